r"""Which mechanism makes steady sliding unstable, and how much keeps it stable, for whole samples of drives at once.

The reserve [1] of a mechanism is its balance: what keeps steady sliding stable less what destabilises it, over the sum
of both. It is 1 where nothing destabilises, 0 at the onset and negative where the mechanism occurs:

    kinematic constraint   Γ_0, or Γ̃_0 with a support (eqs 8.20, 8.27), over the sum of the sizes of its two terms
    negative damping       C_0 likewise (8.19)
    falling friction       C_0 + S likewise, where the slope of μ gives S (:mod:`lsvib.assess.drive`); with a
                           support that is stable without the slope, its Hurwitz determinant with C_0 + S
    mode coupling          the Hurwitz determinant of the drive with support, or without any damping p_2² − 4 p_4 p_0
    thread contact         the Hurwitz determinant of the drive with compliant threads

The last two are laid at the door of the mechanism only where the drive with rigid parts would be stable, or where the
undamped drive with support is unstable already. A support or contact can also keep a drive stable that is unstable with
rigid parts; then no mechanism occurs. With both, each is judged with the other rigid, and the support decides on the
mechanisms of the rigid drive. Without any damping a reserve of damping is zero: motions neither grow nor decay.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lsvib.assess import drive as sheets
from lsvib.assess.drive import damping_by_slope
from lsvib.assess.sheet import Sheet
from lsvib.models import mechanics
from lsvib.models.drive import RigidDrive, SupportDrive, ThreadsDrive, zero_if_close
from lsvib.stability.conditions import conditions
from lsvib.stability.linear import steady_law, support_model, threads_model
from lsvib.stability.spectrum import polynomial, spectrum

NAMES = ("negative_damping", "kinematic_constraint", "mode_coupling", "falling_friction", "thread_contact")
"""All mechanisms; mode coupling needs a support, thread contact a compliant contact."""

DRIVES = {"rigid": RigidDrive, "support": SupportDrive, "contact": ThreadsDrive}
"""The drive that a motion or verdict is of, by the part of the sheet that is compliant in it."""

_MATRICES = {"support": support_model, "contact": threads_model}
_UNDAMPED = ("support_damping", "translation_damping", "axial_support_damping", "contact_damping")


def applicable(sheet: Sheet) -> tuple[str, ...]:
    """Return the mechanisms that a sheet has the parts for."""
    missing = {"mode_coupling": sheet.support is None, "thread_contact": sheet.contact is None}
    return tuple(name for name in NAMES if not missing.get(name, False))


def reserves(sheet: Sheet, values: Mapping[str, Any], direction: int, speed: Any, force: Any) -> dict[str, Any]:
    """Return the reserve [1] of each mechanism at points of operation; the mechanism occurs where it is negative.

    ``values``: quantities of the drive, floats, complex floats (one drive) or arrays that broadcast with ``speed``
    [rad/s] and ``force`` [N]; ``direction`` of travel ±1. Besides the mechanisms: ``law``, s_0 = ±1, and
    ``push_needed``, the lower of those of Γ₊ (Γ̃₊ with a support) and C₊ under law −: below zero steady sliding is
    stable but need not be the only motion (Sect. 8.7), since slip under law + seizes or grows. NaN where μ is not below
    cot λ.
    """
    at = sheets.point(sheet, values, direction, speed, force)
    p = at.parameters
    tangent = np.tan(p["lead_angle"])
    lever = p["pitch_radius"] * tangent * p["translation_damping"]
    carried = p["axial_force"] - lever * p["input_speed"]  # R̃
    # Without any force the slightest one decides, and law + is the one that destabilises.
    law = np.where(np.real(carried) * np.real(p["input_speed"]) >= 0, 1, -1)
    size = np.where(np.real(carried) < 0, -carried, carried)
    by_slope = damping_by_slope(at.slope, size, p["friction_coefficient"], p["pitch_radius"], p["lead_angle"], law)
    factor = mechanics.friction_factor(p["friction_coefficient"], tangent, law)
    geometry = (p["pitch_radius"], tangent, factor)
    mass = p["mass"]
    if sheet.support is not None:
        mass = mass * values["screw_mass"] / (mass + values["screw_mass"])
    inertia = mechanics.effective_inertia(p["screw_inertia"], mass, *geometry)
    damping = mechanics.effective_damping(p["support_damping"], p["translation_damping"], *geometry)
    base = _balance(p["support_damping"], damping - p["support_damping"])
    sloped = _balance(p["support_damping"], damping - p["support_damping"], by_slope)
    found = {
        "kinematic_constraint": _balance(p["screw_inertia"], inertia - p["screw_inertia"]),
        "negative_damping": _larger(base, sloped),
        "falling_friction": np.where(np.real(at.slope) < 0, sloped, 1.0),
    }
    helped = damping + np.where(np.real(by_slope) > 0, by_slope, 0.0)  # a fall is a mechanism of its own
    if sheet.support is not None:
        found |= _with_support(sheet, values, p, law, found, (inertia, helped, by_slope))
    if sheet.contact is not None:
        own = sheets.own_parameters(values, "contact")
        full = _full_reserve("contact", {**p, **own}, law)
        whole = mechanics.effective_inertia(p["screw_inertia"], p["mass"], *geometry)  # the support is rigid here
        own_fault = (np.real(helped) >= 0) & (np.real(whole) > 0)
        found["thread_contact"] = np.where(own_fault, full, _larger(full, 0 * full))
        if sheet.support is None:
            for name in ("negative_damping", "kinematic_constraint"):
                found[name] = _larger(found[name], full)
    plus = mechanics.friction_factor(p["friction_coefficient"], tangent, 1)
    geometry = (p["pitch_radius"], tangent, plus)
    of_plus = mechanics.effective_inertia(p["screw_inertia"], mass, *geometry) - p["screw_inertia"]
    fed = mechanics.effective_damping(0.0, p["translation_damping"], *geometry)
    # Without damping of the load there is nothing that law + could turn round.
    damped = np.where(np.real(fed) == 0, 1.0, _balance(p["support_damping"], fed))
    reserve = _balance(p["screw_inertia"], of_plus)
    found["push_needed"] = np.where(law < 0, np.where(np.real(damped) < np.real(reserve), damped, reserve), 1.0)
    valid = np.real(p["friction_coefficient"] * tangent) < 1
    return {name: np.where(valid, value, np.nan) for name, value in found.items()} | {"law": law}


def _with_support(
    sheet: Sheet, values: Mapping[str, Any], p: dict[str, Any], law: Any, rigid: dict[str, Any], terms: tuple
) -> dict[str, Any]:
    """Reserves that a support alters, from those of the ``rigid`` screw.

    ``terms``: Γ̃_0, C_0 with the rise of friction over the speed, and S.
    """
    inertia, helped, by_slope = terms
    p = {**p, **sheets.own_parameters(values, "support")}
    level = sloped = _full_reserve("support", p, law)
    if sheet.friction.slope is not None or sheet.friction.curve is not None:
        sloped = _full_reserve("support", {**p, "support_damping": p["support_damping"] + by_slope}, law)
    bare = _full_reserve("support", {**p, **dict.fromkeys(_UNDAMPED, 0.0)}, law)
    falls, kinematic = np.real(by_slope) < 0, np.real(inertia) <= 0
    full = np.where(falls, level, sloped)
    coupled = ~kinematic & ((np.real(helped) >= 0) | (np.real(bare) < 0))
    fallen = np.where(np.real(level) < 0, _larger(rigid["falling_friction"], sloped), sloped)
    found = {
        "negative_damping": _larger(rigid["negative_damping"], full),
        "falling_friction": np.where(falls, fallen, rigid["falling_friction"]),
    }
    found = {name: np.where(kinematic, rigid[name], one) for name, one in found.items()}
    return found | {"mode_coupling": np.where(coupled, full, _larger(full, 0 * full))}


def _balance(*terms: Any) -> Any:
    """Sum of terms over the sum of their sizes; zero if all are zero."""
    size = sum(np.where(np.real(term) < 0, -term, term) for term in terms)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(np.real(size) == 0, 0.0, sum(terms) / size)


def _larger(a: Any, b: Any) -> Any:
    return np.where(np.real(a) >= np.real(b), a, b)


def _full_reserve(part: str, parameters: dict[str, Any], law: Any) -> Any:
    """Reserve of a drive with two coordinates, from its characteristic polynomial, for a law (scalar or array)."""
    if any(np.iscomplexobj(value) for value in parameters.values()):
        exact = {key: complex(value) for key, value in parameters.items()}
        tangent = complex(np.tan(parameters["lead_angle"]))
        return _hurwitz_reserve(*polynomial(DRIVES[part], exact, int(law), tangent))
    both = [_hurwitz_reserve(*_MATRICES[part](parameters, s).polynomial()) for s in (1, -1)]
    return np.where(law > 0, *both)


def _hurwitz_reserve(p_4: Any, p_3: Any, p_2: Any, p_1: Any, p_0: Any) -> Any:
    """Balance of the Hurwitz determinant (p_3 p_2 − p_4 p_1) p_1 − p_3² p_0; −1 where a coefficient is not positive.

    A coefficient that falls to zero takes the balance to −1, so that it is continuous. Where p_3 and p_1 vanish, as
    without damping, that of p_2² − 4 p_4 p_0 instead.
    """
    terms = (p_3 * p_2 * p_1, -p_4 * p_1**2, -(p_3**2) * p_0)
    damped = _balance(*terms)
    negative = (np.real(p_3) <= 0) | (np.real(p_2) <= 0) | (np.real(p_1) <= 0)
    damped = np.where(negative, -1.0, damped)
    undamped = np.where(np.real(p_2) <= 0, -1.0, _balance(p_2**2, -4 * p_4 * p_0))
    return np.where((p_3 == 0) & (p_1 == 0), undamped, damped)


def drive_of(
    sheet: Sheet, values: Mapping[str, float], direction: int, speed: float, force: float, part: str = "rigid"
):
    """Return the drive of the package at one point of operation: rigid, or with the ``contact`` or ``support``."""
    parameters = sheets.point(sheet, values, direction, speed, force).parameters
    given = {**parameters, **sheets.own_parameters(values, part)}
    kind = DRIVES[part]
    return kind(**{key: zero_if_close(kind, key, float(value)) for key, value in given.items()})


def certain(sheet: Sheet, values: Mapping[str, float], direction: int, speed: float, force: float) -> dict[str, bool]:
    """Say which mechanisms occur in one drive without a slope of friction, decided by exact signs.

    For the rigid drive by :func:`lsvib.stability.conditions.conditions`, with a support or contact by
    :func:`lsvib.stability.spectrum.spectrum`. Raises ``InputError`` where the contact carries no force.
    """
    rigid = drive_of(sheet, values, direction, speed, force)
    found = conditions(rigid)
    law = steady_law(rigid)
    occurs = {
        "negative_damping": found["negative_damping"].hold,
        "kinematic_constraint": found["kinematic_constraint"].hold,
        "falling_friction": False,
    }
    stable = not (occurs["negative_damping"] or occurs["kinematic_constraint"])
    if sheet.support is not None:
        supported = drive_of(sheet, values, direction, speed, force, "support")
        kind = spectrum(supported, law)[0]
        bare = spectrum(supported.replace(**dict.fromkeys(_UNDAMPED[:3], 0.0)), law)[0]
        unstable = kind in ("flutter", "divergence")
        occurs["kinematic_constraint"] = kind == "kinematic_constraint"
        fed = occurs["negative_damping"]
        occurs["mode_coupling"] = unstable and (not fed or bare in ("flutter", "divergence"))
        occurs["negative_damping"] &= unstable or kind == "kinematic_constraint"
    if sheet.contact is not None:
        kind = spectrum(drive_of(sheet, values, direction, speed, force, "contact"), law)[0]
        unstable = kind not in ("stable", "neutral")
        occurs["thread_contact"] = stable and unstable
        if sheet.support is None:
            for name in ("negative_damping", "kinematic_constraint"):
                occurs[name] &= unstable
    return occurs
