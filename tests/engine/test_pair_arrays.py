"""Pairs of doubles with bounds of their errors: every bound holds, and what is called safe is what 50 digits give."""

import operator
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest

from lsvib.engine.exact.pair_arrays import Divided, Pairs, Undecided, doubles, in_groups

RNG = np.random.default_rng(3)


def numbers(size: int, unsafe: np.ndarray) -> tuple[Pairs, list[Fraction]]:
    """Pairs that are exact, with both parts in use, over sixty decades."""
    high = RNG.choice([-1, 1], size) * 10.0 ** RNG.uniform(-30, 30, size)
    low = 0.5 * np.spacing(high) * RNG.uniform(-1, 1, size)
    exact = [Fraction(a) + Fraction(b) for a, b in zip(high.tolist(), low.tolist(), strict=True)]
    return Pairs(high, low, np.zeros(size), unsafe), exact


def within(found: Pairs, exact: list[Fraction]) -> bool:
    parts = zip(found.high.tolist(), found.low.tolist(), found.bound.tolist(), exact, strict=True)
    return all(abs(Fraction(a) + Fraction(b) - x) <= Fraction(c) for a, b, c, x in parts)


@pytest.mark.parametrize("act", [operator.add, operator.sub, operator.mul, operator.truediv])
def test_bounds_hold(act):
    """Also where leading parts cancel, and where an operand brings an error of its own."""
    unsafe = np.zeros(500, dtype=bool)
    a, exact_a = numbers(500, unsafe)
    b, exact_b = numbers(500, unsafe)
    near = Pairs(a.high * (1 + 2.0**-40), -a.low, np.zeros(500), unsafe)
    exact_near = [Fraction(x) + Fraction(y) for x, y in zip(near.high.tolist(), near.low.tolist(), strict=True)]
    for other, exact_other in ((b, exact_b), (near, exact_near)):
        found, exact = act(a, other), [act(x, y) for x, y in zip(exact_a, exact_other, strict=True)]
        assert within(found, exact)
        assert (found.bound <= 1e-29 * (np.abs(a.high) + np.abs(other.high) + np.abs(found.high))).all()
        again = act(found, a)
        assert within(again, [act(x, y) for x, y in zip(exact, exact_a, strict=True)])
    assert within(act(a, Decimal("0.1")), [act(x, Fraction(1, 10)) for x in exact_a])


def test_roots():
    unsafe = np.zeros(300, dtype=bool)
    a, exact = numbers(300, unsafe)
    root = abs(a).sqrt()
    for high, low, bound, x in zip(root.high.tolist(), root.low.tolist(), root.bound.tolist(), exact, strict=True):
        with localcontext(prec=80):
            true = (Decimal(abs(x).numerator) / Decimal(abs(x).denominator)).sqrt()
            assert abs(Decimal(high) + Decimal(low) - true) <= Decimal(bound)
    zero = Pairs.exactly(np.zeros(1), np.zeros(1, dtype=bool)).sqrt()
    assert zero.high[0] == zero.bound[0] == 0


def test_a_double_is_safe_only_if_the_bound_leaves_one():
    """1 + 2^-53 lies halfway between two doubles: with an error it has no rounding, without a cancellation 1 has."""
    unsafe = np.zeros(3, dtype=bool)
    x = Pairs(np.ones(3), np.array([0.0, 2.0**-54, 2.0**-53]), np.array([1e-25, 1e-25, 1e-25]), unsafe)
    assert (x.rounded() == 1).all()
    assert unsafe.tolist() == [False, False, True]


def test_comparisons_divide_and_refuse():
    unsafe = np.zeros(3, dtype=bool)
    x = Pairs(np.array([1.0, -1.0, 1e-40]), np.zeros(3), np.array([0.0, 0.0, 1e-39]), unsafe)
    with pytest.raises(Divided) as parts:
        bool(x > 0)
    assert unsafe.tolist() == [False, False, True]
    assert parts.value.holds[:2].tolist() == [True, False]
    with pytest.raises(Undecided):
        bool(Pairs(np.zeros(1), np.zeros(1), np.ones(1), np.zeros(1, dtype=bool)) == 0)
    assert (Pairs.exactly(np.zeros(2), np.zeros(2, dtype=bool))) == 0

    values = RNG.uniform(-1, 1, 50)

    def signs(group):
        numbers = Pairs.exactly(values[group], np.zeros(group.size, dtype=bool))
        return ("positive" if numbers > 0 else "negative"), doubles([numbers, 2], (2,))

    seen = np.zeros(50, dtype=bool)
    for group, (word, table) in in_groups(50, signs):
        assert (values[group] > 0).all() == (word == "positive")
        np.testing.assert_array_equal(table, np.column_stack([values[group], np.full(group.size, 2.0)]))
        seen[group] = True
    assert seen.all()
