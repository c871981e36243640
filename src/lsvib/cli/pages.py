"""The commands that need more packages: the report on a data sheet, the fit of measured torques, and the explorer."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from lsvib.cli.app import ProgressLine, app, show
from lsvib.cli.options import AsJson, Files, Whole, require_folder
from lsvib.drives.scene import Scene, read_yaml
from lsvib.errors import InputError
from lsvib.files import write_text
from lsvib.numbers import whole_between


@contextmanager
def _installed(command: str, extra: str) -> Iterator[None]:
    """Say what to install where a command needs a package that is not there."""
    try:
        yield
    except ModuleNotFoundError as error:
        missing = f"lsvib {command} needs {(error.name or '').split('.')[0]}, which is not installed"
        raise InputError(f"{missing}: pip install 'lsvib[{extra}]'.") from None


@app.command
def fit(
    sheet: Annotated[Path, Parameter(help="YAML file that names thread, load and tables; see docs/fit.md.")],
    *,
    out: Annotated[Path | None, Parameter(help="Folder for dataset, JSON, pictures and friction.yaml.")] = None,
    as_json: AsJson = False,
) -> None:
    """Fit a friction law to the measured torque of a screw: the law, its errors, and what the data cannot tell.

    It reads what drives log: speed or position, torque or current. Records over time also give the inertia, and jerks
    the static friction, spring and damper of the drive; docs/measure.md says what to measure.

    Example of use:

        lsvib fit examples/measured_screw/measured_screw.yaml --out fitted
    """
    require_folder(out, "fit.nc, fit.json, fit.png, fit.pdf and friction.yaml")
    with _installed("fit", "assess"):
        from lsvib.sheets.fit_output import fit, text_of

        result = fit(sheet, out)
    show(result, as_json, [text_of(result)], out)


@app.command
def assess(
    sheet: Annotated[Path | None, Parameter(help="Data sheet (YAML), or variants (CSV); docs/assess.md.")] = None,
    *,
    base: Annotated[Path | None, Parameter(help="Data sheet with the entries that all variants share.")] = None,
    out: Annotated[Path | None, Parameter(help="Folder for page, dataset and JSON; for variants a CSV file.")] = None,
    template: Annotated[bool, Parameter(negative="", help="Print a data sheet to fill in, and nothing else.")] = False,
    samples: Annotated[Whole | None, Parameter(help="Drives drawn, a power of two: 4096, 64 per variant.")] = None,
    seed: Annotated[Whole, Parameter(help="Seed of the random draws.")] = 1,
    units: Annotated[Literal["si", "us"], Parameter(help="us: add US units (in, lbf, lbf·in) to SI units.")] = "si",
    solve: Annotated[str | None, Parameter(help="Entry of the sheet to solve for, such as load.force.")] = None,
    goal: Annotated[str | None, Parameter(name="--for", help="Row of statics at its limit, or ROW=VALUE.")] = None,
    as_json: AsJson = False,
) -> None:
    """Assess a drive from its data sheet: whether it vibrates, its torque and limits, and what to change.

    Prints verdict, torque, efficiency, whether it holds its load, limits that are exceeded, and up to three changes.

    Examples of use:

        lsvib assess --template > drive.yaml

        lsvib assess examples/powered_seat.yaml --out report

        lsvib assess variants.csv --base drive.yaml --out table.csv

        lsvib assess drive.yaml --solve load.force --for motor.torque='60 N*m'
    """
    if template and (sheet is not None or out is not None):
        raise InputError("lsvib assess --template takes no data sheet and no --out; it prints a sheet to fill in.")
    if template:
        print(files("lsvib.sheets").joinpath("template.yaml").read_text(encoding="utf-8"), end="")
        return
    if sheet is None:
        raise InputError("lsvib assess needs the file of a data sheet; lsvib assess --template prints one to fill in.")
    if sheet.suffix == ".csv":
        _assess_variants(sheet, base, out, 64 if samples is None else samples, seed, as_json)
        return
    if base is not None:
        raise InputError("--base needs a CSV file of variants; a single data sheet is complete.")
    if as_json and units == "us":
        raise InputError("lsvib assess --json prints SI units only; leave out --json or --units us.")
    if (solve is None) != (goal is None):
        raise InputError("--solve and --for go together, such as --solve load.force --for motor.torque='60 N*m'.")
    require_folder(out, "index.html, assessment.nc and assessment.json")
    with _installed("assess", "assess"):
        from lsvib.sheets.output import assess
    asked = (solve, goal) if solve and goal else None
    result = assess(sheet, out, 4096 if samples is None else samples, seed, units, asked)
    names = "and assessment.json" if result["vibration"] is None else "assessment.nc and assessment.json"
    written = [f"wrote {out / 'index.html'}, {names}".replace(", and", " and")] if out is not None else []
    show(result, as_json, [*result["brief"], *written])


def _assess_variants(table: Path, base: Path | None, out: Path | None, samples: int, seed: int, as_json: bool) -> None:
    """Assess each row of a table, and write or show the table of answers."""
    Files(out, reads=table, ends=[".csv"])
    with _installed("assess", "assess"):
        from lsvib.answers.io import on_screen, records
        from lsvib.sheets.output import ON_SCREEN, assess_variants
    rows = assess_variants(table, base, samples, seed, ProgressLine("variants"))
    if out:
        write_text(rows.to_csv(index=False, lineterminator="\n"), out)
    show({"rows": records(rows)}, as_json, on_screen(rows, ON_SCREEN, "--out table.csv"), out)


@app.command
def explore(
    file: Annotated[
        Path | None,
        Parameter(help="YAML file to start from: a scene, or a data sheet with the motion that assess finds."),
    ] = None,
    *,
    port: Annotated[Whole, Parameter(help="Port to serve the page at; 0 takes a free one.")] = 5006,
    show: Annotated[bool, Parameter(negative="--no-show", help="Open the page in a browser.")] = True,
) -> None:
    """Explore drives in a browser: phase plane, region of attraction and amplitudes follow as you drag a parameter.

    Examples of use:

        lsvib explore examples/chapter.yaml --port 5010 --no-show
    """
    number = whole_between("port", port, 0, 65535)
    with _installed("explore", "explore"):
        from lsvib.explore.server import FRONT, serve
    serve(number, show, view_of(file) if file else FRONT)


def view_of(file: Path) -> Any:
    """Return what a file of a scene or a data sheet shows first; raises ``InputError``."""
    from lsvib.explore.view import View

    values, note = read_yaml(file), ""
    if "modes" in values:
        raise InputError(
            f"{file} is a system, not a scene or data sheet; draw it with lsvib simulate --system --figure."
        )
    if "drive" not in values:
        with _installed("explore with a sheet", "assess"):
            from lsvib.sheets import assessment, sheet
        shown = assessment.assess(sheet.Sheet.read(file), samples=64).nominal
        if not (values := shown.vibration.scene):
            raise InputError(f"{file} has no motion that can be explored: {shown.vibration.reason}")
        if (factor := float(shown.there.draw.square(1.0))) > 1:
            note = f"Friction coefficients are {factor:.4g} times those of the sheet: its flanks slope, and the"
            note += " equations are for a square thread."
    return View.of_scene(Scene.of(values), note)
