"""Judge the engine on cases at the edge of the domain: status, events, times, states, and what the input itself allows.

A case passes if the engine reports the events of the reference with 40 digits, in order, and its final state and event
times to 1e-9 of the motion. Where it does not, the reference is asked again with every parameter moved by up to 16
units of its last place, the size below which the engine takes a sum for zero: if one of these inputs leads to what the
engine has, the case is decided by digits that double precision does not have. The energy of a motion under
constant friction must balance, too (:mod:`benchmarks.sweeps.energy_balance`).
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from benchmarks.judge import CORNER, Record, Verdict, distance, lateness, same_but_corners, without_clusters
from benchmarks.sweeps.energy_balance import Balance, balance
from benchmarks.sweeps.families import Case
from benchmarks.sweeps.paths import automaton, engine_path, exact_path, most_events
from lsvib.drives.friction import depends_on_speed
from lsvib.errors import InputError, LsvibError
from lsvib.systems.motion import follow

TOLERANCE = 1e-9  # largest error that is right, relative to the size of each coordinate and to the duration
ENERGY_TOLERANCE = 1e-10  # residual that passes beside that of rounding, relative to the largest energy or work
_ENERGY_PLACES = 4  # Rounding may change the clock and each term by so many last places.
_AT_ONCE = 1e-6  # Events that are closer, relative to the duration, may be the end of infinitely many.
_LAST_PLACES = 16  # The engine takes a sum for zero if it is smaller than so many last places.
_PERTURBED = 4  # inputs moved at random, and as many moved the other way; each costs a run of the reference
_AS_MUCH = 2.0  # factor on what moved inputs change: all places at their worst change about so much more
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


@dataclass
class CaseOutcome:
    """Verdict on a case; errors are relative to the size of the motion, nan where nobody computed them.

    ``sensitivity``: what a change of the input in its last places changes in the reference's final state and times.
    """

    verdict: Verdict
    events: int = 0
    state_error: float = math.nan
    time_error: float = math.nan
    sensitivity: float = math.nan
    condition: float = math.nan
    energy: Balance | None = None
    path: Record | None = field(default=None, repr=False)

    @property
    def error(self) -> float:
        """Largest error of final state and event times [1]; nan where there is none to compare."""
        return float(np.fmax(self.state_error, self.time_error))  # the first is nan if the motion was cut off


def judge(case: Case, rng: np.random.Generator, thorough: bool = False) -> CaseOutcome:
    """Follow a case and compare it with the reference; ``thorough``: ask for the sensitivity in any case."""
    outcome = _judge(case, rng, thorough)
    balanced = outcome.energy
    # A balance that could not be computed (nan) changes no verdict; the dataset counts such cases.
    if balanced and outcome.verdict in _GOOD and balanced.residual > allowed_residual(balanced.rounding):
        outcome.verdict = Verdict.UNBALANCED
    return outcome


def allowed_residual(rounding):
    """Return the largest residual of an energy balance that passes, from its rounding [1]; floats or arrays."""
    return ENERGY_TOLERANCE + _ENERGY_PLACES * rounding


def _judge(case: Case, rng: np.random.Generator, thorough: bool) -> CaseOutcome:
    try:
        model = automaton(case)
        motion = follow(model, case.start, case.duration, max_events=most_events(case.drive))
    except LsvibError:
        return CaseOutcome(Verdict.REFUSED)
    path = engine_path(motion, case)
    outcome = CaseOutcome(Verdict.WRONG, len(path.kinds), condition=model.condition, path=path)
    if not np.isfinite(path.end).all():
        return outcome
    if not depends_on_speed(case.drive):
        outcome.energy = balance(motion, case.drive, case.physics)
    exact = exact_path(case, case.drive, case.start)
    if exact is None:
        return outcome
    if not exact.complete:  # cut off after many events, or where Newton's laws do not say what follows
        path = _until(path, len(exact.kinds))
    if _comparable(path, exact):
        outcome.time_error = lateness(path, exact) / case.duration
        outcome.state_error = distance(path.end, exact) if path.complete else math.nan
        outcome.verdict = Verdict.RIGHT if outcome.error <= TOLERANCE else Verdict.INACCURATE
    elif _same_but_corners(path, exact, case):
        outcome.verdict, outcome.state_error = Verdict.CORNER, distance(path.end, exact)
    if outcome.verdict not in _GOOD or thorough:
        decided, outcome.sensitivity = _weighed(path, exact, case, rng)
        if outcome.verdict not in _GOOD and not decided:
            outcome.verdict = Verdict.BEYOND_INPUT
    return outcome


def _until(path: Record, count: int) -> Record:
    """The first events of a motion, which then is not complete."""
    return replace(path, kinds=path.kinds[:count], times=path.times[:count], complete=False)


def _comparable(path: Record, other: Record) -> bool:
    return path.kinds == other.kinds and path.complete == other.complete


def _gap(path: Record, other: Record, case: Case) -> float:
    """Largest difference of two motions with the same events, relative to the duration and to the motion."""
    late = lateness(path, other) / case.duration
    return max(late, distance(path.end, other)) if path.complete else late


def _same_but_corners(path: Record, other: Record, case: Case) -> bool:
    """Whether two motions end in the same state and have the same events, with events at once as one corner."""
    if not (path.complete and other.complete and distance(path.end, other) <= TOLERANCE):
        return False
    gap = _AT_ONCE * case.duration
    one, two = (without_clusters(x.kinds, x.times, gap) for x in (path, other))
    if not same_but_corners(one, two):
        return False
    begins, starts = (x.times[np.diff(x.times, prepend=-np.inf) > gap] for x in (path, other))
    late = [gap if CORNER in pair else TOLERANCE * case.duration for pair in zip(one, two, strict=True)]
    return bool((np.abs(begins - starts) <= late).all())


def _weighed(path: Record, exact: Record, case: Case, rng: np.random.Generator) -> tuple[bool, float]:
    """Whether the digits of the input decide against the engine, and the sensitivity.

    They do not if an input that differs in its last places leads to the engine's motion: to its events, and as near to
    its times and its end as such inputs are to each other.
    """
    numbers = len(dict(case.drive)) + len(case.start)
    drawn = rng.uniform(-_LAST_PLACES, _LAST_PLACES, (_PERTURBED, numbers))
    moved = [_moved_path(case, places) for places in (*drawn, *-drawn)]
    others = [other for other in moved if other is not None]
    sensitivity = max((_gap(other, exact, case) for other in others if _comparable(other, exact)), default=0.0)
    allowed = max(TOLERANCE, _AS_MUCH * sensitivity)
    like = [other for other in (exact, *others) if _comparable(path, other)]
    found = any(_gap(path, other, case) <= allowed for other in like)
    return not (found or any(_same_but_corners(path, other, case) for other in others)), sensitivity


def _moved_path(case: Case, places: np.ndarray) -> Record | None:
    """The reference's motion with each parameter and each coordinate of the start moved by so many last places."""
    parts = iter((1 + places * _EPS).tolist())
    values = {key: value * (next(parts) if key != "stribeck_exponent" else 1) for key, value in case.drive}
    # On θ′ = 0 to the last digit it has to stay: a motion that starts there is one that has just stopped.
    start = [value * next(parts) for value in case.start]
    if case.start[1] == -case.drive.input_speed:
        start[1] = -values["input_speed"]
    try:
        return exact_path(case, type(case.drive).model_construct(**values), tuple(start))
    except InputError:  # the moved input is outside the allowed ranges
        return None
