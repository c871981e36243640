"""Boundaries of stability of damped drives: the table of docs/lemmas.md, 12 digits, and what contradicted itself."""

import json
import math
import re
from fractions import Fraction
from pathlib import Path

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references.newton import eigenvalues, is_stable, steady_law

from lsvib.drives.parameters import NutParameters, RigidParameters, SupportParameters, ThreadsParameters
from lsvib.engine.exact.polynomials import multiplied
from lsvib.errors import InputError
from lsvib.steady_sliding import boundaries, characteristic, linearised, real_roots, spectrum, stiff_contact
from lsvib.steady_sliding.stability_table import stability_table
from lsvib.steady_sliding.threshold_table import threshold_table

LEMMAS = (Path(__file__).parents[2] / "docs" / "lemmas.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (1e\d+) \| ([\d.]+) \|$", LEMMAS, re.MULTILINE)
KINDS = {"threads": ThreadsParameters, "support": SupportParameters, "nut": NutParameters}


def boundary(model: str, drive: RigidParameters, key: str, low: float, high: float) -> mpmath.mpf:
    """Place between low and high at which the stability by Newton's laws changes, by bisection to 25 digits."""

    class At:
        """The drive with one parameter in many digits."""

        def __init__(self, value: mpmath.mpf) -> None:
            self.values = {**dict(drive), key: value}

        def __iter__(self):
            return iter(self.values.items())

    with mpmath.workdps(60):
        low, high, law = mpmath.mpf(low), mpmath.mpf(high), steady_law(drive)
        before = is_stable(model, At(low), law)
        assert is_stable(model, At(high), law) is not before
        for _ in range(90):
            middle = (low + high) / 2
            low, high = (middle, high) if is_stable(model, At(middle), law) is before else (low, middle)
        return low


@pytest.mark.parametrize(("stiffness", "printed"), ROWS)
def test_table_of_the_least_contact_damping(stiffness, printed):
    changes = {"mass": 9.0, "contact_stiffness": float(stiffness)}
    entry = threshold_table(changes, "threads")["least_contact_damping"]
    assert f"{entry['value']:.6g}" == printed
    assert entry["stable_intervals"] == [{"low": entry["value"], "high": None}]
    exact = boundary(
        "threads", ThreadsParameters.of(changes), "contact_damping", float(printed) / 2, float(printed) * 2
    )
    assert abs(entry["value"] / exact - 1) < 2e-16


def test_the_table_has_five_stiffnesses_and_the_limit():
    assert [float(stiffness) for stiffness, _ in ROWS] == [1e6, 1e7, 1e8, 1e9, 1e10]
    (printed,) = re.findall(r"^\| → ∞ \| ([\d.]+) \|$", LEMMAS, re.MULTILINE)
    drive = ThreadsParameters.of(mass=9.0)
    limit = stiff_contact.least_damping_of_stiff_contact(drive)
    assert f"{limit:.6g}" == printed
    stiff = threshold_table({"mass": 9.0, "contact_stiffness": 1e15}, "threads")["least_contact_damping"]
    assert stiff["value"] == pytest.approx(limit, rel=1e-5)


def test_class_conditions_and_quantities_of_the_soft_contact_agree():
    """m = 9 kg, k_c = 1e8, c_c = 5e4: flutter, though c_c lies above the bound of the limit k_c → ∞."""
    changes = {"mass": 9.0, "contact_stiffness": 1e8, "contact_damping": 5e4}
    table = stability_table(changes, "threads")
    assert (table["stable"], table["class"]) == (False, "flutter")
    with mpmath.workdps(60):
        growth = mpmath.re(eigenvalues("threads", ThreadsParameters.of(changes), 1)[-1])
    assert table["eigenvalues"][-1]["real"] == pytest.approx(float(growth), rel=1e-15)
    assert round(table["eigenvalues"][-1]["real"]) == 553
    assert table["conditions"]["contact_flutter"]["hold"] is True
    assert table["quantities"]["least_damping_of_stiff_contact"]["value"] < 5e4
    assert table["quantities"]["least_contact_damping"]["value"] > 5e4


BOUNDARIES = [
    ("threads", {"contact_damping": 5e4}, "critical_mass", "mass"),
    ("threads", {"mass": 9.0, "contact_damping": 5e4}, "critical_friction", "friction_coefficient"),
    ("threads", {"mass": 9.0, "translation_damping": 0.3}, "least_contact_damping", "contact_damping"),
    ("support", {"axial_support_damping": 20.0}, "critical_mass", "mass"),
    ("support", {"mass": 15.0, "axial_support_damping": 20.0}, "critical_friction", "friction_coefficient"),
    ("support", {"mass": 15.0}, "least_axial_support_damping", "axial_support_damping"),
    ("nut", {"translation_damping": 100.0}, "critical_mass", "mass"),
    ("nut", {"translation_damping": 1000.0}, "critical_friction", "friction_coefficient"),
    ("nut", {"support_damping": 1e-5, "translation_damping": 40.0}, "least_nut_damping", "nut_damping"),
]


@pytest.mark.parametrize(("model", "changes", "name", "key"), BOUNDARIES)
def test_boundaries_to_the_last_digit(model, changes, name, key):
    entry = threshold_table(changes, model)[name]
    exact = boundary(model, KINDS[model].of(changes), key, entry["value"] * 0.999, entry["value"] * 1.001)
    assert abs(entry["value"] / exact - 1) < 2e-16
    assert json.dumps(entry, allow_nan=False)


def test_boundaries_of_undamped_drives_are_those_of_real_frequencies():
    """μ_kc of figure 8.15 (eq. 8.28); and between the branches of (8.29) no friction of the gap is stable."""
    undamped = {"mass": 15.0, "support_damping": 0.0}
    entry = threshold_table(undamped, "support")["critical_friction"]
    assert entry["stability"] == "neutral"
    assert entry["value"] == pytest.approx(0.2848594241193505, rel=1e-15)
    table = stability_table(undamped, "support")
    assert (table["stable"], table["class"]) == (False, "neutral")
    assert {value["real"] for value in table["eigenvalues"]} == {0.0}
    assert not any(condition["hold"] for condition in table["conditions"].values())


def test_a_set_of_several_intervals_is_told_in_full():
    """A soft support, undamped: small and large friction are stable, mode coupling lies between."""
    changes = {"mass": 15.0, "support_damping": 0.0, "support_stiffness": 1e7, "friction_coefficient": 0.1}
    entry = threshold_table(changes, "support")["critical_friction"]
    assert entry["value"] == entry["stable_intervals"][-1]["high"]
    middle = [(interval["low"] + interval["high"]) / 2 for interval in entry["stable_intervals"]]
    gaps = [
        (a["high"] + b["low"]) / 2
        for a, b in zip(entry["stable_intervals"], entry["stable_intervals"][1:], strict=False)
    ]
    kinds = [stability_table({**changes, "friction_coefficient": x}, "support")["class"] for x in middle + gaps]
    assert kinds == ["neutral"] * len(middle) + ["flutter"] * len(gaps)


def test_a_mode_that_no_damping_reaches_is_neutral():
    """A nut like the screw, damped by the slide alone: both turn together, and nothing slides."""
    changes = {"support_damping": 0.0, "nut_damping": 0.0, "translation_damping": 3.0, "friction_coefficient": 0.05}
    table = stability_table(changes, "nut")
    assert (table["stable"], table["class"]) == (False, "neutral")
    rate = math.sqrt(1.0 / 3.12e-6)
    assert [value["real"] for value in table["eigenvalues"]][-2:] == [0.0, 0.0]
    assert table["eigenvalues"][-1]["imaginary"] == pytest.approx(rate, rel=1e-14)
    assert threshold_table(changes, "nut")["critical_mass"]["stable_intervals"] == []
    growing = stability_table({**changes, "friction_coefficient": 0.5}, "nut")
    assert growing["class"] == "flutter"
    least = threshold_table(changes, "nut")["least_nut_damping"]
    assert (least["value"], least["reason"][-24:]) == (0.0, "above zero, however small"[-23:] + ".")


@pytest.mark.parametrize(
    ("changes", "kind"),
    [({}, "centre"), ({"friction_coefficient": math.tan(math.radians(5.57))}, "centre"), ({"mass": 11.0}, "saddle")],
)
def test_undamped_rigid_drive(changes, kind):
    table = stability_table({"support_damping": 0.0, **changes})
    assert (table["class"], table["stable"]) == (kind, False)
    assert [x["real"] for x in table["eigenvalues"]] == [0.0, 0.0] or kind == "saddle"
    assert any(condition["hold"] for condition in table["conditions"].values()) is (kind == "saddle")


def test_eigenvalues_keep_their_signs_where_rates_lie_far_apart():
    """Contact rates of 1e14 1/s beside a decay of 1e-6 1/s, which LAPACK loses."""
    changes = {
        "contact_stiffness": 1e15,
        "contact_damping": 1e12,
        "support_damping": 5e-12,
        "friction_coefficient": 0.05,
    }
    table = stability_table(changes, "threads")
    assert table["stable"]
    real = [x["real"] for x in table["eigenvalues"]]
    assert real[0] < -1e11
    assert -1e-5 < real[-1] < 0


def test_repeated_eigenvalues_are_found():
    """I_2 = I, k_2 = k, c_2 = c with c² = 4 k I: a double root −c/(2I) of the mode in which both turn together."""
    equal = {"screw_inertia": 2.0**-10, "coupling_stiffness": 0.25, "support_damping": 2.0**-5}
    changes = {**equal, "nut_inertia": 2.0**-10, "nut_stiffness": 0.25, "nut_damping": 2.0**-5, "mass": 2.0}
    values = [complex(x["real"], x["imaginary"]) for x in stability_table(changes, "nut")["eigenvalues"]]
    assert values.count(-16) == 2


@pytest.mark.parametrize(
    ("apart", "thread"),
    [(2.0**-52, {}), (1e-18, {}), (1e-18, {"pitch_radius": 1e-6}), (1e-18, {"pitch_radius": 1e-6, "lead_angle": 1e-6})],
)
def test_eigenvalues_that_nearly_coincide_end(apart, thread):
    """A drag that couples both bodies by next to nothing leaves rates that share dozens of digits."""
    equal = {"screw_inertia": 2.0**-10, "coupling_stiffness": 0.25, "support_damping": 2.0**-5}
    changes = {**equal, "nut_inertia": 2.0**-10, "nut_stiffness": 0.25, "nut_damping": 2.0**-5}
    light = {"mass": apart, "translation_damping": apart}
    table = stability_table({**changes, **light, **thread}, "nut")
    assert table["stable"]
    assert [x["real"] for x in table["eigenvalues"]] == pytest.approx([-16.0] * 4, rel=1e-6)


def test_friction_and_force_that_balance_but_for_a_drag():
    """R = F_0 with c_x Ω r_m tan λ = 5e-21 N left: the contact carries that force, and its sign is the law's."""
    drive = SupportParameters.of(axial_force=1.0, slide_friction=1.0, translation_damping=1e-18, input_speed=10.0)
    with mpmath.workdps(100):
        assert linearised.steady_law(drive) == steady_law(drive) == -1


@pytest.mark.parametrize("force", [-0.018678427837130564, 0.15619748442975243, 1e-3, -11.0])
def test_friction_that_balances_the_force_leaves_no_law(force):
    """Doubles whose decimals are longer than 50 digits."""
    changes = {"axial_force": force, "slide_friction": abs(force), "input_speed": math.copysign(3.0, force)}
    for model in ("support", "nut"):
        with pytest.raises(InputError, match="the contact carries no force"):
            threshold_table(changes, model)


@pytest.mark.parametrize("model", sorted(KINDS))
def test_polynomial_is_that_of_the_matrices(model):
    build = {"threads": linearised.threads_model, "support": linearised.support_model, "nut": linearised.nut_model}[
        model
    ]
    drive = KINDS[model].of(mass=7.0, translation_damping=70.0)
    for law in (1, -1):
        exact = spectrum.spectrum(drive, law)[2]
        factor = characteristic.scale(drive, law)
        for ours, theirs in zip(exact, build(drive.exact(), law).polynomial(), strict=True):
            assert abs(ours / factor - Fraction(theirs)) < Fraction(1, 10**40) * abs(Fraction(theirs))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.integers(-400, 400), min_size=1, max_size=4), st.integers(-20, 20))
def test_positive_roots_of_known_polynomials(halves, power):
    """Roots n/2 · 10^power, repeated ones and zero among them."""
    size = Fraction(10) ** power
    polynomial = (Fraction(3),)
    for half in halves:
        polynomial = multiplied(polynomial, (Fraction(1), -Fraction(half, 2) * size))
    found = real_roots.positive_roots(polynomial, 1000 * size)
    assert [float(x) for x in found] == [
        float(Fraction(half, 2) * size) for half in sorted({h for h in halves if h > 0})
    ]


def test_thresholds_of_every_model_are_those_of_the_function():
    for model, kind in KINDS.items():
        assert threshold_table({}, model) == boundaries.model_thresholds(kind())
        assert set(threshold_table({}, model)) == {
            "critical_mass",
            "critical_friction",
            f"least_{kind.own_damping}",
        }
    with pytest.raises(InputError, match="model = 'elastic' is not one of rigid, threads, support, nut"):
        threshold_table({}, "elastic")
    assert np.isfinite(threshold_table()["critical_mass"]["value"])
