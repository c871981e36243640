"""The cycle that the events of a motion lie on or approach, by the return map of the section of its rarest events."""

from typing import NamedTuple

import numpy as np

from lsvib.dynamics import drift_two_states
from lsvib.dynamics.attractor import Attractor, SteadyState, cycle_label
from lsvib.dynamics.poincare_map import MARGIN, FixedPoint, Section, conserves, section_key
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar, layout
from lsvib.engine.motion import Budget, Motion

PERIODS = 64  # most returns to the section in a cycle that is recognised because it repeats
SOLVED = 8  # most returns to the section in a cycle that the return map is solved for
REPEATS = (4 * flow_planar.EPS, 1e-10)  # relative change that is rounding: with two states, with more (modal form)
FEWEST = 4  # fewest returns that show where a motion goes, unless they repeat
_WAY = np.linspace(0.0, 1.0, 9)  # parts of the way to a fixed point at which the events of a return are compared
_POINTS = 1000  # latest returns that show where a motion goes; over more of them a slow approach is lost in rounding
_STEPS = 8  # returns in a row that tell a drift from rounding
# A fixed point smaller than this, in scales of the motion, is the equilibrium if that lies on a surface: the first one
# for two states, the second for more, where Newton's method leaves 1e-9 over the distance of a multiplier from one.
CORNERS = (1e-9, 1e-5)
_ON_IT = 1e-6  # distance to a cycle, in its own sizes, within which a motion is on it: rounding over 1 − multiplier
_TOUCH = 1e-6  # part of a period for which the largest of a neutral family seems to rest where it touches θ′ = 0


class Watched(NamedTuple):
    """The states of a motion on the section of its rarest events.

    ``key`` is kind and mode of these events; ``points`` (k, n) are the states after them; ``size`` (n) is that of the
    motion; ``longest`` [s] is the longest time between two of them.
    """

    key: tuple[int, int]
    points: np.ndarray
    size: np.ndarray
    longest: float


def watched(motion: Motion) -> Watched | None:
    """Watch a motion on the section of its rarest events; None if it only touches guards."""
    key = section_key(motion)
    if key is None:
        return None
    seen = (motion.kind == key[0]) & (motion.mode == key[1])
    size = np.abs(motion.after).max(axis=0)
    size[size == 0] = 1.0  # a coordinate that is zero at every event may have any scale
    return Watched(key, motion.after[seen], size, np.diff(motion.time[seen]).max(initial=0.0))


def recurrence(automaton: Automaton, motion: Motion, budget: Budget | None = None) -> SteadyState | None:
    """Return the attractor that the last events of a motion lie on or approach; None if they do not show it."""
    seen = watched(motion)
    if seen is None:
        return None
    key, points, size, longest = seen._replace(points=seen.points[-_POINTS:])
    changes = np.abs(points[-1] - points[-2 : -2 - PERIODS : -1]) / size
    repeats = np.flatnonzero((changes <= REPEATS[size.size > 2]).all(axis=1)) + 1
    if len(points) < FEWEST and not repeats.size:
        return None
    nearest = int(repeats[0]) if repeats.size else int(np.argmin(changes[:SOLVED].max(axis=1))) + 1
    section = Section(automaton, key, points[-1], size, nearest, longest, budget)
    if repeats.size and size.size == 2:
        found = section.repeated()
        return found and cycle_through(section, found)
    divisors = [returns for returns in range(1, nearest + 1) if nearest % returns == 0]
    for returns in divisors:  # a slow cycle may seem to have a multiple of its returns
        before = points[-1 - returns : len(points) // 2 : -returns][::-1]
        section = Section(automaton, key, points[-1], size, returns, longest, budget)
        found = section.fixed_point(before) if len(before) else None
        if found is None:
            continue
        if section.dimension == 1 and not drift_two_states.goes_straight(section, float(section.place(found.state)[0])):
            continue
        if size.size > 2 and not _by_the_same_events(section, found):
            continue
        if np.abs(found.state / size).max() < CORNERS[size.size > 2]:
            nearer = np.abs(points[-1] / size).max() < np.abs(before[-1] / size).max()
            if nearer and not _pushed(motion):
                return SteadyState(Attractor.STEADY_SLIDING, np.zeros_like(found.state))
            continue
        for fewer in divisors[: divisors.index(returns)]:  # Newton's method may miss these from afar
            there = Section(automaton, key, found.state, size, fewer, longest, budget)
            again = there.fixed_point(before)
            if again is not None and (np.abs(again.state - found.state) <= CORNERS[0] * size).all():
                return cycle_through(there, again)
        return cycle_through(section, found)
    if not repeats.size or _drifts(points[::-nearest]):
        return None
    found = section.repeated()
    attracts = abs(found.multiplier) < 1 - MARGIN  # no comparison holds with a multiplier that is not known
    return cycle_through(section, found) if found.neutral or (attracts and _on_its_cycle(section)) else None


def _by_the_same_events(section: Section, found: FixedPoint) -> bool:
    """Whether returns have the same events all the way from the origin of a section to a fixed point."""
    target = section.place(found.state)
    events = [section.outcome(part * target)[1] for part in _WAY]
    return events[0] is not None and all(one == events[0] for one in events)


def _pushed(motion: Motion) -> bool:
    """Whether a mode of the later half of a motion has its equilibrium elsewhere than at steady sliding.

    Then steady sliding lies on no surface, and no events are left near it: what is small is a cycle.
    """
    flow, modes = motion.automaton.tables.flow, np.unique(motion.mode[motion.time.size // 2 :])
    return bool((flow[modes, layout.EQUILIBRIUM] if isinstance(flow, np.ndarray) else flow.field[modes, :, -1]).any())


def _on_its_cycle(section: Section) -> bool:
    """Whether the origin is a fixed point of the return map as far as the size of its own orbit tells.

    What has fallen by ten decades since the first event seems to repeat while it still moves by parts of itself. The
    fixed point, if there is one, is (1 − P′)⁻¹ (P(y) − y) away.
    """
    here, orbit = np.zeros(section.dimension), section.come_back(section.origin)
    (slopes, _), gap = section.slopes(here), section.excess(here)
    if orbit is None or not (np.isfinite(slopes).all() and np.isfinite(gap).all()):
        return False
    away = section.directions @ np.linalg.lstsq(np.eye(section.dimension) - slopes, gap, rcond=None)[0]
    return bool(np.abs(away / section.size).max() <= _ON_IT * (_swing(orbit) / section.size).max())


def _swing(orbit: Motion) -> np.ndarray:
    """Return how far (n) the states of a motion lie apart."""
    return np.ptp(orbit.at(orbit.end_time * _WAY)[0], axis=0)


def _drifts(states: np.ndarray) -> bool:
    """Whether states (k, n) of a section, the latest first, move in one direction by steps that do not shrink."""
    if len(states) <= _STEPS:
        return False
    size = np.maximum(np.abs(states[: _STEPS + 1]).max(axis=0), np.finfo(float).tiny)
    latest, first, all_of_them = (
        np.abs((states[i] - states[j]) / size).max() for i, j in ((0, 1), (_STEPS - 1, _STEPS), (0, _STEPS))
    )
    # Half of the way of so many latest steps, and nine tenths of the first step, leave room for what scatters.
    return bool(all_of_them > 0.5 * _STEPS * latest and latest > 0.9 * first)


def cycle_through(section: Section, found: FixedPoint) -> SteadyState | None:
    """Return the cycle through a fixed point of the return map; None if its motion does not come back."""
    orbit = section.come_back(found.state)
    if orbit is None:
        return None
    label = cycle_label(orbit)
    touches = label == Attractor.STICK_SLIP_CYCLE and conserves(orbit.automaton) and _only_touches_rest(orbit)
    if touches or (found.neutral and label != Attractor.SPRAG_SLIP_CYCLE):
        label = Attractor.NEUTRAL_FAMILY
    residual = float(np.max(np.abs(orbit.end_state - found.state) / section.size))
    return SteadyState(label, found.state, orbit, section.returns, residual, found.enclosure, found.multiplier)


def _only_touches_rest(motion: Motion) -> bool:
    """Whether a motion rests for no longer than the largest of a neutral family seems to, where it touches θ′ = 0."""
    modes, _, _, durations = motion.arcs()
    resting = np.isin(motion.automaton.codes[modes], motion.automaton.rest_codes)
    return bool(durations[resting].sum() <= _TOUCH * durations.sum())
