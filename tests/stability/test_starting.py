"""From rest: what becomes of a drive as it is switched on, and the smallest speed at which it runs evenly."""

import math

import numpy as np
import pytest
from mpmath import mp, mpf
from references.drives import JERKING
from references.series import Series
from references.sizes import sizes

import lsvib
from lsvib import Attractor, Drive, NoThreshold
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import PARTS
from lsvib.drives.model import model_of, standing_state
from lsvib.stability.starting import runs_evenly
from lsvib.systems.motion import enter

EVERYWHERE = Drive(
    lead_angle=0.0972, support_damping=5e-4, static_friction_coefficient=0.27, axial_force=40.0, slide_friction=3.0,
    slide_static_friction=6.0, bearing_friction=2e-3, bearing_static_friction=1e-2,
)  # fmt: skip
RIGID = {
    "measured": JERKING,
    "against the force": JERKING.replace(axial_force=-2.0, mass=0.1),
    "backwards, with drag": JERKING.replace(input_speed=-0.3, translation_damping=20.0, axial_force=-1.5),
    "guide": JERKING.replace(
        static_friction_coefficient=0, slide_friction=0.3, slide_static_friction=0.9, axial_force=-0.943
    ),
    "bearing": JERKING.replace(static_friction_coefficient=0, bearing_friction=2e-4, bearing_static_friction=1.6e-3),
    "guide that turns the force over": JERKING.replace(slide_friction=0.2, slide_static_friction=1.3, input_speed=-0.3),
    "threads, guide and bearing": EVERYWHERE,
}
PART_VALUES = {
    "motor": {"motor_inertia": 1e-6, "integral_gain": 0.1, "speed_gain": 2e-4},
    "support": {"screw_mass": 0.4, "support_stiffness": 2e5, "axial_support_damping": 40.0},
    "nut": {"nut_inertia": 1e-6, "nut_stiffness": 0.5, "nut_damping": 2e-4},
    "threads": {"contact_stiffness": 1e6, "contact_damping": 30.0},
}


def lowest_speed(drive: Drive, speed: mpf) -> mpf:
    """The lowest θ′ [rad/s] of the first slip of a rigid drive from rest, by the equations of motion in many digits."""
    p = {name: mpf(value) for name, value in drive}
    sense = mp.sign(speed)
    r, t, k, force = p["pitch_radius"], mp.tan(p["lead_angle"]), p["coupling_stiffness"], p["axial_force"] * sense
    mu, guide, bearing = (p.get(name, 0) for name in ("friction_coefficient", "slide_friction", "bearing_friction"))

    def xi(x, load):
        s = mp.sign(load)
        return (s * x - t) / (1 + s * x * t)

    xi_sliding = xi(mu, force - guide)
    inertia = p["screw_inertia"] - xi_sliding * t * p["mass"] * r**2
    damping = p["support_damping"] - xi_sliding * t * p["translation_damping"] * r**2
    # inertia θ″ + damping θ′ + k (θ − Ω t) + T = 0 from θ′ = 0, k (Ω t − θ) = T_r: v = θ′ from 0, Ω in time
    held = force - p.get("slide_static_friction", guide)
    rest = r * held * xi(p.get("static_friction_coefficient", mu), held) + p.get("bearing_static_friction", bearing)
    push, omega = (rest - r * (force - guide) * xi_sliding - bearing) / inertia, speed * sense
    a, b = ((-damping + sign * mp.sqrt(damping**2 - 4 * inertia * k)) / (2 * inertia) for sign in (1, -1))
    # v − Ω = A e^{at} + B e^{bt}, with v(0) = 0 and v′(0) = push
    first = (push + b * omega) / (a - b)
    second = -omega - first
    time = mp.log(-second * b / (first * a)) / (a - b)  # v′ = 0, once in half a turn
    half = mp.pi / abs(mp.im(a))
    times = [mp.re(time) + n * half for n in range(-2, 3)]
    at = min(t for t in times if t > 0 and mp.re(first * a**2 * mp.exp(a * t) + second * b**2 * mp.exp(b * t)) > 0)
    return omega + mp.re(first * mp.exp(a * at) + second * mp.exp(b * at))


@pytest.mark.parametrize("drive", RIGID.values(), ids=RIGID)
def test_even_speed_in_25_digits(drive):
    """To 1e-12 and within its enclosure, which is that of two doubles."""
    found = drive.threshold("even_speed")
    with mp.workdps(60):
        exact = mp.findroot(lambda speed: lowest_speed(drive, speed), mpf(found.value), solver="secant")
        assert abs(found.value - exact) <= mpf(1e-12) * abs(exact)
        assert found.enclosure[0] <= exact <= found.enclosure[1]
        step = mpf(10) ** -20
        static = ("static_friction_coefficient", "slide_static_friction", "bearing_static_friction")
        for name in ("support_damping", *(name for name in static if getattr(drive, name))):
            more = {**dict(drive), name: mpf(getattr(drive, name)) * (1 + step)}
            there = mp.findroot(lambda speed, p=more: lowest_speed(p.items(), speed), exact, solver="secant")
            slope = (there - exact) / (mpf(getattr(drive, name)) * step)
            assert found.derivatives[name].value == pytest.approx(float(slope), rel=1e-10)
    known = {JERKING: (6.3158, 6.3160, 30 / math.pi), EVERYWHERE: (4.3685, 4.3686, 1.0)}  # that reviewers hold
    low, high, unit = known.get(drive, (-math.inf, math.inf, 1.0))
    assert low < found.value * unit < high


SMOOTH = JERKING.replace(static_friction_coefficient=0.0, axial_force=0.0)  # nothing that gives its friction a size
OTHERS = [(JERKING, "coupling_stiffness"), (JERKING, "support_damping"), (JERKING, "static_friction_coefficient")]
OTHERS += [(SMOOTH, "slide_static_friction"), (SMOOTH, "bearing_static_friction")]
OTHERS += [(Drive(static_friction_coefficient=0.3, input_speed=1), "friction_coefficient")]  # at the end of its range
OTHERS += [(JERKING.replace(input_speed=2), "friction_slope")]  # negative


@pytest.mark.parametrize(("drive", "unknown"), OTHERS, ids=[unknown for _, unknown in OTHERS])
def test_even_speed_for_other_parameters(drive, unknown):
    """The value of a parameter at which the drive's own speed is the even speed."""
    value = drive.threshold("even_speed", unknown).value
    there = drive.replace(**{unknown: value})
    assert there.threshold("even_speed").value == pytest.approx(drive.input_speed, rel=1e-12)


def random_drive(seed: int) -> Drive:
    """A slow drive with static friction or a law of friction, and perhaps parts and dry friction."""
    rng = np.random.default_rng([seed, 46])
    values = {
        "coupling_stiffness": 10 ** rng.uniform(-2, -1), "support_damping": 10 ** rng.uniform(-4, -3.4),
        "axial_force": rng.choice([-1, 1]) * 10 ** rng.uniform(-0.3, 0.7),
        "friction_coefficient": rng.uniform(0.2, 0.5), "mass": 10 ** rng.uniform(-1, 0),
        "input_speed": rng.choice([-1, 1]) * 0.3, "static_friction_coefficient": 0.0,
    }  # fmt: skip
    static = values["friction_coefficient"] * rng.uniform(1.2, 1.6)
    if seed % 2:
        values["stribeck_rise"] = static - values["friction_coefficient"]
        values["stribeck_speed"] = 10 ** rng.uniform(-3, -2)
    else:
        values["static_friction_coefficient"] = static
        values |= {"slide_friction": 0.1, "bearing_friction": 1e-4} if rng.random() < 0.3 else {}
    for part in PARTS:
        values |= PART_VALUES[part] if rng.random() < 0.3 and seed % 3 == 0 else {}
    return JERKING.replace(**{key: float(value) for key, value in values.items()})


def jerks_just_below(seeds) -> int:
    """Hold the even speed of drives against the motions from rest a part in 10⁹ on either side; how many have one.

    Next to it a motion may be too much work; then the enclosure says so, as it is wider. With parts that comply the
    state at release differs from time to time, so that next to it some motions run evenly after a few stops, and only
    the ends of the enclosure are asked.
    """
    found = 0
    for seed in seeds:
        drive = random_drive(seed)
        try:
            solutions = drive.threshold("even_speed").solutions
        except NoThreshold:
            continue
        for one in solutions:
            low, high = one.enclosure
            close = high - low <= 1e-11 * abs(one.value)
            rigid = close and not drive.parts
            sides = (one.value * (1 - 1e-9), one.value * (1 + 1e-9)) if rigid else (low, high)
            assert {runs_evenly(drive.replace(input_speed=side)) for side in sides} == {True, False}, drive
            found += close
    return found


@pytest.mark.parametrize("seeds", sizes([[0, 1, 2, 4]], [[5, 7, 100, 101, 102]], [range(103, 172)]), ids=len)
def test_below_it_the_motion_sticks_for_ever(seeds):
    assert jerks_just_below(seeds) >= 0.7 * len(seeds)


@pytest.mark.parametrize("parts", [(), *((part,) for part in PARTS), tuple(PARTS)], ids=" and ".join)
def test_a_start_at_rest_stands_relaxed(parts):
    """All that turns stands, the coupling has no torque, and Newton's laws hold the load by what carries it.

    Only the motor begins to turn, as its controller sees the whole speed as error.
    """
    drive = JERKING.replace(**{key: value for part in parts for key, value in PART_VALUES[part].items()})
    state, laws, automaton = standing_state(drive), Series(drive), automaton_of(drive)
    standing = {part: 0.0 for part in drive.parts} | {"screw": -drive.input_speed, "motor": -drive.input_speed}
    assert state[1::2].tolist() == [standing[part] for part in ("screw", *drive.parts)]
    mode, _ = enter(automaton, state)
    (torque,) = automaton.observe("coupling_torque", state[None], np.array([mode]))
    assert abs(torque) < 1e-15
    name = model_of(drive).modes(int(automaton.codes[mode])).name.lower()
    assert name.startswith("rest")
    forces = laws.own(state + laws.steady, laws.mode(name))
    assert all(abs(forces[body]) < 1e-9 for body in (*laws.q, "x") if body != "psi")
    assert float(forces["n"]) == pytest.approx(drive.axial_force, rel=1e-12)


def test_rest_is_a_start_everywhere():
    """Scene, methods, sweep and command follow the same motion."""
    assert JERKING.steady_state("rest").label == Attractor.STICK_SLIP_CYCLE
    motion = JERKING.simulate("rest", 2.0)
    assert motion.w[0] == -JERKING.input_speed
    assert motion.coupling_torque[0] == pytest.approx(0, abs=1e-15)
    speeds = np.array([0.99, 1.01]) * JERKING.threshold("even_speed").value
    swept = JERKING.sweep(start="rest", input_speed=speeds)
    assert swept.attractor.values.tolist() == [Attractor.STICK_SLIP_CYCLE, Attractor.STEADY_SLIDING]
    law = JERKING.replace(friction_slope=1e-9)  # followed one by one
    assert (law.sweep(start="rest", input_speed=speeds).attractor == swept.attractor).all()
    scene = lsvib.Scene(drive=JERKING, start="rest", duration=2.0)
    assert lsvib.simulate(scene).equals(motion)
