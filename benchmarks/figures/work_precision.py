"""Error against run time: every method on every scene, against 40 digits, and how much faster the engine is."""

import json
import math
from collections.abc import Callable, Mapping
from importlib.metadata import version
from importlib.util import find_spec
from operator import attrgetter
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
import xarray as xr
from pydantic import Field

from benchmarks.record import Verdict
from benchmarks.rivals.methods import MODULES
from lsvib.datasets.attributes import flagged, named_index, variable
from lsvib.datasets.checks import Check
from lsvib.datasets.io import machine
from lsvib.figures import style
from lsvib.figures.common import flag_names, named
from lsvib.figures.settings import FigureSettings, Unique
from lsvib.figures.style import Axes, Figure

if TYPE_CHECKING:
    from benchmarks.rivals.race import Entry

CAPTION = """\
Error of the final state, in sizes of the motion, against run time. Every line is a method at several tolerances, time
steps or widths of the smoothed friction; a cross is a run that shows a wrong motion: another number of events of some
kind, or another attractor. The dotted line is a hundred times the run time of lsvib. The reference has 40 digits.
"""

SCENES = (
    "stick_slip", "graze_above", "graze_below", "sprag_slip", "sprag_graze", "stiff_contact", "near_critical",
    "long_run",
)  # fmt: skip
_NAMES = (
    "exact", "rk45", "dop853", "dop853_capped", "radau", "bdf", "lsoda", "lsoda_capped", "cvode_adams", "cvode_bdf",
    "cvode_bdf_capped", "diffrax_tsit5", "diffrax_dopri8", "diffrax_dopri8_capped", "diffrax_kvaerno5", "heyoka",
    "smoothed", "rk4", "rk4_refined",
)  # fmt: skip
Controls = Annotated[list[Annotated[float, Field(ge=0, le=10)]], *Unique, Field(max_length=20)]
_CONTROLS = {
    "relative_tolerance": ("1", "relative tolerance of the method"),
    "time_step": ("s", "time step of the method"),
    "smoothing_width": ("rad s-1", "width of the smoothed jump of friction"),
}
_NUMBERS = {  # variable: where an entry has it, unit, words
    "state_error": ("errors.state", "1", "error of the final state, relative to the size of the motion"),
    "event_time_error": ("errors.times", "s", "largest error of an event's time"),
    "amplitude_error": ("errors.amplitude", "1", "error of the steady amplitude in sizes of the motion"),
    "run_time": ("fastest", "s", "run time, shortest of the runs"),
    "run_time_median": ("median", "s", "run time, median of the runs"),
}
_FIRST_RUN = "discarded run of a hundredth of the scene, with what is loaded and compiled for it"
_RATIO = "run time of the best rival of a family over that of the engine, at an equal error"
_GENERAL = ("GENERAL", "COMPILED", "TAYLOR")
_RIVALS = (*_GENERAL, "FIXED_STEP", "SMOOTHED")  # of the families of methods
_SOURCE = "docs/validation.md"
_VERDICTS = (Verdict.NOT_RUN, Verdict.RIGHT, Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION, Verdict.GAVE_UP)
_Row = dict[str, "list[Entry]"]  # of a scene, by method
_PACKAGES = [("scikit-sundae", "sksundae"), *((name, name) for name in ("scipy", "diffrax", "jax", "heyoka", "mpmath"))]
_STYLES = {  # colour, marker, dashes of the methods that are drawn; the dataset has more
    "exact": (style.BLACK, "*", "-"),
    "dop853": (style.BLUE, "o", "-"),
    "dop853_capped": (style.BLUE, "o", ":"),
    "radau": (style.PURPLE, "v", "-"),
    "lsoda": (style.GREEN, "s", "-"),
    "cvode_adams": (style.SKY, "D", "-"),
    "cvode_bdf": (style.VERMILION, "D", "-"),
    "diffrax_tsit5": (style.WINE, "^", "-"),
    "diffrax_dopri8_capped": (style.WINE, "^", ":"),
    "diffrax_kvaerno5": (style.WINE, "<", "--"),
    "heyoka": (style.OLIVE, "h", "-"),
    "smoothed": (style.GREY, "p", "-"),
    "rk4": (style.ORANGE, ">", ":"),
    "rk4_refined": (style.ORANGE, ">", "-"),
}
_LEAST = 1e-16  # errors below are drawn there
_COLUMNS = 4  # of panels, as many as can be read on a page


class Settings(FigureSettings):
    """Error against run time of the engine and of other methods."""

    timed: ClassVar = True
    needs: ClassVar = MODULES

    scenes: Annotated[list[Literal[*SCENES]], *Unique] = Field(min_length=1, description="Scenes to run.")
    shorten: float = Field(gt=0, le=1, description="Part of each scene's duration that is run [1].")
    methods: dict[Literal[*_NAMES], Controls] = Field(
        description="Settings of each method, coarse to fine: relative tolerances [1], time steps [s] of rk4 and "
        "rk4_refined, widths [rad/s] of smoothed; [0] where there is nothing to set, [] to leave a method out."
    )
    repeats: int = Field(ge=1, le=1000, description="Rounds in which every method runs.")
    seconds: float = Field(ge=0, description="Run time after which a method is left out of further rounds [s].")
    limit: float = Field(gt=0, description="Run time after which a run is given up [s].")
    error_levels: Annotated[list[Annotated[float, Field(gt=0, le=1)]], *Unique] = Field(
        min_length=1, description="Errors of the final state at which run times are compared, coarse to fine [1]."
    )
    ratio_floor: float = Field(
        gt=0, description="Least ratio of run times, of general solvers that call a field in Python [1]."
    )
    compiled_floor: float = Field(gt=0, description="The same, of general solvers that compile the field [1].")


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the methods of :data:`benchmarks.rivals.method_list.METHODS` on scenes; ``InputError`` without a package."""
    from benchmarks.rivals.method_list import METHODS, MethodFamily
    from benchmarks.rivals.race import RaceBudget, contest

    scenes, methods = settings["scenes"], settings["methods"]
    names = [name for name, values in methods.items() if values]
    budget = RaceBudget(settings["repeats"], settings["seconds"], settings["limit"])
    races = [contest(name, methods, budget, settings["shorten"]) for name in scenes]
    rows = [{name: [e for e in entries if e.method == name] for name in names} for _, _, entries in races]
    levels = np.array(settings["error_levels"], dtype=float)
    families, titles = [METHODS[name].family for name in names], [this.title for this, _, _ in races]
    labels, asked = [METHODS[name].label for name in names], "ratio that the checks ask for, of"
    lengths = np.array([this.duration for this, _, _ in races])
    true = np.array([len(truth.kinds) for _, truth, _ in races], dtype=np.int32)
    return xr.Dataset(
        {
            **_measured(rows, max(len(methods[name]) for name in names)),
            "reference_events": variable("scene", true, "1", "number of events of the reference"),
            "duration": variable("scene", lengths, "s", "duration of the motion"),
            "method_family": flagged("method", families, "family of the method", MethodFamily),
            "ratio": variable(("scene", "rival", "error_level"), [_ratios(row, levels) for row in rows], "1", _RATIO),
            **_settings(methods, names),
        },
        coords={
            "scene": named_index("scene", "scene", scenes, labels="; ".join(titles)),
            "method": named_index("method", "method", names, labels="; ".join(labels)),
            "rival": flagged("rival", [MethodFamily[name] for name in _RIVALS], "family of the rival", MethodFamily),
            "error_level": variable("error_level", levels, "1", "error of the final state that is asked for"),
            "ratio_floor": variable((), float(settings["ratio_floor"]), "1", f"{asked} scipy and CVODE"),
            "compiled_floor": variable((), float(settings["compiled_floor"]), "1", f"{asked} diffrax and heyoka"),
        },
        attrs={
            "title": "Error against run time of the engine and of other methods",
            "source": "lsvib; references with mpmath at 40 digits",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sects. 8.5 to 8.7",
            "timing": "processor time of one process, methods interleaved, after a discarded run; "
            "the preparation of a method (tables, compilation) is not in it",
            **machine(),
            "rival_versions": json.dumps({name: version(name) for name, module in _PACKAGES if find_spec(module)}),
        },
    )


def _measured(rows: list[_Row], longest: int) -> dict[str, tuple]:
    """What was measured, over (scene, method, setting)."""
    from benchmarks.rivals.race import Entry

    def cube(value: Callable[[Entry], float], missing: float = np.nan, dtype: type = float) -> np.ndarray:
        padded = [[[*map(value, found), *[missing] * (longest - len(found))] for found in row.values()] for row in rows]
        return np.array(padded, dtype=dtype)

    dims, events = ("scene", "method", "setting"), cube(lambda e: e.events, -1, np.int32)
    first = np.array([[found[0].first if found else np.nan for found in row.values()] for row in rows])
    verdict = cube(lambda e: e.errors.verdict, Verdict.NOT_RUN, np.int8)
    return {
        **{name: variable(dims, cube(attrgetter(where)), *about) for name, (where, *about) in _NUMBERS.items()},
        "runs": variable(dims, cube(lambda e: len(e.seconds), 0, np.int32), "1", "number of runs"),
        "first_run_time": variable(dims[:2], first, "s", _FIRST_RUN),
        "motion_verdict": flagged(dims, verdict, "whether the motion is the true one", _VERDICTS),
        "events": variable(dims, events, "1", "number of events", comment="-1 for a method without"),
        "setting": variable("setting", np.arange(longest), "1", "index of the method's setting, coarse to fine"),
    }


def _ratios(row: _Row, levels: np.ndarray) -> list[list[float]]:
    """Run time of the best of each rival family on a scene at an error, over the engine's; (family, level)."""
    from benchmarks.rivals.method_list import METHODS
    from benchmarks.rivals.race import fastest

    points = {
        name: [(e.errors.state, e.fastest) for e in found if e.errors.verdict == Verdict.RIGHT]
        for name, found in row.items()
    }
    of_family = [[points[name] for name in row if METHODS[name].family.name == family] for family in _RIVALS]
    return [[fastest(rivals, x) / fastest([points["exact"]], x) for x in levels] for rivals in of_family]


def _settings(methods: Mapping[str, list[float]], names: list[str]) -> dict[str, tuple]:
    """The settings of the methods by what they are, over (method, setting)."""
    from benchmarks.rivals.method_list import METHODS

    found = {key: np.full((len(names), max(len(methods[name]) for name in names)), np.nan) for key in _CONTROLS}
    for k, name in enumerate(names):
        if METHODS[name].control in _CONTROLS:
            found[METHODS[name].control][k, : len(methods[name])] = methods[name]
    return {key: variable(("method", "setting"), values, *_CONTROLS[key]) for key, values in found.items()}


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the engine's verdicts and errors, and its ratios to the best general solvers, scene by scene."""
    return [
        *_engine_checks(dataset),
        *_ratio_checks(dataset, "GENERAL", "scipy or CVODE", float(dataset.ratio_floor)),
        *_ratio_checks(dataset, "COMPILED", "diffrax", float(dataset.compiled_floor)),
        *_ratio_checks(dataset, "TAYLOR", "heyoka", float(dataset.compiled_floor)),
    ]


def _engine_checks(dataset: xr.Dataset) -> list[Check]:
    names = dataset.method.attrs["flag_meanings"].split()
    engine = dataset.isel(method=names.index("exact"), setting=0)
    worst = int(np.argmax(engine.state_error.values))
    scene = dataset.scene.attrs["flag_meanings"].split()[worst]
    largest = float(engine.state_error[worst])
    wrong = int(np.count_nonzero(engine.motion_verdict.values != int(Verdict.RIGHT)))
    others = dataset.isel(method=named(dataset.method_family, *map(str.lower, _GENERAL)))
    ran = others.motion_verdict.values != int(Verdict.NOT_RUN)
    missed = int(np.count_nonzero(others.motion_verdict.values[ran] != int(Verdict.RIGHT)))
    return [
        Check.holds(
            "The engine shows the true motion on every scene",
            _SOURCE,
            f"{wrong} wrong of {engine.scene.size}",
            not wrong,
        ),
        Check.holds(
            "The engine's error is below 1e-11 on every scene",
            _SOURCE,
            f"largest {largest:.1e}, {scene}",
            largest < 1e-11,
        ),
        Check.holds(
            "General solvers show a wrong motion, or none, in some runs",
            _SOURCE,
            f"{missed} of {int(ran.sum())} runs",
            missed > 0,
        ),
    ]


def _ratio_checks(dataset: xr.Dataset, family: str, solver: str, floor: float) -> list[Check]:
    """One for each scene in which a solver of the family was run, over all error levels that one reaches."""

    result = []
    levels = dataset.error_level.values
    for k, name in enumerate(dataset.scene.attrs["flag_meanings"].split()):
        scene = dataset.isel(scene=k)
        rivals, engine = (scene.isel(method=named(dataset.method_family, kind)) for kind in (family.lower(), "exact"))
        runs = int((rivals.motion_verdict != Verdict.NOT_RUN).sum())
        if not runs:
            continue
        reached, ours = levels >= _least_error(rivals), bool((levels >= _least_error(engine)).all())
        ratios = dataset.ratio.isel(rival=_RIVALS.index(family)).values[k]
        if reached.any():
            claim = f"{name}: at every error that {solver} reaches, the engine is {floor:g} times faster"
            words = ", ".join(f"{ratios[i]:.0f} at {levels[i]:.0e}" for i in np.flatnonzero(reached))
        else:
            claim = (
                f"{name}: to none of the errors asked for does {solver} show the true motion, to all the engine does"
            )
            words = f"{runs} runs of others"
        passed = ours and bool((ratios[reached] >= floor).all())
        result.append(Check.holds(claim, _SOURCE, words if ours else f"{words}; the engine misses a level", passed))
    return result


def _least_error(methods: xr.Dataset) -> float:
    """Smallest error of the final state of all runs of some methods that show the true motion; inf without one."""
    right = methods.motion_verdict.values == Verdict.RIGHT
    return float(methods.state_error.values[right].min(initial=np.inf))


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the error of the final state against run time, scene by scene; the legend is shared."""
    count = dataset.sizes["scene"]
    rows = math.ceil(count / _COLUMNS)
    figure = style.new_figure(style.DOUBLE, 2.35 * rows + 1.0)
    panels = np.ravel(figure.subplots(rows, min(count, _COLUMNS), sharey=True, squeeze=False))
    names = dataset.method.attrs["flag_meanings"].split()
    titles = dataset.scene.attrs["labels"].split("; ")
    right = {word: value for value, word in flag_names(dataset.motion_verdict).items()}["right"]
    for k, axes in enumerate(panels):
        if k >= count:
            axes.set_visible(False)
            continue
        _panel(axes, dataset.isel(scene=k), names, right)
        axes.set_title(f"({chr(97 + k)}) {titles[k]}", fontsize=7)
        if k >= count - _COLUMNS:
            axes.set_xlabel("Run time [s]")
        if k % _COLUMNS == 0:
            axes.set_ylabel("Error of the final state")
    figure.legend(handles=_handles(dataset, names), loc="outside lower center", ncols=5, fontsize=6.5)
    return figure


def _panel(axes: Axes, scene: xr.Dataset, names: list[str], right: int) -> None:
    axes.margins(x=0.1)
    axes.set(xscale="log", yscale="log", ylim=(_LEAST / 3, 30))
    axes.set_yticks([1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0])
    for k, name in enumerate(names):
        if name not in _STYLES:
            continue
        method = scene.isel(method=k)
        seconds, error = method.run_time.values, np.maximum(method.state_error.values, _LEAST)
        ran = np.isfinite(error) & np.isfinite(seconds)
        good = ran & (method.motion_verdict.values == right)
        colour, marker, dashes = _STYLES[name]
        size = 9 if name == "exact" else 3.5
        axes.plot(seconds[ran], error[ran], color=colour, linestyle=dashes, linewidth=0.7, alpha=0.8)
        face = "white" if dashes == ":" else colour
        axes.plot(seconds[good], error[good], color=colour, marker=marker, markersize=size, linestyle="", mfc=face)
        axes.plot(seconds[ran & ~good], error[ran & ~good], color=colour, marker="x", markersize=4, linestyle="")
    engine = float(scene.run_time.isel(method=names.index("exact"), setting=0))
    floor = float(scene.ratio_floor)
    axes.axvline(floor * engine, color=style.GREY, linestyle=":", linewidth=0.8, zorder=0)
    axes.text(floor * engine, 2.0, f" {floor:g}×", fontsize=6, color=style.GREY, va="bottom")
    _gave_up(axes, scene)


def _gave_up(axes: Axes, scene: xr.Dataset) -> None:
    """Say how many runs of the methods that are drawn ended without a result."""
    codes = {word: value for value, word in flag_names(scene.motion_verdict).items()}
    drawn = [name in _STYLES for name in scene.method.attrs["flag_meanings"].split()]
    lost = int((scene.motion_verdict.values[drawn] == codes["gave up"]).sum())
    if lost:
        axes.text(0.97, 0.03, f"{lost} gave up", transform=axes.transAxes, fontsize=6, ha="right")


def _handles(dataset: xr.Dataset, names: list[str]) -> list:
    from matplotlib.lines import Line2D

    handles = []
    for name, label in zip(names, dataset.method.attrs["labels"].split("; "), strict=True):
        if name not in _STYLES:
            continue
        colour, marker, dashes = _STYLES[name]
        size = 8 if name == "exact" else 4
        face = "white" if dashes == ":" else colour
        line = {"color": colour, "marker": marker, "linestyle": dashes, "mfc": face}
        handles.append(Line2D([], [], linewidth=0.8, markersize=size, label=label, **line))
    handles.append(Line2D([], [], color=style.BLACK, marker="x", linestyle="", markersize=4, label="wrong motion"))
    return handles
