"""Stability on stiff and extreme cases: the engine judged at the edge of the domain, family by family."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.accuracy.sides import attractor_is_right, long_run
from lsvib.accuracy.sweep_cases import THRESHOLDS, Case, Family, Group, cases
from lsvib.accuracy.sweeps import TOLERANCE, Judge, Outcome, Verdict, judge
from lsvib.datasets.checks import Check
from lsvib.datasets.variables import flags
from lsvib.models.parameters import LeadScrew, ThreadsDrive

_SOURCE = "issue: stability on stiff and extreme cases"
_NUMBERS = {
    "state_error": ("1", "error of the final state, relative to the size of the motion"),
    "time_error": ("1", "largest error of an event time, relative to the duration"),
    "sensitivity": ("1", "change of the final state when the input is moved in its last places"),
    "condition": ("1", "largest condition number of the modal forms"),
}
_LONG = ({"translation_damping": 1e3, "axial_force": 40.0}, {"mass": 15.0, "axial_force": 100.0})


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the sweeps.

    ``settings``: ``seed``; ``counts``, number of cases of each family by name; ``thorough``, how many of them are asked
    of the reference in any case; ``distances`` [1] from the thresholds at which attractors are found; ``periods`` of
    the long runs.
    """
    rows: list[tuple[Case, Outcome]] = []
    for name, count in settings["counts"].items():
        family = Family[name.upper()]
        rng = np.random.default_rng([settings["seed"], family])
        for k, case in enumerate(cases(family, count, rng)):
            rows.append((case, judge(case, rng, thorough=k < settings["thorough"])))
    families = sorted({case.family for case, _ in rows})
    sides = _sides(settings["distances"])
    runs = [long_run(LeadScrew.of(changes), settings["periods"]) for changes in _LONG]
    return xr.Dataset(
        _cases(rows) | _summary(rows, families) | sides | _runs(runs),
        coords={
            "case": ("case", np.arange(len(rows)), {"units": "1", "long_name": "index of the case"}),
            "family": ("family", np.array(families, dtype=np.int8), _flag("what is driven to the edge", Family)),
            "outcome": ("outcome", np.array(Verdict, dtype=np.int8), _flag("verdict", Verdict)),
            "threshold": ("threshold", np.array(list(THRESHOLDS), dtype=np.int8), _flag("threshold of R", Group)),
            "side": ("side", np.array([-1, 1], dtype=np.int8), {
                "units": "1", "long_name": "side of the threshold", "flag_values": np.array([-1, 1], dtype=np.int8),
                "flag_meanings": "smaller_force larger_force"}),
            "distance": ("distance", np.array(settings["distances"], dtype=float),
                         {"units": "1", "long_name": "relative distance from the threshold"}),
            "run": ("run", np.arange(len(runs)), {"units": "1", "long_name": "index of the long run"}),
            "tolerance": ((), TOLERANCE, {"units": "1", "long_name": "relative error that passes"}),
            "periods": ((), settings["periods"], {"units": "1", "long_name": "number of periods of a long run"}),
        },
        attrs={
            "title": "The engine at the edge of the domain",
            "source": "lsvib, exact event-driven motion; judges: Taylor steps, and a reference with 40 digits",
            "references": "doi:10.1007/978-1-4419-1752-2_8; docs/stability.md",
            "worst_cases": json.dumps(_worst(rows, families)),
        },
    )  # fmt: skip


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that no verdict is wrong, that rigid motions are accurate, and the thresholds and long runs."""
    total = dataset.sizes["case"]
    verdict, rigid = dataset.verdict.values, dataset.case_family.values != Family.CONTACT
    wrong, inaccurate = int((verdict == Verdict.WRONG).sum()), verdict == Verdict.INACCURATE
    asked = rigid & (dataset.judge.values == Judge.REFERENCE) & (verdict != Verdict.BEYOND_INPUT)
    worst = float(np.nanmax(np.where(asked, dataset.state_error.values, np.nan)))
    refused = int((verdict == Verdict.REFUSED).sum())
    sides = dataset.attractor_is_right.values
    return [
        Check.holds(
            "No wrong verdict: the engine has the events of an independent computation, in order, in every case",
            _SOURCE,
            f"{wrong} wrong of {total}; {int((verdict == Verdict.BEYOND_INPUT).sum())} decided by digits that the "
            f"input does not have, {int((verdict == Verdict.CORNER).sum())} differ within an instant at a corner, "
            f"{refused} refused in a sentence",
            wrong == 0,
        ),
        Check.holds(
            f"Rigid drive: final states and event times to {TOLERANCE:.0e} in every case",
            _SOURCE,
            f"{int((inaccurate & rigid).sum())} above it; worst error against 40 digits {worst:.1e}",
            not bool((inaccurate & rigid).any()),
        ),
        Check.holds(
            "Attractors on both sides of each threshold of the axial force are those that it promises",
            _SOURCE,
            f"{int(sides.sum())} of {sides.size}, down to {float(dataset.distance.min()):.0e} of the threshold",
            bool(sides.all()),
        ),
        Check.holds(
            "Cycles over many periods: clock to 1e-12, state to 1e-12",
            _SOURCE,
            f"{int(dataset.periods)} periods, {int(dataset.run_events.sum())} events: clock "
            f"{float(dataset.clock_error.max()):.1e}, state {float(dataset.run_state_error.max()):.1e}",
            bool(dataset.clock_error.max() <= 1e-12 and dataset.run_state_error.max() <= 1e-12),
        ),
    ]


def _flag(words: str, kinds) -> dict[str, Any]:
    return {"units": "1", "long_name": words, **flags(kinds)}


def _cases(rows: list[tuple[Case, Outcome]]) -> dict[str, tuple]:
    agrees = [-1 if o.stepper_agrees is None else int(o.stepper_agrees) for _, o in rows]
    damping = [_log(c.drive.contact_damping) if isinstance(c.drive, ThreadsDrive) else np.nan for c, _ in rows]
    # On the edge itself the logarithm is −inf, which is stored as missing.
    level = np.array([case.level for case, _ in rows])
    found = {
        "case_family": (np.array([c.family for c, _ in rows], np.int8), _flag("family of the case", Family)),
        "group": (np.array([c.group for c, _ in rows], np.int8), _flag("edge of the case", Group)),
        "level": (np.where(np.isfinite(level), level, np.nan).astype(np.float32), {
            "units": "1", "long_name": "decimal logarithm of the parameter or of its distance from the edge"}),
        "damping_level": (np.array(damping, np.float32), {
            "units": "1", "long_name": "decimal logarithm of the contact damping in N s/m"}),
        "verdict": (np.array([o.verdict for _, o in rows], np.int8), _flag("verdict on the case", Verdict)),
        "judge": (np.array([o.judge for _, o in rows], np.int8), _flag("who decided", Judge)),
        "events": (np.array([o.events for _, o in rows], np.int32), {"units": "1", "long_name": "number of events"}),
        "stepper_agrees": (np.array(agrees, np.int8), {
            "units": "1", "long_name": "whether the Taylor stepper has the right events",
            "flag_values": np.array([-1, 0, 1], np.int8), "flag_meanings": "not_asked no yes"}),
    }  # fmt: skip
    for name, (units, words) in _NUMBERS.items():
        values = np.array([getattr(o, name) for _, o in rows], np.float32)
        found[name] = (values, {"units": units, "long_name": words})
    return {name: ("case", values, attributes) for name, (values, attributes) in found.items()}


def _log(value: float) -> float:
    return float(np.log10(value)) if value else np.nan


def _summary(rows: list[tuple[Case, Outcome]], families: list[Family]) -> dict[str, tuple]:
    count = np.array([[sum(c.family == f and o.verdict == v for c, o in rows) for v in Verdict] for f in families])
    astray = [sum(c.family == f and o.stepper_agrees is False for c, o in rows) for f in families]
    return {
        "case_count": (("family", "outcome"), count, {"units": "1", "long_name": "number of cases"}),
        "stepper_wrong": ("family", np.array(astray), {
            "units": "1", "long_name": "number of cases in which the Taylor stepper has wrong events"}),
    }  # fmt: skip


def _sides(distances: list[float]) -> dict[str, tuple]:
    right = [[[attractor_is_right(group, side, x) for x in distances] for side in (-1, 1)] for group in THRESHOLDS]
    return {
        "attractor_is_right": (("threshold", "side", "distance"), np.array(right, np.int8), {
            "units": "1", "long_name": "the attractor is the one that the threshold promises",
            "flag_values": np.array([0, 1], np.int8), "flag_meanings": "no yes"})
    }  # fmt: skip


def _runs(runs: list) -> dict[str, tuple]:
    words = {
        "run_events": ("events", "number of events of the long run"),
        "clock_error": ("clock_error", "relative error of the time of the last release from rest"),
        "run_state_error": ("state_error", "relative error of the state at the last release from rest"),
    }
    return {
        name: ("run", [getattr(run, key) for run in runs], {"units": "1", "long_name": text})
        for name, (key, text) in words.items()
    }


def _worst(rows: list[tuple[Case, Outcome]], families: list[Family]) -> dict[str, dict]:
    """The case of the largest error against the reference in each family, so that it can be run again."""
    found = {}
    for family in families:
        asked = [(o.state_error, c) for c, o in rows if c.family == family and o.judge == Judge.REFERENCE]
        asked = [(error, c) for error, c in asked if np.isfinite(error)]
        if asked:
            error, case = max(asked, key=lambda pair: pair[0])
            found[family.name.lower()] = {"state_error": error, "drive": dict(case.drive), "start": list(case.start),
                                          "duration": case.duration}  # fmt: skip
    return found
