"""The files of the models: a model is found by its file, so that nothing lists it."""

import re
from functools import cache
from pathlib import Path

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
