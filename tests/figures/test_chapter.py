"""The list of the chapter's numbers and claims is complete by its numbering, and each entry leads somewhere."""

import html
import math
import re
from pathlib import Path

import pytest
import yaml
from references.figure_checks import LIST, entries

from lsvib.datasets.checks import report
from lsvib.datasets.statements import counted, read_statements
from lsvib.figures.configuration import default_figures
from lsvib.models.drive import Drive

ROOT = Path(__file__).parents[2]
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
KEYS = {"at", "says", "value", "unit", "figure", "check", "input", "reason", "contradicted"}


def numbers_in(places: list[str], word: str) -> set[int]:
    """Numbers N of "word 8.N" in places such as "Sect. 8.8.1", "Fig. 8.14b" or "eqs 8.24, 8.25, 8.26"."""
    found = [re.match(rf"{word}s? (8\.\d+(?:\.\d)?[a-d]?(?:, 8\.\d+)*)$", part) for part in places]
    return {int(n) for match in found if match for n in re.findall(r"8\.(\d+)", match[1])}


def test_every_entry_is_whole():
    for entry in entries():
        assert entry.keys() <= KEYS, entry
        assert {"at", "says"} <= entry.keys(), entry
        verdicts = [key for key in ("check", "input", "reason", "contradicted") if key in entry]
        assert len(verdicts) == 1 or verdicts == ["check", "contradicted"], entry
        assert ("check" in entry) == ("figure" in entry), entry
        assert ("value" in entry) == ("unit" in entry), entry
        assert "value" in entry or "input" not in entry, entry
        assert entry.get("figure", default_figures()[0]) in default_figures(), entry
    said = [(entry["at"], entry["says"]) for entry in entries()]
    assert len(said) == len(set(said))


@pytest.mark.parametrize(
    ("word", "last"), [("eq\\.?", 33), ("Fig\\.", 15), ("Sect\\.", 9), ("Remark", 6), ("Lemma", 2), ("Table", 1)]
)
def test_nothing_that_is_numbered_is_left_out(word, last):
    places = [part for entry in entries() for part in re.split(r", (?=[A-Za-z])", entry["at"])]
    found = numbers_in(places, word)
    assert found == set(range(1, last + 1))


@pytest.mark.parametrize("entry", [e for e in entries() if "input" in e], ids=lambda e: f"{e['at']}, {e['says']}")
def test_printed_inputs_are_those_that_are_used(entry):
    head, *path = entry["input"].split(".")
    if head == "drive":
        value = getattr(Drive(), path[0])
        value = math.degrees(value) if entry["unit"] == "degree" else value
        assert value == pytest.approx(entry["value"], rel=1e-15)
    else:
        value = CONFIG[head]
        for key in path:
            value = value[int(key) if isinstance(value, list) else key]
        assert value == entry["value"]


def test_reasons_name_files_that_exist():
    for entry in entries():
        for name in re.findall(r"(?:docs|tests)/[\w/]+\.(?:md|py)", entry.get("reason", "")):
            assert (ROOT / name).exists(), entry


def test_a_contradicted_entry_counts_as_nothing_else():
    statements = read_statements(LIST)
    assert sum(map(len, statements.values())) == len(entries())
    assert all("contradicted" in entry for entry in statements["contradicted"])
    assert not any("contradicted" in entry for verdict in ("check", "input", "reason") for entry in statements[verdict])
    assert {verdict: len(found) for verdict, found in statements.items()} == {
        "contradicted": sum("contradicted" in entry for entry in entries()),
        "check": sum("check" in entry and "contradicted" not in entry for entry in entries()),
        **{verdict: sum(verdict in entry for entry in entries()) for verdict in ("input", "reason")},
    }


@pytest.mark.parametrize("page", ["README.md", "docs/physics.md"])
def test_pages_count_as_the_list_does(page):
    assert counted(read_statements(LIST)) in " ".join((ROOT / page).read_text(encoding="utf-8").split())


def test_the_report_has_the_counts_and_the_contradictions():
    """Without the list, as for the figures of accuracy, it says nothing of the chapter's statements."""
    statements = read_statements(LIST)
    pages = [report(form, [], statements) for form in ("md", "html", "rst")]
    assert all(counted(statements) in html.unescape(page) for page in pages)
    for entry in statements["contradicted"]:
        assert entry["contradicted"][1:] in pages[0]
        assert entry["contradicted"] in html.unescape(pages[1])
    assert not any("contradicted" in report(form, []) for form in ("md", "html", "rst"))
