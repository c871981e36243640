"""Wrap the documentation at 120 characters: ``python tests/tools/wrap_docs.py FILE.md ...``.

Paragraphs and list items with a line that is too long are filled anew; what stands between backquotes, and a link, is
not broken. Tables, code, headings, quotations, HTML and the texts of links stay as they are: in them a new line has a
meaning. Nothing but the places of line breaks changes.
"""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

WIDTH = 120
_FENCE = re.compile(r"^\s*(```|~~~)")
_FIXED = re.compile(r"^\s*(\|.*\|$|[#<>]|!\[|\[[^]]+\]:)")  # table, heading, HTML, quotation, picture, link
_ITEM = re.compile(r"^(\s*)([*+-]|\d+[.)]) +")
_WHOLE = re.compile(r"!?\[[^]]*\]\([^)]*\)|`[^`]*`")  # a link, or code
_STARTS = re.compile(r"[>|]|([*+-]|#+|=+|\d+[.)])$")  # a word that would begin something else if it began a line


def wrapped(text: str) -> str:
    """Return the text with all paragraphs and list items filled that have a line too long."""
    blocks = _blocks(text.split("\n"))
    return "\n".join(line for block, prose in blocks for line in (_filled(block) if prose else block))


def _blocks(lines: list[str]) -> Iterator[tuple[list[str], bool]]:
    """Yield the lines in blocks, and whether a block is prose: a paragraph or a list item; other lines come singly."""
    block: list[str] = []
    fenced = False
    for line in lines:
        fence = bool(_FENCE.match(line))
        alone = fenced or fence or not line.strip() or bool(_FIXED.match(line))
        alone = alone or (not block and line.startswith("    "))  # code by indentation
        if block and (alone or _ITEM.match(line)):
            yield block, True
            block = []
        if alone:
            yield [line], False
        else:
            block.append(line)
        fenced ^= fence
    if block:
        yield block, True


def _filled(block: list[str]) -> list[str]:
    breaks = any(line.endswith(("  ", "\\")) for line in block[:-1])
    if max(map(len, block)) <= WIDTH or breaks:
        return block
    item = _ITEM.match(block[0])
    first = item.group(0) if item else ""
    indent = " " * len(first)
    text = " ".join([block[0][len(first) :].strip(), *(line.strip() for line in block[1:])])
    lines, current = [], first
    for word in _words(text):
        begins = current in (first, indent)
        if not begins and len(current) + 1 + len(word) > WIDTH:
            lines.append(current)
            current, begins = indent, True
        current += word if begins else f" {word}"
    return [*lines, current]


def _words(text: str) -> list[str]:
    """Return the words of a text; those that must not be parted, or must not begin a line, are one word."""
    held = _WHOLE.sub(lambda found: found.group(0).replace(" ", "\0"), text)
    words: list[str] = []
    for word in held.split():
        if words and _STARTS.match(word):
            words[-1] += f" {word}"
        else:
            words.append(word)
    return [word.replace("\0", " ") for word in words]


def main() -> None:
    """Wrap the files of the command line."""
    if len(sys.argv) < 2:
        sys.exit("usage: python tests/tools/wrap_docs.py FILE.md ...")
    for path in map(Path, sys.argv[1:]):
        text = path.read_text(encoding="utf-8")
        if (new := wrapped(text)) != text:
            path.write_text(new, encoding="utf-8")
            print(f"{path}: wrapped")


if __name__ == "__main__":
    main()
