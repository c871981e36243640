"""Power series of a motion of the rigid drive in one mode of a friction law, and the roots of polynomials on a step.

Part of :mod:`references.friction_law_digits`, whose equations they are made of, by recurrence.
"""

from operator import mul

import numpy as np
from flint import arb

PRECISION = 110  # bits
TERMS = 28
TAIL = 1e-23  # last term of a series over its largest
NOTHING = 60.0  # minus the logarithm of a rise that is below all digits
ZERO = arb(0)
PLACES = np.linspace(0.0, 1.0, 41)[:, None] ** np.arange(TERMS + 1)


def near(x):
    """The middle of a ball."""
    return arb(x).mid()


def sgn(x):
    return int(x > 0) - int(x < 0)


def dot(a, b, first, k):
    """Sum of a_i b_{k-i} from i = first on."""
    return sum(map(mul, a[first : k + 1], b[k - first :: -1]), ZERO) if k >= first else ZERO


def series_of(drive, direction, s, z0, V0):
    """Power series of z and V in a mode with law s."""
    d, zero_mu = drive, drive.raw_mu(V0) <= 0
    z, V, mu, decay, power, steep = [z0], [V0], [], [], [], []
    T, P, upper, lower, rate = [], [], [], [], []
    speed = d.lever * direction
    for k in range(TERMS):
        T.append(near(-d.k * z[k] - d.c * V[k]))
        P.append(near((d.R if k == 0 else 0) - d.cx * d.p * V[k]))
        value = (d.mu_0 if k == 0 else arb(0)) + d.slope * speed * V[k]
        if d.rise > 0:
            ratio = speed / d.v_s
            power.append(near(-ratio * V[k] if d.power == 1 else -ratio * ratio * dot(V, V, 0, k)))
            steep.append(k * power[k])
            decay.append(near(power[0].exp() if k == 0 else dot(steep, decay, 1, k) / k))
            value += d.rise * decay[k]
        mu.append(arb(0) if zero_mu else near(value))
        one = 1 if k == 0 else 0
        lower.append(near(d.I * (one + s * mu[k] * d.t) - (s * mu[k] - one * d.t) * d.r * d.p * d.m))
        upper.append(near(T[k] + s * d.t * dot(mu, T, 0, k) - d.r * (s * dot(mu, P, 0, k) - d.t * P[k])))
        rate.append(near((upper[k] - dot(lower, rate, 1, k)) / lower[0]))
        z.append(near((V[k] - (d.Omega if k == 0 else 0)) / (k + 1)))
        V.append(near(rate[k] / (k + 1)))
    return z, V


def step_of(drive, direction, z, V):
    """Step on which the series are good; a rise that is nothing at its start counts at its end at most a little."""
    step = np.inf
    for row in (z, V):
        for n in (TERMS - 1, TERMS):
            if row[n] != 0:
                largest = max(float((abs(row[j]) / abs(row[n])).log() / (n - j)) for j in range(3) if row[j] != 0)
                step = min(step, np.exp(largest + np.log(TAIL) / n))
    if drive.rise > 0 and float(V[0] * direction) > drive.fast:
        row = np.array([float(x * direction * arb(step) ** k) for k, x in enumerate(V)])
        counts = PLACES @ row < 0.98 * drive.fast
        if counts.any():
            step *= np.argmax(counts) / 40 - 1 / 41
    return step


def value_at(row, tau):
    total = arb(0)
    for x in reversed(row):
        total = total * tau + x
    return near(total)


def first_fall(form, step, touching):
    """First time in (0, step] at which a polynomial, positive at first, comes to zero; None without one."""
    form = list(form)
    shift = 0
    while touching and shift < 4:  # divided by the time while it starts on the surface
        del form[0]
        shift += 1
        if abs(form[0]) * arb(step) > arb(2) ** (30 - PRECISION) * max(
            float(abs(x) * arb(step) ** (k + 1)) for k, x in enumerate(form[:4])
        ):
            break
    row = np.zeros(TERMS + 1)
    row[: len(form)] = [float(x * arb(step) ** k) for k, x in enumerate(form)]
    values = PLACES @ row
    bracket = None
    for j in range(len(values) - 1):
        if values[j + 1] <= 0:
            bracket = j / 40, (j + 1) / 40
            break
        if 0 < j and values[j] < values[j - 1] and values[j] <= values[j + 1]:  # a near miss is looked at closely
            fine = np.linspace((j - 1) / 40, (j + 1) / 40, 401)
            close = np.polyval(row[::-1], fine)
            if (close <= 0).any():
                below = int(np.argmax(close <= 0))
                bracket = fine[below - 1], fine[below]
                break
    if bracket is None:
        return None
    low, high = bracket
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if np.polyval(row[::-1], middle) > 0 else (low, middle)
    tau, slopes = arb(high) * arb(step), [k * x for k, x in enumerate(form)][1:]
    for _ in range(7):
        tau = near(tau - value_at(form, tau) / value_at(slopes, tau))
    return tau
