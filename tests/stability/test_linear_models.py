"""Linearised models against Newton's laws in 40 digits, their eigenvalues, classes and plain-value summary."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from references.classes import damped_class, growth_rate
from references.newton import eigenvalues, state_matrix
from references.parts import DRIVES as KINDS
from references.parts import nut_drive, support_drive, threads_drive

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.errors import InputError
from lsvib.stability import conditions, linear
from lsvib.stability.conditions import stability
from lsvib.stability.linear import Stability, eigenvalue_pair, stability_class

MODELS = ("nut", "support", "threads")
DAMPED = {"support_damping": 3e-4, "translation_damping": 70.0}
OWN = {
    "threads": {"contact_stiffness": 3e6, "contact_damping": 2e3},
    "support": {"axial_support_damping": 40.0, "support_stiffness": 2e7},
    "nut": {"nut_inertia": 5e-6, "nut_damping": 1e-4, "nut_stiffness": 0.7},
}
_FRICTIONS = st.just(0.0) | st.floats(1e-18, 5.0)


@pytest.mark.parametrize("law", [1, -1])
@pytest.mark.parametrize("model", MODELS)
def test_matrices_eigenvalues_and_polynomial_follow_from_newtons_laws(model, law):
    """The polynomial is held against them in test_stability_everywhere.py; here in balls and floats."""
    drive = KINDS[model].of(mass=7.0, **DAMPED, **OWN[model])
    with mpmath.workdps(60):
        expected = np.array(state_matrix(model, drive, law), dtype=float)
        roots = np.array([complex(root) for root in eigenvalues(model, drive, law)])
    np.testing.assert_allclose(linear.state_matrices(dict(drive), law), expected, rtol=1e-13, atol=0)
    values = linear.eigenvalues(dict(drive), law)
    assert (np.diff(values.real) >= 0).all()
    assert (np.abs(values / roots[:, None] - 1).min(axis=1) < 1e-11).all()
    exact, floats = ([float(p) for p in linear.polynomial(own, law)] for own in (drive.exact(), drive))
    np.testing.assert_allclose(floats, exact, rtol=1e-12)


@pytest.mark.parametrize("model", MODELS)
def test_grids_give_what_single_drives_give(model):
    drive = KINDS[model].of(**DAMPED, **OWN[model])
    friction, mass = np.array([0.05, 0.2, 0.4]), np.array([1.0, 30.0])
    grid = {**dict(drive), "friction_coefficient": friction[:, None], "mass": mass}
    assert linear.state_matrices(grid, 1).shape == (3, 2, 4, 4)
    for i, j in np.ndindex(3, 2):
        one = dict(drive.replace(friction_coefficient=friction[i], mass=mass[j]))
        np.testing.assert_array_equal(linear.state_matrices(grid, 1)[i, j], linear.state_matrices(one, 1))
        assert damped_class(grid, 1)[i, j] == damped_class(one, 1)
        assert linear.undamped_class(grid, 1)[i, j] == linear.undamped_class(one, 1)
        assert growth_rate(grid, 1)[i, j] == growth_rate(one, 1)


@settings(max_examples=200)
@given(_FRICTIONS, st.floats(0.1, 50.0), st.floats(0.1, 50.0), st.floats(3.0, 11.0), st.sampled_from([1, -1]))
def test_generalised_eigenvalues_keep_their_digits(friction, mass, screw_mass, power, law):
    drive = support_drive(
        friction_coefficient=friction, mass=mass, screw_mass=screw_mass, support_stiffness=10.0**power
    )
    squares = linear.reciprocal_squares(dict(drive), law)
    undamped = drive.replace(support_damping=0.0, axial_support_damping=0.0)
    p_4, _, p_2, _, p_0 = linear.polynomial(undamped.exact(), law)
    with mpmath.workdps(40):
        whole, middle, last = (mpmath.mpf(x.str(60, radius=False)) for x in (p_4, p_2, p_0))
        trace, det = middle / last, whole / last
        gap = mpmath.sqrt(trace * trace / 4 - det)
        expected = [trace / 2 - gap, trace / 2 + gap]
        # The sensitivity of 1/ω² to rounding of the entries grows where both coincide, and where Γ is a small
        # difference of terms of which the larger one is the inertia of the screw.
        size = max(*(abs(x) for x in expected), drive.screw_inertia / drive.coupling_stiffness)
        reach = 1e-14 * size * (1 + size / abs(gap))
        error = min(
            max(abs(mpmath.mpc(complex(a)) - b) for a, b in zip(pair, expected, strict=True))
            for pair in (squares, squares[::-1])
        )
        assert error < reach + mpmath.mpf(1e-7) * size * (abs(gap) < 1e-7 * size)


@pytest.mark.parametrize("law", [1, -1])
def test_printed_polynomial_is_that_of_the_matrices(law):
    drive = support_drive(mass=15.0, support_damping=0.0)
    p_4, _, p_2, _, p_0 = linear.polynomial(drive.exact(), law)
    printed = conditions.characteristic_polynomial(drive.exact(), law)
    with many_digits():
        assert all(abs(a - b) < 1e-100 * abs(b) for a, b in zip((p_4, -p_2, p_0), printed, strict=True))


def test_steady_law_counts_the_friction_of_the_slide():
    drive = support_drive(axial_force=10.0)
    assert linear.steady_law(drive) == 1
    assert linear.steady_law(drive.replace(slide_friction=11.0)) == -1
    assert linear.steady_law(drive.replace(slide_friction=11.0, input_speed=-40.0)) == -1
    assert linear.steady_law(drive.replace(axial_force=-10.0)) == -1
    with pytest.raises(InputError, match="the contact carries no force"):
        linear.steady_law(drive.replace(slide_friction=10.0))


@pytest.mark.parametrize(
    ("model", "changes", "kind"),
    [
        ("threads", {"mass": 9.0}, "stable"),
        ("threads", {"mass": 11.0}, "divergence"),
        ("threads", {"mass": 9.0, "contact_damping": 0.0}, "flutter"),
        ("threads", {"mass": 9.0, "contact_damping": 5e4}, "flutter"),
        ("support", {"mass": 15.0, "support_damping": 0.0}, "neutral"),
        ("support", {"mass": 15.0, "support_damping": 0.0, "support_stiffness": 1e7}, "flutter"),
        (
            "support",
            {"mass": 15.0, "support_damping": 0, "support_stiffness": 1e9, "friction_coefficient": 0.25},
            "divergence",
        ),
        ("support", {"mass": 15.0, "friction_coefficient": 0.3}, "kinematic_constraint"),
        ("nut", {"mass": 5.0}, "stable"),
        ("nut", {"mass": 5.1}, "kinematic_constraint"),
    ],
)
def test_summary(model, changes, kind):
    report = stability(KINDS[model].of(changes))
    assert (report.kind, report.stable) == (kind, kind == "stable")
    assert len(report.eigenvalues) == 4
    parts = [value.real for value in report.eigenvalues]
    assert parts == sorted(parts)
    largest = max(map(abs, report.eigenvalues))
    assert (parts[-1] > 1e-9 * largest) is (kind not in ("stable", "neutral"))
    assert (parts[-1] == 0) is (kind == "neutral")


def test_summary_states_the_conditions():
    report = stability(support_drive(mass=15.0, support_stiffness=1e7))
    assert [name for name, c in report.conditions.items() if c.hold] == ["flutter"]
    assert report.quantities["critical_friction"].value == pytest.approx(0.2848594241193505, rel=1e-14)
    undamped = report.without_damping
    assert undamped.kind == "flutter"
    assert [name for name, c in undamped.conditions.items() if c.hold] == ["mode_coupling"]
    lower, upper = (undamped.quantities[f"{name}_flutter_stiffness"].value for name in ("lower", "upper"))
    assert lower < 1e7 < upper
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


@settings(max_examples=300)
@given(SIGNED, SIGNED, st.floats(1e-9, 1e9))
def test_class_follows_the_signs(gamma, c, k):
    """Stable exactly if Γ_0 > 0 and C_0 > 0; focus exactly if C_0² < 4kΓ_0, decided here in rational numbers."""
    kind = Stability(int(stability_class(gamma, c, k)))
    if gamma < 0:
        assert kind is Stability.SADDLE
        return
    focus = Fraction(c) ** 2 < 4 * Fraction(k) * Fraction(gamma)
    name = ("STABLE" if c > 0 else "UNSTABLE") + ("_FOCUS" if focus else "_NODE")
    assert kind.name == name


def test_limits_of_eigenvalues_and_classes():
    assert stability_class(1.0, 0.0, 1.0) == Stability.CENTRE
    assert stability_class(1.0, 2.0, 1.0) == Stability.STABLE_NODE
    assert stability_class(0.0, 1.0, 1.0) == Stability.DEGENERATE
    first, second = eigenvalue_pair(0.0, 2.0, 3.0)
    assert first == -1.5
    assert np.isnan(second.real)
    assert list(eigenvalue_pair(1.0, 0.0, 0.0)) == [0, 0]
