"""The ``lsvib`` command."""

import json
import os
import sys
import warnings
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, NoReturn

from cyclopts import App, CycloptsError, Parameter

from lsvib import __version__
from lsvib.errors import InputError, LsvibError

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
    from lsvib.analysis.summary import threshold_table

    pairs = _pairs(changes)
    if model == "rigid" and "axial_force" in pairs:
        raise InputError(
            "the forces of the rigid drive are thresholds of axial_force, so --set axial_force would change nothing."
        )
    table = threshold_table(pairs, model)
    if as_json:
        _print_json(table)
        return
    for name, entry in table.items():
        if "stable_intervals" in entry:
            _print_boundary(name, entry)
            continue
        if entry["value"] is None:
            print(f"{name:22s} none: {entry['reason']}")
            continue
        line = f"{name:22s} {entry['value']:.12g} {entry['unit']}"
        if entry["expected"] is not None:
            verdict = "pass" if entry["passed"] else "FAIL"
            line += f"   chapter {entry['expected']:g}, relative error {entry['relative_error']:.2%}, {verdict}"
        print(line)


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
    from lsvib.analysis.summary import stability_table

    table = stability_table(_pairs(changes), model)
    if as_json:
        _print_json(table)
        return
    neutral = table["class"] in ("neutral", "centre")
    verdict = "stable" if table["stable"] else "neutral" if neutral else "unstable"
    kind = table["class"].replace("_", " ")
    print(f"steady sliding is {verdict}{'' if kind == verdict else f' ({kind})'}")
    for value in table["eigenvalues"]:
        print(f"  eigenvalue {value['real']:.10g} {value['imaginary']:+.10g}i 1/s")
    _print_quantities(table.get("quantities", {}))
    for quantity in ("effective_inertia", "effective_damping") if model == "rigid" else ():
        entry = table[quantity]
        print(f"  {quantity}: law + {entry['plus']:.10g}, law - {entry['minus']:.10g} {entry['unit']}")
    _print_conditions(table["conditions"])
    if "without_damping" in table:
        print(f"without any damping: {table['without_damping']['class']}")
        _print_quantities(table["without_damping"]["quantities"])
        _print_conditions(table["without_damping"]["conditions"])


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
    from lsvib.datasets.trajectory import as_scene, attractor_of, motion_file, run, summary
    from lsvib.datasets.writer import write_dataset
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
        _print_json(result)
        return
    print(f"wrote {out}")
    final = result["final_state"]
    numbers = ", ".join(f"{key} = {value:.15g}" for key, value in final.items() if key != "mode")
    print(f"final state: {numbers}, {final['mode'].replace('_', ' ')} (SI units)")
    print("events: " + (", ".join(f"{n} {kind.replace('_', ' ')}" for kind, n in result["events"].items()) or "none"))
    print(f"attractor: {result['attractor'].replace('_', ' ')}")
    print(f"peak normal force: {result['peak_normal_force']:.10g} N, without the impulses of seizures")
    if result.get("peak_normal_impulse"):
        print(f"peak normal impulse of a seizure: {result['peak_normal_impulse']:.10g} N s")


@app.command
def figure(
    number: str,
    *,
    changes: Changes = None,
    config: Annotated[Path | None, Parameter(help="Settings of the figures; see below for the default.")] = None,
    out: Annotated[Path, Parameter(help="Folder to write to.")] = Path("results"),
    as_json: AsJson = False,
) -> None:
    """Build one figure, of the chapter or beyond it: its dataset, its checks, and the picture as PNG and PDF.

    The settings are those of the file config/config.yaml if there is one here, else those that come with lsvib.
    Changed parameters leave the chapter's, so its checks are then reported as they come out, not enforced. A parameter
    that the figure varies itself, or does not depend on, cannot be changed.

    Examples of use:

        lsvib figure 8.6

        lsvib figure 8.9 --set support_damping=4e-4 --out mine

        lsvib figure limit_process

    Parameters
    ----------
    number:
        Number of the figure in the chapter, e.g. 8.6, or its name, e.g. limit_process.
    """
    from importlib import import_module

    from lsvib.datasets.writer import write_dataset
    from lsvib.files import Outputs, write_json
    from lsvib.models.scene import read_yaml
    from lsvib.settings import DEFAULT, check_section, figures

    here = Path("config/config.yaml")
    config = config or (here if here.is_file() else DEFAULT)
    settings = read_yaml(config)
    labels = {name: _label(name) for name in figures(settings)}
    name = next((name for name, label in labels.items() if number in (name, label)), number)
    if not labels:
        raise InputError(f"{config} lists no figures that it has settings for, under figures or accuracy_figures.")
    if name not in labels:
        raise InputError(f"figure {number} is not one of those in {config}: {', '.join(labels.values())}.")
    check_section(settings, name)
    section = settings[name]
    if changes:
        section["drive"] = _changed_drive(number, name, section, _pairs(changes))
    files = [
        ("datasets", "nc", "netCDF"),
        ("checks", "json", "JSON"),
        ("figures", "png", "PNG"),
        ("figures", "pdf", "PDF"),
    ]
    paths = [(out / folder / f"{name}.{suffix}", kind) for folder, suffix, kind in files]
    outputs = Outputs(paths, [config], make_folders=True)
    module = import_module(f"lsvib.datasets.{name}")
    dataset = module.build(section)
    checks = module.checks(dataset)
    drawn = import_module(f"lsvib.figures.{name}").draw(dataset)
    from lsvib.figures.style import save

    with outputs.writing() as (data, verdicts, *pictures):
        write_dataset(dataset, data, f"lsvib.datasets.{name}.build")
        write_json([check.to_json() for check in checks], verdicts)
        save(drawn, *pictures)
    picture = paths[2][0]
    if as_json:
        _print_json({"figure": str(picture), "checks": [check.to_json() for check in checks]})
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
    from time import perf_counter

    from lsvib.analysis import refinement as refined
    from lsvib.analysis.attraction import mapper
    from lsvib.analysis.grid import Grid
    from lsvib.datasets.attraction import attraction_map, refined_map, summary
    from lsvib.datasets.writer import write_dataset
    from lsvib.files import Outputs
    from lsvib.models.model import find_model

    workers = _whole("threads", threads, 1, 4096)  # more than any machine has
    if resume not in ("contact_sign", "at_once"):
        raise InputError(f"resume = {resume!r} is not one of contact_sign, at_once.")
    if figure is not None and figure.suffix != ".png":
        raise InputError(f"figure = {figure} does not end in .png; a PDF is written beside it.")
    pictures = [(figure, "PNG"), (figure.with_suffix(".pdf"), "PDF")] if figure else []
    outputs = Outputs([(out, "netCDF"), *pictures])
    starts = Grid.parse(grid)
    mapped = mapper(find_model(model).drive.of(_pairs(changes)), model, resume=resume)
    wanted = list(dict.fromkeys(["label", *quantities]))
    if figure is not None and (starts.x.coordinate, starts.y.coordinate) != ("u", "w"):
        raise InputError("figure is for maps of u and w; leave it out for a plane of other coordinates.")
    if refine and (wanted != ["label"] or figure is not None or model != "rigid"):
        raise InputError("refine is for labels of the rigid drive, without a figure and other quantities.")
    mapped.cells(starts, slice(0, 1), slice(0, 1), wanted)  # so that compiling is not part of the speed
    begin = perf_counter()
    if refine:
        blocks = refined.refine(mapped, starts)
        seconds, counts, dataset = perf_counter() - begin, blocks.counts(), refined_map(mapped, blocks)
    else:
        found = mapped.cells(starts, quantities=wanted, threads=workers, progress=_Progress())
        seconds, counts = perf_counter() - begin, refined.count(found["label"])
        dataset = attraction_map(mapped, starts, found)
    area = dataset["basin_area"].item() if "basin_area" in dataset else None
    result = summary(counts, area, seconds)
    with outputs.writing() as parts:
        write_dataset(dataset, parts[0], "lsvib.attraction")
        if figure is not None:
            from lsvib.figures.attraction import draw
            from lsvib.figures.style import save

            save(draw(dataset), *parts[1:])
    if as_json:
        _print_json(result)
        return
    print(f"wrote {out}")
    for kind, cells in counts.items():
        if cells and kind >= 0:
            share = f"a fraction of {cells / result['cells']:.6g}"
            print(f"{kind.name.lower().replace('_', ' ')}: {cells} of {result['cells']} cells, {share}")
    print(f"unresolved: {result['unresolved']} cells")
    if area is not None:
        print(f"exact area of the basin of steady sliding in the map: {area:.12g} rad2/s")
    print(f"{result['cells_per_second']:.3g} cells per second")


class _Progress:
    """Tell on the error stream how far a map is: a line that is rewritten, or in a log one line for every 5 %."""

    def __init__(self) -> None:
        self.shown = -1

    def __call__(self, done: int, total: int) -> None:
        terminal = sys.stderr.isatty()
        percent = 100 * done // total
        step = percent if terminal else percent // 5
        if step == self.shown:
            return
        self.shown = step
        end = "\n" if done == total or not terminal else ""
        print(f"{chr(13) if terminal else ''}{percent:3d} % of {total} rows", end=end, file=sys.stderr, flush=True)


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
    from lsvib.models.model import find_model
    from lsvib.models.parameters import allowed_range, names_and_values
    from lsvib.models.scene import Scene, read_yaml

    start = read_yaml(scene) if scene else {}
    for key in start:
        if key not in Scene.model_fields:
            raise InputError(f"{key} is not a known key; the known keys are {', '.join(Scene.model_fields)}.")
    kind = find_model(model or start.get("model", "rigid")).drive
    drive = kind.of(names_and_values("drive", start.get("drive"))).replace(**_pairs(changes))
    fields = {
        key: {
            "value": value,
            "unit": kind.model_fields[key].json_schema_extra["unit"],
            "symbol": kind.model_fields[key].json_schema_extra["symbol"],
            "allowed": allowed_range(kind, key),
        }
        for key, value in drive
    }
    if as_json:
        _print_json(fields)
        return
    for key, entry in fields.items():
        print(f"{key:21s} {entry['symbol']:7s} = {entry['value']:<20.15g} {entry['unit']:15s} {entry['allowed']}")


def _changed_drive(number: str, name: str, section: Mapping[str, Any], changes: Mapping[str, str]) -> dict[str, Any]:
    """Return the drive of a figure with changes; a change that would change nothing in the figure is refused."""
    from lsvib.settings import UNUSED

    if "drive" not in section:
        raise InputError(f"figure {number} has no drive of its own, so --set cannot change it.")
    for key in changes:
        if key in UNUSED.get(name, ()):
            raise InputError(
                f"figure {number} does not depend on {key} of its drive, so --set {key} would change nothing."
            )
    given = section["drive"]
    if changes.keys() & {"lead_angle", "lead_angle_deg"}:
        given = {key: value for key, value in given.items() if key not in ("lead_angle", "lead_angle_deg")}
    return {**given, **changes}


def _label(name: str) -> str:
    """Number of a figure of the chapter by its name: 8.6 for fig8_06; other figures keep their name."""
    chapter, _, number = name.removeprefix("fig").partition("_")
    return f"{chapter}.{int(number)}" if chapter.isdigit() and number.isdigit() else name


def _whole(name: str, text: str, least: int, most: int) -> int:
    """Read an option that is a whole number."""
    from lsvib.models.numbers import NotNumber, whole

    allowed = f"{least} <= {name} <= {most}"
    try:
        value = whole(text)
    except NotNumber as error:
        raise InputError(f"{name} = {text!r} {error}; the allowed range is {allowed}.") from None
    if not least <= value <= most:
        raise InputError(f"{name} = {text} is outside the allowed range {allowed}.")
    return value


def _pairs(items: list[str] | None) -> dict[str, str]:
    """Split KEY=VALUE items; the values stay text, which the models read and check."""
    pairs = {}
    for item in items or []:
        key, equals, value = item.partition("=")
        if not equals or not key or not value:
            raise InputError(f"{item!r} is not of the form KEY=VALUE.")
        if key in pairs:
            raise InputError(f"{key} is given twice, as {pairs[key]} and as {value}; give it once.")
        pairs[key] = value
    return pairs


def _print_boundary(name: str, entry: Mapping[str, Any]) -> None:
    """Print a boundary of stability, why there is none, and the intervals of the parameter that are stable."""
    print(f"{name:27s} {_value(entry)}")
    for interval in entry["stable_intervals"]:
        high = "on" if interval["high"] is None else f"to {interval['high']:.12g}"
        print(f"  {entry['stability']} stability from {interval['low']:.12g} {high} {entry['unit']}")
    if "reason" in entry:
        print(f"  {entry['reason']}")


def _value(entry: Mapping[str, Any]) -> str:
    return "none" if entry["value"] is None else f"{entry['value']:.12g} {entry['unit']}"


def _print_quantities(quantities: Mapping[str, Any]) -> None:
    for name, entry in quantities.items():
        print(f"  {name}: {_value(entry)}")


def _print_conditions(conditions: Mapping[str, Any]) -> None:
    for name, condition in conditions.items():
        print(f"  {name}: {'holds' if condition['hold'] else 'does not hold'}")


def _print_json(value: Mapping[str, Any]) -> None:
    print(json.dumps(value, indent=2, allow_nan=False))


def main() -> None:
    """Run the command; unacceptable input ends in one sentence on the error stream and exit code 2."""
    warnings.showwarning = _say
    try:
        app(exit_on_error=False, print_error=False)
        if sys.stdout is not None:  # None: the standard output is closed
            sys.stdout.flush()
    except BrokenPipeError:  # the reader of our output, such as head, has seen enough
        _to_nowhere(sys.stdout)
    except KeyboardInterrupt:
        _fail("interrupted.", 130)  # as a shell reports a program that SIGINT ended
    except MemoryError:
        _fail("there is not enough memory; take fewer cells or samples.")
    except (CycloptsError, LsvibError) as error:
        _fail(str(error))
    except OSError as error:
        # What we open ourselves is said in the package's own errors; so this is one of the standard streams.
        _to_nowhere(sys.stdout)
        _fail(f"Cannot write to the standard output: {error.strerror or error}.")


def _say(message: Warning | str, category: type[Warning], *where: Any) -> None:
    """Show a warning as one sentence on the error stream, without the line of code that it comes from."""
    if sys.stderr is not None:
        print(f"lsvib: {' '.join(str(message).split())}", file=sys.stderr)


def _fail(text: str, code: int = 2) -> NoReturn:
    """Say one sentence on the error stream, in one line that can be printed, and end with an exit code."""
    line = "".join(letter if letter.isprintable() else "?" for letter in " ".join(text.split()))
    if sys.stderr is not None:
        with suppress(OSError):  # nobody can be told
            print(f"lsvib: {line}", file=sys.stderr, flush=True)
    sys.exit(code)


def _to_nowhere(stream: Any) -> None:
    """Let the rest of a stream, which cannot be written, vanish, so that Python does not complain at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
