"""The command that builds a figure."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.cli.app import app, show
from lsvib.cli.options import AsJson, Changes, Files, require_folder
from lsvib.errors import InputError, LsvibError

_FILES = (".nc", "_checks.json", ".png", ".pdf")  # ends of names, after that of the figure


@app.command
def draw(
    file: Annotated[Path, Parameter(help="netCDF file of a motion, sweep, branch of cycles or map.")],
    figure: Annotated[Path, Parameter(help="PNG file to draw it to; a PDF is written beside it.")],
    *,
    kind: Annotated[str | None, Parameter(help="Of a motion: phase_plane or friction_loop, else over time.")] = None,
) -> None:
    """Draw a file that another command wrote.

    Example of use:

        lsvib draw motion.nc motion.png
    """
    from lsvib.answers.io import read_dataset

    files = Files(None, figure, reads=file)
    files.write(read_dataset(file), kind=kind)
    print(f"wrote {figure} and its PDF")


@app.command
def figure(
    number: Annotated[str, Parameter(help="Number in the chapter, e.g. 8.6, or name, e.g. nut_stability.")],
    *,
    changes: Changes = None,
    config: Annotated[Path | None, Parameter(help="Settings of the figures; the default is named above.")] = None,
    out: Annotated[Path, Parameter(help="Folder to write to.")] = Path("figures"),
    as_json: AsJson = False,
) -> None:
    """Build one figure, of the chapter or beyond it: its dataset, its checks, and the picture as PNG and PDF.

    The files are FOLDER/fig8_06.nc, fig8_06_checks.json, fig8_06.png and fig8_06.pdf; the results of the workflow stay
    as they are. Settings come from config/config.yaml in the current folder, else from the copy in lsvib. With changed
    parameters the chapter no longer applies, so its checks are reported, not enforced. A parameter that the figure
    varies itself, or does not depend on, cannot be changed.

    Examples of use:

        lsvib figure 8.9 --set support_damping=4e-4 --out mine

        lsvib figure nut_stability
    """
    from lsvib.chapter.build import compute_figure, draw_figure
    from lsvib.chapter.configuration import DEFAULT, section
    from lsvib.drives.scene import read_yaml
    from lsvib.files import check_outputs, replacing

    require_folder(out, "dataset, checks, PNG and PDF")
    name = _name(number)
    here = Path("config/config.yaml")
    config = config or (here if here.is_file() else DEFAULT)
    settings = section(read_yaml(config), name)
    if changes:
        settings = {**settings, "drive": _changed_drive(number, name, settings, dict(changes))}
    files = [out / f"{name}{ending}" for ending in _FILES]
    check_outputs(files, [config])
    with replacing(*files) as (data, judged, png, pdf):
        checks = compute_figure(name, settings, data, judged)
        draw_figure(name, data, png, pdf)

    failed, picture = sum(not check.passed for check in checks), str(out / f"{name}.png")
    verdict = f"{failed} of {len(checks)} checks failed." if failed else f"All {len(checks)} checks passed."
    text = [*(check.sentence() for check in checks), *([verdict] if checks else [])]
    result = {"figure": picture, "checks": [check.to_json() for check in checks]}
    show(result, as_json, [*text, f"wrote {picture}, its PDF, dataset and checks"])
    if failed and not changes:
        raise LsvibError(f"figure {number}: a check failed; see above.")


def _name(number: str) -> str:
    """Return the name of a figure, which may be given by its number in the chapter, as 8.6 for fig8_06."""
    from lsvib.chapter.configuration import BENCHMARKS, FIGURES

    labels = []
    for name in (*FIGURES, *BENCHMARKS):
        chapter, _, rest = name.removeprefix("fig").partition("_")
        labels.append(f"{chapter}.{int(rest)}" if chapter.isdigit() and rest.isdigit() else name)
        if number in (name, labels[-1]):
            return name
    raise InputError(f"figure {number} is not one of {', '.join(labels)}.")


def _changed_drive(number: str, name: str, section: Mapping[str, Any], changes: Mapping[str, str]) -> dict[str, Any]:
    """Return the drive of a figure with changes; a change that would change nothing in the figure is refused."""
    from lsvib.chapter.configuration import load
    from lsvib.drives.drive import Drive, changed
    from lsvib.drives.pairings import in_parameters
    from lsvib.numbers import number as number_of

    settings, changes = load(name).Settings, in_parameters(changes)
    if "drive" not in settings.model_fields:
        raise InputError(f"figure {number} has no drive of its own, so --set cannot change it.")
    for key in changes:
        if key in settings.unused:
            raise InputError(
                f"figure {number} does not depend on {key} of its drive, so --set {key} would change nothing; what it "
                "varies is in its section of the settings, see --config."
            )
    given = section.get("drive", {})
    Drive.of(changed(given, changes))  # refuses a key or a value with the words of the other commands
    return changed(given, {key: number_of(text) for key, text in changes.items()})
