"""Search for the worst case of a family: change the worst cases so far, keep what is worse.

A change multiplies some parameters and coordinates of the start, by a little or by a lot. Cases whose digits the input
does not hold, and corners (:class:`benchmarks.record.Verdict`), are no finds; a wrong one ends the search.
"""

import math
from typing import NamedTuple

import numpy as np

from benchmarks.record import Verdict
from benchmarks.sweeps.case_judge import CaseOutcome, judge
from benchmarks.sweeps.families import Case
from lsvib.errors import InputError

_KEPT = 8  # worst cases that are changed further
_FINEST = 8  # decades down to which a number is moved
_FINDS = (Verdict.RIGHT, Verdict.INACCURATE, Verdict.UNBALANCED, Verdict.WRONG)


class Tried(NamedTuple):
    """A case, and the judgement on it."""

    case: Case
    outcome: CaseOutcome

    @property
    def error(self) -> float:
        """Largest error of final state and event times; infinite if the verdict is wrong, −1 if this is no find."""
        if self.outcome.verdict not in _FINDS:
            return -1.0
        return math.inf if self.outcome.verdict is Verdict.WRONG else self.outcome.error


def search(begin: list[Tried], evaluations: int, rng: np.random.Generator) -> Tried:
    """Return the worst case after so many ``evaluations``; ``begin``: cases of one family, judged."""
    worst = sorted(begin, key=lambda tried: -tried.error)[:_KEPT]
    for _ in range(evaluations):
        if worst[0].error == math.inf:
            break
        k = int(len(worst) * rng.random() ** 2)  # the worst ones more often
        try:
            case = _changed(worst[k].case, rng)
        except InputError:  # outside the allowed ranges
            continue
        worst = sorted([*worst, Tried(case, judge(case, rng))], key=lambda tried: -tried.error)[:_KEPT]
    return worst[0]


def _changed(case: Case, rng: np.random.Generator) -> Case:
    """The case with about two of its numbers changed."""
    drive = dict(case.drive)
    count = len(drive) + len(case.start)
    chosen = rng.random(count) < 2 / count
    chosen[rng.integers(count)] = True
    steps = rng.normal(size=count) * 10 ** -rng.uniform(0.5, _FINEST, count)
    factors = np.where(chosen, np.exp(steps), 1.0).tolist()
    values = {key: value * factor for (key, value), factor in zip(drive.items(), factors, strict=False)}
    start = tuple(x * factor for x, factor in zip(case.start, factors[len(drive) :], strict=True))
    return case._replace(drive=type(case.drive).of(values), start=start)
