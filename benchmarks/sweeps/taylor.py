"""A second way to follow the rigid drive: Taylor steps in double precision, events by the signs at the ends of a step.

It shares with the engine neither the flow (no characteristic roots: the series of the equation of motion, eq. 8.16) nor
the search (steps of a fixed part of the fastest time), nor the coefficients (those of
:mod:`references.rigid_digits`, rounded). It is a hundred times faster than that reference and
good for about ten digits, so that it can judge every case of a sweep; the reference judges those in which engine and
stepper disagree. It can miss what happens within a step, and its work grows with the stiffness.
"""

import math
from typing import NamedTuple

import numpy as np
from mpmath import mp

from benchmarks.jit import allocating_kernel, kernel
from references.rigid_digits import RigidTrueDrive

DIGITS = 40  # in which the constants of a drive are formed before they are rounded
# Names of the events in the order of their codes, as the references have them.
KINDS = ("contact_reversal", "stick", "reversal", "release", "seizure")
CONTACT_REVERSAL, STICK, REVERSAL, RELEASE, SEIZURE = range(5)
HALVINGS = 60  # of a bracket: what is left of it is below the last digit of a double
ORDER = 18  # of the series; a step of 0.25 fastest times leaves 1e-27
PART = 0.25  # of the fastest time: length of a step, so short that a guard hardly turns twice within it
_ROUNDING = 1e-15  # of a sum of three terms, in sizes of them: nine roundings, of which it has seven


class TaylorConstants(NamedTuple):
    """The drive of eqs (8.16), (8.17) in numbers; laws +1, −1 in the order of index."""

    rates: np.ndarray  # (2, 3): k/Γ, C/Γ, force/Γ
    contact: np.ndarray  # (3,) Q as an affine function of (u, w)
    speed: float  # Ω
    band: np.ndarray  # (2,) u at the ends of static friction, ascending
    push: float  # u at which slip under law −1 has no acceleration from rest
    released: float  # u at which rest ends
    force_sign: int  # of R
    paradox: bool
    scale: float  # size of u, for rounding


def constants(parameters: dict[str, float]) -> TaylorConstants:
    """Form the constants of a rigid drive [SI units] with 40 digits and round them once."""
    with mp.workdps(DIGITS):
        d = RigidTrueDrive(parameters, DIGITS)
        rates = np.zeros((2, 3))
        for row, s in enumerate((1, -1)):
            if d.Gamma(s) != 0:
                force = d.r * (d.xi(d.s0) - d.xi(s)) * d.R_tilde
                rates[row] = [float(x / d.Gamma(s)) for x in (d.k, d.C(s), force)]
        ends = sorted(float(-d.z0 - torque / d.k) for torque in d.band)
        push = d.r * (d.xi(d.s0) - d.xi(-1)) * d.R_tilde + d.C(-1) * d.Omega
        return TaylorConstants(
            rates=rates,
            contact=np.array([float(x) for x in d.Q_terms(1, 1)]),
            speed=float(d.Omega),
            band=np.array(ends),
            push=float(push / d.k),
            released=ends[0] if d.Omega > 0 else ends[1],
            force_sign=int(mp.sign(d.R)),
            paradox=d.painleve,
            scale=float(max(d.u_scale, abs(d.z0))),
        )


@kernel
def _series(rates, u, w, h, place, rate):
    """Taylor coefficients of u and w in the part of a step h."""
    place[0], rate[0] = u, w
    for n in range(ORDER):
        place[n + 1] = rate[n] * h / (n + 1)
        acceleration = -rates[0] * place[n] - rates[1] * rate[n]
        if n == 0:
            acceleration += rates[2]
        rate[n + 1] = acceleration * h / (n + 1)


@kernel
def _at(series, x):
    """Value and slope of a polynomial."""
    value, slope = 0.0, 0.0
    for n in range(ORDER, -1, -1):
        slope = slope * x + value
        value = value * x + series[n]
    return value, slope


@kernel
def _fall(series, fresh):
    """Part of the step at which a positive guard falls through zero, else 2; ``fresh``: it has just been left."""
    high = 1.0
    last, last_slope = _at(series, 1.0)
    if last > 0.0:
        if fresh or series[1] >= 0.0 or last_slope <= 0.0:
            return 2.0
        low = 0.0
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if _at(series, middle)[1] < 0.0:
                low = middle
            else:
                high = middle
        if _at(series, high)[0] > 0.0:
            return 2.0
    low = 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _at(series, middle)[0] > 0.0:
            low = middle
        else:
            high = middle
    return high


@kernel
def _sign(x):
    return 1 if x > 0.0 else (-1 if x < 0.0 else 0)


@kernel
def _contact_sign(c, u, w):
    value = c.contact[0] * u + c.contact[1] * w + c.contact[2]
    size = abs(c.contact[0] * u) + abs(c.contact[1] * w) + abs(c.contact[2])
    return _sign(value) if abs(value) > _ROUNDING * size else 0


@kernel
def _by_band(c, u):
    """Direction and sign of Q at θ′ = 0 by the band of static friction; (0, 0) is rest."""
    rounding = _ROUNDING * max(abs(u), c.scale)
    if c.band[0] - rounding <= u <= c.band[1] + rounding:
        return 0, 0
    direction = 1 if u < c.band[0] else -1
    return direction, -direction if c.paradox else _contact_sign(c, u, -c.speed)


@kernel
def _resumed(c, u, sign):
    """After a seizure of the given sign: slip against it under law −1 if Q admits it and the torque drives it."""
    driven = c.push - u
    if _contact_sign(c, u, -c.speed) == sign and _sign(driven) == -sign:
        return -sign, sign
    return _by_band(c, u)


@allocating_kernel
def run(c, u, w, t_end, times, kinds):
    """Follow the motion from (u [rad], w [rad/s]) to t_end [s]; events are written to ``times`` and ``kinds``.

    Returns (complete, number of events, u, w); not complete if there was no room for all events. One loop over the
    steps: what a step hands to the next are nine numbers.
    """
    place, rate, guard = np.zeros(ORDER + 1), np.zeros(ORDER + 1), np.zeros(ORDER + 1)
    t, count = 0.0, 0
    direction, contact = _sign(w + c.speed), _contact_sign(c, u, w)
    kind = -1
    if direction == 0:
        direction, contact = _by_band(c, u)
    elif c.paradox and contact == direction:
        direction, contact = _resumed(c, u, direction)
        kind, w = SEIZURE, -c.speed
    fresh_speed, fresh_contact = w == -c.speed, contact == 0
    if contact == 0 and direction != 0:
        rates = c.rates[1]  # Q′ at Q = 0 is the same under both laws
        contact = _sign(c.contact[0] * w + c.contact[1] * (rates[2] - rates[1] * w - rates[0] * u))
    while True:
        if kind >= 0:
            times[count], kinds[count] = t, kind
            count += 1
            if count == times.size:
                return False, count, u, w
        if direction == 0:
            stay = max((u - c.released) / c.speed, 0.0)
            if t + stay > t_end:
                return True, count, u - c.speed * (t_end - t), w
            t, u = t + stay, c.released
            direction = _sign(c.speed)
            contact = -direction if c.paradox or c.force_sign == 0 else c.force_sign
            kind, fresh_speed, fresh_contact = RELEASE, True, False
            continue
        rates = c.rates[0] if direction * contact > 0 else c.rates[1]
        h = min(PART / (abs(rates[1]) + math.sqrt(abs(rates[0]))), t_end - t)
        _series(rates, u, w, h, place, rate)
        for n in range(ORDER + 1):
            guard[n] = direction * rate[n]
        guard[0] += direction * c.speed
        stop = _fall(guard, fresh_speed)
        for n in range(ORDER + 1):
            guard[n] = contact * (c.contact[0] * place[n] + c.contact[1] * rate[n])
        guard[0] += contact * c.contact[2]
        turn = _fall(guard, fresh_contact)
        part = min(stop, turn)
        fresh_speed = fresh_contact = False
        u, w = _at(place, min(part, 1.0))[0], _at(rate, min(part, 1.0))[0]
        t += min(part, 1.0) * h
        kind = -1
        if part > 1.0:
            if t >= t_end:
                return True, count, u, w
        elif turn < stop and not c.paradox:
            contact, kind, fresh_contact = -contact, CONTACT_REVERSAL, True
        else:
            if turn < stop:
                kind, (direction, contact) = SEIZURE, _resumed(c, u, direction)
            elif c.paradox:
                direction, contact = _resumed(c, u, contact)
            else:
                direction, contact = _by_band(c, u)
            if kind < 0:
                kind = STICK if direction == 0 else REVERSAL
            w, fresh_speed, fresh_contact = -c.speed, True, False
