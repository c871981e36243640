"""The checks of a run for people: a text by figure, and one page with a table that can be filtered."""

import re
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from lsvib.datasets.checks import Check, percent, quantity, verdict
from lsvib.models.chapter import PRINTED

NamedChecks = Sequence[tuple[str, Check]]

_HEADING = "Printed by the chapter"
_STYLE = Path(__file__).with_suffix(".css").read_text(encoding="utf-8")
# Of the page: a row is shown if it holds every word, belongs to the figure, and failed where only those are wanted.
_FILTER = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


def printed(checks: NamedChecks) -> list[tuple[str, Check]]:
    """Return those of some checks, pairs (figure, check), whose number the chapter prints, in its order."""
    order = {(claim.source, claim.value): k for k, claim in reversed(list(enumerate(PRINTED)))}
    found = [pair for pair in checks if (pair[1].source, pair[1].expected) in order]
    return sorted(found, key=lambda pair: order[pair[1].source, pair[1].expected])


def checks_text(checks: NamedChecks) -> str:
    """Return checks, pairs (figure, check), as Markdown that reads well as text.

    First a table of the numbers that the chapter prints, if some are among them; then for each figure how many checks
    passed, and a line for each of them.
    """
    lines = ["# Checks", "", verdict(checks), ""]
    if found := printed(checks):
        rows = [["number", "printed", "computed", "error", "allowed", "verdict", "figure"]]
        rows += [[check.claim, *_numbers(check), _verdict(check), figure] for figure, check in found]
        lines += [f"## {_HEADING}", "", *_table(rows), ""]
    for figure in dict.fromkeys(figure for figure, _ in checks):
        own = [check for name, check in checks if name == figure]
        lines += [f"## {figure}: {sum(check.passed for check in own)} of {len(own)} passed", ""]
        lines += [f"- {_verdict(check)}: {_flat(check.claim)} [{check.source}]: {_found(check)}" for check in own]
        lines.append("")
    return "\n".join(lines)


def printed_table(checks: NamedChecks) -> str:
    """Return the printed numbers among checks, pairs (figure, check), as a table in reStructuredText, for a report."""
    found = printed(checks)
    if not found:
        return "None of the figures of this run has a number that the chapter prints.\n"
    rows = [["number", "printed", "computed", "error", "figure"]]
    rows += [[check.claim, *_numbers(check)[:3], figure] for figure, check in found]
    lines = [".. list-table::", "   :header-rows: 1", ""]
    for row in rows:
        lines += [f"   {'*' if k == 0 else ' '} - {restructured(_flat(cell))}" for k, cell in enumerate(row)]
    return "\n".join([*lines, ""])


def restructured(text: str) -> str:
    """Return a text whose characters mean nothing in reStructuredText but themselves."""
    return re.sub(r"([*`|_\\])", r"\\\1", text)


def checks_page(checks: NamedChecks) -> str:
    """Return checks, pairs (figure, check), as an HTML page that needs no other file: numbers first, then every check.

    The table of every check can be filtered by words, by figure, and for those that failed; on a phone its rows become
    lists.
    """
    parts = [f"<h1>Checks</h1><p class='verdict'>{escape(verdict(checks))}</p>"]
    if found := printed(checks):
        columns = ["number", "printed", "computed", "error", "allowed", "verdict", "figure"]
        parts.append(f"<h2>{_HEADING}</h2><table id='printed'>{_head(columns)}<tbody>")
        for figure, check in found:
            numbers = [(name, text, "") for name, text in zip(columns[1:5], _numbers(check), strict=True)]
            parts.append(_row([("number", _claim(check), "words"), *numbers, _mark(check), ("figure", figure, "")]))
        parts.append("</tbody></table>")
    parts.append(f"<h2>Every check</h2>{_form(dict.fromkeys(figure for figure, _ in checks))}<table id='every'>")
    parts.append(f"{_head(['claim', 'expected', 'found', 'error', 'allowed', 'verdict', 'figure'])}<tbody>")
    for figure, check in checks:
        expected, computed, error, allowed = _numbers(check)
        cells = [("claim", _claim(check), "words"), ("expected", escape(expected), "")]
        cells += [("found", escape(computed), "words"), ("error", error, ""), ("allowed", allowed, "")]
        cells += [_mark(check), ("figure", figure, "")]
        parts.append(_row(cells, f' data-figure="{figure}" data-passed="{"yes" if check.passed else "no"}"'))
    parts.append("</tbody></table>")
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1"><link rel="icon" href="data:,">'
        f"<title>Checks</title><style>{_STYLE}</style></head>\n<body>\n"
        + "\n".join(parts)
        + f"\n<script>{_FILTER}</script></body></html>\n"
    )


def _numbers(check: Check) -> list[str]:
    """What was expected and computed, the relative error and the largest allowed."""
    values = [_flat(quantity(value, check.unit)) for value in (check.expected, check.computed)]
    return [*values, percent(check.error), percent(check.tolerance)]


def _found(check: Check) -> str:
    expected, computed, error, allowed = _numbers(check)
    if check.tolerance is None:
        return f"{'true' if check.passed else 'NOT true'} ({computed})"
    return f"{computed}, expected {expected}, error {error} of at most {allowed}"


def _verdict(check: Check) -> str:
    return "pass" if check.passed else "FAIL"


def _flat(text: str) -> str:
    return " ".join(text.split())


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    """A Markdown table whose columns are aligned; the first row is its head."""
    cells = [[_flat(cell).replace("|", "\\|") for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    padded = [[cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in cells]
    lines = [f"| {' | '.join(row)} |" for row in padded]
    return [lines[0], f"|{'|'.join('-' * (width + 2) for width in widths)}|", *lines[1:]]


def _claim(check: Check) -> str:
    return f"{escape(check.claim)}<small>{escape(check.source)}</small>"


def _mark(check: Check) -> tuple[str, str, str]:
    return "verdict", _verdict(check), "" if check.passed else "fail"


def _head(columns: Iterable[str]) -> str:
    return f"<thead><tr>{''.join(f'<th scope=col>{name}</th>' for name in columns)}</tr></thead>"


def _row(cells: Iterable[tuple[str, str, str]], attributes: str = "") -> str:
    """A row of cells, each with the name of its column, HTML, and a class."""
    inner = "".join(
        f'<td data-name="{name}"{f" class={kind}" if kind else ""}>{text}</td>' for name, text, kind in cells
    )
    return f"<tr{attributes}>{inner}</tr>"


def _form(figures: Iterable[str]) -> str:
    options = "".join(f"<option>{figure}</option>" for figure in figures)
    return (
        '<form><label>Words <input type="search" id="words"></label>'
        f'<label>Figure <select id="figure"><option value="">all</option>{options}</select></label>'
        '<label class="box"><input type="checkbox" id="failed"> only those that failed</label>'
        '<p id="shown" role="status"></p></form>'
    )
