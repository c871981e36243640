"""Cycles of drives with four states against 40 digits: multipliers and period, attracting and repelling ones.

The reference (``reference.cycle_digits``) takes of the library only the modes and about how long each lasts. Drives are
random; by hand twenty of each model have an attracting and a repelling cycle each, and twenty more come from a wide
range. Tolerance 1e-9 of the larger of 1 and the multiplier, as the library promises, and the library's own bound. The
state of a cycle that repels by a factor beyond 1e4 is known to rounding times that factor, and its multiplier as well.
"""

from itertools import permutations

import numpy as np
import pytest
from references.cycle_digits import CycleDigits
from references.draws import drawn, one_of, power, uniform
from references.parts import DRIVES

import lsvib.api  # noqa: F401  (the methods of drives)

KINDS = ("threads", "support", "nut")


# Drives of which slip that repels may bound the basin of steady sliding; and drives below or above the critical mass.
ON_AN_EDGE = {"mass": uniform(9.5, 9.95), "translation_damping": power(2.9, 3.1), "axial_force": uniform(6, 14)}
ANYWHERE = {
    "mass": uniform(4, 16), "support_damping": power(-4, -2.5), "translation_damping": one_of(0.0, 10.0, 1000.0),
    "axial_force": uniform(-60, 60), "input_speed": one_of(-40.0, 40.0),
}  # fmt: skip
NUT = {"nut_inertia": power(-3, -1), "nut_stiffness": power(2, 5), "nut_damping": power(-2, 1)}


def second_body(model, rng):
    """Contact, support or nut, from soft to stiff."""
    if model == "threads":
        stiffness = power(6, 9)(rng)
        return {"contact_stiffness": stiffness, "contact_damping": stiffness * power(-4, -1)(rng)}
    if model == "support":
        stiffness, mass = power(7, 9)(rng), power(0, 2)(rng)
        damping = stiffness * power(-5, -3)(rng)
        return {"screw_mass": mass, "support_stiffness": stiffness, "axial_support_damping": damping}
    return drawn(rng, NUT)


def assert_digits(cycle):
    reference = CycleDigits(cycle)
    scale = max(1.0, float(np.abs(reference.multipliers).max()))
    error = min(
        max(abs(a - b) for a, b in zip(cycle.multipliers, order, strict=True))
        for order in permutations(reference.multipliers)
    )
    assert error <= max(1e-9, 1e-13 * scale) * scale, (cycle.multipliers, reference.multipliers)
    assert error <= cycle.multiplier_error + 1e-14 * scale
    assert cycle.attracting == (abs(reference.multipliers[0]) < 1) or cycle.neutral
    assert abs(cycle.period - float(reference.solved[1])) <= 1e-10 * cycle.period


def cycles_of(model, seed, draws, sides):
    """Cycles of the first random drive of a seed that has them on these sides of the unit circle."""
    rng = np.random.default_rng([seed, len(model)])
    for _ in range(60):
        values = drawn(rng, draws)
        cycles = DRIVES[model](values | second_body(model, rng)).cycles().cycles
        if sides <= {cycle.attracting for cycle in cycles}:
            return cycles
    raise AssertionError("no drive has such cycles")


@pytest.mark.slow
@pytest.mark.parametrize("model", KINDS)
def test_attracting_and_repelling_cycle_of_a_drive(model):
    for cycle in cycles_of(model, 0, ON_AN_EDGE, {True, False}):
        assert_digits(cycle)


@pytest.mark.slow
@pytest.mark.parametrize("model", KINDS)
def test_cycles_of_a_drive_anywhere(model):
    for cycle in cycles_of(model, 0, ANYWHERE, {True}):
        assert_digits(cycle)
