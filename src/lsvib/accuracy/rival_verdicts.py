"""Other methods on the cases of the sweeps: do they show the motion that really takes place?

The truth is the engine's own motion, and only in cases in which an independent computation has confirmed it
(:func:`lsvib.accuracy.sweeps.judge`: PASSED). A method is told the sizes of the motion, for its absolute tolerances,
and it is held to no more than it was asked for: an error of ``GENEROSITY`` times its tolerance is right, events within
that part of the duration may come in any order, and next to the start and the end they may be missing. Effort is
counted in evaluations of the field, not in seconds, so that a verdict is the same on every machine.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from lsvib.accuracy import sweeps
from lsvib.accuracy.catalogue import Family, find_method
from lsvib.accuracy.hybrid import Clock, GaveUp, Hybrid
from lsvib.accuracy.result import Run
from lsvib.accuracy.scenes import Scene
from lsvib.accuracy.sweep_cases import Case
from lsvib.models.coefficients import coefficients
from lsvib.models.model import MODELS, find_model
from lsvib.models.motion import follow

GENEROSITY = 1000.0  # times the tolerance that a method was asked for is still right
MOST_EVALUATIONS = 50_000  # of the field, by a general solver
MOST_STEPS = 1_000_000  # of a fixed-step method
_STEPS_PER_TURN = 1000  # of the fastest oscillation that the motion has
_FEWEST_STEPS = 100
_CAP = 50  # steps per turn where a solver is repeated with smaller steps
_SPARE_EVENTS = 50
_STIFF = "too stiff"


class Verdict(IntEnum):
    """What became of a method on a case."""

    RIGHT = 0
    INACCURATE = 1  # the right events, an error above what it was asked for
    OTHER_EVENTS = 2  # events missed or invented, but the motion ends where it should
    OTHER_MOTION = 3  # other events, and another end
    GAVE_UP = 4  # too much effort, a step that cannot be made, an endless chain of events, overflow


@dataclass(frozen=True)
class _Posed(Scene):
    """A case as a scene; ``sizes`` (n) are those of its motion."""

    sizes: tuple[float, ...] = ()

    @property
    def scales(self) -> np.ndarray:
        """Sizes of the coordinates (n): of this motion, but of u and w not above what steady sliding at Ω would reach.

        A motion that starts far away is not to be lost in the tolerance for its start. 1 where a coordinate stays zero.
        """
        speed = abs(self.drive.input_speed)
        natural = np.full(len(self.sizes), np.inf)
        natural[:2] = speed * self.turn / (2 * math.pi), speed
        sizes = np.array(self.sizes)
        return np.where(sizes > 0, np.minimum(sizes, natural), 1.0)

    @property
    def turn(self) -> float:
        """Undamped oscillation [s] of the screw under the law of friction that helps it."""
        return 2 * math.pi * math.sqrt(float(coefficients(self.drive).gamma[-1]) / self.drive.coupling_stiffness)

    @property
    def window(self) -> float:
        """Infinite: no steady amplitude is asked for."""
        return math.inf


class Question(NamedTuple):
    """A case that the engine passed, its motion, and what limits the step of a method.

    ``turn`` [s]: shortest oscillation of the modes that the motion visits; ``decay`` [1/s]: their fastest rate of
    decay; ``stiffness`` [1]: that rate, integrated over the motion.
    """

    case: Case
    path: sweeps.Path
    hybrid: Hybrid
    turn: float
    decay: float
    stiffness: float

    @property
    def scale(self) -> float:
        """Time [s] in which the motion turns: its shortest oscillation, or all of it."""
        return min(self.turn, self.case.duration)

    @property
    def shortest_stay(self) -> float:
        """Shortest time between two events in units of ``scale`` [1]; infinite if there are fewer."""
        return float(np.diff(self.path.times).min(initial=math.inf)) / self.scale


class Answer(NamedTuple):
    """Verdict; largest error of final state and times, relative to the motion, nan unless the events are right; why it
    gave up.
    """

    verdict: Verdict
    error: float = math.nan
    failure: str = ""


class Effort(Clock):
    """A limit on the evaluations of a run, the same on every machine."""

    def start(self) -> None:
        """Start counting."""
        self.calls = 0

    def check(self) -> None:
        """Count one; ``GaveUp`` if it is one too many."""
        self.calls += 1
        if self.calls > self.limit:
            raise GaveUp(f"over {self.limit:g} evaluations")


def pose(case: Case, rng: np.random.Generator) -> tuple[sweeps.Verdict, Question | None]:
    """Judge the engine on a case; if it passed, return the question for others as well.

    A motion with too many events is cut before the last of them; where all of those are at the very start, there is no
    question.
    """
    outcome = sweeps.judge(case, rng)
    if outcome.verdict is sweeps.Verdict.PASSED and not outcome.path.complete:
        if outcome.path.times.size < 2:
            return outcome.verdict, None
        case = case._replace(duration=float(outcome.path.times[-2:].mean()))
        outcome = sweeps.judge(case, rng)
    path = outcome.path
    if outcome.verdict is not sweeps.Verdict.PASSED or not path.complete:
        return outcome.verdict, None
    kind = next(name for name in MODELS if find_model(name).drive is type(case.drive))
    scene = _Posed(
        "case", "a case", kind, case.drive, case.start, case.duration, case.duration / _CAP, sizes=tuple(path.size)
    )
    hybrid = Hybrid(scene)
    question = Question(case, path, hybrid, *_rates(hybrid))
    hybrid.scene = replace(scene, step_cap=question.scale / _CAP)
    return outcome.verdict, question


def _rates(hybrid: Hybrid) -> tuple[float, float, float]:
    """Shortest oscillation [s], fastest decay [1/s] and its integral [1] over the modes that the motion visits."""
    scene = hybrid.scene
    motion = follow(hybrid.automaton, scene.state, scene.duration, max_events=sweeps.MOST_EVENTS)
    modes, _, _, stays = motion.arcs()
    turn, decay, stiffness = scene.turn, 0.0, 0.0
    for mode in np.unique(modes):
        rates = np.linalg.eigvals(hybrid.modes[mode].matrix)
        fastest = float(np.abs(rates[rates.real < 0]).max(initial=0.0))
        turn = min(turn, float((2 * math.pi / np.abs(rates[rates.imag != 0])).min(initial=math.inf)))
        decay = max(decay, fastest)
        stiffness += fastest * float(stays[modes == mode].sum())
    return turn, decay, stiffness


def ask(question: Question, method_name: str, tolerance: float) -> Answer:
    """Run a method of :data:`lsvib.accuracy.catalogue.METHODS` at a relative tolerance.

    A fixed step is a thousandth of the shortest oscillation, or what is stable; it is held to ``tolerance`` like the
    others. Raises ``InputError`` if there is no such method or its package is missing. Call it under
    :func:`lsvib.accuracy.contest.quiet`: solvers print.
    """
    method = find_method(method_name)
    setting = tolerance
    if method.family == Family.FIXED_STEP:
        setting = _step(question)
        if question.case.duration > MOST_STEPS * setting:
            return Answer(Verdict.GAVE_UP, failure=_STIFF)
    elif method.explicit and question.stiffness > MOST_EVALUATIONS:
        # No explicit method is stable with steps of more than 1/rate for each evaluation.
        return Answer(Verdict.GAVE_UP, failure=_STIFF)
    most = 2 * len(question.path.kinds) + _SPARE_EVENTS
    function = method.prepare(question.hybrid, setting, Effort(MOST_EVALUATIONS), most)
    try:
        run = function().run()
    except GaveUp as reason:
        return Answer(Verdict.GAVE_UP, failure=_in_words(str(reason)))
    except (ArithmeticError, ValueError, RuntimeError) as fault:  # of the solver: not finite, no bracket
        return Answer(Verdict.GAVE_UP, failure=str(fault))
    if run.failure or not np.isfinite(run.end_state).all():
        return Answer(Verdict.GAVE_UP, failure=_in_words(run.failure) or "not finite")
    return compare(question.case.duration, question.path, run, GENEROSITY * tolerance)


def _in_words(failure: str) -> str:
    """Why a method gave up, the same for any number of events."""
    return "an endless chain of events" if failure.endswith("events") else failure


def _step(question: Question) -> float:
    """Step [s] that resolves the fastest oscillation, is stable, and makes a few steps in any case."""
    stable = 1.0 / question.decay if question.decay else math.inf
    return min(question.turn / _STEPS_PER_TURN, question.case.duration / _FEWEST_STEPS, stable)


def compare(duration: float, truth: sweeps.Path, run: Run, allowed: float) -> Answer:
    """Compare a run with the true motion; ``allowed``: error, relative to the motion and to its duration [s]."""
    gap = allowed * duration
    state_error = float(np.max(np.abs(run.end_state - truth.end) / np.where(truth.size > 0, truth.size, 1.0)))
    ours, theirs = list(zip(truth.times, truth.kinds, strict=True)), list(zip(run.times, run.kinds, strict=True))
    pairs = [(a, b) for a in _trimmed(ours, gap, duration) for b in _trimmed(theirs, gap, duration)]
    for a, b in pairs:
        if [kind for _, kind in a] == [kind for _, kind in b]:
            late = max((abs(x - y) for (x, _), (y, _) in zip(a, b, strict=True)), default=0.0)
            error = max(state_error, float(late) / duration)
            return Answer(Verdict.RIGHT if error <= allowed else Verdict.INACCURATE, error)
    if state_error > allowed:
        return Answer(Verdict.OTHER_MOTION)
    same = any(_same(_without_clusters(a, gap), _without_clusters(b, gap)) for a, b in pairs)
    return Answer(Verdict.RIGHT, state_error) if same else Answer(Verdict.OTHER_EVENTS)


def _trimmed(events: list[tuple[float, str]], gap: float, duration: float) -> Iterator[list[tuple[float, str]]]:
    """The events, all of them first, then without some of those that are next to the start or the end."""
    early = sum(time <= gap for time, _ in events)
    late = sum(time >= duration - gap for time, _ in events)
    for first in range(early + 1):
        for last in range(late + 1):
            yield events[first : max(first, len(events) - last)]


def _without_clusters(events: list[tuple[float, str]], gap: float) -> list[str]:
    """Kinds of events, with each run of events that follow each other within ``gap`` [s] as one."""
    tokens: list[str] = []
    for k, (time, kind) in enumerate(events):
        if k and time - events[k - 1][0] <= gap:
            tokens[-1] = "corner"
        else:
            tokens.append(kind)
    return tokens


def _same(left: list[str], right: list[str]) -> bool:
    return len(left) == len(right) and all(a == b or "corner" in (a, b) for a, b in zip(left, right, strict=True))
