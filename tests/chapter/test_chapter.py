"""The list of the chapter's numbers and claims is complete by its numbering, and each entry leads somewhere."""

import math
import re
from pathlib import Path

import pytest
import yaml

from lsvib import Drive
from lsvib.chapter.checks import counted, read_statements, report
from lsvib.drives.chapter import FILE, listed

ROOT = Path(__file__).parents[2]
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
OURS = {"id", "source", "claim", "found", "value", "unit", "tolerance", "deviation", "reason"}
KEYS = OURS | {"drive", "figure", "check", "input", "unchecked", "contradicted"}
ENTRIES = listed()["entries"]


def numbers_in(places: list[str], word: str) -> set[int]:
    """Numbers N of "word 8.N" in places such as "Sect. 8.8.1", "Fig. 8.14b" or "eqs 8.24, 8.25, 8.26"."""
    found = [re.match(rf"{word}s? (8\.\d+(?:\.\d)?[a-d]?(?:, 8\.\d+)*)$", part) for part in places]
    return {int(n) for match in found if match for n in re.findall(r"8\.(\d+)", match[1])}


def test_every_entry_is_whole():
    for entry in ENTRIES:
        assert entry.keys() <= KEYS, entry
        assert {"source", "claim"} <= entry.keys(), entry
        verdicts = [key for key in ("id", "check", "input", "unchecked", "contradicted") if key in entry]
        assert len(verdicts) == 1 or verdicts in (["id", "contradicted"], ["check", "contradicted"]), entry
        assert "value" in entry or "input" not in entry, entry
        assert ("value" in entry and "id" in entry) == ("reason" in entry), entry
        assert verdicts == ["id"] or "{" not in entry["claim"], entry  # only a check fills that in
    assert all({"id", "source", "claim"} <= entry.keys() <= OURS for entry in listed()["ours"])
    said = [(entry["source"], entry["claim"]) for part in listed().values() for entry in part]
    names = [entry["id"] for part in listed().values() for entry in part if "id" in entry]
    assert (len(said), len(names)) == (len(set(said)), len(set(names)))


@pytest.mark.parametrize(
    ("word", "last"), [("eq\\.?", 33), ("Fig\\.", 15), ("Sect\\.", 9), ("Remark", 6), ("Lemma", 2), ("Table", 1)]
)
def test_nothing_that_is_numbered_is_left_out(word, last):
    places = [part for entry in ENTRIES for part in re.split(r", (?=[A-Za-z])", entry["source"])]
    found = numbers_in(places, word)
    assert found == set(range(1, last + 1))


@pytest.mark.parametrize("entry", [e for e in ENTRIES if "input" in e], ids=lambda e: f"{e['source']}, {e['claim']}")
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
    for entry in ENTRIES:
        for name in re.findall(r"(?:docs|tests)/[\w/]+\.(?:md|py)", entry.get("unchecked", "")):
            assert (ROOT / name).exists(), entry


def test_a_contradicted_entry_counts_as_nothing_else():
    statements = read_statements(FILE)
    assert sum(map(len, statements.values())) == len(ENTRIES)
    assert all("contradicted" in entry for entry in statements["contradicted"])
    assert not any("contradicted" in entry for verdict in ("id", "input", "unchecked") for entry in statements[verdict])


def test_the_report_has_the_counts_and_the_contradictions():
    """Without the list, as for the figures of accuracy, it says nothing of the chapter's statements."""
    statements = read_statements(FILE)
    pages = [report(form, [], statements) for form in ("md", "rst")]
    assert all(counted(statements) in page for page in pages)
    assert all(entry["contradicted"][1:] in pages[0] for entry in statements["contradicted"])
    assert not any("contradicted" in report(form, []) for form in ("md", "rst"))
