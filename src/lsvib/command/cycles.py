"""The commands about cycles: all of a drive's, and one of them over a parameter."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.command.app import app
from lsvib.command.options import MODEL, ONE_VALUE, RESUME, AsJson, Changes, pairs
from lsvib.command.printing import print_json
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

    found = drive_class(model).of(pairs(changes)).cycles(resume=resume).to_json()
    if as_json:
        print_json(found)
        return
    for sentence in (found["proved"], found["searched"]):
        if sentence:
            print(sentence)
    if not found["cycles"]:
        print("no cycle found")
    for cycle in found["cycles"]:
        _print_cycle(cycle)
    for family in found["neutral_families"]:
        print(f"neutral oscillations side by side, one of them with period {family['period']:.9g} s")


@app.command
def follow(
    *,
    over: Annotated[str, Parameter(help="KEY=START:STOP: the parameter and its range, with the drive's own value.")],
    model: Annotated[str, MODEL] = "rigid",
    changes: Changes = None,
    cycle: Annotated[str, Parameter(help="Which of the cycles that lsvib cycles lists, from 1.")] = "1",
    resume: Annotated[str, RESUME] = "contact_sign",
    points: Annotated[str, Parameter(help="Most points each way.")] = "1000",
    out: Annotated[
        Path | None, Parameter(help="netCDF file to write; one that is there is replaced.", **ONE_VALUE)
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Follow a cycle over a parameter, both ways, through folds; changes of its events are named.

    Examples of use:

        lsvib follow --over axial_force=-19:-15 --set mass=11 --set support_damping=2e-3 --set axial_force=-18

        lsvib follow --over mass=10.2:14 --set mass=11 --out branch.nc --json
    """
    from lsvib import numbers
    from lsvib.api import drive_class
    from lsvib.data.cycles import branch_dataset, branch_json
    from lsvib.data.writer import write_dataset
    from lsvib.files import Outputs

    outputs = Outputs([(out, "netCDF")] if out else [])
    ((parameter, text),) = pairs([over]).items()
    low, colon, high = text.partition(":")
    if not colon or ":" in high:
        raise InputError(f"over: {parameter}={text} is not of the form KEY=START:STOP.")
    drive = drive_class(model).of(pairs(changes))
    listed = drive.cycles(resume=resume).cycles
    try:
        number = numbers.whole(cycle)
    except numbers.NotNumber as error:
        raise InputError(f"cycle = {cycle} {error}.") from None
    if not listed:
        raise InputError("the drive has no cycle to follow; see lsvib cycles.")
    if not 1 <= number <= len(listed):
        raise InputError(f"cycle = {number} is outside the allowed range 1 <= cycle <= {len(listed)}.")
    span: Any = (low, high)
    branch = drive.follow(listed[number - 1], parameter, span, resume=resume, points=points)  # type: ignore[arg-type]
    with outputs.writing() as parts:
        for part in parts:
            write_dataset(branch_dataset(drive, branch), part)
    if as_json:
        print_json(branch_json(branch))
        return
    values = [point.value for point in branch.points]
    print(f"{len(values)} cycles, {parameter} from {min(values):.9g} to {max(values):.9g}")
    for change in branch.changes:
        print(f"{change.kind} at {parameter} = {change.value:.12g}: {change.what}")


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
