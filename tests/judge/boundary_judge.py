"""Judge the boundaries of stability of a drive with four states: steady sliding must be stable where they say so.

Every threshold comes with the intervals of its parameter in which steady sliding is stable. Each end of an interval is
asked on both sides, a part in 10⁹ away, and the whole range at random: the eigenvalues of Newton's laws there decide.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from judge import linear_judge
from judge.wide_drives import WideDrive
from lsvib.errors import InputError
from lsvib.steady_sliding.threshold_table import threshold_table

_ASIDE = 1e-9  # distance from a boundary, relative to it; thresholds are printed with 12 digits
_PLACES = 4  # values asked at random besides
_DECADES = {"critical_mass": (-4.0, 6.0), "critical_friction": (-4.0, 0.0)}  # values asked [kg], [share of cot λ]
_DAMPING_DECADES = (-10.0, 10.0)  # values asked of a damping, in its unit


def objections(wide: WideDrive, rng: np.random.Generator) -> Iterator[tuple[str, str, str, str]]:
    """Ask every threshold of a drive; yields its name, a verdict (right, wrong, refused), what it says, the truth."""
    own = wide.drive.own_damping
    keys = {"critical_mass": "mass", "critical_friction": "friction_coefficient", f"least_{own}": own}
    try:
        table = threshold_table(dict(wide.drive), wide.model)
    except InputError as error:
        verdict = "right" if linear_judge.carries_no_force(wide) else "refused"
        yield "all", verdict, str(error), "a law of steady sliding"
        return
    for name, key in keys.items():
        yield name, *_judged(wide, name, key, table[name], rng)


def _judged(wide: WideDrive, name: str, key: str, entry: dict[str, Any], rng) -> tuple[str, str, str]:
    """Verdict on one threshold, what it says, and what is true instead."""
    schema = type(wide.drive).model_json_schema()["properties"][key]
    limit = 1 / np.tan(wide.drive.lead_angle) if key == "friction_coefficient" else schema["maximum"]
    intervals = [(x["low"], limit if x["high"] is None else x["high"]) for x in entry["stable_intervals"]]
    said = f"{name} {entry['value']}, stable in {intervals}"
    if not _fits(name, entry, intervals, limit):
        return "wrong", said, "a threshold that is the end of an interval"
    unit = limit if key == "friction_coefficient" else 1.0
    places = [unit * 10**x for x in rng.uniform(*_DECADES.get(name, _DAMPING_DECADES), _PLACES)]
    places += [end * (1 + side * _ASIDE) for pair in intervals for end in pair for side in (-1, 1)]
    ends = sorted({end for pair in intervals for end in pair if 0 < end < limit})
    for place in places:
        near = [end for end in ends if abs(place - end) < 0.5 * _ASIDE * end]
        if not 0 < place < limit * (1 - _ASIDE) or near:
            continue
        told = any(low < place < high for low, high in intervals)
        drive = type(wide.drive).of({**dict(wide.drive), key: float(place)})
        if _stable(wide._replace(drive=drive), entry["stability"] == "neutral") != told:
            return "wrong", said, f"{'un' if told else ''}stable at {place!r}"
    return "right", "", ""


def _fits(name: str, entry: dict[str, Any], intervals: list[tuple[float, float]], limit: float) -> bool:
    """Whether the value is the lowest end of a damping, the highest of a mass or friction, or none with a reason."""
    if entry["value"] is None:
        return bool(entry["reason"]) and (not intervals or intervals[-1][1] == limit)
    return bool(intervals) and entry["value"] == (intervals[0][0] if name.startswith("least") else intervals[-1][1])


def _stable(wide: WideDrive, neutral: bool) -> bool:
    """Whether all motions near steady sliding die away or, with ``neutral``, none of them grows."""
    rates = linear_judge.rates(wide)
    return linear_judge.grows_not(rates) if neutral else linear_judge.stable(rates)
