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
from references.parts import nut_drive, support_drive, threads_drive

KINDS = {"threads": threads_drive, "support": support_drive, "nut": nut_drive}


def power(rng, low, high):
    return float(10 ** rng.uniform(low, high))


def second_body(model, rng):
    """Contact, support or nut, from soft to stiff."""
    if model == "threads":
        stiffness = power(rng, 6, 9)
        return {"contact_stiffness": stiffness, "contact_damping": stiffness * power(rng, -4, -1)}
    if model == "support":
        stiffness = power(rng, 7, 9)
        return {
            "screw_mass": power(rng, 0, 2),
            "support_stiffness": stiffness,
            "axial_support_damping": stiffness * power(rng, -5, -3),
        }
    return {
        "nut_inertia": power(rng, -3, -1),
        "nut_stiffness": power(rng, 2, 5),
        "nut_damping": power(rng, -2, 1),
    }


def on_an_edge(model, rng):
    """A drive of which slip that repels may bound the basin of steady sliding."""
    return KINDS[model](
        mass=float(rng.uniform(9.5, 9.95)),
        translation_damping=power(rng, 2.9, 3.1),
        axial_force=float(rng.uniform(6, 14)),
        **second_body(model, rng),
    )


def anywhere(model, rng):
    """A drive below or above the critical mass, turning either way."""
    return KINDS[model](
        mass=float(rng.uniform(4, 16)),
        support_damping=power(rng, -4, -2.5),
        translation_damping=float(rng.choice([0.0, 10.0, 1000.0])),
        axial_force=float(rng.uniform(-60, 60)),
        input_speed=float(rng.choice([-40.0, 40.0])),
        **second_body(model, rng),
    )


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


def drive_with(model, seed, draw, sides):
    """The first random drive of a seed with cycles on these sides of the unit circle."""
    rng = np.random.default_rng([seed, len(model)])
    for _ in range(60):
        drive = draw(model, rng)
        cycles = drive.cycles().cycles
        if sides <= {cycle.attracting for cycle in cycles}:
            return cycles
    raise AssertionError("no drive has such cycles")


@pytest.mark.slow
@pytest.mark.parametrize("model", KINDS)
def test_attracting_and_repelling_cycle_of_a_drive(model):
    for cycle in drive_with(model, 0, on_an_edge, {True, False}):
        assert_digits(cycle)


@pytest.mark.slow
@pytest.mark.parametrize("model", KINDS)
def test_cycles_of_a_drive_anywhere(model):
    for cycle in drive_with(model, 0, anywhere, {True}):
        assert_digits(cycle)
