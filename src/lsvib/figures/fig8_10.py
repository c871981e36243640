"""Figure 8.10: phase plane and contact force with compliant threads, a peak of the force, and its dependence on R."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import phase, style

_SLIDING = (-60.0, 160.0)  # N: part of the force axis on which sliding is seen


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the phase plane, (b) N(t) with a broken axis, (c) one peak in time, (d) the peak against R."""
    figure = style.new_figure(style.DOUBLE, 5.0)
    panels = figure.subplot_mosaic(
        [["a", "peaks"], ["a", "sliding"], ["c", "d"]], height_ratios=(1, 1, 1.35), width_ratios=(1, 1.15)
    )
    _plane(panels["a"], dataset)
    _force(panels["peaks"], panels["sliding"], dataset)
    _one_peak(panels["c"], dataset)
    _sensitivity(panels["d"], dataset)
    phase.legend(figure, [panels["a"], panels["c"]], 3)
    return figure


def _plane(axes: Axes, dataset: xr.Dataset) -> None:
    axes.plot(dataset.angle_deviation, dataset.velocity_deviation, color=style.SKY, linewidth=0.8, label="motion")
    _cycles(axes, dataset)
    axes.plot(dataset.angle_deviation[0], dataset.velocity_deviation[0], "o", color=style.SKY, markerfacecolor="white")
    phase.mark_origin(axes)
    axes.axhline(
        -float(dataset.input_speed), color=style.GREY, linestyle=(0, (6, 2, 1, 2)), linewidth=1.0, zorder=1.4,
        label=r"$\dot\theta = 0$",
    )  # fmt: skip
    phase.label_axes(axes, dataset)
    axes.locator_params(axis="x", nbins=5)
    contact = f"$k_c = c_c$ = {phase.number(dataset.contact_stiffness)} (SI)"
    axes.set_title(f"(a) {contact}, $m$ = {phase.number(dataset.mass)} kg")
    if not np.isfinite(dataset.cycle_angle).any():
        return
    corner = axes.inset_axes((0.22, 0.36, 0.46, 0.26))
    _cycles(corner, dataset)
    speed = float(dataset.input_speed)
    low, width = float(dataset.cycle_angle.max()), float(dataset.amplitude)
    corner.set(xlim=(low - 0.06 * width, low + 0.03 * width), ylim=(-1.1 * speed, 1.1 * speed))
    corner.locator_params(nbins=3)
    corner.ticklabel_format(axis="x", style="plain")
    corner.tick_params(labelsize=6, pad=1.5)
    axes.indicate_inset_zoom(corner, edgecolor=style.GREY)


def _cycles(axes: Axes, dataset: xr.Dataset) -> None:
    """The rigid cycle, its jump included, and the compliant one on it."""
    axes.plot(dataset.rigid_cycle_angle, dataset.rigid_cycle_velocity, color=style.ORANGE, linewidth=2.6,
              label="cycle of the rigid drive", zorder=2)  # fmt: skip
    axes.plot(dataset.cycle_angle, dataset.cycle_velocity, color=style.BLUE, linewidth=1.0,
              label="cycle with compliant threads", zorder=2.1)  # fmt: skip


def _force(peaks: Axes, sliding: Axes, dataset: xr.Dataset) -> None:
    """Contact force over time: the peaks above, sliding below, on the same axis of time."""
    time = dataset.time * 1e3
    peaks.plot(time, dataset.normal_force / 1e3, color=style.BLUE, linewidth=0.8)
    sliding.plot(time, dataset.normal_force, color=style.BLUE, linewidth=0.8)
    printed = float(dataset.printed_peak_normal_force) / 1e3
    peaks.axhline(printed, color=style.VERMILION, linestyle="--", linewidth=0.9)
    peaks.text(0.99, 0.97, f"{printed:g} kN, printed", color=style.VERMILION, ha="right", va="top", fontsize=6.5,
               transform=peaks.transAxes)  # fmt: skip
    sliding.axhline(0, color=style.GREY, linewidth=0.6)
    peaks.set(title="(b) contact force", ylim=(0, _top(dataset)), ylabel="$N$ [kN]")
    sliding.set(ylim=_SLIDING, xlabel="Time $t$ [ms]", ylabel="$N$ [N]")
    peaks.tick_params(labelbottom=False)
    peaks.spines["bottom"].set_linestyle((0, (4, 3)))
    sliding.spines["top"].set_linestyle((0, (4, 3)))
    for axes in (peaks, sliding):
        axes.set_xlim(0, float(time[-1]))


def _top(dataset: xr.Dataset) -> float:
    """Upper end of an axis of the force [kN]: a little above the printed peak and what is drawn."""
    return 1.15e-3 * max(float(dataset.printed_peak_normal_force), float(dataset.normal_force.max()))


def _one_peak(axes: Axes, dataset: xr.Dataset) -> None:
    sprag = float(dataset.sprag_duration) * 1e6
    time = dataset.close_up_time * 1e6
    axes.plot(time, dataset.close_up_normal_force / 1e3, color=style.BLUE)
    axes.axvspan(0, sprag, color=style.YELLOW, alpha=0.35, linewidth=0, label=r"sprag: $N > 0$, $\dot\theta > 0$")
    axes.set(title="(c) one peak", xlabel="Time after $N = 0$ [µs]", ylabel="$N$ [kN]", ylim=(-10, _top(dataset)))
    axes.margins(x=0)


def _sensitivity(axes: Axes, dataset: xr.Dataset) -> None:
    printed = float(dataset.printed_peak_normal_force) / 1e3
    part = dataset.printed_peak_normal_force.attrs["relative_tolerance"]
    axes.axhspan(printed * (1 - part), printed * (1 + part), color=style.VERMILION, alpha=0.15, linewidth=0)
    axes.text(0.98, 0.2, f"{printed:g} kN ± {100 * part:g} %", color=style.VERMILION, ha="right", fontsize=6.5,
              transform=axes.transAxes)  # fmt: skip
    axes.plot(dataset.swept_axial_force, dataset.swept_peak_normal_force / 1e3, color=style.BLUE)
    axes.plot(dataset.axial_force, dataset.peak_normal_force / 1e3, "o", color=style.BLUE)
    axes.set(
        title="(d) dependence on $R$, assumed above",
        xlabel=style.label(dataset.swept_axial_force),
        ylabel="Peak of $N$ [kN]",
    )
    axes.set_xlim(0, float(dataset.swept_axial_force[-1]))
    axes.tick_params(axis="y", which="both", right=False)
    right = axes.twinx()
    right.plot(dataset.swept_axial_force, 100 * dataset.swept_orbit_distance, color=style.GREEN, linestyle="--")
    right.set_ylabel("Distance to the rigid cycle [%]", color=style.GREEN)
    right.set_ylim(0, None)
