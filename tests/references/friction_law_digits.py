"""High-precision reference for the rigid drive under a friction law mu(v).

A yardstick, not an engine: every line aims to be checkable by eye. It imports nothing of the library. Numbers are
flint's, 33 digits with their balls cut off: parameters are taken as the exact doubles given.

Newton's laws, with p = r tan(lambda), t = tan(lambda), z = theta - Omega t and the speed of the screw V = theta_dot,
are those of :mod:`references.rigid_digits`, with a coefficient mu = mu(|V| r / cos(lambda)) that is not a number but

    mu(v) = max(0, mu_0 + rise exp(-(v / v_s)^n) + slope v).

Multiplied by D_s = 1 + s mu t, so that mu stands nowhere else, s = sgn(V) sgn(N):

    G_s = D_s Gamma_s = I D_s - (s mu - t) r p m
    G_s V' = D_s T - r (s mu - t) P,      T = -k z - c V,      P = R - c_x p V,      z' = V - Omega
    Q = I P - m p T                        (N = 0 where Q = 0, whatever mu is)

Law of motion
  rest   V = 0 while T lies in the band between r R xi_-(mu_static) and r R xi_+(mu_static).
  G_+ > 0 at the speed: sgn N = sgn Q; the law changes where Q = 0.
  G_+ <= 0 at the speed: only law -1, sgn N = -sgn V, is followed; on Q = 0 the screw seizes.
  Law +1 that comes to a speed where G_+ = 0 seizes as well. A seizure is V -> 0 at the same z with an impulse of the
  sign nu of V; slip under law -1 with N of sign nu follows if Q(z, 0) has that sign and the screw accelerates, else
  the band decides.
  V = 0: rest within the band, else slip towards the excess of T, with N of the sign of Q, or, where G_+ <= 0 at rest,
  of the sign against the slip.

In a mode the motion is a power series of the time, made by recurrence; a step is about a sixth of its radius. Guards
are looked at on it in doubles at many places, and their roots found with all digits.
"""

from dataclasses import dataclass, field
from operator import mul

import numpy as np
from flint import arb, ctx

PRECISION = 110  # bits
TERMS = 28
TAIL = 1e-23  # last term of a series over its largest
NOTHING = 60.0  # minus the logarithm of a rise that is below all digits
ZERO = arb(0)
PLACES = np.linspace(0.0, 1.0, 41)[:, None] ** np.arange(TERMS + 1)


def near(x):
    return arb(x).mid()


def sgn(x):
    return int(x > 0) - int(x < 0)


def dot(a, b, first, k):
    return sum(map(mul, a[first : k + 1], b[k - first :: -1]), ZERO) if k >= first else ZERO


def series_of(drive, direction, s, z0, V0):
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


REST = (0, 0)


@dataclass
class LawEvent:
    time: arb
    kind: str  # contact_reversal, stick, reversal, release, seizure, passage
    before: tuple
    after: tuple  # (u, w)


@dataclass
class LawTruth:
    """A motion with its events; ``end`` says why it ends.

    time, events: as asked. beyond: N would change its sign, or law +1 comes to, a speed at which growing friction has
    G_+ <= 0. corner: law +1 comes to G_+ = 0 and Q = 0 at once, with a finite acceleration (both go to zero along the
    slow direction of a node). What follows these two is not determined.
    """

    drive: object = field(repr=False)
    events: list
    time: arb
    z: arb
    speed: arb
    mode: tuple
    end: str

    @property
    def state(self):
        return self.drive.deviation(self.z, self.speed)


class LawDrive:
    """Constants of a drive, its law, and the speeds of the screw at which the law divides its modes."""

    def __init__(self, q):
        q = {name: arb(value) if isinstance(value, float | int) else value for name, value in q.items()}
        self.r, self.I, self.m = q["pitch_radius"], q["screw_inertia"], q["mass"]
        self.k, self.c, self.cx = q["coupling_stiffness"], q["support_damping"], q["translation_damping"]
        self.Omega, self.R = q["input_speed"], q["axial_force"]
        self.t = near(q["lead_angle"].tan())
        self.p = near(self.r * self.t)
        self.mu_0, self.rise = q["friction_coefficient"], q.get("stribeck_rise", arb(0))
        self.slope, self.power = q.get("friction_slope", arb(0)), int(q.get("stribeck_exponent", arb(1)).unique_fmpz())
        self.v_s = q.get("stribeck_speed", arb(0)) if self.rise > 0 else arb(1)
        self.lever = near(self.r / q["lead_angle"].cos())  # v = lever |V|
        static = q.get("static_friction_coefficient", arb(0))
        self.mu_static = static if static > 0 else self.mu(arb(0))
        edges = [near(self.r * self.R * self.xi(s, self.mu_static)) for s in (-1, 1)]
        self.band = (edges[0], edges[1]) if edges[0] < edges[1] else (edges[1], edges[0])
        steady_mu = self.mu(abs(self.Omega))
        self.s0 = sgn((self.R - self.p * self.cx * self.Omega) * self.Omega) or 1
        xi = self.xi(self.s0, steady_mu)
        self.z0 = near(-((self.c - xi * self.r * self.p * self.cx) * self.Omega + self.r * xi * self.R) / self.k)
        heavy = self.r * self.p * self.m - self.I * self.t
        limit = near((self.I + self.t * self.r * self.p * self.m) / heavy) if heavy > 0 else None
        self.jams = self.crossings(limit) if limit is not None else []
        # Speed beyond which the rise is nothing.
        self.fast = float(self.v_s / self.lever) * (NOTHING if self.power == 1 else NOTHING**0.5)
        self.upper = self.jams[-1] if self.jams and self.slope > 0 else None
        self.zeros = self.crossings(arb(0))

    def raw_mu(self, V):
        v = self.lever * abs(V)
        ratio = v / self.v_s
        return near(self.mu_0 + self.rise * (-(ratio if self.power == 1 else ratio * ratio)).exp() + self.slope * v)

    def mu(self, V):
        found = self.raw_mu(V)
        return found if found > 0 else arb(0)

    def crossings(self, level):
        """Speeds |V| > 0 at which the law crosses a level."""
        grid = np.concatenate([[0.0], np.geomspace(1e-6, 1e6, 4001)]) * float(abs(self.Omega))
        v = grid * float(self.lever) / float(self.v_s)
        values = float(self.mu_0) + float(self.rise) * np.exp(-(v**self.power))
        values += float(self.slope) * grid * float(self.lever) - float(level)
        found = []
        for j in np.flatnonzero((values[1:] > 0) != (values[:-1] > 0)):
            low, high = arb(grid[j]), arb(grid[j + 1])
            falls = bool(self.raw_mu(low) > level)
            for _ in range(PRECISION):
                middle = near((low + high) / 2)
                low, high = (middle, high) if bool(self.raw_mu(middle) > level) == falls else (low, middle)
            found.append(high)
        return found

    def xi(self, s, mu):
        return (s * mu - self.t) / (1 + s * mu * self.t)

    def G(self, s, V):
        mu = self.mu(V)
        return self.I * (1 + s * mu * self.t) - (s * mu - self.t) * self.r * self.p * self.m

    def Q_terms(self, z, V):
        return self.I * self.R, self.m * self.p * self.k * z, (self.m * self.p * self.c - self.I * self.cx * self.p) * V

    def Q(self, z, V):
        """Q, zero where it is rounding."""
        terms = self.Q_terms(z, V)
        total, size = near(sum(terms)), sum(abs(float(x)) for x in terms)
        return total if abs(total) > 1e-24 * size else arb(0)

    def acceleration(self, s, z, V):
        mu, T, P = self.mu(V), -self.k * z - self.c * V, self.R - self.cx * self.p * V
        return near(((1 + s * mu * self.t) * T - self.r * (s * mu - self.t) * P) / self.G(s, V))

    def deviation(self, z, V):
        return near(z - self.z0), near(V - self.Omega)

    def is_beyond(self, V):
        """Whether friction, which grows with speed, has come to G_+ <= 0 from above: what follows is not determined."""
        return self.upper is not None and bool(abs(V) > self.upper)

    # --- which mode follows
    def by_band(self, z):
        T = -self.k * z
        if self.band[0] <= T <= self.band[1]:
            return REST
        return self.from_rest(1 if T > self.band[1] else -1, z)

    def from_rest(self, direction, z):
        return direction, sgn(self.Q(z, arb(0))) if self.G(1, arb(0)) > 0 else -direction

    def after_seizure(self, z, nu):
        if sgn(self.Q(z, arb(0))) == nu and sgn(self.acceleration(-1, z, arb(0))) == -nu:
            return -nu, nu
        return self.by_band(z)

    def entry(self, z, V):
        return sgn(V), sgn(self.Q(z, V))


def guards_of(drive, mode, V, series):
    """The guards of a slip mode: (name, polynomial that is positive in the mode)."""
    direction, contact = mode
    s = direction * contact
    rows_z, rows_V = series
    constant, by_z, by_V = drive.I * drive.R, drive.m * drive.p * drive.k, drive.Q_terms(arb(0), arb(1))[2]

    def affine(weight, of_z, of_V, value):
        return [
            near(weight * (of_z * a + of_V * b + (value if k == 0 else 0)))
            for k, (a, b) in enumerate(zip(rows_z, rows_V, strict=True))
        ]

    yield "stop", affine(direction, 0, 1, 0)
    yield "contact", affine(contact, by_z, by_V, constant)
    for edge in drive.jams:
        if s < 0:
            if edge is not drive.upper:
                yield ("band", edge), affine(1 if V * direction > edge else -1, 0, direction, -edge)
        else:
            above = bool(V * direction > edge)
            close = edge * (1 + arb(1e-5)) if above else edge * (1 - arb(1e-5))
            yield ("jam" if above else "beyond", edge), affine(1 if above else -1, 0, direction, -close)
    for edge in drive.zeros:
        yield ("zero", edge), affine(1 if V * direction > edge else -1, 0, direction, -edge)
    if s == drive.s0 and direction == sgn(drive.Omega):
        yield ("passage", direction * drive.Omega), affine(1 if V > drive.Omega else -1, 0, 1, -drive.Omega)


def upper_of(drive, z, V):
    """F = G_+ V' under law +1, which stays finite where G_+ = 0."""
    return near(drive.acceleration(1, z, V) * drive.G(1, V))


def comes_to_the_corner(drive, direction, z, V, edge):
    """Whether a motion of law +1 close to G_+ = 0 comes to F = 0 there, so that its acceleration is finite.

    In the time s with dt = G_+ ds, x = V - V_edge and F obey x' = F, F' = F_V F + F_z (V - Omega) G_V x. Where both
    rates of that are negative, motions slower than the faster one, F = rate x, end in x = F = 0.
    """
    on, step = near(direction * edge), near(edge * arb(2) ** -40)
    F_V = (upper_of(drive, z, on + 3 * step) - upper_of(drive, z, on + step)) / (2 * step)
    F_z = (upper_of(drive, z + step, on + step) - upper_of(drive, z, on + step)) / step
    G_V = (drive.G(1, on + step) - drive.G(1, on - step)) / (2 * step)
    product = -F_z * (on - drive.Omega) * G_V
    square = F_V * F_V / 4 - product
    if not (F_V < 0 and product > 0 and square > 0):
        return False
    faster = F_V / 2 - square.sqrt()
    return bool(abs(upper_of(drive, z, V)) < abs(faster * (V - on)))


def to_the_jam(drive, direction, z, V, edge):
    """Time and z at which law +1 comes to G_+ = 0, from close by: Runge and Kutta's steps with V as the variable.

    The acceleration may be large only in the end, so the steps halve what is left.
    """

    def rates(V, z):
        lower = drive.G(1, V) / upper_of(drive, z, V)
        return lower, (V - drive.Omega) * lower

    time = arb(0)
    for _ in range(20):
        h = (direction * edge - V) / 16
        for _ in range(8):
            a = rates(V, z)
            b = rates(V + h / 2, z + h / 2 * a[1])
            c = rates(V + h / 2, z + h / 2 * b[1])
            d = rates(V + h, z + h * c[1])
            time = near(time + h / 6 * (a[0] + 2 * b[0] + 2 * c[0] + d[0]))
            z = near(z + h / 6 * (a[1] + 2 * b[1] + 2 * c[1] + d[1]))
            V = near(V + h)
    return time, z


def simulate(parameters, u, w, t_end, max_events=10_000):
    """Follow the motion from (u, w) [rad, rad/s] for t_end [s]; see the module docstring for the law."""
    precision = ctx.prec
    ctx.prec = PRECISION
    try:
        drive = LawDrive(parameters)
        return _simulate(drive, near(arb(u) + drive.z0), near(arb(w) + drive.Omega), arb(t_end), max_events)
    finally:
        ctx.prec = precision


def _simulate(drive, z, V, t_end, max_events):
    t, events = arb(0), []
    mode = drive.by_band(z) if V == 0 else drive.entry(z, V)
    touching = {"stop"} if V == 0 else set()

    def record(kind, before, after):
        events.append(LawEvent(t, kind, drive.deviation(*before), drive.deviation(*after)))

    def seized():
        record("seizure", (z, V), (z, arb(0)))
        return drive.after_seizure(z, direction), arb(0), {"stop"}

    def ended(why):
        return LawTruth(drive, events, t, z, V, mode, why)

    while len(events) < max_events:
        if mode == REST:
            torque = drive.band[1] if drive.Omega > 0 else drive.band[0]
            stay = near((-torque / drive.k - z) / -drive.Omega)
            if t + stay > t_end:
                z, t = near(z - drive.Omega * (t_end - t)), t_end
                return ended("time")
            t, z = near(t + stay), near(-torque / drive.k)
            mode, touching = drive.from_rest(sgn(drive.Omega), z), {"stop"}
            record("release", (z, V), (z, V))
            continue
        direction, contact = mode
        if direction == contact and not touching and drive.G(1, V) <= 0:  # law +1 where it has no motion
            if drive.is_beyond(V):
                return ended("beyond")
            mode, V, touching = seized()
            continue
        series = series_of(drive, direction, direction * contact, z, V)
        step = min(step_of(drive, direction, *series), float(t_end - t))
        tau, name = None, None
        for guard, form in guards_of(drive, mode, V, series):
            found = first_fall(form, step, guard in touching)
            if found is not None and (tau is None or found < tau):
                tau, name = found, guard
        if tau is None:
            z, V, t = value_at(series[0], arb(step)), value_at(series[1], arb(step)), near(t + arb(step))
            touching = set()
            if not t_end - t > 1e-24:
                return ended("time")
            continue
        z, V, t = value_at(series[0], tau), value_at(series[1], tau), near(t + tau)
        touching = {name}
        kind = name if isinstance(name, str) else name[0]
        if kind in ("passage", "zero", "band"):
            V_on = direction * name[1]
            side = sgn(drive.acceleration(direction * contact, z, V))
            V = near(V_on + side * arb(2) ** -95 * abs(V_on))  # off the edge: the next guards go by the speed
            touching = set()
            if kind != "zero":
                record("passage", (z, V), (z, V))
        elif kind == "beyond" or (kind == "contact" and drive.is_beyond(V)):
            return ended("beyond")
        elif kind == "contact" and drive.G(1, V) > 0:
            mode = direction, -contact
            record("contact_reversal", (z, V), (z, V))
        elif kind == "contact":
            mode, V, touching = seized()
        elif kind == "jam":
            if comes_to_the_corner(drive, direction, z, V, name[1]):
                return ended("corner")
            sooner, there = to_the_jam(drive, direction, z, V, name[1])
            t, z, V = near(t + sooner), there, near(direction * name[1])
            mode, V, touching = seized()
        else:
            mode = drive.by_band(z)
            record("stick" if mode == REST else "reversal", (z, V), (z, arb(0)))
            V, touching = arb(0), {"stop"}
    return ended("events")
