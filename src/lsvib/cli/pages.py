"""The commands that make pages: the report on a data sheet, and the explorer."""

from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from lsvib.cli.app import app, show
from lsvib.cli.options import AsJson, Whole, refuse_results_of_the_workflow
from lsvib.errors import InputError
from lsvib.numbers import whole_between


@app.command
def assess(
    sheet: Annotated[Path | None, Parameter(help="YAML file of the data sheet; see docs/assess.md.")] = None,
    *,
    out: Annotated[
        Path | None,
        Parameter(help="Folder to write index.html, assessment.nc and assessment.json to; none if left out."),
    ] = None,
    template: Annotated[bool, Parameter(negative="", help="Print a data sheet to fill in, and nothing else.")] = False,
    samples: Annotated[Whole, Parameter(help="Drives drawn from the uncertainties, a power of two.")] = 4096,
    seed: Annotated[Whole, Parameter(help="Seed of the samples.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Assess a drive from its data sheet: will it vibrate, what does it bear, and what should be changed.

    Prints verdict, torque, efficiency, whether it holds its load, limits that are exceeded, and three changes.

    Examples of use:

        lsvib assess --template > drive.yaml

        lsvib assess examples/powered_seat.yaml --out report
    """
    if template and (sheet is not None or out is not None):
        raise InputError("lsvib assess --template goes without a data sheet and --out; it prints a sheet to fill in.")
    if template:
        print(files("lsvib.assess").joinpath("template.yaml").read_text(encoding="utf-8"), end="")
        return
    if sheet is None:
        raise InputError("lsvib assess needs the file of a data sheet; lsvib assess --template prints one to fill in.")
    if out is not None:
        refuse_results_of_the_workflow(out / "index.html")
    try:
        from lsvib.assess.output import assess_file
    except ModuleNotFoundError as error:
        raise InputError(
            f"lsvib assess needs {error.name}, which is not installed: pip install 'lsvib[assess]'."
        ) from None

    result = assess_file(sheet, out, samples, seed)
    written = [f"wrote {out / 'index.html'}, assessment.nc and assessment.json"] if out is not None else []
    show(result, as_json, [*result["brief"], *written])


@app.command
def explore(
    *,
    port: Annotated[Whole, Parameter(help="Port of this machine to serve the page at; 0 takes a free one.")] = 5006,
    show: Annotated[bool, Parameter(negative="--no-show", help="Open the page in a browser.")] = True,
) -> None:
    """Explore drives in a browser: phase plane, region of attraction, amplitudes, while you drag a parameter.

    Examples of use:

        lsvib explore --port 5010 --no-show
    """
    number = whole_between("port", port, 0, 65535)
    if find_spec("bokeh") is None:
        raise InputError("lsvib explore needs bokeh, which is not installed: pip install 'lsvib[explore]'.")
    from lsvib.explore.server import serve

    serve(number, show)
