"""Checks: the verdict, its limits, and its two written forms."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lsvib.data.checks import Check, markdown_table, terminal_table
from lsvib.errors import InputError


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


@pytest.mark.parametrize(("expected", "tolerance"), [(0.0, 0.1), (math.nan, 0.1), (1.0, 0.0), (1.0, math.nan)])
def test_refuses_what_has_no_relative_error(expected, tolerance):
    with pytest.raises(InputError):
        Check.within("claim", "source", expected, 1.0, tolerance, "1")


@given(st.floats(), st.floats(min_value=1e-300, allow_infinity=False))
def test_json_round_trip(computed, tolerance):
    check = Check.within("claim", "source", 2.0, computed, tolerance, "N")
    back = Check.from_json(json.loads(json.dumps(check.to_json(), allow_nan=False)))
    assert repr(back) == repr(check)


def test_json_round_trip_of_a_statement():
    check = Check.holds("Origin is stable", "Fig. 8.9", "nan", False)
    back = Check.from_json(json.loads(json.dumps(check.to_json())))
    assert back.passed is False
    assert back.tolerance is None


def test_table_has_a_line_for_each_check():
    checks = [("fig8_08", within(10.107)), ("fig8_07", Check.holds("mean of |N| grows", "Fig. 8.12", "3 of 3", False))]
    head, rule, first, second = markdown_table(checks).splitlines()
    columns = [cell.strip() for cell in head.strip("|").split("|")]
    assert columns == ["figure", "claim", "expected", "computed", "error", "tolerance", "verdict"]
    assert set(rule) == {"|", "-"}
    assert [cell.strip() for cell in first.strip("|").split("|")][2:] == [
        "10.1 kg",
        "10.107 kg",
        "0.000693",
        "0.02",
        "pass",
    ]
    assert "mean of \\|N\\| grows" in second
    assert second.endswith("| FAIL    |")
    assert len({len(head), len(rule), len(first), len(second)}) == 1


@pytest.mark.parametrize("figure", ["fig8_12", "limit_process"])
def test_terminal_table_fits_a_terminal_and_loses_no_word(figure):
    claim = "a claim much too long for one line of the table of checks, with |N| in it, so that it must go on below"
    table = terminal_table([(figure, Check.holds(claim, "Fig. 8.12", "word " * 20, False))])
    assert max(map(len, table.splitlines())) <= 120
    assert table.split().count("word") == 20
    assert all(word in table for word in claim.split())
    assert "FAIL" in table
    assert sum(line.startswith(figure) for line in table.splitlines()) == 1
