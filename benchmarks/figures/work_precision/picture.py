"""Error against run time: one panel for each scene, every method a line, wrong motions marked by crosses."""

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lsvib.figures import style

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


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the error of the final state against run time, scene by scene; the legend is shared."""
    count = dataset.sizes["scene"]
    rows = math.ceil(count / _COLUMNS)
    figure = style.new_figure(style.DOUBLE, 2.35 * rows + 1.0)
    panels = np.ravel(figure.subplots(rows, min(count, _COLUMNS), sharey=True, squeeze=False))
    names = dataset.method.attrs["flag_meanings"].split()
    titles = dataset.scene.attrs["labels"].split("; ")
    right = {word: value for value, word in style.flag_names(dataset.motion_verdict).items()}["right"]
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
    codes = {word: value for value, word in style.flag_names(scene.motion_verdict).items()}
    drawn = [name in _STYLES for name in scene.method.attrs["flag_meanings"].split()]
    lost = int((scene.motion_verdict.values[drawn] == codes["gave up"]).sum())
    if lost:
        axes.text(0.97, 0.03, f"{lost} gave up", transform=axes.transAxes, fontsize=6, ha="right")


def _handles(dataset: xr.Dataset, names: list[str]) -> list[Line2D]:
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
