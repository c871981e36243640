"""The window of operation: the points at which a reserve can be lowest, and the lowest of each mechanism."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lsvib.drives import friction
from lsvib.sheets import vibration
from lsvib.sheets.draw import Draw, Operation
from lsvib.sheets.formulas import sliding_speed
from lsvib.sheets.reserves import NAMES
from lsvib.sheets.sheet import Sheet

Array = NDArray[Any]  # of floats
Pair = tuple[Array, Array]
AT_ONCE = 2**17  # reserves, few enough for the processor's caches, many enough for NumPy
_FADING = (0.05, 0.1, 0.2, 0.35, 0.6, 1.0, 1.6, 2.5, 4.0, 7.0)  # of the speed over which a rise of friction fades
_SHARES = np.linspace(0, 1, 8)[1:-1]  # of the window, in logarithm
_GOLDEN = 0.5 * (math.sqrt(5) - 1)
_BESIDE = 1e-9  # how near to R̃ = 0, or to a law of zero, relative: far above rounding


class Worst(NamedTuple):
    """The lowest ``reserve`` [1] of a mechanism in the window, arrays (n), and the point of operation that has it."""

    reserve: NDArray[np.float64]
    direction: NDArray[np.int64]
    speed: NDArray[np.float64]
    force: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class OperatingWindow:
    """The window of one drive: where it is weakest, asked once."""

    draw: Draw

    @cached_property
    def corners(self) -> list[Operation]:
        """The points of the window where a reserve can be lowest.

        They are those of docs/assess.md: with rigid parts reserves of damping are monotonic in the size of R̃.
        """
        return [
            Operation(self.draw, direction, speed, force)
            for direction in self.draw.sheet.directions
            for speed, force in zip(*points(self.draw, direction), strict=True)
        ]

    @cached_property
    def worst(self) -> dict[str, Worst]:
        """The lowest reserve of each mechanism, see :func:`worst`."""
        return worst(self.draw)

    @cached_property
    def most_perturbed(self) -> tuple[bool | None, float, Operation | None]:
        """Return whether a perturbation starts vibration of a drive, the smallest of the rigid one, and where.

        Asked is the exact basin at every corner of the window where Γ₊ or C₊ is negative, as none does without (docs);
        where it is not known, a motion after a strong perturbation. None if that does not show it either. The smallest
        is in rad/s, infinite if there is none.
        """
        sizes, sheet = {}, self.draw.sheet
        places = {at.corner: at for at in self.corners if sheet.followed or at.reserves["after_perturbation"] < 0}
        for corner, there in places.items():
            calm, size = ("steady sliding", *vibration.UNDECIDED), there.tolerated[0] if sheet.stiff else None
            # One that is not known, or of a drive that nothing damps, a motion shows.
            sizes[corner] = size or (None if there.after_knock in calm else vibration.STRONG * there.speed)
        known = {corner: size for corner, size in sizes.items() if size is not None}
        size, first = min(((size, corner) for corner, size in known.items()), default=(math.inf, None))
        started = True if size < math.inf else None if len(known) < len(sizes) else False
        return started, size, places[first] if first else None

    def critical(self, mechanism: str) -> Operation:
        """Return the point of the window at which the drive has the lowest reserve of a mechanism."""
        _, direction, speed, force = (float(one[0]) for one in self.worst[mechanism])
        return Operation(self.draw, int(direction), speed, force)


def applicable(sheet: Sheet) -> tuple[str, ...]:
    """Return the mechanisms that a sheet has the parts for."""
    missing = {"mode_coupling": sheet.support is None, "thread_contact": sheet.contact is None}
    return tuple(name for name in NAMES if not missing.get(name, False))


def points(draw: Draw, direction: int, between: bool = True) -> tuple[Array, Array]:
    """Speeds [rad/s] and forces [N] of all corners of one direction: (k) for one drive, (k, n) for arrays of drives.

    ``between``: with a support also between the ends of |R̃|, where its reserves need not be monotonic.
    """
    sheet, shape = draw.sheet, draw.shape
    shares = np.linspace(_BESIDE, 1.0, 3 if between and sheet.support is not None else 1)
    draw = replace(draw, values={key: np.broadcast_to(value, shape) for key, value in draw.values.items()})
    values = draw.values
    # R̃ = R − drag Ω, of which R is own less the force.
    drag = draw.pitch_radius * np.tan(draw.lead_angle) * values["translation_damping"] * direction
    own = -draw.weight - values.get("slide_friction", 0.0) * direction

    def within(key: str, places: Any) -> Array:
        low, high = values[f"{key}_low"], values[f"{key}_high"]
        places = np.where(places > low, places, low)
        return np.asarray(np.where(places < high, places, high))

    def beside(key: str, balance: Any) -> list[Array]:
        """From where |R̃| is least to the ends of the window."""
        nearest = within(key, balance)
        return [nearest + np.multiply.outer(shares, values[f"{key}_{end}"] - nearest) for end in ("low", "high")]

    speeds = values["speed_low"][None]
    pushed = ("low", "high") if sheet.is_window("load.force") else ("low",)
    if sheet.is_window("operation.speed"):
        rows = [within("speed", speed) for speed in _own_speeds(draw)]
        for end in pushed if sheet.friction.sloped else ():
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # where nothing drags
                rows += beside("speed", np.divide(own - values[f"force_{end}"], drag))
        speeds = np.sort(np.concatenate(rows), axis=0)
    sides = [values[f"force_{end}"][None] for end in pushed]
    if sheet.friction.sloped and len(pushed) > 1:
        sides += [force for rows in beside("force", own - drag * speeds) for force in rows]
    forces = np.stack([np.broadcast_to(side, speeds.shape) for side in sides], axis=1)  # of each speed one by one
    return np.repeat(speeds, forces.shape[1], axis=0), forces.reshape(-1, *forces.shape[2:])


def _own_speeds(draw: Draw) -> list[Array]:
    """Speeds [rad/s] over which friction is looked at (k, ...): the ends of the window, and what friction has."""
    given, sliding = draw.sheet.friction, sliding_speed(1.0, draw.pitch_radius, draw.lead_angle)
    low, high = draw.values["speed_low"], draw.values["speed_high"]
    rows = [low + np.multiply.outer((0.0, 1.0), high - low)]
    if given.law:
        rows.append(low * (high / low) ** np.reshape(_SHARES, (-1, *np.ndim(low) * (1,))))
        if given.stribeck_rise is not None:
            rows.append(np.multiply.outer(_FADING, draw.values["stribeck_speed"] / sliding))
        if given.slope is not None:
            rows.append((_frictionless(draw) / sliding * (1 - _BESIDE))[None])
    return rows


def _frictionless(draw: Draw) -> Array:
    """The sliding speed [m/s] at which a falling law reaches zero, before which it weighs most; zero if it rises."""
    law = SimpleNamespace(**draw.friction_law)
    slope = np.where(law.friction_slope < 0, law.friction_slope, -np.inf)
    low, high = -law.friction_coefficient / slope, -(law.friction_coefficient + law.stribeck_rise) / slope
    for _ in range(30):  # to its distance from the place, see below
        middle = 0.5 * (low + high)
        rubs = friction.unbounded(law, middle)[0] > 0
        low, high = np.where(rubs, middle, low), np.where(rubs, high, middle)
    return np.asarray(low)


def count_of(draw: Draw) -> int:
    """Return at how many points of the window a drive is looked at."""
    one = replace(draw, values={key: np.ravel(value)[0] for key, value in draw.values.items()})
    return sum(len(points(one, direction)[0]) for direction in draw.sheet.directions)


def worst(draw: Draw, between: bool = True) -> dict[str, Worst]:
    """Return the lowest reserve of each mechanism over the window for one drive or arrays (n) of them.

    ``between``: as of :func:`points`. ``after_perturbation`` is among them, see
    :func:`lsvib.sheets.reserves.reserves`. NaN where the friction is so strong that the drive cannot move at all.
    """
    count, values = max(np.size(value) for value in draw.values.values()), draw.values
    step = max(AT_ONCE // count_of(draw), 1) if count > 256 else count  # of few, asking takes longer than all
    blocks = (
        {key: one[k : k + step] if np.size(one) > 1 else one for key, one in values.items()}
        for k in range(0, count, step)
    )
    parts = [_worst(replace(draw, values=block), between) for block in blocks]
    return {name: Worst(*map(np.concatenate, zip(*(one[name] for one in parts), strict=True))) for name in parts[0]}


def _worst(draw: Draw, between: bool) -> dict[str, Worst]:
    """The same of all drives at once."""
    shape, rows, places = draw.shape or (1,), [], []
    for direction in draw.sheet.directions:
        speeds, forces = (
            np.broadcast_to(table[:, None] if table.ndim == 1 else table, (len(table), *shape))
            for table in points(draw, direction, between)
        )
        rows.append(Operation(draw, direction, speeds, forces).reserves)
        places.append((np.full(speeds.shape, direction), speeds, forces))
    side, speed, force = (np.concatenate(tables) for tables in zip(*places, strict=True))
    found = {}
    for name in (*applicable(draw.sheet), "after_perturbation"):
        pairs = zip(rows, places, strict=True)
        table = np.concatenate([np.broadcast_to(row[name], place[1].shape) for row, place in pairs])
        lowest = np.argmin(np.where(np.isnan(table), -np.inf, table), axis=0)
        there = (np.take_along_axis(one, lowest[None], 0)[0] for one in (table, side, speed, force))
        reserve, way, at, push = there
        if name == "falling_friction" and draw.sheet.friction.law and draw.sheet.is_window("operation.speed"):
            reserve, at = _lowest_between(draw, (way, push), (reserve, at), speed)
        found[name] = Worst(reserve, way, at, push)
    return found


def _lowest_between(draw: Draw, own: Pair, best: Pair, speeds: Array) -> Pair:
    """The lowest reserve of falling friction (n) between the speeds next to the ``best`` one, by golden sections.

    ``own``: direction and force of it; ``speeds`` (k, n): all that were looked at. Returns reserve and speed.
    """
    reserve, at = best
    low = np.max(np.where(speeds < at, speeds, -np.inf), axis=0)
    high = np.min(np.where(speeds > at, speeds, np.inf), axis=0)
    low, high = np.where(np.isinf(low), at, low), np.where(np.isinf(high), at, high)
    draw = replace(draw, sheet=draw.sheet.model_copy(update={"contact": None}))  # which takes no part in it

    def looked(place: Array) -> Array:
        """Return the reserve at some speeds, and keep the lowest."""
        nonlocal reserve, at
        here = Operation(draw, own[0], place, own[1]).reserves["falling_friction"]
        reserve, at = np.where(here < reserve, here, reserve), np.where(here < reserve, place, at)
        return np.asarray(here)

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
