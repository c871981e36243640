"""The motion of the rigid drive in one mode in many digits: closed form, extrema of its guards, their first roots.

The flow u'' + 2a u' + b (u - u_eq) = 0 has a closed form.  Both guards (theta_dot and Q) are linear in (u, w), so the
derivative h of a guard obeys h'' + 2a h' + b h = 0, whose roots are known in closed form.  Between two of them the
guard is monotone, hence a sign change is a bracket with exactly one root: no event can be missed.
"""

from itertools import chain

from mpmath import mp, mpf

from references.exponential_sums import solve


class RigidTrueFlow:
    """Closed form of Gamma u'' + C u' + k u = force from (u0, w0) under law s, (8.16)."""

    def __init__(self, drive, s, u0, w0):
        Gamma, C, k = drive.Gamma(s), drive.C(s), drive.k
        self.a, self.b = C / (2 * Gamma), k / Gamma
        self.u_eq = drive.r * (drive.xi(drive.s0) - drive.xi(s)) * drive.R_tilde / k
        self.y0, self.w0 = u0 - self.u_eq, w0
        self.disc = self.a**2 - self.b
        self.omega = mp.sqrt(abs(self.disc))
        self.rate = abs(self.a) + mp.sqrt(self.b)  # no rate of the flow is faster
        if self.disc > 0:  # the larger root first: no cancellation
            self.l1 = -self.a - (self.omega if self.a >= 0 else -self.omega)
            self.l2 = self.b / self.l1

    def homogeneous(self, h0, h1, tau):
        """h(tau) for h'' + 2a h' + b h = 0, h(0) = h0, h'(0) = h1."""
        if self.disc > 0:
            return ((h1 - self.l2 * h0) * mp.exp(self.l1 * tau) + (self.l1 * h0 - h1) * mp.exp(self.l2 * tau)) / (
                self.l1 - self.l2
            )
        decay = mp.exp(-self.a * tau)
        if self.disc == 0:
            return decay * (h0 + (h1 + self.a * h0) * tau)
        cos, sin = mp.cos_sin(self.omega * tau)
        return decay * (h0 * cos + (h1 + self.a * h0) / self.omega * sin)

    def second(self, y, w):
        return -2 * self.a * w - self.b * y

    def state(self, tau):
        u = self.u_eq + self.homogeneous(self.y0, self.w0, tau)
        return u, self.homogeneous(self.w0, self.second(self.y0, self.w0), tau)

    def slope_start(self, guard):
        """h(0), h'(0) of h = d/dt (A u + B w + const)."""
        A, B, _ = guard
        acc = self.second(self.y0, self.w0)
        jerk = self.second(self.w0, acc)
        return A * self.w0 + B * acc, A * acc + B * jerk

    def extrema(self, guard, end):
        """All tau in (0, end) where the guard is stationary, in order."""
        h0, h1 = self.slope_start(guard)
        if h0 == 0 == h1:
            return
        if self.disc < 0:  # h0 cos x + h2 sin x = 0
            x = mp.atan2(-h0, (h1 + self.a * h0) / self.omega) % mp.pi
            while x / self.omega < end:
                if x > 0:
                    yield x / self.omega
                x += mp.pi
            return
        if self.disc == 0:
            roots = [-h0 / (h1 + self.a * h0)] if h1 + self.a * h0 != 0 else []
        else:
            first, second = h1 - self.l2 * h0, self.l1 * h0 - h1
            opposite = first * second < 0
            roots = [mp.log(-second / first) / (self.l1 - self.l2)] if opposite else []
        yield from (tau for tau in roots if 0 < tau < end)

    def first_root(self, guard, side, from_zero, end, digits):
        """First tau in (0, end] where side*guard falls to 0; None if it stays positive.

        from_zero: the guard is 0 at tau = 0 and has just been left on the right side.  Its stationary point at
        tau = 0 (release from rest: zero acceleration) may come out as a tiny positive tau: it is passed over.
        """
        A, B, const = guard
        h = self.slope_start(guard)

        def value(tau):
            u, w = self.state(tau)
            return side * (A * u + B * w + const)

        if not from_zero:
            assert value(mpf(0)) > 0
        left, tiny = mpf(0), mpf(10) ** -(digits // 2 + 5) / self.rate
        for right in chain(self.extrema(guard, end), [end]):
            if from_zero and left == 0 and right < min(tiny, end):
                continue
            if value(right) <= 0:
                if from_zero and left == 0:
                    if right <= tiny:  # the end of the run, a rounding away
                        return None
                    raise ArithmeticError("a guard left zero on the wrong side")
                return solve(
                    value,
                    lambda tau: side * self.homogeneous(*h, tau),
                    left,
                    right,
                    mpf(10) ** -(digits + 5) / self.rate,
                )
            left = right
        return None


def windows(first, end):
    """Growing parts of a run, so that a guard that never falls is not searched to the end if another one does."""
    while first < end:
        yield first
        first *= 4
    yield end
