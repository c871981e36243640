"""The command that charts what a drive does over two of its parameters."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from lsvib.cli.app import ProgressLine, app
from lsvib.cli.options import MODEL, RESUME, AsJson, Changes, OutFile, pairs, refuse_results_of_the_workflow
from lsvib.cli.printing import picture_files, print_chart, show


@app.command
def chart(
    *,
    x: Annotated[str, Parameter(help="KEY=START:STOP:COUNT: the parameter along the columns, and its cells.")],
    y: Annotated[str, Parameter(help="KEY=START:STOP:COUNT: the parameter along the rows.")],
    model: Annotated[str, MODEL] = "rigid",
    changes: Changes = None,
    resume: Annotated[str, RESUME] = "contact_sign",
    workers: Annotated[
        str, Parameter(help="Number of processes; of threads for a small chart of the rigid drive.")
    ] = "1",
    out: OutFile = None,
    figure: Annotated[Path | None, Parameter(help="PNG file to draw the chart to; a PDF is written beside it.")] = None,
    as_json: AsJson = False,
) -> None:
    """Chart what a drive does over two of its parameters, with the exact curves that divide the chart.

    Examples of use:

        lsvib chart --x mass=1:20:400 --y axial_force=-60:60:400 --set translation_damping=300 --workers 2 --out
        chart.nc --figure chart.png

        lsvib chart --model threads --x contact_stiffness=1e4:1e9:30 --y contact_damping=1:1e9:30 --set mass=9 --out
        contacts.nc
    """
    from time import perf_counter

    from lsvib.api import drive_class
    from lsvib.datasets.chart import chart as charted
    from lsvib.datasets.chart import summary
    from lsvib.datasets.io import write_dataset
    from lsvib.files import Outputs

    refuse_results_of_the_workflow(out, figure)
    pictures = picture_files(figure)
    outputs = Outputs([*([(out, "netCDF")] if out else []), *pictures])
    drive = drive_class(model).of(pairs(changes))
    begin = perf_counter()
    found = charted(drive, x, y, resume, workers, ProgressLine("motions"))
    result = summary(found, perf_counter() - begin)
    with outputs.writing() as parts:
        if out:
            write_dataset(found, parts[0], "lsvib.chart")
        if pictures:
            from lsvib.figures.chart import draw
            from lsvib.figures.style import save

            save(draw(found), *parts[-2:])
    show(result, as_json, print_chart)
