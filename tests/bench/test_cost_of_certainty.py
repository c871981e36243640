"""The price of the certain search beside the cheapest possible one, which finds the same roots."""

import pytest

from benchmarks.cost_of_certainty import compared


@pytest.mark.slow
def test_certainty_costs_less_than_twice_a_plain_search():
    certain, plain = compared()
    assert certain < 2 * plain
