"""Judge the engine on cases at the edge of the domain: status, events, times, states, and what the input itself allows.

A case passes if the engine reports the events of an independent computation, in order, and its final state and event
times to 1e-9 of the motion. The first judge of a rigid drive is :mod:`benchmarks.sweeps.taylor`; where it
disagrees, or the drive is too stiff for it, the reference with 40 digits decides (always, for the other models). Where
the engine disagrees with the reference as well, the reference is asked again with every parameter moved by up to 16
units of its last place, the size below which the engine takes a sum for zero: if one of these inputs leads to all that
the engine has, the case is decided by digits that double precision does not have. The energy of the motion must
balance, too (:mod:`benchmarks.sweeps.energy_balance`).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from benchmarks.record import Record, Verdict, distance
from benchmarks.sweeps.energy_balance import Balance, balance
from benchmarks.sweeps.families import Case
from benchmarks.sweeps.paths import (
    CORNER,
    MOST_EVENTS,
    automaton,
    engine_path,
    exact_path,
    is_rigid,
    same_but_corners,
    stepper_path,
    without_clusters,
)
from lsvib.drives.parameters import DriveParameters
from lsvib.engine.motion import follow
from lsvib.errors import InputError, LsvibError

TOLERANCE = 1e-9  # largest error that is right, relative to the size of each coordinate and to the duration
ENERGY_TOLERANCE = 1e-10  # residual that passes beside that of rounding, relative to the largest energy or work
ENERGY_PLACES = 4  # Rounding may change the clock and each term by so many last places.
_AT_ONCE = 1e-6  # Events that are closer, relative to the duration, may be the end of infinitely many.
LAST_PLACES = 16  # The engine takes a sum for zero if it is smaller than so many last places.
_PERTURBED = 4  # inputs moved at random, and as many moved the other way; each costs a run of the reference
# Most inputs that are tried for a wrong answer. Several digits may have to be right at once: what leads to most of the
# engine's events is moved on, in about a third of its numbers.
_CLIMBS = 40
_REDRAWN = 0.3
# Factor on how far the motions of moved inputs are apart: all of fourteen places at their worst lead 1.7 times as far
# out of those of four moves and their opposites as these are apart, in the mean.
_AS_MUCH = 2.0
_EPS = float(np.finfo(float).eps)


# The verdicts that a case may get.
VERDICTS = (
    Verdict.RIGHT,
    Verdict.REFUSED,
    Verdict.BEYOND_INPUT,
    Verdict.CORNER,
    Verdict.INACCURATE,
    Verdict.WRONG,
    Verdict.UNBALANCED,
)
_GOOD = (Verdict.RIGHT, Verdict.CORNER)


class Judge(IntEnum):
    """Which of the judges decided."""

    NONE = 0
    STEPPER = 1
    REFERENCE = 2


@dataclass
class CaseOutcome:
    """Verdict on a case; errors are relative to the size of the motion, nan where nobody computed them.

    ``sensitivity``: what a change of the input in its last places changes in the reference's final state and times.
    ``stepper_agrees``: whether the stepper had the events of the reference (None: it was not asked).
    """

    verdict: Verdict
    judge: Judge
    events: int = 0
    state_error: float = math.nan
    time_error: float = math.nan
    sensitivity: float = math.nan
    condition: float = math.nan
    stepper_agrees: bool | None = None
    energy: Balance | None = None
    path: Record | None = field(default=None, repr=False)


Truth = Callable[[Case, DriveParameters, tuple[float, ...]], Record | None]


def judge(
    case: Case,
    rng: np.random.Generator,
    thorough: bool = False,
    by_reference: bool = False,
    truth: Truth = exact_path,
) -> CaseOutcome:
    """Follow a case and compare it with what a judge finds.

    ``by_reference``: ask the reference even where the stepper agrees; ``thorough``: ask it for the sensitivity, too;
    ``truth``: the function that stands for the reference, called as :func:`benchmarks.sweeps.paths.exact_path` is.
    """
    outcome = _judge(case, rng, thorough, by_reference, truth)
    balanced = outcome.energy
    # A balance that could not be computed (nan) changes no verdict; the dataset counts such cases.
    if balanced and outcome.verdict in _GOOD and balanced.residual > allowed_residual(balanced.rounding):
        outcome.verdict = Verdict.UNBALANCED
    return outcome


def allowed_residual(rounding):
    """Return the largest residual of an energy balance that passes, from its rounding [1]; floats or arrays."""
    return ENERGY_TOLERANCE + ENERGY_PLACES * rounding


def _judge(case: Case, rng: np.random.Generator, thorough: bool, by_reference: bool, truth: Truth) -> CaseOutcome:
    try:
        model = automaton(case)
        motion = follow(model, case.start, case.duration, max_events=MOST_EVENTS)
    except LsvibError:
        return CaseOutcome(Verdict.REFUSED, Judge.NONE)
    path = engine_path(motion, case)
    outcome = CaseOutcome(Verdict.WRONG, Judge.REFERENCE, len(path.kinds), condition=model.condition, path=path)
    if not np.isfinite(path.end).all():
        return outcome
    outcome.energy = balance(motion, case.drive, case.physics)
    quick = stepper_path(case, path.size) if is_rigid(case) else None
    if quick is not None:
        outcome.stepper_agrees = compare(outcome, path, quick, case) is Verdict.RIGHT
        if outcome.stepper_agrees and not (thorough or by_reference):
            outcome.verdict, outcome.judge = Verdict.RIGHT, Judge.STEPPER
            return outcome
    exact = truth(case, case.drive, case.start)
    if exact is None:
        return outcome
    if quick is not None:
        outcome.stepper_agrees = quick.kinds == exact.kinds or agree_but_corners(quick, exact, case)
    outcome.verdict = compare(outcome, path, exact, case)
    if outcome.verdict is Verdict.WRONG and agree_but_corners(path, exact, case):
        outcome.verdict = Verdict.CORNER
        outcome.state_error = distance(path.end, exact)
    good = outcome.verdict in _GOOD
    if not good or thorough:
        excused, outcome.sensitivity = weigh(path, exact, case, rng, truth, _PERTURBED if good else _CLIMBS)
        if excused and not good:
            outcome.verdict = Verdict.BEYOND_INPUT
    return outcome


def compare(outcome: CaseOutcome, path: Record, other: Record, case: Case) -> Verdict:
    """Write the errors of a path against another one to ``outcome`` and return the verdict on it."""
    outcome.state_error = outcome.time_error = math.nan
    if path.kinds != other.kinds or path.complete != other.complete:
        return Verdict.WRONG
    late = np.abs(path.times - other.times)
    outcome.time_error = float(np.max(late, initial=0.0)) / case.duration
    if path.complete:
        outcome.state_error = distance(path.end, other)
    return Verdict.INACCURATE if max(outcome.time_error, outcome.state_error) > TOLERANCE else Verdict.RIGHT


def agree_but_corners(path: Record, other: Record, case: Case) -> bool:
    """Whether two motions agree in the final state and, with simultaneous events counted as one, in their events."""
    return same_end(path, other) and same_corners(path, other, case, None)


def same_corners(path: Record, other: Record, case: Case, count: int | None) -> bool:
    """Whether the first events of two motions agree, with events at once as one corner, told when it begins."""
    gap = _AT_ONCE * case.duration
    one, two = (without_clusters(x.kinds, x.times, gap)[:count] for x in (path, other))
    if not same_but_corners(one, two):
        return False
    begins, starts = (x.times[np.diff(x.times, prepend=-np.inf) > gap][:count] for x in (path, other))
    late = [gap if CORNER in pair else TOLERANCE * case.duration for pair in zip(one, two, strict=True)]
    return bool((np.abs(begins - starts) <= late).all())


def same_end(path: Record, other: Record) -> bool:
    """Whether two motions end in the same state, whatever their events."""
    return path.complete and other.complete and distance(path.end, other) <= TOLERANCE


def weigh(
    path: Record, exact: Record, case: Case, rng: np.random.Generator, truth: Truth, most: int = _CLIMBS
) -> tuple[bool, float]:
    """Move the input in its last places, at ``most`` so many times, and ask the reference again.

    Returns whether such inputs lead to what the engine has, from the first event to the last, and how far they change
    the reference's final state and times where they leave its events as they are.
    """
    drawn = [_places(case, rng) for _ in range(_PERTURBED)]
    drawn += [-places for places in drawn]
    like, cornered = [exact] if exact.kinds == path.kinds else [], False
    tried: list[tuple[int, np.ndarray]] = []
    moves, sensitivity = rng.spawn(1)[0], 0.0
    for k in range(most):
        # Four moves may all put a start that is on a guard to one side of it; their opposites do not.
        if (cornered and k >= _PERTURBED) or (len(like) > _PERTURBED and k >= len(drawn)):
            break
        places = drawn[k] if k < len(drawn) else _near(tried or [(0, drawn[0])], moves)
        try:
            other = truth(case, *_moved(case, places))
        except InputError:  # the moved input is outside the allowed ranges
            continue
        if other is None:
            continue
        tried.append((_common(path.kinds, other.kinds), places))
        if other.kinds == path.kinds and other.complete == path.complete:
            like.append(other)
        else:
            cornered = cornered or agree_but_corners(path, other, case)
        if exact.complete == other.complete and exact.kinds == other.kinds:
            moved = float(np.abs(exact.times - other.times).max(initial=0.0)) / case.duration
            moved = max(moved, distance(other.end, exact)) if exact.complete else moved
            sensitivity = max(sensitivity, moved)
    return cornered or _among(path, like, case), sensitivity


def _near(tried: list[tuple[int, np.ndarray]], rng: np.random.Generator) -> np.ndarray:
    """Draw a part of the places anew of the input that has led to most of the engine's events."""
    best = max(tried, key=lambda one: one[0])[1]
    return np.where(rng.random(best.size) < _REDRAWN, rng.uniform(-LAST_PLACES, LAST_PLACES, best.size), best)


def _among(path: Record, like: list[Record], case: Case) -> bool:
    """Whether a motion lies among others with its events: as far from one of them at most as they from each other.

    Each time and each coordinate of the final state is asked for, so that a late event is not excused by another one.
    """
    if not like:
        return False
    here, there = path.times / case.duration, np.array([x.times for x in like]) / case.duration
    if path.complete:
        sizes = np.where(like[0].size > 0, like[0].size, 1.0)
        here, there = np.append(here, path.end / sizes), np.hstack([there, [x.end / sizes for x in like]])
    apart = there.max(axis=0) - there.min(axis=0)
    return bool((np.abs(there - here).min(axis=0) <= np.maximum(TOLERANCE, _AS_MUCH * apart)).all())


def _common(left: list[str], right: list[str]) -> int:
    """Number of leading events that two motions share; one more than all if they are the same."""
    if left == right:
        return len(left) + 1
    return next((k for k, pair in enumerate(zip(left, right, strict=False)) if pair[0] != pair[1]),
                min(len(left), len(right)))  # fmt: skip


def _places(case: Case, rng: np.random.Generator) -> np.ndarray:
    """By how many last places each parameter and each coordinate of the start is moved."""
    return np.array([rng.uniform(-LAST_PLACES, LAST_PLACES) for _ in (*case.drive, *case.start)])


def _moved(case: Case, places: np.ndarray) -> tuple[DriveParameters, tuple[float, ...]]:
    parts = iter((1 + places * _EPS).tolist())
    values = {key: value * next(parts) for key, value in case.drive}
    # On θ′ = 0 to the last digit it has to stay: a motion that starts there is one that has just stopped.
    start = [value * next(parts) for value in case.start]
    if case.start[1] == -case.drive.input_speed:
        start[1] = -values["input_speed"]
    return type(case.drive).model_construct(**values), tuple(start)
