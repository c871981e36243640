"""What a drive does when it is switched on: the screw stands with the coupling relaxed, and the motor begins to turn.

The motions are those of :mod:`lsvib.stability.starting`, with the ramp of the sheet if it has one, at the ends of the
range of forces in each direction; and the operating chart, which says what happens at each speed and force.
"""

import math
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.drives.drive import STATIC
from lsvib.errors import EngineError, InputError
from lsvib.sheets.draw import Draw, Operation
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.vibration import Vibration
from lsvib.sheets.window import applicable
from lsvib.stability.starting import even_from, runs_evenly

BEYOND = 10.0  # how many times below and above the window speeds are tried
_STEPS = 6  # of these speeds, from end to end
_DRAWS = 256  # random drives that are started; a quarter with parts that comply, an eighth with a law besides
_ENDS = 64  # combinations of ends of the uncertain entries, likewise
# Work of a motion, and of all those of a sheet that come to no end, in events; what is beyond gets the least.
_WORK, _WORK_OF_LAW, _SUM, _LEAST = 100_000, 20_000, 40, 4_000
_CONTACTS = ("threads", "guide", "bearing")  # whose friction at rest STATIC has
Place = tuple[int, float]  # direction of travel, force [N]


class Starter:
    """Starts drives of one sheet from rest; those that come to no end share an allowance of work."""

    def __init__(self, sheet: Sheet) -> None:
        law = sheet.friction.law and sheet.friction.sloped  # over the speed, whose motions take longer
        few = 1 if sheet.stiff else 8 if law else 4
        self.draws, self.ends = _DRAWS // few, _ENDS // few
        self.work = _WORK_OF_LAW if law else _WORK
        self.left = _SUM * self.work

    def evenly(self, there: Operation, stiff: bool = False) -> bool | None:
        """Whether a drive, or the one with rigid parts, comes to run evenly; None where it is not known."""
        work, found = self.work if self.left > 0 else _LEAST, None
        with suppress(InputError, EngineError):  # out of range, or with a ramp that takes too long
            drive = there.rigid if stiff else there.drive
            found = runs_evenly(drive, work, there.started(drive, work))
        self.left -= work if found is None else 0
        return found


@dataclass(frozen=True)
class FromRest:
    """What becomes of a drive that is started from rest.

    ``jerks``: whether it goes on vibrating at some speed of the window, at the middle values; None where that is not
    known. ``there``: the slowest such point of operation, or where it is nearest to that; ``even_speed`` [rad/s] of the
    screw there, from which on it runs evenly: zero if at all speeds tried, infinite if at none up to :data:`BEYOND`
    times the highest, None where it is not known. ``motion`` from rest there, if it jerks. ``cause`` there:
    ``threads``, ``guide`` or ``bearing``, without whose surplus of friction at rest it runs evenly, ``static``, without
    that of all of these, ``law``, without any change of friction with the speed, ``unknown``, or empty. Of ``drawn``
    random drives ``jerky`` ones do so there, of ``unknown`` ones it is not known; ``ends``: whether one with all
    uncertain entries at an end of theirs does, at the lowest speed. ``unstable``: directions of travel in which no
    drive is started, as steady running is unstable there.
    """

    jerks: bool | None
    there: Operation
    even_speed: float | None
    motion: Vibration | None = None
    cause: str = ""
    drawn: int = 0
    jerky: int = 0
    unknown: int = 0
    ends: bool | None = False
    unstable: tuple[int, ...] = ()

    @property
    def share(self) -> float | None:
        """The part of the drawn drives that jerks, of those of which it is known; None if of none."""
        if not self.drawn:
            return None if self.jerks is None else float(self.jerks)
        known = self.drawn - self.unknown
        return self.jerky / known if known else None


def any_jerks(answers: Iterable[bool | None]) -> bool | None:
    """Whether one of some drives does not run evenly, by whether each does; None where that is not known."""
    found = list(answers)
    return True if False in found else None if None in found else False


def from_rest(draw: Draw, starter: Starter, draws: Iterable[Draw] = (), ends: Iterable[Draw] = ()) -> FromRest:
    """Start a drive at the middle values, random ``draws``, and those at the ``ends`` of their entries.

    With parts that comply the corner is that of the drive with rigid ones, and there the whole drive is started.
    """
    all_places, window = places(draw), speeds(draw)
    low, high = window[0], window[-1]
    beyond = np.geomspace(low / BEYOND, BEYOND * high, _STEPS + 1)
    tried = np.unique([*beyond[(beyond < low) | (beyond > high)], *window]).tolist()

    def asked(place: Place, speed: float, own: Draw = draw, stiff: bool = False) -> bool | None:
        """Whether a drive runs evenly."""
        return starter.evenly(Operation(own, place[0], speed, place[1]), stiff)

    often = {at: sum(asked(at, speed, stiff=True) is False for speed in window) for at in all_places}
    found = {at: even_from(partial(asked, at, stiff=True), tried, high) for at in all_places}
    worst = max(all_places, key=lambda at: (often[at], found[at] or 0.0))
    # The whole drive is asked at the worst place of the rigid one, and at the lowest speed everywhere.
    points = [*product([worst], window), *((at, low) for at in all_places)]
    answers = {point: asked(*point) for point in (product(all_places, window) if draw.sheet.stiff else points)}
    jerky = [point for point in points + list(answers) if answers[point] is False]
    place, first = jerky[0] if jerky else (worst, low)
    there = Operation(draw, place[0], first, place[1])
    even_speed = found[place] if draw.sheet.stiff else even_from(lambda speed: asked(place, speed), tried, high)
    k = [at for at in all_places[::-1] if at[0] == place[0]].index(place)  # an uncertain force moves it
    own = [
        asked(here[min(k, len(here) - 1)], first * one.values["speed_low"] / low, one)
        for one, here in ((one, [at for at in places(one)[::-1] if at[0] == place[0]]) for one in draws)
    ]
    corners = any_jerks(asked(at, one.values["speed_low"], one) for one in ends for at in places(one))
    spread: dict[str, Any] = {"drawn": len(own), "jerky": own.count(False), "unknown": own.count(None), "ends": corners}
    if jerks := any_jerks(answers.values()):
        spread |= {"motion": there.motion(None), "cause": _cause(there, starter)}
    return FromRest(jerks, there, even_speed, **spread)


def _cause(there: Operation, starter: Starter) -> str:
    """What a drive that jerks would run evenly without."""
    draw = there.draw
    pairs = zip(_CONTACTS, STATIC, strict=True)
    without = {where: {static: 0.0} for where, static in pairs if static in draw.values}
    if draw.sheet.followed:
        without["static"] = {static: 0.0 for one in without.values() for static in one}
        without["law"] = {**without["static"], "stribeck_rise": 0.0, "friction_slope": 0.0}
    known = {name: starter.evenly(replace(there, draw=draw.changed(**none))) for name, none in without.items()}
    return next((name for name, even in known.items() if even), "unknown" if None in known.values() else "")


def speeds(draw: Draw) -> list[float]:
    """The speeds of the screw [rad/s] at which a drive is started: the ends and the middle of its window."""
    low, high = draw.values["speed_low"], draw.values["speed_high"]
    return [*map(float, np.unique([low, math.sqrt(low * high), high]))]


def places(draw: Draw) -> list[Place]:
    """Where a drive is started: in each direction under both ends and the middle of its forces, as far as they differ.

    Where rigid threads alone rub, the same at any speed, and no ramp is given, the end that pushes more, weight
    included, is enough if both push the same way.
    """
    weight, low, high = draw.weight, draw.values["force_low"], draw.values["force_high"]
    forces = [high, 0.5 * (low + high), low] if high != low else [low]
    if draw.sheet.stiff and not (draw.sheet.dry or draw.sheet.friction.sloped or draw.run):
        forces = sorted((low, high), key=lambda force: abs(force + weight))[
            int((low + weight) * (high + weight) >= 0) :
        ]
    return list(product(draw.sheet.directions, forces))


def outcomes(draw: Draw, direction: int, turning: NDArray[Any], force: NDArray[Any]) -> NDArray[np.float64]:
    """Return 1 where a drive runs evenly from rest, 0 where it does not, NaN where that is not known (force, speed).

    Arguments: speeds of the screw [rad/s] and forces [N]. With rigid parts, where only the threads rub and their
    friction does not change with the speed of sliding, and without a ramp, every motion is multiplied if speed and
    whole force are, so that their ratio decides: it is sampled on either side of zero, and each change is closed in on.
    Else a point has the answer of the nearest of 9 by 9.
    """

    starter = Starter(draw.sheet)

    def asked(speed: float, push: float) -> float:
        """The answer at a point."""
        found = starter.evenly(Operation(draw, direction, speed, push))
        return math.nan if found is None else float(found)

    if not draw.sheet.stiff or draw.sheet.dry or draw.sheet.friction.sloped or draw.run:
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


KINDS = ("steady", "steady_until_perturbed", "steady_once_started", "steady_when_left_alone", "jerks_from_rest",
         "negative_damping", "kinematic_constraint", "mode_coupling", "falling_friction", "thread_contact")  # fmt: skip
"""What the chart distinguishes, by flag value."""


@dataclass(frozen=True)
class Chart:
    """One direction of travel: ``kind`` (force, speed) as flags of :data:`KINDS`, ``speed`` of the load [m/s] and
    ``force`` against outward travel [N].
    """

    direction: int
    speed: NDArray[np.float64]
    force: NDArray[np.float64]
    kind: NDArray[np.int8]


def charts(draw: Draw) -> list[Chart]:
    """Return the operating chart at given values, half as far again as the window, one for each direction of travel."""
    values, weight = draw.values, draw.weight
    top, points = 1.5 * values["speed_high"], 161  # a step is finer than a line of the picture
    turning = np.linspace(top / points, top, points)
    ends = (values["force_low"], values["force_high"], 0.0, -weight)
    room = 0.5 * max(max(ends) - min(ends), 0.1 * max(map(abs, ends)), 1.0)
    force = np.linspace(min(ends) - room, max(ends) + room, points)
    return [
        Chart(way, draw.travel * turning, force, _kinds(draw, way, turning, force)) for way in draw.sheet.directions
    ]


def _kinds(draw: Draw, direction: int, turning: NDArray[Any], force: NDArray[Any]) -> NDArray[np.int8]:
    """Flag of the first mechanism in the order of :data:`KINDS` that occurs at each point (force, speed)."""
    there = Operation(draw, direction, turning[None, :], force[:, None])
    found, p, shape = there.reserves, there.parameters, (force.size, turning.size)
    drag = p["pitch_radius"] * np.tan(p["lead_angle"]) * p["translation_damping"]
    ratio = np.abs(p["axial_force"] - drag * p["input_speed"]) / turning  # |R̃ / Ω|
    kind = np.zeros(shape, dtype=np.int8)
    blind = draw.sheet.friction.law or draw.sheet.dry  # of which the reserve after a perturbation knows nothing
    maybe = np.broadcast_to((found["after_perturbation"] < 0) | blind, shape)
    if maybe.any():
        last = _fatal_ratio(draw, direction, ratio[maybe].max(), drag)
        upset = KINDS.index("steady_once_started" if last is None else "steady_until_perturbed")
        kind[maybe & (ratio <= (math.inf if last is None else last))] = upset
    started = outcomes(draw, direction, turning, force)
    kind[np.isnan(started)] = KINDS.index("steady_when_left_alone")  # what a start becomes is not known
    kind[started == 0] = KINDS.index("jerks_from_rest")
    for name in reversed([name for name in KINDS if name in applicable(draw.sheet)]):
        kind = np.where(np.broadcast_to(found[name], shape) < 0, KINDS.index(name), kind)
    return kind.astype(np.int8)


def _fatal_ratio(draw: Draw, direction: int, most: float, drag: float) -> float | None:
    """The |R̃ / Ω| up to ``most`` [N s/rad] below which a perturbation starts vibration, to 0.3 %; None if not known.

    With Ω and R̃ multiplied alike every motion is; and beyond some force against the motion none ends in vibration.
    """
    if not draw.sheet.closed:
        return None
    speed, (low, high) = draw.values["speed_high"], (1e-4 * most, most)
    for _ in range(12):
        ratio = math.sqrt(low * high)
        size, _ = Operation(draw, direction, speed, direction * speed * (ratio - drag) - draw.weight).tolerated
        if not size:  # not known, or zero as nothing damps the drive
            return None
        low, high = (low, ratio) if size == math.inf else (ratio, high)
    return high
