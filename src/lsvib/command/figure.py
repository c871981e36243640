"""The command that builds a figure."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.command.app import app
from lsvib.command.options import AsJson, Changes, pairs
from lsvib.command.printing import print_checks
from lsvib.errors import InputError, LsvibError

# What a figure is written to: folder, suffix, and what the file is called in messages.
_FILES = [
    ("datasets", "nc", "netCDF"),
    ("checks", "json", "JSON"),
    ("figures", "png", "PNG"),
    ("figures", "pdf", "PDF"),
]


@app.command
def figure(
    number: str,
    *,
    changes: Changes = None,
    config: Annotated[Path | None, Parameter(help="Settings of the figures; see below for the default.")] = None,
    out: Annotated[Path, Parameter(help="Folder to write to.")] = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Build one figure, of the chapter or beyond it: its dataset, its checks, and the picture as PNG and PDF.

    The settings are those of the file config/config.yaml if there is one here, else those that come with lsvib.
    Changed parameters leave the chapter's, so its checks are then reported as they come out, not enforced. A parameter
    that the figure varies itself, or does not depend on, cannot be changed.

    Examples of use:

        lsvib figure 8.6

        lsvib figure 8.9 --set support_damping=4e-4 --out mine

        lsvib figure limit_process

    Parameters
    ----------
    number:
        Number of the figure in the chapter, e.g. 8.6, or its name, e.g. limit_process.
    """
    from importlib import import_module

    from lsvib.data.writer import write_dataset
    from lsvib.figures.folders import dataset_module, picture_module
    from lsvib.files import Outputs, write_json
    from lsvib.settings import DEFAULT

    here = Path("config/config.yaml")
    config = config or (here if here.is_file() else DEFAULT)
    name, section = _section(number, config)
    if changes:
        section["drive"] = _changed_drive(number, name, section, pairs(changes))
    paths = [(out / folder / f"{name}.{suffix}", kind) for folder, suffix, kind in _FILES]
    outputs = Outputs(paths, [config], make_folders=True)
    module = import_module(dataset_module(name))
    dataset = module.build(section)
    checks = module.checks(dataset)
    drawn = import_module(picture_module(name)).draw(dataset)
    from lsvib.figures.drawing.style import save

    with outputs.writing() as (data, verdicts, *pictures):
        write_dataset(dataset, data, f"{dataset_module(name)}.build")
        write_json([check.to_json() for check in checks], verdicts)
        save(drawn, *pictures)
    print_checks(paths[2][0], checks, as_json)
    if not changes and not all(check.passed for check in checks):
        raise LsvibError(f"figure {number}: a check failed; see above.")


def _section(number: str, config: Path) -> tuple[str, dict[str, Any]]:
    """Return the name of a figure and its settings in a configuration file, which are checked."""
    from lsvib.drives.scene import read_yaml
    from lsvib.settings import check_section, figures

    settings = read_yaml(config)
    labels = {name: _label(name) for name in figures(settings)}
    if not labels:
        raise InputError(f"{config} lists no figures that it has settings for, under figures or accuracy_figures.")
    name = next((name for name, label in labels.items() if number in (name, label)), number)
    if name not in labels:
        raise InputError(f"figure {number} is not one of those in {config}: {', '.join(labels.values())}.")
    check_section(settings, name)
    return name, settings[name]


def _changed_drive(number: str, name: str, section: Mapping[str, Any], changes: Mapping[str, str]) -> dict[str, Any]:
    """Return the drive of a figure with changes; a change that would change nothing in the figure is refused."""
    from lsvib.settings import UNUSED

    if "drive" not in section:
        raise InputError(f"figure {number} has no drive of its own, so --set cannot change it.")
    for key in changes:
        if key in UNUSED.get(name, ()):
            raise InputError(
                f"figure {number} does not depend on {key} of its drive, so --set {key} would change nothing."
            )
    given = section["drive"]
    if changes.keys() & {"lead_angle", "lead_angle_deg"}:
        given = {key: value for key, value in given.items() if key not in ("lead_angle", "lead_angle_deg")}
    return {**given, **changes}


def _label(name: str) -> str:
    """Number of a figure of the chapter by its name: 8.6 for fig8_06; other figures keep their name."""
    chapter, _, number = name.removeprefix("fig").partition("_")
    return f"{chapter}.{int(number)}" if chapter.isdigit() and number.isdigit() else name
