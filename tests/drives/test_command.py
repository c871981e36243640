"""A commanded speed that changes: pieces, jumps, seizures and stops; motions are held by ``test_contacts.py``."""

import numpy as np
import pytest
from references.known import PARADOX

import lsvib
from lsvib import Drive
from lsvib.answers.motion import Simulation, as_scene
from lsvib.drives.automata import automaton_of
from lsvib.drives.model import standing_state
from lsvib.drives.names import Event
from lsvib.drives.scene import Command
from lsvib.errors import InputError
from lsvib.systems.motion import Budget, follow


def followed(drive: Drive, start: np.ndarray, duration: float, command: Command | None = None, resume="contact_sign"):
    """The motion of a drive from a state, under a command or at its input speed."""
    automaton = automaton_of(drive, resume, command)
    return follow(automaton, [*start, *([0.0] if command else [])], duration, budget=Budget(100_000))


@pytest.mark.parametrize("resume", ["contact_sign", "at_once"])
def test_seizures_go_on_under_a_command(resume):
    """In the Painlevé region a constant command seizes as the rigid drive does, by either resume rule."""
    drive = PARADOX
    plain = followed(drive, np.array([0.1, 0.0]), 0.1, resume=resume)
    motion = followed(drive, np.array([0.1, 0.0]), 0.1, Command(times=[0.02, 0.03], speeds=[40, 40]), resume)
    real = motion.kind != Event.COMMAND
    assert np.count_nonzero(plain.kind == Event.SEIZURE) > 3
    np.testing.assert_array_equal(motion.kind[real], plain.kind)
    np.testing.assert_allclose(motion.before[real, :2], plain.before, rtol=1e-9, atol=1e-10)


def test_a_ramp_needs_the_torque_of_the_inertia():
    """Long after the start of a ramp in slip, T = I_total α + c θ′ + friction; mean over a swing of the coupling."""
    drive = Drive(support_damping=2e-3)
    ramp = 20.0
    motion = followed(drive, np.zeros(2), 2.0, Command(times=[0, 2], speeds=[40, 80]))
    times = np.linspace(1.5, 2.0, 5001)[:-1]
    states, modes = motion.at(times)
    torque, speed = (motion.automaton.observe(name, states, modes) for name in ("coupling_torque", "screw_speed"))
    steady = followed(drive, np.zeros(2), 0.01)
    (level,) = steady.automaton.observe("coupling_torque", steady.start_state[None], np.array([steady.start_mode]))
    mu, angle, radius = drive.friction_coefficient, drive.lead_angle, drive.pitch_radius
    lever = radius * (mu - np.tan(angle)) / (1 + mu * np.tan(angle))  # r_m ξ₊; the load's inertia acts through it
    inertia = drive.screw_inertia - lever * drive.mass * radius * np.tan(angle)
    expected = level + inertia * ramp + drive.support_damping * (speed - 40.0)
    assert np.mean(torque - expected) == pytest.approx(0, abs=1e-3 * inertia * ramp)


def test_pieces_and_jumps():
    """Straight between points, constant outside, a jump where a time stands twice, at which the coupling is relaxed."""
    command = Command(times=[0.1, 0.1, 0.3], speeds=[0, 40, 20])
    assert list(command.pieces()) == [(0.1, 0.0, 0.0), (0.3 - 0.1, 40.0, -20.0 / (0.3 - 0.1)), (np.inf, 20.0, 0.0)]
    np.testing.assert_allclose(command.at([0, 0.05, 0.1, 0.2, 0.3, 1]), [0, 0, 40, 30, 20, 20])
    drive = Drive()
    waits = followed(drive, standing_state(drive), 0.4, Command(times=[0.1, 0.1], speeds=[0, 40]))
    plain = followed(drive, standing_state(drive), 0.3)
    np.testing.assert_allclose(waits.time[waits.kind != Event.COMMAND] - 0.1, plain.time, rtol=1e-9)
    np.testing.assert_allclose(waits.at([0.25])[0][0, :2], plain.at([0.15])[0][0], rtol=1e-7, atol=1e-9)


def test_a_scene_with_a_command():
    """Start, ramp and stop: speed follows, rests at both ends; an end is told where the command comes to the speed."""
    drive = lsvib.Drive(static_friction_coefficient=0.3)
    motion = drive.simulate(
        "rest", 1.2, command={"times": [0.1, 0.3, 0.7, 0.9], "speeds": [0, 40, 40, 0]},
        outputs=("screw_speed", "load_place", "load_speed"),
    )  # fmt: skip
    assert not [name for name in motion if "clock" in name]
    assert "speeds to the constant input_speed" in motion.comment
    speed, commanded, time = (motion[name].values for name in ("screw_speed", "commanded_speed", "time"))
    np.testing.assert_allclose(commanded, np.interp(time, [0.1, 0.3, 0.7, 0.9], [0, 40, 40, 0]), atol=1e-12)
    place, mean = motion.load_place.values, 0.5 * (motion.load_speed.values[1:] + motion.load_speed.values[:-1])
    np.testing.assert_allclose(np.cumsum(mean * np.diff(time)), place[1:] - place[0], atol=1e-3 * np.ptp(place))
    assert not speed[(time < 0.1) | (time > 1.0)].any()
    assert np.abs(speed - commanded)[(time > 0.5) & (time < 0.7)].max() < 0.3
    scene = {"drive": drive, "start": "rest", "duration": 1.0}
    ends = {}
    for last in (40, 20):
        checked = as_scene({**scene, "command": {"times": [0, 0.2], "speeds": [0, last]}}, {}, {})
        ends[last] = Simulation.of(checked).to_json()
    assert ends[40]["attractor"] == "steady_sliding"
    assert ends[20]["attractor"] == "unresolved"
    assert "within the duration" in ends[20]["unresolved_because"]


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ({"times": [0, 1], "speeds": [0, 1, 2]}, "2 times but 3 speeds"),
        ({"times": [0], "speeds": [0]}, "command: times = [0] is not long enough; it needs at least 2."),
        ({"times": 5, "speeds": [0, 1]}, "command: times = 5 is not a list."),
        ({"times": [1, 0], "speeds": [0, 1]}, "must ascend"),
        ({"times": [-1, 0], "speeds": [0, 1]}, "must ascend"),
        ({"times": [0, 0, 0], "speeds": [0, 1, 2]}, "more than twice"),
        ({"times": [0, 1], "speeds": [0, 1e10]}, "-1e9 <= speed <= 1e9"),
        ({"times": [0, "fast"], "speeds": [0, 1]}, "command: times.1 = 'fast' is not a number"),
        ({"times": [0, 1]}, "command: speeds is missing"),
        ({"times": [0, 1], "speeds": [0, 1], "until": 3}, "until is not a known key; the known keys are times, speeds"),
        ([0, 1], "command = [0, 1] is not a set of names and values, such as times: [0, 1] and speeds: [0, 40]."),
        ({"times": np.array(1.0), "speeds": [0, 1]}, "command: times = 1.0 is not a list."),
    ],
)
def test_a_wrong_command_is_refused_in_one_sentence(command, words):
    with pytest.raises(InputError) as error:
        lsvib.Drive().simulate("rest", 1.0, command=command)
    assert words in str(error.value)
    assert "\n" not in str(error.value)
