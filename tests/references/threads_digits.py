"""High-precision reference for the drive with compliant threads (two degrees of freedom).

A yardstick, not an engine: every line aims to be checkable by eye.  All numbers are mpmath floats; inputs are taken as
the exact doubles given.  It imports nothing of the library but other references.

With e = x - r tan(lambda) theta the contact is compressed by e cos(lambda).  s = sgn(theta' N), z = theta - Omega t:

    N = cos (k_c e + c_c e'),     I theta'' = -k z - c theta' - r N (s mu cos - sin)                             (8.6)
                                  m x''     = R - c_x x' - N (cos + s mu sin)

Rest: theta' = 0 while the friction F that the torque asks for, 0 = -k z - r F cos + r N sin, stays within mu |N|;
then m x'' = R - c_x x' - N cos - F sin.  State (u, w, e, v): u = z - z0 with z0 of the rigid drive's steady sliding
(8.14), w = theta' - Omega, v = e'.

Flow: in slip x' = A x + b, solved with the eigenvectors of A; at rest u = u0 - Omega t, and (e, v) obeys a scalar
second-order equation with a force that is linear in time.  So every coordinate is c0 + c1 t + sum_j Re(c_j exp(l_j t)).
The search for its events is that of :mod:`references.exponential_sums`.
"""

from dataclasses import dataclass, field
from functools import cached_property

from mpmath import mp, mpf

from references.exponential_sums import CLOSE, Function, ThreadsTrueArc, affine, first_root

SPARE_DIGITS = 30  # extra working digits beyond the dps asked for


@dataclass
class ThreadsTrueEvent:
    """An event: its time, its kind, the state and the mode that follows."""

    time: mpf
    kind: str  # contact_reversal, stick, reversal, release
    state: tuple
    mode_after: str


@dataclass
class ThreadsTruth:
    """A motion with all of its digits: its end, its events and its arcs."""

    time: mpf
    state: tuple
    mode: str
    events: list
    arcs: list = field(repr=False)  # (start time, mode, Arc, duration)
    drive: object = field(repr=False)
    complete: bool = True  # False: stopped at max_events


class ThreadsTrueDrive:
    """Constants of the drive, its field in every mode and its guards as rows over (u, w, e, v, 1)."""

    def __init__(self, parameters):
        q = {name: mpf(value) for name, value in parameters.items()}
        self.r, self.I = q["pitch_radius"], q["screw_inertia"]
        self.k, self.c = q["coupling_stiffness"], q["support_damping"]
        self.mu, self.Omega, self.m = q["friction_coefficient"], q["input_speed"], q["mass"]
        self.cx, self.R = q["translation_damping"], q["axial_force"]
        self.kc, self.cc = q["contact_stiffness"], q["contact_damping"]
        self.sin, self.cos, self.tan = mp.sin(q["lead_angle"]), mp.cos(q["lead_angle"]), mp.tan(q["lead_angle"])
        net = self.R - self.r * self.tan * self.cx * self.Omega
        mu0 = self.mu * (1 if net * self.Omega >= 0 else -1)
        xi0 = (mu0 - self.tan) / (1 + mu0 * self.tan)
        C0 = self.c - xi0 * self.r**2 * self.tan * self.cx
        self.z0 = -(C0 * self.Omega + self.r * xi0 * self.R) / self.k  # (8.14)

    @cached_property
    def fields(self):
        """Spectrum of slip under each law."""
        return {law: self._spectrum(law) for law in (1, -1)}

    def N(self, x):
        """Normal force of the threads."""
        return self.cos * (self.kc * x[2] + self.cc * x[3])

    def friction(self, x):  # that holds the screw at rest
        return (-self.k * (self.z0 + x[0]) / self.r + self.N(x) * self.sin) / self.cos

    def slip(self, law, x):  # (8.6)
        """Return the rate of the state x = (u, w, e, v) in slip under a law, (8.6) with damping."""
        u, w, _, v = x
        speed, N = w + self.Omega, self.N(x)
        torque = -self.k * (self.z0 + u) - self.c * speed
        acceleration = (torque - self.r * N * (law * self.mu * self.cos - self.sin)) / self.I
        nut_speed = v + self.r * self.tan * speed
        nut = (self.R - self.cx * nut_speed - N * (self.cos + law * self.mu * self.sin)) / self.m
        return w, acceleration, v, nut - self.r * self.tan * acceleration

    def rest(self, x):
        """The rate of the state at rest, where the motor turns on."""
        nut = (self.R - self.cx * x[3] - self.N(x) * self.cos - self.friction(x) * self.sin) / self.m
        return -self.Omega, mpf(0), x[3], nut

    @staticmethod
    def matrix(field):
        """A and b of a field A x + b."""
        rows = affine(field)
        return mp.matrix([row[:4] for row in rows]), mp.matrix([row[4] for row in rows])

    def _spectrum(self, law):
        A, b = self.matrix(lambda x: self.slip(law, x))
        rates, vectors = mp.eig(A)
        return rates, vectors, mp.lu_solve(A, -b)

    def guards(self, mode):
        """Pairs (row, side): side*function is positive inside the mode; N or limit of friction first, then speed."""
        direction, contact = mode
        N, F = affine(lambda x: (self.N(x), self.friction(x)))
        if direction:
            return [(N, contact), ([mpf(0), mpf(1), mpf(0), mpf(0), self.Omega], direction)]
        return [([contact * self.mu * n - side * f for n, f in zip(N, F, strict=True)], 1) for side in (1, -1)]

    def arc(self, mode, x):
        return self.slip_arc(mode[0] * mode[1], x) if mode[0] else self.rest_arc(x)

    def slip_arc(self, law, x):
        """Return the closed form of slip under a law from the state x on, in eigenvectors."""
        rates, vectors, steady = self.fields[law]
        weights = mp.lu_solve(vectors, mp.matrix(x) - steady)
        kept, columns = [], []
        for j, rate in enumerate(rates):
            real = abs(mp.im(rate)) < mpf(10) ** -(mp.dps // 2) * abs(rate)
            close = abs(mp.im(rate)) < CLOSE / 2 * abs(rate)  # conjugates that are one cluster are both kept
            if real or close or mp.im(rate) > 0:  # else a pair is twice the real part of one of the two
                column = [(1 if real or close else 2) * weights[j] * vectors[i, j] for i in range(4)]
                kept.append(mp.re(rate) if real else rate)
                columns.append([mp.re(c) for c in column] if real else column)
        return ThreadsTrueArc(kept, columns, list(steady), [mpf(0)] * 4)

    def rest_arc(self, x):
        """Return the closed form of rest from the state x on."""
        u, w, e, v = x
        A, b = self.matrix(self.rest)
        # v' = a3 + p u + q e + d v and u = u0 - Omega t: e = alpha + beta t + free oscillation
        p, _, q, d = (A[3, j] for j in range(4))
        beta = p * self.Omega / q
        alpha = -(d * beta + p * u + b[3]) / q
        root = mp.sqrt(d * d / 4 + q)
        rates = [d / 2 + root, d / 2 - root]
        first = (v - beta - rates[1] * (e - alpha)) / (rates[0] - rates[1])
        parts = [first, e - alpha - first]
        if mp.im(root) != 0:
            rates, parts = rates[:1], [2 * parts[0]]
        columns = [[mpf(0), mpf(0), c, rate * c] for c, rate in zip(parts, rates, strict=True)]
        c0, c1 = [u, w, alpha, beta], [w, mpf(0), beta, mpf(0)]
        return ThreadsTrueArc(rates, columns, c0, c1)

    def mode_at(self, x):
        """Mode at a state; N = 0 is judged by its first non-zero derivative, which is the same under every law."""
        speed, N = x[1] + self.Omega, self.N(x)
        A, b = self.matrix((lambda y: self.slip(1, y)) if speed else self.rest)
        rate = A * mp.matrix(x) + b
        while N == 0:
            N, rate = self.N(rate), A * rate
        contact = int(mp.sign(N))
        if speed:
            return int(mp.sign(speed)), contact
        F = self.friction(x)
        return (0 if abs(F) <= self.mu * abs(N) else int(mp.sign(F))), contact


def name(mode):
    direction, contact = mode
    sign = "positive" if contact > 0 else "negative"
    return f"rest_{sign}" if direction == 0 else f"slip_{'forward' if direction > 0 else 'backward'}_{sign}"


def simulate(parameters, state, t_end, *, dps=40, max_events=10000):
    """Follow the motion from ``state`` (u, w, e, v) at t = 0 to t_end."""
    with mp.workdps(dps + SPARE_DIGITS):
        drive = ThreadsTrueDrive(parameters)
        x, t, t_end = tuple(mpf(value) for value in state), mpf(0), mpf(t_end)
        events, arcs = [], []
        mode = drive.mode_at(x)
        while len(events) < max_events:
            arc, left = drive.arc(mode, x), t_end - t
            rows, sides = zip(*drive.guards(mode), strict=True)
            stay, fired = first_root([Function(arc, row) for row in rows], sides, left)
            arcs.append((t, name(mode), arc, stay))
            x = arc.state(stay)
            t += stay
            if fired is None:
                return ThreadsTruth(t_end, x, name(mode), events, arcs, drive)
            direction, contact = mode
            if direction == 0:
                kind, mode = "release", ((1, -1)[fired], contact)
            elif fired == 0:
                kind, mode = "contact_reversal", (direction, -contact)
            else:
                x = (x[0], -drive.Omega, x[2], x[3])
                mode = drive.mode_at(x)
                kind = "reversal" if mode[0] else "stick"
            events.append(ThreadsTrueEvent(t, kind, x, name(mode)))
        return ThreadsTruth(t, x, name(mode), events, arcs, drive, complete=False)
