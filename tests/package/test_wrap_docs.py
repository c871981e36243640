"""The tool that wraps the documentation changes the places of line breaks in prose and nothing else."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "tools"))
from wrap_docs import WIDTH, wrapped

WORDS = "A paragraph that says the same thing again and again "


def test_paragraphs_and_items_are_filled():
    text = f"{WORDS * 5}\n\n* {WORDS * 3}\n  {WORDS * 3}\n* short\n"
    new = wrapped(text)
    assert new.split() == text.split()
    assert max(map(len, new.split("\n"))) <= WIDTH
    assert all(line.startswith(("* ", "  ")) for line in new.split("\n")[4:-1])
    assert wrapped(new) == new


@pytest.mark.parametrize(
    "kept",
    [
        f"```\n{WORDS * 5}\n```",
        f"Text:\n\n    {WORDS * 5}\n    {WORDS * 5}",
        f"| {WORDS * 3} | {WORDS * 3} |",
        f"# {WORDS * 3}",
        f"[name]: {WORDS * 3}",
        "short\nlines stay\nas they are",
    ],
)
def test_what_a_new_line_would_change_is_kept(kept):
    assert wrapped(kept) == kept


def test_code_and_links_are_not_broken_and_no_line_begins_like_a_list():
    text = f"{'x' * 110} `code with spaces` - [a link](https://example.org) {'y' * 110} 8. {'z' * 20}"
    lines = wrapped(text).split("\n")
    assert any("`code with spaces`" in line for line in lines)
    assert not any(line.startswith(("- ", "8. ")) for line in lines)
