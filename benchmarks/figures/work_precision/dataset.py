"""Error against run time: every method on every scene, against 40 digits, and how much faster the engine is."""

import json
from collections.abc import Callable, Mapping
from importlib.metadata import version
from importlib.util import find_spec
from operator import attrgetter
from typing import Any

import numpy as np
import xarray as xr

from benchmarks.record import Verdict
from benchmarks.rivals.method_list import METHODS, MethodFamily
from benchmarks.rivals.race import Entry, RaceBudget, contest, fastest
from lsvib.datasets.attributes import flagged, named_index, variable
from lsvib.datasets.checks import Check
from lsvib.datasets.io import machine

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
_GENERAL = (MethodFamily.GENERAL, MethodFamily.COMPILED, MethodFamily.TAYLOR)
_RIVALS = (*_GENERAL, MethodFamily.FIXED_STEP, MethodFamily.SMOOTHED)
_SOURCE = "docs/validation.md"
_VERDICTS = (Verdict.NOT_RUN, Verdict.RIGHT, Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION, Verdict.GAVE_UP)
_Row = dict[str, list[Entry]]  # of a scene, by method
_PACKAGES = [("scikit-sundae", "sksundae"), *((name, name) for name in ("scipy", "diffrax", "jax", "heyoka", "mpmath"))]


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the methods of :data:`benchmarks.rivals.method_list.METHODS` on scenes; ``InputError`` without a package."""
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
            "rival": flagged("rival", _RIVALS, "family of the rival", MethodFamily),
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
    points = {
        name: [(e.errors.state, e.fastest) for e in found if e.errors.verdict == Verdict.RIGHT]
        for name, found in row.items()
    }
    of_family = [[points[name] for name in row if METHODS[name].family == family] for family in _RIVALS]
    return [[fastest(rivals, x) / fastest([points["exact"]], x) for x in levels] for rivals in of_family]


def _settings(methods: Mapping[str, list[float]], names: list[str]) -> dict[str, tuple]:
    """The settings of the methods by what they are, over (method, setting)."""
    found = {key: np.full((len(names), max(len(methods[name]) for name in names)), np.nan) for key in _CONTROLS}
    for k, name in enumerate(names):
        if METHODS[name].control in _CONTROLS:
            found[METHODS[name].control][k, : len(methods[name])] = methods[name]
    return {key: variable(("method", "setting"), values, *_CONTROLS[key]) for key, values in found.items()}


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the engine's verdicts and errors, and its ratios to the best general solvers, scene by scene."""
    return [
        *_engine_checks(dataset),
        *_ratio_checks(dataset, MethodFamily.GENERAL, "scipy or CVODE", float(dataset.ratio_floor)),
        *_ratio_checks(dataset, MethodFamily.COMPILED, "diffrax", float(dataset.compiled_floor)),
        *_ratio_checks(dataset, MethodFamily.TAYLOR, "heyoka", float(dataset.compiled_floor)),
    ]


def _engine_checks(dataset: xr.Dataset) -> list[Check]:
    names = dataset.method.attrs["flag_meanings"].split()
    engine = dataset.isel(method=names.index("exact"), setting=0)
    worst = int(np.argmax(engine.state_error.values))
    scene = dataset.scene.attrs["flag_meanings"].split()[worst]
    largest = float(engine.state_error[worst])
    wrong = int(np.count_nonzero(engine.motion_verdict.values != int(Verdict.RIGHT)))
    others = dataset.isel(method=np.isin(dataset.method_family.values, _GENERAL))
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


def _ratio_checks(dataset: xr.Dataset, family: MethodFamily, solver: str, floor: float) -> list[Check]:
    """One for each scene in which a solver of the family was run, over all error levels that one reaches."""
    result = []
    levels = dataset.error_level.values
    for k, name in enumerate(dataset.scene.attrs["flag_meanings"].split()):
        scene = dataset.isel(scene=k)
        rivals, engine = (
            scene.isel(method=dataset.method_family.values == kind) for kind in (family, MethodFamily.EXACT)
        )
        runs = int((rivals.motion_verdict != Verdict.NOT_RUN).sum())
        if not runs:
            continue
        reached, ours = levels >= _least_error(rivals), bool((levels >= _least_error(engine)).all())
        ratios = dataset.ratio.sel(rival=int(family)).values[k]
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
