"""From the entries of a data sheet to the parameters of a drive: floats, complex numbers or arrays (docs/assess.md)."""

import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.assess.materials import SCREW_MATERIALS
from lsvib.assess.sheet import Sheet
from lsvib.models import friction
from lsvib.models.drive import PARTS
from lsvib.models.mechanics import friction_factor

GRAVITY = 9.80665  # m/s², standard
Values = Mapping[str, Any]  # entries of a sheet or quantities of a drive by name: floats, or arrays that broadcast
Corner = tuple[int, Any, Any]  # a point of operation: direction of travel ±1, speed of the screw [rad/s], force [N]
Parts = tuple[str, ...]  # of a drive, which comply

# What the verdict depends on: name in words and unit. Values of these names are floats or arrays that broadcast.
QUANTITIES = {
    "lead": ("lead of the thread", "m"),
    "pitch_diameter": ("pitch diameter of the thread", "m"),
    "half_angle": ("half angle of the thread", "rad"),
    "friction": ("friction of the threads", "1"),
    "friction_slope": ("slope of friction over the sliding speed", "s m-1"),
    "stribeck_rise": ("rise of friction towards slow sliding", "1"),
    "stribeck_speed": ("sliding speed over which the rise of friction fades", "m s-1"),
    "static_friction": ("friction of the threads at rest", "1"),
    "inertia": ("rotating inertia", "kg m2"),
    "coupling_stiffness": ("stiffness of the coupling", "N m rad-1"),
    "rotational_damping": ("rotational damping of the screw", "N m s rad-1"),
    "translational_damping": ("damping of the load's travel", "N s m-1"),
    "mass": ("moved mass", "kg"),
    "tilt": ("angle of the axis above the horizontal", "rad"),
    "force_low": ("smallest force against outward travel", "N"),
    "force_high": ("largest force against outward travel", "N"),
    "speed_low": ("smallest speed of the screw", "rad s-1"),
    "speed_high": ("largest speed of the screw", "rad s-1"),
    "bearing_torque": ("friction torque of the bearing", "N m"),
    "collar_friction": ("friction of the thrust collar", "1"),
    "collar_diameter": ("mean diameter of the thrust collar", "m"),
    "guide_friction": ("friction of the guide", "N"),
    "motor_inertia": ("inertia of the motor, at the screw", "kg m2"),
    "integral_gain": ("stiffness of the motor's control, at the screw", "N m rad-1"),
    "speed_gain": ("damping of the motor's control, at the screw", "N m s rad-1"),
    "coupling_damping": ("damping of the coupling", "N m s rad-1"),
    "contact_stiffness": ("stiffness of the thread contact", "N m-1"),
    "contact_damping": ("damping of the thread contact", "N s m-1"),
    "support_stiffness": ("stiffness of the axial support", "N m-1"),
    "support_damping": ("damping of the axial support", "N s m-1"),
    "screw_mass": ("mass of the screw", "kg"),
}
# The same of the sides of the operating window, whose ends are changed together.
WINDOW = {"force": ("force on the load", "N"), "speed": ("speed", "rad s-1")}
UNITS = {key: unit for key, (_, unit) in (QUANTITIES | WINDOW).items()}
IN_WORDS = {key: words for key, (words, _) in (QUANTITIES | WINDOW).items()}

_ONLY_IF_GIVEN = {  # entries of a law of friction, of bearing, collar and guide
    "bearing_torque": "bearing.torque",
    "collar_friction": "bearing.collar.coefficient",
    "collar_diameter": "bearing.collar.mean_diameter",
    "guide_friction": "guide.friction",
    "stribeck_rise": "friction.stribeck_rise",
    "stribeck_speed": "friction.stribeck_speed",
    "static_friction": "friction.static",
}


def nominal_draw(sheet: Sheet) -> dict[str, float]:
    """Return the entries of a sheet, each at the value in its middle."""
    return {path: entry.nominal for path, entry in sheet.spreads.items()}


def random_entries(sheet: Sheet) -> list[str]:
    """Return the entries that are uncertain: all but ranges of force and speed, which are the operating window."""
    return [path for path, entry in sheet.spreads.items() if entry.uncertain and not is_window(sheet, path)]


def is_window(sheet: Sheet, path: str) -> bool:
    """Whether an entry is a side of the operating window: a range of force or speed, all of which is used."""
    entry = sheet.spreads.get(path)
    return path in ("load.force", "operation.speed") and entry is not None and entry.kind == "uniform"


def quantities(sheet: Sheet, draw: Values) -> dict[str, Any]:
    """Return the quantities of :data:`QUANTITIES` from the entries (floats, or arrays of one shape) of a sheet.

    Quantities that the sheet does not give are zero, or absent for a contact, support or law of friction that it does
    not have.
    """
    lead, diameter, half_angle = thread_geometry(sheet, draw)
    angle = np.arctan(lead / (math.pi * diameter))
    inertia, screw_mass = _screw(sheet, draw, diameter)
    ratio = draw.get("coupling.gear_ratio", 1.0)
    found = {
        "lead": lead,
        "pitch_diameter": diameter,
        "half_angle": half_angle,
        "friction": _coefficient(sheet, draw, angle, half_angle),
        "friction_slope": draw.get("friction.slope", 0.0),
        "inertia": inertia + draw.get("coupling.inertia", 0.0),
        "coupling_stiffness": draw.get("coupling.stiffness", 0.0) * ratio**2,
        "rotational_damping": draw.get("damping.rotational", 0.0) + draw.get("bearing.viscous", 0.0),
        "translational_damping": draw.get("damping.translational", 0.0),
        "mass": draw.get("load.mass", 0.0),
        "tilt": draw.get("load.orientation", 0.0),
    }
    found |= {key: draw[path] for key, path in _ONLY_IF_GIVEN.items() if path in draw}
    for part, keys in (("contact", sheet.contact), ("support", sheet.support)):
        if keys is not None:
            found[f"{part}_stiffness"] = draw[f"{part}.stiffness"]
            found[f"{part}_damping"] = draw.get(f"{part}.damping", 0.0)
    if sheet.motor is not None:
        found |= _motor(sheet, draw, found["inertia"], ratio)
    if sheet.support is not None:
        found["screw_mass"] = screw_mass
    turns = 2 * math.pi / lead if sheet.operation.speed.unit == "m/s" else 1.0  # from the speed as given to rad/s
    for key, path, scale in (("force", "load.force", 1.0), ("speed", "operation.speed", turns)):
        if is_window(sheet, path):
            entry = sheet.spreads[path]
            found[f"{key}_low"], found[f"{key}_high"] = entry.low * scale, entry.high * scale
        else:
            found[f"{key}_low"] = found[f"{key}_high"] = draw.get(path, 0.0) * scale
    return found


def thread_geometry(sheet: Any, draw: Values) -> tuple[Any, Any, Any]:
    """Return lead [m], pitch diameter [m] and half angle [rad] from the entries of a sheet that has a ``thread``."""
    thread = sheet.thread
    if thread.size is not None:
        return thread.size.lead, thread.size.pitch_diameter, thread.size.half_angle
    half_angle = draw.get("thread.half_angle", 0.0)
    pitch = draw.get("thread.pitch")
    lead = draw.get("thread.lead", pitch * thread.starts if pitch is not None else None)
    if thread.pitch_diameter is not None:
        diameter = draw["thread.pitch_diameter"]
    else:
        diameter = draw["thread.nominal_diameter"] - 0.5 * (lead / thread.starts if pitch is None else pitch)
    if lead is None or thread.lead_angle is not None:
        lead = math.pi * diameter * np.tan(draw["thread.lead_angle"])
    return lead, diameter, half_angle


def _screw(sheet: Sheet, draw: Values, pitch_diameter: Any) -> tuple[Any, Any]:
    """Inertia [kg m²] and mass [kg] of the screw, a cylinder where they are not given."""
    screw = sheet.screw
    if screw.inertia is not None or screw.length is None:
        return draw.get("screw.inertia", 0.0), draw.get("screw.mass")
    density = draw.get("screw.density", SCREW_MATERIALS[screw.material or "steel"].density)
    diameter = draw.get("screw.diameter", pitch_diameter)
    mass = density * math.pi / 4 * diameter**2 * draw["screw.length"]
    return mass * diameter**2 / 8, draw.get("screw.mass", mass)


def _motor(sheet: Sheet, draw: Values, inertia: Any, ratio: Any) -> dict[str, Any]:
    """What a motor is on the side of the screw, whose ``inertia`` counts for the gains by bandwidth."""
    own, ratio = draw["motor.inertia"] * ratio**2, ratio**2
    damping, stiffness = draw.get("motor.speed_gain", 0.0) * ratio, draw.get("motor.integral_gain", 0.0) * ratio
    if "motor.bandwidth" in draw:
        rate = 2 * math.pi * draw["motor.bandwidth"]
        damping, stiffness = rate * (own + inertia), rate**2 * (own + inertia) / 4
    if "motor.holding_torque" in draw:
        stiffness = draw["motor.holding_torque"] * sheet.motor.steps_per_turn / 4 * ratio
    found = {"motor_inertia": own, "integral_gain": stiffness, "speed_gain": damping}
    return found | {"coupling_damping": draw.get("coupling.damping", 0.0) * ratio}


def _coefficient(sheet: Sheet, draw: Values, angle: Any, half_angle: Any) -> Any:
    """Friction coefficient of the flanks; with a curve, its mean over the curve's points stands for the middle."""
    if sheet.friction.coefficient is not None:
        return draw["friction.coefficient"]
    if sheet.friction.efficiency is not None:
        square = coefficient_from_efficiency(draw["friction.efficiency"], angle)
        return flank_coefficient(square, angle, half_angle)
    return float(np.mean(sheet.friction.curve.coefficients)) * draw.get("friction.curve_factor", 1.0)


def point(sheet: Sheet, values: Values, direction: int, speed: Any, force: Any) -> tuple[dict[str, Any], Any]:
    """Return the parameters of the rigid drive, and the slope μ′ of the square thread [s/m], at points of operation.

    ``direction`` of travel ±1, ``speed`` > 0 [rad/s], ``force`` against outward travel [N], to which the weight adds.
    """
    parameters = without_friction(values, direction, speed, force)
    radius, angle = parameters["pitch_radius"], parameters["lead_angle"]
    if sheet.friction.law:
        law = SimpleNamespace(**friction_law(sheet, values, angle))
        coefficient, slope = friction.unbounded(law, sliding_speed(speed, radius, angle))
        positive = np.real(coefficient) > 0
        parameters["friction_coefficient"] = np.where(positive, coefficient, 0.0)
        return parameters, np.where(positive, slope, 0.0)
    coefficient, slope = values["friction"], values["friction_slope"]
    if sheet.friction.curve is not None:
        mean = float(np.mean(sheet.friction.curve.coefficients))
        scale = coefficient / mean if mean > 0 else 1.0  # a curve that is zero throughout stays so, whatever the factor
        coefficient, slope = (scale * x for x in _along(sheet, sliding_speed(speed, radius, angle)))
    parameters["friction_coefficient"] = square_coefficient(coefficient, angle, values["half_angle"])
    return parameters, square_coefficient(slope, angle, values["half_angle"])


def friction_law(sheet: Sheet, values: Values, lead_angle: Any) -> dict[str, Any]:
    """Return the parameters of the friction law of the square thread (:mod:`lsvib.models.friction`)."""
    given = {
        "friction_coefficient": values["friction"],
        "static_friction_coefficient": values.get("static_friction", 0.0),
        "stribeck_rise": values.get("stribeck_rise", 0.0),
        "friction_slope": values["friction_slope"],
    }
    square = {key: square_coefficient(value, lead_angle, values["half_angle"]) for key, value in given.items()}
    fading = {"stribeck_speed": values.get("stribeck_speed", 0.0)}
    return square | fading | {"stribeck_exponent": sheet.friction.stribeck_exponent}


def without_friction(values: Values, direction: int, speed: Any, force: Any) -> dict[str, Any]:
    """Return the parameters of a point of operation but for friction, arguments as :func:`point`."""
    radius = 0.5 * values["pitch_diameter"]
    dry = {"bearing_friction": "bearing_torque", "slide_friction": "guide_friction"}
    rubs = {name: values[key] for name, key in dry.items() if key in values}
    if "collar_friction" in values:
        rubs |= {"collar_friction": values["collar_friction"], "collar_radius": 0.5 * values["collar_diameter"]}
    return rubs | {
        "pitch_radius": radius,
        "lead_angle": np.arctan(values["lead"] / (2 * math.pi * radius)),
        "screw_inertia": values["inertia"],
        "coupling_stiffness": values["coupling_stiffness"],
        "support_damping": values["rotational_damping"],
        "input_speed": direction * speed,
        "mass": values["mass"],
        "translation_damping": values["translational_damping"],
        "axial_force": -(force + weight_of(values)),
    }


def efficiencies(sheet: Sheet, values: Values) -> tuple[Any, Any]:
    """Return the lifting and the lowering efficiency [1] at the middle speed; below zero the latter is self-locking."""
    at, _ = point(sheet, values, 1, 0.5 * (values["speed_low"] + values["speed_high"]), 0.0)
    thread = at["friction_coefficient"], at["lead_angle"], collar_of(values)
    return lifting_efficiency(*thread), lowering_efficiency(*thread)


def _along(sheet: Sheet, sliding: Any) -> tuple[NDArray, NDArray]:
    """Coefficient and slope of the curve at sliding speeds [m/s]; constant beyond its ends."""
    curve = sheet.friction.curve
    real = np.real(sliding)
    speeds, coefficients = np.array(curve.speeds), np.array(curve.coefficients)
    slopes = np.concatenate([[0.0], np.diff(coefficients) / np.diff(speeds), [0.0]])
    piece = np.searchsorted(speeds, real, side="right")
    start = np.clip(piece - 1, 0, None)
    return coefficients[start] + slopes[piece] * (sliding - speeds[start]), slopes[piece]


def own_parameters(values: Values, parts: Parts) -> dict[str, Any]:
    """Return the parameters that parts of a drive add to those of the rigid one."""
    found = {key: values[key.removeprefix("axial_")] for part in parts for key in PARTS[part]}
    return found | ({"coupling_damping": values["coupling_damping"]} if "motor" in parts else {})


def square_coefficient(coefficient: Any, lead_angle: Any, half_angle: Any) -> Any:
    """Return the coefficient of the square thread that behaves alike, μ / cos α_n [1]; angles λ and α [rad]."""
    return coefficient * np.sqrt(1 + (np.cos(lead_angle) * np.tan(half_angle)) ** 2)


def flank_coefficient(coefficient: Any, lead_angle: Any, half_angle: Any) -> Any:
    """Return the coefficient of the flank [1] from that of the square thread, the inverse of the function above."""
    return coefficient / np.sqrt(1 + (np.cos(lead_angle) * np.tan(half_angle)) ** 2)


def collar_of(values: Values) -> Any:
    """Return μ_b r_b / r_m [1], by which a thrust collar adds to |ξ_s|; zero without one."""
    return values.get("collar_friction", 0.0) * values.get("collar_diameter", 0.0) / values["pitch_diameter"]


def weight_of(values: Values) -> Any:
    """Return the part of the weight along the axis [N], against outward travel."""
    return values["mass"] * GRAVITY * np.sin(values["tilt"])


def lifting_efficiency(coefficient: Any, lead_angle: Any, collar: Any = 0.0) -> Any:
    """Return η = tan λ / (tan(λ + arctan μ) + μ_b r_b / r_m) [1] of motion against the load.

    ``coefficient`` μ of the square thread, −ξ₋ = tan(λ + arctan μ); ``collar``: :func:`collar_of`.
    """
    tangent = np.tan(lead_angle)
    return -tangent / (friction_factor(coefficient, tangent, -1) - collar)


def lowering_efficiency(coefficient: Any, lead_angle: Any, collar: Any = 0.0) -> Any:
    """Return η = (tan(λ − arctan μ) − μ_b r_b / r_m) / tan λ [1] of motion with the load; negative if self-locking."""
    tangent = np.tan(lead_angle)
    return -(friction_factor(coefficient, tangent, 1) + collar) / tangent


def coefficient_from_efficiency(efficiency: Any, lead_angle: Any) -> Any:
    """Return the μ of the square thread at which the lifting efficiency is ``efficiency``, tan(arctan(t/η) − λ)."""
    tangent = np.tan(lead_angle)
    return tangent * (1 - efficiency) / (efficiency + tangent**2)


def sliding_speed(speed: Any, pitch_radius: Any, lead_angle: Any) -> Any:
    """Return the speed at which the threads slide, r_m Ω / cos λ [m/s]."""
    return pitch_radius * speed / np.cos(lead_angle)
