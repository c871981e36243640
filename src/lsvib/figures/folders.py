"""The folder of each figure: its name is found there, and so are its settings, dataset, picture and caption."""

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from pkgutil import iter_modules

from lsvib.errors import InputError

_DEFAULT, _ACCURACY = "lsvib.figures", "benchmarks.figures"
ROOMS = (_DEFAULT, _ACCURACY)


def default_figures() -> tuple[str, ...]:
    """Return the names of the figures that a bare ``snakemake`` builds: those of the chapter first."""
    return _found(_DEFAULT)


def accuracy_figures() -> tuple[str, ...]:
    """Return the names of the figures of the target ``accuracy``."""
    return _found(_ACCURACY)


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
def _found(room: str) -> tuple[str, ...]:
    """Return the names of the folders in which a dataset is made: the numbered ones first, each part by its names."""
    names = [found.name for found in iter_modules([str(_path(room))]) if found.ispkg]
    figures = [name for name in names if (_path(room) / name / "dataset.py").is_file()]
    return tuple(sorted(figures, key=lambda name: (not name.startswith("fig"), name)))


def _folder(figure: str) -> str:
    for room in ROOMS:
        if figure.isidentifier() and find_spec(f"{room}.{figure}") is not None:
            return f"{room}.{figure}"
    raise InputError(f"figure = {figure!r} has no folder in {' or '.join(ROOMS)}.")


def _path(package: str) -> Path:
    return Path(import_module(package).__path__[0])
