"""What a drive does when it is switched on: the screw stands with the coupling relaxed, and the motor begins to turn.

The motions are those of :mod:`lsvib.stability.starting`, at the ends of the range of forces in each direction.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice, pairwise, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.assess.margins import Margin, changeable
from lsvib.assess.operation import Draw, Operation
from lsvib.assess.vibration import Vibration, work_of_many
from lsvib.errors import InputError
from lsvib.models.drive import STATIC
from lsvib.stability.starting import even_from, runs_evenly

BEYOND = 10.0  # how many times below and above the window speeds are tried
_STEPS = 6  # of these speeds, from end to end
_CLOSE = 1e-3  # relative, to which a factor is closed in on
_FACTORS = (1.5, 3.0)  # and their inverses: changes of one quantity that are tried
_DRAWS = 16  # random drives that are started
_WORK = 2_000  # of a motion, a fraction of a second where friction follows a law
_CONTACTS = ("threads", "guide", "bearing")  # whose friction at rest STATIC has
Place = tuple[int, float]  # direction of travel, force [N]


@dataclass(frozen=True)
class Starting:
    """What becomes of a drive that is started from rest.

    ``jerks``: whether it goes on vibrating at some speed of the window, at the middle values; None where that is not
    known. ``there``: the slowest such point of operation, or where it is nearest to that; ``even_speed`` [rad/s] of the
    screw there, from which on it runs evenly: zero if at all speeds tried, infinite if at none up to :data:`BEYOND`
    times the highest, None where it is not known. ``motion`` from rest there, if it jerks. ``cause`` there:
    ``threads``, ``guide`` or ``bearing``, without whose surplus of friction at rest it runs evenly, ``static``, if it
    does without that of all of these, ``law``, if without any change of friction with the speed, else empty.
    ``changes`` of one quantity by no more than a factor of three that end it at all points of the window that are
    tried, the smallest first. ``share`` of ``drawn`` drives that jerk at the lowest speed there.
    """

    jerks: bool | None
    there: Operation
    even_speed: float | None
    motion: Vibration | None = None
    cause: str = ""
    changes: list[Margin] = field(default_factory=list)
    share: float = 0.0
    drawn: int = 0


def starting(draw: Draw, draws: Iterable[Draw], advise: bool = True) -> Starting:
    """Start a drive at the middle values, and some of ``draws``, random ones.

    ``advise``: whether changes that end jerks are looked for.

    With parts that comply the corner is that of the drive with rigid ones, and there the whole drive is started.
    """
    places = [(direction, force) for direction in draw.sheet.directions for force in _forces(draw)]
    low, high = draw.values["speed_low"], draw.values["speed_high"]
    beyond = np.geomspace(low / BEYOND, BEYOND * high, _STEPS + 1)
    tried = np.unique([*beyond[(beyond < low) | (beyond > high)], low, math.sqrt(low * high), high]).tolist()
    window = [speed for speed in tried if low <= speed <= high]

    def stiffly(place: Place, speed: float) -> bool | None:
        """Whether the drive with rigid parts runs evenly."""
        return evenly(draw.at(place[0], speed, place[1]), stiff=True)

    def whole(speed: float, own: Draw = draw) -> bool | None:
        """Whether the whole drive runs evenly at the worst place."""
        return evenly(own.at(place[0], speed, place[1]))

    found = {at: even_from(lambda speed, at=at: stiffly(at, speed), tried, high) for at in places}
    often = {at: sum(stiffly(at, speed) is False for speed in window) for at in places}
    place = max(places, key=lambda at: (often[at], found[at] or 0.0))  # what is not known counts as quiet
    even_speed = found[place] if draw.sheet.stiff else even_from(whole, tried, high)
    jerky = [speed for speed in window if whole(speed) is False]
    there = draw.at(place[0], jerky[0] if jerky else low, place[1])
    if not jerky:
        ends = [whole(low, own) for own in islice(draws, _DRAWS)]
        jerks, share = None if even_speed is None else False, ends.count(False) / max(len(ends), 1)
        return Starting(jerks, there, even_speed, share=share, drawn=len(ends))
    own = zip(_CONTACTS, STATIC, strict=True)
    without = {where: {static: 0.0} for where, static in own if static in draw.values}
    if draw.sheet.followed:
        without["static"] = {static: 0.0 for one in without.values() for static in one}
        without["law"] = {**without["static"], "stribeck_rise": 0.0, "friction_slope": 0.0}
    causes = (name for name, none in without.items() if whole(there.speed, draw.changed(**none)))
    asked = [(place, there.speed), *product(places, window)]
    changes = sorted(_changes(draw, asked) if advise else (), key=lambda row: abs(math.log(row.factor or 1.0)))
    return Starting(True, there, even_speed, there.motion(None), next(causes, ""), changes, share=1.0)


def evenly(there: Operation, stiff: bool = False) -> bool | None:
    """Whether a drive, or the one with rigid parts, runs evenly once started from rest; None where it is not known."""
    try:
        drive = there.rigid if stiff else there.drive
    except InputError:
        return None
    return runs_evenly(drive, min(_WORK, work_of_many(() if stiff else there.draw.sheet.parts)))


def _forces(draw: Draw) -> list[float]:
    """The ends of the window of forces [N]; of two that push the same way, weight included, the larger one."""
    weight, ends = draw.weight, (draw.values["force_low"], draw.values["force_high"])
    low, high = sorted(ends, key=lambda force: abs(force + weight))
    return [high] if (low + weight) * (high + weight) >= 0 else [low, high]


def _changes(draw: Draw, asked: list[tuple[Place, float]]) -> Iterator[Margin]:
    """The changes of one quantity that end the jerks at the first of the points ``asked``, and at all of them."""
    values = draw.values

    def quiet(keys: tuple[str, ...], factor: float, points: list[tuple[Place, float]]) -> bool:
        """Whether the changed drive runs evenly at some points of its window."""
        own = draw.scaled(keys, factor)
        faster, more = own.values["speed_low"] / values["speed_low"], factor if "force_low" in keys else 1.0
        return all(evenly(own.at(way, faster * speed, more * force)) for (way, force), speed in points)

    for name, keys in changeable(values).items():
        sides = [list(_FACTORS), [1 / factor for factor in _FACTORS]]
        if slowest := STATIC.get(name):  # it cannot be below that of slow sliding, nor that by rounding
            least = sum(values.get(key, 0.0) for key in slowest) / values[name] * (1 + 1e-12)
            sides = [[*(factor for factor in sides[1] if factor > least), *([least] if least else [])]]
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


def outcomes(draw: Draw, direction: int, turning: NDArray[Any], force: NDArray[Any]) -> NDArray[np.float64]:
    """Return 1 where a drive runs evenly from rest, 0 where it does not, NaN where that is not known (force, speed).

    Arguments: speeds of the screw [rad/s] and forces [N]. With rigid parts, where only the threads rub and their
    friction does not change with the speed of sliding, every motion is multiplied if speed and whole force are, so that
    their ratio decides: it is sampled on either side of zero, and each change is closed in on. Else a point has the
    answer of the nearest of 9 by 9.
    """

    def asked(speed: float, push: float) -> float:
        """The answer at a point."""
        found = evenly(draw.at(direction, speed, push))
        return math.nan if found is None else float(found)

    if not draw.sheet.stiff or draw.sheet.dry or draw.sheet.friction.sloped:
        speeds, forces = (np.linspace(axis[0], axis[-1], 9) for axis in (turning, force))
        table = np.array([[asked(speed, push) for speed in speeds.tolist()] for push in forces.tolist()])
        return table[np.ix_(_nearest(forces, force), _nearest(speeds, turning))]
    weight, speed = draw.weight, draw.values["speed_high"]
    ratio = (force[:, None] + weight) / turning
    sizes = np.geomspace(1e-4, 1.0, 60) * np.abs(ratio).max()
    known = {one: asked(speed, one * speed - weight) for one in [*-sizes[::-1], *sizes]}
    for (low, first), (high, last) in pairwise(list(known.items())):
        for _ in range(8 * (first != last and low * high > 0)):  # to 1e-3
            middle = math.copysign(math.sqrt(low * high), low)
            known[middle] = asked(speed, middle * speed - weight)
            low, high = (middle, high) if known[middle] == first else (low, middle)
    places = np.array(sorted(known))
    return np.array([known[one] for one in places.tolist()])[_nearest(places, ratio)]


def _nearest(places: NDArray[Any], x: NDArray[Any]) -> NDArray[np.int64]:
    """The index of the nearest of some ascending places."""
    return np.searchsorted(0.5 * (places[1:] + places[:-1]), x)
