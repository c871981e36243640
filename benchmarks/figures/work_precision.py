"""Error against run time: methods on scenes, against 22 digits and more, with ratios at equal error."""

import json
import math
import os
import platform
from collections.abc import Callable, Mapping
from importlib.metadata import version
from importlib.util import find_spec
from operator import attrgetter
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

import numpy as np
import xarray as xr
from pydantic import Field

from benchmarks.judge import QUARTILES, Verdict, quartiles
from lsvib.answers.attributes import flag_names, flagged, named, named_index, variable
from lsvib.chapter.checks import Check
from lsvib.chapter.settings import FigureSettings, Unique
from lsvib.pictures import style
from lsvib.pictures.style import Axes, Figure

if TYPE_CHECKING:
    from benchmarks.rivals.race import Entry

CAPTION = """\
Error of the final state, relative to the size of the motion, against run time. Each line is a method at several
tolerances, time steps or widths of the smoothed friction, with larger markers for finer ones; a cross marks a wrong
motion: a different number of events of some kind, or a different attractor. The reference has 40 digits, 22 under a
friction law. Last row: run time of the best method of each family over that of lsvib, at errors of 1e-3 and 1e-7 where
it reaches them. Bars span the quartiles of repeats.
"""

SCENES = (
    "stick_slip", "graze_above", "graze_below", "sprag_slip", "sprag_graze", "stiff_contact", "near_critical",
    "long_run", "friction_law", "steep_law", "law_graze", "law_motor",
)  # fmt: skip
_NAMES = (
    "exact", "rk45", "dop853", "dop853_capped", "radau", "bdf", "lsoda", "cvode_adams", "cvode_bdf", "heyoka",
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
    "amplitude_error": ("errors.amplitude", "1", "error of the steady amplitude, relative to the size of the motion"),
    "run_time": ("fastest", "s", "run time, shortest of the runs"),
}
_TIMES = "run time, quartiles of the shortest of each round"
_FIRST_RUN = "discarded run of a hundredth of the scene, loading and compilation included"
_RATIO = "run time of the best rival of a family over that of the engine, at an equal error, quartiles of the rounds"
_GENERAL = ("GENERAL", "TAYLOR")
RIVALS = {  # family of methods: marker, words by the methods that it may have
    "GENERAL": ("s", {"dop853": "scipy", "cvode_bdf": "CVODE"}),
    "TAYLOR": ("h", {"heyoka": "heyoka"}),
    "FIXED_STEP": (">", {"rk4_refined": "RK4"}),
    "SMOOTHED": ("p", {"smoothed": "smoothed friction"}),
}
_LEVELS = (1e-3, 1e-7)  # errors at which ratios are drawn
_SOURCE = "docs/validation.md"
_VERDICTS = (Verdict.NOT_RUN, Verdict.RIGHT, Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION, Verdict.GAVE_UP)
_Row = dict[str, "list[Entry]"]  # of a scene, by method
_PACKAGES = [("scikit-sundae", "sksundae"), *((name, name) for name in ("scipy", "heyoka", "mpmath"))]
_STYLES = {  # colour, marker, dashes of the methods that are drawn; the dataset has more
    "exact": (style.BLACK, "*", "-"),
    "dop853": (style.BLUE, "o", "-"),
    "dop853_capped": (style.BLUE, "o", ":"),
    "radau": (style.PURPLE, "v", "-"),
    "lsoda": (style.GREEN, "s", "-"),
    "cvode_adams": (style.SKY, "D", "-"),
    "cvode_bdf": (style.VERMILION, "D", "-"),
    "heyoka": (style.OLIVE, "h", "-"),
    "smoothed": (style.GREY, "p", "-"),
    "rk4": (style.ORANGE, ">", ":"),
    "rk4_refined": (style.ORANGE, ">", "-"),
}
_LEAST = 1e-16  # errors below are drawn there


class Settings(FigureSettings):
    """Error against run time of the engine and of other methods."""

    engine: ClassVar = ("planar", "modal", "taylor")

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


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the methods of :data:`benchmarks.rivals.method_list.METHODS` on scenes; ``InputError`` without a package."""
    from benchmarks.rivals.method_list import METHODS, MethodFamily
    from benchmarks.rivals.race import contest

    scenes, methods = settings["scenes"], settings["methods"]
    names = [name for name, values in methods.items() if values]
    limits = {name: settings[name] for name in ("repeats", "seconds", "limit", "shorten")}
    races = [contest(name, methods, **limits) for name in scenes]
    rows = [{name: [e for e in entries if e.method == name] for name in names} for _, _, entries in races]
    levels = np.array(settings["error_levels"], dtype=float)
    families, titles = [METHODS[name].family for name in names], [this.title for this, _, _ in races]
    labels = [METHODS[name].label for name in names]
    lengths = np.array([this.duration for this, _, _ in races])
    true = np.array([len(truth.kinds) for _, truth, _ in races], dtype=np.int32)
    return xr.Dataset(
        {
            **_measured(rows, max(len(methods[name]) for name in names)),
            "reference_events": variable("scene", true, "1", "number of events of the reference"),
            "duration": variable("scene", lengths, "s", "duration of the motion"),
            "method_family": flagged("method", families, "family of the method", MethodFamily),
            "ratio": variable(
                ("scene", "rival", "error_level", "quartile"),
                [_ratios(row, levels, settings["repeats"]) for row in rows],
                "1",
                _RATIO,
            ),
            **_settings(methods, names),
        },
        coords={
            "scene": named_index("scene", "scene", scenes, labels="; ".join(titles)),
            "method": named_index("method", "method", names, labels="; ".join(labels)),
            "rival": named_index("rival", "family of the rival", [name.lower() for name in RIVALS]),
            "error_level": variable("error_level", levels, "1", "required error of the final state"),
            "quartile": variable("quartile", list(QUARTILES), "1", "share of the repeats below"),
        },
        attrs={
            "title": "Error against run time of the engine and of other methods",
            "source": "lsvib; references with 40 digits, 22 where friction depends on speed",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sects. 8.5 to 8.7",
            "timing": "processor time of one process, methods interleaved, after a discarded run; "
            "without the preparation of a method (tables, compilation)",
            "hardware": f"{platform.machine()}, {os.cpu_count()} CPUs",
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
        "run_time_quartiles": variable(
            (*dims, "quartile"),
            np.stack([cube(lambda e, k=k: float(quartiles(e.rounds or [np.nan])[k])) for k in range(3)], axis=-1),
            "s",
            _TIMES,
        ),
        "runs": variable(dims, cube(lambda e: len(e.seconds), 0, np.int32), "1", "number of runs"),
        "first_run_time": variable(dims[:2], first, "s", _FIRST_RUN),
        "motion_verdict": flagged(dims, verdict, "whether the motion is correct", _VERDICTS),
        "events": variable(dims, events, "1", "number of events", comment="-1 for a method without events"),
        "setting": variable("setting", np.arange(longest), "1", "index of the method's setting, coarse to fine"),
    }


def _ratios(row: _Row, levels: np.ndarray, rounds: int) -> np.ndarray:
    """Run times of the best of each rival family on a scene over the engine's, (family, error level, quartile)."""
    from benchmarks.rivals.method_list import METHODS
    from benchmarks.rivals.race import fastest

    def of_round(k: int) -> list[list[float]]:
        """Return the ratios of one round, (family, level)."""
        points = {
            name: [(e.errors.state, e.of_round(k)) for e in found if e.errors.verdict == Verdict.RIGHT]
            for name, found in row.items()
        }
        of_family = [[points[name] for name in row if METHODS[name].family.name == family] for family in RIVALS]
        return [[fastest(rivals, x) / fastest([points["exact"]], x) for x in levels] for rivals in of_family]

    return quartiles(np.stack([of_round(k) for k in range(rounds)], axis=-1))


def _settings(methods: Mapping[str, list[float]], names: list[str]) -> dict[str, tuple]:
    """The settings of the methods by what they are, if any has such, over (method, setting)."""
    from benchmarks.rivals.method_list import METHODS

    found = {key: np.full((len(names), max(len(methods[name]) for name in names)), np.nan) for key in _CONTROLS}
    for k, name in enumerate(names):
        if METHODS[name].control in _CONTROLS:
            found[METHODS[name].control][k, : len(methods[name])] = methods[name]
    given = {key: values for key, values in found.items() if not np.isnan(values).all()}
    return {key: variable(("method", "setting"), values, *_CONTROLS[key]) for key, values in given.items()}


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the engine's verdicts and errors; no run time decides."""
    names = dataset.method.attrs["flag_meanings"].split()
    engine = dataset.isel(method=names.index("exact"), setting=0)
    worst = int(np.argmax(engine.state_error.values))
    scene = np.atleast_1d(dataset.scene.attrs["flag_meanings"].split())[worst]
    largest = float(engine.state_error[worst])
    wrong = int(np.count_nonzero(engine.motion_verdict.values != int(Verdict.RIGHT)))
    others = dataset.isel(method=named(dataset.method_family, *map(str.lower, _GENERAL))).motion_verdict.values
    missed = int(np.isin(others, (Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION)).sum())
    return [
        Check.holds(
            "The engine gives the true motion in every scene",
            _SOURCE,
            f"{wrong} wrong of {engine.scene.size}",
            not wrong,
        ),
        Check.holds(
            "The engine's error is below 1e-11 in every scene",
            _SOURCE,
            f"largest {largest:.1e}, {scene}",
            largest < 1e-11,
        ),
        Check.holds(
            "General solvers give a wrong motion in some runs",
            _SOURCE,
            f"{missed} of {int((others != Verdict.NOT_RUN).sum())} runs",
            missed > 0,
        ),
    ]


def draw(dataset: xr.Dataset) -> Figure:
    """Draw the error of the final state against run time, scene by scene, then ratios."""
    count = dataset.sizes["scene"]
    columns = math.ceil(math.sqrt(count))  # of three or four scenes two, of ten to sixteen four
    rows = math.ceil(count / columns)
    high = 2.2 if columns < 4 else 1.9
    figure = style.new_figure(style.DOUBLE, high * rows + 2.9)
    upper, lower = figure.subfigures(2, 1, height_ratios=[high * rows + 0.8, 2.1])
    panels = upper.subplots(rows, columns, sharey=True, squeeze=False)
    names = dataset.method.attrs["flag_meanings"].split()
    titles = dataset.scene.attrs["labels"].split("; ")
    right = {word: value for value, word in flag_names(dataset.motion_verdict).items()}["right"]
    for k, axes in enumerate(panels.ravel()):
        if k >= count:
            axes.set_visible(False)
            continue
        _panel(axes, dataset.isel(scene=k), names, right)
        axes.set_title(f"({chr(97 + k)}) {titles[k]}", fontsize=7)
        axes.set_xlabel("Run time [s]")
    for axes in panels[:, 0]:
        axes.set_ylabel("Error of the final state")
    _ratio_panel(lower.subplots(), dataset, names)
    upper.legend(handles=_handles(dataset, names), loc="outside lower center", ncols=5, fontsize=6.5)
    return figure


def _bars(times: np.ndarray) -> np.ndarray:
    """Lengths (2, k) of the bars from the median to both quartiles, of quartiles (k, 3)."""
    return np.abs(times[:, [0, 2]] - times[:, [1]]).T


def _ratio_panel(axes: Axes, dataset: xr.Dataset, names: list[str]) -> None:
    """Draw run times over the engine's, at two errors."""
    levels, width = dataset.error_level.values, 0.12
    reached = np.zeros(dataset.sizes["scene"], dtype=bool)
    for k, (marker, methods) in enumerate(RIVALS.values()):
        words = ", ".join(word for name, word in methods.items() if name in names)
        for level, face in zip(_LEVELS, (style.BLACK, "white"), strict=True):
            near, power = np.isclose(levels, level), str(round(math.log10(level))).translate(style.SUPERSCRIPTS)
            ratios = dataset.ratio.values[:, k, near].reshape(-1, 3)
            seen = np.flatnonzero(np.isfinite(ratios[:, 0])) if near.any() else np.empty(0, dtype=int)
            reached[seen] = True
            place = seen + width * (k - 1.5) + (0.04 if face == "white" else 0)
            axes.errorbar(place, ratios[seen, 1], _bars(ratios[seen]), fmt=marker, markersize=3.5, mfc=face,
                          color=style.BLACK, elinewidth=0.7,
                          label=f"{words}, error 10{power}" if seen.size else None)  # fmt: skip
    axes.axhline(1.0, color=style.GREY, linestyle=":", linewidth=0.8)
    letters = [f"({chr(97 + k)})" for k in range(reached.size)]
    axes.set_xticks(range(len(letters)), letters)
    axes.set_xlim(-0.6, len(letters) - 0.4)
    axes.set(yscale="log", xlabel="Scene", ylabel="Run time over that of lsvib")
    axes.margins(y=0.25)
    for k in np.flatnonzero(~reached):
        axes.text(k, 0.5, "not\nreached", transform=axes.get_xaxis_transform(), fontsize=6, ha="center", va="center")
    axes.set_title(f"({chr(97 + len(letters))}) ratios at equal error", fontsize=7)
    axes.figure.legend(loc="outside lower center", fontsize=6, ncols=4)


def _panel(axes: Axes, scene: xr.Dataset, names: list[str], right: int) -> None:
    """Draw the methods of a scene: a line joins runs with the true motion, from one setting to the next."""
    seconds = scene.run_time_quartiles.values[[name in _STYLES for name in names]]
    limits = np.nanmin(seconds) / 2, np.nanmax(seconds) * 2
    axes.set(xscale="log", yscale="log", xlim=limits, ylim=(_LEAST / 3, 30))
    axes.set_yticks([1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 1.0])
    for k, name in enumerate(names):
        if name not in _STYLES:
            continue
        method = scene.isel(method=k)
        quarters, error = method.run_time_quartiles.values, np.maximum(method.state_error.values, _LEAST)
        seconds = quarters[:, 1]
        ran = np.isfinite(error) & np.isfinite(seconds)
        good = ran & (method.motion_verdict.values == right)
        colour, marker, dashes = _STYLES[name]
        sizes = np.full(good.size, 60.0) if name == "exact" else 4.0 + 3.0 * np.arange(good.size)
        axes.plot(np.where(good, seconds, np.nan), np.where(good, error, np.nan), color=colour, linestyle=dashes,
                  linewidth=0.7, alpha=0.8)  # fmt: skip
        face = "white" if dashes == ":" else colour
        axes.scatter(
            seconds[good], error[good], sizes[good], face, marker=marker, edgecolors=colour, linewidths=0.7, zorder=3
        )
        axes.errorbar(
            seconds[good], error[good], xerr=_bars(quarters[good]), color=colour, linestyle="", elinewidth=0.7
        )
        axes.scatter(seconds[ran & ~good], error[ran & ~good], sizes[ran & ~good], colour, marker="x", linewidths=0.8)
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
