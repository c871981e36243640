"""The commands that make pages: the report on a data sheet, and the explorer."""

from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from lsvib.cli.app import app
from lsvib.cli.options import AsJson, Whole, refuse_results_of_the_workflow
from lsvib.cli.printing import show
from lsvib.errors import InputError
from lsvib.numbers import whole_between


@app.command
def assess(
    sheet: Annotated[Path, Parameter(help="YAML file of the data sheet; see docs/assess.md.")],
    *,
    out: Annotated[Path, Parameter(help="Folder to write index.html, assessment.nc and assessment.json to.")],
    samples: Annotated[Whole, Parameter(help="Drives drawn from the uncertainties, a power of two.")] = 4096,
    seed: Annotated[Whole, Parameter(help="Seed of the samples.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Assess a drive from its data sheet: will it vibrate, how close is it, and what should be changed.

    Examples of use:

        lsvib assess examples/powered_seat.yaml --out report
    """
    refuse_results_of_the_workflow(out / "index.html")
    try:
        from lsvib.assess.output import assess_file
    except ModuleNotFoundError as error:
        raise InputError(
            f"lsvib assess needs {error.name}, which is not installed: pip install 'lsvib[assess]'."
        ) from None

    result = assess_file(sheet, out, samples, seed)
    written = f"wrote {out / 'index.html'}, assessment.nc and assessment.json"
    show(result, as_json, lambda result: print(result["sentence"], written, sep="\n"))


@app.command
def explore(
    *,
    port: Annotated[Whole, Parameter(help="Port of this machine to serve the page at; 0 takes a free one.")] = 5006,
    show: Annotated[bool, Parameter(negative="--no-show", help="Open the page in a browser.")] = True,
) -> None:
    """Explore drives in a browser: phase plane, region of attraction, amplitudes, contact, while you drag a parameter.

    Examples of use:

        lsvib explore --port 5010 --no-show
    """
    number = whole_between("port", port, 0, 65535)
    if find_spec("bokeh") is None:
        raise InputError("lsvib explore needs bokeh, which is not installed: pip install 'lsvib[explore]'.")
    from lsvib.explore.server import serve

    serve(number, show)
