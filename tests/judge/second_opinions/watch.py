"""A third way to follow the rigid drive: closed forms and all extrema of the guards, in double precision.

It is the method of :mod:`lsvib.bench.reference.rigid_digits`, compiled, with that reference's constants rounded once,
and shares no line with the engine. It costs less than a microsecond an event however stiff the drive is, knows when no
further event can come, and so can watch a motion until its fate is plain. What it cannot decide with its digits is left
to the reference.
"""

import math
from typing import NamedTuple

import numpy as np
from mpmath import mp

from judge.second_opinions.endings import AMBIGUOUS, EVENTS_FULL, SETTLED, SLOW, TIME_REACHED
from judge.second_opinions.jit import allocating_kernel, kernel
from lsvib.bench.reference.rigid_digits import RigidTrueDrive
from lsvib.bench.sweeps import taylor
from lsvib.bench.sweeps.taylor import CONTACT_REVERSAL, DIGITS, RELEASE, REVERSAL, SEIZURE, STICK

ANYWHERE = -1  # mode of a start that is told by its state
_A, _B, _OMEGA, _FORM, _FAST, _SLOW, _REST, _CONTACT = range(8)  # columns of ``WatchConstants.flow``
# What a search for a root returns instead of a time, which is never negative.
_NEVER = -1.0  # there is no root
_WRONG_SIDE = -2.0  # the guard has left zero on the wrong side
_TOO_LATE = -3.0  # after more turns than the phase is known for
_AT_ONCE = 1e-7  # of the fastest time; the stationary point of a guard that has just been left may come out so late
_AT_CORNER = 1e-9  # of its terms; Q at θ′ = 0 below this starts slips that w = θ′ − Ω cannot hold
_ON_LINE = 1e-15  # of its terms; Q below this is zero
_AT_END = 1e-13  # of its terms; u beyond the band of rest
_TURNS = 1e6  # half turns after which the phase is not known well enough
_DOUBLINGS = 2000  # of a time that begins at 1e-3 of the fastest; it is infinite before
_STEPS = 200  # of a root: 53 halvings of a bracket leave a double, and one more for each power of two nearer to zero


class WatchConstants(NamedTuple):
    """The drive of eqs (8.16), (8.17) in numbers; rows of ``flow`` are the laws +1 and −1."""

    flow: np.ndarray  # (2, 8): a = C/2Γ, b = k/Γ, √|a² − b|, sign of a² − b, both rates, u and Q at rest
    contact: np.ndarray  # (3,) Q as an affine function of (u, w)
    speed: float  # Ω
    band: np.ndarray  # (2,) u at the ends of static friction, ascending
    push: float  # u at which slip under law −1 has no acceleration from rest
    released: float  # u at which rest ends
    force_sign: int  # of R
    net_force: float  # R̃
    paradox: bool
    scale: float  # size of u, for rounding


def constants(parameters: dict[str, float]) -> WatchConstants:
    """Form the constants of a rigid drive [SI units] with 40 digits and round them once."""
    shared = taylor.constants(parameters)._asdict()
    del shared["rates"]
    with mp.workdps(DIGITS):
        d = RigidTrueDrive(parameters, DIGITS)
        flow = np.zeros((2, 8))
        q_u, _, q_0 = d.Q_terms(1, 1)
        for row, s in enumerate((1, -1)):
            if s > 0 and d.painleve:
                continue
            a, b = d.C(s) / (2 * d.Gamma(s)), d.k / d.Gamma(s)
            u = d.r * (d.xi(d.s0) - d.xi(s)) * d.R_tilde / d.k
            disc = a * a - b
            half = mp.sqrt(abs(disc))
            fast = -a - (half if a >= 0 else -half)
            flow[row] = [float(x) for x in (a, b, half, mp.sign(disc), fast, b / fast if fast else 0, u, q_u * u + q_0)]
        return WatchConstants(flow=flow, net_force=float(d.R_tilde), **shared)


@kernel
def _value(row, h0, h1, t):
    """h(t) for h″ + 2a h′ + b h = 0 from h(0) = h0, h′(0) = h1."""
    a, half = row[_A], row[_OMEGA]
    if row[_FORM] < 0:
        return math.exp(-a * t) * (h0 * math.cos(half * t) + (h1 + a * h0) / half * math.sin(half * t))
    if row[_FORM] == 0:
        return math.exp(-a * t) * (h0 + (h1 + a * h0) * t)
    if half * t < 0.5:
        return math.exp(-a * t) * (h0 * math.cosh(half * t) + (h1 + a * h0) / half * math.sinh(half * t))
    fast, slow = row[_FAST], row[_SLOW]
    first, second = (h1 - slow * h0) / (fast - slow), (fast * h0 - h1) / (fast - slow)
    one = first * math.exp(fast * t) if first != 0 else 0.0
    two = second * math.exp(slow * t) if second != 0 else 0.0
    return one + two


@kernel
def _curvature(row, h0, h1):
    return -2.0 * row[_A] * h1 - row[_B] * h0


@kernel
def _root(row, level, h0, h1, left, right):
    """Root of level + h, positive at ``left`` and not at ``right``, monotone between: Newton in a shrinking bracket."""
    h2 = _curvature(row, h0, h1)
    t, last = 0.5 * (left + right), right - left
    for _ in range(_STEPS):
        value = level + _value(row, h0, h1, t)
        if value > 0:
            left = t
        else:
            right = t
        slope = _value(row, h1, h2, t)
        step = -value / slope if slope != 0 else right - left
        if not (left < t + step < right and abs(step) <= 0.5 * last):
            step = 0.5 * (left + right) - t
        if t + step == t or right - left <= 2e-16 * right:
            break
        t, last = t + step, abs(step)
    return t


@kernel
def _far_root(row, level, h0, h1, left):
    """Root beyond ``left`` of level + h, which is known to fall for ever."""
    width = 1e-3 / (abs(row[_A]) + math.sqrt(row[_B]))
    for _ in range(_DOUBLINGS):
        right = left + width
        value = level + _value(row, h0, h1, right)
        if not math.isfinite(value):
            return _WRONG_SIDE
        if value <= 0:
            return _root(row, level, h0, h1, left, right)
        left, width = right, 2 * width
    return _WRONG_SIDE


@kernel
def first_root(row, rest, h0, h1, fresh):
    """First time at which the guard rest + h falls to zero; _NEVER, or _WRONG_SIDE where that cannot be told.

    ``fresh``: the guard is zero now and has just been left for the positive side.
    """
    h2 = _curvature(row, h0, h1)
    a, half, form = row[_A], row[_OMEGA], row[_FORM]
    soon = _AT_ONCE / (abs(a) + math.sqrt(row[_B])) if fresh else 0.0
    level = -h0 if fresh else rest
    if not fresh and level + h0 <= 0:
        return _WRONG_SIDE
    if fresh and ((h1 <= 0 and h2 <= 0) or h1 * (abs(a) + math.sqrt(row[_B])) < -_AT_ONCE * abs(h2)):
        return _WRONG_SIDE
    if form < 0:
        if h0 == 0 and h1 == 0:
            return _NEVER
        spacing = math.pi / half
        angle = math.atan2(-h1, (h2 + a * h1) / half) % math.pi
        at = angle / half
        if at <= soon:
            at += spacing
        extreme = _value(row, h0, h1, at)
        if level + extreme <= 0:
            return _root(row, level, h0, h1, 0.0, at)
        factor = math.exp(-a * spacing)
        following = -extreme * factor
        if level + following <= 0:
            return _root(row, level, h0, h1, at, at + spacing)
        if a >= 0 or level <= 0:
            return _NEVER
        lowest, n = (extreme, 0) if extreme < 0 else (following, 1)
        if lowest == 0:
            return _NEVER
        n += 2 * max(math.floor(math.log(level / -lowest) / (-2.0 * a * spacing)) - 1, 0)
        if n > _TURNS:
            return _TOO_LATE
        while level + _value(row, h0, h1, at + n * spacing) > 0:
            n += 2
            if n > 2 * _TURNS:
                return _WRONG_SIDE
        return _root(row, level, h0, h1, at + (n - 1) * spacing, at + n * spacing)
    left = 0.0
    if form == 0:
        slope = h2 + a * h1
        at = -h1 / slope if slope != 0 else -1.0
        final = h1 + a * h0
    else:
        fast, slow = row[_FAST], row[_SLOW]
        first, second = h1 - slow * h0, fast * h0 - h1
        ratio = -second * slow / (first * fast) if first != 0 else -1.0
        at = math.log(ratio) / (fast - slow) if ratio > 0 else -1.0
        final = first / (fast - slow)
    if at > soon:
        if level + _value(row, h0, h1, at) <= 0:
            return _root(row, level, h0, h1, 0.0, at)
        left = at
    falls = final < 0 if a < 0 else rest < 0
    return _far_root(row, level, h0, h1, left) if falls else _NEVER


@kernel
def coded(direction, contact, kind):
    """Mode after an event and the event's kind as one number."""
    return 100 * (direction + 1) + 10 * (contact + 1) + kind


@kernel
def _sign(x):
    return 1 if x > 0.0 else (-1 if x < 0.0 else 0)


@kernel
def _contact_sign(c, u, w, part):
    one, two, three = c.contact[0] * u, c.contact[1] * w, c.contact[2]
    size = max(abs(one), abs(two), abs(three), c.contact[0] * c.scale)
    value = one + two + three
    return _sign(value) if abs(value) > part * size else 0


@kernel
def _contact_next(c, u, w):
    """Sign of Q, or of its rate where it is zero; Q′ at Q = 0 is the same under both laws."""
    sign = _contact_sign(c, u, w, _ON_LINE)
    if sign != 0:
        return sign
    row = c.flow[1]
    return _sign(c.contact[0] * w + c.contact[1] * (row[_B] * (row[_REST] - u) - 2.0 * row[_A] * w))


@kernel
def _by_band(c, u):
    """Direction and contact at θ′ = 0 by the band of static friction; (0, 0) is rest."""
    rounding = _AT_END * max(abs(u), c.scale)
    if c.band[0] - rounding <= u <= c.band[1] + rounding:
        return 0, 0
    direction = 1 if u < c.band[0] else -1
    return direction, -direction if c.paradox else _contact_next(c, u, -c.speed)


@kernel
def _resumed(c, u, sign):
    """After a seizure of the given sign: slip against it under law −1 if Q admits it and the torque drives it."""
    if _contact_sign(c, u, -c.speed, _AT_CORNER) == sign and _sign(c.push - u) == -sign:
        return -sign, sign
    return _by_band(c, u)


@allocating_kernel
def watch(c, u, w, mode, t_end, two_releases, times, kinds, modes, states):
    """Follow the motion from (u [rad], w [rad/s]) to t_end [s]; its events are written to the four arrays.

    ``mode``: ANYWHERE, or what :func:`coded` tells of the event just before. ``two_releases``: end at the second
    release from rest, after which the motion repeats. ``modes`` (n), ``states`` (n, 2): after each event. Returns (how
    it ends, number of events, u, w, law of the last slip). One loop over the arcs: what an arc hands to the next are
    nine numbers, which a kernel for each part would have to take and return.
    """
    t, count, kind = 0.0, 0, -1
    if mode != ANYWHERE:
        direction, contact, last = mode // 100 - 1, mode // 10 % 10 - 1, mode % 10
        fresh_contact = last == CONTACT_REVERSAL or _contact_sign(c, u, w, _ON_LINE) == 0
        fresh_speed = last != CONTACT_REVERSAL
    else:
        direction, contact = _sign(w + c.speed), _contact_next(c, u, w)
        if direction == 0:
            direction, contact = _by_band(c, u)
        elif c.paradox and contact == direction:
            direction, contact = _resumed(c, u, direction)
            kind, w = SEIZURE, -c.speed
        fresh_contact = _contact_sign(c, u, w, _ON_LINE) == 0
        fresh_speed = w == -c.speed
    releases = 0
    while True:
        if kind >= 0:
            times[count], kinds[count], modes[count] = t, kind, coded(direction, contact, kind)
            states[count, 0], states[count, 1] = u, w
            count += 1
            releases += kind == RELEASE
            if count == times.size or (two_releases and releases == 2):
                return EVENTS_FULL, count, u, w, direction * contact
        if direction == 0:
            stay = max((u - c.released) / c.speed, 0.0)
            if t + stay > t_end:
                return TIME_REACHED, count, u - c.speed * (t_end - t), w, 0
            t, u = t + stay, c.released
            direction = _sign(c.speed)
            contact = -direction if c.paradox or c.force_sign == 0 else c.force_sign
            kind, fresh_speed = RELEASE, True
            fresh_contact = _contact_sign(c, u, w, _ON_LINE) == 0
            continue
        row = c.flow[0] if direction * contact > 0 else c.flow[1]
        y = u - row[_REST]
        rate = -2.0 * row[_A] * w - row[_B] * y
        stop = first_root(row, direction * c.speed, direction * w, direction * rate, fresh_speed)
        h0 = contact * (c.contact[0] * y + c.contact[1] * w)
        h1 = contact * (c.contact[0] * w + c.contact[1] * rate)
        turn = first_root(row, contact * row[_CONTACT], h0, h1, fresh_contact)
        if stop == _WRONG_SIDE or turn == _WRONG_SIDE:
            return AMBIGUOUS, count, u, w, direction * contact
        if stop == _TOO_LATE or turn == _TOO_LATE:
            other = turn if stop == _TOO_LATE else stop
            if other < 0 and other != _WRONG_SIDE and t_end == math.inf:
                return SLOW, count, u, w, direction * contact
            stop, turn = (_NEVER, turn) if stop == _TOO_LATE else (stop, _NEVER)
        turns = stop == _NEVER or 0 <= turn < stop
        part = turn if turns else stop
        if turns and turn == _NEVER:
            part = math.inf
        if t + part > t_end or part == math.inf:
            if t_end == math.inf:
                return SETTLED, count, u, w, direction * contact
            left = t_end - t
            u, w = row[_REST] + _value(row, y, w, left), _value(row, w, rate, left)
            return TIME_REACHED, count, u, w, direction * contact
        u, w, t = row[_REST] + _value(row, y, w, part), _value(row, w, rate, part), t + part
        if turns and not c.paradox:
            contact, kind, fresh_contact, fresh_speed = -contact, CONTACT_REVERSAL, True, False
            continue
        if turns:
            kind = SEIZURE
            direction, contact = _resumed(c, u, direction)
        else:
            direction, contact = _resumed(c, u, contact) if c.paradox else _by_band(c, u)
            kind = STICK if direction == 0 else REVERSAL
        w, fresh_speed = -c.speed, True
        fresh_contact = _contact_sign(c, u, w, _ON_LINE) == 0


_ROOM = 256  # events within which a motion that settles mostly has done so


@allocating_kernel
def come_to_rest(c: WatchConstants, starts: np.ndarray) -> np.ndarray:
    """Tell of starts (n, 2) whether they soon settle in damped slip (n); of those that do not, nothing is known."""
    found = np.zeros(len(starts), dtype=np.bool_)
    times, kinds, modes = np.empty(_ROOM), np.empty(_ROOM, dtype=np.int64), np.empty(_ROOM, dtype=np.int64)
    states = np.empty((_ROOM, 2))
    for k in range(starts.shape[0]):
        end, _, _, _, law = watch(c, starts[k, 0], starts[k, 1], ANYWHERE, math.inf, True, times, kinds, modes, states)
        found[k] = end == SETTLED and c.flow[0 if law > 0 else 1, _A] > 0
    return found
