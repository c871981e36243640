"""What a scene saves by leaving out what it does not need: run time, construction, data and imports."""

import json
import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import xarray as xr
from pydantic import Field

from benchmarks.judge import QUARTILES, quartiles
from lsvib.answers.attributes import flag_names, named_index, variable, yes_no
from lsvib.chapter.checks import Check
from lsvib.chapter.settings import Duration, FigureSettings
from lsvib.pictures import style
from lsvib.pictures.style import Axes, Figure

CAPTION = """\
What a scene saves by leaving parts out: (a) run time and (b) construction time of its own model and of a general one
in which they are zero or negligible, with the quartiles of the ratio; (c) what datasets and pictures import.
"""

MODULES = {  # what drawing a figure or building its dataset imports; measured in processes of their own
    "figure": "lsvib.chapter.fig8_09, matplotlib.backends.backend_agg",
    "eigenvalues": "lsvib.chapter.fig8_08",
    "motion": "lsvib.chapter.fig8_09, lsvib.systems.motion",
    "everything": "lsvib.chapter.fig8_09, lsvib.systems.motion, matplotlib.backends.backend_agg, lsvib.cli.app",
}
_IMPORT = """
import json, sys, time
begun = time.perf_counter()
import {module}
print(json.dumps([len(sys.modules), time.perf_counter() - begun, sorted({{m.split('.')[0] for m in sys.modules}})]))
"""
_SOURCE = "docs/validation.md"
_ROUNDING = 1e-12  # of the size of a state: what half a second of events may make of the last digit
_MODELS = ("pared", "general")
_PACKAGES = ("numba", "matplotlib", "xarray")
_TIMES = {"run_time": "time to follow the motion", "build_time": "time to build the model"}
_NUMBERS = {
    "modes": ("1", "number of modes"),
    "guards": ("1", "number of guards"),
    "states": ("1", "number of states"),
    "table_bytes": ("byte", "size of the tables"),
}
_COLOURS = {"own model": style.BLUE, "general model": style.GREY}


class Settings(FigureSettings):
    """What a scene saves by leaving out what it does not need."""

    engine: ClassVar = ("planar", "modal", "taylor")

    duration: Duration
    repeats: int = Field(ge=1, le=1000, description="Repeats of each measurement.")
    fresh: int = Field(ge=1, le=100, description="Processes of their own in which each import is timed.")


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Measure the scenes of :func:`benchmarks.leaving_out.scenes` and the imports.

    ``settings``: see ``Settings``.
    """
    from benchmarks import leaving_out

    scenes = leaving_out.scenes(settings["duration"])
    pairs = [leaving_out.measure(scene, settings["repeats"]) for scene in scenes.values()]
    variables: dict[str, tuple] = {
        name: variable(("scene", "model"), np.array([[getattr(m, name) for m in pair] for pair in pairs]), units, words)
        for name, (units, words) in _NUMBERS.items()
    }
    compared = [leaving_out.difference(pared.motion, general.motion) for pared, general in pairs]
    for name, words in _TIMES.items():
        times = np.array([[getattr(m, f"{name}s") for m in pair] for pair in pairs])
        ratio = f"{words}: general over own model, quartiles of the repeats"
        variables |= {
            name: variable(("scene", "model"), np.median(times, axis=-1), "s", f"{words}, median of the repeats"),
            f"{name}_ratio": variable(("scene", "quartile"), quartiles(times[:, 1] / times[:, 0]), "1", ratio),
        }
    apart = "largest difference of states and event times, relative to their size"
    variables |= {
        "same_events": yes_no("scene", [same for same, _ in compared], "both models have the same events"),
        "difference": variable("scene", [gap for _, gap in compared], "1", apart),
    }
    variables |= _imports(settings)
    return xr.Dataset(
        variables,
        coords={
            "scene": named_index("scene", "scene", list(scenes)),
            "model": named_index("model", "extent of the model", _MODELS),
            "imported_for": named_index("imported_for", "what is imported", list(MODULES)),
            "package": named_index("package", "package", _PACKAGES),
            "quartile": variable("quartile", list(QUARTILES), "1", "share of the repeats below"),
        },
        attrs={
            "title": "What a scene saves by leaving parts out",
            "source": "lsvib, own and general models of the same motions",
            "references": "docs/validation.md",
            "left_out": "; ".join(f"{name}: {scene.left_out}" for name, scene in scenes.items()),
            "modules": "; ".join(f"{name}: {module}" for name, module in MODULES.items()),
            "hardware": f"{platform.machine()}, {os.cpu_count()} CPUs",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that both models have one motion, that the own one has less in it, and what is imported."""
    parts = [(dataset[name].values, words) for name, (_, words) in _NUMBERS.items()]
    loads = dataset.loads.astype(bool).values
    row = {name: k for k, name in enumerate(MODULES)}
    column = {name: k for k, name in enumerate(_PACKAGES)}
    return [
        Check.holds(
            f"The own and the general model of each scene have the same events, and states to {_ROUNDING:.0e}",
            _SOURCE,
            f"largest difference {float(dataset.difference.max()):.1e}",
            bool(dataset.same_events.all() and (dataset.difference <= _ROUNDING).all()),
        ),
        Check.holds(
            "No scene's own model has more modes, guards or states than the general one, and each has smaller tables",
            _SOURCE,
            ", ".join(f"{words} {x[:, 0].sum():g} of {x[:, 1].sum():g}" for x, words in parts),
            bool(all((x[:, 0] <= x[:, 1]).all() for x, _ in parts) and (parts[-1][0][:, 0] < parts[-1][0][:, 1]).all()),
        ),
        Check.holds(
            "Datasets of eigenvalues import no numba, datasets of motions no matplotlib, pictures no engine",
            _SOURCE,
            ", ".join(f"{name}: {int(n)} modules" for name, n in zip(MODULES, dataset.imported.values, strict=True)),
            not (
                loads[row["eigenvalues"], column["numba"]]
                or loads[row["motion"], column["matplotlib"]]
                or loads[row["figure"], column["numba"]]
            ),
        ),
    ]


def _imports(settings: Mapping[str, Any]) -> dict[str, tuple]:
    """Number of modules that an import loads, its fastest time, and packages; each import in a new process."""
    found = []
    for module in MODULES.values():
        words = [sys.executable, "-c", _IMPORT.format(module=module)]
        runs = [subprocess.run(words, capture_output=True, text=True, check=True) for _ in range(settings["fresh"])]
        counts, times, packages = zip(*(json.loads(run.stdout) for run in runs), strict=True)
        found.append((counts[0], min(times), [package in packages[0] for package in _PACKAGES]))
    (numbers, seconds, loads), dim = zip(*found, strict=True), "imported_for"
    return {
        "imported": variable(dim, list(numbers), "1", "number of modules that are imported"),
        "import_time": variable(dim, list(seconds), "s", "fastest time to import them"),
        "loads": yes_no((dim, "package"), list(loads), "the package is imported"),
    }


def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) run time and (b) construction of both models, (c) imports."""
    figure = style.new_figure(style.DOUBLE, 4.2)
    axes = figure.subplot_mosaic("ab;cc", height_ratios=[dataset.sizes["scene"], dataset.sizes["imported_for"] + 0.5])
    _pairs(axes["a"], dataset, "run_time", "(a) following the motion")
    _pairs(axes["b"], dataset, "build_time", "(b) building the model")
    names, left_out = flag_names(dataset.scene).values(), dataset.attrs["left_out"].split("; ")
    words = [f"{name},\nwithout {other.split(': ')[1]}" for name, other in zip(names, left_out, strict=True)]
    axes["a"].set_yticks(range(len(words)), words, fontsize=6.5)
    axes["b"].set_yticks(range(len(words)), [""] * len(words))
    axes["b"].legend(loc="upper right", fontsize=6.5, handletextpad=0.1)
    packages = flag_names(dataset.package)
    loaded = [
        ", ".join(packages[int(p)] for p, yes in zip(dataset.package.values, row, strict=True) if yes) or "none of them"
        for row in dataset.loads.values
    ]
    words = [f"{int(n)} modules: {text}" for n, text in zip(dataset.imported, loaded, strict=True)]
    _bars(axes["c"], dataset.imported_for, dataset.import_time, words)
    return figure


def _pairs(axes: Axes, dataset: xr.Dataset, name: str, title: str) -> None:
    """Both times of each scene, and how many times longer the general model takes, with the quartiles."""
    values = dataset[name].values * 1e3
    place = np.arange(dataset.sizes["scene"])
    axes.hlines(place, *values.T, color=style.GREY, linewidth=0.8)
    for k, (words, colour) in enumerate(_COLOURS.items()):
        axes.plot(values[:, k], place, "o", color=colour, label=words)
    for row, (low, middle, high) in enumerate(dataset[f"{name}_ratio"].values):
        axes.annotate(f"× {middle:.2g} ({low:.2g}–{high:.2g})", (values[row].max(), row), (6, 0), va="center",
                      textcoords="offset points", fontsize=6.5)  # fmt: skip
    axes.set(title=title, xlabel="Time [ms]", xscale="log", ylim=(place[-1] + 0.6, -0.6))
    axes.set_xlim(values.min() / 1.3, values.max() * 3 * (values.max() / values.min()) ** 0.2)


def _bars(axes: Axes, kinds: xr.DataArray, seconds: xr.DataArray, words: list[str]) -> None:
    place, longest = np.arange(seconds.size), float(seconds.max())
    axes.barh(place, seconds.values, 0.6, color=style.SKY)
    for row, text in enumerate(words):
        axes.text(0.02 * longest, row, text, va="center", fontsize=6.5)
    axes.set_yticks(place, list(flag_names(kinds).values()))
    axes.set(title="(c) imports", xlabel="Time [s]", xlim=(0, longest * 1.02), ylim=(place[-1] + 0.6, -0.6))
