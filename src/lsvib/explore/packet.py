"""What a redraw sends to the browser: one message of few pieces, however many columns of sources it fills.

A source that changes by itself is a message, and each array in it a piece more. A piece costs server and browser half a
millisecond, whatever it holds: the fifty pieces of a redraw took longer than the engine.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from bokeh.core import properties
from bokeh.model import DataModel
from bokeh.models import ColumnDataSource, CustomJS

Columns = Mapping[str, Sequence[Any]]
"""The columns of a source by name. A row is a number, words, the numbers of a line, or the pixels of an image."""

_UNPACK = Path(__file__).with_suffix(".js").read_text(encoding="utf-8")


class Content(DataModel):
    """What was sent last, ``pieces``: JSON that says which row is where; the numbers of all lines; each image."""

    pieces = properties.Any(default=["{}", np.empty(0)])


class Packet:
    """Fills sources of a page in the browser; on the server they stay empty."""

    def __init__(self, sources: Mapping[str, ColumnDataSource]) -> None:
        self.content = Content(name="packet")
        self.content.js_on_change(
            "pieces", CustomJS(args={"content": self.content, "sources": dict(sources)}, code=_UNPACK)
        )
        self._filled: dict[str, Columns] = {}
        self._waiting: set[str] = set()

    def fill(self, name: str, columns: Columns) -> None:
        """Let a source hold columns as soon as they are sent."""
        self._filled[name] = columns
        self._waiting.add(name)

    def send(self) -> None:
        """Send what was filled since the last time."""
        self.content.pieces = pack({name: self._filled[name] for name in sorted(self._waiting)})
        self._waiting.clear()

    def send_all(self) -> None:
        """Send all, to a browser that has just opened the page."""
        self._waiting.update(self._filled)
        self.send()


def pack(sources: Mapping[str, Columns]) -> list[Any]:
    """Return the pieces that say what columns of sources hold."""
    lines: list[np.ndarray] = [np.empty(0)]
    images: list[np.ndarray] = []
    length = 0

    def place(row: Any) -> Any:
        """Put a row into a piece, if it is an array; return where it is, or the row itself."""
        nonlocal length
        if not isinstance(row, np.ndarray):
            return row
        if row.ndim == 2:
            images.append(row)
            return {"piece": len(images)}
        lines.append(row)
        length += row.size
        return {"piece": 0, "begin": length - row.size, "size": row.size}

    text = {
        name: {key: [place(row) for row in rows] for key, rows in columns.items()} for name, columns in sources.items()
    }
    return [json.dumps(text), np.concatenate(lines, dtype=float), *images]
