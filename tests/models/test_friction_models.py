"""Friction laws in every model: against constant friction, and against Newton's laws with adaptive steps."""

import numpy as np
import pytest
from references.draws import drawn, one_of, power, signed, uniform
from references.drives import held_against_newton
from references.parts import nut_drive, support_drive, threads_drive

from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.dynamics.energy import work
from lsvib.dynamics.sweep import all_endings, ending_of
from lsvib.engine.motion import follow
from lsvib.errors import EngineError, InputError
from lsvib.models import friction
from lsvib.models.drive import Drive
from lsvib.models.many import ManyDrives
from lsvib.models.model import automaton_of, model_of

KINDS = (Drive, threads_drive, support_drive, nut_drive)
MILD = {  # of drives of the chapter's size
    "mass": uniform(1, 8),
    "axial_force": signed(uniform(5, 80)),
    "support_damping": power(-5, -2.5),
    "translation_damping": one_of(0.0, 20.0),
    "input_speed": signed(uniform(5, 40)),
    "static_friction_coefficient": one_of(0.0, 0.0, 0.36),
}
OWN = {
    threads_drive: {"contact_stiffness": power(4, 6), "contact_damping": power(1, 2)},
    support_drive: {
        "screw_mass": power(-1, 1), "support_stiffness": power(4, 7), "axial_support_damping": uniform(1, 100),
        "bearing_friction": one_of(0.0, 0.02),
    },
    nut_drive: {
        "nut_inertia": power(-5.5, -4.5), "nut_stiffness": power(-1, 1.5), "nut_damping": power(-5, -3),
        "slide_friction": one_of(0.0, 3.0),
    },
}  # fmt: skip


def mild(kind, rng):
    """Parameters of a random drive, and a start."""
    values, own = drawn(rng, MILD), {part: drawn(rng, draws) for part, draws in OWN.items()}
    return values | own.get(kind, {}), {"u": rng.uniform(-1, 1), "w": rng.uniform(-2, 2) * values["input_speed"]}


def random_law(rng):
    """A fall, a rise or a mixture of both."""
    rise = drawn(rng, stribeck_rise=uniform(0, 0.1), stribeck_speed=power(-2.3, -0.5), stribeck_exponent=one_of(1, 2))
    slope = drawn(rng, friction_slope=uniform(-0.5, 0.3))
    return [rise, slope, rise | slope][rng.integers(3)]


def made(drive):
    return model_of(drive), automaton_of(drive)


@pytest.mark.parametrize("kind", KINDS)
def test_a_rise_of_nothing_changes_nothing(kind):
    """Events, times, states and observables of 20 random drives to 1e-12, passages left out."""
    events = 0
    for seed in range(20):
        values, start = mild(kind, np.random.default_rng([seed, 1]))
        drive = kind(**values)
        model, plain = made(drive)
        _, law = made(kind(**values, stribeck_rise=1e-300, stribeck_speed=0.01))
        motion = follow(plain, model.initial_state(drive, start), 0.05, max_events=30)
        end = motion.end_time if motion.time.size < 30 else motion.time[-2:].mean()
        other = follow(law, motion.start_state, end)
        known, found = motion.time < end, other.kind != model.events["PASSAGE"]
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
        events += known.sum()
    assert events > 100


@pytest.mark.parametrize("kind", KINDS[1:])
@pytest.mark.parametrize("seeds", [range(12), pytest.param(range(12, 60), marks=pytest.mark.slow)], ids=["few", "many"])
def test_motions_obey_newtons_laws(kind, seeds):
    """Arcs of random drives under random laws are those of an integration of Newton's laws, with N.

    To 2e-10: some slips are so unstable that they make 1e-10 of a rounding, in the engine and in what it is held
    against; nearly all arcs agree to 1e-12.
    """
    arcs, kinds, refused = 0, set(), 0
    for seed in seeds:
        rng = np.random.default_rng([seed, 2])
        values, start = mild(kind, rng)
        drive = kind(**values | random_law(rng))
        try:
            motion, _ = held_against_newton(drive, model_of(drive).initial_state(drive, start), 0.03, 8, 2e-10)
        except (InputError, EngineError):  # friction reaches the limit of the Painlevé region
            refused += 1
            continue
        kinds |= set(motion.kind.tolist())
        arcs += int((motion.arcs()[3] > 1e-9).sum())
    assert arcs > 4 * len(seeds)
    assert len(kinds) >= 4
    assert refused <= 0.4 * len(seeds)


@pytest.mark.parametrize("kind", KINDS)
def test_energy_of_cycles_under_a_law(kind):
    """What motor and load put in, friction, dampers and impacts take out, of cycles of random drives.

    To rounding; of those that jam, where the force grows without bound, to the distance at which the engine stops.
    """
    cycles = 0
    for seed in range(20):
        rng = np.random.default_rng([seed, 2])
        values, start = mild(kind, rng)
        drive = kind(**values | random_law(rng))
        try:
            model, automaton = made(drive)
            orbit = steady_state(automaton, model.initial_state(drive, start), max_events=20_000).orbit
        except InputError:
            continue
        if orbit is not None and orbit.time.size:
            seizes = np.isin(orbit.kind, automaton.sprag_kinds).any()
            assert abs(work(drive, orbit).balance) <= (3e-9 if seizes else 1e-13)
            cycles += 1
    assert cycles >= 6


@pytest.mark.parametrize(("kind", "name"), [(support_drive, "slide_friction"), (nut_drive, "bearing_friction")])
def test_what_a_law_does_not_go_with_is_refused(kind, name):
    law = {"stribeck_rise": 0.05, "stribeck_speed": 0.1}
    with pytest.raises(InputError, match=f"{name} = 0.01 is not followed where friction of"):
        made(kind(mass=2, **{name: 0.01}, **law))


@pytest.mark.parametrize("kind", [support_drive, nut_drive])
def test_seizures_under_a_law(kind):
    """In the Painlevé region at all speeds the threads seize, and slip begins with the friction of slow sliding."""
    heavy = {"mass": 40.0} | ({"screw_mass": 40.0} if kind is support_drive else {})
    drive = kind(**heavy, axial_force=-50, stribeck_rise=0.1, stribeck_speed=0.1)
    model, automaton = made(drive)
    assert {int(code) for code in automaton.codes} <= {int(m) for m in model.modes if "FORWARD_POS" not in m.name}
    motion = follow(automaton, model.initial_state(drive, {"u": 1.0, "w": 10.0}), 0.05)
    assert (motion.kind == model.events["SEIZURE"]).any()


@pytest.mark.parametrize("kind", [Drive, threads_drive])
def test_a_sweep_makes_drives_with_a_law_one_by_one(kind):
    """Drives with and without a law in one sweep end as each alone; tables of many hold to 1e-12, not to the bit."""
    law = {"stribeck_rise": 0.06, "stribeck_speed": 0.05}
    laws = [{}, law, {"friction_slope": -0.05}, {"static_friction_coefficient": 0.3}, law | {"stribeck_exponent": 2}]
    own = {"support_damping": 2e-3, "axial_force": 40}
    if kind is threads_drive:
        own |= {"contact_stiffness": 1e6, "contact_damping": 100}
    drives = [kind(mass=mass, **own, **law) for law in laws for mass in (1, 3)]
    many = ManyDrives(
        {
            name: [getattr(drive, name) for drive in drives]
            for name in Drive.model_fields
            if name in dict(drives[0]) or name in friction.NAMES
        }
    )
    starts = np.tile([0.05, -20.0], (len(drives), 1))
    found, model = all_endings(many, starts), model_of(drives[0])
    for place, drive in enumerate(drives):
        alone = ending_of(drive, automaton_of(drive), model.initial_state(drive, {"u": 0.05, "w": -20.0}))
        one = [column[place] for column in found]
        assert one[:2] == list(alone[:2])
        np.testing.assert_allclose(one[2:], alone[2:], rtol=1e-9)
    assert Attractor.UNRESOLVED not in found.attractor
