"""The application that the commands join, its entry point, and what it says on the terminal."""

import json
import logging
import os
import signal
import socket
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any, NoReturn

from cyclopts import App, CycloptsError, MissingArgumentError, UnusedCliTokensError

from lsvib import __version__, cli
from lsvib.errors import LsvibError
from lsvib.files import WRITING

app = App(
    name="lsvib",
    help="Friction-induced vibration of lead-screw drives, computed exactly from event to event.",
    version=__version__,
    result_action="return_value",
    suppress_keyboard_interrupt=False,  # an interrupt is said below
)
app.register_install_completion_command(help="Install completion of commands and options for bash, zsh or fish.")


def main() -> None:
    """Run the command; unacceptable input ends in one sentence on the error stream and exit code 2.

    All modules of this package are imported first, so that their commands join ``app``: a new command is a new file.
    """
    for module in iter_modules(cli.__path__, f"{cli.__name__}."):
        import_module(module.name)
    with _heeding_interrupts():
        run(lambda: app(sys.argv[1:], exit_on_error=False, print_error=False))


def run(call: Callable[[], object]) -> None:
    """Run a command; what it refuses, and the log and warnings of the package, are single sentences."""
    _suit_the_terminal()
    log = logging.getLogger("lsvib")
    log.addHandler(_SENTENCES)  # the same one however often, so nothing is said twice
    log.setLevel(logging.INFO)
    warnings.showwarning = lambda message, *more, **where: _say(str(message))
    try:
        call()
        if sys.stdout is not None:  # None: the standard output is closed
            sys.stdout.flush()
    except BrokenPipeError:  # the reader of our output, such as head, has seen enough
        _discard(sys.stdout)
    except KeyboardInterrupt:
        _fail("interrupted.", 130)  # as a shell reports a program that SIGINT ended
    except MemoryError:
        _fail("there is not enough memory; use fewer cells or samples.")
    except MissingArgumentError as error:
        option = error.keyword or (error.argument and error.argument.name)
        _fail(f"{' '.join(error.command_chain or ())} needs a value for {option}; see --help.")
    except UnusedCliTokensError as error:
        _fail(f"{' '.join(error.unused_tokens or ())} is not expected; to change a parameter, give --set KEY=VALUE.")
    except (CycloptsError, LsvibError) as error:
        _fail(str(error))
    except OSError as error:
        # Files that we open ourselves raise errors of the package; this is a file of the shell, or a standard stream.
        if error.filename is None:
            _discard(sys.stdout)
        _fail(f"Cannot write to {error.filename or 'the standard output'}: {error.strerror or error}.")


def show(result: Mapping[str, Any], as_json: bool, text: Iterable[str], out: Path | None = None) -> None:
    """Print a result as one JSON object, or its ``text``, in lines, for people; ``out``: a file that was written."""
    if as_json:
        print(json.dumps(result, indent=2, allow_nan=False))
        return
    print(*([] if out is None else [f"wrote {out}"]), *text, sep="\n")


def _suit_the_terminal() -> None:
    """Write what a stream has no letter for as ?, and lines of a readable width, whatever the environment says."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    columns = os.environ.get("COLUMNS", "")
    if columns and not (columns.isdecimal() and 40 <= int(columns) <= 10_000):
        del os.environ["COLUMNS"]


@contextmanager
def _heeding_interrupts() -> Iterator[None]:
    """End the process a second after Ctrl+C where it is deep in a kernel, which does not come back to Python.

    A file that is being written comes first.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    reader, writer = socket.socketpair()  # Windows takes no pipe for it
    writer.setblocking(False)
    before = signal.set_wakeup_fd(writer.fileno(), warn_on_full_buffer=False)

    def watch() -> None:
        """Wait for an interrupt, or for the end of the command."""
        with reader:
            while (got := reader.recv(1)) != bytes([signal.SIGINT]):
                if not got:  # the command has ended
                    return
        with WRITING:
            pass
        time.sleep(1.0)  # in which Python ends the command itself, if it can
        if running:
            _say("interrupted.")
            os._exit(130)

    running = [True]
    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        running.clear()
        signal.set_wakeup_fd(before)
        writer.close()


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
        start, end = "\r" if terminal else "", "\n" if done == total or not terminal else ""
        print(f"{start}{percent:3d} % of {total} {self.what}", end=end, file=sys.stderr, flush=True)


class _Sentences(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        _say(record.getMessage())


_SENTENCES = _Sentences()


def _say(text: str) -> None:
    """Print one line on the error stream, of letters that can be printed."""
    line = "".join(letter if letter.isprintable() else "?" for letter in " ".join(text.split()))
    if sys.stderr is not None:
        with suppress(OSError):  # nobody is there to read it
            print(f"lsvib: {line}", file=sys.stderr, flush=True)


def _fail(text: str, code: int = 2) -> NoReturn:
    _say(text)
    sys.exit(code)


def _discard(stream: Any) -> None:
    """Let the rest of a stream, which cannot be written, vanish, so that Python does not complain at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
