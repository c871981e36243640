"""Boundaries of stability of damped drives: the table of docs/lemmas.md, 12 digits, and what contradicted itself."""

import json
import math
import re
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from references.newton import eigenvalues, is_stable, steady_law

from lsvib.engine.exact.arithmetic import multiplied
from lsvib.models.drive import NutDrive, RigidDrive, SupportDrive, ThreadsDrive
from lsvib.stability import spectrum
from lsvib.stability.stability_table import stability_table
from lsvib.stability.threshold_table import threshold_table

LEMMAS = (Path(__file__).parents[2] / "docs" / "lemmas.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (1e\d+) \| ([\d.]+) \|$", LEMMAS, re.MULTILINE)
KINDS = {"threads": ThreadsDrive, "support": SupportDrive, "nut": NutDrive}


def boundary(model: str, drive: RigidDrive, key: str, low: float, high: float) -> mpmath.mpf:
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
    exact = boundary("threads", ThreadsDrive.of(changes), "contact_damping", float(printed) / 2, float(printed) * 2)
    assert abs(entry["value"] / exact - 1) < 2e-16


def test_class_conditions_and_quantities_of_the_soft_contact_agree():
    """m = 9 kg, k_c = 1e8, c_c = 5e4: flutter, though c_c lies above the bound of the limit k_c → ∞."""
    changes = {"mass": 9.0, "contact_stiffness": 1e8, "contact_damping": 5e4}
    table = stability_table(changes, "threads")
    assert (table["stable"], table["class"]) == (False, "flutter")
    with mpmath.workdps(60):
        growth = mpmath.re(eigenvalues("threads", ThreadsDrive.of(changes), 1)[-1])
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


@settings(max_examples=200, deadline=None)
@given(st.lists(st.integers(-400, 400), min_size=1, max_size=4), st.integers(-20, 20))
def test_positive_roots_of_known_polynomials(halves, power):
    """Roots n/2 · 10^power, repeated ones and zero among them."""
    size = Fraction(10) ** power
    polynomial = (Fraction(3),)
    for half in halves:
        polynomial = multiplied(polynomial, (Fraction(1), -Fraction(half, 2) * size))
    found = spectrum.positive_roots(polynomial, 1000 * size)
    assert [float(x) for x in found] == [
        float(Fraction(half, 2) * size) for half in sorted({h for h in halves if h > 0})
    ]
