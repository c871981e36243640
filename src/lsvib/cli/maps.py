"""The commands about regions: of attraction in the phase plane, and resilience."""

from time import perf_counter
from typing import Annotated, Literal

from cyclopts import Parameter

from lsvib.cli import options, systems
from lsvib.cli.app import ProgressLine, app, show
from lsvib.errors import InputError

Quantities = Annotated[
    list[Literal["label", "time", "seizures", "first_event", "doubt"]],
    Parameter(consume_multiple=True, negative="", help="What to store of each cell; the label always is."),
]


@app.command
def attraction(
    *,
    grid: options.GridOfStarts,
    out: options.OutFile,
    changes: options.Changes = None,
    quantities: Quantities = ["label"],  # noqa: B006
    workers: options.Workers = 1,
    figure: options.Picture = None,
    system: options.SystemFile = None,
    start: options.Start = None,
    as_json: options.AsJson = False,
) -> None:
    """Map the region of attraction: the attractor of the motion from every start of a grid.

    Examples of use:

        lsvib attraction --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --grid u=-0.3:0.3:2000
        w=-150:150:2000 --out map.nc --workers 2

        lsvib attraction --set contact_stiffness=1e8 --set contact_damping=1e8 --set mass=11 --grid u=-0.05:0.05:100
        w=-15:15:100 --out slice.nc
    """
    from lsvib.answers.map import summary, text

    files = options.Files(out, figure, reads=system)
    if system:
        systems.attraction(systems.read(system, changes, start), grid, files, as_json)
        return
    if start:
        raise InputError("start is for systems, which --system names.")
    if figure and {key for key, values in grid if isinstance(values, tuple)} != {"u", "w"}:
        raise InputError("figure is for maps of u and w; leave it out for a plane of other coordinates.")
    asked, begin = [*quantities, "doubt"], perf_counter()
    found = options.drive_of(changes).attraction(dict(grid), quantities=asked, workers=workers, progress=ProgressLine())
    result = summary(found, perf_counter() - begin)
    files.write(found if "doubt" in quantities else found.drop_vars("doubt"), "lsvib.attraction")
    show(result, as_json, text(result), out)


@app.command
def resilience(
    *, changes: options.Changes = None, window: options.Window = None, as_json: options.AsJson = False
) -> None:
    """Find the largest perturbations that the rigid drive's steady sliding tolerates, and how much of a window settles.

    Examples of use:

        lsvib resilience --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --window u=-0.3:0.3 w=-150:150
    """
    reserve = options.drive_of(changes).resilience(dict(window) if window else None)
    show(reserve.to_json(), as_json, reserve.text())
