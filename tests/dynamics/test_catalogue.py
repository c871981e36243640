"""Labels of drives such as catalogues offer, each held against where its motion itself has come much later.

The motion must end near what the label says: at the equilibrium, or on the orbit. Tolerance: a motion that attracts
slowly still has most of its first distance left, so that a tenth of it must be gone; and 1e-3 of the size of the motion
is where the points of an orbit lie.
"""

import math

import numpy as np
import pytest
from references.catalogue import MODELS, catalogue_drive

from lsvib.dynamics.attractor import Attractor, Doubt, SteadyState, steady_state
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.errors import WorkSpentError
from lsvib.models.model import automaton_of

DRIVES, STARTS = 5, 4  # of each model
CYCLES = (Attractor.STICK_SLIP_CYCLE, Attractor.SPRAG_SLIP_CYCLE, Attractor.OTHER_CYCLE)


def distances(found: SteadyState, motion: Motion, size: np.ndarray) -> tuple[float, float]:
    """Largest distance from an attractor, in sizes of the motion, over the motion's first and last hundredth."""
    points = found.state[None]
    if found.orbit is not None:
        points = np.vstack([found.orbit.after, found.orbit.at(np.linspace(0, found.period, 2000))[0]])
    times = motion.end_time * np.array([np.linspace(0, 0.01, 100), np.linspace(0.99, 1, 100)])
    first, last = (
        max(np.abs((points - state) / size).max(axis=1).min() for state in motion.at(part)[0]) for part in times
    )
    return float(first), float(last)


@pytest.mark.parametrize("model", MODELS)
def test_motions_end_where_their_labels_say(model):
    unresolved, held = 0, 0
    for index in range(DRIVES):
        drive, starts = catalogue_drive(model, 32, index, STARTS)
        automaton = automaton_of(drive)
        horizon = 20_000 * math.sqrt(drive.screw_inertia / drive.coupling_stiffness)
        for start in starts:
            found = steady_state(automaton, start)
            if found.label == Attractor.UNRESOLVED:
                unresolved += 1
                assert found.doubt in (Doubt.EVENT_BUDGET, Doubt.RECURRENT, Doubt.WORK_BUDGET)
                continue
            assert found.label in (Attractor.STEADY_SLIDING, *CYCLES)
            if found.orbit is not None:
                assert found.residual <= 1e-9
                assert abs(found.multiplier) < 1
            try:
                motion = follow(automaton, start, horizon, budget=Budget(2e5))
            except WorkSpentError:
                continue
            size = np.abs(np.vstack([start, motion.end_state, motion.after[:1000]])).max(axis=0)
            first, last = distances(found, motion, size)
            assert last <= max(0.9 * first, 1e-3)
            held += 1
    assert unresolved <= 2
    assert held >= 10
