"""Which figures there are, their settings, and one sentence about what is wrong with a configuration.

A figure is a module of this package, or of ``benchmarks.figures``, with a function ``build``: its name is found there.
Figures that share it are made in one module, each by a line ``NAME = Figure(…)``.
The values of settings are those of ``config/config.yaml``, to which the file beside this module is a link (an installed
package holds a copy); their type is the class ``Settings`` in the module of the figure. The benchmarks come with a
checkout only: an installed lsvib knows their names, so that a configuration may have their sections.
"""

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, create_model

from lsvib.errors import InputError
from lsvib.figures.settings import DriveChanges, FigureSettings, SettingsSection, Unique
from lsvib.models.complaints import sentence_about
from lsvib.numbers import shown

DEFAULT = Path(__file__).with_name("config.yaml")
_BENCHMARKS = ("work_precision", "stability_sweeps", "ablation")

PARTS = ("analysis", "maps")
"""Functions of some figures whose results, each a dataset, its ``build`` takes: the analysis of its drives, and maps of
grids of starts. In the workflow each has a rule and a file of its own."""


@cache
def _modules() -> dict[str, tuple[str, str]]:
    """Name and text of the module of each figure of the package: those of the chapter first."""
    found = {}
    for file in Path(__file__).parent.glob("*.py"):
        text = file.read_text(encoding="utf-8")
        names = re.findall(r"^(\w+) = Figure\(", text, re.MULTILINE) or [file.stem] * ("\ndef build(" in text)
        found |= dict.fromkeys(names, (file.stem, text))
    return dict(sorted(found.items(), key=lambda item: (not item[0].startswith("fig"), item[0])))


def default_figures() -> tuple[str, ...]:
    """Return the names of the figures of the package: those of the chapter first."""
    return tuple(_modules())


def figures_with(part: str) -> tuple[str, ...]:
    """Return the names of the figures whose module has a function of this name."""
    return tuple(name for name, (_, text) in _modules().items() if f"\ndef {part}(" in text)


def accuracy_figures() -> tuple[str, ...]:
    """Return the names of the figures of the target ``accuracy``."""
    return _BENCHMARKS


def module_of(figure: str) -> str:
    """Return the name of the module of a figure; raises ``InputError`` if there is no such figure."""
    if figure in _BENCHMARKS:
        with suppress(ModuleNotFoundError):  # no benchmarks, or others
            if find_spec(f"benchmarks.figures.{figure}"):
                return f"benchmarks.figures.{figure}"
        raise InputError(f"figure {figure} does not exist here: the benchmarks come with a checkout of lsvib only.")
    module, _ = _modules().get(figure, (figure, ""))
    if module == figure and figure not in (*_modules(), "attraction", "chart"):
        raise InputError(f"figure = {figure!r} has no file in lsvib.figures.")
    return f"lsvib.figures.{module}"


def load(figure: str) -> Any:
    """Return the figure: its module, or what a module of several has under its name.

    It has ``Settings``, ``build``, ``checks``, ``draw`` and ``CAPTION``; ``attraction`` and ``chart`` have no ``build``
    and no ``checks``. Raises ``InputError`` if there is no such figure.
    """
    module = import_module(module_of(figure))
    return getattr(module, figure, module)


class Selection(SettingsSection):
    """What is built, and how, and the drive of all figures; each figure has a section of its own beside it."""

    table_8_1: DriveChanges = Field(
        default=DriveChanges(), description="Parameters of the drive of all figures; their `drive` differs from it."
    )

    figures: Annotated[list[Literal[*default_figures(), *_BENCHMARKS]], *Unique] | None = Field(
        default=None, min_length=1, description="Figures to build; all if it is left out."
    )
    accuracy_figures: Annotated[list[Literal[*_BENCHMARKS]], *Unique] | None = Field(
        default=None, min_length=1, description="Figures of the target `accuracy`, as `figures`."
    )
    accuracy: dict[Literal[*_BENCHMARKS], dict[str, Any]] = Field(
        default={}, description="What the target `accuracy` changes in the sections of its figures."
    )
    draft: bool = Field(
        default=False,
        description="Whether the figures are a quick look, computed and drawn several in one process, without PDF.",
    )


class Assessments(Selection):
    """The drives that the target `assessments` assesses."""

    assessments: Annotated[list[Annotated[str, Field(min_length=6)]], *Unique] = Field(
        min_length=1, description="Data sheets of the target `assessments`, YAML files."
    )
    assessment_samples: int = Field(
        ge=64, le=2**24, description="Drives drawn from the uncertainties of each sheet, a power of two."
    )


def check(configuration: Mapping[str, Any]) -> None:
    """Check a complete configuration, that of a run of the workflow; raises ``InputError`` in one sentence."""
    _checked(_configuration(), configuration)
    for name in selected(configuration):
        complete_settings(name, given(configuration, name))
    for name in selected(configuration, "accuracy_figures"):
        complete_settings(name, given(configuration, name, accuracy=True))


def given(configuration: Mapping[str, Any], figure: str, *, accuracy: bool = False) -> dict[str, Any]:
    """Return the section of a figure, its drive with all parameters of ``table_8_1`` that it does not change itself.

    ``accuracy``: as the target of that name builds it, with what the section ``accuracy`` has of it on top.
    """
    found, table = configuration.get(figure, {}), configuration.get("table_8_1", {})
    if accuracy:
        found = _merged(found, configuration.get("accuracy", {}).get(figure, {}))
    if not (table and isinstance(found, dict) and "drive" in settings_of(figure).model_fields):
        return found
    drive = found.get("drive", {})
    angles = {"lead_angle", "lead_angle_deg"}
    beneath = {key: value for key, value in table.items() if not (key in angles and angles & set(drive))}
    # In alphabetical order, because Snakemake compares parameters as text.
    return {**found, "drive": dict(sorted({**beneath, **drive}.items()))}


def section(configuration: Mapping[str, Any], figure: str) -> Mapping[str, Any]:
    """Return the section of one figure, empty if there is none; raises ``InputError`` about anything but sections."""
    known = (*Assessments.model_fields, "attraction", "chart", *default_figures(), *accuracy_figures())
    for key in configuration:
        if key not in known:
            raise InputError(f"{shown(key)} is not a known key; the known keys are {', '.join(known)}.")
    _checked(Selection, {key: value for key, value in configuration.items() if key in Selection.model_fields})
    _checked(settings_of(figure), configuration.get(figure, {}), (figure,))
    return given(configuration, figure)


def _merged(below: Any, above: Any) -> Any:
    """Lay one value over another as Snakemake does with two files: mappings key by key, all else as a whole."""
    if not (isinstance(below, Mapping) and isinstance(above, Mapping)):
        return above
    return {**below, **{key: _merged(below.get(key), value) for key, value in above.items()}}


def selected(configuration: Mapping[str, Any], key: str = "figures") -> tuple[str, ...]:
    """Return the names of the figures to build; ``key``: that of a list in the configuration, which may be absent."""
    of_all = (*default_figures(), *(_BENCHMARKS if find_spec("benchmarks") else ()))  # in a checkout benchmarks, too
    return tuple(configuration.get(key) or (of_all if key == "figures" else accuracy_figures()))


def complete_settings(figure: str, section: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of a figure: those given, as they are, and its defaults; ``InputError`` in one sentence."""
    settings = _checked(settings_of(figure), section, (figure,))
    absent = set(type(settings).model_fields) - set(section)
    return {**section, **settings.model_dump(mode="json", include=absent, exclude_none=True)}


def standard_settings(figure: str) -> dict[str, Any]:
    """Return the settings of a figure that come with the package; raises ``InputError`` if there is no such figure."""
    from lsvib.models.scene import read_yaml

    return complete_settings(figure, section(read_yaml(DEFAULT), figure))


def settings_of(figure: str) -> type[FigureSettings]:
    """Return the type of the settings of a figure; raises ``InputError`` if there is no such figure."""
    found: type[FigureSettings] = load(figure).Settings
    return found


@cache
def _configuration() -> type[SettingsSection]:
    sections: dict[str, Any] = {name: (settings_of(name), ...) for name in ("attraction", "chart")}
    # A section that is missing is no fault unless its figure is to be built.
    sections |= {name: (settings_of(name), None) for name in (*default_figures(), *accuracy_figures())}
    words = "Configuration of the workflow; SI units throughout."
    return create_model("Configuration", __base__=Assessments, __doc__=words, **sections)


def _checked(model: type[SettingsSection], values: Any, place: Sequence[str] = ()) -> Any:
    try:
        return model.model_validate(values)
    except ValidationError as error:
        raise InputError(sentence_about(model, error, place)) from None
