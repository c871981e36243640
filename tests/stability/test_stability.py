"""Eigenvalues (8.18) against 60-digit arithmetic, and their classes."""

from fractions import Fraction

import mpmath
import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st

from lsvib.stability.linear import Stability, eigenvalue_pair, stability_class

SIGNED = st.floats(1e-12, 1e6) | st.floats(-1e6, -1e-12)


def exact_pair(gamma: float, c: float, k: float) -> list[mpmath.mpc]:
    with mpmath.workdps(60):
        g, c, k = map(mpmath.mpf, (gamma, c, k))
        root = mpmath.sqrt(c * c - 4 * k * g)
        return sorted(((-c - root) / (2 * g), (-c + root) / (2 * g)), key=lambda z: (mpmath.re(z), mpmath.im(z)))


@settings(deadline=None, max_examples=500)
@given(SIGNED, SIGNED | st.just(0.0), st.floats(1e-9, 1e9))
@example(1e-9, 2e-4, 10.0)  # discriminant at the rounding of its two products
@example(2.5e-9, 1e-4, 1.0)
@example(1e-12, 1e6, 1e-9)  # roots 1e33 apart
def test_eigenvalues_keep_all_digits(gamma, c, k):
    pair = eigenvalue_pair(gamma, c, k)
    for ours, exact in zip(pair, exact_pair(gamma, c, k), strict=True):
        with mpmath.workdps(60):
            for mine, theirs in ((ours.real, mpmath.re(exact)), (ours.imag, mpmath.im(exact))):
                assert abs(mpmath.mpf(float(mine)) - theirs) <= 8e-16 * abs(theirs)


@settings(deadline=None, max_examples=300)
@given(SIGNED, SIGNED, st.floats(1e-9, 1e9))
def test_class_follows_the_signs(gamma, c, k):
    """Stable exactly if Γ_0 > 0 and C_0 > 0; focus exactly if C_0² < 4kΓ_0, decided here in rational numbers."""
    kind = Stability(int(stability_class(gamma, c, k)))
    if gamma < 0:
        assert kind is Stability.SADDLE
        return
    focus = Fraction(c) ** 2 < 4 * Fraction(k) * Fraction(gamma)
    name = ("STABLE" if c > 0 else "UNSTABLE") + ("_FOCUS" if focus else "_NODE")
    assert kind.name == name


def test_limits():
    assert stability_class(1.0, 0.0, 1.0) == Stability.CENTRE
    assert stability_class(1.0, 2.0, 1.0) == Stability.STABLE_NODE
    assert stability_class(0.0, 1.0, 1.0) == Stability.DEGENERATE
    first, second = eigenvalue_pair(0.0, 2.0, 3.0)
    assert first == -1.5
    assert np.isnan(second.real)
    assert list(eigenvalue_pair(1.0, 0.0, 0.0)) == [0, 0]
