"""Steady sliding with friction that depends on the speed: against Newton's laws linearised by differences."""

import math

import mpmath
import numpy as np
import pytest
from references.drives import DRIVES, drive_with_law, threads_drive
from references.newton import eigenvalues_of_sliding
from references.sizes import sizes

from lsvib import Drive
from lsvib.drives import friction
from lsvib.drives.pairings import PAIRINGS
from lsvib.errors import InputError, NoThreshold
from lsvib.stability import spectrum
from lsvib.stability.boundaries import stable_set
from lsvib.stability.conditions import stability
from lsvib.stability.curves import ChartBoundary, boundary_curves
from lsvib.stability.threshold import all_thresholds

MODELS = tuple(DRIVES)
LEAD, RADIUS = math.radians(5.57), 5.18e-3
SEAT = PAIRINGS["powered_seat"].parameters()  # a measured law of a seat adjuster


def polynomial_of(roots) -> list:
    """Coefficients of the polynomial with these roots, the highest one 1."""
    found = [mpmath.mpf(1)]
    for root in roots:
        found = [a - root * b for a, b in zip([*found, 0], [0, *found], strict=True)]
    return [float(mpmath.re(x)) for x in found]


@pytest.mark.parametrize("model", MODELS)
def test_report_against_newtons_laws(model):
    rng, kinds = np.random.default_rng(1), set()
    for _ in range(25):
        drive = drive_with_law(model, rng)
        report, exact = stability(drive), eigenvalues_of_sliding(drive)
        with mpmath.workdps(60):
            expected = polynomial_of(exact)
        lead = report.characteristic_polynomial[0]
        np.testing.assert_allclose([p / lead for p in report.characteristic_polynomial], expected, rtol=1e-12)
        for ours, theirs in zip(report.eigenvalues, exact, strict=True):
            assert abs(ours - complex(theirs)) <= 1e-13 * abs(complex(theirs))
        growing = bool(mpmath.re(exact[-1]) > 0)
        assert report.stable is not growing
        assert any(condition.hold for condition in report.conditions.values()) == growing
        kinds.add(report.stable)
    assert kinds == {True, False}


@pytest.mark.parametrize("model", [model for model in MODELS if model != "rigid"])
def test_polynomial_in_balls_in_floats_and_of_grids(model):
    rng = np.random.default_rng(2)
    for _ in range(10):
        drive = drive_with_law(model, rng)
        law, report = spectrum.steady_law(drive), stability(drive)
        for own in (drive, drive.exact()):
            found = [float(p) for p in spectrum.polynomial(own, law)]
            np.testing.assert_allclose(found, report.characteristic_polynomial, rtol=1e-12)
    # one of the drives without a law, one that is cut off at zero
    changes = {"friction_slope": [0.0, drive.friction_slope, -1e3], "stribeck_rise": [0.0, 0.03, 0.01]}
    law = {"stribeck_speed": 0.1, "stribeck_exponent": 2.0}
    grid = spectrum.polynomial({**dict(drive), **law, **{key: np.array(x) for key, x in changes.items()}}, 1)
    for k in range(3):
        one = spectrum.polynomial(drive.replace(**law, **{key: x[k] for key, x in changes.items()}), 1)
        found = [np.broadcast_to(p, 3)[k] for p in grid]
        np.testing.assert_allclose(found, [float(p) for p in one], rtol=1e-14)


def test_forces_and_masses_of_the_seat():
    expected = {40: (88.934, 11.848), 10: (64.305, 10.451), 5: (24.914, 10.041), 2: (9.8556, 9.441)}
    for speed, (force, mass) in expected.items():
        drive = Drive(**SEAT, input_speed=speed, mass=1)
        found = drive.threshold("onset", unknown="axial_force").solutions
        assert float(f"{found[-1].value:.5g}") == force
        assert found[0].value < 0  # the law falls for the load in the other direction, too
        assert round(drive.threshold("kinematic_constraint").value, 3) == mass
        onset = drive.replace(axial_force=1.0).threshold("onset", unknown="mass")
        assert round(onset.value, 3) == mass


@pytest.mark.parametrize("model", sizes(["rigid"], [model for model in MODELS if model != "rigid"]))
def test_onset_by_every_parameter(model):
    """Every solution divides stable from unstable drives, and every random value has the stability that is said."""
    rng, seen = np.random.default_rng(3), set()
    for _ in range(3):
        drive = drive_with_law(model, rng)
        for key in set(DRIVES[model].parameters) - {"stribeck_exponent"}:
            if key == "stribeck_rise" and not drive.stribeck_speed:
                continue
            stable = stable_set(drive, key)
            if stable is None:
                continue
            ends = [float(x) for x in {end for interval in stable.intervals for end in interval}]
            ends = [math.atan(x) if key == "lead_angle" else x for x in ends]
            ends = [end for end in ends if end]
            own = getattr(drive, key) or 1.0
            places = [own * x for x in (0.3, 0.9, 1.2, 4.0)]
            places += [end * (1 + side * 1e-7) for end in ends for side in (-1, 1)]
            for value in places:
                seen |= {(key, found)} if (found := judged(model, drive, key, value, stable)) is not None else set()
            if (solved := solutions(drive, key)) is not None:
                inner = [end for end in ends if any(math.isclose(end, x.value, rel_tol=1e-14) for x in solved)]
                assert len(inner) == len(solved)
                assert all(low <= x.value <= high for x in solved for low, high in [x.enclosure])
    assert {key for key, found in seen if found} >= {"mass", "input_speed", "pitch_radius", *friction.NAMES[1:3]}
    assert {key for key, found in seen if not found} >= {"mass", "input_speed", "pitch_radius", "friction_slope"}


def judged(model, drive, key, value, stable) -> bool | None:
    """Hold the stability that a set says of a value against Newton's laws; None where the drive may not have it."""
    try:
        other = drive.replace(**{key: value})
    except InputError:
        return None
    if not spectrum.sliding_law(other):
        return None
    x = math.tan(value) if key == "lead_angle" else value
    said = any(float(low) < x < float(high) for low, high in stable.intervals)
    exact = eigenvalues_of_sliding(other)
    assert said == bool(mpmath.re(exact[-1]) < 0), (key, value, drive)
    return said


def solutions(drive, key):
    """The solutions of the onset, None where there is none."""
    try:
        return drive.threshold("onset", unknown=key).solutions
    except NoThreshold:
        return None


@pytest.mark.parametrize("model", MODELS)
def test_derivatives_of_the_onset(model):
    rng, count = np.random.default_rng(5), 0
    while count < 3:
        drive = drive_with_law(model, rng)
        if not drive.stribeck_rise or not (found := solutions(drive, "axial_force")):
            continue
        count += 1
        root = found[-1]
        assert "stribeck_exponent" not in root.derivatives
        for key in ("stribeck_rise", "stribeck_speed", "friction_slope", "friction_coefficient", "input_speed"):
            step = 1e-5 * getattr(drive, key)
            ends = []
            for way in (1, -1):
                near = solutions(drive.replace(**{key: getattr(drive, key) + way * step}), "axial_force")
                ends.append(min((x.value for x in near), key=lambda value: abs(value - root.value)))
            slope = root.derivatives[key].value
            assert math.isclose(slope, (ends[0] - ends[1]) / (2 * step), rel_tol=1e-5, abs_tol=1e-7 * abs(slope)), key


def test_where_friction_is_cut_off_it_has_no_slope():
    drive = Drive(friction_slope=-3.0, input_speed=40.0, axial_force=50.0)
    assert drive.exact().steady_friction == 0
    report = stability(drive)
    assert report.stable
    assert report.quantities["damping_by_slope"].value == 0
    cut = drive.threshold("onset", unknown="friction_slope").solutions[0]
    assert cut.equation.startswith("μ = 0")
    assert math.isclose(cut.value, -0.218 * math.cos(LEAD) / (RADIUS * 40.0), rel_tol=1e-14)


def test_speeds_at_which_nothing_is_left_of_a_rise():
    """An exponential below all numbers still has its sign."""
    drive = Drive(stribeck_rise=0.1, stribeck_speed=1e-12, stribeck_exponent=2, support_damping=0, input_speed=1e9)
    assert stability(drive).kind.startswith("unstable")
    assert stability(drive.replace(support_damping=1e-30)).kind.startswith("stable")


def test_a_rise_that_is_solved_for_fades_also_where_the_drive_has_none():
    drive = Drive(support_damping=1e-3, axial_force=30, stribeck_speed=0.15)
    assert len({drive.replace(stribeck_rise=x).threshold("onset", "stribeck_rise").value for x in (0.0, 0.01)}) == 1


def test_static_friction_above_sliding_keeps_what_is_not_about_rest():
    drive = Drive(translation_damping=1000, axial_force=35)
    rough = drive.replace(static_friction_coefficient=0.3)
    assert rough.threshold("stick", unknown="axial_force").value == drive.threshold("stick").value
    assert rough.threshold("onset").value == drive.threshold("onset").value
    assert rough.stability() == drive.stability()
    assert Drive(static_friction_coefficient=0.3).cycles().proved == ""
    limits = Drive(static_friction_coefficient=0.3, mass=12).threshold("onset", unknown="friction_coefficient")
    assert [x.value for x in limits.solutions] == [Drive(mass=12).threshold("onset", "friction_coefficient").value]
    assert limits.stable_intervals[-1][0] == 0.0


def test_curves_of_a_law():
    """The onset is where the report changes; curves that hold for constant friction alone are not drawn."""
    drive = Drive(**SEAT, input_speed=10)
    found = boundary_curves(drive, ("mass", (1.0, 14.0)), ("axial_force", (-80.0, 80.0)))
    assert set(found) == {ChartBoundary.ONSET, ChartBoundary.KINEMATIC_CONSTRAINT}
    for kind in found:
        for line in found[kind]:
            for mass, force in line[:: max(1, len(line) // 10)]:
                sides = {
                    drive.replace(mass=mass + a * 1e-6, axial_force=force + b * 1e-6).stability().stable
                    for a, b in ((1, 0), (-1, 0), (0, 1), (0, -1))
                }
                assert sides == {True, False} or kind is ChartBoundary.KINEMATIC_CONSTRAINT, (mass, force)
    forces = {round(force, 3) for line in found[ChartBoundary.ONSET] for mass, force in line if mass < 8}
    assert forces == {64.305, -59.155}


def test_stability_is_asked_within_the_range():
    """Below the least pitch radius, 1e-6 m, this drive would be stable again."""
    drive = threads_drive(
        pitch_radius=0.0425, lead_angle=0.4165, screw_inertia=2.77e-8, coupling_stiffness=14.7, support_damping=1.63e-8,
        friction_coefficient=0.685, input_speed=251.2, mass=3230.6, translation_damping=1650.0, axial_force=141790.0,
        stribeck_rise=0.008, stribeck_speed=0.0555, friction_slope=-0.0535, contact_stiffness=3.56e9,
        contact_damping=0.059,
    )  # fmt: skip
    stable = stable_set(drive, "pitch_radius")
    for value in (1e-6, 1.1e-6, 1e-5, 0.04, 0.05):
        assert judged("threads", drive, "pitch_radius", value, stable) == (value == 0.05)


def test_next_to_nothing_of_a_rise_parts_no_double_roots():
    drive = threads_drive(stribeck_rise=0.01, stribeck_speed=1e-6, contact_damping=0, axial_force=5, input_speed=2.0)
    level = drive.replace(stribeck_rise=0.0, stribeck_speed=0.0)
    for key in ("friction_coefficient", "mass"):
        one, other = (all_thresholds(d, key)["onset"] for d in (drive, level))
        assert one.stable_intervals[:-1] == other.stable_intervals[:-1]
        assert [x.value for x in one.solutions] == [x.value for x in other.solutions]


def test_roots_beside_the_cut_of_a_falling_law_are_found():
    """In 30 digits by another program; unstable between the last two."""
    drive = Drive(friction_slope=-0.1, translation_damping=1000, axial_force=-50)
    found = drive.threshold("onset", "input_speed")
    values = [solution.value for solution in found.solutions]
    assert values == pytest.approx([-90.55144207398037, 323.657252968244251, 418.86232048206784], rel=1e-14)
    assert ["μ = 0" in solution.equation for solution in found.solutions] == [False, False, True]
    assert "reaches zero and is cut off" in found.how
    for speed, stable in ((300.0, True), (350.0, False), (410.0, False), (430.0, True)):
        assert drive.replace(input_speed=speed).stability().stable == stable


def test_friction_that_fades_to_nothing_is_solved():
    """v + 0.5 exp(−v / 0.1) with M = k = 1 (a course): the slope vanishes at v = ln 5 / 10."""
    drive = Drive(
        pitch_radius=1, lead_angle=1e-6, mass=1e-18, axial_force=1000, screw_inertia=1, coupling_stiffness=1,
        support_damping=1, friction_coefficient=0, stribeck_rise=5e-4, stribeck_speed=0.1, input_speed=0.2,
    )  # fmt: skip
    values = [solution.value for solution in drive.threshold("onset", "input_speed").solutions]
    assert values == pytest.approx([-math.log(5) / 10, math.log(5) / 10], rel=1e-8)  # the lead changes it by 1e-9
