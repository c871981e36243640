"""The commands about cycles: all of a drive's, and one of them over a parameter."""

from collections.abc import Mapping
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.cli.app import app
from lsvib.cli.options import MODEL, RESUME, AsJson, Changes, OutFile, ends, pairs, refuse_results_of_the_workflow
from lsvib.cli.printing import show
from lsvib.errors import InputError


@app.command
def cycles(
    *,
    model: Annotated[str, MODEL] = "rigid",
    changes: Changes = None,
    resume: Annotated[str, RESUME] = "contact_sign",
    as_json: AsJson = False,
) -> None:
    """Find the cycles of a drive, attracting and repelling: period, multipliers, amplitude, work.

    Examples of use:

        lsvib cycles --set mass=11 --set support_damping=2e-3 --set axial_force=-18.37

        lsvib cycles --model threads --set mass=11 --json
    """
    from lsvib.api import drive_class

    show(drive_class(model).of(pairs(changes)).cycles(resume=resume).to_json(), as_json, _print_cycles)


@app.command
def follow(
    *,
    over: Annotated[str, Parameter(help="KEY=START:STOP: the parameter and its range, with the drive's own value.")],
    model: Annotated[str, MODEL] = "rigid",
    changes: Changes = None,
    cycle: Annotated[str, Parameter(help="Which of the cycles that lsvib cycles lists, from 1.")] = "1",
    resume: Annotated[str, RESUME] = "contact_sign",
    points: Annotated[str, Parameter(help="Most points each way.")] = "1000",
    out: OutFile = None,
    as_json: AsJson = False,
) -> None:
    """Follow a cycle over a parameter, both ways, through folds; changes of its events are named.

    Examples of use:

        lsvib follow --over axial_force=-19:-15 --set mass=11 --set support_damping=2e-3 --set axial_force=-18

        lsvib follow --over mass=10.2:14 --set mass=11 --out branch.nc --json
    """
    from lsvib import numbers
    from lsvib.api import drive_class
    from lsvib.datasets.cycles import branch_dataset, branch_json
    from lsvib.datasets.io import write_dataset
    from lsvib.files import Outputs

    refuse_results_of_the_workflow(out)
    outputs = Outputs([(out, "netCDF")] if out else [])
    ((parameter, given),) = pairs([over]).items()
    span: Any = ends("over", parameter, given, "KEY=START:STOP")
    drive = drive_class(model).of(pairs(changes))
    listed = drive.cycles(resume=resume).cycles
    if not listed:
        raise InputError("the drive has no cycle to follow; see lsvib cycles.")
    number = numbers.whole_between("cycle", cycle, 1, len(listed))
    branch = drive.follow(listed[number - 1], parameter, span, resume=resume, points=points)  # type: ignore[arg-type]
    with outputs.writing() as parts:
        for part in parts:
            write_dataset(branch_dataset(drive, branch), part)

    def text(result: Mapping[str, Any]) -> None:
        """Print how far the branch goes, and what changes on it."""
        values = [point.value for point in branch.points]
        print(f"{len(values)} cycles, {parameter} from {min(values):.9g} to {max(values):.9g}")
        for change in branch.changes:
            print(f"{change.kind} at {parameter} = {change.value:.12g}: {change.what}")

    show(branch_json(branch), as_json, text)


def _print_cycles(found: Mapping[str, Any]) -> None:
    for sentence in (found["proved"], found["searched"]):
        if sentence:
            print(sentence)
    if not found["cycles"]:
        print("no cycle found")
    for cycle in found["cycles"]:
        _print_cycle(cycle)
    for family in found["neutral_families"]:
        period = family["period"]
        words = "of several frequencies" if period is None else f"one of them with period {period:.9g} s"
        print(f"neutral oscillations side by side, {words}")


def _print_cycle(cycle: dict[str, Any]) -> None:
    """Print a cycle in a few lines."""
    work = cycle["work"]
    taken = {name: 0 - work[name] for name in ("friction", "damping", "impacts")}
    multipliers = ", ".join(map(_shown, cycle["multipliers"]))
    if cycle["multiplier_error"] is not None:
        multipliers += f" (± {cycle['multiplier_error']:.1g})"
    print(f"{cycle['label'].replace('_', ' ')}, {cycle['stability']} (found by: {cycle['found_by']})")
    print(f"  period {cycle['period']:.12g} s, amplitude {cycle['amplitude']:.12g} rad")
    print(f"  multipliers {multipliers}, residual {cycle['residual']:.1g}")
    print(
        f"  work per cycle [J]: motor {work['motor']:.6g}, load {work['load']:.6g}, "
        f"friction {taken['friction']:.6g}, damping {taken['damping']:.6g}, impacts {taken['impacts']:.6g}"
    )


def _shown(multiplier: float | list[float] | None) -> str:
    if multiplier is None:
        return "none"
    return f"{multiplier:.9g}" if isinstance(multiplier, float) else f"{multiplier[0]:.9g} {multiplier[1]:+.9g}i"
