"""Runs of the engine: rates decades apart, whose digits stay or are refused; the room for events; too many of them."""

import math

import numpy as np
import pytest
from references.parts import threads_drive

from lsvib.engine import motion as runs
from lsvib.engine.exact.modal_form import linear_mode, modal_flow
from lsvib.engine.kernels import event_loop
from lsvib.engine.motion import follow
from lsvib.errors import EngineError
from lsvib.models.drive import Drive
from lsvib.models.model import automaton_of
from lsvib.models.rigid import rigid_automaton


def test_growth_beyond_all_numbers_does_not_move_what_is_in_equilibrium():
    """Steady sliding that repels at 1.2e5 1/s: a motion from it stays there, for 0.2 s and whenever it is looked at."""
    drive = Drive.of(
        pitch_radius=0.03806244679962706, lead_angle=0.12264428665884365, screw_inertia=1.2429230549627857e-06,
        coupling_stiffness=0.003946670052215552, support_damping=9.60114218189808e-07,
        friction_coefficient=0.1608478915598803, input_speed=0.1696369958396299, mass=0.09625457766977397,
        translation_damping=10800.043519753883, axial_force=632.0047383503252,
    )  # fmt: skip
    motion = follow(rigid_automaton(drive), (0.0, 0.0), 0.2)
    assert motion.time.size == 0
    assert motion.end_state.tolist() == [0.0, 0.0]
    assert not motion.at([0.001, 0.1, 0.2])[0].any()


def test_growth_beyond_all_numbers_does_not_move_a_pair_in_equilibrium():
    """The same of a growing pair of a field of four states, beside a pair that decays and swings."""
    rows = [[0, 1, 0, 0, 0], [-1e10, 3e5, 0, 0, 0], [0, 0, 0, 1, 0], [0, 0, -100, -1, 0]]
    flow = modal_flow([linear_mode(rows, [1.0] * 4, None, "a parameter")])
    out, turning = np.empty(4), math.sqrt(99.75)
    event_loop.advance(flow, 0, np.array([0.0, 0.0, 1.0, 0.0]), 0.1, out)
    assert out[:2].tolist() == [0.0, 0.0]
    assert out[2] == pytest.approx(
        math.exp(-0.05) * (math.cos(0.1 * turning) + 0.5 / turning * math.sin(0.1 * turning)), rel=1e-12
    )


JUST_BELOW_COT_LEAD = {
    "support_damping": 54624.77056974889, "contact_stiffness": 24764977476642.695,
    "friction_coefficient": 10.25407004273012, "input_speed": -1e-9, "axial_force": 6949.60410918396,
}  # fmt: skip
CREEPING = [{"contact_stiffness": 1e4, "contact_damping": damping} for damping in (1e11, 1e12)]


@pytest.mark.parametrize("values", [*CREEPING, JUST_BELOW_COT_LEAD])
def test_rates_that_cannot_be_told_apart_are_refused_by_name(values):
    """A contact that creeps at 1e-8 1/s beside the coupling's 500 1/s; and a field that is singular in doubles."""
    drive = threads_drive(**values)
    with pytest.raises(EngineError, match=r"cannot be distinguished .*change contact_damping\."):
        automaton_of(drive)


FASTEST = Drive(translation_damping=1e15, friction_slope=-1e-5)  # turns at 10¹⁴ 1/s


def test_a_motion_of_too_many_steps_is_refused_in_one_sentence(monkeypatch):
    monkeypatch.setattr("lsvib.engine.motion._MANY_STEPS", 10_000)
    with pytest.raises(
        EngineError, match=r"takes more than 10,000 steps by its event after t = 0 s; shorten the duration"
    ):
        follow(rigid_automaton(FASTEST), (0.1, 0.0), 1.0)


def test_samples_of_a_friction_law_do_not_depend_on_those_before():
    """All samples of a stay are taken in one pass; each is that of a pass of its own, to rounding."""
    drive = Drive(stribeck_rise=0.05, stribeck_speed=0.02)
    motion = follow(rigid_automaton(drive), (0.1, 0.0), 0.2)
    times = np.sort(np.append(np.linspace(0.0, 0.2, 301), motion.time))
    states, modes = motion.at(times)
    for time, state, mode in zip(times, states, modes, strict=True):
        alone, there = motion.at([time])
        assert there[0] == mode
        assert (np.abs(alone[0] - state) <= 1e-13 * np.abs(states).max(axis=0)).all()


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
    whole = follow(automaton, start, duration)
    monkeypatch.setattr(runs, "_FIRST_CAPACITY", room)
    pieces = follow(automaton, start, duration)
    assert whole.time.size > 5
    for name in ("time", "kind", "sign", "mode", "before", "after", "end_state"):
        assert np.array_equal(getattr(whole, name), getattr(pieces, name))
    assert (whole.end_time, whole.end_mode, whole.status) == (pieces.end_time, pieces.end_mode, pieces.status)


def test_more_events_than_anybody_can_want_is_an_error_unless_asked_for(monkeypatch):
    assert follow(STICK_SLIP, (0.01, 0.0), 1.0, max_events=100).time.size == 100
    monkeypatch.setattr(runs, "_MANY_EVENTS", 100)
    with pytest.raises(EngineError, match=r"more than 100 events before t = 0\.\d+ s; shorten the duration"):
        follow(STICK_SLIP, (0.01, 0.0), 1.0)
