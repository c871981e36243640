"""The commands that follow motions: one of them, many over a range of parameters, and limit cycles."""

from collections.abc import Mapping
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.cli import options
from lsvib.cli.app import ProgressLine, app
from lsvib.cli.printing import name, rate, show, table
from lsvib.errors import InputError


@app.command
def simulate(
    *,
    out: options.OutFile,
    drive: options.DriveOptions = options.CHAPTER,
    scene: options.SceneFile = None,
    start: options.Start = None,
    duration: Annotated[float | None, Parameter(help="Time [s] that the motion is followed.")] = None,
    samples: Annotated[options.Whole | None, Parameter(help="Number of output times, both ends included.")] = None,
    figure: options.Picture = None,
    as_json: options.AsJson = False,
) -> None:
    """Simulate a drive exactly and write its motion and events as netCDF.

    Examples of use:

        lsvib simulate --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --start u=0.1 w=0
        --duration 0.5 --out motion.nc

        lsvib simulate --set static_friction_coefficient=0.4 --start rest --duration 1 --out motion.nc

        lsvib simulate --scene scene.yaml --samples 5000 --out motion.nc --figure motion.png --json
    """
    from lsvib.datasets.motion import as_scene, attractor_of, motion_file, run, summary

    files = options.Files(out, figure, reads=scene)
    given = {"duration": duration, "samples": samples, "start": options.start_of(start)}
    checked = as_scene(scene, {key: value for key, value in given.items() if value is not None}, drive.values())
    motion = run(checked)
    steady = attractor_of(checked, motion)
    files.write(motion_file(checked, motion, steady), "lsvib.simulate")
    show(summary(checked, motion, steady), as_json, _print_motion, out)


@app.command
def sweep(
    *,
    over: options.Over,
    drive: options.DriveOptions = options.CHAPTER,
    start: options.Start = None,
    workers: options.Workers = 1,
    out: options.OutFile | None = None,
    figure: options.Picture = None,
    as_json: options.AsJson = False,
) -> None:
    """Sweep parameters of a drive: what the motion ends on, how large and how fast, and the forces.

    Examples of use:

        lsvib sweep --set translation_damping=1000 --over axial_force=1:60:200 --figure sweep.png

        lsvib sweep --set contact_stiffness=1e8 --set mass=11 --over contact_damping=1e7:1e8:100 --workers 2
    """
    from time import perf_counter

    from lsvib.datasets.sweep import summary

    files = options.Files(out, figure)
    if figure and len(over) > 2:
        raise InputError("figure is for sweeps over one or two parameters; leave it out for more.")
    drive.refuse(*over)
    begin, wanted = perf_counter(), options.start_of(start)
    found = drive.drive().sweep(
        start=wanted, workers=workers, progress=ProgressLine("points"),
        **{axis.key: axis.values() for axis in over},
    )  # fmt: skip
    seconds = perf_counter() - begin
    files.write(found)
    show(summary(found, seconds), as_json, _print_sweep)


@app.command
def cycles(*, drive: options.DriveOptions = options.CHAPTER, as_json: options.AsJson = False) -> None:
    """Find the cycles of a drive, attracting and repelling: period, multipliers, amplitude, work.

    Examples of use:

        lsvib cycles --set mass=11 --set support_damping=2e-3 --set axial_force=-18.37

        lsvib cycles --set contact_stiffness=1e8 --set contact_damping=1e8 --set mass=11 --json
    """
    show(drive.drive().cycles().to_json(), as_json, _print_cycles)


@app.command
def follow(
    *,
    over: options.Ends,
    drive: options.DriveOptions = options.CHAPTER,
    cycle: Annotated[options.Whole, Parameter(help="Which of the cycles that lsvib cycles lists, from 1.")] = 1,
    points: Annotated[options.Whole, Parameter(help="Most points each way.")] = 1000,
    out: options.OutFile | None = None,
    figure: options.Picture = None,
    as_json: options.AsJson = False,
) -> None:
    """Follow a cycle over a parameter, both ways, through folds; changes of its events are named.

    Examples of use:

        lsvib follow --over axial_force=-19:-15 --set mass=11 --set support_damping=2e-3 --set axial_force=-18

        lsvib follow --over mass=10.2:14 --set mass=11 --out branch.nc --json
    """
    from lsvib.datasets.cycles import branch_dataset, branch_json
    from lsvib.numbers import whole_between

    files, made = options.Files(out, figure), drive.drive()
    listed = made.cycles().cycles
    if not listed:
        raise InputError("the drive has no cycle to follow; see lsvib cycles.")
    chosen = listed[whole_between("cycle", cycle, 1, len(listed)) - 1]
    branch = made.follow(chosen, over.key, (over.low, over.high), points=points)
    files.write(branch_dataset(made, branch))

    def text(result: Mapping[str, Any]) -> None:
        values = [point.value for point in branch.points]
        print(f"{len(values)} cycles, {over.key} from {min(values):.9g} to {max(values):.9g}")
        for change in branch.changes:
            print(f"{change.kind} at {over.key} = {change.value:.12g}: {change.what}")

    show(branch_json(branch), as_json, text)


def _print_motion(result: Mapping[str, Any]) -> None:
    final = result["final_state"]
    numbers = ", ".join(f"{key} = {value:.15g}" for key, value in final.items() if key != "mode")
    print(f"final state: {numbers}, {name(final['mode'])} (SI units)")
    print("events: " + (", ".join(f"{n} {name(kind)}" for kind, n in result["events"].items()) or "none"))
    doubt = result.get("unresolved_because")
    print(f"attractor: {name(result['attractor'])}{f': {doubt}' if doubt else ''}")
    print(f"peak normal force: {result['peak_normal_force']:.10g} N, without the impulses of seizures")
    if result.get("peak_normal_impulse"):
        print(f"peak normal impulse of a seizure: {result['peak_normal_impulse']:.10g} N s")


def _print_sweep(result: Mapping[str, Any]) -> None:
    for kind, count in result["attractors"].items():
        print(f"{name(kind)}: {count} of {result['points']} points")
    print(f"{rate(result['points_per_second'])} points per second")


def _print_cycles(found: Mapping[str, Any]) -> None:
    for sentence in filter(None, (found["proved"], found["searched"])):
        print(sentence)
    if not found["cycles"]:
        print("no cycle found" + (" from the starts that are resolved" if found["unresolved_starts"] else ""))
    for cycle in found["cycles"]:
        print(f"{name(cycle['label'])}, {cycle['stability']} (found by: {cycle['found_by']})")
        multipliers = ", ".join(map(_multiplier, cycle["multipliers"]))
        if cycle["multiplier_error"] is not None:
            multipliers += f" (± {cycle['multiplier_error']:.1g})"
        work = {key: f"{key} {value:.6g} J" for key, value in cycle["work"].items()}
        rows = [
            ("period", f"{cycle['period']:.12g} s"),
            ("amplitude", f"{cycle['amplitude']:.12g} rad"),
            ("multipliers", multipliers),
            ("residual", f"{cycle['residual']:.1g}"),
            ("work per cycle", f"done by {work['motor']}, {work['load']}"),
            ("", f"dissipated by {work['friction']}, {work['damping']}, {work['impacts']}"),
        ]
        table([("", *row) for row in rows])
    for family in found["neutral_families"]:
        period = family["period"]
        words = "of several frequencies" if period is None else f"one of them with period {period:.9g} s"
        print(f"neutral oscillations side by side, {words}")


def _multiplier(value: float | list[float] | None) -> str:
    if value is None:
        return "none"
    return f"{value:.9g}" if isinstance(value, float) else f"{value[0]:.9g} {value[1]:+.9g}i"
