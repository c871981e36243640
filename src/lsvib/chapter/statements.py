"""What the chapter states, entry by entry (``config/chapter.yaml``), and what became of it, counted in one place."""

import os
from collections import Counter
from collections.abc import Iterable
from itertools import chain
from typing import Any

from lsvib.drives.scene import read_yaml

Statements = dict[str, list[dict[str, Any]]]
_VERDICTS = {  # the first that an entry has is its own: a check may hold the evidence of a contradiction
    "contradicted": "contradicted by the chapter's own equations",
    "id": "checked",
    "input": "inputs",
    "unchecked": "not checked, each with the reason",
}


def read_statements(path: str | os.PathLike[str]) -> Statements:
    """Read the list and return its entries by verdict: ``contradicted``, ``id`` (checked), ``input``, ``unchecked``."""
    statements: Statements = {verdict: [] for verdict in _VERDICTS}
    for entry in read_yaml(str(path))["entries"]:
        statements[next((verdict for verdict in _VERDICTS if verdict in entry), "id")].append(entry)
    return statements


def counted(statements: Statements) -> str:
    """Return in one sentence how many numbers and claims the chapter states, and how many of them have each verdict."""

    def both(entries: Iterable[dict[str, Any]]) -> str:
        found = Counter("numbers" if "value" in entry else "claims" for entry in entries)
        return " and ".join(f"{found[kind]} {kind}" for kind in ("numbers", "claims") if found[kind])

    *parts, last = (f"{both(statements[v])} are {_VERDICTS[v]}" for v in ("input", "id", "contradicted", "unchecked"))
    return f"Of the chapter's {both(chain(*statements.values()))}, {', '.join(parts)}, and {last}."
