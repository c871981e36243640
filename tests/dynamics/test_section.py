"""The section of a Poincaré map: coordinates, and its map beside the compiled one of the rule."""

import math

import numpy as np
from references.parts import threads_drive

from lsvib.dynamics.poincare_map import Section, section_key
from lsvib.engine.motion import follow
from lsvib.models.mechanism import seated_state
from lsvib.models.model import automaton_of


def test_a_coordinate_that_is_zero_throughout():
    """Its scale was zero, and the section divided by it."""
    drive = threads_drive(mass=11.0, axial_force=50.0)
    automaton = automaton_of(drive)
    motion = follow(automaton, seated_state(drive, 0.003, -20.0), math.inf, max_events=40)
    key, size = section_key(motion), np.abs(motion.after).max(axis=0)
    ours = np.flatnonzero((motion.kind == key[0]) & (motion.mode == key[1]))
    origin, size = motion.after[ours[-1]].copy(), size.copy()
    origin[2] = size[2] = 0.0
    section = Section(automaton, key, origin, size, 1, 1.0)
    assert np.isfinite(section.directions).all()
    assert (section.place(origin) == 0).all()
