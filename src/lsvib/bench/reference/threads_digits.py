"""High-precision reference for the drive with compliant threads (two degrees of freedom).

A yardstick, not an engine: every line aims to be checkable by eye.  All numbers are mpmath floats; inputs are taken as
the exact doubles given.  It imports nothing else of the library.

With e = x - r tan(lambda) theta the contact is compressed by e cos(lambda).  s = sgn(theta' N), z = theta - Omega t:

    N = cos (k_c e + c_c e'),     I theta'' = -k z - c theta' - r N (s mu cos - sin)                             (8.6)
                                  m x''     = R - c_x x' - N (cos + s mu sin)

Rest: theta' = 0 while the friction F that the torque asks for, 0 = -k z - r F cos + r N sin, stays within mu |N|;
then m x'' = R - c_x x' - N cos - F sin.  State (u, w, e, v): u = z - z0 with z0 of the rigid drive's steady sliding
(8.14), w = theta' - Omega, v = e'.

Flow: in slip x' = A x + b, solved with the eigenvectors of A; at rest u = u0 - Omega t, and (e, v) obeys a scalar
second-order equation with a force that is linear in time.  So every coordinate is c0 + c1 t + sum_j Re(c_j exp(l_j t)).
(`ThreadsTrueArc.check` holds it against the matrix exponential of mpmath.)

Search: an interval of half-width d around t is dismissed if Taylor's theorem says |f| > 0 on it,

    |f(t)| > |f'(t)| d + M2 d^2/2,      M_k = sum_j |c_j| |l_j|^k max(exp(Re l_j t)) over the interval >= |f^(k)|;

if it says |f'| > 0 in the same way, the signs at the ends decide on the one root; otherwise it is halved.  Nothing is
sampled, so nothing is missed.  A function that is zero at the start, because an event has just put it there, is
followed by its first non-zero derivative until M of the next order lets that derivative change its sign.
"""

from dataclasses import dataclass, field

from mpmath import mp, mpf

SPARE_DIGITS = 30  # extra working digits beyond the dps asked for
_CLOSE = mpf(1) / 10  # of a rate: rates so close together have coefficients that cancel, and one bound


@dataclass
class ThreadsTrueEvent:
    time: mpf
    kind: str  # contact_reversal, stick, reversal, release
    state: tuple
    mode_after: str


@dataclass
class ThreadsTruth:
    time: mpf
    state: tuple
    mode: str
    events: list
    arcs: list = field(repr=False)  # (start time, mode, Arc, duration)
    drive: object = field(repr=False)
    complete: bool = True  # False: stopped at max_events


class Function:
    """f(t) = c0 + c1 t + sum Re(c_j exp(l_j t)) with its derivatives, and bounds of them."""

    def __init__(self, arc, row):
        *weights, constant = row  # over (u, w, e, v, 1)
        self.arc = arc
        self.c0 = constant + sum(g * x for g, x in zip(weights, arc.c0, strict=True))
        self.c1 = sum(g * x for g, x in zip(weights, arc.c1, strict=True))
        coefficients = [sum(g * x for g, x in zip(weights, column, strict=True)) for column in arc.columns]
        self.powers = [[c * rate**k for c, rate in zip(coefficients, arc.rates, strict=True)] for k in range(7)]
        self.sizes = [[abs(c) for c in power] for power in self.powers]
        self.differences = {}

    def __call__(self, t, k=0):
        smooth = (self.c0 + self.c1 * t, self.c1)[k] if k < 2 else mpf(0)
        return smooth + sum((c * x).real for c, x in zip(self.powers[k], self.arc.exponentials(t), strict=True))

    def derivative(self):
        slope = Function(self.arc, [mpf(0)] * 5)
        slope.c0, slope.powers, slope.sizes = self.c1, self.powers[1:], self.sizes[1:]
        return slope

    def bound(self, k, left, right):
        """Of |f^(k)|, k >= 2, on an interval: each |exp(l t)| is largest at an end.

        Rates close together have large coefficients that cancel. In Newton's form through such rates l_0, l_1, ...

            sum_j b_j exp(l_j t) = sum_m a_m E_m(t),      a_m = sum_j b_j prod_{i<m} (l_j - l_i),

        E_m, the divided difference of exp(l t) over l_0 ... l_m, is at most t^m / m! max |exp(l_j t)|.
        """
        ends = [max(x) for x in zip(self.arc.magnitudes(left), self.arc.magnitudes(right), strict=True)]
        total = mpf(0)
        for cluster in self.arc.clusters:
            most = sum(self.sizes[k][j] * ends[j] for j in cluster)
            if len(cluster) > 1:
                newton = sum(a * right**m / mp.factorial(m) for m, a in enumerate(self.newton(k, cluster)))
                most = min(most, newton * max(ends[j] for j in cluster))
            total += most
        return total

    def newton(self, k, cluster):
        """|a_m| of f^(k) over a cluster of rates."""
        if (k, cluster) not in self.differences:
            terms, found = {j: self.powers[k][j] for j in cluster}, []
            for i in cluster:
                found.append(abs(sum(terms.values())))
                terms = {j: b * (self.arc.rates[j] - self.arc.rates[i]) for j, b in terms.items()}
            self.differences[k, cluster] = found
        return self.differences[k, cluster]

    def keeps_sign(self, k, left, right):
        """True if Taylor's theorem about the middle shows that f^(k) has no zero on the interval."""
        middle, d = (left + right) / 2, (right - left) / 2
        most = abs(self(middle, k + 1)) * d + self.bound(k + 2, left, right) * d**2 / 2
        return abs(self(middle, k)) > most

    def roots(self, left, right):
        """Yield every root in [left, right] in order; both ends must not be roots."""
        if self.keeps_sign(0, left, right):
            return
        if self.keeps_sign(1, left, right):
            if self(left) * self(right) < 0:
                yield self.solve(left, right)
            return
        middle = (left + right) / 2
        if right - left < mpf(10) ** -35 * (1 / self.arc.fastest + left):
            raise ArithmeticError("a guard grazes zero: no digit of this reference can decide")
        yield from self.roots(left, middle)
        yield from self.roots(middle, right)

    def solve(self, left, right):
        """Root of a function that is monotone from left to right: Newton kept inside a shrinking bracket.

        Where Newton's steps do not halve (along a steep exponential they stay the same) the bracket is halved instead.
        """
        sign = 1 if self(left) < 0 else -1
        t, last, finest = (left + right) / 2, right - left, mpf(10) ** -(mp.dps - 10)
        while right - left > finest * right:
            value = sign * self(t)
            left, right = (t, right) if value < 0 else (left, t)
            step = -value / (sign * self(t, 1))
            if abs(step) < finest * right:
                return t + step
            if not (left < t + step < right and abs(step) <= last / 2):
                step = (left + right) / 2 - t
            t, last = t + step, abs(step)
        return t

    def sign_after_zero(self, sizes):
        """(order, sign) of the first derivative that is not zero, for a function that is zero at t = 0."""
        for k in range(1, 4):
            if abs(self(mpf(0), k)) > mpf(10) ** -(mp.dps // 2) * sizes[k]:
                return k, mp.sign(self(mpf(0), k))
        raise ArithmeticError("a guard rests on zero")

    def clear_start(self, side):
        """Time up to which side*f, positive or zero and rising at t = 0, has no root after t = 0."""
        if abs(self(mpf(0))) > mpf(10) ** -(mp.dps // 2 + 5) * (sum(self.sizes[0]) + abs(self.c0)):
            assert side * self(mpf(0)) > 0, "a guard is negative at the start"
            return mpf(0)
        k, sign = self.sign_after_zero([sum(power) + abs(self.c1) for power in self.sizes])
        assert sign == side, "a guard leaves zero on the wrong side"
        t = 1 / self.arc.fastest
        while not abs(self(mpf(0), k)) > self.bound(k + 1, mpf(0), t) * t:
            t /= 2
        return t


def first_root(functions, sides, end):
    """(time, index) of the first root in (0, end] of any of several functions, or (end, None); in growing windows."""
    starts = [f.clear_start(side) for f, side in zip(functions, sides, strict=True)]
    left, right = mpf(0), 1 / functions[0].arc.fastest
    while left < end:
        right = min(right, end)
        roots = [
            next(f.roots(max(left, a), right), None) if a < right else None
            for f, a in zip(functions, starts, strict=True)
        ]
        if any(root is not None for root in roots):
            return min((root, k) for k, root in enumerate(roots) if root is not None)
        left, right = right, 4 * right
    return end, None


class ThreadsTrueArc:
    """Motion in one mode: coordinates c0 + c1 t + sum over columns of Re(column * exp(rate t))."""

    def __init__(self, rates, columns, c0, c1, check):
        self.rates, self.columns, self.c0, self.c1, self.check = rates, columns, c0, c1, check
        self.fastest = max(abs(rate) for rate in rates)
        self.clusters = _clusters(rates)
        self._exponentials, self._magnitudes = {}, {}

    def exponentials(self, t):
        if t not in self._exponentials:
            self._exponentials[t] = [mp.exp(rate * t) for rate in self.rates]
        return self._exponentials[t]

    def magnitudes(self, t):
        if t not in self._magnitudes:
            self._magnitudes[t] = [mp.exp(mp.re(rate) * t) for rate in self.rates]
        return self._magnitudes[t]

    def state(self, t):
        unit = [[mpf(i == j) for j in range(5)] for i in range(4)]
        return tuple(Function(self, row)(t) for row in unit)


def _clusters(rates):
    """Indices of the rates in groups, of which each member is close to another."""
    groups = []
    for j, rate in enumerate(rates):
        near = [g for g in groups if any(abs(rate - rates[i]) < _CLOSE * abs(rate) for i in g)]
        groups = [g for g in groups if g not in near] + [(*(i for g in near for i in g), j)]
    return groups


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
        self.fields = {law: self._spectrum(law) for law in (1, -1)}

    def N(self, x):
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
        nut = (self.R - self.cx * x[3] - self.N(x) * self.cos - self.friction(x) * self.sin) / self.m
        return -self.Omega, mpf(0), x[3], nut

    @staticmethod
    def row(function):
        """An affine function of the state as a row."""
        constant = function((mpf(0),) * 4)
        return [function([mpf(i == j) for j in range(4)]) - constant for i in range(4)] + [constant]

    def matrix(self, field):
        rows = [self.row(lambda x, i=i: field(x)[i]) for i in range(4)]
        return mp.matrix([row[:4] for row in rows]), mp.matrix([row[4] for row in rows])

    def _spectrum(self, law):
        A, b = self.matrix(lambda x: self.slip(law, x))
        rates, vectors = mp.eig(A)
        return A, b, rates, vectors, mp.lu_solve(A, -b)

    def guards(self, mode):
        """Pairs (row, side): side*function is positive inside the mode; N or limit of friction first, then speed."""
        direction, contact = mode
        N = self.row(self.N)
        if direction:
            return [(N, contact), ([mpf(0), mpf(1), mpf(0), mpf(0), self.Omega], direction)]
        F = self.row(self.friction)
        return [([contact * self.mu * n - side * f for n, f in zip(N, F, strict=True)], 1) for side in (1, -1)]

    def arc(self, mode, x):
        return self.slip_arc(mode[0] * mode[1], x) if mode[0] else self.rest_arc(x)

    def slip_arc(self, law, x):
        """Return the closed form of slip under a law from the state x on, in eigenvectors."""
        A, b, rates, vectors, steady = self.fields[law]
        weights = mp.lu_solve(vectors, mp.matrix(x) - steady)
        kept, columns = [], []
        for j, rate in enumerate(rates):
            real = abs(mp.im(rate)) < mpf(10) ** -(mp.dps // 2) * abs(rate)
            close = abs(mp.im(rate)) < _CLOSE / 2 * abs(rate)  # conjugates that are one cluster are both kept
            if real or close or mp.im(rate) > 0:  # else a pair is twice the real part of one of the two
                column = [(1 if real or close else 2) * weights[j] * vectors[i, j] for i in range(4)]
                kept.append(mp.re(rate) if real else rate)
                columns.append([mp.re(c) for c in column] if real else column)
        return ThreadsTrueArc(kept, columns, list(steady), [mpf(0)] * 4, lambda t: _by_matrix_exponential(A, b, x, t))

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
        return ThreadsTrueArc(rates, columns, c0, c1, lambda t: _by_matrix_exponential(A, b, x, t))

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


def _by_matrix_exponential(A, b, x, t):
    extended = mp.zeros(5)
    for i in range(4):
        extended[i, 4] = b[i] * t
        for j in range(4):
            extended[i, j] = A[i, j] * t
    return tuple((mp.expm(extended) * mp.matrix([*x, 1]))[:4])


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
