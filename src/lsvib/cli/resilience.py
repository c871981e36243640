"""The command about the perturbations that steady sliding tolerates."""

import math
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.cli.app import ProgressLine, app
from lsvib.cli.options import ONE_VALUE, AsJson, Changes, OutFile, ends, pairs, refuse_results_of_the_workflow
from lsvib.cli.printing import show
from lsvib.errors import InputError


@app.command
def resilience(
    *,
    changes: Changes = None,
    window: Annotated[
        list[str] | None,
        Parameter(consume_multiple=True, help="Part of the phase plane: u=LOW:HIGH w=LOW:HIGH.", **ONE_VALUE),
    ] = None,
    over: Annotated[
        list[str] | None,
        Parameter(help="KEY=START:STOP:COUNT: a parameter to vary; repeatable. Needs --out.", **ONE_VALUE),
    ] = None,
    out: OutFile = None,
    as_json: AsJson = False,
) -> None:
    """Find the largest perturbations that the rigid drive's steady sliding tolerates, and how much of a window settles.

    Examples of use:

        lsvib resilience --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --window u=-0.3:0.3 w=-150:150

        lsvib resilience --set mass=11 --set support_damping=1e-3 --over axial_force=-33:-1:65 --out reserve.nc
    """
    from lsvib import RigidDrive
    from lsvib.datasets.io import write_dataset
    from lsvib.datasets.sweep import evenly, resilience_sweep, window_of
    from lsvib.files import Outputs

    refuse_results_of_the_workflow(out)
    if (over is None) != (out is None):
        raise InputError("over and out belong together: the values over a parameter are written to a file.")
    limits = (
        None
        if window is None
        else {name: ends("window", name, text, "KEY=LOW:HIGH") for name, text in pairs(window).items()}
    )
    drive, part = RigidDrive.of(pairs(changes)), window_of(limits)
    if over is None:
        reserve = drive.resilience(part)
        show(reserve.to_json(), as_json, lambda result: _print(reserve))
        return
    outputs = Outputs([(out, "netCDF")] if out else [])
    axes = {name: evenly(name, text) for name, text in pairs(over).items()}
    found = resilience_sweep(drive, axes, part, ProgressLine("points"))
    with outputs.writing() as files:
        for file in files:
            write_dataset(found, file)
    result = {"points": int(found.fatal_energy.size), "not_covered": int(found.fatal_energy.isnull().sum())}
    text = f"wrote {out}: {result['points']} points, {result['not_covered']} of them not covered"
    show(result, as_json, lambda result: print(text))


def _print(found: Any) -> None:
    print(f"boundary of the region of attraction: {found.boundary.replace('_', ' ')}")
    print(f"largest tolerated perturbation of the deflection: {_shown(found.angle, 'rad')}")
    print(f"largest tolerated perturbation of the speed: {_shown(found.speed, 'rad/s')}")
    u, w = found.state
    state = f", at u = {u:.12g} rad, w = {w:.12g} rad/s" if math.isfinite(found.energy) else ""
    print(f"largest tolerated perturbation by energy: {_shown(found.energy, 'J')}{state}")
    if found.window is not None:
        print(f"share of the window that settles: {found.fraction:.12g}")


def _shown(size: float, unit: str) -> str:
    """A perturbation with its unit; where all are tolerated, which is an infinite one in files, it has no limit."""
    return f"{size:.12g} {unit}" if math.isfinite(size) else "unlimited"
