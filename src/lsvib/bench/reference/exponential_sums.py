"""Sums of exponentials in many digits: the closed form of a motion, and a search for roots that misses none.

Search: an interval of half-width d around t is dismissed if Taylor's theorem says |f| > 0 on it,

    |f(t)| > |f'(t)| d + M2 d^2/2,      M_k = sum_j |c_j| |l_j|^k max(exp(Re l_j t)) over the interval >= |f^(k)|;

if it says |f'| > 0 in the same way, the signs at the ends decide on the one root; otherwise it is halved.  Nothing is
sampled, so nothing is missed.  A function that is zero at the start, because an event has just put it there, is
followed by its first non-zero derivative until M of the next order lets that derivative change its sign.
"""

from mpmath import mp, mpf

UNIT = [[mpf(i == j) for j in range(4)] for i in range(4)]  # states, one coordinate 1 and the others 0
CLOSE = mpf(1) / 10  # of a rate: rates so close together have coefficients that cancel, and one bound


def affine(functions):
    """Affine functions of the state as rows; ``functions(x)`` returns their values."""
    constant, *slopes = [functions(x) for x in ([mpf(0)] * 4, *UNIT)]
    return [[*(slope[i] - c for slope in slopes), c] for i, c in enumerate(constant)]


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
        """The derivative in time, a function of the same kind."""
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
                sign = mp.sign(self(left))
                finest = right * mpf(10) ** -(mp.dps - 10)
                yield solve(lambda t: sign * self(t), lambda t: sign * self(t, 1), left, right, finest)
            return
        middle = (left + right) / 2
        if right - left < mpf(10) ** -35 * (1 / self.arc.fastest + left):
            raise ArithmeticError("a guard grazes zero: no digit of this reference can decide")
        yield from self.roots(left, middle)
        yield from self.roots(middle, right)

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

    def __init__(self, rates, columns, c0, c1):
        self.rates, self.columns, self.c0, self.c1 = rates, columns, c0, c1
        self.fastest = max(abs(rate) for rate in rates)
        self.clusters = _clusters(rates)
        self._exponentials, self._magnitudes = {}, {}

    def exponentials(self, t):
        """All e^(rate t), kept for each t."""
        if t not in self._exponentials:
            self._exponentials[t] = [mp.exp(rate * t) for rate in self.rates]
        return self._exponentials[t]

    def magnitudes(self, t):
        """Their sizes."""
        if t not in self._magnitudes:
            self._magnitudes[t] = [mp.exp(mp.re(rate) * t) for rate in self.rates]
        return self._magnitudes[t]

    def state(self, t):
        """The four coordinates of the state."""
        return tuple(Function(self, [*row, mpf(0)])(t) for row in UNIT)


def _clusters(rates):
    """Indices of the rates in groups, of which each member is close to another."""
    groups = []
    for j, rate in enumerate(rates):
        near = [g for g in groups if any(abs(rate - rates[i]) < CLOSE * abs(rate) for i in g)]
        groups = [g for g in groups if g not in near] + [(*(i for g in near for i in g), j)]
    return groups


def solve(f, slope, left, right, tolerance):
    """Root of a monotone f with f(left) > 0 >= f(right): Newton kept inside a shrinking bracket.

    Where Newton's steps do not halve (along a steep exponential they stay the same) the bracket is halved instead.
    """
    tolerance = max(tolerance, right * mpf(10) ** (5 - mp.dps))  # no finer than the working digits
    x, last = (left + right) / 2, right - left
    while right - left > tolerance:
        value, d = f(x), slope(x)
        if value > 0:
            left = x
        else:
            right = x
        step = -value / d if d != 0 else right - left
        if abs(step) < tolerance / 4:  # converged? then a step of tolerance brackets it
            low, high = max(left, x + step - tolerance / 2), min(right, x + step + tolerance / 2)
            if f(low) > 0 >= f(high):
                return x + step
        if not (left < x + step < right and abs(step) <= last / 2):
            step = (left + right) / 2 - x
        x, last = x + step, abs(step)
    return (left + right) / 2
