"""What is said of a drive: a short answer, and a report with pictures and numbers; and many drives in one table.

What is said stands in the templates beside this file.
"""

import json
import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from jinja2 import Environment

from lsvib.drives import friction
from lsvib.drives.pairings import PAIRINGS
from lsvib.errors import InputError
from lsvib.files import write_json, write_text
from lsvib.sheets import words
from lsvib.sheets.assessment import ZERO, Assessment, modes
from lsvib.sheets.catalogue import STEPS, drops
from lsvib.sheets.draw import Draw
from lsvib.sheets.fields import Spread
from lsvib.sheets.formulas import FRICTION, sliding_speed
from lsvib.sheets.from_rest import BEYOND, Chart
from lsvib.sheets.motor import LIMITED
from lsvib.sheets.move import SETTLED
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import Statics, statics
from lsvib.sheets.threads import NUT_MATERIALS, ThreadSize
from lsvib.sheets.words import shown

EFFORTS = {"lifting": "against the load", "lowering": "with the load", "braking": "to brake when the load drives it"}
"""What torques are for, the most demanding first."""
_OF_VIBRATION = ("probability", "interval", "nearest_mechanism", "reserve", "nearest_change", "worst_case")
POOR = 0.1  # of a coefficient: a law that is further off says something else than its curve


@cache
def _templates(html: bool) -> Environment:
    """What renders the templates, with the words that they use."""
    found = words.environment(html)
    found.globals |= vars(words) | {"EFFORTS": EFFORTS, "BEYOND": BEYOND, "POOR": POOR, "drops": drops, "inf": math.inf}
    found.globals |= {"said": said, "entry_text": entry_text, "NUT_MATERIALS": NUT_MATERIALS}
    found.globals |= {"LIMITED": LIMITED, "SETTLED": SETTLED, "STEPS": STEPS, "ZERO": ZERO, "PAIRINGS": PAIRINGS}
    return found


def _page(template: str, **values: Any) -> str:
    return _templates(html=True).get_template(template).render(**values).lstrip()


def said(name: str, *about: Any) -> str:
    """Return sentences by their name in the template ``summary.j2``, without line breaks."""
    sentences = _templates(html=False).get_template("summary.j2").module
    return " ".join(str(getattr(sentences, name)(*about)).split())


def brief(assessment: Assessment) -> list[str]:
    """Return the short answer for the shell, a sentence or two to a line: verdict, statics, limits, three changes."""
    started = assessment.from_rest
    known = started.jerks is not None if started.unstable else 0 < (started.even_speed or 0.0) < math.inf
    told = assessment.vibration not in ("vibrates", "steady without reserve") or known
    first = f"{said('verdict', assessment)} {said('from_rest', assessment.from_rest) if told else ''}".strip()
    advised = ("changes", "purchases") if assessment.vibration in ("vibrates", "jerks") else ()
    changes = [said(name, assessment) for name in ("stepper", *advised)]
    own = said("nut", assessment.draw.sheet), said("curve", of_curve(assessment.draw))
    more = said("move", assessment.draw), said("ripple", assessment), *own
    sure = said("sure", assessment)
    return [line for line in (first, sure, *of_statics(assessment.statics), *more, *changes) if line]


def of_statics(found: Statics) -> list[str]:
    """Return what statics say: whether the load is held, torques, efficiency, the motor, limits that are exceeded."""
    return [line for name in ("holding", "effort", "guesses", "motor", "limits") if (line := said(name, found))]


def of_curve(draw: Draw) -> dict[str, Any] | None:
    """Return the ``law`` of a curve of friction, how far it is ``off`` [1] ``at`` most, and the sliding speeds [m/s].

    Those are the ends of the ``curve`` and of the operating ``window``.
    """
    given = draw.sheet.friction
    if not given.curve:
        return None
    law = {name: draw.values[name] for name in (*FRICTION, "stribeck_speed") if name in draw.values}
    law["stribeck_exponent"], (speeds, coefficients) = given.stribeck_exponent, np.array(given.curve).T
    off = np.abs(friction.unbounded(SimpleNamespace(**law), speeds)[0] / coefficients - 1)
    used = [sliding_speed(draw.values[f"speed_{end}"], draw.pitch_radius, draw.lead_angle) for end in ("low", "high")]
    ends = {"curve": speeds[[0, -1]].tolist(), "window": [float(speed) for speed in used]}
    return {"law": law, "off": float(off.max()), "at": float(speeds[off.argmax()]), **ends}


def size_report(sheet: Sheet, result: dict[str, Any], solved: str = "") -> str:
    """Return the report on a sheet of statics, of which the JSON says ``result``; ``solved`` as of :func:`report`."""
    title, curve = f"{sheet.name}: torque and limits", said("curve", result["friction_curve"])
    found = {"assessment": None, "sheet": sheet, "statics": statics(sheet), "draw": Draw.of(sheet)}
    return _page("report.html.j2", title=title, curve=curve, solved=solved, sentence=result["brief"][-1], **found)


def report(assessment: Assessment, charts: list[Chart], solved: str = "") -> str:
    """Return the report on an assessment as the text of one HTML page, which needs no other file.

    ``solved``: a sentence on the entry that was solved for.
    """
    from lsvib.sheets import pictures

    sheet = assessment.draw.sheet
    nominal, worst = assessment.nominal, assessment.worst
    motions = {"At the middle values": nominal, "In the worst case within the uncertainties": worst}
    return _page(
        "report.html.j2",
        title=f"{sheet.name}: will it vibrate?",
        assessment=assessment,
        statics=assessment.statics,
        solved=solved,
        sentence=said("verdict", assessment),
        curve=said("curve", of_curve(assessment.draw)),
        sheet=sheet,
        spread=assessment.uncertainty,
        names=assessment.names,
        changes=[row for row in assessment.changes if row.factor]
        if assessment.vibration == "jerks"
        else [row for row in assessment.margins if row.is_near() and row.value],
        uncontrolled=modes(replace(nominal.there, draw=nominal.there.draw.changed(speed_gain=0.0))),
        charts=charts,
        pictures=pictures,
        motions={"At the given values": nominal} if worst is nominal else motions,
    )


def entry_text(path: str, entry: object) -> str:
    """Return what a sheet says of an entry, by its name."""
    if isinstance(entry, Spread):
        kind = "anywhere in the range" if entry.kind == "uniform" else entry.kind
        return entry.text if kind == "value" else f"{entry.text} ({kind})"
    if path == "motor.torque_curve" and isinstance(entry, tuple):
        return "; ".join(f"{shown(torque, 'N m')} at {shown(speed, 'rad/s')}" for speed, torque in entry)
    if isinstance(entry, tuple):
        return "; ".join(f"{coefficient:g} at {shown(speed, 'm/s')}" for speed, coefficient in entry)
    if isinstance(entry, ThreadSize):
        return f"lead {shown(entry.lead, 'm')}, pitch diameter {shown(entry.pitch_diameter, 'm')}"
    return {True: "yes", False: "no"}[entry] if isinstance(entry, bool) else str(entry)


def compare(verdicts: Sequence[Path], page_file: Path, json_file: Path) -> None:
    """Write the comparison of drives from their files ``assessment.json``, the most likely to vibrate first.

    The page links to ``index.html`` in the folder of each file, from the folder that holds these folders. Raises
    ``InputError`` in one sentence if a file is missing or damaged.
    """
    found = [{"report": f"{path.parent.name}/index.html", **_short(path)} for path in verdicts]
    drives, sizes = ([one for one in found if (one["vibration"] is None) == still] for still in (False, True))
    found = sorted(drives, key=lambda one: (-one["probability"], one["reserve"])) + sizes
    names = {about.name: about.words for about in words.QUANTITIES.values()}
    page = _page("report_comparison.html.j2", title="Which drives vibrate?", drives=found, names=names)
    write_text(page, page_file)
    write_json(found, json_file)


def _short(path: Path) -> dict[str, Any]:
    """What the comparison says of a drive, from its file ``assessment.json``."""
    try:
        verdict = json.loads(path.read_text(encoding="utf-8"))
        rows = {key: row for key, row in verdict["statics"].items() if key != "back_drives"}
        about = {key: verdict[key] for key in ("name", "verdict", "vibration", "self_locking", "efficiency")} | {
            "torque": rows.get("lifting_torque", {"worst": None})["worst"],
            "exceeded": [key for key, row in rows.items() if row["exceeded"] and key != "holding_friction"],
        }
        if verdict["vibration"] is None:
            return about | dict.fromkeys(_OF_VIBRATION)
        name, one = min(verdict["mechanisms"].items(), key=lambda item: item[1]["reserve"])
        margins = verdict["any_mechanism"]["margin"].items()
        nearest = ((key, row["factor"]) for key, row in margins if row["factor"] is not None)
        worst = verdict["worst_case"]
        return about | {
            "probability": verdict["any_mechanism"]["probability"],
            "interval": verdict["any_mechanism"]["interval"],
            "nearest_mechanism": name,
            "reserve": one["reserve"],
            "nearest_change": dict(zip(("quantity", "factor"), next(nearest, (None, None)), strict=True)),
            "worst_case": {key: worst[key] for key in ("attractor", "frequency", "amplitude", "peak_contact_force")},
        }
    except OSError as error:
        raise InputError(f"Cannot read {path}: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(f"{path} is not a readable assessment; make it again.") from None
