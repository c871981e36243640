"""Which mechanism makes steady sliding unstable in the operating window, and how far it is from that.

All is for whole samples of drives at once. The reserve [1] of a mechanism, in docs/assess.md for each, is its balance:
what keeps steady sliding stable less what destabilises it, over the sum of both. It is 1 where nothing destabilises, 0
at the onset and negative where the mechanism occurs. Without any damping a reserve of damping is zero: motions neither
grow nor decay.
"""

import math
from dataclasses import dataclass
from functools import reduce
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.assess import drive as sheets
from lsvib.assess.drive import Corner, Parts, Values, is_window, sliding_speed, without_friction
from lsvib.assess.sheet import Sheet
from lsvib.models import friction, mechanics
from lsvib.models.drive import Drive, zero_if_close
from lsvib.stability.spectrum import hurwitz, interlaced

NAMES = ("negative_damping", "kinematic_constraint", "mode_coupling", "falling_friction", "thread_contact")
"""All mechanisms; mode coupling needs a support, thread contact a compliant contact."""

AT_ONCE = 2**17  # reserves, few enough for the processor's caches, many enough for NumPy
_FADING = (0.05, 0.1, 0.2, 0.35, 0.6, 1.0, 1.6, 2.5, 4.0, 7.0)  # of the speed over which a rise of friction fades
_SHARES = np.linspace(0, 1, 8)[1:-1]  # of the window, in logarithm
_GOLDEN = 0.5 * (math.sqrt(5) - 1)
_BESIDE = 1e-9  # how near to a point of a curve, or to R̃ = 0, relative: far above rounding
_UNDAMPED = ("support_damping", "translation_damping", "axial_support_damping", "contact_damping")


def applicable(sheet: Sheet) -> tuple[str, ...]:
    """Return the mechanisms that a sheet has the parts for."""
    missing = {"mode_coupling": sheet.support is None, "thread_contact": sheet.contact is None}
    return tuple(name for name in NAMES if not missing.get(name, False))


def reserves(sheet: Sheet, values: Values, direction: int, speed: Any, force: Any) -> dict[str, Any]:
    """Return the reserve [1] of each mechanism at points of operation; the mechanism occurs where it is negative.

    ``values``: quantities of the drive, floats, complex floats (one drive) or arrays that broadcast with ``speed``
    [rad/s] and ``force`` [N]; ``direction`` of travel ±1. Besides the mechanisms: ``law``, s_0 = ±1, and
    ``after_perturbation``, the lower of those of Γ₊ (Γ̃₊ with a support) and C₊ under law −: below zero steady sliding
    is stable but need not be the only motion (Sect. 8.7), since slip under law + seizes or grows. NaN where μ is not
    below cot λ.
    """
    p, slope = sheets.point(sheet, values, direction, speed, force)
    tangent = np.tan(p["lead_angle"])
    lever = p["pitch_radius"] * tangent * p["translation_damping"]
    carried = p["axial_force"] - lever * p["input_speed"] - p.get("slide_friction", 0.0) * direction  # R̃
    # Without any force the slightest one decides, and law + is the one that destabilises.
    law = np.where(np.real(carried) * np.real(p["input_speed"]) >= 0, 1, -1)
    size = np.where(np.real(carried) < 0, -carried, carried)
    radius, rubs, collar = p["pitch_radius"], p["friction_coefficient"], sheets.collar_of(values)
    by_slope = mechanics.damping_by_slope(slope, size, rubs, radius, np.cos(p["lead_angle"]), tangent, law)
    geometry = (radius, tangent, mechanics.friction_factor(rubs, tangent, law) + law * collar)
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
        "falling_friction": np.where(np.real(slope) < 0, sloped, 1.0),
    }
    helped = damping + np.where(np.real(by_slope) > 0, by_slope, 0.0)  # a fall is a mechanism of its own
    if sheet.motor is not None or sheet.support is not None:
        found |= _as_a_whole(sheet, values, p, law, found, (inertia, helped, by_slope))
    if sheet.contact is not None:  # the whole drive decides; threads and support together are named after the contact
        full = _full_reserve(p | sheets.own_parameters(values, sheet.parts), law)
        names = [name for name in ("negative_damping", "kinematic_constraint", "mode_coupling") if name in found]
        found |= {name: _larger(found[name], full) for name in names}
        own_fault = (np.real(helped) >= 0) & (np.real(inertia) > 0)
        if sheet.support is not None:
            own_fault = reduce(np.logical_and, [np.real(found[name]) >= 0 for name in names])
        found["thread_contact"] = np.where(own_fault, full, _larger(full, 0 * full))
    # Where nothing damps the drive a reserve of damping is at most zero, whatever its two bodies do undamped.
    dampings = [value for key, value in values.items() if key.endswith("_damping")]
    nothing, reserve = sum(map(_size, (*dampings, by_slope))) == 0, found["negative_damping"]
    found["negative_damping"] = np.where(nothing & (np.real(reserve) > 0), 0.0, reserve)
    geometry = (radius, tangent, mechanics.friction_factor(rubs, tangent, 1) + collar)
    of_plus = mechanics.effective_inertia(p["screw_inertia"], mass, *geometry) - p["screw_inertia"]
    fed = mechanics.effective_damping(0.0, p["translation_damping"], *geometry)
    # Without damping of the load there is nothing that law + could turn round.
    damped = np.where(np.real(fed) == 0, 1.0, _balance(p["support_damping"], fed))
    reserve = _balance(p["screw_inertia"], of_plus)
    found["after_perturbation"] = np.where(law < 0, np.where(np.real(damped) < np.real(reserve), damped, reserve), 1.0)
    valid = np.real(rubs * tangent) < 1
    return {name: np.where(valid, value, np.nan) for name, value in found.items()} | {"law": law}


def _as_a_whole(sheet: Sheet, values: Values, p: dict, law: Any, rigid: Values, terms: tuple) -> dict[str, Any]:
    """Reserves that a motor or a support alters, from those of the ``rigid`` screw.

    ``terms``: Γ̃_0, C_0 with the rise of friction over the speed, and S.
    """
    inertia, helped, by_slope = terms
    p = p | sheets.own_parameters(values, tuple(part for part in sheet.parts if part != "threads"))
    level = sloped = _full_reserve(p, law)
    if sheet.friction.sloped:
        sloped = _full_reserve({**p, "support_damping": p["support_damping"] + by_slope}, law)
    falls, kinematic, coupled = np.real(by_slope) < 0, np.real(inertia) <= 0, np.real(helped) >= 0
    if not coupled.all():  # there it is mode coupling only if the two bodies do it undamped, too
        coupled |= np.real(_full_reserve({**p, **dict.fromkeys(_UNDAMPED, 0.0)}, law)) < 0
    coupled &= ~kinematic
    full = np.where(falls, level, sloped)
    fallen = np.where(np.real(level) < 0, _larger(rigid["falling_friction"], sloped), sloped)
    found = {
        "negative_damping": _larger(rigid["negative_damping"], full),
        "falling_friction": np.where(falls, fallen, rigid["falling_friction"]),
    }
    found = {name: np.where(kinematic, rigid[name], one) for name, one in found.items()}
    if sheet.support is None:
        return found
    return found | {"mode_coupling": np.where(coupled, full, _larger(full, 0 * full))}


def _balance(*terms: Any) -> Any:
    """Sum of terms over the sum of their sizes; zero if all are zero."""
    size = sum(map(_size, terms))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.where(np.real(size) == 0, 0.0, sum(terms) / size)


def _size(term: Any) -> Any:
    return np.where(np.real(term) < 0, -term, term) if np.iscomplexobj(term) else np.abs(term)


def _larger(a: Any, b: Any) -> Any:
    return np.where(np.real(a) >= np.real(b), a, b)


def _full_reserve(parameters: dict[str, Any], law: Any) -> Any:
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
    sizes = tuple(map(_size, p))
    for order in range(3, len(p) - 1, 2):
        size = hurwitz(sizes, order, same=True)
        with np.errstate(invalid="ignore", divide="ignore"):
            one = np.where(np.real(size) == 0, 0.0, hurwitz(p, order) / size)
        found = np.where(np.real(one) < np.real(found), one, found)
    return np.where(_any_negative(p[1:-1]), -1.0, found)


def _any_negative(coefficients: tuple[Any, ...]) -> Any:
    """Whether one of some coefficients is not positive."""
    return reduce(np.logical_or, [np.real(x) <= 0 for x in coefficients])


def drive_of(sheet: Sheet, values: Values, direction: int, speed: float, force: float, parts: Parts = ()) -> Drive:
    """Return the drive at one point of operation: rigid, or with some ``parts`` of the sheet.

    It has the law of friction of the sheet, if there is one, else the coefficient at that point.
    """
    given = sheets.point(sheet, values, direction, speed, force)[0] | sheets.own_parameters(values, parts)
    if sheet.friction.law:
        given |= sheets.friction_law(sheet, values, given["lead_angle"])
    return Drive(**{key: zero_if_close(key, float(value)) for key, value in given.items()})


@dataclass(frozen=True)
class Worst:
    """The lowest reserve of a mechanism in the window, arrays (n): ``reserve``, and where it is.

    ``corner``: the number of the point of :func:`corners` that has it, or the point next to it, as ``speed`` [rad/s]
    may lie between two of them, at the direction and force of that point.
    """

    reserve: NDArray[np.float64]
    corner: NDArray[np.int64]
    speed: NDArray[np.float64]

    def place(self, places: list[Corner]) -> Corner:
        """Return direction, speed [rad/s] and force [N] of the lowest reserve of a single drive, from its corners."""
        direction, _, force = places[int(self.corner[0])]
        return int(direction), float(self.speed[0]), float(force)


def directions(sheet: Sheet) -> tuple[int, ...]:
    """Return the directions of travel, 1 outward and −1 back."""
    return {"out": (1,), "back": (-1,), "both": (1, -1)}[sheet.operation.direction]


def corners(sheet: Sheet, values: Values) -> list[Corner]:
    """Return direction, speed [rad/s] and force [N] of the points of the window where a reserve can be lowest.

    They are those of docs/assess.md: with rigid parts reserves of damping are monotonic in the size of R̃.
    """
    return [
        (direction, speed, force)
        for direction in directions(sheet)
        for speed, force in zip(*window_points(sheet, values, direction), strict=True)
    ]


def window_points(sheet: Sheet, values: Values, direction: int, between: bool = True) -> tuple[NDArray, NDArray]:
    """Speeds [rad/s] and forces [N] of all corners of one direction: (k) for one drive, (k, n) for arrays of drives.

    ``between``: with a support also between the ends of |R̃|, where its reserves need not be monotonic.
    """
    shares = np.linspace(_BESIDE, 1.0, 3 if between and sheet.support is not None else 1)
    shape = np.broadcast_shapes(*map(np.shape, values.values()))
    values = {key: np.broadcast_to(value, shape) for key, value in values.items()}
    p = without_friction(values, direction, 1.0, 0.0)
    drag = p["pitch_radius"] * np.tan(p["lead_angle"]) * p["translation_damping"] * direction  # R̃ = R − drag Ω
    own = p["axial_force"] - p.get("slide_friction", 0.0) * direction

    def within(key: str, points: Any) -> NDArray:
        low, high = values[f"{key}_low"], values[f"{key}_high"]
        points = np.where(np.real(points) > np.real(low), points, low)
        return np.where(np.real(points) < np.real(high), points, high)

    def beside(key: str, balance: Any) -> list[NDArray]:
        """From where |R̃| is least to the ends of the window."""
        nearest = within(key, balance)
        return [nearest + np.multiply.outer(shares, values[f"{key}_{end}"] - nearest) for end in ("low", "high")]

    speeds = values["speed_low"][None]
    pushed = ("low", "high") if is_window(sheet, "load.force") else ("low",)
    if is_window(sheet, "operation.speed"):
        rows = [within("speed", speed) for speed in _own_speeds(sheet, values, p)]
        for end in pushed if sheet.friction.sloped else ():
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # where nothing drags
                rows += beside("speed", np.divide(own - values[f"force_{end}"], drag))
        speeds = np.sort(np.concatenate(rows), axis=0)
    sides = [values[f"force_{end}"][None] for end in pushed]
    if sheet.friction.sloped and len(pushed) > 1:
        sides += [force for rows in beside("force", own - drag * speeds) for force in rows]
    forces = np.stack([np.broadcast_to(side, speeds.shape) for side in sides], axis=1)  # of each speed one by one
    return np.repeat(speeds, forces.shape[1], axis=0), forces.reshape(-1, *forces.shape[2:])


def _own_speeds(sheet: Sheet, values: Values, p: Values) -> list[NDArray]:
    """Speeds [rad/s] over which friction is looked at (k, ...): the ends of the window, and what friction has."""
    sliding = sliding_speed(1.0, p["pitch_radius"], p["lead_angle"])
    low, high = values["speed_low"], values["speed_high"]
    curve = sheet.friction.curve
    steps = np.linspace(0.0, 1.0, 2 if curve is None else 17)  # between points of a curve only its level changes
    rows = [low + np.multiply.outer(steps, high - low)]
    if curve is not None:
        rows.append(np.divide.outer(np.multiply.outer(curve.speeds, (1 - _BESIDE, 1 + _BESIDE)).ravel(), sliding))
    if sheet.friction.law:
        rows.append(low * (high / low) ** np.reshape(_SHARES, (-1, *np.ndim(low) * (1,))))
        if sheet.friction.stribeck_rise is not None:
            rows.append(np.multiply.outer(_FADING, values["stribeck_speed"] / sliding))
        if sheet.friction.slope is not None:
            rows.append((_frictionless(sheet, values, p) / sliding * (1 - _BESIDE))[None])
    return rows


def _frictionless(sheet: Sheet, values: Values, p: Values) -> NDArray:
    """The sliding speed [m/s] at which a falling law reaches zero, before which it weighs most; zero if it rises."""
    law = SimpleNamespace(**sheets.friction_law(sheet, values, p["lead_angle"]))
    slope = np.where(np.real(law.friction_slope) < 0, law.friction_slope, -np.inf)
    low, high = -law.friction_coefficient / slope, -(law.friction_coefficient + law.stribeck_rise) / slope
    for _ in range(30):  # to its distance from the place, see below
        middle = 0.5 * (low + high)
        rubs = np.real(friction.unbounded_coefficient(law, middle)) > 0
        low, high = np.where(rubs, middle, low), np.where(rubs, high, middle)
    return low


def worst(sheet: Sheet, values: Values, between: bool = True) -> dict[str, Worst]:
    """Return the lowest reserve of each mechanism over the window for drives given by arrays (n) or floats.

    ``between``: as of :func:`window_points`.

    ``after_perturbation`` is among them, see :func:`lsvib.assess.mechanisms.reserves`. NaN where the friction is so
    strong that the drive cannot move at all.
    """
    count = max(np.size(value) for value in values.values())
    step = max(AT_ONCE // reserves_of(sheet, values), 1)
    parts = [
        _worst(sheet, {key: one[k : k + step] if np.size(one) > 1 else one for key, one in values.items()}, between)
        for k in range(0, count, step)
    ]
    keys = ("reserve", "corner", "speed")
    return {
        name: Worst(*(np.concatenate([getattr(part[name], key) for part in parts]) for key in keys))
        for name in parts[0]
    }


def reserves_of(sheet: Sheet, values: Values) -> int:
    """Return how many points of the window a drive is looked at."""
    one = {key: np.ravel(value)[0] for key, value in values.items()}
    return sum(len(window_points(sheet, one, direction)[0]) for direction in directions(sheet))


def _worst(sheet: Sheet, values: Values, between: bool) -> dict[str, Worst]:
    """The same of all drives at once."""
    shape = np.broadcast_shapes(*map(np.shape, values.values())) or (1,)
    rows, places = [], []
    for direction in directions(sheet):
        speeds, forces = (
            np.broadcast_to(table[:, None] if table.ndim == 1 else table, (len(table), *shape))
            for table in window_points(sheet, values, direction, between)
        )
        rows.append(reserves(sheet, values, direction, speeds, forces))
        places.append((np.full(speeds.shape, direction), speeds, forces))
    side, speed, force = (np.concatenate(tables) for tables in zip(*places, strict=True))
    found = {}
    for name in (*applicable(sheet), "after_perturbation"):
        pairs = zip(rows, places, strict=True)
        table = np.concatenate([np.broadcast_to(row[name], place[1].shape) for row, place in pairs])
        lowest = np.argmin(np.where(np.isnan(np.real(table)), -np.inf, np.real(table)), axis=0)
        there = [np.take_along_axis(one, lowest[None], 0)[0] for one in (table, speed, side, force)]
        reserve, at = there[:2]
        if name == "falling_friction" and sheet.friction.law and is_window(sheet, "operation.speed"):
            reserve, at = _lowest_between(sheet, values, there[2:], there[:2], speed)
        found[name] = Worst(reserve, lowest, at)
    return found


def _lowest_between(sheet: Sheet, values: Values, own: list, best: list, speeds: NDArray) -> tuple[NDArray, NDArray]:
    """The lowest reserve of falling friction (n) between the speeds next to the ``best`` one, by golden sections.

    ``own``: direction and force of it; ``speeds`` (k, n): all that were looked at. Returns reserve and speed.
    """
    reserve, at = best
    low = np.max(np.where(speeds < at, speeds, -np.inf), axis=0)
    high = np.min(np.where(speeds > at, speeds, np.inf), axis=0)
    low, high = np.where(np.isinf(low), at, low), np.where(np.isinf(high), at, high)
    sheet = sheet.model_copy(update={"contact": None})  # which takes no part in it

    def looked(place: NDArray) -> NDArray:
        """Return the reserve at some speeds, and keep the lowest."""
        nonlocal reserve, at
        here = reserves(sheet, values, own[0], place, own[1])["falling_friction"]
        reserve, at = np.where(here < reserve, here, reserve), np.where(here < reserve, place, at)
        return here

    inner = [high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)]
    there = [looked(place) for place in inner]
    for _ in range(7):  # until the ends are a part 2e-2 of their distance apart, in which the reserve is flat
        left = there[0] < there[1]
        low, high = np.where(left, low, inner[0]), np.where(left, inner[1], high)
        new = np.where(left, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
        inner = [np.where(left, new, inner[1]), np.where(left, inner[0], new)]
        value = looked(new)
        there = [np.where(left, value, there[1]), np.where(left, there[0], value)]
    return reserve, at
