"""The return map of a line: many returns at once are what each of them is alone."""

import math

import numpy as np
import pytest

from lsvib.dynamics.poincare_map import Section, section_key
from lsvib.engine.motion import follow
from lsvib.models.drive import RigidDrive, ThreadsDrive
from lsvib.models.rigid import rigid_automaton
from lsvib.models.threads import seated_state, threads_automaton

DRIVES = {
    "seizures": {"mass": 11.0, "support_damping": 1e-3, "axial_force": -10.0},
    "contact reversals": {"translation_damping": 1e3, "axial_force": 25.0},
    "hardly damped": {"support_damping": 1e-9, "axial_force": 0.0},
}


@pytest.mark.parametrize("room", [1, 64])
@pytest.mark.parametrize("name", DRIVES)
def test_many_returns_at_once_are_those_of_each_place(monkeypatch, name, room):
    """The same excess to the last bit and the same events, whether or not the room for these suffices."""
    automaton = rigid_automaton(RigidDrive.of(DRIVES[name]))
    motion = follow(automaton, (0.1, 0.0), math.inf, max_events=40)
    key, size = section_key(motion), np.abs(motion.after).max(axis=0)
    assert key is not None
    watched = (motion.kind == key[0]) & (motion.mode == key[1])
    longest = float(np.diff(motion.time[watched]).max())
    section = Section(automaton, key, motion.after[watched][-1], size, 1, longest)
    if section.dimension == 0:
        pytest.skip("a section that is a point")
    monkeypatch.setattr(return_section, "_ROOM", room)
    places = np.linspace(-1.5, 1.5, 31)
    came_back = 0
    for place, one in zip(places.tolist(), section.returns_from(places), strict=True):
        alone = section.return_from(place)
        assert one.events == alone.events
        assert one.excess == alone.excess or (math.isnan(one.excess) and math.isnan(alone.excess))
        came_back += one.events is not None
    assert came_back >= 5


def test_a_coordinate_that_is_zero_throughout():
    """Its scale was zero, and the section divided by it."""
    drive = ThreadsDrive.of(mass=11.0, axial_force=50.0)
    automaton = threads_automaton(drive)
    motion = follow(automaton, seated_state(drive, 0.003, -20.0), math.inf, max_events=40)
    key, size = section_key(motion), np.abs(motion.after).max(axis=0)
    ours = np.flatnonzero((motion.kind == key[0]) & (motion.mode == key[1]))
    origin, size = motion.after[ours[-1]].copy(), size.copy()
    origin[2] = size[2] = 0.0
    section = Section(automaton, key, origin, size, 1, 1.0)
    assert np.isfinite(section.axes).all()
    assert np.isfinite(section.directions).all()
    assert (section.place(origin) == 0).all()
