"""The equations of a branch of cycles over a parameter, and their solution by Newton's method.

The unknowns are the free coordinates y of a section (:class:`~lsvib.dynamics.moving_section.MovingSection`; the others
follow from its surfaces, which move with the parameter p) and p itself. On  F(y, p) = P(y, p) − y = 0  the next point
is sought where it meets the plane across the tangent at the last one. F_y = P′ − I is exact; F_p is a central
difference, which steers Newton's method and the tangent, but is no part of the residual F.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lsvib.dynamics.cycles import Cycle
from lsvib.dynamics.moving_section import MovingSection
from lsvib.dynamics.poincare_map import Section, derivative, multipliers
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar
from lsvib.engine.kernels.layout import GRAZE_KIND
from lsvib.engine.motion import Motion
from lsvib.errors import EngineError, InputError
from lsvib.models.drive import Drive

_NEWTON = 30  # steps; where the derivative jumps as an event appears they converge slowly at first
_PARTS = 1.0  # size of a step of Newton's method, in sizes of the motion, beyond which it has left the branch
_CONVERGED = 1e-8  # a step of Newton's method after which one more is rounding only
_ROUNDING = 1e-12  # residual of a point of the branch, times the growth of neighbours over a period
_PARAMETER_STEP = 1e-5  # of the central difference for F_p, in widths of the range

Build = Callable[[float], tuple[Drive, Automaton]]


@dataclass(frozen=True)
class Solved:
    """A point of the branch: unknowns z = (y, p in widths), its cycle, and the tangent."""

    z: np.ndarray
    cycle: Cycle
    tangent: np.ndarray


class BranchEquations:
    """The equations F(y, p) = 0 on one section, p counted in ``width`` from ``low``."""

    def __init__(self, build: Build, section: MovingSection, low: float, width: float) -> None:
        self.build, self.section, self.low, self.width = build, section, low, width

    def value(self, z: np.ndarray) -> float:
        """The value of the parameter at a point (y, p)."""
        return self.low + self.width * float(z[-1])

    def at(self, z: np.ndarray) -> tuple[Drive, Section, Motion] | None:
        """The drive, the section and one return from a point (y, p); None where none comes back or no drive is."""
        try:
            drive, automaton = self.build(self.value(z))
            found = self.section.back(automaton, z[:-1])
        except (EngineError, InputError):
            return None
        return None if found is None else (drive, *found)

    def slopes(self, z: np.ndarray, motion: Motion, last: np.ndarray | None = None) -> np.ndarray | None:
        """[F_y, F_p] (d, d + 1); F_p (d) as it was where it is given: it only steers."""
        d = z.size - 1
        if d == 0:
            return np.zeros((0, 1))
        _, along = self.section.state(motion.automaton, z[:-1])
        matrix = derivative(motion).matrix @ along
        inner = matrix[self.section.free] / self.section.size[self.section.free][:, None] - np.eye(d)
        if last is not None:
            found = np.column_stack([inner, last])
            return found if np.isfinite(found).all() else None
        step, here = np.eye(d + 1)[-1] * _PARAMETER_STEP, self.section.place(motion.end_state)
        beside = {0.0: here}
        for sign in (1.0, -1.0):
            found = self.at(z + sign * step)
            if found is not None and events_of(found[2]) == events_of(motion):  # else the difference is that of a kink
                beside[sign] = self.section.place(found[2].end_state)
        if len(beside) == 1:
            return None
        first, last = min(beside), max(beside)
        found = np.column_stack([inner, (beside[last] - beside[first]) / ((last - first) * _PARAMETER_STEP)])
        return found if np.isfinite(found).all() else None

    def corrected(self, guess: np.ndarray, tangent: np.ndarray) -> Solved | None:
        """The point of the branch in the plane through ``guess`` across ``tangent``, with its tangent."""
        z, slopes, last, length = guess.copy(), None, math.inf, math.inf
        events: tuple = ()
        for _ in range(_NEWTON):
            found = self.at(z)
            if found is None:
                return None
            gap = self.section.place(found[2].end_state) - z[:-1]
            same = slopes is not None and events == events_of(found[2])
            slopes = self.slopes(z, found[2], slopes[:, -1] if same else None)
            events = events_of(found[2])
            step = None if slopes is None else _bordered(slopes, tangent, gap, float(tangent @ (z - guess)))
            if step is None:
                return None
            length = float(np.abs(step).max(initial=0.0))
            if length <= 4 * flow_planar.EPS or (last <= _CONVERGED and length >= 0.5 * last):
                break
            if length > _PARTS:
                return None
            z, last = z + step, length
        found = self.at(z)
        slopes = None if found is None or not length <= _CONVERGED else self.slopes(z, found[2], slopes[:, -1])
        if slopes is None:
            return None
        drive, section, motion = found
        residual = float(np.max(np.abs(motion.end_state - motion.start_state) / section.size))
        values, error = multipliers(section, motion, residual)
        if not residual <= _ROUNDING * max(1.0, float(np.abs(values).max(initial=0.0))):
            return None
        ahead = null_direction(slopes)
        if ahead @ tangent < 0:
            ahead = -ahead
        cycle = Cycle(drive, motion, residual, values, error, "continuation", section)
        return Solved(z, cycle, ahead)


def events_of(motion: Motion) -> tuple[list[int], list[int]]:
    """Kinds of a motion's events and codes of the modes that they enter, without touches."""
    own = motion.kind != GRAZE_KIND
    return motion.kind[own].tolist(), motion.automaton.codes[motion.mode[own]].tolist()


def _bordered(slopes: np.ndarray, tangent: np.ndarray, gap: np.ndarray, off: float) -> np.ndarray | None:
    """Newton's step for F = 0 in the plane across the tangent."""
    try:
        step = np.linalg.solve(np.vstack([slopes, tangent]), -np.append(gap, off))
    except np.linalg.LinAlgError:
        return None
    return step if np.isfinite(step).all() else None


def null_direction(slopes: np.ndarray) -> np.ndarray:
    """Unit vector that the slopes (d, d + 1) take to zero."""
    if not len(slopes):
        return np.ones(1)
    return np.linalg.svd(slopes)[2][-1]
