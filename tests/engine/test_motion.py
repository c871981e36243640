"""Runs of the engine for Python: the room for events takes no part in the result, and too many events are an error."""

import numpy as np
import pytest
from references.parts import threads_drive

from lsvib.engine import motion
from lsvib.errors import EngineError
from lsvib.models.drive import Drive
from lsvib.models.model import automaton_of
from lsvib.models.rigid import rigid_automaton

SPRAG_SLIP = rigid_automaton(Drive.of(mass=11.0, support_damping=1e-3, axial_force=-10.0))
STICK_SLIP = rigid_automaton(Drive.of(mass=1.0, translation_damping=1000.0, axial_force=40.0))
NO_DAMPING = rigid_automaton(Drive.of(mass=11.0, axial_force=-10.0), resume="at_once")  # seizures accumulate
THREADS = automaton_of(threads_drive(mass=11.0, axial_force=50.0, contact_stiffness=1e8, contact_damping=1e8))


@pytest.mark.parametrize("room", [1, 2, 3])
@pytest.mark.parametrize(
    ("automaton", "start", "duration"),
    [
        (SPRAG_SLIP, (0.1, 0.0), 0.5),
        (STICK_SLIP, (0.01, 0.0), 0.5),
        (NO_DAMPING, (0.1, 0.0), 0.2),
        (THREADS, (0.003, 0.0, 0.0, 0.0), 0.01),
    ],
)
def test_the_room_for_events_takes_no_part_in_the_arithmetic(monkeypatch, automaton, start, duration, room):
    whole = motion.follow(automaton, start, duration)
    monkeypatch.setattr(motion, "_FIRST_CAPACITY", room)
    pieces = motion.follow(automaton, start, duration)
    assert whole.time.size > 5
    for name in ("time", "kind", "sign", "mode", "before", "after", "end_state"):
        assert np.array_equal(getattr(whole, name), getattr(pieces, name))
    assert (whole.end_time, whole.end_mode, whole.status) == (pieces.end_time, pieces.end_mode, pieces.status)


def test_more_events_than_anybody_can_want_is_an_error_unless_asked_for(monkeypatch):
    assert motion.follow(STICK_SLIP, (0.01, 0.0), 1.0, max_events=100).time.size == 100
    monkeypatch.setattr(motion, "_MANY_EVENTS", 100)
    with pytest.raises(EngineError, match=r"more than 100 events before t = 0\.\d+ s; shorten the duration"):
        motion.follow(STICK_SLIP, (0.01, 0.0), 1.0)
