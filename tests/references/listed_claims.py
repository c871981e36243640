"""The list of what the chapter prints, ``config/chapter.yaml``, and the checks that it names."""

from collections.abc import Iterable
from functools import cache
from pathlib import Path

import yaml

from lsvib.datasets.checks import Check

LIST = Path(__file__).parents[2] / "config" / "chapter.yaml"


@cache
def entries() -> list[dict]:
    return yaml.safe_load(LIST.read_text(encoding="utf-8"))["entries"]


def assert_listed_checks_exist(figure: str, checks: Iterable[Check]) -> None:
    """The words of each entry of a figure name exactly one of its checks, which expects the printed number, if any."""
    for entry in entries():
        if entry.get("figure") == figure:
            named = [check for check in checks if entry["check"] in check.claim]
            assert len(named) == 1, entry
            if "value" in entry:
                assert (named[0].expected, named[0].unit.replace("/", " ")) == (entry["value"], _slash(entry["unit"]))


def _slash(unit: str) -> str:
    """Checks write N m s/rad where the list writes N m s rad-1."""
    return unit.replace("rad-1", "rad").replace(" s-1", " s")
