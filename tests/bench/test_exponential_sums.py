"""The reference's search for roots: touches, dips, what dies away, what begins with less than its rounding."""

import pytest
from mpmath import mp, mpf
from references.exponential_sums import Function, ThreadsTrueArc, first_root, summed

FIRST = [mpf(1), mpf(0), mpf(0), mpf(0), mpf(0)]  # the function is the first coordinate


@pytest.fixture(autouse=True)
def _digits():
    with mp.workdps(70):
        yield


def function(rates, coefficients, constant=0, **how):
    """The function constant + sum Re(c exp(rate t))."""
    columns = [[mpf(c), mpf(0), mpf(0), mpf(0)] for c in coefficients]
    arc = ThreadsTrueArc([mp.mpmathify(x) for x in rates], columns, [mpf(constant), *[mpf(0)] * 3], [mpf(0)] * 4)
    return Function(arc, FIRST, **how)


def test_a_touch_is_no_root_where_it_is_without_effect_and_undecided_elsewhere():
    """1 + cos t touches zero at pi."""
    assert first_root([function([1j], [1], 1, may_touch=True)], [1], mpf(20)) == (20, None)
    with pytest.raises(ArithmeticError, match="grazes zero"):
        first_root([function([1j], [1], 1)], [1], mpf(20))


@pytest.mark.parametrize("depth", [mpf(10) ** -k for k in (3, 12, 30, 40)])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_dip_is_told_from_none_far_below_the_rounding_of_doubles(depth, sign):
    """1 + sign * depth + cos t falls below zero at pi - sqrt(2 depth), or never."""
    when, fired = first_root([function([1j], [1], 1 + sign * depth, may_touch=True)], [1], mpf(20))
    assert (when, fired) == (20, None) if sign > 0 else fired == 0 and abs(when - mp.acos(depth - 1)) < mpf(10) ** -25


def test_what_dies_away_is_followed_at_once_and_to_its_last_root():
    """Rates of 1e6 1/s for an hour: no step is as short as the time in which it dies away."""
    fast = function([-1e6, -3e6], [2, -1])
    assert first_root([fast], [1], mpf(3600)) == (3600, None)
    assert fast.arc.work + sum(arc.work for arc in fast.arc._over.values()) < 100
    late = function([-1e3, -1001], [-1, mpf(10) ** 300])
    when, fired = first_root([late], [1], mpf(3600))
    assert fired == 0
    assert abs(when - 300 * mp.log(10)) < mpf(10) ** -50


def test_a_sum_that_is_rounding_is_zero():
    """Terms that cancel leave nothing, and nothing grows from it."""
    third = mpf(1) / 3
    assert summed(third, third, -2 * third + mpf(10) ** -60) == 0
    assert summed(third, third, -2 * third + mpf(10) ** -40) != 0
    assert first_root([function([1e6], [0])], [1], mpf(1)) == (1, None)


def test_a_guard_that_begins_with_less_than_its_rounding_may_fall_at_once():
    """1e-60 - t falls, which is an event for a speed and a contradiction for a condition that is zero exactly."""
    arc = ThreadsTrueArc(
        [mpf(1)], [[mpf(-1), mpf(0), mpf(0), mpf(0)]], [1 + mpf(10) ** -60, *[mpf(0)] * 3], [mpf(0)] * 4
    )
    assert first_root([Function(arc, FIRST, may_fall=True)], [1], mpf(1)) == (0, 0)
    with pytest.raises(AssertionError, match="wrong side"):
        first_root([Function(arc, FIRST)], [1], mpf(1))
