"""Motions of rigid threads behind a coupling or a motor, from rest or after a knock: do they become steady?

Newton's laws of screw and load in plain numbers, in steps of Dormand and Prince between events that are closed in on by
halves; nothing is regularised. A motion has settled within an ellipsoid of Lyapunov that reaches no event; it goes on
for ever once it comes back to a state that it has had.
"""

import math

import numpy as np
from numba import njit
from scipy.linalg import solve_continuous_lyapunov

SETTLES, UNDECIDED, GOES_ON = 1, 0, -1
MANY = 10_000  # events after which a motion is not decided
NAMES = ("I", "m", "k", "c", "c_x", "r", "tan", "cos", "R", "F", "F_s", "T", "T_s", "collar", "speed", "mu", "mu_s",
         "rise", "v_s", "exponent", "slope", "J", "K_i", "K_p", "d")  # fmt: skip
(I_, M, K, C, CX, R, TAN, COS, FORCE, F, FS, T, TS, COLLAR, SPEED, MU, MUS, RISE, VS, EXPONENT, SLOPE, J, KI, KP,
 D) = range(len(NAMES))  # fmt: skip
TABLEAU = np.zeros((8, 7))
for _row, _weights in enumerate((
    (1 / 5,), (3 / 40, 9 / 40), (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656), (35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784,
    11 / 84), (71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40),
)):  # fmt: skip
    TABLEAU[_row + 1, : len(_weights)] = _weights  # the last row is of the error


@njit(cache=True)
def friction(p, turning):
    speed = p[R] * abs(turning) / p[COS]
    fading = p[RISE] * math.exp(-((speed / p[VS]) ** p[EXPONENT])) if p[RISE] else 0.0
    return max(p[MU] + p[SLOPE] * speed + fading, 0.0)


@njit(cache=True)
def lever(p, law, mu):
    """Torque that brakes the screw over the axial force of the threads; the collar's is added."""
    return p[R] * (law * mu - p[TAN]) / (1 + law * mu * p[TAN]) + law * p[COLLAR]


@njit(cache=True)
def inertia(p, law, turning):
    return p[I_] - lever(p, law, friction(p, turning)) * p[M] * p[R] * p[TAN]


@njit(cache=True)
def wound(p, z):
    """Torque of the coupling on the screw."""
    return -p[K] * (z[0] - z[2]) - p[D] * (z[1] - z[3])


@njit(cache=True)
def pushed(p, z, way):
    """Torque and force without those of the threads, and what has the sign of the threads' force over the inertia."""
    turning, travel = z[1] + p[SPEED], p[R] * p[TAN]
    torque = wound(p, z) - p[C] * turning - p[T] * way
    force = p[FORCE] - p[CX] * travel * turning - p[F] * way
    return torque, force, p[I_] * force - p[M] * travel * torque


@njit(cache=True)
def rate(p, z, way, side, found):
    """Put the rate of (angle, speed) of screw and motor from the command, in slip one way or at rest (0)."""
    found[0], found[1] = z[1], 0.0
    if way:
        torque, force, _ = pushed(p, z, way)
        law, turning = way * side, z[1] + p[SPEED]
        found[1] = (torque - lever(p, law, friction(p, turning)) * force) / inertia(p, law, turning)
    if p[J]:
        found[2], found[3] = z[3], (-wound(p, z) - p[KI] * z[2] - p[KP] * z[3]) / p[J]


@njit(cache=True)
def step(p, z, h, way, side, work):
    """Put the state after a time, and an estimate of its error, into the last two rows."""
    for row in range(8):
        for j in range(4):
            total = 0.0
            for k in range(min(row, 7)):
                total += TABLEAU[row, k] * work[k, j]
            work[7 if row < 7 else 8, j] = h * total + (z[j] if row < 7 else 0.0)
        if row < 7:
            rate(p, work[7], way, side, work[row])


@njit(cache=True)
def bound(p, way):
    """The torque of the coupling, in a direction, from which on the screw slips that way.

    Threads, guide and bearing let go together, unless the guide relieves the threads so much that slip would not go on.
    """
    most = -math.inf
    for guide, bearing, mu in ((p[FS], p[TS], p[MUS]), (p[F], p[T], friction(p, 0.0))):
        force = p[FORCE] - way * guide
        most = max(most, way * lever(p, way * np.sign(force), mu) * force + bearing)
    return most


@njit(cache=True)
def begun(p, z, way):
    """The side of the threads with which slip begins in a direction; 0 if it cannot."""
    side = -1.0 if pushed(p, z, way)[2] < 0 else 1.0
    return 0.0 if way * side > 0 and inertia(p, 1.0, 0.0) <= 0 else side


@njit(cache=True)
def stopped(p, z):
    """The way in which a screw that stands goes on, and the side of the threads."""
    for way in (1, -1):
        if way * wound(p, z) > bound(p, way) and begun(p, z, way):
            return way, begun(p, z, way)
    return 0, 1.0


@njit(cache=True)
def guards(p, z, way, side, turned):
    """What is positive while a mode lasts: speed, force of the threads, and ``turned`` before the next look at it."""
    if way == 0:
        return bound(p, 1) - wound(p, z), bound(p, -1) + wound(p, z), 1.0
    ahead = -z[1] * np.sign(p[SPEED]) if turned else 1.0
    return way * (z[1] + p[SPEED]), side * pushed(p, z, way)[2], ahead


@njit(cache=True)
def moved(p, z, h, way, side, turned, work):
    """Follow a mode for a time, or to what is not positive then first; return its number, 0 for none, and the time."""
    good, bad, kind = 0.0, h, 0
    for _ in range(60 if min(guards(p, work[7], way, side, turned)) < 0 else 0):
        middle = 0.5 * (good + bad)
        step(p, z, middle, way, side, work)
        broken = min(guards(p, work[7], way, side, turned)) < 0
        good, bad, kind = (good, middle, 1) if broken else (middle, bad, 1)
    if kind:
        step(p, z, bad, way, side, work)
        left = guards(p, work[7], way, side, turned)
        kind = 1 if left[0] < 0 else 2 if left[1] < 0 else 3
    z[:] = work[7]
    return kind, bad


@njit(cache=True)
def after(p, z, kind, way, side):
    """Way and side after an event; side 0 where friction that grows with speed wedges: not determined."""
    if way == 0:  # it is let go
        way = 1 if kind == 1 else -1
        return way, begun(p, z, way)
    if kind == 2 and (way * side > 0 or inertia(p, 1.0, z[1] + p[SPEED]) > 0):
        return way, -side
    if kind == 2 and p[SLOPE] > 0:
        return way, 0.0
    z[1] = -p[SPEED]
    return stopped(p, z)


@njit(cache=True)
def followed(p, z, steady, shape, inside, fastest, neutral, most):
    """Return what becomes of a motion, and period and swing of the return to a state that it has had."""
    sense, first = int(np.sign(p[SPEED])), 0.01 / fastest
    surplus = max(p[MUS] / max(friction(p, 0.0), 1e-9), p[FS] / max(p[F], 1e-9), p[TS] / max(p[T], 1e-9)) > 1 + 1e-6
    known, times, work = np.full((16, 4), np.nan), np.zeros(16), np.zeros((9, 4))
    size = 1e-9 * max(abs(p[SPEED]) / fastest, abs(steady[0]) + abs(steady[2]), abs(z[0] - steady[0]))
    t, h, until, period, low, high, looks, dry, turned = 0.0, first, math.inf, 0.0, z[0], z[0], 0, 0, False
    way, side = int(np.sign(z[1] + p[SPEED])), 0.0
    if way:
        side = begun(p, z, way)
    if side == 0:
        z[1] = -p[SPEED]
        way, side = stopped(p, z)
    for count in range(most):
        if way == 0 and p[J] == 0:
            angle = -sense * bound(p, sense) / p[K]
            t += max((z[0] - angle) * sense / abs(p[SPEED]), 0.0)
            z[0], kind = angle, 1 if sense > 0 else 2
        else:
            step(p, z, h, way, side, work)
            error = max(abs(work[8, 0]), abs(work[8, 2]), abs(work[8, 1]) / fastest, abs(work[8, 3]) / fastest) / size
            if error > 1:
                h *= max(0.2, 0.9 * error**-0.2)
                continue
            kind, taken = moved(p, z, h, way, side, turned, work)
            t += taken
            h = min(h * min(3.0, 0.9 * max(error, 1e-10) ** -0.2), 0.1 / fastest if way else 2.0 / fastest)
        low, high, turned = min(low, z[0]), max(high, z[0]), turned or (way != 0 and z[1] * sense < 0)
        if t >= until or abs(z[1]) > 1e8 * abs(p[SPEED]):
            return -1, period, high - low
        look = kind == 3 or (kind and way == 0 and sense == (1 if kind == 1 else -1))
        if kind == 1 or kind == 2:
            way, side = after(p, z, kind, way, side)
            dry, h = dry + 1, first
        turned = turned and (kind == 0 or (kind == 2 and way != 0))
        away = z - steady
        energy = away @ shape @ away if look or count % 32 == 0 else math.inf
        if side == 0 or dry > MANY or (way == sense and not neutral and energy < inside):
            return 0 if side == 0 or dry > MANY else 1, 0.0, 0.0
        if not look or until < math.inf:
            continue
        looks += 1
        if neutral and ((dry == 0 and looks > 3) or (not surplus and looks > 50)):
            break
        for before in range(8 if kind == 3 else 0, 16 if kind == 3 else 8):
            gap = away - known[before]
            if gap @ shape @ gap <= 1e-14 * energy and (surplus or not neutral):
                period = t - times[before]
                until, low, high = t + period, z[0], z[0]  # once more, for its size
                break
        row = looks % 8 + (8 if kind == 3 else 0)
        known[row], times[row] = away, t
    return 0, 0.0, 0.0


@njit(cache=True)
def sliding(p):
    """Steady sliding, the force of the threads in it, the inertia, and the matrix of small deviations."""
    way, travel = int(np.sign(p[SPEED])), p[R] * p[TAN]
    force = p[FORCE] - p[CX] * travel * p[SPEED] - p[F] * way
    side = np.sign(force) if force else float(way)
    torque = p[C] * p[SPEED] + p[T] * way + lever(p, way * side, friction(p, p[SPEED])) * force
    steady, size = np.zeros(4), 4 if p[J] else 2
    steady[2] = -torque / p[KI] if p[J] else 0.0
    steady[0] = steady[2] - torque / p[K]
    matrix, found, small = np.zeros((size, size)), np.zeros((2, 4)), 1e-6 * abs(p[SPEED])
    for k in range(size):
        for row in range(2):
            away = steady.copy()
            away[k] += small if row else -small
            rate(p, away, way, side, found[row])
        matrix[:, k] = (found[1] - found[0])[:size] / (2 * small)
    return steady, force, inertia(p, way * side, p[SPEED]), matrix


@njit(cache=True)
def grows(table):
    """The fastest growth of a small nudge of drives, over the size of its rate; infinite where sliding wedges."""
    found = np.zeros(len(table))
    for k, p in enumerate(table):
        _, _, left, matrix = sliding(p)
        rates = np.linalg.eigvals(matrix.astype(np.complex128))
        found[k] = np.inf if left <= 0 else np.max(rates.real / np.abs(rates))
    return found


def ends(p: np.ndarray, knock: float | None = None, most: int = 250_000) -> tuple[int, float, float]:
    """Return how a motion ends whose speed is changed by ``knock`` times the command, or (None) from rest.

    Besides the period [s] and the swing of the load [m] of one that goes on and comes back to a state.
    """
    growth, way = grows(p[None])[0], int(np.sign(p[SPEED]))
    if growth > 1e-8:
        return GOES_ON, 0.0, 0.0
    steady, _, left, matrix = sliding(p)
    size, rates = len(matrix), np.linalg.eigvals(matrix)
    fastest = np.abs(rates).max()
    neutral = not p[[C, KP, D, CX, SLOPE, RISE]].any() or growth > -1e-8
    away = np.array([1.0, 0, -1, 0])
    shape, inside = p[K] * np.outer(away, away) + np.diag([0.0, left, p[KI], p[J]]), 0.0
    if not neutral:
        scale = np.tile([1.0, fastest], 2)[:size]
        own = solve_continuous_lyapunov((matrix / scale[:, None] * scale).T, np.eye(size) * rates.real.max())
        shape[:size, :size], inverse = own / np.outer(scale, scale), np.linalg.inv(own) * np.outer(scale, scale)
        at, rows = pushed(p, steady, way)[2], [(np.eye(4)[1], abs(p[SPEED]))]
        rows.append((np.array([pushed(p, steady + unit, way)[2] - at for unit in np.eye(4)]), abs(at)))
        inside = min(distance**2 / (row[:size] @ inverse @ row[:size]) for row, distance in rows)
        inside *= 1e-4 if p[SLOPE] or p[RISE] else 0.9
    rest = np.array([0.0, -p[SPEED], 0.0, -p[SPEED] if p[J] else 0.0])
    start = rest if knock is None else steady + np.array([0.0, knock * p[SPEED], 0.0, 0.0])
    found, period, swing = followed(p, start, steady, shape, inside, fastest, neutral, most)
    return found, period, swing * p[R] * p[TAN]
