"""Figure 8.10: phase plane and contact force with compliant threads, a peak of the force, and its dependence on R."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lsvib.figures import drawing, style

_SLIDING = (-60.0, 160.0)  # N: part of the force axis on which sliding is seen
_CUT = {"marker": [(-1, -0.6), (1, 0.6)], "markersize": 7, "linestyle": "none", "color": style.BLACK, "mew": 0.8,
        "clip_on": False, "zorder": 10}  # fmt: skip


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the phase plane, (b) N(t) on a broken axis, (c) a seizure close up, (d) its peak, (e) what R changes."""
    figure = style.new_figure(style.DOUBLE, 5.6)
    above, below = figure.subfigures(2, 1, height_ratios=(1.25, 1))
    panels = above.subplot_mosaic([["a", "peaks"], ["a", "sliding"]], width_ratios=(1, 1.15))
    close, peak, force = below.subplots(1, 3)
    _plane(panels["a"], dataset)
    _force(panels["peaks"], panels["sliding"], dataset)
    _close_up(close, dataset)
    _one_peak(peak, dataset)
    _sensitivity(force, dataset)
    style.state_values(figure, dataset)
    drawing.legend(figure, [panels["a"], peak], 3)
    return figure


def _plane(axes: Axes, dataset: xr.Dataset) -> None:
    axes.plot(dataset.angle_deviation, dataset.velocity_deviation, color=style.SKY, linewidth=0.8, label="motion")
    _cycles(axes, dataset)
    axes.plot(dataset.angle_deviation[0], dataset.velocity_deviation[0], "o", color=style.SKY, markerfacecolor="white",
              label="start")  # fmt: skip
    drawing.mark_origin(axes)
    axes.axhline(
        -float(dataset.input_speed), color=style.GREY, linestyle=(0, (6, 2, 1, 2)), linewidth=1.0, zorder=1.4,
        label=r"$\dot\theta = 0$",
    )  # fmt: skip
    drawing.draw_arrows(axes, [(dataset.cycle_angle.values, dataset.cycle_velocity.values, style.BLUE)])
    drawing.label_axes(axes, dataset)
    axes.locator_params(axis="x", nbins=5)
    axes.set_title("(a) phase plane")


def _close_up(axes: Axes, dataset: xr.Dataset) -> None:
    """The right edge of (a), where the screw seizes: a jump with rigid threads."""
    _cycles(axes, dataset)
    if np.isfinite(dataset.cycle_angle).any():
        speed = float(dataset.input_speed)
        edge, width = float(dataset.cycle_angle.max()), float(dataset.amplitude)
        axes.set(xlim=(edge - 0.05 * width, edge + 0.02 * width), ylim=(-1.1 * speed, 1.1 * speed))
    axes.xaxis.set_major_formatter(lambda value, _: f"{1e3 * value:g}".replace("-", "−"))
    axes.locator_params(axis="x", nbins=4)
    axes.set(title="(c) right edge of (a)", xlabel="Deviation $u$ [10⁻³ rad]",
             ylabel=style.label(dataset.velocity_deviation, "rate"))  # fmt: skip


def _cycles(axes: Axes, dataset: xr.Dataset) -> None:
    """The rigid cycle, its jump included, and the compliant one on it."""
    axes.plot(dataset.rigid_cycle_angle, dataset.rigid_cycle_velocity, color=style.ORANGE, linewidth=2.6,
              label="cycle of the rigid drive", zorder=2)  # fmt: skip
    axes.plot(dataset.cycle_angle, dataset.cycle_velocity, color=style.BLUE, linewidth=1.0,
              label="cycle with compliant threads", zorder=2.1)  # fmt: skip


def _force(peaks: Axes, sliding: Axes, dataset: xr.Dataset) -> None:
    """Contact force over time: the peaks above, sliding below, on the same axis of time; its own axis is broken."""
    time = dataset.time * 1e3
    peaks.plot(time, dataset.normal_force / 1e3, color=style.BLUE, linewidth=0.8)
    sliding.plot(time, dataset.normal_force, color=style.BLUE, linewidth=0.8)
    printed = float(dataset.printed_peak_normal_force) / 1e3
    peaks.axhline(printed, color=style.VERMILION, linestyle="--", linewidth=0.9)
    peaks.text(0.99, 0.97, f"{printed:g} kN, printed", color=style.VERMILION, ha="right", va="top", fontsize=6.5,
               transform=peaks.transAxes)  # fmt: skip
    sliding.axhline(0, color=style.GREY, linewidth=0.6)
    peaks.set(title="(b) contact force, axis broken: kN above, N below", ylim=(0, 1.06 * _top(dataset)))
    peaks.set_ylabel("$N$ [kN]")
    sliding.set(ylim=_SLIDING, xlabel="Time $t$ [ms]", ylabel="$N$ [N]")
    peaks.tick_params(labelbottom=False, bottom=False, top=False)
    sliding.tick_params(top=False)
    peaks.spines["bottom"].set_visible(False)
    sliding.spines["top"].set_visible(False)
    for axes, edge in ((peaks, 0), (sliding, 1)):
        axes.set_xlim(0, float(time[-1]))
        axes.plot([0, 1], [edge, edge], transform=axes.transAxes, **_CUT)


def _top(dataset: xr.Dataset) -> float:
    """Upper end of an axis of the force [kN]: a little above the printed peak and what is drawn."""
    return 1.15e-3 * max(float(dataset.printed_peak_normal_force), float(dataset.normal_force.max()))


def _one_peak(axes: Axes, dataset: xr.Dataset) -> None:
    sprag = float(dataset.sprag_duration) * 1e6
    time = dataset.close_up_time * 1e6
    axes.plot(time, dataset.close_up_normal_force / 1e3, color=style.BLUE)
    axes.axvspan(0, sprag, color=style.YELLOW, alpha=0.35, linewidth=0, label=r"sprag: $N > 0$, $\dot\theta > 0$")
    axes.set(title="(d) one peak", xlabel="Time after $N = 0$ [µs]", ylabel="$N$ [kN]", ylim=(-10, _top(dataset)))
    axes.margins(x=0)


def _sensitivity(axes: Axes, dataset: xr.Dataset) -> None:
    """Peak force (left) and distance to the rigid cycle (right) over R; the dot is the force of (a) to (d)."""
    printed = float(dataset.printed_peak_normal_force) / 1e3
    part = dataset.printed_peak_normal_force.attrs["relative_tolerance"]
    axes.axhspan(printed * (1 - part), printed * (1 + part), color=style.VERMILION, alpha=0.15, linewidth=0)
    axes.text(0.97, 0.1, f"{printed:g} kN ± {100 * part:g} %", color=style.VERMILION, ha="right", fontsize=6.5,
              transform=axes.transAxes)  # fmt: skip
    force = dataset.swept_axial_force
    (peak,) = axes.plot(force, dataset.swept_peak_normal_force / 1e3, color=style.BLUE)
    axes.plot(dataset.axial_force, dataset.peak_normal_force / 1e3, "o", color=style.BLUE)
    axes.set(title="(e) dependence on $R$", xlabel=f"Axial force {style.label(force, ' ').strip()}")
    axes.set_ylabel("Peak of $N$ [kN]", color=peak.get_color())
    axes.set_xlim(0, float(force[-1]))
    axes.tick_params(axis="y", which="both", right=False)
    right = axes.twinx()
    right.plot(force, 100 * dataset.swept_orbit_distance, color=style.GREEN, linestyle="--")
    right.set_ylabel("Distance to rigid cycle [%]", color=style.GREEN)
    right.set_ylim(0, None)
