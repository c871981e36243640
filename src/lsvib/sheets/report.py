"""The report: the verdict on a drive in plain words, with pictures and numbers; and many drives in one table.

What is said stands in the templates beside this file.
"""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lsvib.errors import InputError
from lsvib.files import write_json, write_text
from lsvib.sheets import pictures
from lsvib.sheets.assessment import Assessment
from lsvib.sheets.chart import Chart
from lsvib.sheets.fields import Spread
from lsvib.sheets.materials import NUT_MATERIALS
from lsvib.sheets.summary import of_curve, said, templates
from lsvib.sheets.threads import ThreadSize
from lsvib.sheets.words import QUANTITIES, shown
from lsvib.stability.conditions import stability


def _page(template: str, **values: Any) -> str:
    pages = templates(html=True)
    pages.globals |= {"pictures": pictures, "said": said, "of_curve": of_curve, "NUT_MATERIALS": NUT_MATERIALS}
    return pages.get_template(template).render(**values).lstrip()


def report(assessment: Assessment, charts: list[Chart]) -> str:
    """Return the report on an assessment as the text of one HTML page, which needs no other file."""
    sheet = assessment.draw.sheet
    same = assessment.worst is assessment.nominal
    motions = {"At the given values" if same else "At the middle values": assessment.nominal}
    if not same:
        motions["In the worst case within the uncertainties"] = assessment.worst
    return _page(
        "report.html.j2",
        title=f"{sheet.name}: will it vibrate?",
        assessment=assessment,
        sheet=sheet,
        given=sheet.paths(),
        spread=assessment.uncertainty,
        worst=assessment.worst.vibration,
        names=assessment.names,
        changes=[row for row in assessment.changes if row.factor]
        if assessment.verdict == "jerks"
        else [row for row in assessment.margins if row.is_near() and row.value],
        oscillations=_oscillations(assessment) if sheet.motor is not None else [],
        charts=charts,
        motions=motions,
        endangered=bool(assessment.statics.back_drives) or any(row.exceeded for row in assessment.statics.limited),
        entries=[(path, _entry(one)) for path, one in sheet.entries() if one is not None],
    )


def _oscillations(assessment: Assessment) -> list[str]:
    """Frequencies with damping ratios of small oscillations, with the motor's control and without its damping."""
    drive, found = assessment.nominal.there.drive, []
    for gain in (drive.speed_gain, 0.0):
        try:
            roots = stability(drive.replace(speed_gain=gain)).eigenvalues
        except InputError:  # the contact carries no force
            return []
        pairs = sorted((root for root in roots if root.imag > 0), key=abs)
        ratios = ((abs(z), 0.0 - z.real / abs(z)) for z in pairs)
        found.append(", ".join(f"{shown(w / (2 * math.pi), 'Hz')} (ζ = {shown(zeta, '')})" for w, zeta in ratios))
    return found


def _entry(entry: object) -> str:
    if isinstance(entry, Spread):
        kind = "anywhere in the range" if entry.kind == "uniform" else entry.kind
        return entry.text if kind == "value" else f"{entry.text} ({kind})"
    if isinstance(entry, tuple):
        return "; ".join(f"{coefficient:g} at {shown(speed, 'm/s')}" for speed, coefficient in entry)
    if isinstance(entry, ThreadSize):
        return f"lead {shown(entry.lead, 'm')}, pitch diameter {shown(entry.pitch_diameter, 'm')}"
    return str(entry)


def compare(verdicts: Sequence[Path], page_file: Path, json_file: Path) -> None:
    """Write the comparison of drives from their files ``assessment.json``, the most likely to vibrate first.

    The page links to ``index.html`` in the folder of each file, from the folder that holds these folders. Raises
    ``InputError`` in one sentence if a file is missing or damaged.
    """
    found = [{"report": f"{path.parent.name}/index.html", **_short(path)} for path in verdicts]
    found.sort(key=lambda short: (-short["probability"], short["reserve"]))
    names = {about.name: about.words for about in QUANTITIES.values()}
    page = _page("report_comparison.html.j2", title="Which drives vibrate?", drives=found, names=names)
    write_text(page, page_file)
    write_json(found, json_file)


def _short(path: Path) -> dict[str, Any]:
    """What the comparison says of a drive, from its file ``assessment.json``."""
    try:
        verdict = json.loads(path.read_text(encoding="utf-8"))
        name, one = min(verdict["mechanisms"].items(), key=lambda item: item[1]["reserve"])
        margins = verdict["any_mechanism"]["margin"].items()
        nearest = ((key, row["factor"]) for key, row in margins if row["factor"] is not None)
        worst = verdict["worst_case"]
        return {
            "name": verdict["name"],
            "verdict": verdict["verdict"],
            "probability": verdict["any_mechanism"]["probability"],
            "interval": verdict["any_mechanism"]["interval"],
            "nearest_mechanism": name,
            "reserve": one["reserve"],
            "nearest_change": dict(zip(("quantity", "factor"), next(nearest, (None, None)), strict=True)),
            "worst_case": {key: worst[key] for key in ("attractor", "frequency", "amplitude", "peak_contact_force")},
            "self_locking": verdict["self_locking"],
            "efficiency": verdict["efficiency"],
        }
    except OSError as error:
        raise InputError(f"Cannot read {path}: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(f"{path} is not a readable assessment; run again what makes it.") from None
