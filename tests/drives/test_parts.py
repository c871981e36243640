"""Drives with any parts and laws of friction: against Newton's laws body by body, stiff parts, energy, refusals."""

from contextlib import suppress

import numpy as np
import pytest
from mpmath import mp, mpf
from references.bodies import Bodies
from references.comparisons import balanced, held
from references.drives import LAWS, drive_with_parts, nut_drive, support_drive
from references.newton import eigenvalues_of_sliding
from references.series import Series
from references.sizes import sizes

from lsvib import Drive
from lsvib.answers.sweep import sweep
from lsvib.drives import friction
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import PARTS
from lsvib.drives.model import model_of, standing_state
from lsvib.errors import EngineError, InputError
from lsvib.stability.boundaries import places
from lsvib.stability.conditions import stability
from lsvib.systems.attractor import steady_state
from lsvib.systems.motion import follow


def followed(seeds, **more: bool) -> tuple[list[Drive], list[str]]:
    """Hold motions of random drives, and N on each arc, against Newton's laws; drives not refused, and kinds of events.

    To 3e-10: some slips are so unstable that they make 1e-10 of a rounding.
    """
    drives, kinds = [], []
    for drive, start in (drive_with_parts(seed, **more) for seed in seeds):
        with suppress(InputError, EngineError):
            kinds += held(drive, start, None, 0.05, 10, state=3e-10)
            motion = follow(automaton_of(drive), start, 0.05, max_events=10)
            assert_normal_force(drive, motion)
            assert_observables_move_load_and_screw(drive, motion)
            drives.append(drive)
    return drives, kinds


def assert_normal_force(drive: Drive, motion) -> None:
    """N amid each arc, and its sign, are those of Newton's laws at the state there."""
    laws, model, (modes, _, _, durations) = Series(drive), model_of(drive), motion.arcs()
    long, middles = durations > 1e-9, np.cumsum(durations) - 0.5 * durations
    for mode, state in zip(modes[long], motion.at(middles[long])[0], strict=True):
        way = laws.mode(model.modes(int(motion.automaton.codes[mode])).name.lower())
        (found,) = motion.automaton.observe("normal_force", state[None], np.array([mode]))
        normal, least = laws.own(state + laws.steady, way)["N"], 1e-12 * abs(drive.axial_force)
        assert abs(found - normal) <= 1e-9 * abs(normal) + least, drive
        assert not way["slip"] or abs(normal) <= least or normal * way["contact"] > 0


def assert_observables_move_load_and_screw(p: Drive, motion) -> None:
    """Place, speeds, friction torque and contact force amid the longest slip, by differences: Newton's laws."""
    modes, _, _, durations = motion.arcs()
    stands = motion.automaton.marked(motion.automaton.codes[modes], "rest", "held")
    k = int(np.argmax(np.where(stands, 0.0, durations)))
    if stands[k] or durations[k] < 1e-5:
        return
    h, reach = 1e-3 * durations[k], p.pitch_radius * np.tan(p.lead_angle)
    here = motion.at(durations[: k + 1].sum() - 0.5 * durations[k] + h * np.arange(-2, 3))
    names = "load_place load_speed screw_speed axial_contact_force friction_torque coupling_torque sliding_speed"
    found = [motion.automaton.observe(name, *here) for name in names.split()]
    place, load, screw = ((y[0] - 8 * y[1] + 8 * y[3] - y[4]) / (12 * h) for y in found[:3])  # rates
    _, v, w, n, rubs, twist, slides = (own[2] for own in found)
    push = p.axial_force - p.translation_damping * v - p.slide_friction * np.sign(v)
    brake = p.support_damping * w + p.bearing_friction * np.sign(w) + rubs - reach * n
    for rate, *terms in ((place, v, -reach * p.input_speed), (p.mass * load, push, -n),
                         (p.screw_inertia * screw, twist, -brake)):  # fmt: skip
        assert abs(rate - sum(terms)) <= 1e-6 * np.abs(terms).max(), p
    assert rubs * slides >= 0


@pytest.mark.parametrize("seeds", sizes([range(24)], [[*range(24, 38), 47, 60]], [range(38, 400)]), ids=len)
def test_motions_obey_newtons_laws(seeds):
    """Modes, events and states, and N along the arcs."""
    drives, kinds = followed(seeds)
    assert len(drives) >= 0.8 * len(seeds)
    assert len(kinds) >= 4 * len(drives)
    assert len({*kinds}) >= 5
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
    """Eigenvalues of the field are those of the uneliminated equations; stable or not as is said."""
    drives = [drive_with_parts(seed, motor=seed % 3 == 0)[0] for seed in range(90)]
    assert {judged_by_newton(drive)[0] for drive in drives} == {2, 4, 6, 8, 10}


def judged_by_newton(drive: Drive) -> tuple[int, bool]:
    """Number of eigenvalues of a drive, which are held against Newton's laws, and whether it is stable."""
    report = stability(drive)
    found = np.array([complex(x) for x in eigenvalues_of_sliding(drive)])
    expected = np.sort_complex(np.array(report.eigenvalues))
    assert np.abs(np.sort_complex(found) - expected).max() <= 1e-6 * np.abs(expected).max(), drive
    return len(expected), report.stable


def test_a_collar_brakes_with_the_axial_force():
    """Motions, energy and eigenvalues of drives with a collar, constant friction and laws, by Newton's laws."""
    assert len(followed(range(16), collar=True)[0]) >= 13
    assert len(balanced(range(24), collar=True)) >= 5
    assert {judged_by_newton(drive_with_parts(seed, collar=True)[0])[1] for seed in range(24)} == {True, False}


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
    start, model, laws = np.array([0.0, 60.0, 0.0, 0.0]), model_of(drive), Bodies(drive)
    assert held(drive, start, None, 0.2, 20, state=1e-9)
    motion = follow(automaton_of(drive), start, 0.2, max_events=20)
    arcs = [laws.mode(model.modes(int(motion.automaton.codes[mode])).name.lower()) for mode in motion.arcs()[0]]
    jammed = [
        state[1] + drive.input_speed - (state[3] if part == "nut" else 0.0)
        for arc, kind, state in zip(arcs, motion.kind, motion.before, strict=False)
        if kind == model.events.SEIZURE and arc["slip"] * arc["contact"] > 0
    ]
    assert jammed
    inertia, mass = drive.screw_inertia, drive.mass
    if part == "nut":
        inertia = inertia * drive.nut_inertia / (inertia + drive.nut_inertia)
    else:
        mass = mass * drive.screw_mass / (mass + drive.screw_mass)
    for slip in jammed:  # Γ₊ of the speed at which they seize
        assert float(laws.lever(1, laws.mu(slip)) * laws.lead * mass) == pytest.approx(inertia, rel=1e-6)


def test_a_rise_of_nothing_changes_nothing():
    """Events, times, states and observables of a hundred random drives to 1e-12, passages left out."""
    events, parts = 0, set()
    for seed in range(100):
        drive, start = drive_with_parts(seed)
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
