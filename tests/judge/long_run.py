"""What becomes of a motion of a drive with four states in the end, judged by a long run of strides.

It shares nothing with the engine: Newton's laws are those of the references, the method is that of
:mod:`judge.second_opinions.strides`. The motion

* *settles* if it has come to a mode whose own rates, found with many digits, leave all its conditions positive for
  ever: each is bounded by its value at the mode's equilibrium less the amplitudes of all parts. Then it is steady
  sliding where all parts die away, and a neutral family where one goes on for ever;
* *cycles* if the same events have come back many times, with states that repeat to rounding, or that come closer to
  each other by the same factor from turn to turn, so that the rest of the way is small;
* is *unbounded* if the same events have come back many times and it has grown in the end by the same factor from turn
  to turn to a size beside which no constant of the drive counts;
* else it is *unknown*: a motion that drifts slowly, is chaotic, or was followed for too short a time.
"""

from typing import Any

import numpy as np
from mpmath import mp

from judge import linear_judge
from judge.fate import Fate
from judge.second_opinions import strides
from judge.second_opinions.endings import AMBIGUOUS, LATE, TIME_REACHED
from judge.second_opinions.stride_constants import ABSENT, Ladders, ladders
from judge.wide_drives import WideDrive
from lsvib.bench.reference.rigid_digits import RigidTrueDrive

_EVENTS, _STRIDES = 20_000, 200_000  # most events and most strides of one run
_LONG = 1000.0  # slowest times near steady sliding, within which a damped motion dies away
_LONGEST = 1e13  # longest run in fastest times: the ladder has as many rungs as a double allows
_DIGITS = 60  # digits of the rates of a mode, so that a double rate still has 30 of them
_NONE = 1e-25  # A real part below this share of the largest rate is the rounding of pairs of doubles.
_SAME = 1e-20  # relative distance within which a rate of a mode is one of the exact rates near steady sliding
_GONE = 1e-14  # A value below this share of the sum of its terms is rounding.
_PERIODS = 64  # events in the longest pattern
_TIMES = 12  # times that a pattern must have come back
_REPEATS = 1e-12  # relative distance of states that are the same again
_FASTER = 0.97  # largest ratio of the steps of successive turns from which the end of a slow motion is told
_HUGE = 1e30  # growth after which a motion is in proportion to itself: constants lie below half its last of 32 digits
_NEAR = 1e-2  # longest way that may be left to that end, relative to the size of the motion


def constants_of(wide: WideDrive) -> tuple[Ladders, float]:
    """Constants of a drive for motions that last for long, and how long [s]."""
    rates = linear_judge.rates(wide)
    sizes = [max(abs(float(mp.re(x))), 1e-300) for x in rates] + [abs(float(mp.im(x))) for x in rates if mp.im(x)]
    fastest = max(abs(complex(x)) for x in rates)
    longest = min(_LONG / min(sizes), _LONGEST / fastest)
    return ladders(wide.model, dict(wide.drive), wide.physics, longest), longest


def fate(wide: WideDrive, k: int, c: Ladders, longest: float) -> Fate:
    """Follow motion ``k`` of a drive for long."""
    # The mismatch of threads counts from N = 0; in the Painlevé region steady sliding under law +1 is no motion.
    if wide.model != "threads" and not c.paradox and not wide.starts[k].any():
        return Fate("steady_sliding", "in equilibrium")
    times, states = np.empty(_EVENTS), np.empty((_EVENTS, 4))
    before, after, fired = (np.empty(_EVENTS, dtype=np.int64) for _ in range(3))
    end, size = np.empty(4), np.empty(4)
    status, count, mode = strides.follow(
        c, wide.starts[k], longest, _STRIDES, times, before, after, fired, states, end, size
    )
    if _grows(after[:count], fired[:count], states[:count]):
        return Fate("unbounded", "the same factor from turn to turn")
    if status == AMBIGUOUS:
        return Fate("unknown", "a condition that cannot be told")
    settled = _settled(wide, c, mode, end) if status in (TIME_REACHED, LATE) else None
    if settled is not None:
        return settled
    return _recurring(wide, c, after[:count], fired[:count], states[:count])


def _settled(wide: WideDrive, c: Ladders, mode: int, state: np.ndarray) -> Fate | None:
    """Whether a mode is never left again from a state on.

    Pairs of doubles do not hold the sign of a faint damping. Near steady sliding the exact rates do; elsewhere a part
    that they do not see die away lasts only if the drive has no damper.
    """
    if c.direction[mode] == 0 or (c.has_second and c.second[mode] == 0):
        return None
    with mp.workdps(_DIGITS):
        field = mp.matrix(4, 5)
        for i in range(4):
            for j in range(5):
                field[i, j] = mp.mpf(float(c.fields[mode, i, j, 0])) + mp.mpf(float(c.fields[mode, i, j, 1]))
        matrix, push = field[:, :4], field[:, 4]
        try:
            place = mp.lu_solve(matrix, -push)
            rates, right = mp.eig(matrix)
            parts = mp.lu_solve(right, mp.matrix([mp.mpf(float(x)) for x in state]) - place)
        except (ZeroDivisionError, ArithmeticError):
            return None
        largest = max(abs(x) for x in rates)
        lasts = False
        for rate, part in zip(rates, parts, strict=True):
            growth = _growth(wide, rate, largest)
            if growth is None or growth > 0:
                return None
            lasts |= bool(growth == 0 and abs(part) > 0)
        for r in range(c.kinds.shape[1]):
            if c.kinds[mode, r] == ABSENT:
                continue
            row = [mp.mpf(float(x[0])) + mp.mpf(float(x[1])) for x in c.rows[mode, r, 0]]
            value = row[4] + sum(row[i] * place[i] for i in range(4))
            swing = sum(abs(sum(row[i] * right[i, j] for i in range(4)) * parts[j]) for j in range(4))
            if not value > swing:
                return None
    return Fate("neutral_family" if lasts else "steady_sliding", "no further event")


def _growth(wide: WideDrive, rate: Any, largest: Any) -> Any:
    """Real part of a rate of a mode, exactly zero where nothing damps; None if it cannot be told from zero."""
    if abs(mp.re(rate)) > _NONE * largest:
        return mp.re(rate)
    if not any(value for name, value in dict(wide.drive).items() if "damping" in name):
        return 0
    exact = min(linear_judge.rates(wide), key=lambda one: abs(one - rate))
    if abs(exact - rate) > _SAME * abs(exact):
        return None
    return mp.re(exact) if abs(mp.re(exact)) > linear_judge.REAL * abs(exact) else 0


def _recurring(wide: WideDrive, c: Ladders, after: np.ndarray, fired: np.ndarray, states: np.ndarray) -> Fate:
    period = _pattern(after, fired)
    if period is None:
        return Fate("unknown", "no pattern of events")
    last = states[::-1][: period * _TIMES]
    size = np.maximum(np.abs(last).max(axis=0), np.finfo(float).tiny)
    turns = last[::period]
    steps = np.abs(np.diff(turns, axis=0) / size).max(axis=1)  # the latest first
    if steps[0] > _REPEATS:
        earlier = states[::-1][period : period * (_TIMES + 1)][::period]
        factors = steps[:-1] / np.maximum(steps[1:], np.finfo(float).tiny)
        if len(earlier) < _TIMES or not (factors < _FASTER).all():
            return Fate("unknown", "a slow drift")
        factor = factors.max()
        if steps[0] * factor / (1 - factor) > _NEAR:
            return Fate("unknown", "far from where it comes closer to")
    elif np.abs((turns[0] - turns[-1]) / size).max() > _TIMES / 2 * max(steps[0], np.finfo(float).eps):
        return Fate("unknown", "a slow drift")
    return Fate(_name(wide, c, after[-period:], fired[-period:]), "a pattern that repeats")


def _grows(after: np.ndarray, fired: np.ndarray, states: np.ndarray) -> bool:
    """Whether a motion grows by one factor from turn to turn, far beyond the constants of the drive."""
    period = _pattern(after, fired)
    if period is None:
        return False
    turns = np.abs(states[::-1][: period * _TIMES : period])
    size = turns.max(axis=1)
    factors = turns[:-1].max(axis=1) / size[1:]
    huge = size[0] > _HUGE * np.abs(states[0]).max()
    return bool(huge and factors.min() > 1 and np.ptp(factors) <= _REPEATS * factors.max())


def _pattern(after: np.ndarray, fired: np.ndarray) -> int | None:
    """Number of events after which they have come back many times at the end; None if they do not."""
    events = after * 16 + fired
    for period in range(1, min(_PERIODS, events.size // (_TIMES + 1)) + 1):
        last = events[-(_TIMES + 1) * period :]
        if (last[period:] == last[:-period]).all():
            return period
    return None


def _name(wide: WideDrive, c: Ladders, after: np.ndarray, fired: np.ndarray) -> str:
    if wide.model == "threads":
        under_plus = (c.direction[after] * c.contact[after] > 0).any()
        sprags = under_plus and RigidTrueDrive(dict(wide.drive), _DIGITS).painleve
    else:
        sprags = (fired == strides.SEIZURE).any()
    if sprags:
        return "sprag_slip_cycle"
    return "stick_slip_cycle" if (c.direction[after] == 0).any() else "other_cycle"
