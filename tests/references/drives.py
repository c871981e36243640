"""Drives of the tests: with a part, known ones, and random ones from distributions that are written here; seeded.

Wide ones are over the full ranges of their parameters. Those of catalogues have screws of 6–60 mm with leads of 1–25 mm
(at most 1.2 diameters) and 0.1–1.5 m of steel, friction 0.05–0.35, couplings and motors of the usual sizes for them,
dampings from nearly none to strong.
"""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from lsvib import Drive
from lsvib.drives import chapter
from lsvib.drives.drive import PART_OF, PARTS
from lsvib.drives.friction import NAMES
from lsvib.drives.mechanics import friction_factor
from lsvib.errors import InputError
from references.known import JERKING, NEAR_FOLD, NEGATIVE_DAMPING, PARADOX  # noqa: F401  (where tests look for drives)
from references.rigid_digits import RigidTrueDrive


@dataclass(frozen=True)
class Kind:
    """Makes the drives with one ``part``, or the rigid ones."""

    part: str

    def __call__(self, values: Drive | Mapping[str, Any] | None = None, /, **more: Any) -> Drive:
        return Drive.of({**chapter.PARTS.get(self.part, {}), **dict(values or {}), **more})

    of = __call__

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(name for name in Drive.model_fields if PART_OF.get(name, self.part) == self.part)

    @property
    def damper(self) -> str:
        """Name of the damping that the part adds."""
        return PARTS[self.part][-1]

    @property
    def given(self) -> tuple[str, ...]:
        """The part in the words of a command."""
        values = chapter.PARTS.get(self.part, {})
        return tuple(word for name, value in values.items() for word in ("--set", f"{name}={value!r}"))


DRIVES = {name: Kind(name) for name in ("rigid", "threads", "support", "nut")}
rigid_drive, threads_drive, support_drive, nut_drive = DRIVES.values()
GIVEN = {name: kind.given for name, kind in DRIVES.items()}


Draw = Callable[[np.random.Generator], float]


def uniform(low: float, high: float) -> Draw:
    return lambda rng: float(rng.uniform(low, high))


def power(low: float, high: float) -> Draw:
    """A number whose decimal logarithm lies between two ends."""
    return lambda rng: float(10 ** rng.uniform(low, high))


def about(value: float, factor: float = 2.0) -> Draw:
    """A number up to a factor away from a value."""
    return lambda rng: float(value * factor ** rng.uniform(-1, 1))


def one_of(*values: float) -> Draw:
    return lambda rng: float(rng.choice(values))


def times(*draws: Draw) -> Draw:
    return lambda rng: math.prod(draw(rng) for draw in draws)


def signed(draw: Draw) -> Draw:
    return times(one_of(-1, 1), draw)


def drawn(
    rng: np.random.Generator, draws: Mapping[str, Draw | float] | None = None, /, **more: Any
) -> dict[str, float]:
    """Values by name: what is drawn, in its order, and what is given as a number."""
    return {name: draw(rng) if callable(draw) else draw for name, draw in {**(draws or {}), **more}.items()}


LIKE_TABLE_8_1 = {
    "pitch_radius": about(5.18e-3),
    "lead_angle": about(0.0972),
    "screw_inertia": about(3.12e-6),
    "friction_coefficient": about(0.218),
}
LIKE_PARTS = {  # of the chapter, of each kind of drive
    "rigid": {},
    "threads": {"contact_stiffness": about(1e7, 10.0), "contact_damping": about(1e4, 10.0)},
    "support": {
        "screw_mass": about(10.0), "support_stiffness": about(1e5), "axial_support_damping": about(100.0),
        "slide_friction": times(about(2.0), one_of(0, 1)),
    },
    "nut": {
        "nut_inertia": about(3e-6), "nut_stiffness": about(1.0), "nut_damping": about(2e-4),
        "slide_friction": times(about(2.0), one_of(0, 1)),
    },
}  # fmt: skip


def about_the_critical_mass(rng: np.random.Generator) -> float:
    """A mass [kg] like the chapter's, one in ten next to the critical one."""
    return rng.uniform(0.5, 30.0) if rng.random() < 0.9 else rng.uniform(10.0, 10.2)


def random_drive(rng: np.random.Generator, mass: Draw = about_the_critical_mass, **fixed: float) -> Drive:
    """A drive on either side of Γ₊ = 0, damped in at least one place, loaded, turning either way.

    Left out, because there rounding alone decides what happens: c = c_x = 0 (the orbit that is released from rest
    touches θ′ = 0 again after every turn, without crossing it) and R = 0 (the band of rest torques has no width and
    its one state is the corner θ′ = 0, Q = 0).
    """
    support, translation = ((1, 0), (0, 1), (1, 1))[rng.integers(3)]
    values = drawn(
        rng, mass=mass, friction_coefficient=uniform(0.05, 0.5), axial_force=signed(power(0.0, 2.3)),
        input_speed=signed(uniform(5.0, 80.0)), support_damping=times(power(-4.5, -2.0), lambda _: support),
        translation_damping=times(uniform(50.0, 2000.0), lambda _: translation),
    )  # fmt: skip
    return Drive.of(values | fixed)


def random_start(rng: np.random.Generator) -> tuple[float, float]:
    """A state (u [rad], w [rad/s]) on either side of θ′ = 0 and Q = 0."""
    return rng.uniform(-0.4, 0.4), rng.uniform(-200.0, 200.0)


MODELS = ("rigid", "threads", "support", "nut")
_ZERO_DAMPING = 0.25  # share of drives without a damping
_ZERO_FORCE = 0.1  # share of drives without an axial force
_PLACES = ("anywhere", "anywhere", "anywhere", "speed", "contact", "corner", "near", "equilibrium")


class WideDrive(NamedTuple):
    """A drive, the frictions of a second body that it has, and starts of motions (starts, states)."""

    drive: Drive
    physics: tuple[str, ...]
    starts: np.ndarray


def wide_drive(model: str, seed: int, index: int, starts: int) -> WideDrive:
    """Draw drive ``index`` of a seed, the same whatever else is drawn, and so many starts of it."""
    rng = np.random.default_rng([seed, MODELS.index(model), index])
    values = rigid_values(rng)
    drive, physics = (Drive.of(values), ()) if model == "rigid" else _with_part(rng, model, values)
    return WideDrive(drive, physics, _states(rng, drive, starts))


def sign(rng) -> int:
    return int(rng.choice((-1, 1)))


def decades(rng, low: float, high: float) -> float:
    return 10.0 ** rng.uniform(low, high)


def _zero_or(share: float, low: float, high: float) -> Draw:
    """Zero in a share of all draws, else a number whose decimal logarithm is uniform between two bounds."""
    return lambda rng: 0.0 if rng.random() < share else decades(rng, low, high)


def heaviest(values: dict[str, float], inertia: float) -> float:
    """Mass [kg] above which the threads could seize with a given inertia [kg m²], infinite if they never do."""
    tan = math.tan(values["lead_angle"])
    factor = friction_factor(values["friction_coefficient"], tan, 1)
    return inertia / (factor * tan * values["pitch_radius"] ** 2) if factor > 0 else math.inf


def rigid_values(rng: np.random.Generator) -> dict[str, float]:
    """Draw the parameters of a rigid drive over decades; dampings and axial force are zero in a share of the drives."""
    lead = math.radians(decades(rng, math.log10(0.5), math.log10(45.0)))
    friction = decades(rng, -3, math.log10(0.9)) if rng.random() < 0.5 else rng.uniform(0.001, 0.9)
    force = sign(rng) * _zero_or(_ZERO_FORCE, -3, 6)(rng)
    return drawn(
        rng, pitch_radius=power(-3, math.log10(0.05)), lead_angle=lead,
        friction_coefficient=min(friction, 0.999 / math.tan(lead)), mass=power(-2, 4), screw_inertia=power(-9, 1),
        coupling_stiffness=power(-3, 6), support_damping=_zero_or(_ZERO_DAMPING, -9, 2),
        translation_damping=_zero_or(_ZERO_DAMPING, -4, 6), axial_force=force, input_speed=signed(power(-2, 4)),
    )  # fmt: skip


_OTHERS = {
    "threads": {"contact_stiffness": power(3, 12), "contact_damping": _zero_or(_ZERO_DAMPING, -2, 9)},
    "support": {
        "screw_mass": power(-2, 4), "support_stiffness": power(2, 10),
        "axial_support_damping": _zero_or(_ZERO_DAMPING, -2, 8),
    },
    "nut": {
        "nut_inertia": power(-9, 1), "nut_stiffness": power(-3, 6), "nut_damping": _zero_or(_ZERO_DAMPING, -9, 2),
    },
}  # fmt: skip


def _with_part(rng, model: str, values: dict[str, float]) -> tuple[Drive, tuple[str, ...]]:
    """A drive with a part and its frictions; only up to some mass is the motion with them determined."""
    values |= drawn(rng, _OTHERS[model])
    physics = _frictions(rng, values) if model != "threads" else ()
    if model == "support" and "slide_friction" in physics:
        share = decades(rng, -3, -0.01)
        values["screw_mass"] = min(values["screw_mass"], share * heaviest(values, values["screw_inertia"]))
    elif model == "nut" and "bearing_friction" in physics:
        inertia = 1 / (1 / values["screw_inertia"] + 1 / values["nut_inertia"])
        values["mass"] = min(values["mass"], decades(rng, -3, -0.01) * heaviest(values, inertia))
    return DRIVES[model](values), physics


def _frictions(rng, values: dict[str, float]) -> tuple[str, ...]:
    size = abs(values["axial_force"]) or 1.0
    physics = []
    for name, unit in (("slide_friction", size), ("bearing_friction", size * values["pitch_radius"])):
        if rng.random() < 0.5:
            physics.append(name)
            values[name] = unit * decades(rng, -3, 1)
    return tuple(physics)


def sizes_of(drive: Drive) -> tuple[float, ...]:
    """Sizes of the coordinates of a drive; those of speeds have the sign of the input."""
    speed, size = drive.input_speed, abs(drive.input_speed) * (drive.screw_inertia / drive.coupling_stiffness) ** 0.5
    if drive.rigid:
        return float(RigidTrueDrive(dict(drive), 30).u_scale), speed
    if drive.parts == ("nut",):
        return size, speed, size, speed
    place = (abs(drive.axial_force) or 1.0) / (drive.contact_stiffness or drive.support_stiffness)
    return size, speed, place, drive.pitch_radius * math.tan(drive.lead_angle) * speed


def _states(rng, drive: Drive, count: int) -> np.ndarray:
    """Starts over four decades, some on θ′ = 0, N = 0, with the second body at rest, near the equilibrium or on it."""
    sizes = sizes_of(drive)
    found = np.empty((count, len(sizes)))
    for k in range(count):
        found[k] = [sign(rng) * x * decades(rng, -2, 2) for x in sizes]
        where = _PLACES[rng.integers(len(_PLACES))]
        if where in ("speed", "corner"):
            found[k, 1] = -drive.input_speed
        if where in ("contact", "corner") and drive.rigid:
            q_u, q_w, q_0 = (float(x) for x in RigidTrueDrive(dict(drive), 30).Q_terms(1, 1))
            found[k, 0] = -(q_0 + q_w * found[k, 1]) / q_u
        elif where in ("contact", "corner"):
            found[k, 3] = 0.0
        found[k] *= {"near": 1e-8, "equilibrium": 0.0}.get(where, 1.0)
    return found


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


def drive_with_parts(seed: int, collar: bool = False, motor: bool = False) -> tuple[Drive, np.ndarray]:
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
        if key in dry and not (bodies & {*parts} and law.keys() & NAMES[1:]):
            values[key] = dry[key]
    drive = Drive(**values)
    start = np.zeros(2 + 2 * len(drive.parts))
    start[:2] = rng.uniform(-0.2, 0.2), rng.uniform(-2, 2) * drive.input_speed
    return drive, start


def drive_with_law(model: str, rng: np.random.Generator):
    """A drive about as large as the chapter's, with a law of friction that matters at its speed."""
    values = drawn(
        rng, LIKE_TABLE_8_1, input_speed=times(about(10.0, 8.0), one_of(-1, 1)),
        support_damping=times(about(2e-4), one_of(0, 1, 2, 3)), mass=about(3.0),
        axial_force=times(about(40.0), one_of(-1, 1)), translation_damping=times(about(20.0), one_of(0, 1)),
    )  # fmt: skip
    own = {name: drawn(rng, draws) for name, draws in LIKE_PARTS.items()}[model]
    speed = values["pitch_radius"] * abs(values["input_speed"])
    law = drawn(rng, friction_slope=times(about(0.02 / speed), one_of(-1.0, 0.5)))
    if rng.random() < 0.8:
        law |= drawn(rng, stribeck_rise=about(0.05), stribeck_speed=about(speed), stribeck_exponent=one_of(1, 2))
    return DRIVES[model].of(values | own | law)


def law_starts(seeds):
    """Rigid drives with a friction law whose speeds and coefficients matter, with a start of each.

    But for those whose friction of steady sliding is beyond cot λ.
    """
    for seed in seeds:
        rng = np.random.default_rng([20261126, seed])
        speed = rng.choice([-1, 1]) * rng.uniform(2.0, 60.0)
        sliding = Drive().pitch_radius * abs(speed) / math.cos(Drive().lead_angle)
        friction = rng.uniform(0.05, 0.3)
        rise = rng.uniform(0.01, 0.25) if rng.random() < 0.8 else 0.0
        sign = rng.choice([-1, 0, 1]) if rise else rng.choice([-1, 1])
        values = {
            "friction_coefficient": friction,
            "stribeck_rise": rise,
            "stribeck_speed": sliding * 10 ** rng.uniform(-1.5, 0.7) if rise else 0.0,
            "stribeck_exponent": int(rng.choice([1, 2])) if rise else 1,
            "friction_slope": float(sign * friction * 10 ** rng.uniform(-2.5, -0.3) / sliding),
            "static_friction_coefficient": (friction + rise) * rng.uniform(1.0, 1.5) if rng.random() < 0.5 else 0.0,
            "mass": rng.uniform(0.5, 30.0),
            "support_damping": 10 ** rng.uniform(-4.5, -2.0) if rng.random() < 0.7 else 0.0,
            "translation_damping": rng.uniform(20.0, 1000.0) if rng.random() < 0.5 else 0.0,
            "axial_force": rng.choice([-1, 1]) * 10 ** rng.uniform(0.0, 2.3),
        }
        with suppress(InputError):
            drive = Drive.of(**values, input_speed=speed)
            yield drive, (rng.uniform(-0.4, 0.4), rng.uniform(-2.0, 2.0) * abs(speed))


OFFERED = ("threads", "support", "nut")
_STEEL = 7850.0  # density [kg/m3]


def catalogue_drive(model: str, seed: int, index: int, starts: int = 4) -> tuple[Drive, np.ndarray]:
    """Draw drive ``index`` of a seed, the same whatever else is drawn, and so many starts of it (starts, 4)."""
    rng = np.random.default_rng([seed, OFFERED.index(model), index])

    def power(low: float, high: float) -> float:
        return float(math.exp(rng.uniform(math.log(low), math.log(high))))

    diameter, length = power(6e-3, 60e-3), power(0.1, 1.5)
    radius = 0.5 * (diameter - power(0.5e-3, 0.12 * diameter))
    lead = power(1e-3, min(25e-3, 1.2 * diameter))
    volume = math.pi / 4 * diameter**2 * length
    inertia = _STEEL * volume * diameter**2 / 8 * (1 + power(0.05, 1.0))
    stiffness = power(0.3, 30.0) * (diameter / 10e-3) ** 3 * 10
    mass = power(1.0, 200.0) * (diameter / 10e-3) ** 2
    values = {
        "pitch_radius": radius,
        "lead_angle": math.atan(lead / (2 * math.pi * radius)),
        "screw_inertia": inertia,
        "coupling_stiffness": stiffness,
        "support_damping": 2 * power(1e-4, 0.1) * math.sqrt(inertia * stiffness),
        "friction_coefficient": rng.uniform(0.05, 0.35),
        "input_speed": float(rng.choice([-1.0, 1.0])) * power(1.0, 150.0),
        "mass": mass,
        "translation_damping": float(rng.choice([0.0, 1.0])) * power(1.0, 500.0),
        "axial_force": float(rng.choice([-1.0, 1.0])) * power(0.2, 20.0) * mass,
    }
    drive = Drive.of({**values, **_offered(model, power, values, volume)})
    scales = np.abs(sizes_of(drive))
    factors = np.array([[power(0.05, 5.0) * rng.choice([-1.0, 1.0]) for _ in scales] for _ in range(starts)])
    return drive, scales * factors


def _offered(model, power, values, volume):
    if model == "nut":
        mass, stiffness = values["screw_inertia"] * power(0.1, 3.0), values["coupling_stiffness"] * power(0.3, 100.0)
    else:
        stiffness = power(*((2e7, 1e9) if model == "threads" else (1e7, 3e8)))
        mass = values["mass"] if model == "threads" else _STEEL * volume
    damping = 2 * power(*((5e-3, 0.5) if model == "threads" else (1e-3, 0.1))) * math.sqrt(stiffness * mass)
    return dict(zip(PARTS[model], (mass, stiffness, damping)[-len(PARTS[model]) :], strict=True))
