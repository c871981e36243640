"""The figures, their settings, and the check of a configuration, which names a mistake in one sentence.

A figure is a module of this package, or of ``benchmarks.figures``, with a function ``build``; two figures that share
one are made in it by lines ``NAME = Figure(…)``. The values of settings are those of ``config/config.yaml``, to which
the file beside this module is a link (an installed package holds a copy); their type is the class ``Settings`` in the
module of the figure. The benchmarks come with a checkout only: an installed lsvib knows their names, so that a
configuration may have their sections.
"""

import hashlib
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any, Literal

import yaml
from pydantic import Field, ValidationError, create_model

from lsvib.chapter.settings import DriveChanges, SettingsSection, Unique
from lsvib.drives.complaints import sentence_about
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError
from lsvib.numbers import shown

BENCHMARKS = ("work_precision", "stability_sweeps", "ablation", "measured_drive")
"""The figures of a checkout alone: error against run time, extreme cases, what a scene leaves out, a measured screw."""
_SHARED = {  # figures that are not in a module of their own name
    **dict.fromkeys(("fig8_01", "fig8_02"), "contact_portraits"),
    **dict.fromkeys(("fig8_04", "fig8_05"), "negative_damping"),
}
_PACKAGE = Path(__file__).parents[1]
_CHECKOUT = _PACKAGE.parents[1]
DEFAULT = Path(__file__).with_name("config.yaml")
_NO_FIGURES = ("table_8_1", "assessments", "assessment_samples", "attraction", "chart")  # sections of other things
FIGURES = tuple(name for name in read_yaml(DEFAULT) if name not in (*_NO_FIGURES, *BENCHMARKS))
"""The figures of the package, those of the chapter first: each has a section in ``config/config.yaml``."""
_Name: Any = Literal[*FIGURES, *BENCHMARKS]

PARTS = ("analysis", "maps")
"""Functions of some figures whose results, each a dataset, its ``build`` takes: the analysis of its drives, and maps of
grids of starts. In the workflow each has a rule and a file of its own."""


def module_of(figure: str) -> str:
    """Return the name of the module of a figure; raises ``InputError`` if there is no such figure."""
    if figure in BENCHMARKS:
        if not Path(_CHECKOUT, "benchmarks", "figures").is_dir():
            raise InputError(f"figure {figure} does not exist here: the benchmarks come only with a checkout of lsvib.")
        return f"benchmarks.figures.{figure}"
    if figure not in (*FIGURES, "attraction", "chart"):
        raise InputError(f"figure = {figure!r} is not one of {', '.join((*FIGURES, *BENCHMARKS))}.")
    return f"lsvib.chapter.{_SHARED.get(figure, figure)}"


def load(figure: str) -> Any:
    """Return the figure: its module, or what a module of several has under its name.

    It has ``Settings``, ``build``, ``checks``, ``draw`` and ``CAPTION``; ``attraction`` and ``chart`` have no ``build``
    and no ``checks``. Raises ``InputError`` if there is no such figure.
    """
    name = module_of(figure)
    if figure in BENCHMARKS and str(_CHECKOUT) not in sys.path:
        sys.path.append(str(_CHECKOUT))
    module = import_module(name)
    return getattr(module, figure, module)


@cache
def sources_of(figure: str) -> str:
    """Return a digest of the sources on which the dataset of a figure depends: all of lsvib.

    For a benchmark also those of the benchmarks, and of the references of the tests.
    """
    folders = [_PACKAGE, *(_CHECKOUT / part for part in ("benchmarks", "tests/references") if figure in BENCHMARKS)]
    files = [*sorted(file for folder in folders for file in folder.rglob("*.py")), _PACKAGE / "drives" / "chapter.yaml"]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


class Selection(SettingsSection):
    """What is built, and how, and the drive of all figures; each figure has a section of its own beside it."""

    table_8_1: DriveChanges = Field(
        default=DriveChanges(), description="Parameters of the drive of all figures, which their `drive` changes."
    )

    figures: Annotated[list[_Name], *Unique] | None = Field(
        default=None, min_length=1, description="Figures to build; by default all."
    )
    pathvars: dict[Literal["results", "logs"], str] = Field(
        default={}, description="Output folders of Snakemake, if not results and logs."
    )


class Assessments(Selection):
    """The drives that the target `assessments` assesses."""

    assessments: Annotated[list[Annotated[str, Field(min_length=6)]], *Unique] = Field(
        min_length=1, description="Data sheets of the target `assessments`, YAML files."
    )
    assessment_samples: int = Field(
        ge=64, le=2**24, description="Drives drawn from the uncertainties of each sheet, a power of two."
    )


def checked(configuration: Mapping[str, Any]) -> dict[str, Any]:
    """Return a complete configuration, that of a run of the workflow; raises ``InputError`` in one sentence.

    What Snakemake's option ``--config`` gives has its numbers inside of lists and mappings as text; here they are
    numbers.
    """
    values: dict[str, Any] = _typed(configuration)
    _checked(_configuration(), values)
    for name in selected(values):
        complete_settings(name, given(values, name))
    return values


def _typed(values: Any) -> Any:
    if isinstance(values, Mapping):
        return {key: _typed(value) for key, value in values.items()}
    if isinstance(values, list):
        return [_typed(value) for value in values]
    try:
        return yaml.safe_load(values) if isinstance(values, str) else values
    except yaml.YAMLError:
        return values


def given(configuration: Mapping[str, Any], figure: str) -> dict[str, Any]:
    """Return the section of a figure, its drive with all parameters of ``table_8_1`` that it does not change itself."""
    found, table = configuration.get(figure, {}), configuration.get("table_8_1", {})
    if not (table and isinstance(found, dict) and "drive" in load(figure).Settings.model_fields):
        return found  # type: ignore[no-any-return]
    drive = found.get("drive", {})
    angles = {"lead_angle", "lead_angle_deg"}
    beneath = {key: value for key, value in table.items() if not (key in angles and angles & set(drive))}
    # In alphabetical order, because Snakemake compares parameters as text.
    return {**found, "drive": dict(sorted({**beneath, **drive}.items()))}


def section(configuration: Mapping[str, Any], figure: str) -> Mapping[str, Any]:
    """Return the section of one figure, empty if there is none; raises ``InputError`` about anything but sections."""
    known = (*Assessments.model_fields, "attraction", "chart", *FIGURES, *BENCHMARKS)
    for key in configuration:
        if key not in known:
            raise InputError(f"{shown(key)} is not a known key; the known keys are {', '.join(known)}.")
    _checked(Selection, {key: value for key, value in configuration.items() if key in Selection.model_fields})
    _checked(load(figure).Settings, configuration.get(figure, {}), (figure,))
    return given(configuration, figure)


def selected(configuration: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the names of the figures to build: those that the configuration lists, or else all that are here."""
    here = Path(_CHECKOUT, "benchmarks").is_dir()
    return tuple(configuration.get("figures") or (*FIGURES, *(BENCHMARKS if here else ())))


def complete_settings(figure: str, section: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a figure: those given, as they are, and its defaults; ``InputError`` in one sentence."""
    settings = _checked(load(figure).Settings, section, (figure,))
    absent = set(type(settings).model_fields) - set(section)
    return {**section, **settings.model_dump(mode="json", include=absent, exclude_none=True)}


def standard_settings(figure: str) -> dict[str, Any]:
    """Return the settings of a figure that come with the package; raises ``InputError`` if there is no such figure."""
    return complete_settings(figure, section(read_yaml(DEFAULT), figure))


@cache
def _configuration() -> type[SettingsSection]:
    sections: dict[str, Any] = {name: (load(name).Settings, ...) for name in ("attraction", "chart")}
    # A section that is missing is no fault unless its figure is to be built.
    sections |= {name: (load(name).Settings, None) for name in (*FIGURES, *BENCHMARKS)}
    words = "Configuration of the workflow; SI units throughout."
    return create_model("Configuration", __base__=Assessments, __doc__=words, **sections)


def _checked(model: type[SettingsSection], values: Any, place: Sequence[str] = ()) -> Any:
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise InputError(sentence_about(model, error, place)) from None
