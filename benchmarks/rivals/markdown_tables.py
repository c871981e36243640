"""The tables of docs/validation.md, from the dataset of error against run time."""

import math

import numpy as np
import xarray as xr

from benchmarks.record import Verdict
from benchmarks.rivals.method_list import MethodFamily

_COLUMNS = {
    MethodFamily.GENERAL: "scipy, CVODE",
    MethodFamily.COMPILED: "diffrax",
    MethodFamily.TAYLOR: "heyoka",
    MethodFamily.FIXED_STEP: "RK4",
}


def markdown(dataset: xr.Dataset) -> str:
    """Return the machine, ratios at equal error, verdicts by method, and every run, as Markdown."""
    parts = (_machine(dataset), _ratios(dataset), _verdicts(dataset), _runs(dataset))
    return "\n\n".join(parts) + "\n"


def _machine(dataset: xr.Dataset) -> str:
    a = dataset.attrs
    return (
        f"{a['processor']}, {a['processor_cores']} cores; {a['operating_system']}; rivals {a['rival_versions']}; "
        f"lsvib with {a.get('package_versions', 'unknown versions')}"
    )


def _names(dataset: xr.Dataset, dimension: str) -> list[str]:
    return dataset[dimension].attrs["flag_meanings"].split()


def _table(head: list[str], rows: list[list[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _number(value: float, form: str) -> str:
    return f"{value:{form}}" if math.isfinite(value) else "–"


def _ratios(dataset: xr.Dataset) -> str:
    """Run time of the best of scipy and CVODE, of diffrax, of heyoka and of fixed-step methods over the engine's."""
    levels = dataset.error_level.values
    engine = dataset.isel(method=_names(dataset, "method").index("exact"), setting=0)
    head = ["scene", "engine: time", "engine: error"]
    head += [f"{label}, {level:.0e}" for label in _COLUMNS.values() for level in levels]
    rows = []
    for k, scene in enumerate(_names(dataset, "scene")):
        row = [scene, f"{1e3 * float(engine.run_time[k]):.3f} ms", f"{float(engine.state_error[k]):.1e}"]
        for family in _COLUMNS:
            row += [_number(float(x), ".0f") for x in dataset.ratio.sel(rival=int(family)).values[k]]
        rows.append(row)
    return _table(head, rows)


def _verdicts(dataset: xr.Dataset) -> str:
    """Runs with the right motion, with wrong numbers of events, another attractor, and given up, by method."""
    kinds = (Verdict.RIGHT, Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION, Verdict.GAVE_UP)
    rows = []
    for k, label in enumerate(dataset.method.attrs["labels"].split("; ")):
        values = dataset.motion_verdict.values[:, k]
        rows.append([label, *(str(int(np.count_nonzero(values == kind))) for kind in kinds)])
    return _table(["method", "right", "wrong events", "wrong attractor", "gave up"], rows)


def _runs(dataset: xr.Dataset) -> str:
    """Every run."""
    labels = dataset.method.attrs["labels"].split("; ")
    controls = ("relative_tolerance", "time_step", "smoothing_width")
    columns = {  # heading: factor and form of a number
        "state error": ("state_error", 1, ".1e"),
        "event times [s]": ("event_time_error", 1, ".1e"),
        "amplitude": ("amplitude_error", 1, ".1e"),
        "time [ms]": ("run_time", 1e3, ".3g"),
        "median [ms]": ("run_time_median", 1e3, ".3g"),
    }
    rows = []
    for i, scene in enumerate(_names(dataset, "scene")):
        for k, label in enumerate(labels):
            for j in range(dataset.sizes["setting"]):
                run = dataset.isel(scene=i, method=k, setting=j)
                verdict = Verdict(int(run.motion_verdict))
                if verdict == Verdict.NOT_RUN:
                    continue
                setting = next((float(run[c]) for c in controls if math.isfinite(float(run[c]))), math.nan)
                numbers = [_number(factor * float(run[key]), form) for key, factor, form in columns.values()]
                rows.append([scene, label, _number(setting, "g"), *numbers, verdict.words])
    return _table(["scene", "method", "setting", *columns, "motion"], rows)
