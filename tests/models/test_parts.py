"""Drives with any parts and laws of friction: against Newton's laws body by body, stiff parts, energy, refusals."""

from contextlib import suppress

import numpy as np
import pytest
from mpmath import mp, mpf
from references.bodies import Bodies
from references.comparisons import held_against_newton
from references.drives import drawn, nut_drive, one_of, power, signed, support_drive, times, uniform
from references.sizes import sizes

from lsvib import Drive
from lsvib.datasets.sweep import sweep
from lsvib.dynamics.attractor import steady_state
from lsvib.dynamics.energy import work
from lsvib.engine.motion import follow
from lsvib.errors import EngineError, InputError
from lsvib.models import friction
from lsvib.models.drive import PARTS
from lsvib.models.mechanism import standing_state
from lsvib.models.model import automaton_of, model_of
from lsvib.stability.boundaries import places
from lsvib.stability.conditions import stability

POSSIBLE = {  # of drives of the chapter's size
    "mass": power(-0.5, 1.1),
    "coupling_stiffness": power(-0.5, 0.5),
    "support_damping": power(-4.5, -2.5),
    "translation_damping": times(one_of(0, 1), power(1, 3)),
    "axial_force": signed(power(0.5, 2)),
    "input_speed": signed(power(0.5, 1.6)),
    "friction_coefficient": uniform(0.1, 0.3),
}
OWN = {
    "support": {
        "screw_mass": power(-0.5, 1), "support_stiffness": power(4, 6), "axial_support_damping": power(1, 2)
    },
    "nut": {"nut_inertia": power(-5.5, -4.5), "nut_stiffness": power(-1, 1), "nut_damping": power(-5, -3)},
    "threads": {"contact_stiffness": power(4, 6), "contact_damping": power(1, 2)},
}  # fmt: skip
MOTOR = {
    "motor_inertia": power(-5.5, -4.5), "integral_gain": power(-0.5, 0.5), "speed_gain": power(-4, -2.5),
    "coupling_damping": power(-5, -4),
}  # fmt: skip
LAWS = (  # of friction: constant, higher at rest, rising towards slow sliding, with a slope, both
    {}, {"static_friction_coefficient": uniform(1.2, 1.6)},
    RISE := {"stribeck_rise": uniform(0, 0.1), "stribeck_speed": power(-2.3, -0.5), "stribeck_exponent": one_of(1, 2)},
    SLOPE := {"friction_slope": uniform(-0.5, 0.3)}, RISE | SLOPE,
)  # fmt: skip
COLLAR = {"collar_friction": uniform(0.05, 0.3), "collar_radius": power(-2.6, -1.9)}


def random_drive(seed: int, collar: bool = False, motor: bool = False) -> tuple[Drive, np.ndarray]:
    """A drive with random parts, or a collar, frictions and a law or none; and a start.

    Without frictions of a body that slides on its own, which are not followed under a law.
    """
    rng = np.random.default_rng([seed, 45])
    values, own = drawn(rng, POSSIBLE), {part: drawn(rng, draws) for part, draws in OWN.items()}
    parts = [part for part in OWN if rng.random() < 0.6 and not collar]
    for part in parts:
        values |= own[part]
    values |= drawn(rng, MOTOR) if motor else {}
    values |= drawn(rng, COLLAR) if collar else {}
    law = LAWS[rng.integers(len(LAWS))]
    values |= {key: values["friction_coefficient"] * x if "static" in key else x for key, x in drawn(rng, law).items()}
    dry = drawn(rng, slide_friction=power(-0.5, 1), bearing_friction=power(-3, -1.5)) if rng.random() < 0.6 else {}
    for key, bodies in (("slide_friction", {"support", "threads"}), ("bearing_friction", {"nut"})):
        if key in dry and not (bodies & {*parts} and law.keys() & friction.NAMES[1:]):
            values[key] = dry[key]
    drive = Drive(**values)
    start = np.zeros(2 + 2 * len(drive.parts))
    start[:2] = rng.uniform(-0.2, 0.2), rng.uniform(-2, 2) * drive.input_speed
    return drive, start


def held(seeds, **more: bool) -> tuple[list[Drive], int, set[int]]:
    """Hold motions of random drives against Newton's laws; drives that are not refused, number and kinds of events.

    To 3e-10: some slips are so unstable that they make 1e-10 of a rounding, in the engine and in what it is held
    against; nearly all arcs agree to 1e-12.
    """
    found, events, kinds = [], 0, set()
    for drive, start in (random_drive(seed, **more) for seed in seeds):
        with suppress(InputError, EngineError):
            motion, _ = held_against_newton(drive, start, 0.05, 10, 3e-10)
            assert len(motion.time) < 4 or motion.time[-4] < motion.time[-1], "an event follows upon the other at once"
            found.append(drive)
            events, kinds = events + motion.time.size, kinds | set(motion.kind.tolist())
    return found, events, kinds


def balanced(seeds, draw=random_drive, **more: bool) -> list[tuple[str, ...]]:
    """Assert that the energy of the cycles of random drives balances; the parts of the drives that have one.

    To rounding; of those that jam, where the force grows as the inverse root of the time left, to twice the root of it.
    """
    found = []
    for drive, start in (draw(seed, **more) for seed in seeds):
        with suppress(InputError, EngineError):
            automaton = automaton_of(drive)
            orbit = steady_state(automaton, start, max_events=20_000).orbit
            if orbit is not None and orbit.time.size:
                jams = np.isin(orbit.kind, automaton.sprag_kinds).any() and (
                    drive.stribeck_rise or drive.friction_slope
                )
                assert abs(work(drive, orbit).balance) <= (3e-8 if jams else 1e-13), drive
                found.append(drive.parts)
    return found


@pytest.mark.parametrize("seeds", sizes([range(24)], [[*range(24, 38), 47, 60]], [range(38, 400)]), ids=len)
def test_motions_obey_newtons_laws(seeds):
    """States along arcs and N, and all along each arc what its mode says of signs and of what friction can hold."""
    drives, events, kinds = held(seeds)
    assert len(drives) >= 0.8 * len(seeds)
    assert events >= 4 * len(drives)
    assert len(kinds) >= 5
    assert len({drive.parts for drive in drives}) >= 7
    laws = {tuple(key for key, value in drive if key in friction.NAMES and value) for drive in drives}
    assert len(laws) >= len(LAWS)


STIFF = {
    "motor": {"motor_inertia": 1e-5, "integral_gain": 1e3, "speed_gain": 1e-1},
    "support": {"screw_mass": 3.0, "support_stiffness": 1e7, "axial_support_damping": 3e3},
    "nut": {"nut_inertia": 1e-5, "nut_stiffness": 1e3, "nut_damping": 1e-2},
    "threads": {"contact_stiffness": 1e7, "contact_damping": 3e3},
}


@pytest.mark.parametrize("part", PARTS)
def test_a_stiff_part_tends_to_the_drive_without_it(part):
    """Of first order in the compliance: a thousandth of it leaves a thousandth of the difference."""
    times = np.linspace(0, 0.03, 50)

    def moved(drive: Drive) -> np.ndarray:
        start = model_of(drive).initial_state(drive, {"u": 0.05, "w": 0.0})
        return follow(automaton_of(drive), start, 0.03).at(times)[0][:, 0]

    other = {name: value for one in PARTS if one != part for name, value in STIFF[one].items()}
    base, apart = Drive(mass=1.5, translation_damping=500.0, axial_force=30.0, **other), []
    for factor in (1.0, 1e3):
        own = {name: x if name.endswith(("mass", "inertia")) else x * factor for name, x in STIFF[part].items()}
        apart.append(np.abs(moved(base.replace(**own)) - moved(base)).max())
    assert apart[1] < 2e-3 * apart[0]


def test_energy_of_cycles():
    """What the motor and the load put in is what dampers, frictions and seizures take out, of cycles with any parts."""
    parts = balanced(range(48))
    assert len(parts) >= 14
    assert len(set(parts)) >= 6


def test_stability_is_that_of_newtons_laws():
    """Eigenvalues of the field, by differences of the uneliminated equations, to 1e-8; stable or not as is said."""
    assert {judged_by_newton(random_drive(seed, motor=seed % 3 == 0)[0])[0] for seed in range(90)} == {2, 4, 6, 8, 10}


def judged_by_newton(drive: Drive) -> tuple[int, bool]:
    """Number of eigenvalues of a drive, which are held against Newton's laws, and whether it is stable."""
    report, laws = stability(drive), Bodies(drive)
    mode = {"slip": int(laws.sense), "contact": int(laws.sense) * report.steady_law}
    mode |= {name: int(laws.sense) for name in ("bearing", "slide") if laws.p[f"{name}_friction"]}
    steady = laws.steady.copy()
    if "e" in laws.place:
        steady = steady + model_of(drive).initial_state(drive, {"u": 0.0, "w": 0.0})
    size = np.abs(steady).max() * 1e-6
    columns = []
    for k in range(steady.size):
        step = np.zeros_like(steady)
        step[k] = size
        columns.append((laws.rate(0, steady + step, mode) - laws.rate(0, steady - step, mode)) / (2 * size))
    found = np.sort_complex(np.linalg.eigvals(np.array(columns).T))
    expected = np.sort_complex(np.array(report.eigenvalues))
    assert np.abs(found - expected).max() <= 1e-6 * np.abs(expected).max(), drive
    return len(expected), report.stable


def test_a_collar_brakes_with_the_axial_force():
    """Motions, energy and eigenvalues of drives with a collar, constant friction and laws, by Newton's laws."""
    assert len(held(range(16), collar=True)[0]) >= 13
    assert len(balanced(range(24), collar=True)) >= 5
    assert {judged_by_newton(random_drive(seed, collar=True)[0])[1] for seed in range(24)} == {True, False}


@pytest.mark.parametrize(
    "friction", [{"static_friction_coefficient": 0.4}, {"stribeck_rise": 0.15, "stribeck_speed": 0.02}]
)
def test_a_motor_on_a_stiff_coupling_turns_with_the_screw(friction):
    """As one body I + J on the gains as spring and damper; of first order in the compliance of the coupling."""
    slow = Drive(input_speed=1.0, axial_force=-60.0, **friction)
    one = slow.replace(screw_inertia=3.12e-6 + 1e-5, coupling_stiffness=1.5, support_damping=2e-4 + 1e-3)
    expected = steady_state(automaton_of(one), standing_state(one)).period
    apart = []
    for stiffness in (1e3, 1e4):
        motor = {"motor_inertia": 1e-5, "integral_gain": 1.5, "speed_gain": 1e-3}
        drive = slow.replace(**motor, coupling_stiffness=stiffness, coupling_damping=1e-4 * stiffness)
        apart.append(abs(steady_state(automaton_of(drive), standing_state(drive)).period / expected - 1))
    assert apart[0] < 2e-3
    assert 0.09 * apart[0] < apart[1] < 0.11 * apart[0]


def test_the_critical_mass_with_a_collar():
    """m_cr = I / [(ξ₊ + μ_b r_b / r_m) tan λ r_m²]: with thread's own friction and radius about a third (mpmath)."""
    plain = Drive()
    drive = plain.replace(collar_friction=0.218, collar_radius=5.18e-3)
    with mp.workdps(30):
        tangent, mu = mp.tan(mpf(drive.lead_angle)), mpf(0.218)
        xi = (mu - tangent) / (1 + mu * tangent)
        mass = mpf(drive.screw_inertia) / ((xi + mu) * tangent * mpf(drive.pitch_radius) ** 2)
    found = places(drive, "kinematic_constraint", "mass")
    assert float(found[0].value) == pytest.approx(float(mass), rel=1e-15)
    assert float(mass) / 10.106965213139869 == pytest.approx(0.3511, abs=1e-4)


def test_a_damper_that_is_left_out_is_zero_and_a_part_can_be_taken_out():
    drive = Drive(contact_stiffness=1e8)
    assert drive.contact_damping == 0.0
    assert drive.parts == ("threads",)
    assert drive.replace(contact_stiffness=None, contact_damping=None) == Drive()


def test_a_sweep_from_without_friction_of_the_slide_to_with_it():
    """Rigid drives have tables of their own; the smallest friction changes nothing but the tables."""
    drive = Drive(translation_damping=1000.0, axial_force=30.0)
    found = sweep(drive, {"slide_friction": [0.0, 1e-9, 5.0]})
    assert found.period[1] == pytest.approx(float(found.period[0]), rel=1e-9)
    # Pure slip is in proportion to the force on the threads, R − r_m tan λ c_x Ω − F_0.
    force = 30.0 - 1000.0 * 40.0 * drive.pitch_radius * np.tan(drive.lead_angle)
    assert found.amplitude[2] / found.amplitude[0] == pytest.approx((force - 5.0) / force, rel=1e-9)
    alone = steady_state(automaton_of(drive.replace(slide_friction=5.0)), np.array([1e-3, 0.0]) * drive.input_speed)
    assert found.period[2] == pytest.approx(alone.period, rel=1e-9)


@pytest.mark.parametrize("part", ["support", "nut"])
def test_threads_seize_where_friction_comes_to_the_painleve_band(part):
    """Friction rises towards slow sliding, so that law + holds above a speed and ends there by a seizure."""
    own = STIFF[part] | ({"screw_mass": 40.0} if part == "support" else {})
    drive = Drive(mass=40.0, friction_coefficient=0.1, stribeck_rise=0.2, stribeck_speed=0.1, axial_force=60.0, **own)
    motion, arcs = held_against_newton(drive, np.array([0.0, 60.0, 0.0, 0.0]), 0.2, 20, 1e-9)
    jammed = [
        state[1] + drive.input_speed - (state[3] if part == "nut" else 0.0)
        for arc, kind, state in zip(arcs, motion.kind, motion.before, strict=False)
        if kind == model_of(drive).events.SEIZURE and arc["slip"] * arc["contact"] > 0
    ]
    assert jammed
    laws, inertia, mass = Bodies(drive), drive.screw_inertia, drive.mass
    if part == "nut":
        inertia = inertia * drive.nut_inertia / (inertia + drive.nut_inertia)
    else:
        mass = mass * drive.screw_mass / (mass + drive.screw_mass)
    for slip in jammed:  # Γ₊ of the speed at which they seize
        assert laws.lever(1, laws.mu(slip)) * laws.lead * mass == pytest.approx(inertia, rel=1e-6)


def test_a_rise_of_nothing_changes_nothing():
    """Events, times, states and observables of a hundred random drives to 1e-12, passages left out."""
    events, parts = 0, set()
    for seed in range(100):
        drive, start = random_drive(seed)
        drive = drive.replace(**dict.fromkeys(("stribeck_rise", "stribeck_speed", "friction_slope"), 0.0))
        try:
            law = automaton_of(drive.replace(stribeck_rise=1e-300, stribeck_speed=0.01, stribeck_exponent=1))
        except InputError:  # with the friction of a body that slides on its own
            continue
        plain, passage = automaton_of(drive), model_of(drive).events["PASSAGE"]
        motion = follow(plain, start, 0.05, max_events=30)
        if motion.time.size == 30 and motion.time[-1] == motion.time[-9]:  # rest and slip alternate at one instant
            continue
        end = motion.end_time if motion.time.size < 30 else motion.time[-2:].mean()
        other = follow(law, start, end)
        known, found = motion.time < end, other.kind != passage
        assert (motion.kind[known] == other.kind[found]).all()
        size = np.abs([*motion.before, *motion.after, motion.start_state]).max(axis=0)
        np.testing.assert_allclose(other.time[found], motion.time[known], rtol=1e-12, atol=1e-14 * end)
        assert (np.abs(other.before[found] - motion.before[known]) <= 1e-12 * size).all()
        assert (np.abs(other.after[found] - motion.after[known]) <= 1e-12 * size).all()
        times = np.linspace(0, end, 30)[1:-1]
        here, there = motion.at(times), other.at(times)
        for name in plain.observables:
            one, two = plain.observe(name, *here), law.observe(name, *there)
            np.testing.assert_allclose(two, one, rtol=0, atol=1e-11 * np.abs(one).max())
        events, parts = events + known.sum(), parts | {drive.parts}
    assert events > 350
    assert len(parts) == 8


@pytest.mark.parametrize("kind", [support_drive, nut_drive])
def test_seizures_under_a_law(kind):
    """In the Painlevé region at all speeds the threads seize, and slip begins with the friction of slow sliding."""
    heavy = {"mass": 40.0} | ({"screw_mass": 40.0} if kind is support_drive else {})
    drive = kind(**heavy, axial_force=-50, stribeck_rise=0.1, stribeck_speed=0.1)
    model, automaton = model_of(drive), automaton_of(drive)
    assert {int(code) for code in automaton.codes} <= {int(m) for m in model.modes if "FORWARD_POS" not in m.name}
    motion = follow(automaton, model.initial_state(drive, {"u": 1.0, "w": 10.0}), 0.05)
    assert (motion.kind == model.events["SEIZURE"]).any()
