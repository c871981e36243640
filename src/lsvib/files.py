"""Files that appear whole or not at all."""

import glob
import json
import os
import shutil
import signal
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lsvib.errors import LsvibError

File = str | os.PathLike[str]
_ABANDONED = 3600.0  # s without a write, after which a temporary file is that of a process that was killed
WRITING = threading.Lock()  # held while a file is written that an interrupt must not leave half done


def check_outputs(paths: Sequence[File], inputs: Sequence[File] = ()) -> None:
    """Raise ``LsvibError`` about what cannot be written, or is read as well, before a long work begins."""
    targets, read = [Path(os.path.realpath(path)) for path in paths], {os.path.realpath(path) for path in inputs}
    for path, target in zip(paths, targets, strict=True):
        try:
            problem = _problem(target)
        except OSError as error:  # such as a name that is too long
            problem = error.strerror or str(error)
        if str(target) in read:
            problem = "this command reads it"
        elif targets.count(target) > 1:
            problem = "this command writes two of its files there"
        if problem:
            raise LsvibError(f"Cannot write {path}: {problem}.")


def _problem(target: Path) -> str:
    """Say why a file cannot be written, or nothing; folders that do not exist are made."""
    folder = next(folder for folder in target.parents if folder.exists())
    if not folder.is_dir():
        return f"{folder} is not a folder"
    if not os.access(folder, os.W_OK | os.X_OK):
        return f"the folder {folder} is not writable"
    if target.exists() and not target.is_file():
        return "it is a folder" if target.is_dir() else "it is a device, pipe or socket"
    return "the file is write-protected" if target.exists() and not os.access(target, os.W_OK) else ""


@contextmanager
def replacing(*paths: File) -> Iterator[list[Path]]:
    """Give a temporary path beside each of ``paths``; when the block ends well, what is written there replaces them.

    A reader, or the next run after a kill at any moment, sees an old file or a new one, never half of one; if the block
    fails, all old ones stay. Links are followed, folders made. Raises ``LsvibError`` if a file cannot be written.
    """
    check_outputs(paths)
    targets = [Path(os.path.realpath(path)) for path in paths]
    # Another process may write the same file: a job that outlived its run, beside that of the next run.
    parts = [target.with_name(f".{target.name}.{os.getpid()}.part") for target in targets]
    new = [folder for target in targets for folder in target.parents if not folder.exists()]
    try:
        for target in targets:
            target.parent.mkdir(parents=True, exist_ok=True)
            for old in target.parent.glob(f".{glob.escape(target.name)}.*.part"):  # of a process that was killed
                with suppress(FileNotFoundError):
                    if time.time() - old.stat().st_mtime > _ABANDONED:
                        old.unlink()
        yield parts
        for part, target in zip(parts, targets, strict=True):
            if target.exists():
                shutil.copymode(target, part)
            os.replace(part, target)
    except (OSError, UnicodeError, LsvibError) as error:
        ours = isinstance(error, LsvibError)
        reason = getattr(error, "strerror", None) or error
        text = str(error) if ours else f"Cannot write {getattr(error, 'filename', None) or paths[0]}: {reason}."
        for part, path in zip(parts, paths, strict=True):  # the file is meant, not the temporary one
            text = text.replace(str(part), str(path))
        raise (type(error) if ours else LsvibError)(text) from error
    finally:
        for part in parts:
            part.unlink(missing_ok=True)
        for folder in new:
            with suppress(OSError):  # it is not empty, as it should not be
                folder.rmdir()


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Let a block of the main thread end before Ctrl+C interrupts it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, frame: asked.append(number))
    try:
        with WRITING:
            yield
    finally:
        signal.signal(signal.SIGINT, before)
    if asked:
        raise KeyboardInterrupt


def write_text(text: str, path: File) -> None:
    """Write ``text`` to ``path`` as UTF-8, as :func:`replacing` does."""
    with replacing(path) as (part,):
        part.write_text(text, encoding="utf-8")


def write_json(value: Any, path: File) -> None:
    """Write ``value`` to ``path`` as indented JSON, as :func:`replacing` does; NaN raises ``ValueError``."""
    write_text(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n", path)
