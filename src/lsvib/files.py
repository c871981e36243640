"""Files that appear whole or not at all."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lsvib.errors import LsvibError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Give a temporary path beside ``path``; when the block ends well, the file there replaces ``path`` in one step.

    A reader, or the next run after a kill at any moment, sees the old file or the new one, never half of one. The
    temporary name carries the process id, so that a process left over from a killed run cannot write into ours; it
    starts with ``.`` and ends in ``.part``. A block that fails leaves ``path`` as it was and no temporary file.
    Raises ``LsvibError`` if the file cannot be written (no such folder, no permission, disk full).
    """
    path = Path(path)
    if not path.name:
        raise LsvibError(f"Cannot write {path}: it is not the name of a file.")
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield part
        os.replace(part, path)
    except OSError as error:
        raise LsvibError(f"Cannot write {path}: {error.strerror or error}.") from error
    finally:
        with suppress(OSError):  # it is not there, or the error that is on its way says why
            part.unlink()


def make_folder(path: Path) -> Path:
    """Make a folder with all above it, unless it exists, and return it; raises ``LsvibError`` if that fails."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LsvibError(f"Cannot make the folder {path}: {error.strerror or error}.") from error
    return path


def write_text(text: str, path: str | os.PathLike[str]) -> None:
    """Write ``text`` to ``path`` as UTF-8, whole or not at all; raises ``LsvibError`` like :func:`replacing`."""
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")


def write_json(value: Any, path: str | os.PathLike[str]) -> None:
    """Write ``value`` to ``path`` as indented JSON, whole or not at all; raises ``LsvibError`` like :func:`replacing`.

    NaN and infinities are not JSON and raise ``ValueError``.
    """
    write_text(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n", path)
