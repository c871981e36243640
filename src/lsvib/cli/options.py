"""Options that several commands share, and how KEY=VALUE items are read."""

import os
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from lsvib.errors import InputError
from lsvib.models.model import model_names

# For options with several values: no --no-OPTION, or --empty-OPTION, beside them.
ONE_VALUE = {"negative_iterable": ""}
_MODELS = f"{', '.join(model_names()[:-1])} or {model_names()[-1]}."
MODEL = Parameter(help=_MODELS)
MODEL_IF_GIVEN = Parameter(help=f"Model of the drive: {_MODELS.replace(',', ' (the default),', 1)}")
RESUME = Parameter(help="Motion after a seizure: contact_sign or at_once.")
Changes = Annotated[
    list[str] | None,
    Parameter(name="--set", help="KEY=VALUE: change a parameter of the drive; repeatable.", **ONE_VALUE),
]
SceneFile = Annotated[Path | None, Parameter(help="YAML file of a scene to start from.")]
StartItems = Annotated[
    list[str] | None, Parameter(consume_multiple=True, help="State at t = 0: u=RAD w=RAD_PER_S ...", **ONE_VALUE)
]
OutFile = Annotated[Path | None, Parameter(help="netCDF file to write; one that is there is replaced.")]
AsJson = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object.")]


def pairs(items: list[str] | None) -> dict[str, str]:
    """Split KEY=VALUE items; the values stay text, which the models read and check.

    Raises :class:`~lsvib.errors.InputError` if an item has another form or a key is given twice.
    """
    found: dict[str, str] = {}
    for item in items or []:
        key, equals, value = item.partition("=")
        if not equals or not key or not value:
            raise InputError(f"{item!r} is not of the form KEY=VALUE.")
        if key in found:
            raise InputError(f"{key} is given twice, as {found[key]} and as {value}; give it once.")
        found[key] = value
    return found


def refuse_results_of_the_workflow(*files: Path | None) -> None:
    """Refuse files in the folders below ``results`` of the workflow, which could not distinguish them from its own.

    Raises :class:`~lsvib.errors.InputError`.
    """
    for file in filter(None, files):
        try:
            above = list(Path(os.path.realpath(file)).parents)[1:]
        except (OSError, ValueError):
            continue  # it cannot be written at all, which is said where it would be written
        if any(folder.name == "results" and (folder.parent / "Snakefile").is_file() for folder in above):
            raise InputError(f"{file.parent} belongs to the workflow, which fills it by itself; name another folder.")


def ends(option: str, key: str, text: str, form: str) -> tuple[str, str]:
    """Split the value of KEY=LOW:HIGH; raises :class:`~lsvib.errors.InputError`, with the ``form``, for another one."""
    low, colon, high = text.partition(":")
    if not colon or ":" in high:
        raise InputError(f"{option}: {key}={text} is not of the form {form}.")
    return low, high
