"""The command that fits a friction law to measured torques."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from lsvib.cli.app import app, show
from lsvib.cli.options import AsJson, refuse_results_of_the_workflow
from lsvib.errors import InputError


@app.command
def fit(
    sheet: Annotated[Path, Parameter(help="YAML file that names thread, load and tables; see docs/fit.md.")],
    *,
    out: Annotated[
        Path | None, Parameter(help="Folder to write fit.nc, fit.json, fit.png, fit.pdf and friction.yaml to.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Fit the friction of a screw to its torque over the speed: the law, its errors, and what the data cannot tell.

    Of records over time it also finds what jerks tell of static friction, spring and damper of the drive;
    docs/measure.md says what to measure.

    Examples of use:

        lsvib fit examples/measured_screw/measured_screw.yaml --out fitted
    """
    if out is not None:
        refuse_results_of_the_workflow(out / "fit.nc")
    try:
        from lsvib.fit.output import fit_file, text_of

        result = fit_file(sheet, out)
    except ModuleNotFoundError as error:
        raise InputError(
            f"lsvib fit needs {error.name}, which is not installed: pip install 'lsvib[assess]'."
        ) from None
    show(result, as_json, [text_of(result)], out)
