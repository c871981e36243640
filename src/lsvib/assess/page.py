"""The frame of the report: one self-contained HTML page, readable on a phone, on a screen and on paper."""

from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

_STYLE = Path(__file__).with_suffix(".css").read_text(encoding="utf-8")


class Html(str):
    """Text that is HTML already."""


def text(value: object) -> Html:
    """Return a value as HTML: as it is if it is HTML, else escaped."""
    return value if isinstance(value, Html) else Html(escape(str(value)))


def paragraph(*parts: object, kind: str = "") -> Html:
    """Return a paragraph."""
    attribute = f' class="{kind}"' if kind else ""
    return Html(f"<p{attribute}>{''.join(map(text, parts))}</p>")


def heading(value: str, level: int = 2) -> Html:
    """Return a heading."""
    return Html(f"<h{level}>{text(value)}</h{level}>")


def bullets(rows: Iterable[object]) -> Html:
    """Return a list."""
    return Html(f"<ul>{''.join(f'<li>{text(row)}</li>' for row in rows)}</ul>")


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> Html:
    """Return a table that on a phone becomes a list of its rows, each cell with the name of its column."""
    head = "".join(f"<th>{text(name)}</th>" for name in columns)
    body = "".join(
        "<tr>"
        + "".join(f'<td data-name="{text(name)}">{text(cell)}</td>' for name, cell in zip(columns, row, strict=True))
        + "</tr>"
        for row in rows
    )
    return Html(f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>")


def cards(rows: Iterable[tuple[str, str]]) -> Html:
    """Return numbers in boxes, each with its name below."""
    inner = "".join(f'<div class="card"><b>{text(value)}</b><span>{text(name)}</span></div>' for value, name in rows)
    return Html(f'<div class="cards">{inner}</div>')


def picture(source: str, caption: str) -> Html:
    """Return a figure whose image is embedded."""
    return Html(f'<figure><img src="{source}" alt="{text(caption)}"><figcaption>{text(caption)}</figcaption></figure>')


def side_by_side(*parts: Html) -> Html:
    """Return parts beside each other where there is room."""
    return Html(f'<div class="pair">{"".join(f"<div>{part}</div>" for part in parts)}</div>')


def listing(value: str) -> Html:
    """Return lines to be copied."""
    return Html(f"<pre>{text(value)}</pre>")


def small(value: object) -> Html:
    """Return a second, smaller line of a cell."""
    return Html(f"<small>{text(value)}</small>")


def page(title: str, parts: Iterable[Html]) -> str:
    """Return the whole page."""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<link rel="icon" href="data:,"><title>{text(title)}</title><style>{_STYLE}</style></head>\n<body>\n'
        + "\n".join(parts)
        + "\n</body></html>\n"
    )
