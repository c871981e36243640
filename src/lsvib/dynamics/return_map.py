"""The return map that a motion induces where its events happen, and the fixed points of it that attract.

The events of one kind that enter one mode lie on one surface, or on the intersection of several, as on release from
rest. The states there form an affine *section* (:mod:`lsvib.dynamics.poincare_map`); d is its number of dimensions.

* d = 1: the fixed point is found by the secant method and enclosed: P(y) − y is positive on its left and negative on
  its right, so a fixed point lies between. It attracts if that holds beyond rounding, too, a little further away.
* d > 1: Newton's method solves P(y) = y, with the Jacobian P′ from central differences along the section, and where
  that fails with the exact product of :mod:`lsvib.dynamics.poincare_map`. So slow multipliers, real, negative or
  complex, do not make the search long. The evidence is the residual P(y) − y, and that the motion comes closer with
  each of its returns, in the norm in which P′ contracts.

A fixed point counts only if its multipliers, the eigenvalues of P′, lie inside the unit circle; or on it, where the
modes of a cycle preserve volumes, because nothing damps: then it is one of a neutral family.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lsvib.dynamics.poincare_map import MARGIN, ROUNDING, SLOPE_STEP, Section
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar

SECANTS = 60  # steps at most; with its order of 1.6 the secant method takes seven from one digit to sixteen
WIDER = 4.0  # factor from one interval tried around a fixed point to the next
WIDEST = 1e-3  # half width of the last such interval, in scales of the section: rounding moves the point if P′ ≈ 1
# Half widths of intervals one of which both ends must come nearer from: short ones next to where a cycle begins, long
# ones if it attracts faintly, over the last by 2e-14 in a return.
_WIDTHS = (SLOPE_STEP, 1e-7, 1e-9, WIDEST, 0.1)
_NEWTONS = 12  # steps at most; each doubles the digits, and the first that is not shorter than the last ends them
_CONVERGED = 1e-9  # last step of Newton's method, in scales of the section
_NOISE = 4 * flow_planar.EPS  # rounding of P(y) − y, in scales of the section
CLEAR = 2 * _NOISE  # a larger P(y) − y on a line is more than the rounding of both ends of a return
_WATCHED = 10  # fewest states of the motion on the section that show whether it comes closer with each return
_NEUTRAL = 1e-6  # distance from the unit circle of multipliers on it: defective ones scatter by the root of 1e-12
_THERE = 1e-6  # distance within which a motion has reached the point, well above rounding even in a stiff contact
_DOUBLINGS = 40  # of the number of terms in the sum that makes the norm: 2⁴⁰ terms, more than a slow multiplier needs


@dataclass(frozen=True)
class FixedPoint:
    """An attracting fixed point of the return map: ``state`` (n).

    ``multiplier`` [1] is the eigenvalue of P′ of the largest magnitude, or its magnitude if it is complex.
    ``enclosure`` [1] is the relative half width of the interval that is proved to hold the point; nan where d > 1.
    ``neutral``: the multiplier lies on the unit circle, so that points nearby stay nearby and are not attracted.
    """

    state: np.ndarray
    multiplier: float
    enclosure: float
    neutral: bool = False


class Section(Section):
    """A section of return with the fixed points of its map."""

    def fixed_point(self, earlier: np.ndarray) -> FixedPoint | None:
        """Return the fixed point that attracts the origin, or None; ``earlier`` (k, n) are the states before it."""
        if self.dimension == 0:
            return FixedPoint(self.origin, 0.0, 0.0)
        if self.dimension == 1:
            return self._enclosed(self.place(earlier[-1]))
        return self._by_newton(self.place(earlier))

    def between(self, left: float, right: float) -> FixedPoint | None:
        """Return the middle of an interval of a line into which its ends return; None if its slope is not below one."""
        middle = np.array([0.5 * (left + right)])
        slope = largest(self.slopes(middle)[0])
        return FixedPoint(self.state(middle), slope, 0.5 * (right - left)) if abs(slope) < 1 else None

    def repeated(self) -> FixedPoint | None:
        """Return the origin as a fixed point, for a motion that has come back to it; None if a line does not attract.

        A motion that drifts by less than its last digit comes back, too.
        """
        here = np.zeros(self.dimension)
        if self.origin.size == 2:
            attracts = self.dimension == 0 or self._rests() or self._attracts(here)
            return FixedPoint(self.origin, largest(self.jacobian(here)), 0.0) if attracts else None
        leading, (exact, margin) = largest(self.jacobian(here)), self.slopes(here)
        neutral = self._is_neutral(exact, margin)
        # A motion beside may not come back, or a surface that is only touched attracts from one side.
        if math.isnan(leading) or (not neutral and abs(largest(exact)) >= 1 - margin):
            leading = largest(exact)
        return FixedPoint(self.origin, leading, math.nan, neutral)

    def _rests(self) -> bool:
        """Whether a return to a line rests: with two states every rest ends in the same state."""
        orbit = self.come_back(self.origin)
        return orbit is not None and bool(np.isin(self.automaton.codes[orbit.mode], self.automaton.rest_codes).any())

    def _is_neutral(self, slopes: np.ndarray, margin: float) -> bool:
        """Whether a fixed point with these P′ (d, d) neither attracts nor repels, because nothing damps."""
        if not conserves(self.automaton) or not np.isfinite(slopes).all():
            return False
        return bool(abs(abs(largest(slopes)) - 1) <= max(margin, _NEUTRAL))

    def _enclosed(self, older: np.ndarray) -> FixedPoint | None:
        """Solve by the secant method from the last two states, and enclose the solution; None without success."""
        old = np.zeros(1)
        f_older, f_old = self.excess(older), self.excess(old)
        for _ in range(SECANTS):
            if abs(f_old) <= flow_planar.EPS or f_old == f_older:
                break
            new = old - f_old * (old - older) / (f_old - f_older)
            f_new = self.excess(new)
            if np.isnan(f_new):
                return None
            older, f_older, old, f_old = old, f_old, new, f_new
            if abs(old - older) <= flow_planar.EPS:
                break
        width = ROUNDING
        while width < WIDEST and not all(self._inward(old, part * width) for part in (1.0, WIDER)):
            width *= WIDER
        if width >= WIDEST:
            return None
        slope = float(self.jacobian(old)[0, 0])
        if 1 <= slope < 1 + _NEUTRAL and self._inward(old, WIDEST):
            # Over so short a step it is rounding whether P′ is below one; the mean over a longer one shows it.
            left, right = (float(self.excess(old + side * WIDEST)[0]) for side in (-1, 1))
            slope = 1 + (right - left) / (2 * WIDEST)
        return FixedPoint(self.state(old), slope, width) if abs(slope) < 1 and self._attracts(old) else None

    def _attracts(self, place: np.ndarray) -> bool:
        """Whether motions from both sides of a place on a line come nearer to it by more than rounding.

        Or whether all that come back, perhaps from one side only, are there at once, and not by rounding.
        """
        clear = CLEAR * self.grain(place)
        for step in _WIDTHS:
            before, after = (float(self.excess(place + side * step)[0]) for side in (-1, 1))
            if before > clear and after < -clear:
                return True
        left = np.array([abs(float(self.excess(place + far)[0]) + far) for far in (-WIDEST, WIDEST)])
        return bool(clear <= _CONVERGED and np.isfinite(left).any() and not (left > CLEAR).any())

    def _inward(self, place: np.ndarray, width: float) -> bool:
        """Whether motions from both ends of an interval come back nearer to its middle, by the same events."""
        (left, before), (right, after) = self.outcome(place - width), self.outcome(place + width)
        return bool(left > 0 > right) and before == after

    def _by_newton(self, earlier: np.ndarray) -> FixedPoint | None:
        """Solve by Newton's method from the origin; the motion ``earlier`` (k, d) must approach the solution.

        Differences come first: they look to both sides of a surface that is only touched.
        """
        found = self._newton(earlier, lambda place: (self.jacobian(place), MARGIN))
        return found or self._newton(earlier, self.slopes)

    def _newton(
        self, earlier: np.ndarray, slopes_at: Callable[[np.ndarray], tuple[np.ndarray, float]]
    ) -> FixedPoint | None:
        place, length = np.zeros(self.dimension), math.inf
        for _ in range(_NEWTONS):
            (slopes, margin), gap = slopes_at(place), self.excess(place)
            if not (np.isfinite(slopes).all() and np.isfinite(gap).all()):
                return None
            step = np.linalg.lstsq(np.eye(self.dimension) - slopes, gap, rcond=None)[0]
            place, last, length = place + step, length, np.abs(step).max()
            nearest = np.abs(1 - np.linalg.eigvals(slopes)).min()  # P(y) − y is rounding at this distance from zero
            if length <= max(_CONVERGED, min(_NOISE / max(nearest, _NOISE), _THERE)):
                break
            if not length < last:
                return None
        else:
            return None
        # The fixed point may touch a surface that the motion crosses on its way: its own multipliers count.
        own, own_margin = self.slopes(place)
        leading, neutral = largest(slopes), self._is_neutral(own, own_margin)
        if not (neutral or (abs(leading) < 1 - margin and abs(largest(own)) < 1 - own_margin)):
            return None
        if np.abs(place).max() > _THERE:
            if self._is_neutral(slopes, margin):
                return None  # the motion is another member of the family
            away = np.vstack([earlier, np.zeros(self.dimension)]) - place
            distances = np.einsum("ki,ij,kj->k", away, _contracting(slopes), away)
            if len(earlier) < _WATCHED or not np.isfinite(distances).all():
                return None
            if (np.diff(distances)[distances[1:] > _THERE**2] >= 0).any():
                return None
        return FixedPoint(self.state(place), largest(own) if neutral else leading, math.nan, neutral)


def conserves(automaton: Automaton) -> bool:
    """Whether all modes in motion of a model with more than two states preserve volumes: nothing damps them."""
    flow = automaton.tables.flow
    if isinstance(flow, np.ndarray):
        return False
    moving = ~np.isin(automaton.codes, automaton.rest_codes)
    return not np.trace(flow.field[moving][:, :, :-1], axis1=1, axis2=2).any()


def largest(slopes: np.ndarray) -> float:
    """Return the eigenvalue of P′ (d, d) of the largest magnitude, or its magnitude if it is complex; 0 if d = 0."""
    if slopes.size == 0:
        return 0.0
    if not np.isfinite(slopes).all():
        return math.nan
    values = np.linalg.eigvals(slopes)
    leading = values[np.argmax(np.abs(values))]
    return float(leading.real if leading.imag == 0 else abs(leading))


def _contracting(slopes: np.ndarray) -> np.ndarray:
    """Return Σ (P′ᵀ)ᵏ P′ᵏ, the quadratic form that P′ makes smaller, whatever its eigenvectors are."""
    form, power = np.eye(len(slopes)), slopes
    with np.errstate(over="ignore", invalid="ignore"):  # the caller refuses a form that is not finite
        for _ in range(_DOUBLINGS):
            form = form + power.T @ form @ power
            power = power @ power
            if not power.any():  # underflown: nothing more is added
                break
    return form
