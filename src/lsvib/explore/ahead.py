"""Compile what the page needs for models with more than two states, in a process of its own, beside the page.

The first page needs the engine for two states only, which takes a fraction of the time. The process fills the cache of
compiled kernels, from which the server reads them when such a model is chosen.
"""

import os
import subprocess
import sys

from lsvib.api import DRIVES, drive_class
from lsvib.drives.registry import find_model
from lsvib.engine.kernels.jit import OPTIONS
from lsvib.explore import answers
from lsvib.explore.view import View

_GIVES_WAY = 10  # niceness, so that the page answers meanwhile
_POINTS = 2  # of the amplitude curve


class Ahead:
    """The process, which is started by :meth:`start`."""

    def __init__(self) -> None:
        self._process: subprocess.Popen | None = None

    def start(self) -> None:
        """Start the process; without a cache that both share, everything is compiled here and now."""
        if OPTIONS["cache"]:
            # In a session of its own: Ctrl+C is for the server, which ends the process.
            self._process = subprocess.Popen([sys.executable, "-m", __name__], start_new_session=True)
        else:
            compile_larger_models()

    def ready(self, model: str) -> bool:
        """Return whether a model can be shown without compiling for it; also if the process has failed."""
        running = self._process is not None and self._process.poll() is None
        return len(find_model(model).states) == 2 or not running

    def stop(self) -> None:
        """End the process, if it is still at work."""
        if self._process is not None:
            self._process.terminate()
            self._process.wait()


def compile_larger_models() -> None:
    """Ask of each model with more than two states what the page asks of it."""
    for model in DRIVES:
        if len(find_model(model).states) > 2:
            view = View(drive_class(model)())
            window = answers.window_around(view.drive, answers.followed(view))
            next(answers.label_rows(view.drive, window, answers.COARSE))
            next(answers.amplitudes(view, _POINTS))


if __name__ == "__main__":
    os.nice(_GIVES_WAY)
    compile_larger_models()
