"""Panels of a measured torque: the points with the fitted law, and the residuals."""

import math
from collections.abc import Iterator

import numpy as np
import xarray as xr

from lsvib.pictures import style

RPM = math.pi / 30  # rad/s


def torque_panel(axes: style.Axes, dataset: xr.Dataset) -> None:
    """Draw the magnitudes of torques over that of the speed, with their scatter, and the law of the first end."""
    laws = np.abs(dataset.law_torque.isel(end=0)) * 1e3
    for sign, colour, mark, words, own in _ways(dataset):
        points = dataset.isel(point=own)
        axes.errorbar(
            np.abs(points.measured_speed) / RPM, np.abs(points.measured_torque) * 1e3, points.torque_scatter * 1e3,
            fmt=mark, color=colour, markersize=3, elinewidth=0.5, label=f"measured, {words}",
        )  # fmt: skip
        label = f"fitted law, {words}"
        for law in laws:
            sense = sign * int(np.sign(law.load_case) or 1)
            if sense in dataset.direction:
                axes.plot(dataset.law_speed / RPM, law.sel(direction=sense), color=colour, linewidth=1, label=label)
                label = ""
    low, high = axes.get_ylim()
    axes.set(xlabel="Screw speed [rpm]", ylabel="Motor torque [mN m]", ylim=(low, high + 0.25 * (high - low)))
    axes.legend(fontsize=7, ncols=2, loc="upper left")


def residual_panel(axes: style.Axes, dataset: xr.Dataset) -> None:
    """Draw the residuals of the fit, by end, with the standard error of each mean, over the speed."""
    error = dataset.torque_scatter / np.sqrt(dataset.samples) * 1e3
    for _, colour, mark, words, own in _ways(dataset):
        speed = np.abs(dataset.measured_speed[own]) / RPM
        first, *others = dataset.residual[:, own] * 1e3
        axes.errorbar(speed, first, error[own], fmt=mark, color=colour, markersize=3, elinewidth=0.5, label=words)
        for end in others:
            axes.plot(speed, end, "x", color=colour, markersize=3, label=f"{words}, bearing end")
    axes.axhline(0, color=style.GREY, linewidth=0.6)
    axes.set(xlabel="Screw speed [rpm]", ylabel="Torque [mN m]")
    axes.legend(fontsize=7)


def _ways(dataset: xr.Dataset) -> Iterator[tuple[int, str, str, str, np.ndarray]]:
    """Lifting and lowering, as far as measured: sign of speed times load, colour, mark, words, indices of points."""
    for sign, colour, mark, words in ((1, style.VERMILION, "o", "lifting"), (-1, style.BLUE, "s", "lowering")):
        towards = dataset.measured_load.where(dataset.measured_load != 0, 1.0)  # a preloaded nut may have no load
        own = np.flatnonzero(np.sign(dataset.measured_speed * towards) == sign)
        if own.size:
            yield sign, colour, mark, words, own
