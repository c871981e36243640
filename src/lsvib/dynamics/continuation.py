r"""Cycles over a parameter, by pseudo-arclength continuation of the fixed point of the return map, through folds.

:mod:`lsvib.dynamics.branch_points` has the equations of a point of the branch. At a *fold* the tangent has no part in
the parameter p: that zero is found along the branch, and as p is stationary there its value is exact to rounding.

The motion decides on its own events, so that the itinerary may change from point to point; such changes are located by
halving (:mod:`lsvib.dynamics.continuation`). Where a section is no longer met, another event of the last cycle takes
its place; if none does, the branch ends. Where an event appears the branch has a kink: there the step, not the tangent
before it, tells the direction.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lsvib.dynamics.branch_points import BranchEquations, Build, Solved, events_of, null_direction
from lsvib.dynamics.continuation import Change, changes_between
from lsvib.dynamics.cycles import Cycle
from lsvib.dynamics.moving_section import MovingSection
from lsvib.dynamics.poincare_map import Section
from lsvib.engine.kernels.layout import GRAZE_KIND
from lsvib.errors import InputError

_FIRST, _LARGEST, _SMALLEST = 1e-2, 4e-2, 1e-7  # steps, in widths of the range and sizes of the motion
_GROWS = 1.5  # factor from a step that was taken whole to the next one
_TURN = 0.2  # smallest cosine between tangents: beyond it the step was too long
_VANISHED = 1e-4  # amplitude, relative to that at the start, of a cycle that is about to vanish


@dataclass(frozen=True)
class BranchPoint:
    """A cycle of the branch at a ``value`` [SI unit] of the parameter; ``along``: length [1] from its start."""

    value: float
    cycle: Cycle
    along: float


@dataclass(frozen=True)
class CycleBranch:
    """A branch of cycles over a ``parameter``: its ``points`` in order, and the ``changes`` along it."""

    parameter: str
    points: tuple[BranchPoint, ...]
    changes: tuple[Change, ...]

    @property
    def folds(self) -> list[float]:
        """Values of the parameter [SI unit] at folds."""
        return [change.value for change in self.changes if change.kind == "fold"]


def follow_cycle(
    cycle: Cycle, build: Build, parameter: str, span: tuple[float, float], most: int = 1000
) -> CycleBranch:
    """Follow a cycle over a parameter, both ways from where it is, as far as it goes within ``span``.

    Arguments: the cycle, of the drive with the parameter at its own value; ``build`` makes drive and automaton at
    another value; ``most`` points each way. Raises ``InputError`` if the cycle cannot be followed at all.
    """
    down, below = _followed(cycle, build, parameter, span, -1.0, most)
    up, above = _followed(cycle, build, parameter, span, 1.0, most)
    points = [replace(point, along=-point.along) for point in reversed(down[1:])]
    changes = [replace(change, along=-change.along) for change in reversed(below)]
    return CycleBranch(parameter, (*points, *up), (*changes, *above))


def _followed(
    cycle: Cycle, build: Build, parameter: str, span: tuple[float, float], direction: float, most: int
) -> tuple[list[BranchPoint], list[Change]]:
    """Points and changes of the branch that begins with the parameter growing or falling."""
    low, high = span
    width = high - low
    start = float(getattr(cycle.drive, parameter))
    curve = BranchEquations(build, MovingSection(cycle), low, width)
    here = _first(curve, cycle, start, direction)
    if here is None:
        raise InputError(f"the cycle at {parameter} = {start:g} cannot be followed: its return map has no derivative.")
    points: list[BranchPoint] = [BranchPoint(start, here.cycle, 0.0)]
    changes: list[Change] = []
    along, step = 0.0, _FIRST
    while len(points) < most:
        there, curve, here, taken = _next(curve, here, step, low, width)
        if there is None:
            small = here.cycle.amplitude < _VANISHED * cycle.amplitude
            what = "it shrinks to nothing" if small else "no cycle continues this one"
            changes.append(Change("end", curve.value(here.z), what, along))
            break
        value = curve.value(there.z)
        if not low <= value <= high:
            edge = _at_value(curve, here, there, low if value < low else high)
            if edge is not None:
                changes += changes_between(curve, here, edge, taken, along)
                points.append(BranchPoint(curve.value(edge.z), edge.cycle, along + taken))
            changes.append(Change("end", low if value < low else high, "the range ends", along + taken))
            break
        changes += changes_between(curve, here, there, taken, along)
        along += taken
        points.append(BranchPoint(value, there.cycle, along))
        step = min(step * _GROWS, _LARGEST) if taken >= step else max(taken, _SMALLEST)
        here = there
    else:
        changes.append(Change("end", points[-1].value, "the branch is longer than the number of points", along))
    return points, changes


def _first(curve: BranchEquations, cycle: Cycle, start: float, direction: float) -> Solved | None:
    z = np.append(curve.section.place(cycle.state), (start - curve.low) / curve.width)
    found = curve.at(z)
    slopes = None if found is None else curve.slopes(z, found[2])
    if slopes is None:
        return None
    tangent = null_direction(slopes)
    return Solved(z, cycle, tangent * direction if tangent[-1] >= 0 else -tangent * direction)


def _next(
    curve: BranchEquations, here: Solved, step: float, low: float, width: float
) -> tuple[Solved | None, BranchEquations, Solved, float]:
    """The next point, on this section or another of the cycle; also the curve, the last point on it, the step taken."""
    there, taken = _stepped(curve, here, step)
    if there is not None:
        return there, curve, here, taken
    places = [(curve, here)]
    for cycle in other_sections(here.cycle):
        other = BranchEquations(curve.build, MovingSection(cycle), low, width)
        again = _first(other, cycle, curve.value(here.z), 1.0)
        if again is not None:
            turned = again.tangent[-1] * here.tangent[-1] < 0
            places.append((other, replace(again, tangent=-again.tangent) if turned else again))
    for other, again in places:
        # Beyond a kink the branch may turn by more than a right angle, though the parameter goes on: step along it.
        along = np.eye(again.z.size)[-1] * math.copysign(1.0, again.tangent[-1])
        for start in (again, replace(again, tangent=along)):
            there, taken = _stepped(other, start, step)
            if there is not None:
                return there, other, start, taken
    return None, curve, here, 0.0


def _stepped(curve: BranchEquations, here: Solved, step: float) -> tuple[Solved | None, float]:
    while step >= _SMALLEST:
        there = curve.corrected(here.z + step * here.tangent, here.tangent)
        if there is not None:
            turned = there.tangent @ (there.z - here.z) < 0  # across a kink the tangents tell no direction
            there = replace(there, tangent=-there.tangent) if turned else there
            kink = events_of(there.cycle.orbit) != events_of(here.cycle.orbit)
            if there.tangent @ here.tangent >= (-1.0 if kink else _TURN):
                return there, step
        step *= 0.5
    return None, 0.0


def other_sections(cycle: Cycle) -> Iterator[Cycle]:
    """Yield the same cycle, begun at other events of it."""
    orbit, seen = cycle.orbit, {cycle.section.key}
    for k in range(orbit.time.size):
        key = int(orbit.kind[k]), int(orbit.mode[k])
        if key in seen or key[0] == GRAZE_KIND:
            continue
        seen.add(key)
        returns = int(np.sum((orbit.kind == key[0]) & (orbit.mode == key[1])))
        section = Section(orbit.automaton, key, orbit.after[k], cycle.section.size, returns, 2 * cycle.period)
        motion = section.come_back(orbit.after[k])
        if motion is not None:
            yield replace(cycle, orbit=motion, section=section)


def _at_value(curve: BranchEquations, here: Solved, there: Solved, value: float) -> Solved | None:
    """The point at a value of the parameter between two points."""
    target = (value - curve.low) / curve.width
    part = (target - here.z[-1]) / (there.z[-1] - here.z[-1])
    guess = here.z + part * (there.z - here.z)
    guess[-1] = target
    across = np.eye(guess.size)[-1] * math.copysign(1.0, here.tangent[-1])
    return curve.corrected(guess, across)
