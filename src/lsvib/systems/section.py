"""The Poincaré map of a section, its fixed points, attracting or repelling, and their multipliers with an error bound.

The events of one kind that enter one mode lie on one surface, or on the intersection of several; the states there form
an affine section. The map P takes a place y (d) on it to that of the motion after some returns. docs/cycles.md says how
it is solved, and what its n − 1 multipliers are: the eigenvalues of P′, zero where the section has fewer dimensions.

Their error has three parts: the rounding of the product, carried along entry by entry and into the eigenvalues; what
the uncertainty of the fixed point changes; and, for defective eigenvalues, the root of the former. Of stiff contacts
that bound of the rounding is too large by ten decades, because it does not see that the fast motion has died away;
there the rounding is measured instead, by how P′ scatters between places that differ by rounding.
"""

import math
from dataclasses import dataclass

import numpy as np

from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels import flow_planar, saltation
from lsvib.systems.kernels import poincare_map as kernels
from lsvib.systems.kernels.layout import Begin, Events, Status
from lsvib.systems.machine import derivative_of, lent, of_one_type
from lsvib.systems.motion import Motion, new_events

PATIENCE = 10  # time that a return may take, in times of the longest return seen
AT_REST = 4 * flow_planar.EPS  # of a step of Newton's method: rounding
CLOSE = 1e-8  # residual of a motion that is periodic, well above rounding times the growth of neighbours
_MOST_WORK = 100_000.0  # of Newton's method, in events: a second under a friction law
_STEPS = (1e-6, 1e-9)  # in y, by which the change of P′ along the section is measured; the larger change counts


def derivative(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Return the derivative (n, n) of the state after a motion's last event by its start, and a bound of its rounding.

    nan if an event has none. The start's own mode is kept: neighbours start in it. A rounding beyond all numbers is
    infinite or nan: a surface is hardly crossed there.
    """
    n = motion.start_state.size
    matrix, rounding = np.empty((n, n)), np.empty((n, n))
    tables = motion.automaton.tables
    begin = Begin(0.0, motion.start_mode, motion.start_state)
    saltation.derivative(derivative_of(tables), of_one_type(tables), begin, motion.events(), matrix, rounding)
    return matrix, rounding


def eigenvalues(matrix: np.ndarray, lost: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the eigenvalues of a real matrix, complex, and how far those may be whose entries differ by ``lost``.

    With eigenvectors R that is the largest eigenvalue of |R⁻¹| lost |R| (Bauer and Fike), whatever the coordinates'
    units.
    """
    values, right = np.linalg.eig(matrix)
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            moved = np.abs(np.linalg.inv(right)) @ lost @ np.abs(right)
        return values.astype(complex), float(np.abs(np.linalg.eigvals(moved)).max())
    except np.linalg.LinAlgError:  # there is no inverse, or no finite one
        return values.astype(complex), math.inf


def section_key(motion: Motion) -> tuple[int, int] | None:
    """Return kind and mode of the rarest events in the later half of a motion; None if it only touches guards."""
    size = np.abs(motion.after).max(axis=0, initial=0.0)
    found = kernels.rarest_event(motion.automaton.tables, motion.kind, motion.mode, motion.after, size)
    return None if found < 0 else (int(motion.kind[found]), int(motion.mode[found]))


def size_of(motion: Motion) -> np.ndarray:
    """Return the size (n) of a motion at its events; a coordinate that is zero at all of them may have any."""
    states = np.concatenate([motion.after, motion.before])
    if motion.automaton.marked(motion.kind, "passage").all():  # where a coordinate may be zero but for rounding
        states = motion.at(np.linspace(0.0, motion.end_time, 64))[0]
    size = np.abs(states).max(axis=0)
    return np.where(size == 0, 1.0, size)


@dataclass
class Section:
    """The states near ``origin`` (n) in which events of one kind (``key``: kind, mode after) end.

    A place y (d) counts the ``free`` coordinates from the origin in ``unit`` (n), those of the origin itself, because
    an unloaded contact is far from its peak; the others follow from the surfaces of the automaton that the origin
    meets. ``size`` (n) is that of the motion. One return of the map is made of ``returns`` returns to the section, each
    of which may take ``PATIENCE`` times ``longest`` [s]. Kernels know it as it is ``laid``.
    """

    automaton: Automaton
    key: tuple[int, int]
    origin: np.ndarray
    size: np.ndarray
    returns: int
    longest: float

    def __post_init__(self) -> None:
        """Lay the section."""
        tables, n = self.automaton.tables, self.origin.size
        self.unit, free, directions = np.empty(n), np.empty(n, dtype=np.int64), np.empty((n, n))
        d = kernels.lay(tables.surfaces, self.origin[None], self.size, self.unit, free, directions)
        self.dimension, self.free, self.directions = d, free[:d], directions[:, :d]
        self.laid = kernels.Section(
            *self.key, self.returns, PATIENCE * self.longest, d, self.origin, self.size, self.unit, free, directions
        )

    def state(self, place: np.ndarray) -> np.ndarray:
        """Return the state (n) at y = ``place`` (d)."""
        return np.asarray(self.origin + self.directions @ place)

    def place(self, states: np.ndarray) -> np.ndarray:
        """Return y (..., d) of states (..., n) on the section."""
        return np.asarray(((states - self.origin) / self.unit)[..., self.free])

    def come_back(self, state: np.ndarray) -> Motion | None:
        """Follow the motion from a state (n) of the section until it is back; None if it does not come back."""
        events, end = new_events(kernels.LONGEST, state.size), state.copy()
        with lent(self.automaton) as (machine, tables):
            count = kernels.come_back(machine, tables, self.laid, end, events, np.array([_MOST_WORK]))
        if count == 0:
            return None
        own = Events(*(column[:count].copy() for column in events))
        return Motion(
            self.automaton, self.key[1], state, *own,
            status=Status.STOP_EVENT, end_time=float(own.time[-1]), end_mode=self.key[1], end_state=end,
        )  # fmt: skip

    def derivative(self, orbit: Motion) -> tuple[np.ndarray, np.ndarray]:
        """Return P′ (d, d) along a motion that returns to the section, with the bound of its rounding."""
        (matrix, rounding), unit = derivative(orbit), self.unit[self.free, None]
        with np.errstate(over="ignore", invalid="ignore"):
            carried = rounding @ np.abs(self.directions)
            return (matrix @ self.directions)[self.free] / unit, carried[self.free] / unit


def solve(section: Section) -> tuple[Motion, float] | None:
    """Return the periodic motion near the origin of a section and its residual [1]; None if Newton's method fails.

    The residual is the change of the state over the period relative to ``section.size``; it is rounding, times the
    growth of neighbours over a period.
    """
    n, place = section.origin.size, np.empty(section.dimension)
    state, slopes, events = np.empty(n), np.empty((n, n)), new_events(kernels.LONGEST, n)
    with lent(section.automaton) as (machine, tables):
        kernels.newton(machine, tables, section.laid, True, place, state, slopes, events, np.array([_MOST_WORK]))
    orbit = section.come_back(state)
    if orbit is None:
        return None
    residual = float(np.max(np.abs(orbit.end_state - state) / section.size))
    return (orbit, residual) if residual < CLOSE else None


def multipliers(section: Section, orbit: Motion, residual: float) -> tuple[np.ndarray, float]:
    """Return the n − 1 multipliers of a cycle, the largest first, and a bound of their errors [1]; nan without P′."""
    count = max(section.origin.size - 1, section.dimension)
    slopes, rounding = section.derivative(orbit)
    if not np.isfinite(slopes).all():
        return np.full(count, math.nan, dtype=complex), math.nan
    if section.dimension == 0:
        return np.zeros(count, dtype=complex), 0.0
    lost = rounding * orbit.automaton.condition
    if not _norm(lost) <= 1e-10:  # size of the rounding of P′ below which its bound is good enough
        lost = np.fmin(lost, _scatter(section, orbit, slopes))
    least = float(np.linalg.svd(np.eye(section.dimension) - slopes, compute_uv=False).min())
    uncertain = AT_REST + (residual + AT_REST) / max(least, flow_planar.EPS)  # of y, which is a double itself
    place = section.place(orbit.start_state)
    for direction in np.eye(section.dimension):
        changes = np.zeros((len(_STEPS), *slopes.shape))
        for change, step in zip(changes, _STEPS, strict=True):
            beside = section.come_back(section.state(place + step * direction))
            if beside is not None:
                change[:] = np.abs(section.derivative(beside)[0] - slopes) / step
        lost = lost + np.where(np.isfinite(changes), changes, 0.0).max(axis=0) * min(uncertain, _STEPS[0])
    size, (values, moved) = _norm(lost), eigenvalues(slopes, lost)
    error = min(moved, max(size, size ** (1 / len(slopes))) * len(slopes) + size)
    values = np.where(np.abs(values) <= min(error, 1e-5), values.real, values)  # what is zero, threefold, has no phase
    padded = np.concatenate([values, np.zeros(count - len(values))])
    return padded[np.argsort(-np.abs(padded), kind="stable")], error


def _norm(lost: np.ndarray) -> float:
    with np.errstate(over="ignore"):  # of a rounding beyond all bounds
        return float(np.linalg.norm(lost))


def _scatter(section: Section, orbit: Motion, slopes: np.ndarray) -> np.ndarray:
    """Return the rounding of P′ (d, d) as second differences between places side by side show it; nan without them.

    That of the tables, which all places share, is a relative change of the system by it, and is added.
    """
    place, found = section.place(orbit.start_state), []
    for k in range(5):
        beside = section.come_back(section.state(place + k * 1e-12))
        if beside is None:
            return np.full_like(slopes, math.nan)
        found.append(section.derivative(beside)[0])
    noise = np.abs(np.diff(found, 2, axis=0)).max(axis=0)
    tables = flow_planar.EPS * orbit.automaton.condition * orbit.time.size * float(np.abs(slopes).max())
    return np.asarray(30.0 * (noise + tables))  # rounding may exceed a few samples of it so many times
