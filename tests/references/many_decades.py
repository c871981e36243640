"""Random drives of every model over many decades, some marginal: no damping, μ next to tan λ, Γ_0 or C_0 next to 0."""

import math

import numpy as np

from lsvib.drives.parameters import (
    NutParameters,
    RigidParameters,
    SupportParameters,
    ThreadsParameters,
    may_vanish,
    zero_if_close,
)

KINDS = {"rigid": RigidParameters, "threads": ThreadsParameters, "support": SupportParameters, "nut": NutParameters}

_DECADES = {
    "pitch_radius": (-3, math.log10(0.05)),
    "screw_inertia": (-9, 1),
    "coupling_stiffness": (-3, 6),
    "mass": (-2, 4),
    "input_speed": (-2, 4),
    "axial_force": (-3, 6),
    "support_damping": (-9, 2),
    "translation_damping": (-4, 6),
    "contact_stiffness": (2, 13),
    "contact_damping": (-4, 10),
    "screw_mass": (-2, 4),
    "support_stiffness": (0, 12),
    "axial_support_damping": (-4, 8),
    "nut_inertia": (-9, 1),
    "nut_stiffness": (-3, 6),
    "nut_damping": (-9, 2),
    "slide_friction": (-3, 6),
    "bearing_friction": (-3, 6),
}
_SOMETIMES_ZERO = {
    "axial_force": 0.1,
    "support_damping": 0.25,
    "translation_damping": 0.25,
    "contact_damping": 0.25,
    "axial_support_damping": 0.25,
    "nut_damping": 0.25,
    "slide_friction": 0.7,
    "bearing_friction": 0.7,
}
_DAMPINGS = ("support_damping", "translation_damping", "contact_damping", "axial_support_damping", "nut_damping")


def wide_drive(model: str, random: np.random.Generator) -> RigidParameters:
    """Draw a drive: pitch radius 1–50 mm, lead 0.5–45°, μ 0.001–0.9, all else over five to fourteen decades."""
    kind = KINDS[model]
    values = {}
    for key in (key for key in _DECADES if key in kind.model_fields):
        zero = random.random() < _SOMETIMES_ZERO.get(key, 0)
        values[key] = 0.0 if zero else 10 ** random.uniform(*_DECADES[key])
    values["input_speed"] *= random.choice([-1, 1])
    values["axial_force"] *= random.choice([-1, 1])
    lead = values["lead_angle"] = math.radians(random.uniform(0.5, 45.0))
    values["friction_coefficient"] = random.uniform(0.001, min(0.9, 0.999 / math.tan(lead)))
    case = random.random()
    if case < 0.1:
        values |= {key: 0.0 for key in _DAMPINGS if key in values}
    elif case < 0.2:  # only one damping is left
        kept = random.choice([key for key in _DAMPINGS if key in values])
        values |= {key: 0.0 for key in _DAMPINGS if key in values and key != kept}
    elif case < 0.3:
        values["friction_coefficient"] = _beside(math.tan(lead), random)
    elif case < 0.5:
        tangent, friction = math.tan(lead), values["friction_coefficient"]
        factor = (friction - tangent) / (1 + friction * tangent)
        lever = factor * tangent * values["pitch_radius"] ** 2
        key, own = [("mass", "screw_inertia"), ("translation_damping", "support_damping")][random.integers(2)]
        if lever > 0 and values[own] > 0:
            values[key] = min(max(_beside(values[own] / lever, random), 1e-12), 1e9)
    elif case < 0.8:
        _towards_instability(values, random)
    if model == "nut" and random.random() < 0.15:  # two equal bodies: a mode in which the contact plays no part
        values["nut_inertia"], values["nut_stiffness"] = values["screw_inertia"], values["coupling_stiffness"]
        if random.random() < 0.5:
            values["nut_damping"] = values["support_damping"]
    if random.random() < 0.1 and "slide_friction" in values:  # friction that balances the force
        values["slide_friction"] = abs(values["axial_force"])
    return kind.of(values)


def extreme_values(kind: type[RigidParameters], random: np.random.Generator) -> dict[str, float]:
    """Draw parameters over the whole accepted range, some of them at its ends."""
    values = {}
    for key, schema in kind.model_json_schema()["properties"].items():
        if key in ("lead_angle", "friction_coefficient"):
            continue
        lowest, highest = schema.get("anyOf", [schema])[-1]["minimum"], schema["maximum"]
        value = 10 ** random.uniform(math.log10(lowest), math.log10(highest))
        if random.random() < 0.1:
            value = random.choice([highest, lowest])
        vanishes = may_vanish(kind, key) and random.random() < 0.3
        values[key] = 0.0 if vanishes else min(max(float(value), lowest), highest)
    values["input_speed"] *= random.choice([-1, 1])
    values["axial_force"] *= random.choice([-1, 1])
    lead = values["lead_angle"] = random.choice([10 ** random.uniform(-6, 0.19), 1e-6, math.nextafter(math.pi / 2, 0)])
    limit = 1 / math.tan(lead)
    values["friction_coefficient"] = random.choice(
        [limit * random.random(), math.nextafter(limit, 0), 0.0, min(math.tan(lead), 0.99 * limit)]
    )
    values["friction_coefficient"] = zero_if_close(kind, "friction_coefficient", values["friction_coefficient"])
    return values


def _towards_instability(values: dict[str, float], random: np.random.Generator) -> None:
    """Self-locking threads, a force with the motion, and effective inertia and damping of either sign."""
    tangent = math.tan(values["lead_angle"])
    highest = min(0.9, 0.99 / tangent)
    if tangent > highest:
        return
    friction = values["friction_coefficient"] = random.uniform(tangent, highest)
    radius = values["pitch_radius"]
    lever = (friction - tangent) / (1 + friction * tangent) * tangent * radius**2
    values["mass"] = min(values["screw_inertia"] / lever * 10 ** random.uniform(-1, 0.3), 1e8)
    values["translation_damping"] = random.choice(
        [0.0, values["support_damping"] / lever * 10 ** random.uniform(-2, 1)]
    )
    values["translation_damping"] = min(values["translation_damping"], 1e12)
    drag = radius * tangent * values["translation_damping"] * abs(values["input_speed"])
    force = min(max(abs(values["axial_force"]), 2 * drag, 1e-3), 1e11)
    values["axial_force"] = math.copysign(force, values["input_speed"])


def _beside(value: float, random: np.random.Generator) -> float:
    """A double next to a value, or the value."""
    return [value, math.nextafter(value, math.inf), math.nextafter(value, 0)][random.integers(3)]
