"""How results are printed: tables and sentences for people, one JSON object for programs."""

import json
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any


def show(
    result: Mapping[str, Any], as_json: bool, text: Callable[[Mapping[str, Any]], None], out: Path | None = None
) -> None:
    """Print a result as one JSON object, or as ``text`` prints it for people; ``out``: a file that was written."""
    if as_json:
        print(json.dumps(result, indent=2, allow_nan=False))
        return
    if out is not None:
        print(f"wrote {out}")
    text(result)


def table(rows: Iterable[Iterable[object]], *columns: str) -> None:
    """Print rows in columns, with a heading where there are names of columns."""
    from rich.console import Console
    from rich.table import Table

    made = Table(*columns, box=None, show_header=bool(columns), pad_edge=False, header_style="bold")
    for row in rows:
        made.add_row(*map(str, row))
    # A file or a pipe has no width, so that no line is broken there.
    console = Console(width=None if sys.stdout and sys.stdout.isatty() else 500, highlight=False, markup=False)
    with console.capture() as lines:
        console.print(made)
    print("\n".join(line.rstrip() for line in lines.get().splitlines()))


def name(key: str) -> str:
    """Return a name of a dataset or of JSON as a person writes it."""
    return key.replace("_", " ")


def rate(value: float) -> str:
    """Return a rate in three digits, without a power of ten."""
    return f"{float(f'{value:.3g}'):.15g}"


def quantity(entry: Mapping[str, Any]) -> str:
    """Return the value and the unit of an entry; the word none if it has no value."""
    return "none" if entry["value"] is None else with_unit(f"{entry['value']:.12g}", entry["unit"])


def with_unit(text: str, unit: str) -> str:
    """Return a number with its unit; a pure number, whose unit is "1" in files, stands alone."""
    return text if unit == "1" else f"{text} {unit}"
