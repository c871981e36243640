"""The command that maps a region of attraction."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from lsvib.cli.app import ProgressLine, app
from lsvib.cli.options import MODEL, ONE_VALUE, RESUME, AsJson, Changes, pairs, refuse_results_of_the_workflow
from lsvib.cli.printing import picture_files, print_map, show
from lsvib.errors import InputError

Axes = Annotated[
    list[str],
    Parameter(consume_multiple=True, help="Two axes KEY=START:STOP:COUNT; KEY=VALUE fixes another.", **ONE_VALUE),
]
QuantityNames = Annotated[
    list[str],
    Parameter(consume_multiple=True, help="Any of label, time, seizures, first_event, doubt; label is.", **ONE_VALUE),
]


@app.command
def attraction(
    *,
    grid: Axes,
    out: Path,
    model: Annotated[str, MODEL] = "rigid",
    changes: Changes = None,
    resume: Annotated[str, RESUME] = "contact_sign",
    quantities: QuantityNames = ["label"],  # noqa: B006
    workers: Annotated[str, Parameter(help="Number of workers, each on a core.")] = "1",
    figure: Annotated[Path | None, Parameter(help="PNG file to draw the map to; a PDF is written beside it.")] = None,
    as_json: AsJson = False,
) -> None:
    """Map the region of attraction: the attractor of the motion from every start of a grid.

    Examples of use:

        lsvib attraction --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --grid u=-0.3:0.3:2000
        w=-150:150:2000 --out map.nc --workers 2

        lsvib attraction --model threads --set mass=11 --grid u=-0.05:0.05:100 w=-15:15:100 --out slice.nc

    Parameters
    ----------
    out:
        netCDF file to write; one that is there is replaced.
    """
    from lsvib.api import drive_class
    from lsvib.basins.grid import Grid
    from lsvib.datasets.io import write_dataset
    from lsvib.datasets.map import map_attraction, summary
    from lsvib.files import Outputs

    refuse_results_of_the_workflow(out, figure)
    pictures = picture_files(figure)
    outputs = Outputs([(out, "netCDF"), *pictures])
    starts = Grid.parse(grid)
    if pictures and (starts.x.coordinate, starts.y.coordinate) != ("u", "w"):
        raise InputError("figure is for maps of u and w; leave it out for a plane of other coordinates.")
    drive = drive_class(model).of(pairs(changes))
    found = map_attraction(drive, starts, quantities, resume, workers, ProgressLine())
    dataset, counts = found.dataset, found.counts
    area = dataset["basin_area"].item() if "basin_area" in dataset else None
    result = summary(counts, found.doubts, area, found.seconds)
    with outputs.writing() as parts:
        write_dataset(dataset, parts[0], "lsvib.attraction")
        if pictures:
            from lsvib.figures.attraction import draw
            from lsvib.figures.style import save

            save(draw(dataset), *parts[1:])
    show(result, as_json, lambda result: print_map(result, counts), out)
