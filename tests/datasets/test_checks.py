"""Checks: the verdict, its limits, and how it is written as data."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lsvib.datasets.checks import Check, counts, failures, printed_thresholds
from lsvib.errors import InputError
from lsvib.models.chapter import THRESHOLDS


def within(computed: float, tolerance: float = 0.02) -> Check:
    return Check.within("Critical mass", "Sect. 8.6.1", 10.10, computed, tolerance, "kg")


def test_relative_error_decides():
    assert within(10.107).passed
    assert within(10.107).error == pytest.approx(0.007 / 10.10)
    assert not within(10.4).passed
    assert not within(-10.10).passed


@pytest.mark.parametrize("computed", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_never_passes(computed):
    check = within(computed, tolerance=1e300)
    assert not check.passed
    assert "is NOT <=" in check.sentence()
    assert not Check.of("fig8_12.axial_balance", [1.0, computed, 1.0], expected=1.0).passed


@pytest.mark.parametrize(("expected", "tolerance"), [(0.0, 0.1), (math.nan, 0.1), (1.0, 0.0), (1.0, math.nan)])
def test_refuses_what_has_no_relative_error(expected, tolerance):
    with pytest.raises(InputError):
        Check.within("claim", "source", expected, 1.0, tolerance, "1")


@given(st.floats(), st.floats(min_value=1e-300, allow_infinity=False))
def test_json_round_trip(computed, tolerance):
    check = Check.within("claim", "source", 2.0, computed, tolerance, "N")
    back = Check.from_json(json.loads(json.dumps(check.to_json(), allow_nan=False)))
    assert repr(back) == repr(check)


def test_the_end_of_a_run_says_printed_thresholds_beside_computed_ones():
    check = Check.of("fig8_06.onset_force", 20.2066)
    other = Check.holds("another claim", "Fig. 8.6", "yes", True)
    (line,) = printed_thresholds([("fig8_06", check), ("fig8_06", other)])
    words = ["onset", "force", "printed", "20", "N", "computed", "20.2066", "N", "error", "1", "%", "fig8_06"]
    assert line.split() == words
    assert len(THRESHOLDS) == 5


def test_the_end_of_a_run_counts_checks_by_figure():
    checks = [(f"figure_{k}", Check.holds("a claim", "Fig. 8.6", "", k != 7)) for k in range(40) for _ in range(3)]
    text = counts(checks)
    assert max(map(len, text.splitlines())) <= 120
    assert "figure_6 3/3, figure_7 0/3, figure_8 3/3" in " ".join(text.split())


def test_a_failure_says_what_was_expected():
    failed = Check.within("mass", "Sect. 8.6.1", -10.0, -12.0, 0.02, "kg")
    untrue = Check.holds("claim", "Fig. 8.6", "no", False)
    first, second = failures([("fig8_08", failed), ("fig8_06", untrue), ("fig8_06", Check.holds("x", "", "", True))])
    assert first.endswith("is NOT <= 0.02 [Sect. 8.6.1].")
    assert second == "fig8_06: claim: NOT true (no) [Fig. 8.6]."
