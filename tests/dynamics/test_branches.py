"""Branches of cycles over a parameter, of random drives of every kind and of known ones, against Newton's laws."""

from collections import Counter

import numpy as np
import pytest
from references.branches import Judge, random_branch
from references.drives import rigid_drive
from references.sizes import sizes

from lsvib.systems.shooting import Shooting, Units

KNOWN = [  # drive, period of the cycle, parameter, span; values that it reaches as attracting cycles, the last a fold
    ({
        "pitch_radius": 0.002568855824355383, "lead_angle": 0.3033335757876384, "screw_inertia": 3.179895105165241e-05,
        "mass": 0.21866445913170746, "coupling_stiffness": 25.996774238105083, "axial_force": 964.1559220916625,
        "support_damping": 1.555441560121225e-05, "translation_damping": 0.0, "input_speed": 2.6069269347538193,
        "friction_coefficient": 0.18261447919899482, "stribeck_rise": 0.11957927790366288,
        "stribeck_speed": 0.014462183222818356, "static_friction_coefficient": 0.41032730650926336,
        "motor_inertia": 0.0002857137583981114, "integral_gain": 12.209729608620153, "speed_gain": 0.015566072622826251,
    }, 0.10754984013828, "input_speed", (0.65, 5.11), (2.6367,)),
    ({
        "pitch_radius": 0.005315422948662307, "lead_angle": 0.15345527856988447, "screw_inertia": 4.3321781276934675e-7,
        "mass": 3.207552927255614, "coupling_stiffness": 0.5241477825743309, "axial_force": -11.803959068412999,
        "support_damping": 0.0005231061008912198, "translation_damping": 61.4965650090542,
        "input_speed": -1.5109008595505111, "friction_coefficient": 0.2373257091451827,
        "static_friction_coefficient": 0.323603501918012, "screw_mass": 0.8739119679909806,
        "support_stiffness": 1006553.7457440778, "axial_support_damping": 250.35462140327172,
        "bearing_friction": 0.004262227268069563,
    }, 0.012008049543, "friction_coefficient", (0.0736, 0.3236), (0.30584235734,)),  # Γ₊ = 0: motions jump there
    ({
        "pitch_radius": 0.008623355827679022, "lead_angle": 0.18922759436104514, "screw_inertia": 5.604907846291323e-06,
        "mass": 3.920924029888372, "coupling_stiffness": 6.933004211978956, "axial_force": -27.354265001933822,
        "support_damping": 0.0007983734761827193, "input_speed": -0.5920579431906888,
        "friction_coefficient": 0.3404215432305162, "stribeck_rise": 0.09759410950467848,
        "stribeck_speed": 0.007600613781171045, "stribeck_exponent": 2,
    }, 0.00740519769981, "pitch_radius", (0.00507, 0.01466), ()),
    (dict(mass=11, axial_force=-10, support_damping=0.00029), 0.0117323998, "support_damping", (0.00027, 0.00033),
     (0.00027, 0.00033)),
    (dict(mass=1, translation_damping=1e3, axial_force=40, static_friction_coefficient=0.3), None,
     "friction_coefficient", (0.2, 0.3), (0.3,)),
    (dict(mass=11, support_damping=2e-3, axial_force=-18.37, contact_stiffness=1e8, contact_damping=1e8), 0.0146427597,
     "axial_force", (-18.5, -18.3699), (-18.371145255,)),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "period", "parameter", "span", "reached"),
    [pytest.param(*one, marks=[pytest.mark.search] * (one[2] in ("pitch_radius", "input_speed"))) for one in KNOWN],
)
def test_a_branch_goes_on_where_its_cycle_does(values, period, parameter, span, reached):
    """False folds, a jump, a table of other surfaces, rest of no length, and the end of what may be asked."""
    cycles = rigid_drive(values).cycles().cycles
    cycle = next(one for one in cycles if period is None or one.period == pytest.approx(period, rel=1e-6))
    branch = cycle.drive.follow(cycle, parameter, span, points=100)
    assert not Judge(branch, span).faults
    assert branch.folds == pytest.approx([value for value in reached if value in (-18.371145255,)], abs=1e-9)
    found = [point.value for point in branch.points if point.cycle.attracting]
    found += [change.value for change in branch.changes]
    for value in reached:
        assert min(found) - 1e-9 <= value <= max(found) + 1e-9


@pytest.mark.parametrize("k", sizes([3], range(len(KNOWN))))
def test_equations_have_their_derivatives(k):
    """By state, period and parameter, through rest, seizures, jams and static friction, against central differences."""
    values, period, parameter, span, _ = KNOWN[k]
    cycles = rigid_drive(values).cycles().cycles
    cycle = next(one for one in cycles if period is None or one.period == pytest.approx(period, rel=1e-6))

    def build(value):
        return cycle.drive.replace(**{parameter: value}).automaton()

    value = getattr(cycle.drive, parameter)
    units = Units(build, np.abs(cycle.orbit.after).max(axis=0), cycle.period, abs(value), span)
    shooting = Shooting(units, cycle.orbit)
    here = shooting.here(cycle.period, value, np.array([0.0, 1.0]))
    exact = shooting.slopes(here, here.slope)
    for column, step in zip(exact.T, 1e-7 * np.eye(here.z.size), strict=True):
        ends = [shooting.gap(shooting.at(here.z + sign * step)) for sign in (1, -1)]
        # rounding of the differences, and what a derivative changes over their step
        np.testing.assert_allclose(column, (ends[0] - ends[1]) / 2e-7, atol=1e-4 * np.abs(exact).max())
    assert np.abs(exact @ here.tangent).max() <= 1e-9 * np.abs(exact).max()


@pytest.mark.parametrize("seeds", sizes([], [(5, 6)], [range(k, k + 100) for k in range(0, 1200, 100)]))
def test_random_branches(seeds):
    """Folds, borders, ends and points in between are what own motions say, of nearly all that they can follow."""
    drawn = [one for seed in seeds if (one := random_branch(seed)) is not None]
    judges = [Judge(cycle.drive.follow(cycle, name, span, points=70), span) for cycle, name, span in drawn]
    assert not [(judge.drive, judge.branch.parameter, judge.span, judge.faults) for judge in judges if judge.faults]
    held = sum((judge.held for judge in judges), Counter())
    assert sum(held[name] for name in held if "not known" in name) <= 0.05 * held.total()
    assert sum(len(judge.branch.changes) > 2 for judge in judges) >= 0.3 * len(judges) > 0
