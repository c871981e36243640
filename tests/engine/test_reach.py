"""Sizes that coordinates reach: what one typical size makes of another one counts as typical."""

import math

import pytest

from lsvib.engine.exact.field import Field, reached


@pytest.mark.parametrize(("sizes", "found"), [((1e-7, 1.0), (0.25, 1.0)), ((1.0, 1e-7), (1.0, 4.0))])
def test_an_oscillation_takes_each_coordinate_as_far_as_the_other(sizes, found):
    """x″ = −16 x: a rate of 1 m/s swings x by 1/4 m, and 1 m gives it a rate of 4 m/s."""
    field = Field.of([[0, 1, 0], [-16, 0, 0]], sizes)
    assert reached(field, math.inf).sizes == pytest.approx(found, rel=1e-6)


@pytest.mark.parametrize(("sizes", "found"), [((1e-7, 1.0), (0.0974, 1.0)), ((1.0, 1e-7), (1.0, 1.558))])
def test_a_slow_oscillation_takes_coordinates_as_far_as_it_can_before_the_horizon(sizes, found):
    """In 0.1 s the same oscillation turns by 0.4 rad: x = sin(0.4)/4, and x′ = 4 sin(0.4)."""
    field = Field.of([[0, 1, 0], [-16, 0, 0]], sizes)
    assert reached(field, 0.1).sizes == pytest.approx(found, rel=1e-3)
