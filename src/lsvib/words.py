"""How answers are put into words, numbers with their units, and tables."""

import sys
from collections.abc import Iterable, Iterator, Mapping
from typing import Any


def table(rows: Iterable[Iterable[object]], *columns: str) -> str:
    """Return rows in columns, with a heading where there are names of columns."""
    from rich.console import Console
    from rich.table import Column, Table

    own = (Column(name, overflow="fold") for name in columns)  # on a narrow screen no letter is lost
    made = Table(*own, box=None, show_header=bool(columns), pad_edge=False, header_style="bold")
    for row in rows:
        made.add_row(*map(str, row))
    # A file or a pipe has no width, so that no line is broken there.
    console = Console(width=None if sys.stdout and sys.stdout.isatty() else 500, highlight=False, markup=False)
    with console.capture() as lines:
        console.print(made)
    return "\n".join(line.rstrip() for line in lines.get().splitlines())


def plain(kind: Any) -> str:
    """Return a member of an enumeration, or a name of a dataset or of JSON, as a person writes it."""
    return str(getattr(kind, "name", kind)).lower().replace("_", " ")


def rate(value: float) -> str:
    """Return a rate in three digits, without a power of ten."""
    return f"{float(f'{value:.3g}'):.15g}"


def shares(fractions: Mapping[str, float], cells: int) -> Iterator[str]:
    """Return a line for each kind of cells that there is, with its share."""
    return (f"{plain(kind)}: {100 * part:.6g} % of {cells} cells" for kind, part in fractions.items())


def quantity(value: float | None, unit: str) -> str:
    """Return a number with its unit; the word none if there is none."""
    return "none" if value is None else with_unit(f"{value:.12g}", unit)


def with_unit(text: str, unit: str) -> str:
    """Return a number in digits with its unit; a pure number, whose unit is "1" in files, stands alone."""
    return text if unit == "1" else f"{text} {unit}"
