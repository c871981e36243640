"""Where the dataset and the picture of a figure are made: each figure has a folder, which is found by its name."""

from importlib.util import find_spec

from lsvib.errors import InputError

ROOMS = ("lsvib.figures", "lsvib.bench.figures")


def dataset_module(figure: str) -> str:
    """Return the name of the module with ``build`` and ``checks`` of a figure; ``InputError`` if there is no figure."""
    return f"{_folder(figure)}.dataset"


def picture_module(figure: str) -> str:
    """Return the name of the module with ``draw`` of a figure; ``InputError`` if there is no figure."""
    return f"{_folder(figure)}.picture"


def _folder(figure: str) -> str:
    for room in ROOMS:
        if figure.isidentifier() and find_spec(f"{room}.{figure}") is not None:
            return f"{room}.{figure}"
    raise InputError(f"figure = {figure!r} has no folder in {' or '.join(ROOMS)}.")
