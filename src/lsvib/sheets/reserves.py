"""Which mechanism makes steady sliding unstable in the operating window, and how far it is from that.

All is for whole samples of drives at once. The reserve [1] of a mechanism, in docs/assess.md for each, is its balance:
what keeps steady sliding stable less what destabilises it, over the sum of both. It is 1 where nothing destabilises, 0
at the onset and negative where the mechanism occurs. Without any damping a reserve of damping is zero: motions neither
grow nor decay.
"""

from collections.abc import Mapping
from functools import reduce
from typing import Any

import numpy as np

from lsvib.drives import mechanics
from lsvib.drives.drive import PARTS
from lsvib.stability.spectrum import hurwitz, interlaced

NAMES = ("negative_damping", "kinematic_constraint", "mode_coupling", "falling_friction", "thread_contact")
"""All mechanisms; mode coupling needs a support, thread contact a compliant contact."""

_UNDAMPED = ("support_damping", "translation_damping", "axial_support_damping", "contact_damping")


def reserves(p: Mapping[str, Any], slope: Any, sloped: bool) -> dict[str, Any]:
    """Return the reserve [1] of each mechanism at points of operation; the mechanism occurs where it is negative.

    ``p``: parameters of the drive with its parts, floats or arrays that broadcast, with the coefficient of friction at
    the speed; ``slope`` of it over the sliding speed [s/m], ``sloped``: whether it may have one. Besides the
    mechanisms: ``law``, s_0 = ±1, and ``after_perturbation``, the lower of those of Γ₊ (Γ̃₊ with a support) and C₊
    under law −: below zero steady sliding is stable but need not be the only motion (Sect. 8.7), since slip under law +
    seizes or grows. NaN where μ is not below cot λ.
    """
    tangent, radius, rubs, mass = np.tan(p["lead_angle"]), p["pitch_radius"], p["friction_coefficient"], p["mass"]
    support, contact = "support_stiffness" in p, "contact_stiffness" in p
    lever = radius * tangent * p["translation_damping"]
    direction = np.sign(p["input_speed"])
    carried = p["axial_force"] - lever * p["input_speed"] - p.get("slide_friction", 0.0) * direction  # R̃
    # Without any force the slightest one decides, and law + is the one that destabilises.
    law = np.where(carried * p["input_speed"] >= 0, 1, -1)
    collar = p.get("collar_friction", 0.0) * p.get("collar_radius", 0.0) / radius
    by_slope = mechanics.damping_by_slope(slope, np.abs(carried), rubs, radius, np.cos(p["lead_angle"]), tangent, law)
    geometry = (radius, tangent, mechanics.friction_factor(rubs, tangent, law) + law * collar)
    if support:
        mass = mass * p["screw_mass"] / (mass + p["screw_mass"])
    inertia = mechanics.effective_inertia(p["screw_inertia"], mass, *geometry)
    damping = mechanics.effective_damping(p["support_damping"], p["translation_damping"], *geometry)
    base = _balance(p["support_damping"], damping - p["support_damping"])
    sloping = _balance(p["support_damping"], damping - p["support_damping"], by_slope)
    found = {
        "kinematic_constraint": _balance(p["screw_inertia"], inertia - p["screw_inertia"]),
        "negative_damping": np.maximum(base, sloping),
        "falling_friction": np.where(slope < 0, sloping, 1.0),
    }
    helped = damping + np.where(by_slope > 0, by_slope, 0.0)  # a fall is a mechanism of its own
    if "motor_inertia" in p or support:
        found |= _as_a_whole(without(p, "threads"), law, found, (inertia, helped, by_slope), sloped)
    if contact:  # the whole drive decides; threads and support together are named after the contact
        full = _full_reserve(p, law)
        names = [name for name in ("negative_damping", "kinematic_constraint", "mode_coupling") if name in found]
        found |= {name: np.maximum(found[name], full) for name in names}
        own_fault = (helped >= 0) & (inertia > 0)
        if support:
            own_fault = reduce(np.logical_and, [found[name] >= 0 for name in names])
        found["thread_contact"] = np.where(own_fault, full, np.maximum(full, 0 * full))
    # Where nothing damps the drive a reserve of damping is at most zero, whatever its two bodies do undamped.
    dampings = [value for key, value in p.items() if key.endswith("_damping")]
    nothing, reserve = sum(map(np.abs, (*dampings, by_slope))) == 0, found["negative_damping"]
    found["negative_damping"] = np.where(nothing & (reserve > 0), 0.0, reserve)
    geometry = (radius, tangent, mechanics.friction_factor(rubs, tangent, 1) + collar)
    of_plus = mechanics.effective_inertia(p["screw_inertia"], mass, *geometry) - p["screw_inertia"]
    fed = mechanics.effective_damping(0.0, p["translation_damping"], *geometry)
    # Without damping of the load there is nothing that law + could turn round.
    damped = np.where(fed == 0, 1.0, _balance(p["support_damping"], fed))
    reserve = _balance(p["screw_inertia"], of_plus)
    found["after_perturbation"] = np.where(law < 0, np.minimum(damped, reserve), 1.0)
    valid = rubs * tangent < 1
    return {name: np.where(valid, value, np.nan) for name, value in found.items()} | {"law": law}


def without(p: Mapping[str, Any], *parts: str) -> dict[str, Any]:
    """Return the parameters of a drive without those of some parts."""
    left = {name for part in parts for name in PARTS[part]} | ({"coupling_damping"} if "motor" in parts else set())
    return {key: value for key, value in p.items() if key not in left}


def _as_a_whole(
    p: Mapping[str, Any], law: Any, rigid: dict[str, Any], terms: tuple[Any, ...], sloped: bool
) -> dict[str, Any]:
    """Reserves that a motor or a support alters, from those of the ``rigid`` screw.

    ``terms``: Γ̃_0, C_0 with the rise of friction over the speed, and S.
    """
    inertia, helped, by_slope = terms
    level = sloping = _full_reserve(p, law)
    if sloped:
        sloping = _full_reserve({**p, "support_damping": p["support_damping"] + by_slope}, law)
    falls, kinematic, coupled = by_slope < 0, inertia <= 0, helped >= 0
    if not coupled.all():  # there it is mode coupling only if the two bodies do it undamped, too
        coupled |= _full_reserve({**p, **dict.fromkeys(_UNDAMPED, 0.0)}, law) < 0
    coupled &= ~kinematic
    full = np.where(falls, level, sloping)
    fallen = np.where(level < 0, np.maximum(rigid["falling_friction"], sloping), sloping)
    found = {
        "negative_damping": np.maximum(rigid["negative_damping"], full),
        "falling_friction": np.where(falls, fallen, rigid["falling_friction"]),
    }
    found = {name: np.where(kinematic, rigid[name], one) for name, one in found.items()}
    if "support_stiffness" not in p:
        return found
    return found | {"mode_coupling": np.where(coupled, full, np.maximum(full, 0 * full))}


def _balance(*terms: Any) -> Any:
    """Sum of terms over the sum of their sizes; zero if all are zero."""
    size = sum(map(np.abs, terms))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(size == 0, 0.0, sum(terms) / size)


def _full_reserve(parameters: Mapping[str, Any], law: Any) -> Any:
    """Reserve of a drive with parts, from its characteristic polynomial, for a law (scalar or array).

    It is the lowest balance of the Hurwitz determinants of odd order, −1 where a coefficient is not positive. Of a
    quartic that is the balance of (p_3 p_2 − p_4 p_1) p_1 − p_3² p_0. A coefficient that falls to zero takes it to −1,
    so that it is continuous. Where all odd coefficients vanish, as without damping, it is the balance of p_2² − 4 p_4
    p_0 instead, of higher degrees that of :func:`lsvib.stability.spectrum.interlaced`.
    """
    p = mechanics.LinearParts.of(parameters, law, np.tan(parameters["lead_angle"])).polynomial()
    undamped, damped = reduce(np.logical_and, [x == 0 for x in p[1::2]]), _of_determinants(p)
    if not np.any(undamped):
        return damped
    pair = _balance(p[2] ** 2, -4 * p[0] * p[4]) if len(p) == 5 else _of_determinants(interlaced(p))
    without = np.where(_any_negative(p[2::2]), -1.0, pair)
    return np.where(undamped, without, damped)


def _of_determinants(p: tuple[Any, ...]) -> Any:
    found: Any = 1.0
    sizes = tuple(map(np.abs, p))
    for order in range(3, len(p) - 1, 2):
        size = hurwitz(sizes, order, same=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            one = np.where(size == 0, 0.0, hurwitz(p, order) / size)
        found = np.where(one < found, one, found)
    return np.where(_any_negative(p[1:-1]), -1.0, found)


def _any_negative(coefficients: tuple[Any, ...]) -> Any:
    """Whether one of some coefficients is not positive."""
    return reduce(np.logical_or, [x <= 0 for x in coefficients])
