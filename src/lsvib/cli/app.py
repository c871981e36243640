"""The application that the commands join, and its entry point."""

import sys
from importlib import import_module
from pkgutil import iter_modules

from cyclopts import App, CycloptsError

from lsvib import __version__, cli
from lsvib.cli.app import told

app = App(
    name="lsvib",
    help="Friction-induced vibration of lead-screw drives, computed exactly from event to event.",
    version=__version__,
    result_action="return_value",
)


def main() -> None:
    """Run the command; unacceptable input ends in one sentence on the error stream and exit code 2.

    All modules of this package are imported first, so that their commands join ``app``: a new command is a new file.
    """
    for module in iter_modules(cli.__path__, f"{cli.__name__}."):
        import_module(module.name)
    told(lambda: app(sys.argv[1:], exit_on_error=False, print_error=False), CycloptsError)
