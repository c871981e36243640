"""Draw phase planes from the variables of ``lsvib.answers.phase_plane``: one case, a few motions, lines and marks."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.attributes import flag_names, named
from lsvib.pictures import style

MOTIONS = (style.BLUE, style.ORANGE, style.SKY, style.PURPLE)
_ARROW = 10.0  # size of the arrows of time, in points
EVEN = (1.1, 1.1, 1.1, 1.1)  # widths of the lines of up to four motions, in points
DrawnLine = tuple[np.ndarray, np.ndarray, str]  # x, y, both of shape (n) and with NaN where it is broken, and colour


def single(dataset: xr.Dataset) -> style.Figure:
    """Draw the only case of a dataset."""
    figure = style.new_figure(style.SINGLE, 3.2)
    axes, case = figure.add_subplot(), dataset.isel(case=0)
    phase_plane(axes, case)
    draw_lines(axes, case)
    label_axes(axes, dataset, f"$R$ = {style.number(case.axial_force)} N")
    return guide(style.legend(figure, [axes], 3), [axes], [case])


def phase_plane(axes: style.Axes, case: xr.Dataset, widths: Sequence[float] = EVEN, margin: float = 0.06) -> None:
    """Draw motions, limit cycle and origin of one case, with limits around the motions and the line θ′ = 0.

    ``widths`` of the motions in points; ``margin`` beyond the motions, in their extent.
    """
    draw_motions(axes, case, widths)
    draw_cycle(axes, case)
    mark_origin(axes)
    axes.update_datalim([(0.0, float(case.stop_velocity))])
    axes.margins(margin)


def label_axes(axes: style.Axes, dataset: xr.Dataset, title: str | None = None) -> None:
    """Label both axes with u and its rate, and give the panel a ``title``, if it has none."""
    deviation, rate = dataset.u, dataset.w
    style.frame(axes, title or axes.get_title("left"), style.label(deviation, "deviation"), style.label(rate, "rate"))


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
        still_at, seized = rests(motion["mode"]), named(motion.event_kind, "seizure")
        if still_at.any():
            still = np.where(still_at, u, np.nan), np.where(still_at, w, np.nan)
            axes.plot(*still, color=style.GREEN, linewidth=3, solid_capstyle="butt", label="rest", zorder=2.5)
        if seized.any():
            before = [motion[f"event_{name}_before"].values[seized] for name in ("u", "w")]
            mark_seizures(axes, before[0], before[1], colour)
        size = 6 if (seized & (motion.event_time.values == 0)).any() else 4  # around the triangle of a seizure
        axes.plot(u[0], w[0], "o", color=colour, mfc="white", markersize=size, label="start", zorder=4.5)


def with_events(dataset: xr.Dataset, begin: bool = True) -> xr.Dataset:
    """Return a motion over ``sample``: its samples, and what it was just before and after each event between them.

    ``begin``: also events at its start, before which no motion leads to such a state.
    """
    dataset = dataset if begin else dataset.isel(event=dataset.event_time.values > 0)
    mode, after = dataset["mode"], dataset.event_mode.values
    before = np.append(mode[:1], after)[: after.size]
    ends: dict[Any, list[Any]] = {"mode": [before, after], "time": 2 * [dataset.event_time]}
    for name, own in dataset.data_vars.items():
        if own.dims == ("time",) and own.dtype.kind in "fiu" and name not in ends:
            between = np.interp(dataset.event_time, dataset.time, own)  # of what is not known at events
            ends[name] = [dataset.get(f"event_{name}_{when}", between) for when in ("before", "after")]
    points = {name: np.append(np.stack(own, axis=1), dataset[name]) for name, own in ends.items()}
    order = np.argsort(points["time"], kind="stable")  # a sample at the time of an event is one after it
    events = dataset[[name for name, own in dataset.data_vars.items() if own.dims == ("event",)]]
    found = events.assign({name: ("sample", x[order], dataset[name].attrs) for name, x in points.items()})
    if (each := dataset.sizes["time"] / max(order.size - dataset.sizes["time"], 1)) < 4:
        found.time.attrs["long_name"] += f" ({2 * each:.2g} samples between events, so peaks are cut off)"
    return found


def rests(mode: xr.DataArray) -> np.ndarray:
    """Return where the threads rest, by the modes of a motion."""
    return named(mode, *(word for word in flag_names(mode).values() if word.startswith("rest")))


def _motions(case: xr.Dataset) -> Iterator[tuple[xr.Dataset, np.ndarray, np.ndarray, np.ndarray, str]]:
    """Each motion with u, u′, whether the rate jumps after each sample, and a colour."""
    for index, colour in zip(range(case.sizes["start"]), MOTIONS, strict=False):
        motion = case.isel(start=index)
        u, w, time = (motion[name].values for name in ("u", "w", "time"))
        yield motion, u, w, (np.diff(time) == 0) & (np.diff(w) != 0), colour


def draw_cycle(
    axes: style.Axes, case: xr.Dataset, colour: str = style.BLACK, width: float = 1.8, name: str = "limit cycle"
) -> None:
    """Draw the limit cycle of one case, if it has one, its jumps dotted and their starts marked."""
    if "cycle_u" in case and np.isfinite(case.cycle_u).any():
        u, w, jumps = cycle_of(case)
        _broken_line(axes, u, w, jumps, colour, width, name)
        if jumps.any():
            mark_seizures(axes, u[:-1][jumps], w[:-1][jumps], colour)


def cycle_of(case: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return u and u′ of a limit cycle, closed, and for each sample whether the rate jumps before the next."""
    u, w = (np.append(x, x[0]) for x in (case.cycle_u.values, case.cycle_w.values))
    return u, w, (np.abs(np.diff(u)) < 1e-9 * np.ptp(u)) & (np.abs(np.diff(w)) > 0.05 * np.ptp(w))


def mark_seizures(axes: style.Axes, u: np.ndarray, w: np.ndarray, colour: str) -> None:
    """Mark states in which a seizure starts."""
    axes.plot(u, w, "v", color=colour, markersize=3.2, label="start of a seizure", zorder=5)


def _broken_line(
    axes: style.Axes, u: np.ndarray, w: np.ndarray, jumps: np.ndarray, colour: str, width: float, name: str
) -> None:
    """Draw a line that is solid but for its jumps, which are dotted."""
    axes.plot(*parted(u, w, jumps), color=colour, linewidth=width, label=name, zorder=2.2)
    ends = [np.array([x[:-1][jumps], x[1:][jumps]]) for x in (u, w)]
    axes.plot(*ends, color=colour, linewidth=1, linestyle=(0, (1, 1.2)), label="seizure: jump of the rate")


def parted(u: np.ndarray, w: np.ndarray, jumps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return u and w with NaN at the jumps."""
    after = np.flatnonzero(jumps) + 1
    return np.insert(u, after, np.nan), np.insert(w, after, np.nan)


def guide(figure: style.Figure, panels: Iterable[style.Axes], cases: Iterable[xr.Dataset]) -> style.Figure:
    """Name the sides of the line N = 0 of each panel's case, and draw the arrows of :func:`draw_arrows`.

    To be called when all is drawn. N = Q / [Γ_s (cos λ + s μ sin λ)] (8.17), and Q grows with u: N > 0 to the right
    where Γ₊ > 0. Where Γ₊ < 0 a motion follows law −, for which N θ′ < 0, and beyond the line there is no solution.
    """
    style.laid_out(figure)
    for axes, case in zip(panels, cases, strict=True):
        draw_arrows(axes, case)
        angle, slope, stop = (float(case[x]) for x in ("contact_line_angle", "contact_line_slope", "stop_velocity"))
        width, (low, high) = np.ptp(axes.get_xlim()), axes.get_ylim()
        names = [("$N > 0$", 1, low, high), ("$N < 0$", -1, low, high)]
        if float(case.effective_inertia_plus) < 0:
            names = [("$N > 0$", 1, low, stop), ("$N < 0$", -1, stop, high)]
            names += [("no solution", 1, stop, high), ("no solution", -1, low, stop)]
        for word, side, first, last in names:
            places = product(np.linspace(0.02, 0.6, 13) * side * width, np.linspace(last, first, 42)[1:-1])
            beside = ((angle + slope * rate + away, rate, 0.0) for away, rate in places)
            write(axes, word, beside, ha="left" if side > 0 else "right", va="center", zorder=4)
    return figure


def write(axes: style.Axes, words: str, places: Iterable[tuple[float, float, float]], **look: Any) -> bool:
    """Write words at the first place in a panel, x, y and an angle, that is clear of its lines, marks and words.

    Returns whether there is such a place. To be called when the figure is laid out.
    """
    text = axes.text(0, 0, words, rotation_mode="anchor", **look)
    taken = [line.get_transform().transform_path(line.get_path()) for line in axes.lines]
    marks = [path for line, path in zip(axes.lines, taken, strict=True) if line.get_marker() != "None"]
    taken += [outline(other) for other in axes.texts[:-1] if other.get_text()]
    room = axes.bbox.padded(-axes.figure.dpi / 20)  # clear of the ticks
    for x, y, angle in places:
        text.set(x=x, y=y, rotation=angle)
        around, own = outline(text, 5), outline(text)
        covers = (own.intersects_path(path, filled=False) or own.contains_points(path.vertices).any() for path in taken)
        beside = (around.contains_points(path.vertices).any() for path in marks)
        if all(room.contains(*corner) for corner in own.vertices) and not any((*covers, *beside)):
            return True
    text.remove()
    return False


def outline(text: Any, pad: float = 1.5) -> Any:
    """Return the rectangle [pixels] in which words stand, turned as they are, so many points wider on each side."""
    text.set_bbox({"pad": pad, "visible": False})
    text.update_bbox_position_size(text.figure.canvas.get_renderer())
    return text.get_bbox_patch().get_transform().transform_path(text.get_bbox_patch().get_path())


def draw_arrows(axes: style.Axes, case: xr.Dataset) -> None:
    """Draw an arrow of time on each motion of one case, and on its limit cycle, by :func:`arrows`."""
    lines = [(*parted(u, w, jumps), colour) for _, u, w, jumps, colour in _motions(case)]
    if "cycle_u" in case:
        lines.append((*parted(*cycle_of(case)), style.BLACK))
    arrows(axes, lines)


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
    axes: style.Axes, x: Any, y: Any, inside: Any, hatch: str | None, edge: str, colours: Any = "none", **look: Any
) -> None:
    """Hatch the region of a map (y, x) where ``inside`` is 1."""
    area = axes.contourf(x, y, inside, levels=[0.5, 1.5], colors=colours, hatches=[hatch], **look)
    area.set(edgecolor=edge, linewidth=0)


def patches(looks: Iterable[tuple[str, str | None, str]], edge: str) -> list[Any]:
    """Return an entry of a legend for each kind of region: its colour, its hatch or None, and its words."""
    from matplotlib.patches import Patch

    look: dict[str, Any] = {"edgecolor": edge, "linewidth": 0.5}
    return [Patch(facecolor=colour, hatch=hatch, label=words, **look) for colour, hatch, words in looks]


def arrows(axes: style.Axes, lines: Sequence[DrawnLine]) -> None:
    """Draw an arrow on each line that is in view, six times its size from the line's start or half way.

    It points in the direction of the line's points. To be called when the panel has its limits.
    """
    for x, y, colour in lines:
        path = axes.transData.transform(np.column_stack([x, y]))
        seen: np.ndarray = np.all((path > axes.bbox.min) & (path < axes.bbox.max), axis=1)
        steps = np.where(seen[1:] & seen[:-1], np.hypot(*np.diff(path, axis=0).T), 0.0)
        if not steps.any():
            continue
        way = np.append(0.0, np.cumsum(steps))
        last = int(np.searchsorted(way, min(_ARROW * axes.figure.dpi / 12, way[-1] / 2)))
        look = dict[str, Any](arrowstyle="-|>", color=colour, linewidth=0, mutation_scale=_ARROW, shrinkA=0, shrinkB=0)
        axes.annotate("", (x[last], y[last]), (x[last - 1], y[last - 1]), arrowprops=look, zorder=3.2)
