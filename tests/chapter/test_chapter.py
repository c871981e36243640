"""The list of the chapter's numbers and claims is complete by its numbering, and each entry leads somewhere."""

import math
import re
from pathlib import Path

import pytest
import yaml

from lsvib import Drive
from lsvib.chapter.checks import Check, counted, every, kinds, read_statements, report
from lsvib.drives.chapter import FILE, listed

ROOT = Path(__file__).parents[2]
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
OURS = {"id", "source", "claim", "found", "value", "unit", "tolerance", "deviation", "reason"}
KEYS = OURS | {"digits", "drive", "figure", "check", "input", "unchecked", "correction"}
ENTRIES = listed()["entries"]


def numbers_in(places: list[str], word: str) -> set[int]:
    """Numbers N of "word 8.N" in places such as "Sect. 8.8.1", "Fig. 8.14b" or "eqs 8.24, 8.25, 8.26"."""
    found = [re.match(rf"{word}s? (8\.\d+(?:\.\d)?[a-d]?(?:, 8\.\d+)*)$", part) for part in places]
    return {int(n) for match in found if match for n in re.findall(r"8\.(\d+)", match[1])}


def test_every_entry_is_whole():
    for entry in ENTRIES:
        assert entry.keys() <= KEYS, entry
        assert {"source", "claim"} <= entry.keys(), entry
        verdicts = [key for key in ("id", "check", "input", "unchecked", "correction") if key in entry]
        assert verdicts in (["id"], ["check"], ["input"], ["unchecked"], ["id", "correction"], ["check", "correction"])
        assert "value" in entry or "input" not in entry, entry
        assert ("value" in entry and "id" in entry) == ("reason" in entry), entry
        assert verdicts == ["id"] or "{" not in entry["claim"], entry  # only a check fills that in
        assert "digits" not in entry or float(entry["digits"]) == entry["value"], entry
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


def test_the_report_has_the_counts_and_the_corrections():
    """By number and kind, as README and paper count them; without the list, as for the figures of accuracy, nothing."""
    statements = read_statements(FILE)
    pages = [report(form, [], statements) for form in ("md", "rst")]
    assert all(counted(statements) in page for page in pages)
    pairs = [pair for entry in statements["correction"] for pair in entry["correction"].items()]
    for number, (kind, right) in enumerate(pairs, 1):
        assert re.search(rf"^{number}\. .*\. {kind.capitalize()}: {re.escape(right)} \(`\S*`\)\.$", pages[0], re.M)
    assert len({kind for kind, _ in pairs}) == 4
    assert not any("correction" in report(form, []) for form in ("md", "rst"))
    readme, paper = (
        " ".join((ROOT / page).read_text(encoding="utf-8").split()) for page in ("README.md", "paper/paper.md")
    )
    right, all_of_them = len(statements["id"]), sum(map(len, statements.values()))
    compared = f"Of the {all_of_them} statements found in the chapter it compares {right + len(pairs)} with"
    assert f"{compared} what is computed. Of these {right} hold and {len(pairs)} need a correction" in paper
    assert f"corrects the {len(pairs)} that need it ({kinds(statements)})" in readme


def test_a_run_of_some_figures_counts_only_what_it_checked():
    """A claim that another's check covers is listed under it, if its figure, where it names one, was built."""
    told = {"one": every([True]), "place": "", "what": "", "limit": 1.0, "worst": 0.0, "motions": 1}
    run = [("fig8_07", Check.that(id, **told)) for id in ("fig8_07.existence", "newton.laws")]
    statements = read_statements(FILE, run)
    assert [entry.get("id", entry.get("check")) for entry in statements["id"]] == ["fig8_07.existence"] * 3
    assert (sum(map(len, statements.values())), statements["correction"]) == (len(ENTRIES), [])
    page, left = report("md", run, statements), [e for e in ENTRIES if {"id", "check"} & e.keys()]
    numbers = sum("value" in entry for entry in left)
    words = f"{numbers} numbers and {len(left) - numbers - 3} claims belong to figures that are not in this run"
    assert f", 3 claims are checked, {words}, and " in page
    covered = re.findall(r"^- pass, `fig8_07\.existence`: (.*)\.$", page, re.MULTILINE)
    assert covered[:2] == [f"{e['source']}: {e['claim']}" for e in ENTRIES if e.get("check") == "fig8_07.existence"]
    failed = [("fig8_07", Check.that("fig8_07.existence", one=every([False])))]
    assert report("md", failed, read_statements(FILE, failed)).count("- FAIL, `fig8_07.existence`") == 3
