"""The folder of each figure: its name is found there, and so are its settings, dataset, picture and caption.

The figures of the benchmarks have theirs beside the package, in a checkout only: an installed lsvib knows their names,
so that a configuration may have their sections, and says that they are not there.
"""

from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules

from lsvib.errors import InputError

_DEFAULT, _ACCURACY = "lsvib.figures", "benchmarks.figures"
_BENCHMARKS = ("ablation", "map_precision", "rival_verdicts", "stability_sweeps", "work_precision")


def default_figures() -> tuple[str, ...]:
    """Return the names of the figures that a bare ``snakemake`` builds: those of the chapter first."""
    return _found()


def accuracy_figures() -> tuple[str, ...]:
    """Return the names of the figures of the target ``accuracy``."""
    return _BENCHMARKS


def settings_module(figure: str) -> str:
    """Return the name of the module with the ``Settings`` of a figure; ``InputError`` if there is no figure."""
    return f"{_folder(figure)}.settings"


def dataset_module(figure: str) -> str:
    """Return the name of the module with ``build`` and ``checks`` of a figure; ``InputError`` if there is no figure."""
    return f"{_folder(figure)}.dataset"


def picture_module(figure: str) -> str:
    """Return the name of the module with ``draw`` of a figure; ``InputError`` if there is no figure."""
    return f"{_folder(figure)}.picture"


def caption_file(figure: str) -> Path:
    """Return the file with the caption of a figure, in reStructuredText; ``InputError`` if there is no figure."""
    return _path(_folder(figure)) / "caption.rst"


@cache
def _found() -> tuple[str, ...]:
    """Return the names of the folders in which a dataset is made: the numbered ones first, each part by its names."""
    room = _path(_DEFAULT)
    figures = [found.name for found in iter_modules([str(room)]) if (room / found.name / "dataset.py").is_file()]
    return tuple(sorted(figures, key=lambda name: (not name.startswith("fig"), name)))


def _folder(figure: str) -> str:
    room = _ACCURACY if figure in _BENCHMARKS else _DEFAULT
    with suppress(ModuleNotFoundError):  # no benchmarks, or others
        if figure.isidentifier() and find_spec(f"{room}.{figure}") is not None:
            return f"{room}.{figure}"
    if room == _ACCURACY:
        raise InputError(f"figure {figure} does not exist here: the benchmarks come with a checkout of lsvib only.")
    raise InputError(f"figure = {figure!r} has no folder in {_DEFAULT}.")


def _path(package: str) -> Path:
    return Path(import_module(package).__path__[0])
