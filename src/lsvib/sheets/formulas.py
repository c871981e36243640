"""Formulas of a thread, for floats and arrays alike: geometry, friction, efficiency (docs/assess.md)."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from lsvib.drives.mechanics import friction_factor, thread_force

GRAVITY = 9.80665  # m/s², standard
Values = Mapping[str, Any]  # entries of a sheet or quantities of a drive by name: floats, or arrays that broadcast

FLAT = 1e8  # leads of the pitch diameter at which, to rounding, the lead angle has vanished
FRICTION = ("friction_coefficient", "static_friction_coefficient", "stribeck_rise", "friction_slope")  # of the flanks


def thread_geometry(sheet: Any, entries: Values) -> tuple[Any, Any, Any]:
    """Return lead [m], pitch diameter [m] and half angle [rad] from the entries of a sheet that has a ``thread``.

    Of one without a diameter, whose efficiency is given, it is that of a thread with a vanishing lead angle.
    """
    thread = sheet.thread
    if thread.size is not None:
        return thread.size.lead, thread.size.pitch_diameter, thread.size.half_angle
    half_angle = entries.get("thread.half_angle", 0.0)
    pitch = entries.get("thread.pitch")
    lead = entries.get("thread.lead", pitch * thread.starts if pitch is not None else None)
    if thread.bare:
        diameter = FLAT * lead
    elif thread.pitch_diameter is not None:
        diameter = entries["thread.pitch_diameter"]
    else:
        diameter = entries["thread.nominal_diameter"] - 0.5 * (lead / thread.starts if pitch is None else pitch)
    if lead is None or thread.lead_angle is not None:
        lead = math.pi * diameter * np.tan(entries["thread.lead_angle"])
    return lead, diameter, half_angle


def square_coefficient(coefficient: Any, lead_angle: Any, half_angle: Any) -> Any:
    """Return the coefficient of the square thread that behaves alike, μ / cos α_n [1]; angles λ and α [rad]."""
    return coefficient * np.sqrt(1 + (np.cos(lead_angle) * np.tan(half_angle)) ** 2)


def flank_coefficient(coefficient: Any, lead_angle: Any, half_angle: Any) -> Any:
    """Return the coefficient of the flank [1] from that of the square thread, the inverse of the function above."""
    return coefficient / np.sqrt(1 + (np.cos(lead_angle) * np.tan(half_angle)) ** 2)


def torque(
    force: Any,
    pitch_radius: Any,
    lead_angle: Any,
    coefficient: Any,
    lifting: bool,
    collar: Any = 0.0,
    relieved: Any = 0.0,
) -> Any:
    """Return the torque of threads and collar [N m] under an axial ``force`` [N], r F (tan(ρ ± λ) + μ_b r_b / r).

    ``coefficient`` μ of the square thread, ρ = arctan μ; ``lifting``: against the force; ``collar``, μ_b r_b / r.
    Lowering, it is negative where the thread does not lock and has to be braked. ``relieved`` [N]: on the half of a
    preloaded nut, :func:`lsvib.drives.mechanics.relieved_half`; it adds r F′ (tan(ρ + λ) + tan(ρ − λ)).

    >>> round(torque(1000.0, 9.188e-3, 0.04328, 0.15, lifting=True), 3)
    1.788
    """
    threads = thread_force(force, relieved, coefficient, np.tan(lead_angle), -1 if lifting else 1)
    return pitch_radius * (threads + force * collar)


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
