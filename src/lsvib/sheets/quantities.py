"""From the entries of a data sheet to the quantities of a drive: floats or arrays (docs/assess.md)."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from lsvib.drives.mechanics import friction_factor
from lsvib.sheets.materials import SCREW_MATERIALS
from lsvib.sheets.sheet import Motor, Sheet

GRAVITY = 9.80665  # m/s², standard
Values = Mapping[str, Any]  # entries of a sheet or quantities of a drive by name: floats, or arrays that broadcast

FRICTION = ("friction_coefficient", "static_friction_coefficient", "stribeck_rise", "friction_slope")  # of the flanks

_ABSENT = {  # entries that are quantities as they are, absent where the sheet does not give them
    "bearing_friction": "bearing.torque",
    "bearing_static_friction": "bearing.static",
    "collar_friction": "bearing.collar.coefficient",
    "collar_diameter": "bearing.collar.mean_diameter",
    "slide_friction": "guide.friction",
    "slide_static_friction": "guide.static",
    "stribeck_rise": "friction.stribeck_rise",
    "stribeck_speed": "friction.stribeck_speed",
    "static_friction_coefficient": "friction.static",
    "contact_stiffness": "contact.stiffness",
    "contact_damping": "contact.damping",
    "support_stiffness": "support.stiffness",
    "axial_support_damping": "support.damping",
}


def quantities(sheet: Sheet, entries: Values) -> dict[str, Any]:
    """Return the quantities of :data:`lsvib.sheets.words.QUANTITIES` from the entries of a sheet.

    Entries are floats, or arrays of one shape. Quantities that the sheet does not give are zero, or absent for a
    contact, support, motor, bearing or law of friction that it does not have.
    """
    lead, diameter, half_angle = thread_geometry(sheet, entries)
    inertia, screw_mass = _screw(sheet, entries, diameter)
    gear = entries.get("coupling.gear_ratio", 1.0) ** 2
    coefficient = entries.get("friction.coefficient")
    if coefficient is None:
        angle = np.arctan(lead / (math.pi * diameter))
        square = coefficient_from_efficiency(entries["friction.efficiency"], angle)
        coefficient = flank_coefficient(square, angle, half_angle)
    found = {
        "lead": lead,
        "pitch_diameter": diameter,
        "half_angle": half_angle,
        "friction_coefficient": coefficient,
        "friction_slope": entries.get("friction.slope", 0.0),
        "screw_inertia": inertia + entries.get("coupling.inertia", 0.0),
        "coupling_stiffness": entries.get("coupling.stiffness", 0.0) * gear,
        "support_damping": entries.get("damping.rotational", 0.0) + entries.get("bearing.viscous", 0.0),
        "translation_damping": entries.get("damping.translational", 0.0),
        "mass": entries.get("load.mass", 0.0),
        "tilt": entries.get("load.orientation", 0.0),
    }
    undamped = {f"{part}.damping": 0.0 for part in ("contact", "support") if f"{part}.stiffness" in entries}
    given = {**undamped, **entries}
    found |= {key: given[path] for key, path in _ABSENT.items() if path in given}
    if sheet.motor is not None:
        found |= _motor(sheet.motor, entries, found["screw_inertia"], gear)
    if sheet.support is not None:
        found["screw_mass"] = screw_mass
    turns = 2 * math.pi / lead if sheet.operation.speed.unit == "m/s" else 1.0  # from the speed as given to rad/s
    for key, path, scale in (("force", "load.force", 1.0), ("speed", "operation.speed", turns)):
        one = entries.get(path, 0.0)
        low, high = (sheet.spreads[path].low, sheet.spreads[path].high) if sheet.is_window(path) else (one, one)
        found |= {f"{key}_low": low * scale, f"{key}_high": high * scale}
    return found


def thread_geometry(sheet: Any, entries: Values) -> tuple[Any, Any, Any]:
    """Return lead [m], pitch diameter [m] and half angle [rad] from the entries of a sheet that has a ``thread``."""
    thread = sheet.thread
    if thread.size is not None:
        return thread.size.lead, thread.size.pitch_diameter, thread.size.half_angle
    half_angle = entries.get("thread.half_angle", 0.0)
    pitch = entries.get("thread.pitch")
    lead = entries.get("thread.lead", pitch * thread.starts if pitch is not None else None)
    if thread.pitch_diameter is not None:
        diameter = entries["thread.pitch_diameter"]
    else:
        diameter = entries["thread.nominal_diameter"] - 0.5 * (lead / thread.starts if pitch is None else pitch)
    if lead is None or thread.lead_angle is not None:
        lead = math.pi * diameter * np.tan(entries["thread.lead_angle"])
    return lead, diameter, half_angle


def _screw(sheet: Sheet, entries: Values, pitch_diameter: Any) -> tuple[Any, Any]:
    """Inertia [kg m²] and mass [kg] of the screw, a cylinder where they are not given."""
    screw = sheet.screw
    if screw.inertia is not None or screw.length is None:
        return entries.get("screw.inertia", 0.0), entries.get("screw.mass")
    density = entries.get("screw.density", SCREW_MATERIALS[screw.material or "steel"].density)
    diameter = entries.get("screw.diameter", pitch_diameter)
    mass = density * math.pi / 4 * diameter**2 * entries["screw.length"]
    return mass * diameter**2 / 8, entries.get("screw.mass", mass)


def _motor(motor: Motor, entries: Values, inertia: Any, gear: Any) -> dict[str, Any]:
    """What a motor is on the side of the screw, whose ``inertia`` counts for the gains by bandwidth."""
    own = entries["motor.inertia"] * gear
    damping, stiffness = entries.get("motor.speed_gain", 0.0) * gear, entries.get("motor.integral_gain", 0.0) * gear
    if "motor.bandwidth" in entries:
        rate = 2 * math.pi * entries["motor.bandwidth"]
        damping, stiffness = rate * (own + inertia), rate**2 * (own + inertia) / 4
    if "motor.holding_torque" in entries:
        stiffness = entries["motor.holding_torque"] * motor.steps_per_turn / 4 * gear
    found = {"motor_inertia": own, "integral_gain": stiffness, "speed_gain": damping}
    return found | {"coupling_damping": entries.get("coupling.damping", 0.0) * gear}


def square_coefficient(coefficient: Any, lead_angle: Any, half_angle: Any) -> Any:
    """Return the coefficient of the square thread that behaves alike, μ / cos α_n [1]; angles λ and α [rad]."""
    return coefficient * np.sqrt(1 + (np.cos(lead_angle) * np.tan(half_angle)) ** 2)


def flank_coefficient(coefficient: Any, lead_angle: Any, half_angle: Any) -> Any:
    """Return the coefficient of the flank [1] from that of the square thread, the inverse of the function above."""
    return coefficient / np.sqrt(1 + (np.cos(lead_angle) * np.tan(half_angle)) ** 2)


def lifting_efficiency(coefficient: Any, lead_angle: Any, collar: Any = 0.0) -> Any:
    """Return η = tan λ / (tan(λ + arctan μ) + μ_b r_b / r_m) [1] of motion against the load.

    ``coefficient`` μ of the square thread, −ξ₋ = tan(λ + arctan μ); ``collar``: the last term.
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
