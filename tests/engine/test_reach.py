"""Sizes that coordinates reach: what one typical size makes of another one counts as typical."""

import math

import pytest
from references.wide_drives import wide_drive

from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.drives.registry import find_model
from lsvib.engine.exact.field import exact_field
from lsvib.engine.exact.reach import reached
from lsvib.engine.kernels.tables import BlockFlow, ModalFlow


@pytest.mark.parametrize(("sizes", "found"), [((1e-7, 1.0), (0.25, 1.0)), ((1.0, 1e-7), (1.0, 4.0))])
def test_an_oscillation_takes_each_coordinate_as_far_as_the_other(sizes, found):
    """x″ = −16 x: a rate of 1 m/s swings x by 1/4 m, and 1 m gives it a rate of 4 m/s."""
    field = exact_field([[0, 1, 0], [-16, 0, 0]], sizes)
    assert reached(field, math.inf).sizes == pytest.approx(found, rel=1e-6)


@pytest.mark.parametrize(("sizes", "found"), [((1e-7, 1.0), (0.0974, 1.0)), ((1.0, 1e-7), (1.0, 1.558))])
def test_a_slow_oscillation_takes_coordinates_as_far_as_it_can_before_the_horizon(sizes, found):
    """In 0.1 s the same oscillation turns by 0.4 rad: x = sin(0.4)/4, and x′ = 4 sin(0.4)."""
    field = exact_field([[0, 1, 0], [-16, 0, 0]], sizes)
    assert reached(field, 0.1).sizes == pytest.approx(found, rel=1e-3)


def test_a_fast_nut_has_the_size_of_its_swings():
    """Its angle was expected to be 2e-7 rad and its rate 9446 rad/s, so that all rates of a mode shared one block.

    A step of the search was then as short as the block is large, and motions that slide for ever had no next event
    within the work that is allowed. The judge sees no further event either.
    """
    wide, model = wide_drive("nut", 31127, 24, 4), find_model("nut")
    automaton = model.build(wide.drive, wide.physics, "contact_sign")
    assert isinstance(automaton.tables.flow, ModalFlow)
    assert automaton.condition < 100
    assert [steady_state(automaton, start).label for start in wide.starts] == [Attractor.STEADY_SLIDING] * 4


@pytest.mark.long
@pytest.mark.parametrize(("model", "count"), [("threads", 5), ("support", 0), ("nut", 0)])
def test_few_random_drives_are_carried_in_blocks(model, count):
    """Of 300 drives: 46 of compliant threads were, before what slow rates change was told from what they reach."""
    kind, found = find_model(model), 0
    for index in range(300):
        wide = wide_drive(model, 901, index, 4)
        automaton = kind.build(wide.drive, (*kind.options, *wide.physics), "contact_sign")
        found += isinstance(automaton.tables.flow, BlockFlow)
    assert found == count
