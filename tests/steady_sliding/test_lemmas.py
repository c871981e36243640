"""Lemmas 8.1 and 8.2, and what they do not say: the statements of docs/lemmas.md on threads and axial support."""

from decimal import Decimal

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references.classes import growth_rate
from references.companion_roots import roots

from lsvib.drives.coefficients import coefficients
from lsvib.drives.parameters import ThreadsParameters
from lsvib.steady_sliding import conditions, eigenvalues_two_coordinates, linearised, stiff_contact, support_conditions

STIFFNESSES = [1e11, 1e12, 1e13, 1e14]
DAMPINGS = [0.0, 1e3, 1e8]


def exact_growth(drive: ThreadsParameters, law: int) -> mpmath.mpf:
    """Largest real part of the eigenvalues, in 100 digits from exact coefficients."""
    return max(mpmath.re(root) for root in roots(linearised.threads_model(drive.exact(), law).polynomial()))


def factored(drive: ThreadsParameters, law: int) -> list[Decimal]:
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
    drive = ThreadsParameters.of(mass=11.0, contact_stiffness=1e9, contact_damping=1e4, translation_damping=slide)
    polynomial = linearised.threads_model(drive.exact(), law).polynomial()
    for ours, expected in zip(polynomial, factored(drive, law), strict=True):
        assert abs(ours - expected) < Decimal(10) ** -20 * abs(expected)  # Decimal sums outside round to 28 digits


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("mass", [10.2, 11.0, 30.0])
def test_lemma_8_1(mass, stiffness, damping):
    """Γ_0 < 0: the largest real part of the 4 × 4 Jacobian is positive and keeps its digits up to k_c = 1e14."""
    drive = ThreadsParameters.of(mass=mass, contact_stiffness=stiffness, contact_damping=damping)
    assert coefficients(drive).gamma[1] < 0
    growth = float(growth_rate(linearised.threads_model(drive, 1)))
    assert growth > 0
    assert growth == pytest.approx(float(exact_growth(drive, 1)), rel=1e-10)
    if stiffness > stiff_contact.unstable_contact_stiffness(drive):
        assert linearised.threads_model(drive.exact(), 1).polynomial()[2] < 0


@settings(max_examples=150)
@given(
    st.floats(1e-6, 5.0),
    st.sampled_from([0.0, 1e-5, 1e-2]),
    st.sampled_from([0.0, 10.0, 1e3]),
    st.sampled_from([0.0, 1.0, 1e4, 1e8, 1e12]),
)
def test_lemma_8_1_for_any_damping(excess, support_damping, slide, contact_damping):
    """Beyond the stiffness of the proof the sign is certain in decimals, and LAPACK has it too."""
    drive = ThreadsParameters.of(
        support_damping=support_damping, translation_damping=slide, contact_damping=contact_damping, axial_force=1e6
    )
    drive = drive.replace(mass=conditions.critical_mass(drive) * (1 + excess))
    assert linearised.steady_law(drive) == 1
    limit = stiff_contact.unstable_contact_stiffness(drive)
    stiff = drive.replace(contact_stiffness=min(max(2 * limit, 1e3), 1e15))
    assert not eigenvalues_two_coordinates.routh_hurwitz(linearised.threads_model(stiff.exact(), 1).polynomial())
    assert growth_rate(linearised.threads_model(stiff, 1)) > 0


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("mass", [1.0, 9.0, 10.0])
def test_positive_inertia_is_stable_with_contact_damping_only(mass, stiffness):
    drive = ThreadsParameters.of(mass=mass, contact_stiffness=stiffness)
    assert coefficients(drive).gamma[1] > 0
    least = stiff_contact.least_damping_of_stiff_contact(drive)
    for damping, stable in ((0.0, False), (2 * least, True)):
        contact = drive.replace(contact_damping=damping)
        growth = float(growth_rate(linearised.threads_model(contact, 1)))
        exact = float(exact_growth(contact, 1))
        assert (growth < 0, exact < 0) == (stable, stable)
        assert growth == pytest.approx(exact, rel=1e-8)
        assert (
            eigenvalues_two_coordinates.routh_hurwitz(linearised.threads_model(contact.exact(), 1).polynomial())
            is stable
        )


@pytest.mark.parametrize("slide", [0.0, 0.5])
def test_least_contact_damping_is_the_limit(slide):
    drive = ThreadsParameters.of(mass=9.0, contact_stiffness=1e15, translation_damping=slide)
    least = stiff_contact.least_damping_of_stiff_contact(drive)
    verdicts = [
        eigenvalues_two_coordinates.routh_hurwitz(
            linearised.threads_model(drive.replace(contact_damping=least * f).exact(), 1).polynomial()
        )
        for f in (1 - 1e-6, 1 + 1e-6)
    ]
    assert verdicts == [False, True]


def test_elastic_contact_flutters_at_a_rate_that_does_not_depend_on_its_stiffness():
    drive = ThreadsParameters.of(mass=9.0, contact_stiffness=1e14, contact_damping=0.0)
    gamma = float(coefficients(drive).gamma[1])
    expected = drive.support_damping / 2 * (1 / gamma - 1 / drive.screw_inertia)
    assert float(growth_rate(linearised.threads_model(drive, 1))) == pytest.approx(expected, rel=1e-3)
    assert round(expected) == 261


def random_supports(count: int, seed: int = 8) -> dict[str, np.ndarray]:
    """Parameters of the support model, spread over many decades, and friction over its whole valid range."""
    random = np.random.default_rng(seed)
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


def overlaps(count: int) -> tuple[int, np.ndarray]:
    """Number of random drives with mode coupling and kinematic constraint at once, and drives in each class."""
    values = random_supports(count)
    a_4, a_2, a_0 = support_conditions.characteristic_polynomial(values, 1)
    flutter, kinematic = a_2**2 - 4 * a_0 * a_4 < 0, a_4 < 0
    kinds = eigenvalues_two_coordinates.undamped_class(linearised.support_model(values, 1))
    lower, upper = np.moveaxis(support_conditions.flutter_boundaries(values, 1), -1, 0)
    between = (values["support_stiffness"] > lower) & (values["support_stiffness"] < upper)
    near = np.abs(a_2**2 - 4 * a_0 * a_4) < 1e-9 * a_2**2
    assert not (flutter & ~near & ~between).any()
    assert not (between & ~near & ~flutter).any()
    rounded = near | (np.abs(a_4) < 1e-9 * values["screw_inertia"] * (values["mass"] + values["screw_mass"]))
    assert (kinds == support_conditions.printed_class(values, 1))[~rounded].all()
    assert rounded.mean() < 1e-3
    return int((flutter & kinematic).sum() + (between & kinematic).sum()), np.bincount(kinds, minlength=4)


def test_lemma_8_2_over_1e5_random_drives():
    both, counts = overlaps(100_000)
    assert both == 0
    assert counts.min() > 300


@pytest.mark.slow
def test_lemma_8_2_over_1e6_random_drives():
    both, counts = overlaps(1_000_000)
    assert both == 0
    assert counts.min() > 3000
