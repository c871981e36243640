"""Many drives beside each other: one table of their verdicts, as a page and as JSON."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lsvib.assess import report
from lsvib.assess.report import Html
from lsvib.assess.words import CHANGES, MECHANISMS, change, percent, shown
from lsvib.errors import InputError
from lsvib.files import write_json, write_text

_COLUMNS = (
    "Drive",
    "Verdict",
    "Probability that it vibrates",
    "Nearest cause",
    "Smallest change that alters the verdict",
    "Worst case",
    "Self-locking",
    "Efficiency",
)
_ENDS = {  # of motions without a frequency, by the names of lsvib.assess.words.ATTRACTORS
    "steady sliding": "does not vibrate",
    "rest": "stands still",
    "neutral family": "oscillates, neither growing nor decaying",
    "unbounded": "grows without limit",
    "unresolved": "not known",
    "unknown": "not known beyond its onset",
}


def compare(verdicts: Sequence[Path], page_file: Path, json_file: Path) -> None:
    """Write the comparison of drives from their files ``assessment.json``, the most likely to vibrate first.

    The page links to ``index.html`` in the folder of each file, from the folder that holds these folders. Raises
    ``InputError`` in one sentence if a file is missing or damaged.
    """
    found = [(path.parent.name, _read(path)) for path in verdicts]
    found.sort(key=lambda pair: (-pair[1]["any_mechanism"]["probability"], _lowest(pair[1])[1]["reserve"]))
    rows = [_row(folder, verdict) for folder, verdict in found]
    parts = [
        report.heading("Which drives vibrate?", 1),
        report.paragraph(
            "One row for each data sheet, the most likely to vibrate first. The name leads to the report on the drive."
        ),
        report.table(_COLUMNS, rows),
    ]
    write_text(report.page("Which drives vibrate?", parts), page_file)
    write_json([{"report": f"{folder}/index.html", **_short(verdict)} for folder, verdict in found], json_file)


def _read(path: Path) -> dict[str, Any]:
    try:
        verdict = json.loads(path.read_text(encoding="utf-8"))
        _short(verdict)
    except OSError as error:
        raise InputError(f"Cannot read {path}: {error.strerror}.") from None
    except (ValueError, KeyError, TypeError):
        raise InputError(f"{path} is not a readable assessment; delete it, and run again what makes it.") from None
    return verdict


def _lowest(verdict: dict[str, Any]) -> tuple[str, dict[str, Any]]:
    """The mechanism with the lowest reserve."""
    return min(verdict["mechanisms"].items(), key=lambda pair: pair[1]["reserve"])


def _nearest(verdict: dict[str, Any]) -> tuple[str | None, float | None]:
    """The quantity with the smallest change that makes a drive steady or unsteady, and its factor."""
    margins = verdict["any_mechanism"]["margin"]
    return next(((key, row["factor"]) for key, row in margins.items() if row["factor"] is not None), (None, None))


def _short(verdict: dict[str, Any]) -> dict[str, Any]:
    name, one = _lowest(verdict)
    quantity, factor = _nearest(verdict)
    worst = verdict["worst_case"]
    return {
        "name": verdict["name"],
        "verdict": verdict["verdict"],
        "probability": verdict["any_mechanism"]["probability"],
        "interval": verdict["any_mechanism"]["interval"],
        "nearest_mechanism": name,
        "reserve": one["reserve"],
        "nearest_change": {"quantity": quantity, "factor": factor},
        "worst_case": {key: worst[key] for key in ("attractor", "frequency", "amplitude", "peak_contact_force")},
        "self_locking": verdict["self_locking"],
        "efficiency": verdict["efficiency"],
    }


def _row(folder: str, verdict: dict[str, Any]) -> list[object]:
    short = _short(verdict)
    low, high = short["interval"]
    spread = "" if low == high else report.small(f"95 % sure: {percent(low)} to {percent(high)}")
    worst, nearest = short["worst_case"], short["nearest_change"]
    end = _ENDS.get(worst["attractor"], "vibrates")
    motion = end if worst["frequency"] is None else shown(worst["frequency"], "Hz")
    swing = "" if worst["amplitude"] is None else report.small(f"± {shown(worst['amplitude'], 'm')} at the load")
    moved = "none" if nearest["factor"] is None else f"{CHANGES[nearest['quantity']]} {change(nearest['factor'])}"
    reserve = report.small(f"reserve {short['reserve']:+.2f}")
    link = Html(f'<a href="{report.text(folder)}/index.html">{report.text(short["name"])}</a>')
    return [
        link,
        short["verdict"],
        Html(f"{percent(short['probability'])}{spread}"),
        Html(f"{report.text(MECHANISMS[short['nearest_mechanism']][0])}{reserve}"),
        moved,
        Html(f"{motion}{swing}"),
        "yes" if short["self_locking"] else "no",
        percent(short["efficiency"]["lifting"]),
    ]
