"""The frame of the report: one self-contained HTML page, readable on a phone, on a screen and on paper."""

from collections.abc import Iterable, Sequence
from html import escape

_STYLE = """
:root { --ink: #1c2733; --soft: #5b6875; --line: #d8dee4; --paper: #ffffff; --tint: #f3f6f8; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1rem; max-width: 62rem; color: var(--ink); background: var(--paper);
  font: 16px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.5rem; line-height: 1.25; margin: .5rem 0; }
h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; padding-top: .75rem; border-top: 1px solid var(--line); }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; }
p, li { max-width: 44rem; }
.verdict { padding: 1rem; border-left: .4rem solid; background: var(--tint); font-size: 1.1rem; }
.bad { border-color: #d55e00; } .warn { border-color: #e69f00; } .good { border-color: #009e73; }
.cards { display: grid; gap: .75rem; grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr)); margin: 1rem 0; }
.card { background: var(--tint); padding: .7rem .8rem; border-radius: .4rem; }
.card b { display: block; font-size: 1.15rem; } .card span { color: var(--soft); font-size: .85rem; }
figure { margin: 1rem 0; max-width: 34rem; break-inside: avoid; } figure img { width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: .9rem; }
.pair { display: grid; gap: 0 1.5rem; grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); }
table { border-collapse: collapse; width: 100%; margin: .75rem 0; font-size: .93rem; }
th, td { text-align: left; vertical-align: top; padding: .4rem .6rem .4rem 0; border-bottom: 1px solid var(--line); }
td + td { min-width: 6.5rem; }
th { color: var(--soft); font-weight: 600; } td small { color: var(--soft); display: block; }
code, pre { font: .85rem/1.4 ui-monospace, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere;
  white-space: pre-wrap; }
pre { background: var(--tint); padding: .7rem; border-radius: .4rem; }
.assumed { background: #fbf3d9; padding: 0 .3rem; border-radius: .2rem; }
@media (max-width: 640px) {
  body { padding: .75rem; }
  thead { display: none; } tr { display: block; border-bottom: 1px solid var(--line); padding: .4rem 0; }
  td { display: block; border: 0; padding: .1rem 0; } td + td { min-width: 0; }
  td[data-name]::before { content: attr(data-name) ": "; color: var(--soft); }
  td:first-child { font-weight: 600; }
  td:first-child small { font-weight: 400; } td:first-child::before { content: ""; }
}
@media print {
  body { font-size: 10.5pt; max-width: none; padding: 0; } h2 { break-after: avoid; } tr { break-inside: avoid; }
  h2 { margin-top: 1.2rem; } figure { max-width: 9.5cm; margin: .5rem 0; } .pair { grid-template-columns: 1fr 1fr; }
  .cards { grid-template-columns: repeat(4, 1fr); }
  .verdict, .card, pre { background: none; border-width: 1px; border-style: solid; }
  .card, pre { border-color: var(--line); } .verdict { border-left-width: .4rem; }
}
"""


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
