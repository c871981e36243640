"""Other methods on the cases of the sweeps: do they show the motion that really takes place?

The truth is the engine's own motion, and only in cases in which 40 digits have confirmed it
(:func:`benchmarks.sweeps.case_judge.judge`: RIGHT). A method is told the sizes of the motion, for its absolute
tolerances, and judged as in :mod:`benchmarks.judge`. Effort is counted in evaluations of the field,
not in seconds, so that a verdict is the same on every machine.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from benchmarks.judge import GENEROSITY, Answer, asked
from benchmarks.record import Record, Verdict
from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid, counted
from benchmarks.rivals.method_list import METHODS, MethodFamily
from benchmarks.rivals.race_scenes import RaceScene
from benchmarks.sweeps import case_judge
from benchmarks.sweeps.cases import Case
from benchmarks.sweeps.paths import INSTANT, automaton
from lsvib.engine.automaton import Automaton
from lsvib.engine.motion import Motion, follow
from lsvib.models.mechanics import coefficients

MOST_EVALUATIONS = 50_000  # evaluations of the field by a solver that calls Python for each of them: some 0.1 s
MOST_STEPS = 1_000_000  # steps of a method whose steps are compiled: some 0.1 to 0.5 s
_STEPS_PER_TURN = 1000  # steps in a turn of the fastest oscillation of the motion
_FEWEST_STEPS = 100  # steps of a motion that is shorter than a turn
_CAP = 50  # steps per turn where a solver is repeated with smaller steps
_SPARE_EVENTS = 50  # A chain of events is endless if it has so many more than twice the true number.


@dataclass(frozen=True)
class _Posed(RaceScene):
    """A case as a scene; ``sizes`` (n) are those of its motion."""

    sizes: tuple[float, ...] = ()
    case: Case | None = None

    def automaton(self) -> Automaton:
        """The one that is judged."""
        return automaton(self.case)

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
    def steady_from(self) -> float:
        """Infinite: no steady amplitude is asked for."""
        return math.inf


class Question(NamedTuple):
    """A case that the engine passed, its motion, and what limits the step of a method.

    ``turn`` [s]: shortest oscillation of the modes that the motion visits; ``decay`` [1/s]: their fastest decay.
    """

    case: Case
    path: Record
    hybrid: Hybrid
    turn: float
    decay: float


class Effort(Clock):
    """A limit on the evaluations, or on the compiled steps, of a run, the same on every machine."""

    def start(self) -> None:
        """Start counting."""
        self.calls = 0

    def over(self) -> str:
        """Return words if there were too many, else nothing."""
        return f"over {self.limit:g} evaluations" if self.calls > self.limit else ""


def pose(case: Case, rng: np.random.Generator) -> tuple[Verdict, Question | None]:
    """Judge the engine on a case; if it passed, return the question for others as well.

    A motion with too many events is cut before the last of them; where all of those are at the very start, there is no
    question.
    """
    outcome = case_judge.judge(case, rng)
    if outcome.verdict is Verdict.RIGHT and not outcome.path.complete:
        if outcome.path.times.size < 2:
            return outcome.verdict, None
        case = case._replace(duration=float(outcome.path.times[-2:].mean()))
        outcome = case_judge.judge(case, rng)
    if outcome.verdict is not Verdict.RIGHT or not outcome.path.complete:
        return outcome.verdict, None
    size = outcome.path.size
    scene = _Posed("case", "a case", case.drive, case.start, case.duration, math.inf, sizes=tuple(size), case=case)
    hybrid = Hybrid(scene)
    motion = follow(hybrid.automaton, case.start, case.duration, max_events=case_judge.MOST_EVENTS)
    question = Question(case, _truth(hybrid, motion, size), hybrid, *_rates(hybrid, motion))
    hybrid.scene = replace(scene, step_cap=min(question.turn, case.duration) / _CAP)
    return outcome.verdict, question


def _truth(hybrid: Hybrid, motion: Motion, size: np.ndarray) -> Record:
    """The engine's motion in the words of the other methods, without touches of a guard that last no time."""
    modes = [motion.start_mode, *motion.mode]
    kept: list[int] = []

    def touches(first: int, last: int) -> bool:
        at_once = motion.time[last] - motion.time[first] <= INSTANT * hybrid.scene.duration
        same = np.abs(motion.after[last] - motion.before[first]) <= INSTANT * size
        return bool(at_once and modes[last + 1] == modes[first] and same.all())

    for k in map(int, np.flatnonzero(counted(motion.kind))):
        if kept and touches(kept[-1], k):
            kept.pop()
        else:
            kept.append(k)
    kinds = [hybrid.names[int(motion.kind[k])] for k in kept]
    return Record(kinds, motion.time[kept], motion.end_state, size, True)


def _rates(hybrid: Hybrid, motion: Motion) -> tuple[float, float]:
    """Shortest oscillation [s] and fastest decay [1/s] of the modes that the motion visits."""
    turn, decay = hybrid.scene.turn, 0.0
    for mode in np.unique(motion.arcs()[0]):
        rates = np.linalg.eigvals(hybrid.modes[mode].matrix)
        turn = min(turn, float((2 * math.pi / np.abs(rates[rates.imag != 0])).min(initial=math.inf)))
        decay = max(decay, float(np.abs(rates[rates.real < 0]).max(initial=0.0)))
    return turn, decay


def ask(question: Question, method_name: str, tolerance: float) -> Answer:
    """Run a method of :data:`benchmarks.rivals.method_list.METHODS` at a relative tolerance.

    A fixed step is a thousandth of the shortest oscillation, or what is stable; it is held to ``tolerance`` like the
    others. Raises ``InputError`` if there is no such method or its package is missing. Call it under
    :func:`benchmarks.rivals.race.quiet`: solvers print.
    """
    method = METHODS[method_name]
    setting = tolerance
    if method.family == MethodFamily.FIXED_STEP:
        setting = _step(question)
        if question.case.duration > MOST_STEPS * setting:
            return Answer(Verdict.GAVE_UP)
    most = 2 * len(question.path.kinds) + _SPARE_EVENTS
    effort = Effort(MOST_STEPS if method.family == MethodFamily.TAYLOR else MOST_EVALUATIONS)
    function = method.prepare(question.hybrid, setting, effort, most)
    try:
        run = function()()
    except (GaveUp, ArithmeticError, ValueError, RuntimeError):  # the solver's own: not finite, no bracket
        return Answer(Verdict.GAVE_UP)
    return asked(question.case.duration, question.path, run, GENEROSITY * tolerance)


def _step(question: Question) -> float:
    """Step [s] that resolves the fastest oscillation, is stable, and makes a few steps in any case."""
    stable = 1.0 / question.decay if question.decay else math.inf
    return min(question.turn / _STEPS_PER_TURN, question.case.duration / _FEWEST_STEPS, stable)
