"""Lemmas 8.1 and 8.2, and what they do not say: the statements of docs/lemmas.md on threads and axial support.

Boundaries of figure 8.15 in 40 digits; eq. (8.33) of the rotating nut.
"""

import mpmath
import numpy as np
import pytest
from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st
from references.classes import damped_class, growth_rate
from references.newton import eigenvalues
from references.parts import nut_drive, support_drive, threads_drive

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.stability import conditions, linear
from lsvib.stability.linear import UndampedClass

STIFFNESSES = [1e11, 1e14]
DAMPINGS = [0.0, 1e3, 1e8]


def exact_growth(drive: Drive, law: int) -> float:
    """Largest real part of the eigenvalues by Newton's laws, in 100 digits."""
    with mpmath.workdps(100):
        return float(max(mpmath.re(z) for z in eigenvalues("threads", drive, law)))


def factored(drive: Drive, law: int) -> list[arb]:
    """The polynomial of docs/lemmas.md, coefficient by coefficient."""
    d, c = drive.exact(), coefficients(drive)
    gamma, damping = c.gamma[law], c.damping[law]
    beta = d.cos_lead * (d.cos_lead + law * d.friction_coefficient * d.sin_lead)
    own, slide = d.screw_inertia, d.translation_damping
    return [
        own * d.mass,
        own * slide + d.mass * d.support_damping + beta * d.contact_damping * gamma,
        d.support_damping * slide
        + d.mass * d.coupling_stiffness
        + beta * (d.contact_stiffness * gamma + d.contact_damping * damping),
        slide * d.coupling_stiffness
        + beta * (d.contact_stiffness * damping + d.contact_damping * d.coupling_stiffness),
        beta * d.contact_stiffness * d.coupling_stiffness,
    ]


@pytest.mark.parametrize("law", [1, -1])
@pytest.mark.parametrize("slide", [0.0, 300.0])
def test_polynomial_of_the_threads_factors_into_the_rigid_drive(law, slide):
    drive = threads_drive(mass=11.0, contact_stiffness=1e9, contact_damping=1e4, translation_damping=slide)
    polynomial = linear.polynomial(drive.exact(), law)
    with many_digits():
        for ours, expected in zip(polynomial, factored(drive, law), strict=True):
            assert abs(ours - expected) < 1e-100 * abs(expected)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("mass", [10.2, 30.0])
def test_lemma_8_1(mass, stiffness, damping):
    """Γ_0 < 0: the largest real part of the 4 × 4 Jacobian is positive and keeps its digits up to k_c = 1e14."""
    drive = threads_drive(mass=mass, contact_stiffness=stiffness, contact_damping=damping)
    assert coefficients(drive).gamma[1] < 0
    growth = float(growth_rate(dict(drive), 1))
    assert growth > 0
    assert growth == pytest.approx(exact_growth(drive, 1), rel=1e-10)
    if stiffness > conditions.unstable_contact_stiffness(drive):
        assert linear.polynomial(drive.exact(), 1)[2] < 0


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("mass", [1.0, 10.0])
def test_positive_inertia_is_stable_with_contact_damping_only(mass, stiffness):
    drive = threads_drive(mass=mass, contact_stiffness=stiffness)
    assert coefficients(drive).gamma[1] > 0
    least = conditions.least_damping_of_stiff_contact(drive)
    for damping, stable in ((0.0, False), (2 * least, True)):
        contact = drive.replace(contact_damping=damping)
        growth = float(growth_rate(dict(contact), 1))
        exact = exact_growth(contact, 1)
        assert (growth < 0, exact < 0) == (stable, stable)
        assert growth == pytest.approx(exact, rel=1e-8)
        assert linear.routh_hurwitz(linear.polynomial(contact.exact(), 1)) is stable


@pytest.mark.parametrize("slide", [0.0, 0.5])
def test_least_contact_damping_is_the_limit(slide):
    drive = threads_drive(mass=9.0, contact_stiffness=1e15, translation_damping=slide)
    least = conditions.least_damping_of_stiff_contact(drive)
    verdicts = [
        linear.routh_hurwitz(linear.polynomial(drive.replace(contact_damping=least * f).exact(), 1))
        for f in (1 - 1e-6, 1 + 1e-6)
    ]
    assert verdicts == [False, True]


def test_elastic_contact_flutters_at_a_rate_that_does_not_depend_on_its_stiffness():
    drive = threads_drive(mass=9.0, contact_stiffness=1e14, contact_damping=0.0)
    gamma = float(coefficients(drive).gamma[1])
    expected = drive.support_damping / 2 * (1 / gamma - 1 / drive.screw_inertia)
    assert float(growth_rate(dict(drive), 1)) == pytest.approx(expected, rel=1e-3)
    assert round(expected) == 261


def random_supports(count: int) -> dict[str, np.ndarray]:
    """Parameters of the support model, spread over many decades, and friction over its whole valid range."""
    random = np.random.default_rng(8)
    ranges = {
        "screw_inertia": (-8, 0),
        "mass": (-2, 4),
        "screw_mass": (-2, 4),
        "coupling_stiffness": (-3, 5),
        "support_stiffness": (2, 12),
        "pitch_radius": (-4, 0),
    }
    values = {key: 10 ** random.uniform(low, high, count) for key, (low, high) in ranges.items()}
    lead = random.uniform(0.005, 1.5, count)
    friction = random.uniform(0, 1, count) ** 2 / np.tan(lead)
    dampings = dict.fromkeys(("support_damping", "translation_damping", "axial_support_damping"), 0.0)
    return {**values, **dampings, "lead_angle": lead, "friction_coefficient": friction}


def test_lemma_8_2_over_1e5_random_drives():
    """Mode coupling and kinematic constraint never occur at once, and flutter is what lies between both branches."""
    values = random_supports(100_000)
    a_4, a_2, a_0 = conditions.characteristic_polynomial(values, 1)
    discriminant = a_2**2 - 4 * a_0 * a_4
    flutter, kinematic, near = discriminant < 0, a_4 < 0, np.abs(discriminant) < 1e-9 * a_2**2
    lower, upper = np.moveaxis(conditions.flutter_boundaries(values, 1), -1, 0)
    between = (values["support_stiffness"] > lower) & (values["support_stiffness"] < upper)
    assert not ((flutter != between) & ~near).any()
    assert not ((flutter | between) & kinematic).any()
    kinds = linear.undamped_class(values, 1)
    rounded = near | (np.abs(a_4) < 1e-9 * values["screw_inertia"] * (values["mass"] + values["screw_mass"]))
    assert (kinds == conditions.printed_class(values, 1))[~rounded].all()
    assert rounded.mean() < 1e-3
    assert np.bincount(kinds, minlength=4).min() > 300


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
