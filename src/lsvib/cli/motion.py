"""The commands that follow motions: one of them, many over a range of parameters, and limit cycles."""

from time import perf_counter
from typing import Annotated

from cyclopts import Parameter

from lsvib.cli import options, systems
from lsvib.cli.app import ProgressLine, app, show
from lsvib.errors import InputError


@app.command
def simulate(
    *,
    out: options.OutFile,
    changes: options.Changes = None,
    scene: options.SceneFile = None,
    start: options.Start = None,
    duration: Annotated[float | None, Parameter(help="Time [s] that the motion is followed.")] = None,
    samples: Annotated[options.Whole | None, Parameter(help="Number of output times, both ends included.")] = None,
    outputs: Annotated[list[str] | None, Parameter(help="What to write.", consume_multiple=True, negative="")] = None,
    figure: options.Picture = None,
    system: options.SystemFile = None,
    as_json: options.AsJson = False,
) -> None:
    """Simulate a drive exactly and write its motion and events.

    Examples of use:

        lsvib simulate --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --start u=0.1 w=0
        --duration 0.5 --out motion.nc

        lsvib simulate --set static_friction_coefficient=0.4 --start rest --duration 1 --out motion.csv
        --outputs load_place load_speed friction_torque

        lsvib simulate --scene scene.yaml --samples 5000 --out motion.nc --figure motion.png --json
    """
    from lsvib.answers.motion import Simulation, as_scene

    files = options.Files(out, figure, reads=system or scene)
    if system:
        systems.simulate(systems.read(system, changes, start), duration, samples, files, as_json)
        return
    given = {"duration": duration, "samples": samples, "start": options.start_of(start), "outputs": outputs}
    stated = {key: value for key, value in given.items() if value is not None}
    found = Simulation.of(as_scene(scene, stated, dict(changes or ())))
    files.write(found.file(), "lsvib.simulate")
    show(found.to_json(), as_json, found.text(), out)


@app.command
def sweep(
    *,
    over: options.Over,
    changes: options.Changes = None,
    start: options.Start = None,
    workers: options.Workers = 1,
    out: options.OutFile | None = None,
    figure: options.Picture = None,
    system: options.SystemFile = None,
    as_json: options.AsJson = False,
) -> None:
    """Sweep parameters of a drive: what it does, how large and how fast, the forces; over two, with exact curves.

    Without a start what the drive does is told by motions from beside steady sliding, from far away and from rest.

    Examples of use:

        lsvib sweep --set translation_damping=1000 --over axial_force=1:60:200 --figure sweep.png

        lsvib sweep --set translation_damping=300 --over axial_force=-60:60:400 --over mass=1:20:400 --workers 2
        --out chart.nc --figure chart.png

        lsvib sweep --set mass=9 --over contact_damping=1:1e9:30 --over contact_stiffness=1e4:1e9:30
    """
    from lsvib.answers.sweep import summary, text
    from lsvib.answers.tables import records, table_of

    files = options.Files(out, figure, reads=system)
    if figure and len(over) > 2:
        raise InputError("figure is for sweeps over one or two parameters; leave it out for more.")
    if system:
        systems.sweep(systems.read(system, changes, start), over, files, as_json)
        return
    options.refuse_varied(changes, over)
    begin, begun = perf_counter(), options.start_of(start)
    found = options.drive_of(changes).sweep(
        start=begun, workers=workers, progress=ProgressLine("motions"), **options.values_of(over)
    )
    result = summary(found, perf_counter() - begin)
    files.write(found)
    table = table_of(found)
    show(result | {"rows": records(table) if as_json else []}, as_json, text(result, table), out)


@app.command
def cycles(
    *,
    changes: options.Changes = None,
    system: options.SystemFile = None,
    start: options.Start = None,
    box: options.Box = None,
    count: Annotated[options.Whole, Parameter(help="Of a system: number of starts that are drawn from the box.")] = 100,
    seed: Annotated[options.Whole, Parameter(help="Of a system: seed by which they are drawn.")] = 0,
    as_json: options.AsJson = False,
) -> None:
    """Find the cycles of a drive, attracting and repelling: period, multipliers, amplitude, work.

    Examples of use:

        lsvib cycles --set mass=11 --set support_damping=2e-3 --set axial_force=-18.37

        lsvib cycles --set contact_stiffness=1e8 --set contact_damping=1e8 --set mass=11 --json
    """
    if system:
        systems.cycles(systems.read(system, changes, start), dict(box or ()), count, seed, as_json)
        return
    if start or box:
        raise InputError("start and box are for systems, which --system names.")
    found = options.drive_of(changes).cycles()
    show(found.to_json(), as_json, found.text())


@app.command
def follow(
    *,
    over: options.Ends,
    changes: options.Changes = None,
    cycle: Annotated[options.Whole, Parameter(help="Which of the cycles that lsvib cycles lists, from 1.")] = 1,
    points: Annotated[options.Whole, Parameter(help="Most points each way.")] = 1000,
    out: options.OutFile | None = None,
    figure: options.Picture = None,
    system: options.SystemFile = None,
    start: options.Start = None,
    as_json: options.AsJson = False,
) -> None:
    """Follow a cycle over a parameter, both ways, through folds and changes of its events, which are named.

    Examples of use:

        lsvib follow --over axial_force=-19:-15 --set mass=11 --set support_damping=2e-3 --set axial_force=-18

        lsvib follow --over mass=10.2:14 --set mass=11 --out branch.nc --json
    """
    from lsvib.answers.cycles import branch_dataset, branch_json
    from lsvib.numbers import whole_between
    from lsvib.systems.answers import branch_text

    files = options.Files(out, figure, reads=system)
    if system:
        systems.follow(systems.read(system, changes, start), over, points, files, as_json)
        return
    if start:
        raise InputError("start is for systems, which --system names.")
    made = options.drive_of(changes)
    listed = made.cycles().cycles
    if not listed:
        raise InputError("the drive has no cycle to follow; see lsvib cycles.")
    chosen = listed[whole_between("cycle", cycle, 1, len(listed)) - 1]
    branch = made.follow(chosen, *over, points=points, progress=ProgressLine("points"))
    files.write(branch_dataset(branch))
    show(branch_json(branch), as_json, branch_text(branch), out)
