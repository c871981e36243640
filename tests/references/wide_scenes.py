"""Motions of the random drives of ``judge.wide_drives``, by seed, drive and start."""

import math
from unittest.mock import patch

import numpy as np
from references.wide_drives import wide_drive

from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.cycles.patience import follow_patiently
from lsvib.drives.once import forget
from lsvib.drives.registry import find_model
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels.status import Status
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.engine.motion import Budget


def scene(model: str, seed: int, index: int, start: int, in_blocks: bool = False) -> tuple[Automaton, np.ndarray]:
    """Automaton and start of a motion of a random drive; ``in_blocks``: whatever modal form its modes have."""
    wide, kind = wide_drive(model, seed, index, 4), find_model(model)
    if not in_blocks:
        return kind.build(wide.drive, wide.physics, "contact_sign"), wide.starts[start]
    forget()  # an automaton that was made in modal form
    try:
        with patch("lsvib.engine.exact.flow_choice.modal_mode", side_effect=ArithmeticError):
            automaton = kind.build(wide.drive, wide.physics, "contact_sign")
    finally:
        forget()
    assert isinstance(automaton.tables.flow, BlockFlow)
    return automaton, wide.starts[start]


def assert_slides_steadily(automaton: Automaton, state: np.ndarray, most_events: int, work: float) -> None:
    """The motion settles within so many events and so much work, and steady sliding is what it is told to end on."""
    motion = follow_patiently(automaton, state, math.inf, mode=None, max_events=most_events, budget=Budget(work))
    assert motion.status == Status.SETTLED
    assert steady_state(automaton, state).label == Attractor.STEADY_SLIDING
