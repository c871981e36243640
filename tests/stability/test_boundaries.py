"""Boundaries of figure 8.15 and its critical friction in 40 digits; eq. (8.33) of the rotating nut."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references.classes import damped_class
from references.parts import nut_drive, support_drive

from lsvib.models.drive import Drive
from lsvib.stability import conditions, linear
from lsvib.stability.linear import UndampedClass


@settings(max_examples=100)
@given(st.floats(0.0, 1.0), st.floats(1.0, 100.0), st.floats(0.5, 50.0))
def test_boundaries_solve_the_printed_equation_in_40_digits(part, mass, screw_mass):
    """Lower and upper branch of (8.29) by the quadratic formula, for μ between tan λ and μ_kc."""
    drive = support_drive(mass=mass, screw_mass=screw_mass)
    low = float(np.tan(drive.lead_angle))
    high = conditions.critical_value(drive, "friction_coefficient") or 5.0
    drive = drive.replace(friction_coefficient=low + (0.001 + 0.998 * part) * (high - low))
    branches = conditions.flutter_boundaries(drive, 1)
    with mpmath.workdps(40):
        p = {key: mpmath.mpf(value) for key, value in drive}
        tan = mpmath.tan(p["lead_angle"])
        factor = (p["friction_coefficient"] - tan) / (1 + p["friction_coefficient"] * tan)
        turned = factor * p["mass"] * p["pitch_radius"] ** 2 * tan
        inertia, total = p["screw_inertia"], p["mass"] + p["screw_mass"]
        b_1 = (inertia - turned) ** 2
        b_2 = 2 * (p["screw_mass"] * (turned - inertia) - p["mass"] * (turned + inertia))
        b_3 = total**2
        discriminant = b_2**2 - 4 * b_1 * b_3
        reduced = inertia - turned * p["screw_mass"] / total
        assert mpmath.almosteq(discriminant, 16 * turned * p["mass"] * total * reduced, rel_eps=1e-25)  # above (8.32)
        assert b_2 < 0
        k = p["coupling_stiffness"]
        expected = [k * (-b_2 + sign * mpmath.sqrt(discriminant)) / (2 * b_1) for sign in (-1, 1)]
        # both branches depend on the square root of Γ̃_0, the upper one on 1/Γ_0², which magnify rounding of μ
        for branch, exact in zip(branches, expected, strict=True):
            magnified = inertia / reduced + inertia / abs(inertia - turned)
            assert abs(branch - exact) <= 1e-14 * magnified * exact


def test_boundaries_end_where_they_should():
    drive = support_drive(mass=15.0)
    below, beyond = np.tan(drive.lead_angle) * 0.999, conditions.critical_value(drive, "friction_coefficient") * 1.001
    for friction in (below, beyond):
        assert np.isnan(conditions.flutter_boundaries(drive.replace(friction_coefficient=friction), 1)).all()
    start = conditions.flutter_boundaries(drive.replace(friction_coefficient=below / 0.999 * (1 + 1e-12)), 1)
    np.testing.assert_allclose(start, 26.6 / drive.screw_inertia, rtol=1e-4)
    end = conditions.flutter_boundaries(drive.replace(friction_coefficient=beyond / 1.001 * (1 - 1e-13)), 1)
    np.testing.assert_allclose(end, 26.6**2 * (15 * 11.6 / 26.6) / (15**2 * drive.screw_inertia), rtol=1e-4)
    assert np.isnan(conditions.flutter_boundaries(drive, -1)).all()


def random_nuts(count: int) -> dict[str, np.ndarray]:
    random = np.random.default_rng(33)
    values = {key: 10 ** random.uniform(-7, -4, count) for key in ("screw_inertia", "nut_inertia")}
    values |= {key: 10 ** random.uniform(-2, 3, count) for key in ("coupling_stiffness", "nut_stiffness")}
    values |= {key: 10 ** random.uniform(-5, -2, count) for key in ("support_damping", "nut_damping")}
    lead = random.uniform(0.02, 0.5, count)
    values |= {"mass": 10 ** random.uniform(-1, 2, count), "lead_angle": lead, "pitch_radius": np.full(count, 5.18e-3)}
    return {**values, "friction_coefficient": random.uniform(0, 1, count), "translation_damping": 0.0}


@pytest.mark.parametrize("law", [1, -1])
def test_rotating_nut_is_unstable_exactly_by_8_33(law):
    """No flutter by symmetry, no divergence as det K > 0, with damping and without (20000 random drives)."""
    values = random_nuts(20_000)
    inertia = conditions.effective_inertia(values, law)
    squares = linear.reciprocal_squares(values, law)
    assert (squares.imag == 0).all()
    assert ((squares.real > 0).all(axis=-1) == (inertia > 0)).all()
    clear = np.abs(inertia) > 1e-6 * conditions.screw_inertia(values)
    kinds = damped_class(values, law)
    assert (kinds == np.where(inertia > 0, UndampedClass.STABLE, UndampedClass.KINEMATIC_CONSTRAINT))[clear].all()
    if law == -1:
        assert (kinds == UndampedClass.STABLE).all()  # ξ_0 > 0 is necessary
    else:
        factor_positive = values["friction_coefficient"] > np.tan(values["lead_angle"])
        assert factor_positive[kinds == UndampedClass.KINEMATIC_CONSTRAINT].all()
        assert (kinds == UndampedClass.KINEMATIC_CONSTRAINT).any()


def test_rotation_of_the_nut_lowers_the_critical_mass():
    """Remark 8.6; and a very heavy nut is the rigid drive."""
    rigid = conditions.critical_value(Drive(), "mass")
    masses = [conditions.critical_value(nut_drive(nut_inertia=x), "mass") for x in (1e-7, 3.12e-6, 1e-4, 1e3)]
    assert masses == sorted(masses)
    assert masses[1] == pytest.approx(rigid / 2, rel=1e-14)
    assert masses[-1] == pytest.approx(rigid, rel=1e-8)
    assert masses[-1] < rigid
    assert conditions.critical_value(nut_drive(friction_coefficient=0.05), "mass") is None
