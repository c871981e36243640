"""Draw phase planes from the variables of ``lsvib.datasets.phase_plane``: one case, a few motions, lines and marks."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase

from lsvib.figures import drawing, style
from lsvib.figures.style import number

MOTIONS = (style.BLUE, style.ORANGE, style.SKY, style.PURPLE)
EVEN = (1.1, 1.1, 1.1, 1.1)  # widths of the lines of up to four motions, in points
OVERLAID = (2.2, 1.0, 1.0, 1.0)  # where a later motion lies on the first, that one still shows on both sides
_DOTTED = (0, (1, 1.2))  # dots and gaps in widths of the line: close enough to read as one line


def single(dataset: xr.Dataset) -> Figure:
    """Return a figure of the only case of a dataset."""
    figure = style.new_figure(style.SINGLE * 1.25, 3.4)
    axes = figure.add_subplot()
    case = dataset.isel(case=0)
    draw_motions(axes, case)
    draw_cycle(axes, case)
    mark_origin(axes)
    widen(axes, case)
    draw_lines(axes, case)
    guide(axes, case)
    label_axes(axes, dataset)
    axes.set_title(f"$R$ = {number(case.axial_force)} N")
    style.state_values(figure, dataset)
    legend(figure, [axes], 3)
    return figure


def label_axes(axes: Axes, dataset: xr.Dataset) -> None:
    """Label both axes with u and its rate."""
    axes.set_xlabel(style.label(dataset.angle_deviation, "deviation"))
    axes.set_ylabel(style.label(dataset.velocity_deviation, "rate"))


def draw_lines(axes: Axes, case: xr.Dataset, colour: str = style.VERMILION, name: str = "$N = 0$") -> None:
    """Draw the line N = 0 of one case and θ′ = 0, without any change of the axes' limits."""
    limits = axes.axis()
    angle, slope = float(case.contact_line_angle), float(case.contact_line_slope)
    rates = np.array(limits[2:])
    axes.plot(angle + slope * rates, rates, color=colour, linestyle=(0, (5, 2)), linewidth=1.0, label=name, zorder=1.5)
    stop = float(case.stop_velocity)
    axes.axhline(
        stop, color=style.GREY, linestyle=(0, (6, 2, 1, 2)), linewidth=1.0, label=r"$\dot\theta = 0$", zorder=1.4
    )
    axes.axis(limits)


def draw_motions(axes: Axes, case: xr.Dataset, widths: Sequence[float] = EVEN) -> None:
    """Draw the motions of one case: jumps dotted, rest thick, starts and seizures marked."""
    for index, colour, width in zip(range(case.sizes["start"]), MOTIONS, widths, strict=False):
        motion = case.isel(start=index)
        u, w, time = (motion[name].values for name in ("angle_deviation", "velocity_deviation", "time"))
        _broken_line(axes, u, w, (np.diff(time) == 0) & (np.diff(w) != 0), colour, width, "motion")
        rests = (motion["mode"] == code(motion["mode"], "rest")).values
        if rests.any():
            still = np.where(rests, u, np.nan), np.where(rests, w, np.nan)
            axes.plot(*still, color=style.GREEN, linewidth=3, solid_capstyle="butt", label="rest", zorder=2.5)
        seized = events(motion, "seizure").values
        if seized.any():
            mark_seizures(
                axes,
                motion.event_angle_deviation_before.values[seized],
                motion.event_velocity_deviation_before.values[seized],
                colour,
            )
        axes.plot(u[0], w[0], "o", color=colour, markerfacecolor="white", label="start", zorder=3)


def draw_cycle(
    axes: Axes, case: xr.Dataset, colour: str = style.BLACK, width: float = 1.8, name: str = "limit cycle"
) -> None:
    """Draw the limit cycle of one case, if it has one, its jumps dotted."""
    u, w = (np.append(x, x[0]) for x in (case.cycle_angle.values, case.cycle_velocity.values))
    if np.isfinite(u).any():
        _broken_line(axes, u, w, cycle_jumps(case), colour, width, name)


def cycle_jumps(case: xr.Dataset) -> np.ndarray:
    """Return, for each sample of a limit cycle, whether the rate jumps before the next (the first follows the last)."""
    u, w = (np.append(x, x[0]) for x in (case.cycle_angle.values, case.cycle_velocity.values))
    return (np.abs(np.diff(u)) < 1e-9 * np.ptp(u)) & (np.abs(np.diff(w)) > 0.05 * np.ptp(w))


def mark_seizures(axes: Axes, u, w, colour: str) -> None:
    """Mark states in which a seizure starts."""
    axes.plot(u, w, "v", color=colour, markersize=3.2, label="start of a seizure", zorder=3)


def _broken_line(axes: Axes, u, w, jumps, colour: str, width: float, name: str) -> None:
    """Draw a line that is solid but for its jumps, which are dotted."""
    axes.plot(*_parted(u, w, jumps), color=colour, linewidth=width, label=name, zorder=2.2)
    for k in np.flatnonzero(jumps):
        axes.plot(u[k : k + 2], w[k : k + 2], color=colour, linewidth=1, linestyle=_DOTTED,
                  label="seizure: jump of the rate")  # fmt: skip


def _parted(u, w, jumps) -> tuple[np.ndarray, np.ndarray]:
    """Return u and w with NaN at the jumps."""
    after = np.flatnonzero(jumps) + 1
    return np.insert(u, after, np.nan), np.insert(w, after, np.nan)


def guide(axes: Axes, case: xr.Dataset, size: float = 10.0) -> None:
    """Name the sides of the line N = 0 of one case, and draw the arrows of :func:`draw_arrows`.

    To be called when the panel has its limits. ``size`` of the arrows in points; the words are a little smaller.
    N = Q / [Γ_s (cos λ + s μ sin λ)] (8.17), and Q grows with u: N > 0 to the right where Γ₊ > 0. Where Γ₊ < 0 a motion
    follows law −, for which N θ′ < 0, and beyond the line there is no solution: only the side of slip has a name.
    """
    draw_arrows(axes, case, size)
    paths = _paths(case)
    angle, slope, stop = (float(case[x]) for x in ("contact_line_angle", "contact_line_slope", "stop_velocity"))
    sides, (low, high) = np.array(axes.get_xlim()), axes.get_ylim()
    paths.append((sides, np.full(2, stop), None))
    paths.append((sides * 1e-2, np.zeros(2), None))  # the mark of the origin
    if slope:
        low, high = np.clip(np.sort((sides - angle) / slope), low, high)
    if float(case.effective_inertia_plus) > 0:
        _name_sides(axes, angle, slope, (low, high), ("$N > 0$", "$N < 0$"), paths, size)
    else:
        _name_sides(axes, angle, slope, (max(low, stop), high), ("", "$N < 0$"), paths, size)
        _name_sides(axes, angle, slope, (low, min(high, stop)), ("$N > 0$", ""), paths, size)


def draw_arrows(axes: Axes, case: xr.Dataset, size: float = 10.0) -> None:
    """Draw an arrow of time on each motion of one case, and on its limit cycle.

    To be called when the panel has its limits.
    """
    angle, slope = float(case.contact_line_angle), float(case.contact_line_slope)
    rates = np.array(axes.get_ylim())
    drawing.draw_arrows(axes, [*_paths(case), (angle + slope * rates, rates, None)], size)


def _paths(case: xr.Dataset) -> list[drawing.DrawnLine]:
    """Return the motions and the limit cycle of one case as lines with colours, parted at their jumps."""
    paths: list[drawing.DrawnLine] = []
    for index, colour in zip(range(case.sizes["start"]), MOTIONS, strict=False):
        motion = case.isel(start=index)
        u, w, time = (motion[name].values for name in ("angle_deviation", "velocity_deviation", "time"))
        paths.append((*_parted(u, w, (np.diff(time) == 0) & (np.diff(w) != 0)), colour))
    u, w = (np.append(x, x[0]) for x in (case.cycle_angle.values, case.cycle_velocity.values))
    if np.isfinite(u).any():
        paths.append((*_parted(u, w, cycle_jumps(case)), style.BLACK))
    return paths


def _name_sides(axes: Axes, angle: float, slope: float, rates, words: tuple[str, str], paths, size: float) -> None:
    """Write words to the right and to the left of the line N = 0 between two rates, if it is in view there."""
    low, high = rates
    if high > low:
        ends = np.array([[angle + slope * low, low], [angle + slope * high, high]])
        drawing.name_sides(axes, ends, words, paths, 0.8 * size)


def mark_origin(axes: Axes) -> None:
    """Mark steady sliding, the origin."""
    axes.plot(0, 0, "+", color=style.BLACK, markersize=6, markeredgewidth=1.2, label="steady sliding", zorder=4)


def power(value: float) -> str:
    """Return a number for a text, a power of ten as such."""
    exponent = np.log10(value) if value else 0.0
    return f"$10^{{{exponent:.0f}}}$" if value and np.isclose(exponent, round(exponent)) else number(value)


def state_given(figure: Figure, dataset: xr.Dataset) -> None:
    """Write under a picture the parameters that were given for it."""
    given = [x for x in dataset.variables.values() if x.attrs.get("origin", "").startswith("given")]
    style.write_below(figure, style.enumeration("", [style.amount(xr.DataArray(x)) for x in given]))


def legend(figure: FigureBase, axes: Sequence[Axes], columns: int, first: Sequence[Artist] = ()) -> None:
    """Put one legend above the panels: the ``first`` artists, then what the panels name, each name once."""
    entries = {artist.get_label(): artist for artist in first}
    for panel in axes:
        for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=columns)


def widen(axes: Axes, case: xr.Dataset, margin: float = 0.06) -> None:
    """Set limits around the motions and the line θ′ = 0 of one case."""
    u, w = case.angle_deviation.values, np.append(case.velocity_deviation.values, float(case.stop_velocity))
    for limits, x in ((axes.set_xlim, u), (axes.set_ylim, w)):
        room = margin * np.ptp(x)
        limits(x.min() - room, x.max() + room)


def events(motion: xr.Dataset, word: str) -> xr.DataArray:
    """Return which events of a motion, or of several, are of the kind that a word names."""
    return motion.event_kind == code(motion.event_kind, word)


def code(variable: xr.DataArray, word: str) -> int:
    """Return the value of a flag variable that a word names."""
    return next(value for value, name in style.flag_names(variable).items() if name == word)
