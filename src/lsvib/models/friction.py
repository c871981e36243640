r"""The friction law of the threads: its coefficient over the sliding speed v ≥ 0 [m/s] along the helix.

    μ(v) = friction_coefficient + stribeck_rise · exp(−(v / stribeck_speed)^stribeck_exponent) + friction_slope · v,

but never below zero, and at rest up to ``static_friction_coefficient``, where that is not zero, else up to μ(0+). With
rigid threads v = r_m |θ′| / cos λ; so it is with compliant ones, whose small parting is no sliding; with a rotating nut
θ′ − θ_2′ takes the place of θ′. The law is the sum that bSTAB, pybasin and Vahid-Araghi and Golnaraghi use.

The formulas are plain arithmetic, for the balls of one drive, the arrays of many, and power series alike.
"""

import math
from typing import Any

from lsvib.engine.exact.arithmetic import exponential, sign
from lsvib.errors import InputError

NAMES = (  # of the parameters that make more of friction than one number
    "static_friction_coefficient",
    "stribeck_rise",
    "stribeck_speed",
    "stribeck_exponent",
    "friction_slope",
)
OF_SPEED = ("stribeck_rise", "friction_slope")  # of these, each that is not zero makes friction depend on speed


def depends_on_speed(d: Any) -> bool:
    """Whether the coefficient of a drive's sliding threads is more than one number.

    The drive may be given by its parameters as floats, balls or arrays; raises ``Divided`` where arrays do not agree.
    """
    return any(sign(getattr(d, name)) for name in OF_SPEED)


def steady_speed(d: Any) -> Any:
    """Return the sliding speed of steady sliding, r_m |Ω| / cos λ [m/s]."""
    return d.pitch_radius * (d.input_speed * sign(d.input_speed)) / d.cos_lead


def unbounded_coefficient(d: Any, speed: Any) -> Any:
    """Return the sum above at a sliding speed [m/s], which may be negative [1]."""
    value = d.friction_coefficient
    if sign(d.stribeck_rise):
        value = value + d.stribeck_rise * _decay(d, speed)
    return value + d.friction_slope * speed if sign(d.friction_slope) else value


def coefficient(d: Any, speed: Any) -> Any:
    """Return μ at a sliding speed [m/s]."""
    value = unbounded_coefficient(d, speed)
    return value if sign(value, "friction_slope") >= 0 else 0 * value


def slope(d: Any, speed: Any) -> Any:
    """Return dμ/dv at a sliding speed v > 0 [s/m]."""
    if sign(unbounded_coefficient(d, speed), "friction_slope") < 0:
        return 0 * speed
    found = d.friction_slope + 0 * speed
    if sign(d.stribeck_rise):
        steep = d.stribeck_exponent * (speed if _squared(d) else 1) / d.stribeck_speed
        found = found - d.stribeck_rise * _decay(d, speed) * (steep / d.stribeck_speed if _squared(d) else steep)
    return found


def steady_coefficient(d: Any) -> Any:
    """Return μ in steady sliding [1]: the very parameter where it does not depend on speed."""
    return coefficient(d, steady_speed(d)) if depends_on_speed(d) else d.friction_coefficient


def static_coefficient(d: Any) -> Any:
    """Return the coefficient up to which friction holds at rest [1]."""
    if sign(d.static_friction_coefficient):
        return d.static_friction_coefficient
    return d.friction_coefficient + d.stribeck_rise if sign(d.stribeck_rise) else d.friction_coefficient


def levels(d: Any) -> dict[str, Any]:
    """Return the coefficients that motion and rest begin with: ``steady_friction`` and ``static_friction``."""
    return {"steady_friction": steady_coefficient(d), "static_friction": static_coefficient(d)}


def check(drive: Any, limit: float) -> None:
    """Raise ``InputError`` where the parameters of a drive make no friction law, or one beyond cot λ, ``limit``."""
    slowest = drive.friction_coefficient + drive.stribeck_rise
    if drive.stribeck_exponent not in (1, 2):
        raise InputError(f"stribeck_exponent = {drive.stribeck_exponent:g} is neither 1 nor 2.")
    if drive.stribeck_rise and not drive.stribeck_speed:
        raise InputError(f"stribeck_rise = {drive.stribeck_rise:g} needs stribeck_speed > 0.")
    if not slowest < limit:
        raise InputError(
            f"friction_coefficient + stribeck_rise = {slowest:g}, the friction of slow sliding, is not below "
            f"cot(lead_angle) = {limit:.6g}."
        )
    static = drive.static_friction_coefficient
    if static and not slowest <= static < limit:
        raise InputError(
            f"static_friction_coefficient = {static:g} is outside the allowed range {slowest:g} (the friction of slow "
            f"sliding) <= static_friction_coefficient < cot(lead_angle) = {limit:.6g}."
        )
    speed = drive.pitch_radius * abs(drive.input_speed) / math.cos(drive.lead_angle)
    if not (steady := coefficient(drive, speed)) < limit:
        raise InputError(
            f"friction_slope = {drive.friction_slope:g} makes the friction coefficient {steady:g} at the sliding speed "
            f"{speed:g} m/s of steady sliding, which is not below cot(lead_angle) = {limit:.6g}."
        )


def _squared(d: Any) -> bool:
    return bool(sign(d.stribeck_exponent - 1))


def _decay(d: Any, speed: Any) -> Any:
    ratio = speed / d.stribeck_speed
    return exponential(-(ratio * ratio if _squared(d) else ratio))
