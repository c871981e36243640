"""Lemmas 8.1 and 8.2, the boundaries of figure 8.15, and eq. (8.33): what docs/lemmas.md states."""

from decimal import Decimal

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lsvib.analysis import conditions, modes, nut, support, threads
from lsvib.analysis.modes import Mode
from lsvib.models import linear
from lsvib.models.coefficients import coefficients
from lsvib.models.parameters import LeadScrew, NutDrive, SupportDrive, ThreadsDrive
from reference.roots import roots

STIFFNESSES = [1e11, 1e12, 1e13, 1e14]
DAMPINGS = [0.0, 1e3, 1e8]


def exact_growth(drive: ThreadsDrive, law: int) -> mpmath.mpf:
    """Largest real part of the eigenvalues, in 100 digits from exact coefficients."""
    return max(mpmath.re(root) for root in roots(linear.threads_model(drive, law, exact=True).polynomial()))


def factored(drive: ThreadsDrive, law: int) -> list[Decimal]:
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
    drive = ThreadsDrive.of(mass=11.0, contact_stiffness=1e9, contact_damping=1e4, translation_damping=slide)
    polynomial = linear.threads_model(drive, law, exact=True).polynomial()
    for ours, expected in zip(polynomial, factored(drive, law), strict=True):
        assert abs(ours - expected) < Decimal(10) ** -20 * abs(expected)  # Decimal sums outside round to 28 digits


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("mass", [10.2, 11.0, 30.0])
def test_lemma_8_1(mass, stiffness, damping):
    """Γ_0 < 0: the largest real part of the 4 × 4 Jacobian is positive and keeps its digits up to k_c = 1e14."""
    drive = ThreadsDrive.of(mass=mass, contact_stiffness=stiffness, contact_damping=damping)
    assert coefficients(drive).gamma[1] < 0
    growth = float(modes.growth_rate(linear.threads_model(drive, 1)))
    assert growth > 0
    assert growth == pytest.approx(float(exact_growth(drive, 1)), rel=1e-10)
    if stiffness > threads.unstable_contact_stiffness(drive):
        assert linear.threads_model(drive, 1, exact=True).polynomial()[2] < 0


@settings(max_examples=150)
@given(
    st.floats(1e-6, 5.0),
    st.sampled_from([0.0, 1e-5, 1e-2]),
    st.sampled_from([0.0, 10.0, 1e3]),
    st.sampled_from([0.0, 1.0, 1e4, 1e8, 1e12]),
)
def test_lemma_8_1_for_any_damping(excess, support_damping, slide, contact_damping):
    """Beyond the stiffness of the proof the sign is certain in decimals, and LAPACK has it too."""
    drive = ThreadsDrive.of(
        support_damping=support_damping, translation_damping=slide, contact_damping=contact_damping, axial_force=1e6
    )
    drive = drive.replace(mass=conditions.critical_mass(drive) * (1 + excess))
    assert linear.steady_law(drive) == 1
    limit = threads.unstable_contact_stiffness(drive)
    stiff = drive.replace(contact_stiffness=min(max(2 * limit, 1e3), 1e15))
    assert not modes.routh_hurwitz(linear.threads_model(stiff, 1, exact=True).polynomial())
    assert modes.growth_rate(linear.threads_model(stiff, 1)) > 0


@pytest.mark.parametrize("stiffness", STIFFNESSES)
@pytest.mark.parametrize("mass", [1.0, 9.0, 10.0])
def test_positive_inertia_is_stable_with_contact_damping_only(mass, stiffness):
    drive = ThreadsDrive.of(mass=mass, contact_stiffness=stiffness)
    assert coefficients(drive).gamma[1] > 0
    least = threads.least_contact_damping(drive)
    for damping, stable in ((0.0, False), (1.05 * least, True)):
        contact = drive.replace(contact_damping=damping)
        growth = float(modes.growth_rate(linear.threads_model(contact, 1)))
        exact = float(exact_growth(contact, 1))
        assert (growth < 0, exact < 0) == (stable, stable)
        assert growth == pytest.approx(exact, rel=1e-8)
        assert modes.routh_hurwitz(linear.threads_model(contact, 1, exact=True).polynomial()) is stable


@pytest.mark.parametrize("slide", [0.0, 0.5])
def test_least_contact_damping_is_the_limit(slide):
    drive = ThreadsDrive.of(mass=9.0, contact_stiffness=1e15, translation_damping=slide)
    least = threads.least_contact_damping(drive)
    verdicts = [
        modes.routh_hurwitz(
            linear.threads_model(drive.replace(contact_damping=least * f), 1, exact=True).polynomial()
        )
        for f in (1 - 1e-6, 1 + 1e-6)
    ]
    assert verdicts == [False, True]


def test_elastic_contact_flutters_at_a_rate_that_does_not_depend_on_its_stiffness():
    drive = ThreadsDrive.of(mass=9.0, contact_stiffness=1e14, contact_damping=0.0)
    gamma = float(coefficients(drive).gamma[1])
    expected = drive.support_damping / 2 * (1 / gamma - 1 / drive.screw_inertia)
    assert float(modes.growth_rate(linear.threads_model(drive, 1))) == pytest.approx(expected, rel=1e-3)
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
    a_4, a_2, a_0 = support.characteristic_polynomial(values, 1)
    flutter, kinematic = a_2**2 - 4 * a_0 * a_4 < 0, a_4 < 0
    kinds = modes.undamped_class(linear.support_model(values, 1))
    lower, upper = np.moveaxis(support.flutter_boundaries(values, 1), -1, 0)
    between = (values["support_stiffness"] > lower) & (values["support_stiffness"] < upper)
    near = np.abs(a_2**2 - 4 * a_0 * a_4) < 1e-9 * a_2**2
    assert not (flutter & ~near & ~between).any()
    assert not (between & ~near & ~flutter).any()
    rounded = near | (np.abs(a_4) < 1e-9 * values["screw_inertia"] * (values["mass"] + values["screw_mass"]))
    assert (kinds == support.printed_class(values, 1))[~rounded].all()
    assert rounded.mean() < 1e-3
    return int((flutter & kinematic).sum() + (between & kinematic).sum()), np.bincount(kinds, minlength=4)


def test_lemma_8_2_over_1e5_random_drives():
    both, counts = overlaps(100_000)
    assert both == 0
    assert counts.min() > 1000


@pytest.mark.slow
def test_lemma_8_2_over_1e6_random_drives():
    both, counts = overlaps(1_000_000)
    assert both == 0
    assert counts.min() > 10_000


@settings(max_examples=100)
@given(st.floats(0.0, 1.0), st.floats(1.0, 100.0), st.floats(0.5, 50.0))
def test_boundaries_solve_the_printed_equation_in_40_digits(part, mass, screw_mass):
    """Lower and upper branch of (8.29) by the quadratic formula, for μ between tan λ and μ_kc."""
    drive = SupportDrive.of(mass=mass, screw_mass=screw_mass)
    low = float(np.tan(drive.lead_angle))
    high = conditions.critical_friction(drive, screw_mass) or 5.0
    drive = drive.replace(friction_coefficient=low + (0.001 + 0.998 * part) * (high - low))
    branches = support.flutter_boundaries(drive, 1)
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
    drive = SupportDrive.of(mass=15.0)
    below, beyond = np.tan(drive.lead_angle) * 0.999, conditions.critical_friction(drive, 11.6) * 1.001
    for friction in (below, beyond):
        assert np.isnan(support.flutter_boundaries(drive.replace(friction_coefficient=friction), 1)).all()
    start = support.flutter_boundaries(drive.replace(friction_coefficient=below / 0.999 * (1 + 1e-12)), 1)
    np.testing.assert_allclose(start, 26.6 / drive.screw_inertia, rtol=1e-4)
    end = support.flutter_boundaries(drive.replace(friction_coefficient=beyond / 1.001 * (1 - 1e-13)), 1)
    np.testing.assert_allclose(end, 26.6**2 * (15 * 11.6 / 26.6) / (15**2 * drive.screw_inertia), rtol=1e-4)
    assert np.isnan(support.flutter_boundaries(drive, -1)).all()


@pytest.mark.threshold
@pytest.mark.parametrize("screw_mass", [11.6, 3.0, 400.0])
def test_critical_friction_to_12_digits(screw_mass):
    """Fig. 8.15: μ_kc ≈ 0.285 for m_1 = 11.6 kg; closed form, eigenvalues and a root in 40 digits agree."""
    drive = SupportDrive.of(mass=15.0, screw_mass=screw_mass)
    closed = conditions.critical_friction(drive, screw_mass)
    assert support.critical_friction_by_eigenvalues(drive) == pytest.approx(closed, rel=1e-12)
    with mpmath.workdps(40):

        def smallest(friction):
            tan = mpmath.tan(mpmath.mpf(drive.lead_angle))
            factor = (friction - tan) / (1 + friction * tan)
            r, m = mpmath.mpf(drive.pitch_radius), mpmath.mpf(drive.mass)
            mass = mpmath.matrix(
                [
                    [drive.screw_inertia - factor * m * r**2 * tan, -factor * r * m],
                    [m * r * tan, m + mpmath.mpf(screw_mass)],
                ]
            )
            stiffness = mpmath.matrix([[drive.coupling_stiffness, 0], [0, drive.support_stiffness]])
            return min(mpmath.re(x) for x in mpmath.eig(mpmath.inverse(stiffness) * mass, right=False))

        root = mpmath.findroot(smallest, (closed * 0.999, closed * 1.001), solver="anderson", tol=1e-60)
        assert abs(root / closed - 1) < 1e-15
    if screw_mass == 11.6:
        assert closed == pytest.approx(0.285, rel=0.02)


def test_no_critical_friction_where_the_reduced_mass_is_too_small():
    drive = SupportDrive.of(mass=0.01, screw_mass=0.01)
    assert conditions.critical_friction(drive, 0.01) is None
    assert support.critical_friction_by_eigenvalues(drive) is None


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
    model = linear.nut_model(values, law)
    inertia = nut.kinematic_inertia(values, law)
    squares = modes.reciprocal_squares(model)
    assert (squares.imag == 0).all()
    assert ((squares.real > 0).all(axis=-1) == (inertia > 0)).all()
    clear = np.abs(inertia) > 1e-6 * nut.effective_screw_inertia(values)
    kinds = modes.damped_class(model)
    assert (kinds == np.where(inertia > 0, Mode.STABLE, Mode.KINEMATIC))[clear].all()
    if law == -1:
        assert (kinds == Mode.STABLE).all()  # ξ_0 > 0 is necessary
    else:
        factor_positive = values["friction_coefficient"] > np.tan(values["lead_angle"])
        assert factor_positive[kinds == Mode.KINEMATIC].all()
        assert (kinds == Mode.KINEMATIC).any()


def test_rotation_of_the_nut_lowers_the_critical_mass():
    """Remark 8.6; and a very heavy nut is the rigid drive."""
    rigid = conditions.critical_mass(LeadScrew())
    masses = [nut.critical_mass(NutDrive.of(nut_inertia=x)) for x in (1e-7, 3.12e-6, 1e-4, 1e3)]
    assert masses == sorted(masses)
    assert masses[1] == pytest.approx(rigid / 2, rel=1e-14)
    assert masses[-1] == pytest.approx(rigid, rel=1e-8)
    assert masses[-1] < rigid
    assert nut.critical_mass(NutDrive.of(friction_coefficient=0.05)) is None


def test_damping_of_the_slide_can_make_the_nut_oscillate_without_8_33():
    drive = NutDrive.of(mass=4.0, translation_damping=1e3)
    assert nut.kinematic_inertia(drive, 1) > 0
    assert modes.damped_class(linear.nut_model(drive, 1)) == Mode.FLUTTER
