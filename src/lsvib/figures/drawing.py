"""Draw phase planes from the variables of ``lsvib.datasets.phase_plane``: one case, a few motions, lines and marks.

Arrows of time and words beside a line stand where the picture has room for them. Distances for that are those of the
printed page, in points, of a panel as large as it is when the functions are called.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from lsvib.figures import style
from lsvib.figures.common import flag_names, named

STEP = 1.5  # distance of the points that are compared [pt]
_PLACES = 150  # places compared on one line

MOTIONS = (style.BLUE, style.ORANGE, style.SKY, style.PURPLE)
EVEN = (1.1, 1.1, 1.1, 1.1)  # widths of the lines of up to four motions, in points
DrawnLine = tuple[np.ndarray, np.ndarray, str | None]


def single(dataset: xr.Dataset) -> style.Figure:
    """Return a figure of the only case of a dataset."""
    figure = style.new_figure(style.SINGLE * 1.25, 3.4)
    axes, case = figure.add_subplot(), dataset.isel(case=0)
    phase_plane(axes, case)
    draw_lines(axes, case)
    guide(axes, case)
    label_axes(axes, dataset)
    axes.set_title(f"$R$ = {style.number(case.axial_force)} N")
    return style.finished(figure, dataset, [axes], 3)


def phase_plane(
    axes: style.Axes, case: xr.Dataset, widths: Sequence[float] = EVEN, cycle: float = 1.8, margin: float = 0.06
) -> None:
    """Draw motions, limit cycle and origin of one case, with limits around the motions and the line θ′ = 0.

    ``widths`` of the motions and the cycle in points; ``margin`` beyond the motions, in their extent.
    """
    draw_motions(axes, case, widths)
    draw_cycle(axes, case, width=cycle)
    mark_origin(axes)
    u, w = case.angle_deviation.values, np.append(case.velocity_deviation.values, float(case.stop_velocity))
    for limits, x in ((axes.set_xlim, u), (axes.set_ylim, w)):
        limits(x.min() - margin * np.ptp(x), x.max() + margin * np.ptp(x))


def label_axes(axes: style.Axes, dataset: xr.Dataset) -> None:
    """Label both axes with u and its rate."""
    axes.set_xlabel(style.label(dataset.angle_deviation, "deviation"))
    axes.set_ylabel(style.label(dataset.velocity_deviation, "rate"))


def draw_lines(axes: style.Axes, case: xr.Dataset, colour: str = style.VERMILION, name: str = "$N = 0$") -> None:
    """Draw the line N = 0 of one case and θ′ = 0, without any change of the axes' limits."""
    limits = axes.axis()
    angle, slope = float(case.contact_line_angle), float(case.contact_line_slope)
    rates = np.array(limits[2:])
    axes.plot(angle + slope * rates, rates, color=colour, linestyle=(0, (5, 2)), linewidth=1.0, label=name, zorder=1.5)
    draw_stop(axes, float(case.stop_velocity))
    axes.axis(limits)


def draw_stop(axes: style.Axes, rate: float) -> None:
    """Draw the line θ′ = 0, at this rate of the deviation."""
    axes.axhline(rate, color=style.GREY, linestyle=(0, (6, 2, 1, 2)), linewidth=1.0, label=r"$\dot\theta = 0$",
                 zorder=1.4)  # fmt: skip


def draw_motions(axes: style.Axes, case: xr.Dataset, widths: Sequence[float] = EVEN) -> None:
    """Draw the motions of one case: jumps dotted, rest thick, starts and seizures marked."""
    for (motion, u, w, jumps, colour), width in zip(_motions(case), widths, strict=False):
        _broken_line(axes, u, w, jumps, colour, width, "motion")
        rests, seized = named(motion["mode"], "rest"), named(motion.event_kind, "seizure")
        if rests.any():
            still = np.where(rests, u, np.nan), np.where(rests, w, np.nan)
            axes.plot(*still, color=style.GREEN, linewidth=3, solid_capstyle="butt", label="rest", zorder=2.5)
        if seized.any():
            before = (motion[f"event_{name}_deviation_before"].values[seized] for name in ("angle", "velocity"))
            mark_seizures(axes, *before, colour)
        axes.plot(u[0], w[0], "o", color=colour, markerfacecolor="white", label="start", zorder=3)


def _motions(case: xr.Dataset) -> Iterator[tuple[xr.Dataset, np.ndarray, np.ndarray, np.ndarray, str]]:
    """Each motion with u, u′, whether the rate jumps after each sample, and a colour."""
    for index, colour in zip(range(case.sizes["start"]), MOTIONS, strict=False):
        motion = case.isel(start=index)
        u, w, time = (motion[name].values for name in ("angle_deviation", "velocity_deviation", "time"))
        yield motion, u, w, (np.diff(time) == 0) & (np.diff(w) != 0), colour


def draw_cycle(
    axes: style.Axes, case: xr.Dataset, colour: str = style.BLACK, width: float = 1.8, name: str = "limit cycle"
) -> None:
    """Draw the limit cycle of one case, if it has one, its jumps dotted."""
    u, w, jumps = cycle_of(case)
    if np.isfinite(u).any():
        _broken_line(axes, u, w, jumps, colour, width, name)


def cycle_of(case: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return u and u′ of a limit cycle, closed, and for each sample whether the rate jumps before the next."""
    u, w = (np.append(x, x[0]) for x in (case.cycle_angle.values, case.cycle_velocity.values))
    return u, w, (np.abs(np.diff(u)) < 1e-9 * np.ptp(u)) & (np.abs(np.diff(w)) > 0.05 * np.ptp(w))


def mark_seizures(axes: style.Axes, u, w, colour: str) -> None:
    """Mark states in which a seizure starts."""
    axes.plot(u, w, "v", color=colour, markersize=3.2, label="start of a seizure", zorder=3)


def _broken_line(axes: style.Axes, u, w, jumps, colour: str, width: float, name: str) -> None:
    """Draw a line that is solid but for its jumps, which are dotted."""
    axes.plot(*parted(u, w, jumps), color=colour, linewidth=width, label=name, zorder=2.2)
    for k in np.flatnonzero(jumps):
        axes.plot(u[k : k + 2], w[k : k + 2], color=colour, linewidth=1, linestyle=(0, (1, 1.2)),
                  label="seizure: jump of the rate")  # fmt: skip


def parted(u: np.ndarray, w: np.ndarray, jumps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return u and w with NaN at the jumps."""
    after = np.flatnonzero(jumps) + 1
    return np.insert(u, after, np.nan), np.insert(w, after, np.nan)


def guide(axes: style.Axes, case: xr.Dataset, size: float = 10.0) -> None:
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
    spans = [(low, high, ("$N > 0$", "$N < 0$"))]
    if float(case.effective_inertia_plus) < 0:
        spans = [(max(low, stop), high, ("", "$N < 0$")), (low, min(high, stop), ("$N > 0$", ""))]
    for first, last, words in spans:
        if last > first:  # in view
            ends = np.array([[angle + slope * rate, rate] for rate in (first, last)])
            name_sides(axes, ends, words, paths, 0.8 * size)


def draw_arrows(axes: style.Axes, case: xr.Dataset, size: float = 10.0) -> None:
    """Draw an arrow of time on each motion of one case, and on its limit cycle.

    To be called when the panel has its limits.
    """
    angle, slope = float(case.contact_line_angle), float(case.contact_line_slope)
    rates = np.array(axes.get_ylim())
    arrows(axes, [*_paths(case), (angle + slope * rates, rates, None)], size)


def _paths(case: xr.Dataset) -> list[DrawnLine]:
    """Return the motions and the limit cycle of one case as lines with colours, parted at their jumps."""
    u, w, jumps = cycle_of(case)
    cycle = [(*parted(u, w, jumps), style.BLACK)] if np.isfinite(u).any() else []
    return [*((*parted(u, w, jumps), colour) for _, u, w, jumps, colour in _motions(case)), *cycle]


def mark_origin(axes: style.Axes) -> None:
    """Mark steady sliding, the origin."""
    axes.plot(0, 0, "+", color=style.BLACK, markersize=6, markeredgewidth=1.2, label="steady sliding", zorder=4)


def regions(axes: style.Axes, x: Any, y: Any, flags: xr.DataArray, colours: Mapping[str, str], **look: Any) -> None:
    """Paint the cells of a map over x and y, each in the colour of the word that its flag (y, x) means."""
    from matplotlib.colors import BoundaryNorm, ListedColormap

    names = dict(sorted(flag_names(flags).items()))
    bounds = np.array([*names, max(names) + 1]) - 0.5
    axes.pcolormesh(x, y, flags, cmap=ListedColormap([colours[name] for name in names.values()]),
                    norm=BoundaryNorm(bounds, len(names)), rasterized=True, **look)  # fmt: skip


def hatched(
    axes: style.Axes, x: Any, y: Any, inside: Any, hatch: str, edge: str, colours: Any = "none", **look: Any
) -> None:
    """Hatch the region of a map (y, x) where ``inside`` is 1."""
    area = axes.contourf(x, y, inside, levels=[0.5, 1.5], colors=colours, hatches=[hatch], **look)
    area.set(edgecolor=edge, linewidth=0)


def arrows(axes: style.Axes, lines: Sequence[DrawnLine], size: float = 10.0) -> None:
    """Draw one arrow on each line, in the direction of its points and within the limits that the panel has now.

    A line is x, y, both of shape (n) and with NaN where it is broken, and a colour; one without a colour gets no arrow
    but is kept clear of. ``size`` of the arrows in points.
    """
    page = _Page(axes)
    paths = [evenly(page.points(x, y)) for x, y, _ in lines]
    for number, (path, (_, _, colour)) in enumerate(zip(paths, lines, strict=True)):
        if colour is None:
            continue
        place = _roomiest(path, [other[:, :2] for k, other in enumerate(paths) if k != number], page.size)
        if place is not None:
            tail, head = (page.data(path[k, :2]) for k in (place - 1, place))
            look = {"color": colour, "linewidth": 0, "mutation_scale": size, "shrinkA": 0, "shrinkB": 0}
            axes.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", **look}, zorder=3.2)


def name_sides(
    axes: style.Axes, ends: np.ndarray, words: tuple[str, str], lines: Sequence[DrawnLine], size: float = 8.0
) -> None:
    """Write a word on each side of a straight line, to its right and to its left as seen along the line.

    ``ends``: both ends (2, 2) of the line in the limits that the panel has now; ``lines``: what the words keep clear
    of, as in :func:`arrows`; ``size`` of the letters in points. A word that is empty is left out.
    """
    page = _Page(axes)
    first, last = page.points(*ends.T)
    normal = np.array([last[1] - first[1], first[0] - last[0]]) / np.hypot(*(last - first))
    clouds = np.concatenate([evenly(page.points(x, y))[:, :2] for x, y, _ in [(*ends.T, None), *lines]])
    half, asides = np.array([2.0, 0.8]) * size, (1.2, 1.6, 2.0, 2.5, 3.0, 4.0)  # of a word's middle, in letters
    for word, side in zip(words, (1, -1), strict=True):
        along = first + np.linspace(0.05, 0.95, _PLACES)[:, None] * (last - first)
        spots = np.concatenate([along + side * aside * size * normal for aside in asides])
        spots = spots[((spots > 1.1 * half) & (spots < page.size - 1.1 * half)).all(axis=1)]
        if word and spots.size:
            room = [np.abs((clouds - spot) / half).max(axis=1).min(initial=1.3) for spot in spots]
            place = page.data(spots[int(np.argmax(room))])
            patch = {"facecolor": "#FFFFFFD0", "linewidth": 0, "pad": 0.8}
            axes.text(*place, word, ha="center", va="center", bbox=patch, fontsize=size, zorder=4)


class _Page:
    """The panel on the page: points [pt] from its lower left corner, and back to data."""

    def __init__(self, axes: style.Axes) -> None:
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        self.corner, self.sides = np.array([left, low]), np.array([right - left, high - low])
        self.size = np.array([axes.bbox.width, axes.bbox.height]) * 72 / axes.figure.dpi

    def points(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the points (n, 2) of data x and y, each of shape (n)."""
        return (np.column_stack([x, y]) - self.corner) / self.sides * self.size

    def data(self, point: np.ndarray) -> np.ndarray:
        """Return the data (2) of a point (2)."""
        return self.corner + self.sides * point / self.size


def evenly(path: np.ndarray) -> np.ndarray:
    """Return points in even steps along a line (n, 2), each with its distance from the line's start: shape (m, 3)."""
    pieces, length = [np.empty((0, 3))], 0.0
    for piece in np.split(path, np.flatnonzero(np.isnan(path).any(axis=1))):
        piece = piece[np.isfinite(piece).all(axis=1)]
        if len(piece) > 1:
            ends = np.append(0.0, np.cumsum(np.hypot(*np.diff(piece, axis=0).T)))
            s = np.arange(0.0, ends[-1], STEP)
            pieces.append(np.column_stack([*(np.interp(s, ends, z) for z in piece.T), s + length]))
            length += ends[-1] + STEP
    return np.concatenate(pieces)


def _roomiest(path: np.ndarray, others: Sequence[np.ndarray], size: np.ndarray) -> int | None:
    """Return the first point of a path with room around it, else the one with most; none if no point is in view."""
    # Not on the rim, and not at the start, which has a mark [pt].
    inside = ((path[:, :2] > 3.0) & (path[:, :2] < size - 3.0)).all(axis=1)
    inside &= path[:, 2] > np.minimum(14.0, path[-1:, 2] / 3)
    # The point before, at which the arrow starts, lies on the same piece: pieces are more than a step apart.
    inside &= np.append(False, np.diff(path[:, 2]) < 1.001 * STEP)
    found = np.flatnonzero(inside)
    if not found.size:
        return None
    found = found[:: -(-found.size // _PLACES)]
    room = np.full(found.size, 9.0)  # enough [pt]
    for k, point in enumerate(found):
        x, y, s = path[point]
        own = path[np.abs(path[:, 2] - s) > 18.0, :2]  # its own line around an arrow is no other line
        for cloud in (own, *others):
            if cloud.size:
                room[k] = min(room[k], np.hypot(*(cloud - (x, y)).T).min())
    return int(found[np.argmax(room)])
