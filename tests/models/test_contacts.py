"""Static friction in every dry contact at once: motions against a reference that finds modes and events by itself."""

from contextlib import suppress
from itertools import zip_longest

import numpy as np
import pytest
from models.test_parts import MOTOR, OWN
from references.contacts import Contacts, Happening
from references.drives import drawn, one_of, power, signed, times, uniform
from references.sizes import sizes

from lsvib.engine.motion import Motion, follow
from lsvib.errors import InputError
from lsvib.models.command import Command
from lsvib.models.drive import Drive
from lsvib.models.mechanics import friction_factor
from lsvib.models.mechanism import standing_state
from lsvib.models.model import model_of
from lsvib.models.names import Event

SLOW = {
    "mass": power(-0.5, 1.1), "coupling_stiffness": power(-0.5, 0.5), "support_damping": power(-4.5, -2.5),
    "translation_damping": times(one_of(0, 1), power(1, 3)), "axial_force": signed(power(0.5, 2)),
    "input_speed": times(one_of(0, 1, 1, 1), signed(power(-0.5, 1.2))), "friction_coefficient": uniform(0.1, 0.3),
}  # fmt: skip
DRY = {"slide_friction": power(-0.5, 1.3), "bearing_friction": power(-3, -1.5)}
COLLAR = {"collar_friction": uniform(0.05, 0.3), "collar_radius": power(-2.6, -1.9)}
LAW = {"stribeck_rise": uniform(0, 0.1), "stribeck_speed": power(-2.3, -0.5), "stribeck_exponent": one_of(1, 2)}
SAME = 1e-13  # part of the time by which events at one instant differ


def random_contacts(seed: int) -> tuple[Drive, np.ndarray, Command | None]:
    """A slow drive, or one that is let go, a start and a command or none.

    With static friction in the threads, the slide and the bearing, mostly above that of sliding. Without seizures.
    """
    rng = np.random.default_rng([seed, 48])
    while True:
        values, has = drawn(rng, SLOW), {part: rng.random() < 0.5 for part in (*OWN, "motor")}
        for part, draws in (*OWN.items(), ("motor", MOTOR)):
            values |= drawn(rng, draws) if has[part] else {}
        values |= {name: draw(rng) for name, draw in DRY.items() if rng.random() < 0.8}
        own = {"slide_friction": has["support"] or has["threads"], "bearing_friction": has["nut"]}
        if not any(own[name] for name in DRY if name in values) and rng.random() < 0.5:
            values |= drawn(rng, LAW, friction_slope=uniform(-0.3, 0))
        if not any(has[part] for part in OWN) and rng.random() < 0.5:
            values |= drawn(rng, COLLAR)
        for name, most in (("friction_coefficient", "static_friction_coefficient"), *((x, static(x)) for x in DRY)):
            if name in values and rng.random() < 0.7:
                slow = values[name] + (values.get("stribeck_rise", 0) if "coefficient" in name else 0)
                values[most] = slow * rng.uniform(1.05, 1.8)
        with suppress(InputError):
            drive = without_seizure(Drive(**values))
            start = start_of(drive, rng)
            command = None
            if drive.input_speed and rng.random() < 0.4:
                speeds = drive.input_speed * rng.choice([0.0, 0.3, 1.0, 1.5, -0.5], 4)
                command = Command(times=sorted(rng.uniform(0, 0.2, 4)), speeds=speeds.tolist())
            return drive, start, command


def static(name: str) -> str:
    return name.replace("_friction", "_static_friction")


def without_seizure(drive: Drive) -> Drive:
    """The drive with less mass where rigid threads could seize, also while the slide holds."""
    if "threads" in drive.parts:
        return drive
    tan, radius, inertia = np.tan(drive.lead_angle), drive.pitch_radius, drive.screw_inertia
    inertia = 1 / (1 / inertia + 1 / drive.nut_inertia) if drive.nut_inertia else inertia
    factor = friction_factor(drive.friction_coefficient + drive.stribeck_rise, tan, 1)
    factor += drive.collar_friction * drive.collar_radius / radius
    limit = 0.8 * inertia / (factor * tan * radius**2) if factor > 0 else np.inf
    heavy = "screw_mass" if drive.screw_mass else "mass"
    return drive.replace(**{heavy: min(getattr(drive, heavy), limit)})


def start_of(drive: Drive, rng) -> np.ndarray:
    """Rest, or anywhere about it.

    There the slide holds a little less than it may, and the threads more than nothing: else rounding would decide.
    """
    start = standing_state(drive)
    for part, stiffness in (("support", drive.support_stiffness), ("threads", drive.contact_stiffness)):
        if part in drive.parts:
            start[2 + 2 * drive.parts.index(part)] += 0.02 * drive.axial_force / stiffness
    if drive.input_speed and rng.random() < 0.5:
        return start
    start[0] += rng.uniform(-0.3, 0.3)
    if rng.random() < 0.7:
        start[1] += rng.uniform(-2, 2) * (abs(drive.input_speed) + 1)
    return start
