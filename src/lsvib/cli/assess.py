"""The command that assesses a drive from its data sheet."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from lsvib.cli.app import app
from lsvib.cli.options import AsJson, refuse_results_of_the_workflow
from lsvib.cli.printing import show
from lsvib.errors import InputError


@app.command
def assess(
    sheet: Path,
    *,
    out: Annotated[Path, Parameter(help="Folder to write index.html, assessment.nc and assessment.json to.")],
    samples: Annotated[str, Parameter(help="Drives drawn from the uncertainties, a power of two.")] = "4096",
    seed: Annotated[str, Parameter(help="Seed of the samples.")] = "1",
    as_json: AsJson = False,
) -> None:
    """Assess a drive from its data sheet: will it vibrate, how close is it, and what should be changed.

    Examples of use:

        lsvib assess examples/powered_seat.yaml --out report

        lsvib assess drive.yaml --samples 1048576 --out report

    Parameters
    ----------
    sheet:
        YAML file of the data sheet; see docs/assess.md.
    """
    refuse_results_of_the_workflow(out / "index.html")
    try:
        from lsvib.assess import output
    except ModuleNotFoundError as error:
        raise InputError(
            f"lsvib assess needs {error.name}, which is not installed: pip install 'lsvib[assess]'."
        ) from None

    result = output.assess_file(sheet, out, samples, seed)
    written = f"wrote {out / 'index.html'}, assessment.nc and assessment.json"
    show(result, as_json, lambda result: print(result["sentence"], written, sep="\n"))
