"""Search for the worst case of a family: change the draws that made the worst cases so far, keep what is worse.

A case is made of random draws, here numbers in [0, 1) that are kept with it (:class:`Draws`). A change of some of them
makes another case of the same family: near, if they change a little, which moves parameters and start a little, or
elsewhere, if one is drawn anew. Cases whose digits the input does not hold, and corners
(:class:`benchmarks.record.Verdict`), are no finds; a wrong one ends the search.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.record import Verdict
from benchmarks.sweeps.case_judge import CaseOutcome, judge
from benchmarks.sweeps.cases import cases
from benchmarks.sweeps.families import Case, CaseFamily

GENES = 40  # draws that are kept of a case; those after them are the same for all
_KEPT = 8  # worst cases that are changed further
_ANEW = 0.3  # share of the changed draws that are drawn anew
_FINEST = 8  # decades down to which a draw is moved
_FINDS = (Verdict.RIGHT, Verdict.INACCURATE, Verdict.UNBALANCED, Verdict.WRONG)


class Draws:
    """The draws that the families ask for, read from a list of numbers in [0, 1)."""

    def __init__(self, numbers: Iterable[float]) -> None:
        self.numbers, self.used = list(map(float, numbers)), 0
        self._more = np.random.default_rng(0)

    def random(self) -> float:
        """Next number in [0, 1)."""
        self.used += 1
        return self.numbers[self.used - 1] if self.used <= len(self.numbers) else float(self._more.random())

    def uniform(self, low: float, high: float) -> float:
        """Draw a number between two bounds."""
        return low + (high - low) * self.random()

    def integers(self, low: int, high: int | None = None) -> int:
        """Draw an integer from low to high − 1, from 0 to low − 1 if there is no high."""
        low, high = (0, low) if high is None else (int(low), int(high))
        return low + int((high - low) * self.random())

    def choice(self, options):
        """Draw one of some options."""
        return options[self.integers(len(options))]


@dataclass(frozen=True)
class Tried:
    """A case with the draws that it was made of, and what the judges say."""

    genes: np.ndarray
    used: int
    case: Case
    outcome: CaseOutcome

    @property
    def error(self) -> float:
        """Largest error of final state and event times; infinite if the verdict is wrong, −1 if this is no find."""
        if self.outcome.verdict not in _FINDS:
            return -1.0
        if self.outcome.verdict is Verdict.WRONG:
            return math.inf
        return self.outcome.error

    def description(self) -> dict[str, Any]:
        """Return everything that is needed to run the case again."""
        case, outcome = self.case, self.outcome
        numbers = {key: getattr(outcome, key) for key in ("state_error", "time_error", "sensitivity", "condition")}
        return {
            **{key: value if np.isfinite(value) else None for key, value in numbers.items()},
            "verdict": outcome.verdict.name.lower(),
            "events": outcome.events,
            "group": case.group.name.lower(),
            "level": case.level if np.isfinite(case.level) else None,
            "drive": dict(case.drive),
            "physics": list(case.physics),
            "start": list(case.start),
            "duration": case.duration,
        }


def attempt(family: CaseFamily, genes, rng: np.random.Generator, thorough: bool = False) -> Tried:
    """Make a case of a family from draws and judge it, as :func:`benchmarks.sweeps.case_judge.judge` does."""
    draws = Draws(genes)
    case = next(cases(family, 1, draws))
    return Tried(np.asarray(genes, dtype=float), min(draws.used, GENES), case, judge(case, rng, thorough))


def search(family: CaseFamily, begin: list[Tried], evaluations: int, rng: np.random.Generator) -> Tried:
    """Return the worst case after so many ``evaluations``; ``begin``: cases of the family that the reference judged."""
    worst = sorted(begin, key=lambda tried: -tried.error)[:_KEPT]
    for _ in range(evaluations):
        if worst and worst[0].error == math.inf:
            break
        k = int(_KEPT * rng.random() ** 2)  # the worst ones more often
        genes = _changed(worst[k], rng) if k < len(worst) else rng.random(GENES)
        tried = attempt(family, genes, rng)
        worst = sorted([*worst, tried], key=lambda other: -other.error)[:_KEPT]
    return worst[0]


def _changed(tried: Tried, rng: np.random.Generator) -> np.ndarray:
    """Draws of which about two are others."""
    genes = tried.genes.copy()
    chosen = rng.random(tried.used) < 2 / tried.used
    chosen[rng.integers(tried.used)] = True
    for k in np.flatnonzero(chosen):
        step = rng.normal() * 10 ** -rng.uniform(0.5, _FINEST)
        genes[k] = rng.random() if rng.random() < _ANEW else (genes[k] + step) % 1.0
    return genes
