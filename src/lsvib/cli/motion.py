"""The commands that follow motions: one, many over parameters or from a grid, limit cycles, and what they tolerate."""

from pathlib import Path
from time import perf_counter
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from lsvib.cli import options
from lsvib.cli.app import ProgressLine, app, show
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError
from lsvib.words import plain

Quantities = Annotated[
    list[Literal["label", "time", "seizures", "first_event", "doubt"]],
    Parameter(consume_multiple=True, negative="", help="What to store for each cell besides the label."),
]


@app.command
def simulate(
    *,
    out: options.OutFile,
    changes: options.Changes = None,
    scene: options.SceneFile = None,
    start: options.Start = None,
    duration: Annotated[float | None, Parameter(help="Duration of the motion [s].")] = None,
    samples: Annotated[options.Whole | None, Parameter(help="Number of output times, both ends included.")] = None,
    outputs: Annotated[list[str] | None, Parameter(help="Output names.", consume_multiple=True, negative="")] = None,
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
        result, said = _simulate_system(*_system(system, changes, start), duration, samples, files)
        return show(result, as_json, said, out)
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
    """Sweep parameters of a drive: its behaviour, amplitudes, periods and forces; over two, with exact boundaries.

    Without --start, motions from near steady sliding, from far away and from rest tell how the drive behaves.

    Examples of use:

        lsvib sweep --set translation_damping=1000 --over axial_force=1:60:200 --figure sweep.png

        lsvib sweep --set translation_damping=300 --over axial_force=-60:60:400 --over mass=1:20:400 --workers 2
        --out chart.nc --figure chart.png

        lsvib sweep --set mass=9 --over contact_damping=1:1e9:30 --over contact_stiffness=1e4:1e9:30
    """
    from lsvib.answers.io import records, table_of
    from lsvib.answers.sweep import summary, text

    files = options.Files(out, figure, reads=system)
    if figure and len(over) > 2:
        raise InputError("figure needs a sweep over one or two parameters; leave it out for more.")
    if system:
        own, begin = _system(system, changes, start)
        found = own.sweep(*begin, progress=ProgressLine("motions"), **options.values_of(over))
        return _tell_kinds(found, files, as_json)
    options.refuse_varied(changes, over)
    clock, begun = perf_counter(), options.start_of(start)
    found = options.drive_of(changes).sweep(
        start=begun, workers=workers, progress=ProgressLine("motions"), **options.values_of(over)
    )
    result = summary(found, perf_counter() - clock)
    files.write(found)
    table = table_of(found)
    show(result | {"rows": records(table) if as_json else []}, as_json, text(result, table), out)


@app.command
def cycles(
    *,
    changes: options.Changes = None,
    system: options.SystemFile = None,
    start: options.Start = None,
    box: Annotated[options.Window, Parameter(help="Of a system: KEY=LOW:HIGH of states, for random starts.")] = None,
    count: Annotated[options.Whole, Parameter(help="Of a system: number of random starts in the box.")] = 100,
    seed: Annotated[options.Whole, Parameter(help="Of a system: seed of the random starts.")] = 0,
    as_json: options.AsJson = False,
) -> None:
    """Find the limit cycles of a drive, attracting and repelling: period, multipliers, amplitude, work.

    Examples of use:

        lsvib cycles --set mass=11 --set support_damping=2e-3 --set axial_force=-18.37

        lsvib cycles --set contact_stiffness=1e8 --set contact_damping=1e8 --set mass=11 --json
    """
    if system:
        own, begin = _system(system, changes, start)
        ends = own.cycles([] if box else [begin], box=dict(box or ()), count=count, seed=seed)
        lines = [f"Starts searched: {sum(end.starts for end in ends)}; there may be other attractors."]
        lines += [line for end in ends for line in (*end.text(), f"  reached from {end.starts} of them")]
        return show({"ends": [end.to_json() | {"starts": end.starts} for end in ends]}, as_json, lines)
    found = options.drive_of(changes, start=start, box=box).cycles()
    show(found.to_json(), as_json, found.text())


@app.command
def follow(
    *,
    over: options.Ends,
    changes: options.Changes = None,
    cycle: Annotated[options.Whole, Parameter(help="Number of the cycle in the list of lsvib cycles, from 1.")] = 1,
    points: Annotated[options.Whole, Parameter(help="Most points in each direction.")] = 1000,
    out: options.OutFile | None = None,
    figure: options.Picture = None,
    system: options.SystemFile = None,
    start: options.Start = None,
    as_json: options.AsJson = False,
) -> None:
    """Follow a limit cycle over a parameter, both ways, and list its folds and changes of events.

    Examples of use:

        lsvib follow --over axial_force=-19:-15 --set mass=11 --set support_damping=2e-3 --set axial_force=-18

        lsvib follow --over mass=10.2:14 --set mass=11 --out branch.nc --json
    """
    from lsvib.answers.cycles import branch_dataset, branch_json, branch_text
    from lsvib.numbers import whole_between

    files = options.Files(out, figure, reads=system)
    if system:
        own, begin = _system(system, changes, start)
        end = own.steady_state(*begin)
        if end.cycle is None:
            raise InputError(f"the motion from the start does not end on a cycle ({end.label}); choose another start.")
        branch = own.follow(end, *over, points=points, progress=ProgressLine("points"))
    else:
        made = options.drive_of(changes, start=start)
        listed = made.cycles().cycles
        if not listed:
            raise InputError("the drive has no cycle to follow; see lsvib cycles.")
        chosen = listed[whole_between("cycle", cycle, 1, len(listed)) - 1]
        branch = made.follow(chosen, *over, points=points, progress=ProgressLine("points"))
    files.write(branch_dataset(branch))
    show(branch_json(branch), as_json, branch_text(branch), out)


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
    """Map regions of attraction: the attractor of the motion from every start of a grid.

    Examples of use:

        lsvib attraction --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --grid u=-0.3:0.3:2000
        w=-150:150:2000 --out map.nc --workers 2

        lsvib attraction --set contact_stiffness=1e8 --set contact_damping=1e8 --set mass=11 --grid u=-0.05:0.05:100
        w=-15:15:100 --out slice.nc
    """
    from lsvib.answers.map import summary, text

    files = options.Files(out, figure, reads=system)
    if system:
        own, (mode, _) = _system(system, changes, start)
        return _tell_kinds(own.map(dict(grid), mode, progress=ProgressLine()), files, as_json)
    if figure and {key for key, values in grid if isinstance(values, tuple)} != {"u", "w"}:
        raise InputError("figure needs a map over u and w; leave it out for other coordinates.")
    asked, begin = [*quantities, "doubt"], perf_counter()
    made = options.drive_of(changes, start=start)
    found = made.attraction(dict(grid), quantities=asked, workers=workers, progress=ProgressLine())
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


# Of a system of one's own, which ``--system`` names


def _system(file: Path, changes: list[options.Pair] | None, start: list[options.Coordinate] | None) -> tuple[Any, Any]:
    """Return the system that a file holds, with changes, and the start: its mode, else the first one, and its state."""
    from lsvib.systems import System

    system = System.of(read_yaml(file, texts=True)).replace(**dict(changes or ()))
    modes = [key for key, value in start or () if value != value or key == "rest"]
    if len(modes) > 1:
        raise InputError(f"start names {len(modes)} modes, {' and '.join(modes)}; give one.")
    state = {key: value for key, value in start or () if key not in modes}
    return system, ((modes or [*system.modes])[0], state)


def _simulate_system(own: Any, start: Any, duration: float | None, samples: int | None, files: options.Files) -> Any:
    """Simulate a system; returns what is shown of it, as JSON and in lines."""
    from lsvib.variables import counted, flag_names

    if duration is None:
        raise InputError("simulate needs --duration, in seconds.")
    found, end = own.simulate(*start, duration, samples=samples or 1001), own.steady_state(*start)
    files.write(found, "lsvib.simulate")
    last, events = found.isel(time=-1), counted(found.event_kind)
    final, mode = {name: float(last[name]) for name in own.states}, flag_names(last["mode"])[int(last["mode"])]
    where = ", ".join(f"{key} = {x:.15g}" for key, x in final.items())
    happens = ", ".join(f"{n} {plain(kind)}" for kind, n in events.items()) or "none"
    lines = [f"final state: {where}, in mode {mode}", f"events: {happens}", *end.text()]
    return {"final_state": final | {"mode": mode}, "events": events, "end": end.to_json()}, lines


def _tell_kinds(found: Any, files: options.Files, as_json: bool) -> None:
    from lsvib.variables import counted

    files.write(found)
    kinds = counted(found.behaviour)
    shares = (f"{plain(kind)}: {count} of {found.behaviour.size}" for kind, count in kinds.items())
    show({"points": found.behaviour.size, "kinds": kinds}, as_json, shares, files.out)
