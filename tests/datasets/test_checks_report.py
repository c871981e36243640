"""The checks of a run for people: the text by figure, and the page whose table can be filtered."""

import html
import io
import re

import docutils.core

from lsvib.datasets.checks import Check, printed, report
from lsvib.models.chapter import THRESHOLDS, claims
from lsvib.models.chapter import printed as stated

MASS = claims()["fig8_08.critical_mass"]
CHECKS = [
    ("fig8_07", Check.holds("mean of |N|\ngrows & <grows>", "Fig. 8.12", "2 of 3", False)),
    ("fig8_08", Check.holds("Two eigenvalues meet", "Fig. 8.8", "9.9 kg", True)),
    ("fig8_08", Check.of(MASS.id, 10.107)),
    ("fig8_07", Check.within("A number of our own", "Sect. 8.7", 3.0, 3.001, 0.01, "1")),
]


def rows_of(page: str) -> list[tuple[dict[str, str], list[str]]]:
    """The rows of a page: the attributes of each, and the text of its cells."""
    rows = re.findall(r"<tr([^>]*)>(.*?)</tr>", page, re.DOTALL)
    cells = [re.findall(r"<t[dh]\b[^>]*>(.*?)</t[dh]>", row, re.DOTALL) for _, row in rows]
    texts = [[html.unescape(re.sub(r"<[^>]*>", "", cell)) for cell in row] for row in cells]
    return [(dict(re.findall(r'(\S+)="(.*?)"', own)), row) for (own, _), row in zip(rows, texts, strict=True)]


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
    bars = [[k for k, letter in enumerate(line) if letter == "|"][:-1] for line in (head, rule, row)]
    assert bars[0] == bars[1] == bars[2]
    assert [cell.strip() for cell in row.strip("|").split("|")] == [
        *("10.1 kg", "10.107 kg", "0.069 %", "0.83 %", "pass", "fig8_08", MASS.claim),
    ]
    assert re.findall("^## (.*)$", text, re.MULTILINE) == [
        *("Printed by the chapter", "fig8_07: 1 of 2 passed", "fig8_08: 2 of 2 passed"),
    ]
    assert re.findall("^- (.*)$", text, re.MULTILINE) == [
        "FAIL: mean of |N| grows & <grows>: NOT true (2 of 3) [Fig. 8.12].",
        "pass: A number of our own: expected 3, computed 3.001, relative error 0.000333333 <= 0.01 [Sect. 8.7].",
        "pass: Two eigenvalues meet: true (9.9 kg) [Fig. 8.8].",
        f"pass: {CHECKS[2][1].sentence()}",
    ]


def test_the_table_of_a_report_is_restructured_text_without_a_complaint():
    claim = Check.within("|a_b_|*", MASS.source, MASS.value, 10.107, MASS.tolerance, "kg", id=MASS.id)
    for checks in ([*CHECKS, ("fig8_08", claim)], CHECKS[:1]):
        complaints = io.StringIO()
        settings = {"warning_stream": complaints, "report_level": 1}
        shown = docutils.core.publish_doctree(report("rst", checks), settings_overrides=settings).astext()
        assert complaints.getvalue() == ""
        assert ("|a_b_|*" in shown) == (len(checks) > 1)


def test_the_page_has_every_check_with_what_the_filter_asks_for():
    rows = rows_of(report("html", CHECKS))
    assert [cells[0] for _, cells in rows[:2]] == ["number", f"{MASS.claim}{MASS.source}"]
    every = [(given, cells) for given, cells in rows if "data-figure" in given]
    assert [(given["data-figure"], given["data-passed"]) for given, _ in every] == [
        ("fig8_07", "no"),
        ("fig8_08", "yes"),
        ("fig8_08", "yes"),
        ("fig8_07", "yes"),
    ]
    assert every[0][1] == ["mean of |N|\ngrows & <grows>Fig. 8.12", "true", "2 of 3", "-", "-", "FAIL", "fig8_07"]
    assert every[2][1][1:] == ["10.1 kg", "10.107 kg", "0.069 %", "0.83 %", "pass", "fig8_08"]
    assert {len(cells) for _, cells in rows} == {7}
