"""Checks: the verdict, its limits, and how it is written: as data, as text by figure, as a table."""

import io
import json
import math
import re
from dataclasses import replace

import docutils.core
import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

from lsvib.chapter import checks as clauses
from lsvib.chapter.checks import Check, counts, failures, printed, printed_thresholds, read_checks, report
from lsvib.drives.chapter import THRESHOLDS, claims
from lsvib.drives.chapter import printed as stated
from lsvib.errors import InputError


def mass(computed: float) -> Check:
    return Check.of("fig8_08.critical_mass", computed)


def test_relative_error_decides():
    assert mass(10.107).passed
    assert mass(10.107).error == pytest.approx(0.007 / 10.10)
    assert not any(mass(value).passed for value in (10.4, -10.10))


@pytest.mark.parametrize("computed", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_never_passes_nor_what_has_no_relative_error(computed):
    assert not mass(computed).passed
    assert "is NOT <=" in mass(computed).sentence()
    assert "nan" not in mass(computed).sentence()
    assert not Check.of("fig8_12.axial_balance", [1.0, computed, 1.0], expected=1.0).passed
    assert not any(Check.of("fig8_12.axial_balance", 1.0, expected=x).passed for x in (0.0, computed))


@given(st.floats())
def test_json_round_trip(computed):
    check = mass(computed)
    back = Check.from_json(json.loads(json.dumps(check.to_json(), allow_nan=False)))
    assert repr(back) == repr(check)


def test_a_damaged_file_is_refused_with_its_remedy(tmp_path):
    (tmp_path / "checks.json").write_text('[{"claim": "Critical ma')
    with pytest.raises(InputError, match=r"not a readable file of checks; make it again\.$"):
        read_checks(tmp_path / "checks.json")


def test_a_claim_in_words_tells_what_was_found():
    """Of an array each entry, one entry, or a number of it; none for the least of none."""
    values = {"amplitude": 0.5, "rigid_amplitude": 0.25, "period": 1.0, "rigid_period": np.float32(2)}
    values |= {"axial_force": 50.0, "forces": [10.0, 200.0]}
    distances = np.array([0.5, 0.125])
    check = Check.that(
        "fig8_10.close", orbit_distance=clauses.each(xr.DataArray(0.25), "<=", 0.02), near=distances, **values
    )
    assert not check.passed
    said = "distance 0.2500 (amplitude 0.5 against 0.25 rad, period 1 against 2 s), but 0.5000 at R = 10 N and "
    said += "0.1250 at R = 200 N"
    assert check.computed == f"{said}; NOT orbit distance 0.25 <= 0.02"
    assert Check.that("fig8_06.line", line=distances).computed == "from 0.125 to 0.5 rad away"
    assert Check.that("fig8_13.positive", largest=distances).computed == "largest z 0.5, 0.125 rad"
    assert Check.that("fig8_08.above", growth=distances[:0]).computed == "smallest positive one none 1/s"
    found = Check.that("fig8_06.decays", force=14.0, names="rest", starts=2, motions=clauses.every(distances > 0))
    assert "14 N, the origin" in found.claim
    assert found.computed == "rest from 2 starts; all motions (2 of 2)"
    assert found.clauses == {"motions": {"found": "all motions (2 of 2)", "passed": True}}
    assert Check.from_json(json.loads(json.dumps(found.to_json()))) == found


EACH, NEAR, EVERY, SOME, NEVER = clauses.each, clauses.near, clauses.every, clauses.some, clauses.never
FAILING = (
    *(EACH(value, "<", math.inf) for value in (math.nan, [math.nan, 1.0], [], math.inf)),
    *(EACH([1, 2], "<", 2), EACH([1, 2], ">", 1), EACH(3, "<=", 2), EACH(1, ">=", 2), NEAR(math.nan, 1.0, 1.0)),
    *(NEAR(np.array([1.0, 1.01]), 1.0, 0.009), EVERY([]), SOME([]), NEVER([]), EVERY([1, 0]), SOME([0]), NEVER([1, 0])),
)
HOLDING = (
    *(EACH([1, 2], "<", 3), EACH([1, 2], ">", 0), EACH(2, "<=", 2), EACH(2, ">=", 2)),
    *(NEAR(np.array([1.0, 1.01]), 1.0, 0.02), EVERY([1]), SOME([1, 0]), NEVER([0])),
)


def test_a_claim_holds_if_all_its_clauses_do_and_at_least_one():
    assert not Check.that("fig8_05.settles").passed
    assert Check.that("fig8_05.settles", **{f"clause_{k}": one for k, one in enumerate(HOLDING)}).passed
    for clause in FAILING:
        assert not Check.that("fig8_05.settles", one=clause, other=HOLDING[0]).passed


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
    failed = mass(12.0)
    untrue = Check.holds("claim", "Fig. 8.6", "no", False)
    first, second = failures([("fig8_08", failed), ("fig8_06", untrue), ("fig8_06", Check.holds("x", "", "", True))])
    assert first.endswith("is NOT <= 0.0083 [Sect. 8.6.1, eq. 8.20].")
    assert second == "fig8_06: claim: NOT true (no) [Fig. 8.6]."


MASS = claims()["fig8_08.critical_mass"]
CHECKS = [
    ("fig8_07", Check.holds("mean of |N|\ngrows & <grows>", "Fig. 8.12", "2 of 3", False)),
    ("fig8_08", Check.holds("Two eigenvalues meet", "Fig. 8.8", "9.9 kg", True)),
    ("fig8_08", mass(10.107)),
    ("fig8_07", replace(mass(10.107), id="", claim="A number of our own")),
]


def test_every_number_that_the_chapter_prints_is_known_and_the_thresholds_are_first():
    names = [claim.id for claim in stated()]
    assert len({(claims()[name].source, claims()[name].value) for name in names}) == len(names) == 11
    assert names[:5] == [*THRESHOLDS.values()]
    checks = [("a", Check.of(name, 1.0)) for name in reversed(names)]
    assert [check.id for _, check in printed([*CHECKS[:2], *checks])] == names


def test_the_text_has_printed_numbers_first_and_then_a_line_for_each_check_by_figure():
    text = report("md", CHECKS)
    assert text.splitlines()[2] == "1 of 4 checks FAILED: fig8_07."
    head, rule, row = (line for line in text.splitlines() if line.startswith("|"))
    bars = [[k for k, letter in enumerate(line) if letter == "|"][:-2] for line in (head, rule, row)]
    assert bars[0] == bars[1] == bars[2]
    assert [cell.strip() for cell in row.strip("|").split("|")] == [
        *("10.10 kg", "10.107 kg", "0.069 %", "0.83 %", "pass", "fig8_08", MASS.claim, MASS.reason)
    ]
    assert re.findall("^## (.*)$", text, re.MULTILINE) == [
        *("Numbers printed in the chapter", "fig8_07: 1 of 2 passed", "fig8_08: 2 of 2 passed")
    ]
    assert re.findall("^- (.*)$", text, re.MULTILINE) == [
        "FAIL: mean of |N| grows & <grows>: NOT true (2 of 3) [Fig. 8.12].",
        "pass: A number of our own: expected 10.1 kg, computed 10.107 kg, relative error 0.000693069 <= 0.0083 "
        "[Sect. 8.6.1, eq. 8.20].",
        "pass: Two eigenvalues meet: true (9.9 kg) [Fig. 8.8].",
        f"pass, `{MASS.id}`: {CHECKS[2][1].sentence()}",
    ]


def test_a_number_that_shows_a_misprint_is_not_said_to_pass():
    check = Check.of("fig8_06.inertia_plus", claims()["fig8_06.inertia_plus"].value)
    for one, verdict in ((check, "misprint"), (replace(check, passed=False), "FAIL")):
        (row,) = (line for line in report("md", [("fig8_06", one)]).splitlines() if line.startswith("| 6.5e-07"))
        assert row.split("|")[5].strip() == verdict


def test_the_table_of_a_report_is_restructured_text_without_a_complaint():
    claim = replace(mass(10.107), claim="|a_b_|*")
    for checks in ([*CHECKS, ("fig8_08", claim)], CHECKS[:1]):
        complaints = io.StringIO()
        settings = {"warning_stream": complaints, "report_level": 1}
        shown = docutils.core.publish_doctree(report("rst", checks), settings_overrides=settings).astext()
        assert complaints.getvalue() == ""
        assert ("|a_b_|*" in shown) == (len(checks) > 1)
