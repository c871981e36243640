"""What a drive does when it is switched on: the screw stands with the coupling relaxed, and the motor begins to turn.

The motions are those of :mod:`lsvib.stability.starting`, at the ends of the range of forces in each direction.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import islice, product
from typing import Self

import numpy as np
from numpy.typing import NDArray

from lsvib.assess.drive import GRAVITY
from lsvib.assess.margins import Margin, changeable, scaled
from lsvib.assess.mechanisms import directions, drive_of
from lsvib.assess.sheet import Sheet
from lsvib.assess.vibration import Vibration, vibration, work_of_many
from lsvib.errors import InputError
from lsvib.stability.starting import runs_evenly

BEYOND = 10.0  # how many times below and above the window speeds are tried
_STEPS = 6  # of these speeds, from end to end
_CLOSE = 1e-3  # relative, to which a speed or a factor is closed in on
_FACTORS = (1.5, 3.0)  # and their inverses: changes of one quantity that are tried
_DRAWS = 16  # random drives that are started
_WORK = 2_000  # of a motion, a fraction of a second where friction follows a law
Place = tuple[int, float]  # direction of travel, force [N]
Values = Mapping[str, float]  # quantities of a drive


@dataclass(frozen=True)
class Starting:
    """What becomes of a drive that is started from rest.

    ``jerks``: whether it goes on vibrating at some speed of the window, at the middle values; None where that is not
    known. ``corner``: direction, speed [rad/s] and force [N] of the slowest such point, or where it is nearest to that;
    ``even_speed`` [rad/s] of the screw there, from which on it runs evenly, None where there is none or it is not
    known. ``motion`` from rest at the corner, if it jerks. ``of_static``: whether friction at rest is the cause, as the
    drive runs evenly without what it has above that of sliding. ``changes`` of one quantity by no more than a factor of
    three that end it in the whole window, the smallest first. ``share`` of ``drawn`` drives that jerk at the lowest
    speed of that corner.
    """

    jerks: bool | None
    corner: tuple[int, float, float]
    even_speed: float | None
    motion: Vibration | None
    of_static: bool
    changes: list[Margin]
    share: float
    drawn: int

    @classmethod
    def even(cls, corner: tuple[int, float, float]) -> Self:
        """Return what is said of a drive of which every motion is known to become steady."""
        return cls(False, corner, None, None, False, [], 0.0, 0)


def starting(
    sheet: Sheet, values: dict[str, float], parts: tuple[str, ...], draws: Iterable[Values], advise: bool = True
) -> Starting:
    """Start a drive at the middle values, and some of ``draws``, the quantities of random ones.

    ``advise``: whether changes that end jerks are looked for.

    With parts that comply the corner is that of the drive with rigid ones, and there the whole drive is started.
    """
    places = [(direction, force) for direction in directions(sheet) for force in _forces(values)]
    low, high = values["speed_low"], values["speed_high"]
    tried = _speeds(values)
    window = [speed for speed in tried if low <= speed <= high]
    found = {at: even_from(lambda speed, at=at: evenly(sheet, values, at, speed), tried, high) for at in places}
    often = {at: sum(evenly(sheet, values, at, speed) is False for speed in window) for at in places}
    place = max(places, key=lambda at: (often[at], found[at] or 0.0))
    even_speed = found[place]
    if parts:
        even_speed = even_from(lambda speed: evenly(sheet, values, place, speed, parts), tried, high)
    jerky = [speed for speed in window if evenly(sheet, values, place, speed, parts) is False]
    corner = place[0], jerky[0] if jerky else low, place[1]
    if not jerky:
        ends = [evenly(sheet, own, place, low, parts) for own in islice(draws, _DRAWS)]
        jerks = None if even_speed is None else False
        return replace(
            Starting.even(corner),
            jerks=jerks,
            even_speed=even_speed or None,
            share=ends.count(False) / max(len(ends), 1),
            drawn=len(ends),
        )
    level = {**values, "static_friction": 0.0}
    of_static = "static_friction" in values and evenly(sheet, level, place, corner[1], parts) is True
    asked = [(place, corner[1]), *product(places, window)]
    found_changes = _changes(sheet, values, parts, asked) if advise else ()
    changes = sorted(found_changes, key=lambda row: abs(math.log(row.factor or 1.0)))
    motion = vibration(sheet, values, corner, parts, rest=True)
    return Starting(True, corner, even_speed or None, motion, of_static, changes, 1.0, 0)


def _speeds(values: Values) -> list[float]:
    """Speeds of the window [rad/s] and far beyond it, in ascending order."""
    low, high = values["speed_low"], values["speed_high"]
    beyond = np.geomspace(low / BEYOND, BEYOND * high, _STEPS + 1)
    return np.unique([*beyond[(beyond < low) | (beyond > high)], low, math.sqrt(low * high), high]).tolist()


def evenly(sheet: Sheet, values: Values, place: Place, speed: float, parts: tuple[str, ...] = ()) -> bool | None:
    """Whether a drive with some parts runs evenly once started from rest; None where that is not known."""
    try:
        drive = drive_of(sheet, values, place[0], speed, place[1], parts)
    except InputError:
        return None
    return runs_evenly(drive, min(_WORK, work_of_many(parts)))


def _forces(values: Values) -> list[float]:
    """The ends of the window of forces [N]; of two that push the same way, weight included, the larger one."""
    weight = values["mass"] * GRAVITY * math.sin(values["tilt"])
    low, high = sorted((values["force_low"], values["force_high"]), key=lambda force: abs(force + weight))
    return [high] if (low + weight) * (high + weight) >= 0 else [low, high]


def even_from(evenly: Callable[[float], bool | None], tried: list[float], high: float) -> float | None:
    """Return the speed from which on a drive runs evenly, up to ``high`` at least; zero if at all lower ones, too.

    It is looked for from ``high``, one of the ascending speeds ``tried``, downwards if it runs evenly there, else
    upwards. None where there is none or it is not known.
    """
    k = tried.index(high)
    even = evenly(high)
    while even is not None:
        k += -1 if even else 1
        if not 0 <= k < len(tried):
            return 0.0 if even else None
        other = evenly(tried[k])
        if other is not None and other != even:
            break
        even = other
    else:
        return None
    jerks, quiet = (tried[k], tried[k + 1]) if even else (tried[k - 1], tried[k])
    while quiet - jerks > _CLOSE * quiet:
        middle = math.sqrt(jerks * quiet)
        if (there := evenly(middle)) is None:
            return quiet
        jerks, quiet = (jerks, middle) if there else (middle, quiet)
    return quiet


def _changes(
    sheet: Sheet, values: dict[str, float], parts: tuple[str, ...], asked: list[tuple[Place, float]]
) -> Iterator[Margin]:
    """The changes of one quantity that end the jerks at the first of the points ``asked``, and at all of them."""

    def quiet(keys: tuple[str, ...], factor: float, points: list[tuple[Place, float]]) -> bool:
        """Whether the changed drive runs evenly at some points of its window."""
        own = scaled(sheet, values, keys, factor)
        moved = own["speed_low"] / values["speed_low"]
        return all(evenly(sheet, own, place, speed * moved, parts) for place, speed in points)

    for name, keys in changeable(values).items():
        sides = [list(_FACTORS), [1 / factor for factor in _FACTORS]]
        if name == "static_friction":  # it cannot be below that of slow sliding, nor that by rounding
            least = (values["friction"] + values.get("stribeck_rise", 0.0)) / values["static_friction"] * (1 + 1e-12)
            sides = [[*(factor for factor in sides[1] if factor > least), least]]
        ends = []
        for factors in sides:
            good = next((factor for factor in factors if quiet(keys, factor, asked[:1])), None)
            if good is None:
                continue
            bad = ([1.0, *factors])[factors.index(good)]
            while abs(math.log(good / bad)) > _CLOSE:
                middle = math.sqrt(good * bad)
                bad, good = (bad, middle) if quiet(keys, middle, asked[:1]) else (middle, good)
            if quiet(keys, good, asked):
                ends.append(good)
        if ends:
            best = min(ends, key=lambda factor: abs(math.log(factor)))
            yield Margin(name, best, best * max((values[key] for key in keys), key=abs))


def even_speeds(
    sheet: Sheet, values: Values, direction: int, forces: NDArray, parts: tuple[str, ...]
) -> NDArray[np.float64]:
    """Return the even speed [rad/s] of the screw at each force [N] in one direction; NaN where it is not known.

    With rigid parts and friction that does not depend on the speed it is proportional to the whole force on either side
    of zero, as every motion is multiplied if both are; else it is interpolated.
    """
    tried, high = _speeds(values), values["speed_high"]
    weight = values["mass"] * GRAVITY * math.sin(values["tilt"])
    knots = np.clip([forces.min(), -weight, forces.max()], forces.min(), forces.max())
    if not sheet.closed:
        knots = np.unique(np.r_[knots, np.quantile(forces, (0.25, 0.5, 0.75))])

    def at(force: float) -> float:
        """The even speed at a force."""

        found = even_from(lambda speed: evenly(sheet, values, (direction, force), speed, parts), tried, high)
        return math.nan if found is None else found

    return np.interp(forces, knots, [at(float(force)) for force in knots])
