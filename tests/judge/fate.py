"""What becomes of a motion of the rigid drive in the end, judged by watching its events and not by proving anything.

No motion of this drive can grow without bound: with E = ½ (I + m r_m² tan² λ) θ′² + ½ k z² the dampings, the friction
of the threads and the impacts take energy, and motor and axial force bring in no more than a constant times √E, which
is less than a part that dampings and friction take in proportion to E. So a motion

* settles in a mode that it never leaves: *steady sliding* where C of its law is positive, *neutral family* where it is
  zero, since then every start nearby has its own oscillation;
* or rests again and again: every rest ends in one and the same state, so two of them enclose a cycle;
* or recurs without rest: its states at equal events repeat, or drift from turn to turn. A drift is not followed turn by
  turn: the return map is asked farther and farther ahead, as long as the same events come and the drift keeps its
  direction. Where the drift turns back there is a cycle; where the events change the motion is watched again, from
  several points of that turn, since nobody counts the turns until then.
"""

import math
from typing import NamedTuple

import numpy as np

from judge.second_opinions import watch
from judge.second_opinions.watch import WatchConstants
from lsvib.bench.sweeps.taylor import HALVINGS

_FIRST, _MOST = 256, 16_384  # events looked at first, and before a motion without a pattern is given up
_PERIODS = 64  # events in the longest pattern
_STILL = 3e-13  # of the size of the motion; a state that returns to this, and does not drift, has come back
_SEEN = 1e-14  # of the size of the motion; a smaller drift in a turn is rounding
_CORNER = 1e-9  # of the size of the drive; a smaller motion has come to the equilibrium on Q = 0
_LEAPS = 400  # of one motion
_SLOW = 0.1  # of the size of the motion; a drift that is faster is followed turn by turn
_FEW = 8  # leaps that are not worth a new watch
_BEHIND = range(-30, 11)  # powers of two, times the last leap, of the places asked behind a drift of zero
_CLEAR = 1e-3  # of a drift, by which one the other way is more than rounding: a surface only touched magnifies that
_PHASES = (0.0, 0.31, 0.57, 0.83)  # of the turn in which a drift ends


class Fate(NamedTuple):
    """Name of the attractor as in ``lsvib.cycles.attractors.Attractor``, or ``unknown``; why; number of events watched.

    ``edge``: the motion stays on the outermost orbit of a neutral family, which touches θ′ = 0, so that digits decide
    whether it is told as a cycle or as one of the family. ``stops``: θ′ is zero somewhere on the cycle.
    """

    name: str
    reason: str
    events: int = 0
    edge: bool = False
    stops: bool = False


class _WatchedEvents(NamedTuple):
    end: int
    kinds: np.ndarray
    modes: np.ndarray
    states: np.ndarray
    u: float
    w: float
    law: int


def fate(constants: WatchConstants, u: float, w: float) -> Fate:
    """Watch the motion from (u [rad], w [rad/s]) until its fate is plain."""
    if u == 0 and w == 0 and not (constants.paradox and constants.flow[1, 6] != 0):
        return Fate("steady_sliding", "in equilibrium", 0)
    return _fate(constants, u, w, watch.ANYWHERE, _LEAPS)


def _fate(c: WatchConstants, u: float, w: float, mode: int, leaps: int) -> Fate:
    events, room = 0, _FIRST
    while True:
        seen = _watch(c, u, w, mode, room)
        events += seen.kinds.size
        if seen.end == watch.SLOW:
            return _grown(c, seen, events, leaps)
        if seen.end == watch.AMBIGUOUS:
            return Fate("unknown", "a guard that cannot be told in double precision", events)
        if seen.end == watch.SETTLED:
            return _settled(c, seen, events)
        released = np.flatnonzero(seen.kinds == watch.RELEASE)
        if released.size >= 2:
            return _named(c, seen.kinds[released[0] + 1 : released[1] + 1], events, "two rests")
        size = np.abs(seen.states[seen.kinds.size // 2 :]).max(axis=0)
        if _vanishes(c, size[0], size[1]):
            return Fate("steady_sliding", "events without end that shrink to the equilibrium", events)
        period = _pattern(seen.modes)
        if period is None or released.size:
            u, w, mode, room = seen.u, seen.w, int(seen.modes[-1]), min(2 * room, _MOST)
            if events > 4 * _MOST:
                return Fate("unknown", "no pattern of events", events)
            continue
        if c.flow[1, 0] == 0 and (seen.kinds[-period:] == watch.CONTACT_REVERSAL).all():
            return Fate("neutral_family", "undamped, a closed orbit with contact reversals", events)
        return _drift(c, seen, period, events, leaps)


def _vanishes(c: WatchConstants, u: float, w: float) -> bool:
    """Whether a motion has become so small that it has come to an equilibrium on Q = 0; any other it would settle to.

    Without damping no motion becomes small: it loses energy only where θ′ passes zero.
    """
    damped = c.flow[1, 0] != 0  # C of law −1 is zero only if both dampings are
    return damped and c.net_force == 0 and abs(u) < _CORNER * c.scale and abs(w) < _CORNER * abs(c.speed)


def _watch(c: WatchConstants, u: float, w: float, mode: int, room: int) -> _WatchedEvents:
    times, kinds, modes = np.empty(room), np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
    states = np.empty((room, 2))
    end, count, u, w, law = watch.watch(c, u, w, mode, math.inf, True, times, kinds, modes, states)
    return _WatchedEvents(end, kinds[:count], modes[:count], states[:count], u, w, law)


def _settled(c: WatchConstants, seen: _WatchedEvents, events: int) -> Fate:
    row = c.flow[0 if seen.law > 0 else 1]
    damping, place = row[0], row[6]
    if damping > 0:
        return Fate("steady_sliding", "no further event", events)
    if damping < 0:
        return Fate("unknown", "grows and meets no guard", events)
    size = math.hypot(seen.w, math.sqrt(row[1]) * (seen.u - place))
    edge = abs(size / c.speed) > 1 - _CORNER
    return Fate("neutral_family", "undamped, no further event", events, edge)


def _grown(c: WatchConstants, seen: _WatchedEvents, events: int, leaps: int) -> Fate:
    """Growth over more turns than can be counted: enlarge the motion until it is near a guard, in several phases."""
    row = c.flow[0]
    u, w = seen.u - row[6], seen.w
    low, high = 1.0, 2.0
    while _watch(c, row[6] + high * u, high * w, watch.ANYWHERE, 1).end == watch.SLOW:
        low, high = high, 2 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        slow = _watch(c, row[6] + middle * u, middle * w, watch.ANYWHERE, 1).end == watch.SLOW
        low, high = (middle, high) if slow else (low, middle)
    turn = math.expm1(-2 * math.pi * row[0] / row[2])  # growth in a turn
    if leaps < _FEW:
        return Fate("unknown", "too many patterns", events)
    parts = [high * (1 + phase * turn) for phase in _PHASES]
    fates = [_fate(c, row[6] + part * u, part * w, watch.ANYWHERE, leaps // 2) for part in parts]
    return _agreed(fates, events)


def _agreed(fates: list[Fate], events: int) -> Fate:
    if any(found.name != fates[0].name for found in fates):
        return Fate("unknown", "the turn in which slow growth or a slow drift ends decides", events)
    return fates[0]._replace(events=events + fates[0].events)


def _named(c: WatchConstants, kinds: np.ndarray, events: int, reason: str) -> Fate:
    found = set(kinds.tolist())
    if watch.SEIZURE in found:
        return Fate("sprag_slip_cycle", reason, events)
    if watch.RELEASE in found:
        if c.flow[1, 0] == 0 and watch.REVERSAL not in found:
            return Fate("neutral_family", "undamped, from the end of rest, touching θ′ = 0", events, True)
        return Fate("stick_slip_cycle", reason, events, stops=True)
    return Fate("other_cycle", reason, events, stops=found != {watch.CONTACT_REVERSAL})


def _pattern(modes: np.ndarray) -> int | None:
    """Number of events after which kinds and modes have repeated, four times over at the end; None if they do not."""
    for period in range(1, min(_PERIODS, modes.size // 4) + 1):
        last = modes[-4 * period :]
        if (last[period:] == last[:-period]).all():
            return period
    return None


class _WatchedSection:
    """The return map of a pattern of events, as a function of the coordinate along the guard of its last event."""

    def __init__(self, c: WatchConstants, seen: _WatchedEvents, period: int) -> None:
        self.c, self.pattern, self.mode = c, seen.modes[-period:], int(seen.modes[-1])
        self.kinds = self.pattern % 10
        self.on_contact = int(seen.kinds[-1]) == watch.CONTACT_REVERSAL
        self.start = float(seen.states[-1, int(self.on_contact)])
        self.least = abs(c.speed) / math.sqrt(c.flow[1, 1])  # what the rounding of a rate makes of u
        self.size = float(np.abs(seen.states[-period:, int(self.on_contact)]).max())

    def state(self, x: float) -> tuple[float, float]:
        """(u, w) of a point: w is the coordinate along Q = 0, u along θ′ = 0."""
        if not self.on_contact:
            return x, -self.c.speed
        q_u, q_w, q_0 = self.c.contact
        return -(q_0 + q_w * x) / q_u, x

    def drift(self, x: float) -> float | None:
        """Change of the coordinate in one return, 0 where it is rounding, None if other events come."""
        seen = _watch(self.c, *self.state(x), self.mode, self.pattern.size)
        if seen.end != watch.EVENTS_FULL or seen.modes.size != self.pattern.size or (seen.modes != self.pattern).any():
            return None
        places = seen.states[:, int(self.on_contact)]
        turning = math.sqrt(self.c.flow[1, 1])  # between events u swings as far as w / ω, and w as far as u ω
        swing = np.abs(seen.states[:, int(not self.on_contact)]).max() * (turning if self.on_contact else 1 / turning)
        size = max(abs(x), np.abs(places).max(), swing, 0.0 if self.on_contact else self.least)
        change = float(places[-1]) - x
        return change if abs(change) > _SEEN * size else 0.0

    def ahead(self, x: float) -> tuple[float, float] | None:
        """A point that motions come to, near x where they do, and its drift: where one return from x leads."""
        first = self.drift(x)
        if first is None or abs(first) > _SLOW * self.size:
            return None
        second = self.drift(x + first)
        return None if second is None else (x + first, second)

    def turns(self, x: float, step: float, drift: float) -> bool:
        """Whether the drift has turned back somewhere behind x, as clearly as it was there before."""
        changes = (self.drift(x + step * 2.0**power) for power in _BEHIND)
        back = math.copysign(1.0, -drift)
        return any(change is not None and change * back > _CLEAR * abs(drift) for change in changes)


def _drift(c: WatchConstants, seen: _WatchedEvents, period: int, events: int, leaps: int) -> Fate:
    section = _WatchedSection(c, seen, period)
    x = section.start
    drift = section.drift(x)
    if drift is None:  # the pattern ends with this very turn
        return _go_on(c, section, x, 0.0, events, leaps)
    if drift == 0:
        return _still(c, section, x, events)
    step, growing = drift, True
    while leaps > 0:
        leaps -= 1
        found = section.ahead(x + step)
        if found is None:
            if abs(step) <= 2 * abs(drift):
                return _go_on(c, section, x, drift, events, leaps)
            step, growing = 0.5 * step, False
            continue
        there, ahead = found
        if ahead * drift <= 0:
            if not section.turns(there, step, drift):
                return Fate("unknown", "a drift that fades into rounding", events)
            return _between(c, section, x, there, drift, events)
        x, drift = there, ahead
        step = 2 * step if growing else step
        u, w = section.state(x)
        if _vanishes(c, u, w):
            return Fate("steady_sliding", "events without end that shrink to the equilibrium", events)
    return Fate("unknown", "too many leaps", events)


def _between(c: WatchConstants, section: _WatchedSection, x: float, y: float, drift: float, events: int) -> Fate:
    """A drift that turns back between two points: a cycle, if it passes through zero."""
    least = abs(drift)
    for _ in range(HALVINGS):
        middle = 0.5 * (x + y)
        change = section.drift(middle)
        if change is None:
            return Fate("unknown", "a pattern with gaps", events)
        least = min(least, abs(change))
        if change == 0:
            break
        x, y = (middle, y) if change * drift > 0 else (x, middle)
    if least > _CORNER * section.size:
        return Fate("unknown", "a drift that jumps", events)
    u, w = section.state(x)
    if _vanishes(c, u, w):
        return Fate("steady_sliding", "events without end that shrink to the equilibrium", events)
    if c.flow[1, 0] == 0 and not (section.kinds == watch.SEIZURE).any():
        return Fate("neutral_family", "undamped, a drift towards the outermost closed orbit", events, True)
    return _named(c, section.kinds, events, "a drift that turns back")


def _still(c: WatchConstants, section: _WatchedSection, x: float, events: int) -> Fate:
    """No drift to rounding: a cycle if motions on both sides come nearer."""
    kinds = section.kinds
    if c.flow[1, 0] == 0 and not (kinds == watch.SEIZURE).any():
        return Fate("neutral_family", "undamped, states repeat", events, True)
    for part in (1e-3, 1e-5, 1e-7):
        step = part * section.size
        ahead, behind = section.drift(x + step), section.drift(x - step)
        if ahead is None or behind is None:
            continue
        if ahead < 0 < behind:
            return _named(c, kinds, events, "a cycle that attracts")
        if behind < 0 < ahead:
            return _named(c, kinds, events, "a cycle that repels")
    return Fate("unknown", "no drift to rounding", events)


def _go_on(c: WatchConstants, section: _WatchedSection, x: float, drift: float, events: int, leaps: int) -> Fate:
    """Watch again where a pattern ends, from several points of the last turn."""
    if leaps < _FEW:
        return Fate("unknown", "too many patterns", events)
    fates = [_fate(c, *section.state(x + phase * drift), section.mode, leaps // 2) for phase in _PHASES]
    return _agreed(fates, events)
