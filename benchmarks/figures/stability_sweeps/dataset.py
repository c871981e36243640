"""Stability on stiff and extreme cases: the engine judged at the edge of the domain, family by family."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from benchmarks.record import Verdict
from benchmarks.sweeps.case_judge import (
    ENERGY_TOLERANCE,
    TOLERANCE,
    VERDICTS,
    CaseOutcome,
    allowed_residual,
    judge,
)
from benchmarks.sweeps.cases import cases
from benchmarks.sweeps.families import Case, CaseFamily
from lsvib.datasets.attributes import flagged, variable
from lsvib.datasets.checks import Check

_SOURCE = "docs/validation.md"
_NUMBERS = {
    "state_error": ("1", "error of the final state, relative to the size of the motion"),
    "time_error": ("1", "largest error of an event time, relative to the duration"),
    "sensitivity": ("1", "change of the final state when the input is moved in its last places"),
    "condition": ("1", "largest condition number of the modal forms"),
    "energy_residual": ("1", "residual of the energy balance, relative to the largest energy or work in it"),
    "energy_rounding": ("1", "residual of the energy balance that rounding may make"),
}
_WORDS = {
    "level": "decimal logarithm of the parameter or of its distance from the edge",
    "damping_level": "decimal logarithm of the contact damping in N s/m",
    "energy_tolerance": "residual of the energy balance that passes, beyond rounding",
}
_WITH_FOUR_STATES = (CaseFamily.CONTACT, CaseFamily.SUPPORT, CaseFamily.NUT)
# Of the size or the duration: a speed that is zero to rounding ends a little early, see docs/validation.md.
_TOLERANCE_WITH_FOUR_STATES = 1e-8
_NOT_PASSED = 1e-3  # share of the cases that need not pass, without a wrong one among them,
_FEW = 3  # or this number, if that is more
_BALANCED = 0.99  # share of the motions whose energy must be balanced


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the sweeps; ``settings``: see ``Settings``."""
    rows: list[tuple[Case, CaseOutcome]] = []
    for name, count in settings["counts"].items():
        family = CaseFamily[name.upper()]
        rng = np.random.default_rng([settings["seed"], family])
        for k, case in enumerate(cases(family, count, rng)):
            outcome = judge(case, rng, thorough=k < settings["thorough"])
            outcome.path = None  # of no further use, and most of the memory
            rows.append((case, outcome))
    families = sorted({case.family for case, _ in rows})
    return xr.Dataset(
        _cases(rows) | _summary(rows, families),
        coords={
            "case": variable("case", np.arange(len(rows)), "1", "index of the case"),
            "edge_family": flagged("edge_family", families, "what is driven to the edge", CaseFamily),
            "outcome": flagged("outcome", VERDICTS, "verdict", VERDICTS),
            "passing_error": variable((), TOLERANCE, "1", "relative error that passes"),
            "energy_tolerance": variable((), ENERGY_TOLERANCE, "1", _WORDS["energy_tolerance"]),
        },
        attrs={
            "title": "The engine at the edge of the domain",
            "source": "lsvib, exact event-driven motion; judge: a reference with 40 digits",
            "references": "doi:10.1007/978-1-4419-1752-2_8; docs/validation.md",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that no verdict is wrong and hardly one but passed, accuracy and energy."""
    total = dataset.sizes["case"]
    verdict, rigid = dataset.case_verdict.values, ~np.isin(dataset.case_family.values, _WITH_FOUR_STATES)
    inaccurate = verdict == Verdict.INACCURATE
    count = {kind: int((verdict == kind).sum()) for kind in VERDICTS}
    failed = total - count[Verdict.RIGHT] - count[Verdict.CORNER]
    worst = float(np.nanmax(dataset.state_error.values[rigid & (verdict != Verdict.BEYOND_INPUT)]))
    others = ~rigid & (verdict != Verdict.BEYOND_INPUT)
    errors = np.fmax(dataset.state_error.values, dataset.time_error.values)[others]
    return [
        Check.holds(
            "No wrong verdict: the engine has the events of an independent computation, in order, in every case",
            _SOURCE,
            f"{count[Verdict.WRONG]} wrong of {total}",
            count[Verdict.WRONG] == 0,
        ),
        Check.holds(
            f"At most one case in {1 / _NOT_PASSED:g}, or {_FEW} if that is more, does not pass",
            _SOURCE,
            f"{failed} of {total} do not: {count[Verdict.BEYOND_INPUT]} decided by digits beyond those of the input, "
            f"{count[Verdict.REFUSED]} refused in a sentence, {count[Verdict.INACCURATE]} inaccurate, "
            f"{count[Verdict.UNBALANCED]} unbalanced; in {count[Verdict.CORNER]} others events swap at a corner",
            failed <= max(_FEW, _NOT_PASSED * total),
        ),
        Check.holds(
            f"Rigid drive: final states and event times to {TOLERANCE:.0e} in every case",
            _SOURCE,
            f"{int((inaccurate & rigid).sum())} above it; worst error against 40 digits {worst:.1e}",
            not bool((inaccurate & rigid).any()),
        ),
        Check.holds(
            f"Drives with four states: final states and event times to {_TOLERANCE_WITH_FOUR_STATES:.0e} in every case "
            "that its input decides",
            _SOURCE,
            f"worst error {errors.max(initial=0.0, where=np.isfinite(errors)):.1e} of {errors.size} cases, in "
            f"{int(np.isnan(errors).sum())} unknown",
            bool(errors.size and (errors <= _TOLERANCE_WITH_FOUR_STATES).all()),
        ),
        _energy_check(dataset),
    ]


def _energy_check(dataset: xr.Dataset) -> Check:
    residual, rounding = dataset.energy_residual.values, dataset.energy_rounding.values
    tolerance = float(dataset.energy_tolerance)
    drawn = np.isfinite(residual)
    astray = int((residual[drawn] > allowed_residual(rounding[drawn])).sum())
    sharp = drawn & (rounding <= tolerance)
    return Check.holds(
        f"Energy balances in every motion: supply, storage, friction, dampers and seizures, to {tolerance:.0e} of the "
        "largest of them and what rounding makes of it",
        _SOURCE,
        f"{astray} of {int(drawn.sum())} do not, {int((~drawn).sum())} not drawn; where rounding makes less than "
        f"{tolerance:.0e}, in {int(sharp.sum())}, the largest residual is {float(residual[sharp].max()):.1e}",
        astray == 0 and bool(drawn[dataset.case_verdict.values != Verdict.REFUSED].mean() > _BALANCED),
    )


def _cases(rows: list[tuple[Case, CaseOutcome]]) -> dict[str, tuple]:
    damping = [_log(getattr(c.drive, "contact_damping", 0.0)) for c, _ in rows]
    # On the edge itself the logarithm is −inf, which is stored as missing.
    level = np.array([case.level for case, _ in rows])
    return {
        "case_family": flagged("case", [c.family for c, _ in rows], "family of the case", CaseFamily),
        "level": variable("case", np.where(np.isfinite(level), level, np.nan).astype(np.float32), "1", _WORDS["level"]),
        "damping_level": variable("case", np.array(damping, np.float32), "1", _WORDS["damping_level"]),
        "case_verdict": flagged("case", [o.verdict for _, o in rows], "verdict on the case", VERDICTS),
        "events": variable("case", np.array([o.events for _, o in rows], np.int32), "1", "number of events"),
        **{
            name: variable("case", np.array([_number(o, name) for _, o in rows], np.float32), *about)
            for name, about in _NUMBERS.items()
        },
    }


def _number(outcome: CaseOutcome, name: str) -> float:
    if not name.startswith("energy_"):
        return getattr(outcome, name)
    return np.nan if outcome.energy is None else getattr(outcome.energy, name.removeprefix("energy_"))


def _log(value: float) -> float:
    return float(np.log10(value)) if value else np.nan


def _summary(rows: list[tuple[Case, CaseOutcome]], families: list[CaseFamily]) -> dict[str, tuple]:
    count = np.array([[sum(c.family == f and o.verdict == v for c, o in rows) for v in VERDICTS] for f in families])
    return {"case_count": variable(("edge_family", "outcome"), count, "1", "number of cases")}
