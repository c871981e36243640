"""Numbers with derivatives: every operation and function against 60 digits, values and slopes."""

import numpy as np
import pytest
from mpmath import mp

from lsvib.engine.exact import duals


@pytest.mark.parametrize("at", [-30.0, -1e-13, 0.0, 1e-13, 0.3, 200.0])
def test_functions_of_duals(at):
    """Values and slopes of the functions that are smooth through zero, against power series and differences."""
    with mp.workdps(60):
        (z,) = duals.variables([at])
        here, step = mp.mpf(at), mp.mpf(10) ** -15

        def ratio(x):
            return mp.nsum(lambda n: (-1) ** int(n) * x**n / mp.factorial(2 * n + 1), [0, 60])

        def cosine(x):
            return mp.re(mp.cos(mp.sqrt(x)))

        for made, truth in ((duals.cosine_of_root(z), cosine), (duals.sine_ratio_of_root(z), ratio)):
            assert abs(made.value - truth(here)) < mp.mpf(10) ** -40 * max(1, abs(truth(here)))
            slope = (truth(here + step) - truth(here - step)) / (2 * step)
            assert abs(made.slopes[0] - slope) < mp.mpf(10) ** -25 * max(1, abs(slope))


def test_arithmetic_of_duals():
    rng = np.random.default_rng(7)
    a, b = (float(x) for x in rng.uniform(0.5, 2, 2))
    x, y = duals.variables([a, b])
    found = (2 - x) * y / (x + 3) - 1 / y + (-x) ** 3 * duals.exponential(y) * duals.tangent(x / 3) + (1 - y)

    def plain(x, y):
        return (2 - x) * y / (x + 3) - 1 / y + (-x) ** 3 * mp.exp(y) * mp.tan(x / 3) + (1 - y)

    with mp.workdps(60):
        a, b, h = mp.mpf(a), mp.mpf(b), mp.mpf(10) ** -18
        assert abs(found.value - plain(a, b)) < mp.mpf(10) ** -50
        assert abs(found.slopes[0] - (plain(a + h, b) - plain(a - h, b)) / (2 * h)) < mp.mpf(10) ** -30
        assert abs(found.slopes[1] - (plain(a, b + h) - plain(a, b - h)) / (2 * h)) < mp.mpf(10) ** -30
