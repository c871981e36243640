"""What is saved by leaving out what a scene does not need: run, construction, compilation, imports."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import style

_COLOURS = (style.BLUE, style.GREY)


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) run time and (b) construction of both models, (c) compilation, (d) imports."""
    figure = style.new_figure(style.DOUBLE, 4.4)
    run, built, compiled, imported = figure.subplots(2, 2).ravel()
    _pairs(run, dataset, dataset.run_time * 1e3, "(a) following the motion", "Run time [ms]")
    _pairs(built, dataset, dataset.build_time * 1e3, "(b) building the model", "Time [ms]")
    figure.legend(*run.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    _bars(compiled, dataset.compiled, dataset.compile_time, "(c) compiling the engine, cache empty", "CPU time [s]",
          [f"{int(n)} kernels" for n in dataset.specialisations])  # fmt: skip
    names = style.flag_names(dataset.package)
    loaded = [
        ", ".join(names[int(p)] for p, yes in zip(dataset.package.values, row, strict=True) if yes) or "–"
        for row in dataset.loads.values
    ]
    words = [f"{int(n)} modules:\n{text}" for n, text in zip(dataset.imported, loaded, strict=True)]
    _bars(imported, dataset.imported_for, dataset.import_time, "(d) importing what it needs", "Time [s]", words)
    return figure


def _pairs(axes: Axes, dataset: xr.Dataset, values: xr.DataArray, title: str, label: str) -> None:
    """Two bars for each scene, and how many times longer the general model takes."""
    names = style.flag_names(dataset.scene)
    models = style.flag_names(dataset.model)
    place = np.arange(dataset.sizes["scene"])
    for k, colour in enumerate(_COLOURS):
        axes.barh(place + 0.2 * (2 * k - 1), values.values[:, k], 0.36, color=colour, label=f"{models[k]} model")
    for row, (pared, general) in enumerate(values.values):
        axes.text(general * 1.08, row + 0.2, f"× {general / pared:.2g}", va="center", fontsize=7)
    axes.set_yticks(place, list(names.values()))
    axes.set(title=title, xlabel=label, xscale="log", ylim=(place[-1] + 0.6, -0.6))
    axes.set_xlim(values.values.min() / 2, values.values.max() * 6)


def _bars(axes: Axes, kinds: xr.DataArray, values: xr.DataArray, title: str, label: str, words: list[str]) -> None:
    place = np.arange(values.size)
    axes.barh(place, values.values, 0.5, color=style.BLUE)
    largest = float(values.max())
    for row, text in enumerate(words):
        axes.text(values.values[row] + 0.02 * largest, row, text, va="center", fontsize=6.5)
    axes.set_yticks(place, [name.replace(" and ", "\nand ") for name in style.flag_names(kinds).values()])
    axes.set(title=title, xlabel=label, xlim=(0, largest * 1.9), ylim=(place[-1] + 0.6, -0.6))
