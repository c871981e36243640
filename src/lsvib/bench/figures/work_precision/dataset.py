"""Error against run time: every method on every scene, against 40 digits, and how much faster the engine is."""

import json
import os
import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any

import numpy as np
import xarray as xr

from lsvib.bench.record import Verdict
from lsvib.bench.rivals import race_scenes
from lsvib.bench.rivals.catalogue import METHODS, MethodFamily, find_method
from lsvib.bench.rivals.race import Budget, Entry, contest
from lsvib.bench.rivals.time_at_equal_error import fastest
from lsvib.data.attributes import flagged, named_index, variable
from lsvib.data.checks import Check
from lsvib.data.provenance import processor

_CONTROLS = {
    "relative_tolerance": ("1", "relative tolerance of the method"),
    "time_step": ("s", "time step of the method"),
    "smoothing_width": ("rad s-1", "width of the smoothed jump of friction"),
}
_NUMBERS = {  # variable: its name here, unit, words
    "state_error": ("state", "1", "error of the final state, relative to the size of the motion"),
    "event_time_error": ("times", "s", "largest error of an event's time"),
    "amplitude_error": ("amplitude", "1", "error of the steady amplitude in sizes of the motion"),
    "run_time": ("fastest", "s", "run time, shortest of the runs"),
    "run_time_median": ("median", "s", "run time, median of the runs"),
}
_FIRST_RUN = "discarded run of a hundredth of the scene, with what is loaded and compiled for it"
_RATIO = "run time of the best rival of a family over that of the engine, at an equal error"
_GENERAL = (MethodFamily.GENERAL, MethodFamily.COMPILED, MethodFamily.TAYLOR)
_RIVALS = (*_GENERAL, MethodFamily.FIXED_STEP, MethodFamily.SMOOTHED)
_SOURCE = "docs/accuracy.md"
_VERDICTS = (Verdict.NOT_RUN, Verdict.RIGHT, Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION, Verdict.GAVE_UP)
_PACKAGES = ("scipy", "scikit-sundae", "diffrax", "jax", "heyoka", "mpmath")


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the methods of :data:`lsvib.bench.rivals.catalogue.METHODS` on the scenes.

    ``settings``: see ``Settings``. Raises ``InputError`` if a name is wrong or a package is missing.
    """
    names = [name for name, values in settings["methods"].items() if values]
    longest = max(len(settings["methods"][name]) for name in names)
    budget = Budget(settings["repeats"], settings["seconds"], settings["limit"])
    table = _Table(settings["scenes"], names, longest)
    for row, name in enumerate(settings["scenes"]):
        this, truth, entries = contest(name, settings["methods"], budget, settings["shorten"])
        table.fill(row, entries)
        table.reference_events[row], table.durations[row] = len(truth.kinds), this.duration
    levels = np.array(settings["error_levels"], dtype=float)
    return table.dataset(
        settings["methods"], levels, {key: float(settings[key]) for key in ("ratio_floor", "compiled_floor")}
    )


class _Table:
    """Arrays over (scene, method, setting)."""

    def __init__(self, scene_names: list[str], names: list[str], longest: int) -> None:
        self.scenes, self.names = scene_names, names
        shape = (len(scene_names), len(names), longest)
        self.numbers = {key: np.full(shape, np.nan) for key, _, _ in _NUMBERS.values()}
        self.verdict = np.full(shape, int(Verdict.NOT_RUN), dtype=np.int8)
        self.events, self.runs = np.full(shape, -1, dtype=np.int32), np.zeros(shape, dtype=np.int32)
        self.reference_events = np.zeros(len(scene_names), dtype=np.int32)
        self.durations, self.first = np.zeros(len(scene_names)), np.full(shape[:2], np.nan)

    def fill(self, row: int, entries: list[Entry]) -> None:
        """Enter the results of one scene."""
        seen: dict[str, int] = {}
        for entry in entries:
            column = seen.get(entry.method, 0)
            seen[entry.method] = column + 1
            place = row, self.names.index(entry.method), column
            self.verdict[place], self.events[place] = int(entry.errors.verdict), entry.events
            self.runs[place], self.first[place[:2]] = len(entry.seconds), entry.first
            for key, array in self.numbers.items():
                array[place] = getattr(entry if key in ("fastest", "median") else entry.errors, key)

    def points(self, row: int, method: str) -> list[tuple[float, float]]:
        """Pairs (state error, shortest run time) of the right runs of a method on a scene."""
        k = self.names.index(method)
        right = self.verdict[row, k] == Verdict.RIGHT
        state, seconds = self.numbers["state"][row, k], self.numbers["fastest"][row, k]
        return list(zip(state[right], seconds[right], strict=True))

    def family(self, family: MethodFamily) -> list[str]:
        """Names of the methods of a family that are in the table."""
        return [name for name in self.names if METHODS[name].family == family]

    def ratios(self, levels: np.ndarray) -> np.ndarray:
        """Run time of the best of each rival family at an error, over the engine's; (scene, family, level)."""
        found = np.full((len(self.scenes), len(_RIVALS), levels.size), np.nan)
        for row in range(len(self.scenes)):
            for i, family in enumerate(_RIVALS):
                for j, level in enumerate(levels):
                    rival = fastest([self.points(row, name) for name in self.family(family)], level)
                    found[row, i, j] = rival / fastest([self.points(row, "exact")], level)
        return found

    def dataset(
        self, controls: Mapping[str, list[float]], levels: np.ndarray, floors: Mapping[str, float]
    ) -> xr.Dataset:
        """Put everything into a dataset."""
        settings = {key: np.full(self.verdict.shape[1:], np.nan) for key in _CONTROLS}
        for k, name in enumerate(self.names):
            if METHODS[name].control in _CONTROLS:
                settings[METHODS[name].control][k, : len(controls[name])] = controls[name]
        return xr.Dataset(
            self._variables(settings, levels),
            coords=self._coordinates(levels, floors),
            attrs={
                "title": "Error against run time of the engine and of other methods",
                "source": "lsvib; references with mpmath at 40 digits",
                "references": "doi:10.1007/978-1-4419-1752-2_8, Sects. 8.5 to 8.7",
                "timing": "processor time of one process, methods interleaved, after a discarded run; "
                "the preparation of a method (tables, compilation) is not in it",
                "processor": processor(),
                "processor_cores": os.cpu_count() or 0,
                "operating_system": platform.system(),
                "rival_versions": json.dumps(_versions()),
            },
        )

    def _variables(self, settings: Mapping[str, np.ndarray], levels: np.ndarray) -> dict[str, tuple]:
        """Return the variables over scenes, methods and settings, and the ratios."""
        cube, families = ("scene", "method", "setting"), [METHODS[name].family for name in self.names]
        return {
            **{name: variable(cube, self.numbers[key], *about) for name, (key, *about) in _NUMBERS.items()},
            "runs": variable(cube, self.runs, "1", "number of runs"),
            "first_run_time": variable(cube[:2], self.first, "s", _FIRST_RUN),
            "motion_verdict": flagged(cube, self.verdict, "whether the motion is the true one", _VERDICTS),
            "events": variable(cube, self.events, "1", "number of events", comment="-1 for a method without"),
            "reference_events": variable("scene", self.reference_events, "1", "number of events of the reference"),
            "duration": variable("scene", self.durations, "s", "duration of the motion"),
            "method_family": flagged("method", families, "family of the method", MethodFamily),
            "ratio": variable(("scene", "rival", "error_level"), self.ratios(levels), "1", _RATIO),
            **{key: variable(("method", "setting"), settings[key], *_CONTROLS[key]) for key in _CONTROLS},
        }

    def _coordinates(self, levels: np.ndarray, floors: Mapping[str, float]) -> dict[str, tuple]:
        """Return the coordinates, and what the checks ask for."""
        titles = [race_scenes.scene(name).title for name in self.scenes]
        labels, index = [find_method(name).label for name in self.names], np.arange(self.verdict.shape[2])
        asked = "ratio that the checks ask for, of"
        return {
            "scene": named_index("scene", "scene", self.scenes, labels="; ".join(titles)),
            "method": named_index("method", "method", self.names, labels="; ".join(labels)),
            "setting": variable("setting", index, "1", "index of the method's setting, coarse to fine"),
            "rival": flagged("rival", _RIVALS, "family of the rival", MethodFamily),
            "error_level": variable("error_level", levels, "1", "error of the final state that is asked for"),
            "ratio_floor": variable((), floors["ratio_floor"], "1", f"{asked} scipy and CVODE"),
            "compiled_floor": variable((), floors["compiled_floor"], "1", f"{asked} diffrax and heyoka"),
        }


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


def _versions() -> dict[str, str]:
    found = {}
    for package in _PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found
