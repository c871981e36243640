"""Static friction in every dry contact at once: motions against a reference that finds modes and events by itself."""

from contextlib import suppress

import numpy as np
import pytest
from references.comparisons import balanced, by_newton, by_package, held
from references.drives import COLLAR, MOTOR, OWN, RISE, drawn, one_of, power, signed, times, uniform
from references.sizes import sizes

from lsvib import Drive
from lsvib.drives.automata import automaton_of
from lsvib.drives.model import model_of, standing_state
from lsvib.drives.names import Event
from lsvib.drives.scene import Command
from lsvib.errors import InputError

SLOW = {
    "mass": power(-0.5, 1.1), "coupling_stiffness": power(-0.5, 0.5), "support_damping": power(-4.5, -2.5),
    "translation_damping": times(one_of(0, 1), power(1, 3)), "axial_force": signed(power(0.5, 2)),
    "input_speed": times(one_of(0, 1, 1, 1), signed(power(-0.5, 1.2))), "friction_coefficient": uniform(0.1, 0.3),
}  # fmt: skip
DRY = {"slide_friction": power(-0.5, 1.3), "bearing_friction": power(-3, -1.5)}
STATIC = {name: name.replace("friction", "static_friction") for name in ("friction_coefficient", *DRY)}
KINDS = {event.name.lower() for event in Event} - {"graze", "accumulation", "passage"}


def random_contacts(seed: int) -> tuple[Drive, np.ndarray, Command | None]:
    """A slow drive, or one that is let go, a start and a command or none.

    With static friction in the threads, the slide and the bearing, mostly above that of sliding.
    """
    rng = np.random.default_rng([seed, 48])
    while True:
        values, has = drawn(rng, SLOW), {part: rng.random() < 0.5 for part in (*OWN, "motor")}
        for part, draws in (*OWN.items(), ("motor", MOTOR)):
            values |= drawn(rng, draws) if has[part] else {}
        values |= {name: draw(rng) for name, draw in DRY.items() if rng.random() < 0.8}
        own = {"slide_friction": has["support"] or has["threads"], "bearing_friction": has["nut"]}
        if not any(own[name] for name in DRY if name in values) and rng.random() < 0.5:
            values |= drawn(rng, RISE, friction_slope=uniform(-0.3, 0))
        if not any(has[part] for part in OWN) and rng.random() < 0.5:
            values |= drawn(rng, COLLAR)
        for name, most in STATIC.items():
            if name in values and rng.random() < 0.7:
                slow = values[name] + (values.get("stribeck_rise", 0) if "coefficient" in name else 0)
                values[most] = slow * rng.uniform(1.05, 1.8)
        with suppress(InputError):
            drive = Drive(**values)
            automaton_of(drive)
            start, command = start_of(drive, rng), None
            if drive.input_speed and rng.random() < 0.4:
                speeds = drive.input_speed * rng.choice([0.0, 0.3, 1.0, 1.5, -0.5], 4)
                command = Command(times=sorted(rng.uniform(0, 0.2, 4)), speeds=speeds.tolist())
            return drive, start, command


def start_of(drive: Drive, rng) -> np.ndarray:
    """Rest, or anywhere about it.

    A slide that holds no more at rest than in sliding has a little less to hold: else rounding would decide.
    """
    start = standing_state(drive)
    if drive.slide_friction and drive.slide_static_friction <= drive.slide_friction:
        for part, stiffness in (("support", drive.support_stiffness), ("threads", drive.contact_stiffness)):
            if part in drive.parts:
                start[2 + 2 * drive.parts.index(part)] += 0.02 * drive.axial_force / stiffness
    if drive.input_speed and rng.random() < 0.5:
        return start
    start[0] += rng.uniform(-0.3, 0.3)
    if rng.random() < 0.7:
        start[1] += rng.uniform(-2, 2) * (abs(drive.input_speed) + 1)
    return start


@pytest.mark.parametrize("seeds", sizes([[*range(10), 29]], [range(10, 40)], [range(40, 300)]), ids=len)
def test_modes_and_events_are_those_that_newtons_laws_allow(seeds):
    """Of drives with static friction in threads, guide and bearing, with any parts, commands and laws."""
    kinds, parts = [], set()
    for seed in seeds:
        drive, *motion = random_contacts(seed)
        kinds += held(drive, *motion, 0.25, most=24)
        parts.add(drive.parts)
    assert len(kinds) >= 10 * len(seeds)
    assert {*kinds} == KINDS
    assert len(parts) >= 7


@pytest.mark.parametrize("motion", [by_newton, by_package])
def test_a_guide_sticks_while_the_threads_rest(motion):
    """It stops before the threads slip again; the slip that then begins does not move it."""
    support = {"screw_mass": 1.0, "support_stiffness": 1e5, "axial_support_damping": 100.0}
    dry = {"slide_friction": 5.0, "static_friction_coefficient": 0.25}
    drive = Drive(input_speed=1.0, translation_damping=100.0, **support, **dry)
    start = model_of(drive).initial_state(drive, {"u": 0.0, "w": -1.0})
    _, events = motion(drive, start, None, 0.3, most=60)
    assert [event.kind for event in events[:4]] == ["release", "stick", "slide_stick", "release"]
    np.testing.assert_allclose([event.time for event in events[2:4]], [0.024393696537, 0.026524850249], atol=1e-12)
    assert events[-1].state[0] == pytest.approx(-0.00736043, abs=5e-9)


def test_energy_of_cycles_balances():
    assert len(balanced(range(6, 21), lambda seed: random_contacts(seed)[:2])) >= 6
