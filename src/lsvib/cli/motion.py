"""The commands that follow motions: one of them, or many over a range of parameters."""

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from lsvib.cli.app import ProgressLine, app
from lsvib.cli.options import (
    MODEL,
    MODEL_IF_GIVEN,
    ONE_VALUE,
    RESUME,
    AsJson,
    Changes,
    OutFile,
    SceneFile,
    StartItems,
    pairs,
    refuse_results_of_the_workflow,
)
from lsvib.cli.printing import print_motion, print_sweep, show
from lsvib.errors import InputError


@app.command
def simulate(
    *,
    out: Path,
    model: Annotated[str | None, MODEL_IF_GIVEN] = None,
    scene: SceneFile = None,
    changes: Changes = None,
    start: StartItems = None,
    duration: Annotated[str | None, Parameter(help="Time [s] that the motion is followed.")] = None,
    samples: Annotated[str | None, Parameter(help="Number of output times, both ends included.")] = None,
    resume: Annotated[str | None, RESUME] = None,
    as_json: AsJson = False,
) -> None:
    """Simulate a drive exactly and write its motion and events as netCDF.

    Examples of use:

        lsvib simulate --model rigid --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --start u=0.1 w=0
        --duration 0.5 --out motion.nc

        lsvib simulate --scene scene.yaml --samples 5000 --out motion.nc --json

    Parameters
    ----------
    out:
        netCDF file to write; one that is there is replaced.
    """
    from lsvib.datasets.io import write_dataset
    from lsvib.datasets.motion import as_scene, attractor_of, motion_file, run, summary
    from lsvib.files import Outputs

    refuse_results_of_the_workflow(out)
    outputs = Outputs([(out, "netCDF")], [scene] if scene else [])
    given: dict[str, Any] = {"model": model, "duration": duration, "samples": samples, "resume": resume}
    given = {key: value for key, value in given.items() if value is not None}
    if start:
        given["start"] = pairs(start)
    checked = as_scene(scene, given, pairs(changes))
    motion = run(checked)
    steady = attractor_of(motion)
    result = summary(checked, motion, steady)
    with outputs.writing() as (part,):
        write_dataset(motion_file(checked, motion, steady), part, "lsvib.simulate")
    show(result, as_json, print_motion, out)


@app.command
def sweep(
    *,
    over: Annotated[list[str], Parameter(help="KEY=START:STOP:COUNT: a parameter to vary; repeatable.", **ONE_VALUE)],
    model: Annotated[str, MODEL] = "rigid",
    changes: Changes = None,
    start: StartItems = None,
    resume: Annotated[str, RESUME] = "contact_sign",
    workers: Annotated[str, Parameter(help="Number of threads; with more than two states of processes.")] = "1",
    out: OutFile = None,
    as_json: AsJson = False,
) -> None:
    """Sweep parameters of a drive: what the motion ends on, how large and how fast, and the forces.

    Examples of use:

        lsvib sweep --set translation_damping=1000 --over axial_force=1:60:200 --json

        lsvib sweep --over mass=1:20:100 --over axial_force=-60:60:100 --workers 2 --out chart.nc

        lsvib sweep --model threads --set mass=11 --over contact_damping=1e7:1e8:100 --workers 2
    """
    from time import perf_counter

    from lsvib.api import drive_class
    from lsvib.datasets.io import write_dataset
    from lsvib.datasets.sweep import evenly
    from lsvib.datasets.sweep import summary as swept_summary
    from lsvib.datasets.sweep import sweep as swept
    from lsvib.files import Outputs

    refuse_results_of_the_workflow(out)
    outputs = Outputs([(out, "netCDF")] if out else [])
    axes, given = {name: evenly(name, text) for name, text in pairs(over).items()}, pairs(changes)
    for name in axes.keys() & given:
        raise InputError(f"{name} is given by --over and by --set; give it once.")
    begin = perf_counter()
    wanted = pairs(start) if start else None
    found = swept(drive_class(model).of(given), axes, wanted, resume, workers, ProgressLine("points"))
    seconds = perf_counter() - begin
    with outputs.writing() as parts:
        for part in parts:
            write_dataset(found, part)
    show(swept_summary(found, seconds), as_json, print_sweep)
