"""The return map that a motion induces where its events happen, and the fixed points of it that attract.

The events of one kind that enter one mode lie on one surface, or on the intersection of several, as on release from
rest. The states there form an affine *section*; d is its number of dimensions.

* d = 1: the fixed point is found by the secant method and enclosed: P(y) − y is positive on its left and negative on
  its right, so a fixed point lies between.
* d > 1: Newton's method solves P(y) = y, with the Jacobian P′ from central differences along the section, and where
  that fails with the exact product of :mod:`lsvib.cycles.variational`. So slow multipliers, real, negative or complex,
  do not make the search long. The evidence is the residual P(y) − y, and that the motion comes closer with each of its
  returns, in the norm in which P′ contracts.

A fixed point counts only if its multipliers, the eigenvalues of P′, lie inside the unit circle; or on it, where the
modes of a cycle preserve volumes, because nothing damps: then it is one of a neutral family.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lsvib.cycles.patience import follow_patiently
from lsvib.cycles.variational import derivative, eigenvalues
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar
from lsvib.engine.kernels.status import ACCUMULATION_KIND, GRAZE_KIND, Status
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.errors import EngineError, WorkSpentError

ROUNDING = flow_planar.ROUNDING  # sums below it, relative to their terms, count as zero, as they do in the engine
SECANTS = 60  # steps at most; with its order of 1.6 the secant method takes seven from one digit to sixteen
WIDER = 4.0  # factor from one interval tried around a fixed point to the next
WIDEST = 1e-3  # half width of the last such interval, in scales of the section: rounding moves the point if P′ ≈ 1
SLOPE_STEP = 1e-5  # half step of the central difference for P′ on a line
_NEWTONS = 12  # steps at most; each doubles the digits, and the first that is not shorter than the last ends them
_JACOBIAN_STEP = 1e-6  # half step of the central differences for P′ on a section of more dimensions
_CONVERGED = 1e-9  # last step of Newton's method, in scales of the section
_NOISE = 4 * flow_planar.EPS  # rounding of P(y) − y, in scales of the section
MARGIN = 2e-8  # by which multipliers must lie inside the unit circle, well beyond the rounding of P′, 1e-10
_WATCHED = 10  # fewest states of the motion on the section that show whether it comes closer with each return
_FINER = 1e-12  # the same where P′ is an exact product: beyond its rounding over some hundred events
_NEUTRAL = 1e-6  # distance from the unit circle of multipliers on it: defective ones scatter by the root of 1e-12
_FEW_EVENTS = 64  # in a return whose derivative is an exact product, each factor of which costs
_FACTOR = 60.0  # so much, in units of a budget: some hundred microseconds
_THERE = 1e-6  # distance within which a motion has reached the point, well above rounding even in a stiff contact
LONGEST = 1000  # events in one return
PATIENCE = 10  # time that the next return may take, in times of the longest return seen
_ONE_PLANE = 1e-9  # relative singular value below which two surfaces count as one
_LEAST_SCALE = 1e-6  # least scale of a coordinate of the origin, relative to its size in the whole motion
_MADE = 30.0  # cost of a section, in units of a budget: some hundred microseconds
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


class Return(NamedTuple):
    """One return to a line: P(y) − y, and its events as told by ``Section.outcome``."""

    excess: float
    events: tuple[bytes, bytes] | None


def section_key(motion: Motion) -> tuple[int, int] | None:
    """Return kind and mode of the rarest events in the later half of a motion; None if it only touches guards.

    If several kinds are equally rare, take the latest one (two states) or the one that lies on the most surfaces (more
    states), because its section has the fewest dimensions and does not lie where the contact force passes zero, where
    the map is steep.
    """
    ours = ~np.isin(motion.kind, (GRAZE_KIND, ACCUMULATION_KIND))
    pairs, states = np.stack([motion.kind[ours], motion.mode[ours]], axis=1), motion.after[ours]
    if not len(pairs):
        return None
    half = len(pairs) // 2
    found, first, counts = np.unique(pairs[half:][::-1], axis=0, return_index=True, return_counts=True)
    order, size = np.argsort(first), np.abs(motion.after).max(axis=0)
    rarest = [k for k in order if counts[k] == counts.min()]
    if size.size > 2:
        rarest.sort(key=lambda k: -len(_surfaces(motion.automaton, states[len(pairs) - 1 - first[k]], size)))
    kind, mode = found[rarest[0]].tolist()
    return kind, mode


def _surfaces(automaton: Automaton, state: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the normals (k, n) of the surfaces on which a state (n) lies."""
    rows = automaton.tables.surfaces
    values = rows[:, :-1] @ state + rows[:, -1]
    return rows[np.abs(values) <= ROUNDING * (np.abs(rows[:, :-1]) @ size + np.abs(rows[:, -1])), :-1]


class ReturnSection:
    """The states near ``origin`` (n) in which events of one kind (``key``: kind, mode after) end.

    A state is ``origin`` + ``directions`` (n, d) · y. With two states y is measured in scales of the motion, ``size``
    (n); with more, in the origin's own coordinates, because an unloaded contact is far from its peak. One return of the
    map is made of ``returns`` returns to the section; ``longest`` [s] is the longest of them that was seen. Motions
    draw on a ``budget``, if there is one.
    """

    def __init__(
        self,
        automaton: Automaton,
        key: tuple[int, int],
        origin: np.ndarray,
        size: np.ndarray,
        returns: int,
        longest: float,
        budget: Budget | None = None,
    ) -> None:
        self.automaton, self.key, self.returns, self.origin, self.size = automaton, key, returns, origin, size
        self._limit, self.budget = PATIENCE * longest, budget
        if budget is not None:
            budget.spend(_MADE)
        met = _surfaces(automaton, origin, size)
        if origin.size > 2:
            scales = np.maximum(np.abs(origin), _LEAST_SCALE * size)
            normals = met * scales
            lengths = np.linalg.norm(normals, axis=1, keepdims=True)
            normals /= np.where(lengths == 0, 1.0, lengths)
            _, lengths, basis = np.linalg.svd(normals)
            axes = basis[np.count_nonzero(lengths > _ONE_PLANE) :]
            self.directions, self._axes = (axes * scales).T, axes / scales
        elif len(met) == 1:
            tangent = np.array([-met[0, 1], met[0, 0]])
            direction = tangent / np.abs(tangent / size).max()
            chosen = np.argmax(np.abs(direction / size))
            self.directions, self._axes = direction[:, None], (np.arange(2) == chosen)[None] / direction[chosen]
        else:
            self.directions, self._axes = np.zeros((2, 0)), np.zeros((0, 2))

    @property
    def dimension(self) -> int:
        """Number d of directions along the section."""
        return len(self._axes)

    @property
    def axes(self) -> np.ndarray:
        """Rows (d, n) that give y of a displacement along the section."""
        return self._axes

    def state(self, place: np.ndarray) -> np.ndarray:
        """Return the state (n) at y = ``place`` (d)."""
        return self.origin + self.directions @ place

    def place(self, states: np.ndarray) -> np.ndarray:
        """Return y (..., d) of states (..., n) on the section."""
        return (states - self.origin) @ self._axes.T

    def distance(self, place: float) -> float:
        """Return the distance of a place on a line from where its free coordinate is zero, in the scale of y."""
        free = int(np.argmax(np.abs(self._axes[0])))
        return abs(float(self.state(np.array([place]))[free] * self._axes[0, free]))

    def come_back(self, state: np.ndarray) -> Motion | None:
        """Follow the motion from a state (n) of the section until it is back; None if it does not come back."""
        motion, events, here = None, 0, state
        for _ in range(self.returns):
            try:
                motion = self._follow(here, self._limit, LONGEST, self.key)
            except WorkSpentError:
                raise
            except EngineError:
                return None
            if motion.status != Status.STOP_EVENT:
                return None
            here, events = motion.end_state, events + motion.time.size
        if self.returns > 1:
            motion = self._follow(state, math.inf, events)
        return motion

    def _follow(self, state: np.ndarray, t_end: float, events: int, stop: tuple[int, int] = (-1, -1)) -> Motion:
        if self.budget is None:
            return follow(self.automaton, state, t_end, mode=self.key[1], stop=stop, max_events=events)
        mode, budget = self.key[1], self.budget
        return follow_patiently(self.automaton, state, t_end, mode=mode, stop=stop, max_events=events, budget=budget)

    def excess(self, place: np.ndarray) -> np.ndarray:
        """Return P(y) − y (d) at y = ``place`` (d); nan if the motion does not come back."""
        return self.outcome(place)[0]

    def outcome(self, place: np.ndarray) -> tuple[np.ndarray, tuple[bytes, bytes] | None]:
        """Return P(y) − y (d) at y = ``place`` (d), and the kinds and modes of the events of that return.

        The result is nan and None if the motion does not come back, or if it leaves the section the moment it starts,
        because there the surface is crossed the other way.
        """
        motion = self.come_back(self.state(place))
        if motion is None or motion.time[0] == 0.0:
            return np.full(self.dimension, math.nan), None
        return self.place(motion.end_state) - place, (motion.kind.tobytes(), motion.mode.tobytes())

    def return_from(self, place: float) -> Return:
        """Follow one return from y = ``place`` on a line."""
        excess, events = self.outcome(np.array([place]))
        return Return(float(excess[0]), events)

    def jacobian(self, place: np.ndarray) -> np.ndarray:
        """Return P′ (d, d) at y = ``place`` (d) by central differences; nan if a motion does not come back."""
        step = SLOPE_STEP if self.dimension == 1 else _JACOBIAN_STEP
        offsets = step * np.eye(self.dimension)
        columns = [(self.excess(place + h) - self.excess(place - h)) / (2 * step) for h in offsets]
        return np.reshape(columns, offsets.shape).T + np.eye(self.dimension)

    def slopes(self, place: np.ndarray) -> tuple[np.ndarray, float]:
        """Return P′ (d, d) at y = ``place`` (d), and by how much its eigenvalues are uncertain [1]; nan as above."""
        if self.dimension == 0:  # the section is a point
            return np.zeros((0, 0)), MARGIN
        motion = self.come_back(self.state(place))
        if motion is not None and 0 < motion.time.size <= _FEW_EVENTS:
            if self.budget is not None:
                self.budget.spend(_FACTOR * motion.time.size)
            exact = derivative(motion)
            found = self._axes @ exact.matrix @ self.directions
            if np.isfinite(found).all():
                lost = np.abs(self._axes) @ exact.rounding @ np.abs(self.directions) * self.automaton.condition
                return found, min(max(eigenvalues(found)[1] * float(np.linalg.norm(lost)), _FINER), MARGIN)
        return self.jacobian(place), MARGIN

    def fixed_point(self, earlier: np.ndarray) -> FixedPoint | None:
        """Return the fixed point that attracts the origin, or None; ``earlier`` (k, n) are the states before it."""
        if self.dimension == 0:
            return FixedPoint(self.origin, 0.0, 0.0)
        if self.dimension == 1:
            return self._enclosed(self.place(earlier[-1]))
        return self._by_newton(self.place(earlier))

    def repeated(self) -> FixedPoint:
        """Return the origin as a fixed point, for a motion that has come back to it."""
        here = np.zeros(self.dimension)
        if self.origin.size == 2:
            return FixedPoint(self.origin, largest(self.jacobian(here)), 0.0)
        leading, neutral = largest(self.jacobian(here)), self._is_neutral(*self.slopes(here))
        return FixedPoint(self.origin, leading, math.nan, neutral)

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
        if not abs(slope) < 1:
            return None
        return FixedPoint(self.state(old), slope, width)

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
    return form
