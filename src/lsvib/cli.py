"""The ``lsvib`` command."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import App, CycloptsError, Parameter

from lsvib import __version__
from lsvib.errors import InputError, LsvibError
from lsvib.printing import (
    print_json,
    print_map,
    print_motion,
    print_parameters,
    print_stability,
    print_sweep,
    print_thresholds,
)
from lsvib.terminal import Progress, told

app = App(
    name="lsvib",
    help="Friction-induced vibration of lead-screw drives, computed exactly from event to event.",
    version=__version__,
    result_action="return_value",
)

_ONE_VALUE = {"negative_iterable": ""}
Changes = Annotated[
    list[str] | None,
    Parameter(name="--set", help="KEY=VALUE: change a parameter of the drive; repeatable.", **_ONE_VALUE),
]
AsJson = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object.")]


@app.command
def thresholds(
    *,
    model: Annotated[str, Parameter(help="rigid, threads, support or nut.")] = "rigid",
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Compute thresholds of a drive.

    Of the rigid model the chapter's: critical mass and friction, the forces of Fig. 8.6, that of global stability. Of
    another model the boundaries of stability of steady sliding in mass, friction, and the damping that it adds.

    Examples of use:

        lsvib thresholds

        lsvib thresholds --set translation_damping=2000 --json

        lsvib thresholds --model threads --set mass=9 --set contact_damping=5e4
    """
    from lsvib.steady_sliding.summary import threshold_table

    pairs = _pairs(changes)
    if model == "rigid" and "axial_force" in pairs:
        raise InputError(
            "the forces of the rigid drive are thresholds of axial_force, so --set axial_force would change nothing."
        )
    table = threshold_table(pairs, model)
    if as_json:
        print_json(table)
        return
    print_thresholds(table)


@app.command
def stability(
    *,
    model: Annotated[str, Parameter(help="rigid, threads, support or nut.")] = "rigid",
    changes: Changes = None,
    as_json: AsJson = False,
) -> None:
    """Classify the steady sliding of a drive by eqs (8.18) to (8.21).

    Examples of use:

        lsvib stability --set mass=11

        lsvib stability --set mass=1 --set translation_damping=1000 --set axial_force=25 --json

        lsvib stability --model threads --set mass=9 --set contact_stiffness=1e8 --set contact_damping=5e4

        lsvib stability --model support --set mass=15 --set friction_coefficient=0.3
    """
    from lsvib.steady_sliding.stability_table import stability_table

    table = stability_table(_pairs(changes), model)
    if as_json:
        print_json(table)
        return
    print_stability(table)


@app.command
def simulate(
    *,
    out: Path,
    model: str | None = None,
    scene: Annotated[Path | None, Parameter(help="YAML file of a scene to start from.")] = None,
    changes: Changes = None,
    initial: Annotated[
        list[str] | None, Parameter(consume_multiple=True, help="Initial state: u=RAD w=RAD_PER_S ...", **_ONE_VALUE)
    ] = None,
    t_end: Annotated[str | None, Parameter(help="End time [s].")] = None,
    samples: Annotated[str | None, Parameter(help="Number of output times, both ends included.")] = None,
    resume: Annotated[str | None, Parameter(help="Motion after a seizure: contact_sign or at_once.")] = None,
    as_json: AsJson = False,
) -> None:
    """Simulate a drive exactly and write its motion and events as netCDF.

    Examples of use:

        lsvib simulate --model rigid --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --initial u=0.1 w=0
        --t-end 0.5 --out motion.nc

        lsvib simulate --scene scene.yaml --samples 5000 --out motion.nc --json

    Parameters
    ----------
    out:
        netCDF file to write; one that is there is replaced.
    model:
        Model of the drive: rigid (the default), threads, support or nut.
    """
    from lsvib.data.simulation import as_scene, attractor_of, motion_file, run, summary
    from lsvib.data.writer import write_dataset
    from lsvib.files import Outputs

    outputs = Outputs([(out, "netCDF")], [scene] if scene else [])
    given: dict[str, Any] = {"model": model, "t_end": t_end, "samples": samples, "resume": resume}
    given = {key: value for key, value in given.items() if value is not None}
    if initial:
        given["initial"] = _pairs(initial)
    checked = as_scene(scene, given, _pairs(changes))
    motion = run(checked)
    steady = attractor_of(motion)
    result = summary(checked, motion, steady)
    with outputs.writing() as (part,):
        write_dataset(motion_file(checked, motion, steady), part, "lsvib.simulate")
    if as_json:
        print_json(result)
        return
    print(f"wrote {out}")
    print_motion(result)


@app.command
def figure(
    number: str,
    *,
    changes: Changes = None,
    config: Annotated[Path | None, Parameter(help="Settings of the figures; see below for the default.")] = None,
    out: Annotated[Path, Parameter(help="Folder to write to.")] = Path("figures"),
    as_json: AsJson = False,
) -> None:
    """Build one figure, of the chapter or beyond it: its dataset, its checks, and the picture as PNG and PDF.

    The files are FOLDER/fig8_06.nc, fig8_06_checks.json, fig8_06.png and fig8_06.pdf; the results of the workflow stay
    as they are. The settings are those of the file config/config.yaml if there is one here, else those that come with
    lsvib. Changed parameters leave the chapter's, so its checks are then reported as they come out, not enforced. A
    parameter that the figure varies itself, or does not depend on, cannot be changed.

    Examples of use:

        lsvib figure 8.6

        lsvib figure 8.9 --set support_damping=4e-4 --out mine

        lsvib figure limit_process

    Parameters
    ----------
    number:
        Number of the figure in the chapter, e.g. 8.6, or its name, e.g. limit_process.
    """
    from lsvib.drives.scene import read_yaml
    from lsvib.figures.build import build_figure
    from lsvib.figures.configuration import DEFAULT, section
    from lsvib.figures.folders import accuracy_figures, default_figures
    from lsvib.files import Outputs

    labels = {name: _label(name) for name in (*default_figures(), *accuracy_figures())}
    name = next((name for name, label in labels.items() if number in (name, label)), None)
    if name is None:
        raise InputError(f"figure {number} is not one of {', '.join(labels.values())}.")
    here = Path("config/config.yaml")
    config = config or (here if here.is_file() else DEFAULT)
    settings = section(read_yaml(config), name)
    if changes:
        settings = {**settings, "drive": _changed_drive(number, name, settings, _pairs(changes))}
    _refuse_results_of_the_workflow(out)
    endings = {".nc": "netCDF", "_checks.json": "JSON", ".png": "PNG", ".pdf": "PDF"}
    files = [(out / f"{name}{ending}", kind) for ending, kind in endings.items()]
    with Outputs(files, [config], make_folders=True).writing() as parts:
        checks = build_figure(name, settings, *parts)
    picture = out / f"{name}.png"
    if as_json:
        print_json({"figure": str(picture), "checks": [check.to_json() for check in checks]})
    else:
        for check in checks:
            print(check.sentence())
        print(f"wrote {picture}, its PDF, dataset and checks")
    if not changes and not all(check.passed for check in checks):
        raise LsvibError(f"figure {number}: a check failed; see above.")


@app.command
def attraction(
    *,
    grid: Annotated[
        list[str],
        Parameter(consume_multiple=True, help="Two axes KEY=START:STOP:COUNT; KEY=VALUE fixes another.", **_ONE_VALUE),
    ],
    out: Path,
    model: Annotated[str, Parameter(help="rigid, threads, support or nut.")] = "rigid",
    changes: Changes = None,
    resume: Annotated[str, Parameter(help="Motion after a seizure: contact_sign or at_once.")] = "contact_sign",
    quantities: Annotated[
        list[str],
        Parameter(consume_multiple=True, help="Any of label, time, seizures, first_event; label is.", **_ONE_VALUE),
    ] = ["label"],  # noqa: B006
    threads: Annotated[str, Parameter(help="Number of threads.")] = "1",
    refine: Annotated[bool, Parameter(negative="", help="Compute only what lies near boundaries.")] = False,
    figure: Annotated[Path | None, Parameter(help="PNG file to draw the map to; a PDF is written beside it.")] = None,
    as_json: AsJson = False,
) -> None:
    """Map the region of attraction: the attractor of the motion from every start of a grid.

    Examples of use:

        lsvib attraction --set mass=11 --set support_damping=1e-3 --set axial_force=-10 --grid u=-0.3:0.3:2000
        w=-150:150:2000 --out map.nc --threads 2

        lsvib attraction --model threads --set mass=11 --grid u=-0.05:0.05:100 w=-15:15:100 --out slice.nc

    Parameters
    ----------
    out:
        netCDF file to write; one that is there is replaced.
    """
    from lsvib.api import drive_class, map_attraction
    from lsvib.basins.grid import Grid
    from lsvib.data.attraction_map import summary
    from lsvib.data.writer import write_dataset
    from lsvib.files import Outputs

    if figure is not None and figure.suffix != ".png":
        raise InputError(f"figure = {figure} does not end in .png; a PDF is written beside it.")
    pictures = [(figure, "PNG"), (figure.with_suffix(".pdf"), "PDF")] if figure else []
    outputs = Outputs([(out, "netCDF"), *pictures])
    starts = Grid.parse(grid)
    if figure is not None and refine:
        raise InputError("refine is for labels of the rigid drive, without a figure and other quantities.")
    if figure is not None and (starts.x.coordinate, starts.y.coordinate) != ("u", "w"):
        raise InputError("figure is for maps of u and w; leave it out for a plane of other coordinates.")
    drive = drive_class(model).of(_pairs(changes))
    found = map_attraction(drive, starts, quantities, resume, threads, refine, Progress())
    dataset, counts = found.dataset, found.counts
    area = dataset["basin_area"].item() if "basin_area" in dataset else None
    result = summary(counts, area, found.seconds)
    with outputs.writing() as parts:
        write_dataset(dataset, parts[0], "lsvib.attraction")
        if figure is not None:
            from lsvib.figures.attraction.picture import draw
            from lsvib.figures.drawing.style import save

            save(draw(dataset), *parts[1:])
    if as_json:
        print_json(result)
        return
    print(f"wrote {out}")
    print_map(result, counts)


@app.command
def assess(
    sheet: Path,
    *,
    out: Annotated[Path, Parameter(help="Folder to write index.html, assessment.nc and assessment.json to.")],
    samples: Annotated[str, Parameter(help="Drives drawn from the uncertainties, a power of two.")] = "4096",
    seed: Annotated[str, Parameter(help="Seed of the samples.")] = "1",
    threads: Annotated[str, Parameter(help="Number of threads.")] = "1",
    share: Annotated[str | None, Parameter(help="K/N: only compute the K-th of N shares of the samples.")] = None,
    as_json: AsJson = False,
) -> None:
    """Assess a drive from its data sheet: will it vibrate, how close is it, and what should be changed.

    Examples of use:

        lsvib assess examples/powered_seat.yaml --out report

        lsvib assess drive.yaml --samples 1048576 --threads 8 --out report

    Parameters
    ----------
    sheet:
        YAML file of the data sheet; see docs/assess.md.
    """
    try:
        from lsvib.assess import run
    except ModuleNotFoundError as error:
        raise InputError(f"assess needs the library {error.name}: pip install lsvib[assess].") from None

    if share is not None:
        print(f"kept {run.sample_share(sheet, out, samples, seed, share)} blocks of samples in {out}")
        return
    result = run.assess_file(sheet, out, samples, seed, threads, Progress("blocks of samples"))
    if as_json:
        print_json(result)
        return
    print(result["sentence"])
    print(f"wrote {out / 'index.html'}, assessment.nc and assessment.json")


@app.command
def sweep(
    *,
    over: Annotated[list[str], Parameter(help="KEY=START:STOP:COUNT: a parameter to vary; repeatable.", **_ONE_VALUE)],
    changes: Changes = None,
    initial: Annotated[
        list[str] | None,
        Parameter(consume_multiple=True, help="Initial state: u=RAD w=RAD_PER_S.", **_ONE_VALUE),
    ] = None,
    resume: Annotated[str, Parameter(help="Motion after a seizure: contact_sign or at_once.")] = "contact_sign",
    workers: Annotated[str, Parameter(help="Number of processes.")] = "1",
    out: Annotated[Path | None, Parameter(help="netCDF file to write; one that is there is replaced.")] = None,
    as_json: AsJson = False,
) -> None:
    """Sweep parameters of the rigid drive: what the motion ends on, how large and how fast, and the forces.

    Examples of use:

        lsvib sweep --set translation_damping=1000 --over axial_force=1:60:200 --json

        lsvib sweep --over mass=1:20:100 --over axial_force=-60:60:100 --workers 2 --out chart.nc
    """
    from time import perf_counter

    from lsvib.api import RigidDrive, rule
    from lsvib.data.sweep import evenly
    from lsvib.data.sweep import summary as swept_summary
    from lsvib.data.sweep import sweep as swept
    from lsvib.data.writer import write_dataset
    from lsvib.files import Outputs

    outputs = Outputs([(out, "netCDF")] if out else [])
    axes = {name: evenly(name, text) for name, text in _pairs(over).items()}
    start = _pairs(initial) if initial else None
    begin = perf_counter()
    found = swept(RigidDrive.of(_pairs(changes)), axes, start, rule(resume), workers, Progress("points"))
    seconds = perf_counter() - begin
    with outputs.writing() as parts:
        for part in parts:
            write_dataset(found, part)
    result = swept_summary(found, seconds)
    if as_json:
        print_json(result)
        return
    print_sweep(result)


@app.command
def config(
    *,
    model: Annotated[str | None, Parameter(help="rigid (the default), threads, support or nut.")] = None,
    changes: Changes = None,
    scene: Annotated[Path | None, Parameter(help="YAML file of a scene to start from.")] = None,
    as_json: AsJson = False,
) -> None:
    """Show the effective parameters of a drive, with units and allowed ranges.

    Examples of use:

        lsvib config

        lsvib config --set lead_angle_deg=4 --json

        lsvib config --model threads
    """
    from lsvib.api import drive_class
    from lsvib.drives.parameters import allowed_range, described, names_and_values

    start = _known_keys(scene) if scene else {}
    kind = drive_class(model or start.get("model", "rigid"))
    drive = kind.of(names_and_values("drive", start.get("drive"))).replace(**_pairs(changes))
    fields = {}
    for key, value in drive:
        about = described(kind, key)
        allowed = allowed_range(kind, key)
        fields[key] = {"value": value, "unit": about["unit"], "symbol": about["symbol"], "allowed": allowed}
    if as_json:
        print_json(fields)
        return
    print_parameters(fields)


def _known_keys(scene: Path) -> dict[str, Any]:
    """Read the file of a scene; every key is one of a scene."""
    from lsvib.drives.scene import Scene, read_yaml

    values = read_yaml(scene)
    for key in values:
        if key not in Scene.model_fields:
            raise InputError(f"{key} is not a known key; the known keys are {', '.join(Scene.model_fields)}.")
    return values


def _refuse_results_of_the_workflow(folder: Path) -> None:
    """Refuse a folder of datasets, checks or figures of the workflow, which could not tell our files from its own."""
    folder = folder.resolve()
    if folder.parent.name == "results" and (folder.parent.parent / "Snakefile").is_file():
        raise InputError(f"out = {folder} belongs to the workflow, which fills it by itself; name another folder.")


def _changed_drive(number: str, name: str, section: Mapping[str, Any], changes: Mapping[str, str]) -> dict[str, Any]:
    """Return the drive of a figure with changes; a change that would change nothing in the figure is refused."""
    from lsvib.drives.parameters import RigidParameters
    from lsvib.figures.configuration import settings_of
    from lsvib.numbers import number as number_of

    settings = settings_of(name)
    if "drive" not in settings.model_fields:
        raise InputError(f"figure {number} has no drive of its own, so --set cannot change it.")
    for key in changes:
        if key in settings.unused:
            raise InputError(
                f"figure {number} does not depend on {key} of its drive, so --set {key} would change nothing."
            )
    given = section.get("drive", {})
    if changes.keys() & {"lead_angle", "lead_angle_deg"}:
        given = {key: value for key, value in given.items() if key not in ("lead_angle", "lead_angle_deg")}
    RigidParameters.of({**given, **changes})  # refuses a key or a value with the words of the other commands
    return {**given, **{key: number_of(text) for key, text in changes.items()}}


def _label(name: str) -> str:
    """Number of a figure of the chapter by its name: 8.6 for fig8_06; other figures keep their name."""
    chapter, _, number = name.removeprefix("fig").partition("_")
    return f"{chapter}.{int(number)}" if chapter.isdigit() and number.isdigit() else name


def _pairs(items: list[str] | None) -> dict[str, str]:
    """Split KEY=VALUE items; the values stay text, which the models read and check."""
    pairs: dict[str, str] = {}
    for item in items or []:
        key, equals, value = item.partition("=")
        if not equals or not key or not value:
            raise InputError(f"{item!r} is not of the form KEY=VALUE.")
        if key in pairs:
            raise InputError(f"{key} is given twice, as {pairs[key]} and as {value}; give it once.")
        pairs[key] = value
    return pairs


def main() -> None:
    """Run the command; unacceptable input ends in one sentence on the error stream and exit code 2."""
    told(lambda: app(exit_on_error=False, print_error=False), CycloptsError)
