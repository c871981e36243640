"""What the command says on the terminal: progress, one sentence for what it refuses, and its exit code."""

import logging
import os
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import Any, NoReturn

from lsvib.errors import LsvibError


def told(call: Callable[[], object], also: type[Exception]) -> None:
    """Run a command; unacceptable input ends in one sentence on the error stream and exit code 2.

    ``also``: the errors of the reader of the command line, whose sentences are for the user too.
    """
    log = logging.getLogger("lsvib")
    log.addHandler(_SPOKEN)  # the same one however often, so nothing is said twice
    log.setLevel(logging.INFO)
    warnings.showwarning = _say  # type: ignore[assignment]  # it needs no more than the message
    try:
        call()
        if sys.stdout is not None:  # None: the standard output is closed
            sys.stdout.flush()
    except BrokenPipeError:  # the reader of our output, such as head, has seen enough
        _to_nowhere(sys.stdout)
    except KeyboardInterrupt:
        _fail("interrupted.", 130)  # as a shell reports a program that SIGINT ended
    except MemoryError:
        _fail("there is not enough memory; take fewer cells or samples.")
    except (also, LsvibError) as error:
        _fail(str(error))
    except OSError as error:
        # What we open ourselves is said in the package's own errors; so this is one of the standard streams.
        _to_nowhere(sys.stdout)
        _fail(f"Cannot write to the standard output: {error.strerror or error}.")


class ProgressLine:
    """Show on the error stream how far a work is: a line that is rewritten, or in a log one line for every 5 %."""

    def __init__(self, what: str = "rows") -> None:
        self.shown, self.what = -1, what

    def __call__(self, done: int, total: int) -> None:
        terminal = sys.stderr.isatty()
        percent = 100 * done // total
        step = percent if terminal else percent // 5
        if step == self.shown or total == 1:  # one piece of work is not far until it is done
            return
        self.shown = step
        end = "\n" if done == total or not terminal else ""
        print(
            f"{chr(13) if terminal else ''}{percent:3d} % of {total} {self.what}", end=end, file=sys.stderr, flush=True
        )


class _Spoken(logging.Handler):
    """Show a record of the package's log as one sentence on the error stream."""

    def emit(self, record: logging.LogRecord) -> None:
        if sys.stderr is not None:
            print(f"lsvib: {record.getMessage()}", file=sys.stderr, flush=True)


_SPOKEN = _Spoken()


def _say(message: Warning | str, category: type[Warning], *where: Any) -> None:
    """Show a warning as one sentence on the error stream, without the line of code that it comes from."""
    if sys.stderr is not None:
        print(f"lsvib: {' '.join(str(message).split())}", file=sys.stderr)


def _fail(text: str, code: int = 2) -> NoReturn:
    """Say one sentence on the error stream, in one line that can be printed, and end with an exit code."""
    line = "".join(letter if letter.isprintable() else "?" for letter in " ".join(text.split()))
    if sys.stderr is not None:
        with suppress(OSError):  # nobody can be told
            print(f"lsvib: {line}", file=sys.stderr, flush=True)
    sys.exit(code)


def _to_nowhere(stream: Any) -> None:
    """Let the rest of a stream, which cannot be written, vanish, so that Python does not complain at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
