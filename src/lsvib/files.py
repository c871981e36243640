"""Files that appear whole or not at all."""

import glob
import json
import os
import shutil
import signal
import stat
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from lsvib.errors import LsvibError

File = str | os.PathLike[str]
WRITING = threading.Lock()  # held while a file is written that an interrupt must not leave half done

# How a file of each kind begins. What begins otherwise was not written by us and is not replaced by a command.
_BEGINNINGS = {
    "netCDF": (b"\x89HDF", b"CDF"),
    "PNG": (b"\x89PNG",),
    "PDF": (b"%PDF",),
    "JSON": (b"[", b"{"),
    "HTML": (b"<!DO", b"<htm"),
}


def target_of(path: File, make_folder: bool = False) -> Path:
    """Return the file that writing to ``path`` makes or replaces; links are followed.

    ``make_folder``: a folder that does not exist will be made, so the nearest one above that exists decides. Raises
    ``LsvibError`` if no regular file can be written there.
    """
    path = Path(path)
    if path.name in ("", ".."):
        raise LsvibError(f"Cannot write {path}: it is not the name of a file.")
    if any("\ud800" <= letter <= "\udfff" for letter in str(path)):  # what Python makes of bytes that are no UTF-8
        raise LsvibError(f"Cannot write {path}: its name is not valid UTF-8.")
    try:
        target = Path(os.path.realpath(path))
        folder = target.parent
        if make_folder:
            while not os.path.lexists(folder):
                folder = folder.parent
        if not folder.exists():
            raise LsvibError(f"Cannot write {path}: the folder {folder} does not exist.")
        if not folder.is_dir():
            raise LsvibError(f"Cannot write {path}: {folder} is not a folder.")
        mode = target.stat().st_mode if os.path.lexists(target) else None
        with suppress(FileNotFoundError):  # as it should; a name that is too long is refused here
            _part(_part(target)).lstat()
    except (OSError, ValueError) as error:  # ValueError: a null character
        raise LsvibError(f"Cannot write {path}: {getattr(error, 'strerror', None) or error}.") from None
    if mode is not None and not stat.S_ISREG(mode):
        what = "a folder" if stat.S_ISDIR(mode) else "a device, pipe or socket"
        raise LsvibError(f"Cannot write {path}: it is {what}, not a regular file.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise LsvibError(f"Cannot write {path}: the folder {folder} is not writable.")
    if mode is not None and not os.access(target, os.W_OK):
        raise LsvibError(f"Cannot write {path}: the file is write-protected.")
    return target


class Outputs:
    """The files that a command writes: all checked before its work begins, and all put in place or none.

    ``files``: pairs of a path and its kind (netCDF, PNG, PDF, JSON, HTML; empty for any); ``inputs``: what the command
    reads; ``make_folders``: folders that do not exist are made. A file that exists is replaced if it is of the same
    kind, or empty, and neither an input nor another output. Raises ``LsvibError``.
    """

    def __init__(
        self,
        files: Sequence[tuple[File, str]],
        inputs: Sequence[File] = (),
        make_folders: bool = False,
    ) -> None:
        self.paths = [Path(path) for path, _ in files]
        self.targets = [target_of(path, make_folders) for path in self.paths]
        for k, (target, (path, kind)) in enumerate(zip(self.targets, files, strict=True)):
            for source in inputs:
                if _same(target, Path(source)):
                    raise LsvibError(f"Cannot write {path}: it is {source}, which this command reads.")
            if any(_same(target, other) for other in self.targets[:k]):
                raise LsvibError(f"Cannot write {path}: this command writes another of its files there.")
            if kind and not _replaceable(target, kind):
                raise LsvibError(f"Cannot write {path}: the file that is there is no {kind} file; remove it first.")

    @contextmanager
    def writing(self) -> Iterator[list[Path]]:
        """Give a temporary path for each file; when the block ends well, all are put in place, else none."""
        parts, made, placed = [_part(target) for target in self.targets], [], []
        try:
            for target in self.targets:
                made += [folder for folder in target.parents if not folder.exists()]
                target.parent.mkdir(parents=True, exist_ok=True)
                _remove_stale(target)
            yield parts
            for part, target in zip(parts, self.targets, strict=True):
                if not (new := not target.exists()):
                    shutil.copymode(target, part)
                os.replace(part, target)
                placed += [target] if new else []
        except BaseException as error:
            for file in (*placed, *parts):
                file.unlink(missing_ok=True)
            for folder in sorted(made, key=lambda folder: -len(folder.parts)):
                with suppress(OSError):  # somebody else has put something there
                    folder.rmdir()
            if isinstance(error, OSError):
                raise LsvibError(f"Cannot write {self.paths[len(placed)]}: {error.strerror or error}.") from error
            if isinstance(error, LsvibError):
                text = str(error)
                for part, path in zip(parts, self.paths, strict=True):
                    text = text.replace(str(part), str(path))
                raise type(error)(text) from error
            raise


def _same(target: Path, other: Path) -> bool:
    return target == Path(os.path.realpath(other)) or (
        target.exists() and other.exists() and os.path.samefile(target, other)
    )


def _replaceable(target: Path, kind: str) -> bool:
    try:
        with target.open("rb") as file:
            start = file.read(4)
    except FileNotFoundError:
        return True
    except OSError as error:
        raise LsvibError(f"Cannot write {target}: {error.strerror or error}.") from error
    return not start or start.startswith(_BEGINNINGS[kind])


def _part(target: Path) -> Path:
    """The temporary file; a process left over from a killed run, which has another id, cannot write into ours."""
    return target.with_name(f".{target.name}.{os.getpid()}.part")


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


def _remove_stale(target: Path) -> None:
    """Remove temporary files of processes that were killed while they wrote ``target``.

    A process of another machine, which this one does not know, writes its file from minute to minute.
    """
    for part in target.parent.glob(f".{glob.escape(target.name)}.*.part"):
        number = part.name.split(".")[-2]
        if number.isdecimal() and not os.path.exists(f"/proc/{number}"):
            with suppress(OSError):  # another run has removed it
                if time.time() - part.stat().st_mtime > 3600:
                    part.unlink()


@contextmanager
def replacing(path: File) -> Iterator[Path]:
    """Give a temporary path beside ``path``; when the block ends well, the file there replaces ``path`` in one step.

    A reader, or the next run after a kill at any moment, sees the old file or the new one, never half of one. Raises
    ``LsvibError`` if the file cannot be written.
    """
    with Outputs([(path, "")]).writing() as (part,):
        yield part


def write_text(text: str, path: File) -> None:
    """Write ``text`` to ``path`` as UTF-8, as :func:`replacing` does."""
    with replacing(path) as part:
        part.write_text(text, encoding="utf-8")


def write_json(value: Any, path: File) -> None:
    """Write ``value`` to ``path`` as indented JSON, as :func:`replacing` does; NaN raises ``ValueError``."""
    write_text(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False) + "\n", path)
