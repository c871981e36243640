"""Linearised models against Newton's laws in 40 digits, eigenvalues, summary; lemmas 8.1 and 8.2.

And what the lemmas do not say: the statements of docs/lemmas.md on threads and axial support, the boundary of mode
coupling in 40 digits, eq. (8.33) of the rotating nut.
"""

import mpmath
import numpy as np
import pytest
from flint import arb, fmpq, fmpq_poly
from hypothesis import example, given, settings
from hypothesis import strategies as st
from references.drives import DRIVES, nut_drive, support_drive, threads_drive
from references.newton import eigenvalues, state_matrix

from lsvib import Drive
from lsvib.drives.mechanics import LinearParts, coefficients
from lsvib.stability import conditions, spectrum
from lsvib.stability.boundaries import place_values
from lsvib.stability.conditions import stability
from lsvib.stability.spectrum import UndampedClass, eigenvalue_pair
from lsvib.systems.exact.arithmetic import many_digits


def growth_rate(values, law: int) -> np.ndarray:
    """Largest real part [1/s] of the eigenvalues; positive where steady sliding is unstable."""
    return spectrum.eigenvalues(values, law)[..., -1].real


def damped_class(values, law: int) -> np.ndarray:
    """Class (:class:`UndampedClass`) of M q″ + C q′ + K q = 0 with C ≠ 0, by its eigenvalues.

    The fastest growing one decides between divergence and flutter; det M < 0 is kinematic whatever the rest.
    """
    fastest = spectrum.eigenvalues(values, law)[..., -1]
    kinds = [UndampedClass.KINEMATIC_CONSTRAINT, UndampedClass.STABLE, UndampedClass.DIVERGENCE]
    negative = np.broadcast_to(np.asarray(spectrum.polynomial(values, law)[0]) < 0, fastest.shape)
    return np.select([negative, fastest.real < 0, fastest.imag == 0], kinds, UndampedClass.FLUTTER)


MODELS = ("nut", "support", "threads")
BEYOND = fmpq(10) ** 400
DAMPED = {"support_damping": 3e-4, "translation_damping": 70.0}
OWN = {
    "threads": {"contact_stiffness": 3e6, "contact_damping": 2e3},
    "support": {"axial_support_damping": 40.0, "support_stiffness": 2e7},
    "nut": {"nut_inertia": 5e-6, "nut_damping": 1e-4, "nut_stiffness": 0.7},
}


@pytest.mark.parametrize("law", [1, -1])
@pytest.mark.parametrize("model", MODELS)
def test_matrices_and_eigenvalues_follow_from_newtons_laws(model, law):
    """In doubles; those of balls are held in test_stability_everywhere.py, polynomials in test_friction_law.py."""
    drive = DRIVES[model].of(mass=7.0, **DAMPED, **OWN[model])
    with mpmath.workdps(60):
        expected = np.array(state_matrix(model, drive, law), dtype=float)
        roots = np.array([complex(root) for root in eigenvalues(model, drive, law)])
    np.testing.assert_allclose(spectrum.state_matrices(dict(drive), law), expected, rtol=1e-13, atol=0)
    values = spectrum.eigenvalues(dict(drive), law)
    assert (np.diff(values.real) >= 0).all()
    assert (np.abs(values / roots[:, None] - 1).min(axis=1) < 1e-11).all()


@pytest.mark.parametrize("model", MODELS)
def test_grids_give_what_single_drives_give(model):
    drive = DRIVES[model].of(**DAMPED, **OWN[model])
    friction, mass = np.array([0.05, 0.2, 0.4]), np.array([1.0, 30.0])
    grid = {**dict(drive), "friction_coefficient": friction[:, None], "mass": mass}
    assert spectrum.state_matrices(grid, 1).shape == (3, 2, 4, 4)
    for i, j in np.ndindex(3, 2):
        one = dict(drive.replace(friction_coefficient=friction[i], mass=mass[j]))
        np.testing.assert_array_equal(spectrum.state_matrices(grid, 1)[i, j], spectrum.state_matrices(one, 1))
        assert damped_class(grid, 1)[i, j] == damped_class(one, 1)
        assert spectrum.undamped_class(grid, 1)[i, j] == spectrum.undamped_class(one, 1)
        assert growth_rate(grid, 1)[i, j] == growth_rate(one, 1)


def test_summary_states_the_conditions():
    report = stability(support_drive(mass=15.0, support_stiffness=1e7))
    assert [name for name, c in report.conditions.items() if c.hold] == ["flutter"]
    assert report.quantities["critical_friction"].value == pytest.approx(0.2848594241193505, rel=1e-14)
    assert stability(nut_drive(mass=6)).conditions["kinematic_constraint"].hold
    assert stability(threads_drive(mass=11)).quantities["least_contact_damping"].value is None


SIGNED = st.floats(1e-12, 1e6) | st.floats(-1e6, -1e-12)


def exact_pair(gamma: float, c: float, k: float) -> list[mpmath.mpc]:
    with mpmath.workdps(60):
        g, c, k = map(mpmath.mpf, (gamma, c, k))
        root = mpmath.sqrt(c * c - 4 * k * g)
        return sorted(((-c - root) / (2 * g), (-c + root) / (2 * g)), key=lambda z: (mpmath.re(z), mpmath.im(z)))


@settings(max_examples=500)
@given(SIGNED, SIGNED | st.just(0.0), st.floats(1e-9, 1e9))
@example(1e-9, 2e-4, 10.0)  # discriminant at the rounding of its two products
@example(2.5e-9, 1e-4, 1.0)
@example(1e-12, 1e6, 1e-9)  # roots 1e33 apart
def test_eigenvalues_keep_all_digits(gamma, c, k):
    pair = eigenvalue_pair(gamma, c, k)
    for ours, exact in zip(pair, exact_pair(gamma, c, k), strict=True):
        with mpmath.workdps(60):
            for mine, theirs in ((ours.real, mpmath.re(exact)), (ours.imag, mpmath.im(exact))):
                assert abs(mpmath.mpf(float(mine)) - theirs) <= 8e-16 * abs(theirs)


def test_limits_of_eigenvalues():
    found = eigenvalue_pair([0.0, 1.0], [2.0, 0.0], [3.0, 0.0])
    np.testing.assert_array_equal(found.real, [[-1.5, np.nan], [0, 0]])


STIFFNESSES = [1e11, 1e14]
DAMPINGS = [0.0, 1e3, 1e8]


def exact_growth(drive: Drive, law: int) -> float:
    """Largest real part of the eigenvalues by Newton's laws, in 100 digits."""
    with mpmath.workdps(100):
        return float(max(mpmath.re(z) for z in eigenvalues("threads", drive, law)))


@pytest.mark.parametrize("law", [1, -1])
@pytest.mark.parametrize("slide", [0.0, 300.0])
def test_polynomial_of_the_threads_factors_into_the_rigid_drive(law, slide):
    """Coefficient by coefficient as in docs/lemmas.md."""
    drive = threads_drive(mass=11.0, contact_stiffness=1e9, contact_damping=1e4, translation_damping=slide)
    d, c, polynomial = drive.exact(), coefficients(drive), spectrum.polynomial(drive.exact(), law)
    with many_digits():
        beta = d.cos_lead * (d.cos_lead + law * d.friction_coefficient * d.sin_lead)
        soft, damper = beta * d.contact_stiffness, beta * d.contact_damping
        gamma, damping, stiffness = c.gamma[law], c.damping[law], d.coupling_stiffness
        expected = [
            d.screw_inertia * d.mass,
            d.screw_inertia * slide + d.mass * d.support_damping + damper * gamma,
            d.support_damping * slide + d.mass * stiffness + soft * gamma + damper * damping,
            slide * stiffness + soft * damping + damper * stiffness,
            soft * stiffness,
        ]
        for ours, theirs in zip(polynomial, expected, strict=True):
            assert abs(ours - theirs) < 1e-100 * abs(theirs)


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
        assert spectrum.polynomial(drive.exact(), 1)[2] < 0


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
        assert (spectrum.spectrum(contact, 1)[0] == "stable") is stable


@pytest.mark.parametrize("slide", [0.0, 0.5])
def test_least_contact_damping_is_the_limit(slide):
    drive = threads_drive(mass=9.0, contact_stiffness=1e15, translation_damping=slide)
    least = conditions.least_damping_of_stiff_contact(drive)
    kinds = [stability(drive.replace(contact_damping=least * f)).stable for f in (1 - 1e-6, 1 + 1e-6)]
    assert kinds == [False, True]


def random_supports(count: int) -> dict[str, np.ndarray]:
    """Parameters of the support model, spread over many decades, and friction over its whole valid range."""
    random = np.random.default_rng(8)
    ranges = {
        "screw_inertia": (-8, 0), "mass": (-2, 4), "screw_mass": (-2, 4), "coupling_stiffness": (-3, 5),
        "support_stiffness": (2, 12), "pitch_radius": (-4, 0),
    }  # fmt: skip
    values = {key: 10 ** random.uniform(low, high, count) for key, (low, high) in ranges.items()}
    lead = random.uniform(0.005, 1.5, count)
    friction = random.uniform(0, 1, count) ** 2 / np.tan(lead)
    dampings = dict.fromkeys(("support_damping", "translation_damping", "axial_support_damping"), 0.0)
    return {**values, **dampings, "lead_angle": lead, "friction_coefficient": friction}


def test_lemma_8_2_over_1e5_random_drives():
    """Mode coupling and kinematic constraint never occur at once; classes are those by signs (8.24 to 8.26)."""
    values = random_supports(100_000)
    a_4, _, minus_a_2, _, a_0 = spectrum.polynomial(values, 1)
    discriminant = minus_a_2**2 - 4 * a_0 * a_4
    flutter, kinematic, near = discriminant < 0, a_4 < 0, np.abs(discriminant) < 1e-9 * minus_a_2**2
    assert not (flutter & kinematic).any()
    kinds = spectrum.undamped_class(values, 1)
    rounded = near | (np.abs(a_4) < 1e-9 * values["screw_inertia"] * (values["mass"] + values["screw_mass"]))
    named = [UndampedClass.KINEMATIC_CONSTRAINT, UndampedClass.FLUTTER, UndampedClass.DIVERGENCE]
    expected = np.select([kinematic, flutter, minus_a_2 < 0], named, UndampedClass.STABLE)
    assert (kinds == expected)[~rounded].all()
    assert rounded.mean() < 1e-3
    assert np.bincount(kinds, minlength=4).min() > 300


@settings(max_examples=100)
@given(st.floats(0.0, 1.0), st.floats(1.0, 100.0), st.floats(0.5, 50.0))
def test_boundaries_solve_the_printed_equation_in_40_digits(part, mass, screw_mass):
    """Lower and upper branch of (8.29) by the quadratic formula, for μ between tan λ and μ_kc; beyond there is none."""
    drive = support_drive(mass=mass, screw_mass=screw_mass)
    low = float(np.tan(drive.lead_angle))
    high = [*place_values(drive, "kinematic_constraint", "friction_coefficient"), 5.0][0]
    for friction in (low * 0.999, *([high * 1.001] if high < 5 else [])):
        assert not branches(drive.replace(friction_coefficient=friction))
    drive = drive.replace(friction_coefficient=low + (0.001 + 0.998 * part) * (high - low))
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
        for branch, exact in zip(branches(drive), expected, strict=True):
            assert abs(branch - exact) <= 2.3e-16 * exact


def branches(drive: Drive) -> list[float]:
    """Support stiffnesses between which the undamped drive flutters."""
    values, tangent = spectrum.enclosed(drive.replace(support_damping=0.0, axial_support_damping=0.0))[0]
    parts = LinearParts.of({**values, "support_stiffness": fmpq_poly([0, 1])}, 1, tangent).level()
    *_, coupling = spectrum.margins(parts.polynomial(), True)
    return [*map(float, map(arb, spectrum.positive_roots(coupling, BEYOND)))]


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
    tan, mu = np.tan(values["lead_angle"]), law * values["friction_coefficient"]
    screw = 1 / (1 / values["screw_inertia"] + 1 / values["nut_inertia"])
    inertia = screw - (mu - tan) / (1 + mu * tan) * tan * values["mass"] * values["pitch_radius"] ** 2
    squares = spectrum.reciprocal_squares(values, law)
    assert (squares.imag == 0).all()
    assert ((squares.real > 0).all(axis=-1) == (inertia > 0)).all()
    clear = np.abs(inertia) > 1e-6 * screw
    kinds = damped_class(values, law)
    assert (kinds == np.where(inertia > 0, UndampedClass.STABLE, UndampedClass.KINEMATIC_CONSTRAINT))[clear].all()
    if law == -1:
        assert (kinds == UndampedClass.STABLE).all()  # ξ_0 > 0 is necessary
    else:
        factor_positive = values["friction_coefficient"] > np.tan(values["lead_angle"])
        assert factor_positive[kinds == UndampedClass.KINEMATIC_CONSTRAINT].all()
        assert (kinds == UndampedClass.KINEMATIC_CONSTRAINT).any()
