"""Sums of exponentials in many digits: the closed form of a motion, and a search for roots that misses none.

Search: an interval of half-width d around t is dismissed if Taylor's theorem says |f| > 0 on it,

    |f(t)| > |f'(t)| d + M2 d^2/2,      M_k = sum_j |c_j| |l_j|^k max(exp(Re l_j t)) over the interval >= |f^(k)|;

if it says |f'| > 0 in the same way, the signs at the ends decide on the one root; if it says |f''| > 0, so does the
sign at the extremum; otherwise it is halved.  Nothing is sampled, so nothing is missed.  A function that is zero at the
start, because an event has just put it there, is followed by its first non-zero derivative until M of the next order
lets that derivative change its sign.

A sum that is the rounding of its terms is zero exactly (:func:`summed`): what dies away has all of its digits then, and
what nothing excites does not grow.
"""

from itertools import pairwise

from mpmath import mp, mpf

UNIT = [[mpf(i == j) for j in range(4)] for i in range(4)]  # states, one coordinate 1 and the others 0
_MOST_WORK = 20_000  # intervals that are looked at on an arc: some seconds; 500 are many
CLOSE = mpf(1) / 10  # of a rate: rates so close together have coefficients that cancel, and one bound


def summed(*terms):
    """Sum of some terms; zero where it is less than 20 digits above the rounding of them."""
    total = sum(terms, mpf(0))
    return total if abs(total) > mpf(10) ** (20 - mp.dps) * sum(map(abs, terms)) else mpf(0)


def affine(functions):
    """Affine functions of the state as rows; ``functions(x)`` returns their values."""
    constant, *slopes = [functions(x) for x in ([mpf(0)] * 4, *UNIT)]
    return [[*(summed(slope[i], -c) for slope in slopes), c] for i, c in enumerate(constant)]


class Function:
    """f(t) = c0 + c1 t + sum Re(c_j exp(l_j t)) with its derivatives, and bounds of them.

    ``may_touch`` says that f touches zero without any effect: then that is no root, else nobody can decide.
    ``may_fall`` says that f may begin with less than its rounding, and fall from there at once.
    """

    def __init__(self, arc, row, may_touch=False, may_fall=False):
        *weights, constant = row  # over (u, w, e, v, 1)
        self.arc, self.may_touch, self.may_fall = arc, may_touch, may_fall
        self.c0 = summed(constant, *(g * x for g, x in zip(weights, arc.c0, strict=True)))
        self.c1 = summed(*(g * x for g, x in zip(weights, arc.c1, strict=True)))
        self._fill([summed(*(g * x for g, x in zip(weights, column, strict=True))) for column in arc.columns])

    def _fill(self, coefficients):
        self.powers = [[c * rate**k for c, rate in zip(coefficients, self.arc.rates, strict=True)] for k in range(7)]
        self.sizes = [[abs(c) for c in power] for power in self.powers]
        self.differences = {}

    def __call__(self, t, k=0):
        smooth = (self.c0 + self.c1 * t, self.c1)[k] if k < 2 else mpf(0)
        return smooth + sum((c * x).real for c, x in zip(self.powers[k], self.arc.exponentials(t), strict=True))

    def undying(self):
        """A function with the same roots: this one over its slowest exponential, where nothing else is left of it.

        Else each step would be as short as the time in which it dies away, and its roots are looked for much longer.
        """
        alive = [mp.re(rate) for rate, c in zip(self.arc.rates, self.powers[0], strict=True) if c != 0]
        if self.c0 != 0 or self.c1 != 0 or not alive or max(alive) >= 0:
            return self
        same = Function(self.arc.over(max(alive)), [mpf(0)] * 5, self.may_touch)
        same._fill(self.powers[0])
        return same

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
        self.arc.work += 1
        if self.arc.work > _MOST_WORK:
            raise ArithmeticError("the search for a root takes too long")
        if self.keeps_sign(0, left, right):
            return
        edges = [left, right]
        if not self.keeps_sign(1, left, right):
            if not self.keeps_sign(2, left, right):
                middle = (left + right) / 2
                if right - left < mpf(10) ** -35 * (1 / self.arc.fastest + left):
                    raise ArithmeticError("a guard is zero together with its first two derivatives")
                yield from self.roots(left, middle)
                yield from self.roots(middle, right)
                return
            if self(left, 1) * self(right, 1) < 0:
                extreme = self._root(left, right, 1)
                if self._touches(extreme):
                    return
                edges = [left, extreme, right]
        for low, high in pairwise(edges):
            if self(low) * self(high) < 0:
                yield self._root(low, high, 0)

    def _root(self, left, right, k):
        """Root of f^(k), which is monotone and changes its sign on [left, right]."""
        sign = mp.sign(self(left, k))
        finest = right * mpf(10) ** -(mp.dps - 10)
        return solve(lambda t: sign * self(t, k), lambda t: sign * self(t, k + 1), left, right, finest)

    def _touches(self, extreme):
        """Whether f has no digits left at an extreme between equal signs."""
        size = sum(s * m for s, m in zip(self.sizes[0], self.arc.magnitudes(extreme), strict=True))
        if abs(self(extreme)) > mpf(10) ** (25 - mp.dps) * (size + abs(self.c0) + abs(self.c1) * extreme):
            return False
        if not self.may_touch:
            raise ArithmeticError("a guard grazes zero: no digit of this reference can decide")
        return True

    def sign_after_zero(self, sizes):
        """(order, sign) of the first derivative that is not zero, for a function that is zero at t = 0."""
        for k in range(1, 4):
            if abs(self(mpf(0), k)) > mpf(10) ** -(mp.dps // 2) * sizes[k]:
                return k, mp.sign(self(mpf(0), k))
        raise ArithmeticError("a guard rests on zero")

    def clear_start(self, side):
        """Time up to which side*f, positive or zero and rising at t = 0, has no root after t = 0; None if it falls."""
        if not any((self.c0, self.c1, *self.sizes[0])):
            return mp.inf  # it rests on zero
        if abs(self(mpf(0))) > mpf(10) ** -(mp.dps // 2) * (sum(self.sizes[0]) + abs(self.c0)):
            assert side * self(mpf(0)) > 0, "a guard is negative at the start"
            return mpf(0)
        k, sign = self.sign_after_zero([sum(power) + abs(self.c1) for power in self.sizes])
        if sign != side and self.may_fall:
            return None
        assert sign == side, "a guard leaves zero on the wrong side"
        t = 1 / self.arc.fastest
        while not abs(self(mpf(0), k)) > self.bound(k + 1, mpf(0), t) * t:
            t /= 2
        return t


def first_root(functions, sides, end):
    """(time, index) of the first root in (0, end] of any of several functions, or (end, None); in growing windows."""
    starts = [f.clear_start(side) for f, side in zip(functions, sides, strict=True)]
    if None in starts:
        return mpf(0), starts.index(None)
    left, right, functions = mpf(0), 1 / functions[0].arc.fastest, [f.undying() for f in functions]
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


class TrueArc:
    """Motion in one mode: coordinates c0 + c1 t + sum over columns of Re(column * exp(rate t))."""

    def __init__(self, rates, columns, c0, c1):
        self.rates, self.columns, self.c0, self.c1 = rates, columns, c0, c1
        self.fastest = max(abs(rate) for rate in rates)
        self.clusters = _clusters(rates)
        self._exponentials, self._magnitudes, self._over, self.work = {}, {}, {}, 0

    def over(self, rate):
        """The exponentials of this arc, each divided by e^(rate t)."""
        if rate not in self._over:
            columns = [[mpf(0)] * 4] * len(self.rates)
            self._over[rate] = TrueArc([x - rate for x in self.rates], columns, [mpf(0)] * 4, [mpf(0)] * 4)
        return self._over[rate]

    def exponentials(self, t):
        if t not in self._exponentials:
            self._exponentials[t] = [mp.exp(rate * t) for rate in self.rates]
        return self._exponentials[t]

    def magnitudes(self, t):
        if t not in self._magnitudes:
            self._magnitudes[t] = [mp.exp(mp.re(rate) * t) for rate in self.rates]
        return self._magnitudes[t]

    def state(self, t):
        turning = list(zip(self.columns, self.exponentials(t), strict=True))
        parts = [sum((column[i] * x).real for column, x in turning) for i in range(4)]
        return tuple(a + b * t + c for a, b, c in zip(self.c0, self.c1, parts, strict=True))


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
