"""Outcomes of motions of the contact force, against closed forms; tests of the engine hold its roots in 60 digits."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from references.drives import threads_drive

from lsvib.chapter import contact_force
from lsvib.chapter.contact_force import ForceOutcome, Paradox
from lsvib.systems.kernels.layout import A0, A1, EQUILIBRIUM, R1
from lsvib.systems.motion import Motion, follow

AUTOMATA = {
    (damping, paradox): contact_force.contact_automaton(
        threads_drive(mass=30.0, contact_stiffness=1e8, contact_damping=damping), paradox
    )
    for damping in (0.0, 5e3, 5e4)  # elastic, underdamped, overdamped
    for paradox in Paradox
}
NUMBERS = st.floats(-3e5, 3e5, allow_subnormal=False)  # products of subnormal ones are zero


def motion_of(case, start) -> Motion:
    return follow(AUTOMATA[case], start, math.inf, max_events=1000)


def laws(case) -> tuple[np.ndarray, np.ndarray]:
    """The rows of the flow of law + and of law −."""
    plus, minus = AUTOMATA[case].tables.flow
    return plus, minus


def late(motion: Motion) -> np.ndarray:
    """The state 30 times the slowest time constant of the last law later."""
    row = motion.automaton.tables.flow[motion.end_mode]
    slowest = row[R1] or row[A1] / 2
    return motion.at([motion.end_time + 30.0 / abs(slowest)])[0][0]


@settings(max_examples=300)
@given(NUMBERS, NUMBERS)
@example(-1.0, 2.4565521262946583e-287)  # whose slope says nothing about when it comes to zero
def test_inconsistent_contact_forces_grow_whatever_the_start(x, rate):
    for damping in (0.0, 5e3, 5e4):
        motion = motion_of((damping, Paradox.INCONSISTENT), (x, rate))
        assert contact_force.outcome(motion) is ForceOutcome.PLUS_INFINITY
        assert motion.time.size <= 2
        assert min(late(motion)) > 0


@settings(max_examples=150)
@given(NUMBERS, NUMBERS)
@example(-1e-20, 4e3)  # nearer to zero than the sum that the flow forms can tell
@example(-1.0, 1e-166)  # with a slope that says nothing about where zero lies
def test_both_outcomes_of_the_indeterminate_case(x, rate):
    """Elastic: the energy decides. Damped: bounded means settling on 1/Γ₋, else |χ| grows on the side of law +."""
    case = 0.0, Paradox.INDETERMINATE
    (saddle, centre), stiffness = (row[EQUILIBRIUM] for row in laws(case)), laws(case)[0][A0]
    well = x**2 / 2 if x > 0 else stiffness * x**2 / 2
    energy = well - x * centre + rate**2 / 2
    top = -stiffness * saddle**2 / 2
    if abs(energy - top) > 1e-9 * top:
        assert contact_force.outcome(motion_of(case, (x, rate))) is (
            ForceOutcome.BOUNDED if energy < top and x > saddle else ForceOutcome.MINUS_INFINITY
        )
    for damping in (5e3, 5e4):
        motion = motion_of((damping, Paradox.INDETERMINATE), (x, rate))
        if contact_force.outcome(motion) is ForceOutcome.BOUNDED:
            assert late(motion)[0] == pytest.approx(centre, rel=1e-6)
        else:
            assert late(motion)[0] < 10 * saddle
