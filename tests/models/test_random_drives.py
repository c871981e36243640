"""Motions of random drives of every model, over many decades of their parameters, against the references of 40 digits.

A motion is right if it has the events of the reference, its final state and event times to 1e-9, and an energy that
balances; or if digits that the input does not have decide (:mod:`benchmarks.sweeps.case_judge`).
"""

import math

import numpy as np
import pytest
from references.wide_drives import MODELS, wide_drive

from benchmarks.record import Verdict
from benchmarks.sweeps.case_judge import judge
from benchmarks.sweeps.families import Case, CaseFamily
from benchmarks.sweeps.paths import automaton, fields
from lsvib.engine.motion import follow
from lsvib.errors import EngineError, InputError

DRIVES = {"rigid": 60, "threads": 20, "support": 12, "nut": 12}
EVENTS = 8
TURNS = 100
GOOD = {Verdict.RIGHT, Verdict.CORNER, Verdict.BEYOND_INPUT}


def case_of(model: str, index: int) -> Case | None:
    """The motion of a random drive up to its eighth event; None if it has none, or is refused.

    It lasts for a few turns of the fastest oscillation, which bounds the work of the reference.
    """
    wide = wide_drive(model, 32, index, 1)
    start = tuple(map(float, wide.starts[0]))
    case = Case(CaseFamily.RANDOM, 0.0, wide.drive, start, math.inf, wide.physics)
    try:
        engine = automaton(case)
    except (InputError, EngineError):  # a quarter of such threads have rates that doubles do not tell apart
        return None
    rates = np.concatenate([np.linalg.eigvals(field[:, :-1]) for field in fields(engine)])
    motion = follow(engine, start, TURNS * math.tau / max(np.abs(rates).max(), 1e-9), max_events=EVENTS)
    end = motion.end_time if motion.time.size < EVENTS else motion.time[-2:].mean()
    return case._replace(duration=float(end)) if motion.time.size else None


@pytest.mark.parametrize("model", MODELS)
def test_motions_of_random_drives(model):
    outcomes = {}
    for index in range(DRIVES[model]):
        case = case_of(model, index)
        if case is not None:
            outcomes[index] = judge(case, np.random.default_rng(index))
    wrong = {index: found for index, found in outcomes.items() if found.verdict not in GOOD}
    assert not wrong
    right = sum(found.verdict is Verdict.RIGHT for found in outcomes.values())
    assert right >= 0.9 * len(outcomes)
    assert sum(found.events for found in outcomes.values()) >= DRIVES[model]
