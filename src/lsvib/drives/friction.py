r"""The friction law of the threads: its coefficient over the sliding speed v ≥ 0 [m/s] along the helix.

    μ(v) = friction_coefficient + stribeck_rise · exp(−(v / stribeck_speed)^stribeck_exponent) + friction_slope · v,

but never below zero, and at rest up to ``static_friction_coefficient``, where that is not zero, else up to μ(0+). With
rigid threads v = r_m |θ′| / cos λ; so it is with compliant ones, whose small parting is no sliding; with a rotating nut
θ′ − θ_2′ takes the place of θ′. The law is the sum that bSTAB, pybasin and Vahid-Araghi and Golnaraghi use.

The formulas are plain arithmetic, for the balls of one drive, the arrays of many, and power series alike.
"""

import math
from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any

import numpy as np
from flint import arb_series, fmpq_poly

from lsvib.errors import InputError
from lsvib.systems.exact.arithmetic import double, exponential, nothing, root, sign
from lsvib.systems.kernels import law

NAMES = (  # of the parameters that make more of friction than one number
    "static_friction_coefficient",
    "stribeck_rise",
    "stribeck_speed",
    "stribeck_exponent",
    "friction_slope",
)
FADING = {"stribeck_rise": "stribeck_speed"}  # each rise towards slow sliding, and the speed over which it fades
OF_SPEED = (*FADING, "friction_slope")  # each that is not zero makes friction depend on speed


def depends_on_speed(d: Any) -> bool:
    """Whether the coefficient of a drive's sliding threads is more than one number.

    The drive may be given by its parameters as floats, balls or arrays; raises ``Divided`` where arrays do not agree.
    """
    return any(sign(getattr(d, name)) for name in OF_SPEED)


def refusal(d: Any, rest: bool = True, law: bool = False) -> str:
    """Return for which friction alone an answer holds, where that of a drive is another; else nothing.

    ``rest``: whether it is also about rest, and so about static friction; ``law``: whether it holds under a law.
    """
    if not law and depends_on_speed(d):
        return "is computed only for friction that does not depend on speed"
    static = d.static_friction_coefficient
    if rest and sign(static) and sign(static - slowest(vars(d))):
        return "is computed only for static friction that does not exceed sliding friction"
    return ""


def slowest(p: Mapping[str, Any]) -> Any:
    """Return μ(0+), that of slow sliding [1], by parameters by name, of which those of the law may be missing."""
    return sum((p[name] for name in FADING if name in p), p["friction_coefficient"])


def steady_speed(d: Any) -> Any:
    """Return the sliding speed of steady sliding, r_m |Ω| / cos λ [m/s]."""
    return double(d.pitch_radius / d.cos_lead) * (d.input_speed * sign(d.input_speed))


def piece_of(d: Any) -> list[Any]:
    """Return the sum above as a piece of a law, with the columns of :mod:`lsvib.systems.kernels.law`."""
    fade, power = 0 if nothing(d.stribeck_rise) else 1 / _scale(d), d.stribeck_exponent
    power = power if isinstance(power, np.ndarray) else 2 if power == 2 else 1
    return [0, math.inf, d.friction_coefficient, d.friction_slope, d.stribeck_rise, fade, power]


def decays(d: Any, speed: Any) -> dict[str, Any]:
    """Return the share of each rise that is left at a sliding speed [m/s], the exponential above [1], as ``decay…``."""
    if nothing(d.stribeck_speed):
        return {}
    return {"decay": exponential(-law.exponent(piece_of(d), speed / _scale(d)))}


def unbounded(d: Any, speed: Any) -> tuple[Any, Any]:
    """Return the sum above at a sliding speed [m/s], which may be negative [1], and its derivative [s/m]."""
    if nothing(d.stribeck_rise):
        return law.value(piece_of(d), speed, 0, 0)[:2]
    left = d.decay if hasattr(d, "decay") else decays(d, speed)["decay"]
    return law.value(piece_of(d), speed, speed / _scale(d), left)[:2]


def _scale(d: Any) -> Any:
    """Return the speed over which the rise fades; of many drives any where there is no rise."""
    scale = d.stribeck_speed
    return np.where(scale == 0, 1.0, scale) if isinstance(scale, np.ndarray) else scale


def coefficient(d: Any, speed: Any) -> Any:
    """Return μ at a sliding speed [m/s]."""
    value, _ = unbounded(d, speed)
    return value if sign(value, "friction_slope") >= 0 else 0 * value


def levels(d: Any) -> dict[str, Any]:
    """Return what motion and rest begin with: ``steady_friction`` and ``static_friction``, and ``collar``.

    That is μ_b r_b / r_m, by which a thrust collar adds to |ξ_s| [1]; exactly zero without one.
    """
    # the very parameters where friction does not depend on speed
    steady = coefficient(d, steady_speed(d)) if depends_on_speed(d) else d.friction_coefficient
    static = d.static_friction_coefficient if sign(d.static_friction_coefficient) else slowest(vars(d))
    collar = 0 if nothing(d.collar_friction) else d.collar_friction * d.collar_radius / d.pitch_radius
    return {"steady_friction": steady, "static_friction": static, "collar": collar}


def check(drive: Any, limit: float) -> None:
    """Raise ``InputError`` where the parameters of a drive make no friction law, or one beyond cot λ, ``limit``."""
    slow = slowest(vars(drive))
    if drive.stribeck_exponent not in (1, 2):
        raise InputError(f"stribeck_exponent = {drive.stribeck_exponent:g} is neither 1 nor 2.")
    for rise, speed in FADING.items():
        if getattr(drive, rise) and not getattr(drive, speed):
            raise InputError(f"{rise} = {getattr(drive, rise):g} needs {speed} > 0.")
    if not slow < limit:
        raise InputError(
            f"{' + '.join(('friction_coefficient', *FADING))} = {slow:g}, the friction of slow sliding, is not below "
            f"cot(lead_angle) = {limit:.6g}."
        )
    static = drive.static_friction_coefficient
    if static and not slow <= static < limit:
        raise InputError(
            f"static_friction_coefficient = {static:g} is outside the allowed range {slow:g} (the friction of slow "
            f"sliding) <= static_friction_coefficient < cot(lead_angle) = {limit:.6g}."
        )
    speed = drive.pitch_radius * abs(drive.input_speed) / math.cos(drive.lead_angle)
    if not (steady := coefficient(drive, speed)) < limit:
        raise InputError(
            f"friction_slope = {drive.friction_slope:g} makes the friction coefficient {steady:g} at the sliding speed "
            f"{speed:g} m/s of steady sliding, which is not below cot(lead_angle) = {limit:.6g}."
        )


def moves(p: Mapping[str, Any]) -> bool:
    """Whether friction depends on the sliding speed, by parameters by name; those of the law may be missing."""
    return not all(nothing(p.get(key, 0.0)) for key in OF_SPEED)


def steady_sum(p: Mapping[str, Any], t: Any) -> tuple[Any, Any]:
    """Return the sum above in steady sliding, which may be negative [1], and its derivative by the speed [s/m].

    Arguments: parameters by name, of which those of the law may be missing; tan λ. All are numbers of one kind: arrays,
    balls, power series, rationals, or polynomials in an unknown. The last two come with what is no rational:
    ``secant``, 1 / cos λ, and those of :func:`decays`.
    """
    if not moves(p):
        return p["friction_coefficient"], 0
    d = SimpleNamespace(**{**dict.fromkeys(NAMES, 0), "stribeck_exponent": 1, **p})
    speed = d.pitch_radius * _size(d.input_speed) * (d.secant if hasattr(d, "secant") else root(1 + t * t))
    return unbounded(d, speed)


def steady(p: Mapping[str, Any], t: Any) -> tuple[Any, Any]:
    """Return μ [1] and dμ/dv [s/m] in steady sliding; arguments as :func:`steady_sum`.

    A ball counts as negative where it is so for certain, a polynomial never.
    """
    value, rate = steady_sum(p, t)
    if isinstance(value, np.ndarray):
        return np.where(value < 0, 0.0, value), np.where(value < 0, 0.0, rate)
    return (0 * value, 0 * rate) if _negative(value) else (value, rate)


def _negative(x: Any) -> bool:
    return not isinstance(x, fmpq_poly) and bool((x[0] if isinstance(x, arb_series) else x) < 0)


def _size(x: Any) -> Any:
    return np.abs(x) if isinstance(x, np.ndarray) else -x if _negative(x) else x
