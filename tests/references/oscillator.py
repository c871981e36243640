"""The flow of u″ + a₁ u′ + a₀ u = b in mpmath, written with complex roots and one formula for every kind of them."""

from mpmath import exp, expm1, mp, mpf, re, sqrt

DIGITS = 200  # so that roots may be moved apart by 1e-60 where they coincide, and 60 digits are left and more
APART = mpf("1e-60")


def number(x):
    """An int, float, string or Decimal as an mpmath number, exactly."""
    return mpf(x) if isinstance(x, (int, float)) else mpf(str(x))


def flow(inertia, damping, stiffness, force, u, w, t):
    """Return (u, w) at time t of  inertia·u″ + damping·u′ + stiffness·u = force."""
    with mp.workdps(DIGITS):
        inertia, damping, stiffness, force, u, w, t = map(number, (inertia, damping, stiffness, force, u, w, t))
        half = damping / inertia / 2
        root = sqrt(mp.mpc(half**2 - stiffness / inertia))
        first, second = -half + root, -half - root
        if abs(root) < APART:
            first, second = -half + APART, -half - APART
        # Impulse response, its rate and its integral.
        response = (exp(first * t) - exp(second * t)) / (first - second)
        rate = (first * exp(first * t) - second * exp(second * t)) / (first - second)
        integral = (_integral(first, t) - _integral(second, t)) / (first - second)
        push = force / inertia - stiffness / inertia * u
        return re(u + w * response + push * integral), re(w * rate + push * response)


def _integral(root, t):
    return expm1(root * t) / root if root != 0 else t
