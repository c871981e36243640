"""The files of the models: a model is found by its file, so that nothing lists it.

What a room knows of one model alone, such as a closed form, stands in a folder ``*_of_models`` of that room, in a file
with the name of the model. A model without such a file has what serves all models.
"""

import re
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from lsvib.errors import InputError
from lsvib.numbers import shown

# A file of this room in which a line begins so is the file of a model, whose name is that of the file. The section of
# the book that derives the model decides its place among the others.
_MODEL = re.compile(r"^MODEL = ", re.MULTILINE)
_SECTION = re.compile(r'^    section="([\d.]+)"', re.MULTILINE)


@cache
def model_names() -> tuple[str, ...]:
    """Return the names of all models: by the sections that derive them, then those without a section by name."""
    sections = {name: _SECTION.search(file.read_text("utf-8")) for name, file in _files().items()}
    return tuple(sorted(sections, key=lambda name: (not (found := sections[name]), found[1] if found else "", name)))


def model_module(name: str) -> str:
    """Return the name of the module of a model; ``InputError`` if there is no model of that name."""
    if not isinstance(name, str) or name not in _modules():
        raise InputError(f"model = {shown(name)} is not one of {', '.join(model_names())}.")
    return _modules()[name]


def of_model(folder: ModuleType, model: str, name: str, otherwise: Any) -> Any:
    """Return what a room has of one model alone, by its name in the file of the model; ``otherwise`` without one.

    Arguments: the folder ``*_of_models``; the name of a model that there is.
    """
    return getattr(_file_of(f"{folder.__name__}.{model}"), name, otherwise)


def modules_of(model: str) -> tuple[str, ...]:
    """Return the names of all modules of a model: its own, and those in the folders ``*_of_models``.

    Raises ``InputError`` if there is no model of that name.
    """
    own, package = model_module(model), Path(__file__).parent.parent
    files = (file.relative_to(package.parent) for file in package.glob(f"*/*_of_models/{model}.py"))
    return (own, *sorted(".".join(file.with_suffix("").parts) for file in files))


@cache
def _file_of(module: str) -> ModuleType | None:
    """Return a module, None if there is none of that name."""
    return import_module(module) if find_spec(module) else None


@cache  # one motion asks for its model some thirty times
def _modules() -> dict[str, str]:
    """Return the module of each model by its name."""
    inside = {name: file.relative_to(Path(__file__).parent).with_suffix("") for name, file in _files().items()}
    return {name: ".".join((__package__, *path.parts)) for name, path in inside.items()}


@cache
def _files() -> dict[str, Path]:
    """Return the file of each model by its name."""
    files = sorted(Path(__file__).parent.rglob("*.py"))
    return {file.stem: file for file in files if _MODEL.search(file.read_text("utf-8"))}
