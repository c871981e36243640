"""Pictures of a user's own answers: a motion, a sweep, cycles, one that was followed, a basin, a map.

A dataset says by its variables what it is, so a file draws itself as well as what was just computed.
"""

import json
import os
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.attributes import flag_names, named, quantity
from lsvib.answers.io import read_dataset
from lsvib.answers.phase_plane import curve, orbits
from lsvib.drives.drive import Drive
from lsvib.errors import InputError
from lsvib.numbers import shown
from lsvib.pictures import attraction, chart, drawing, friction_loop, phase_plane, style

KINDS = {"phase_plane": phase_plane.draw, "friction_loop": friction_loop.draw}  # of a motion, besides that over time
_STATE = "velocity_deviation"  # which every motion has
_CAN = "motions, sweeps of one or two parameters, cycles, branches, basins, and maps of u and w can"
_NUMBERS = "bfiu"  # kinds of types
_HEIGHT, _EDGE = 1.3, 0.6  # of a panel over time, and of what is around all of them [inch]
_MARKS = "x.os^vDP*"  # of what drives do, for readers in grey
_MARK = {"markersize": 3, "markeredgecolor": style.BLACK, "markeredgewidth": 0.3}


def draw(answer: Any, kind: str | None = None) -> style.Figure:
    """Draw what lsvib found, for a first look or a report.

    Arguments: the dataset of a motion, a sweep over one or two parameters, a map of starts; what ``cycles``,
    ``follow`` and ``basin`` of a drive return; or the path of a file that holds a dataset. ``kind``: of a motion
    ``phase_plane``, or ``friction_loop``, for which it has sliding_speed and friction_torque among its outputs.

    Returns a figure of matplotlib, 7.2 inches wide, which a notebook shows. Raises ``InputError`` for anything else.

    >>> motion = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10).simulate({"u": 0.1, "w": 0}, 0.1)
    >>> figure = lsvib.draw(motion)  # figure.savefig("motion.pdf") writes it
    >>> [axes.get_title("left") for axes in figure.axes][0]
    'Angular speed of the screw'

    See also: ``lsvib draw``, of a file in the shell.
    """
    if isinstance(answer, str | os.PathLike):
        answer = read_dataset(answer)
    return _drawn(answer if isinstance(answer, xr.Dataset) else _dataset(answer), kind)


def open(file: str | os.PathLike[str]) -> xr.Dataset:
    """Return the answer that a file holds, as the method that made it gives it; :func:`lsvib.draw` draws it.

    Raises ``InputError`` if the file is missing, or no readable netCDF file.

    See also: ``write_dataset`` of :mod:`lsvib.answers.io`, which writes one.
    """
    return read_dataset(file)


def _dataset(answer: Any) -> xr.Dataset:
    """The dataset of what a method of a drive returned, which has loaded the engine by then."""
    from lsvib.answers.cycles import Cycles, branch_dataset
    from lsvib.dynamics.boundary import Basin
    from lsvib.dynamics.cycles import Cycle
    from lsvib.systems import answers
    from lsvib.systems.continuation import CycleBranch

    if isinstance(answer, CycleBranch):
        return (branch_dataset if isinstance(answer.points[0].cycle, Cycle) else answers.branch_dataset)(answer)
    if isinstance(answer, answers.Ends) and answer.cycles:
        return answers.orbits(answer)
    steady = {name: ((), 0.0, quantity(name)) for name in ("angle_deviation", "velocity_deviation")}
    if isinstance(answer, Basin) and answer.curves:
        return xr.Dataset(steady | curve("boundary", "boundary_point", answer.line(), "on the exact boundary"))
    if isinstance(answer, Cycles) and answer.cycles:
        attracting = ("cycle", [cycle.attracting for cycle in answer.cycles])
        return xr.Dataset(steady | orbits([cycle.orbit for cycle in answer.cycles]) | {"attracting": attracting})
    empty = {Basin: "a basin without a boundary", Cycles: "what has no cycle", answers.Ends: "what has no cycle"}
    raise InputError(f"{empty.get(type(answer), shown(answer))} cannot be drawn; {_CAN}.")


@style.styled
def _drawn(dataset: xr.Dataset, kind: str | None) -> style.Figure:
    """Draw a dataset, which may come from anywhere: what it lacks shows where it is asked for."""
    try:
        figure = _picture(dataset, kind)
        figure.draw_without_rendering()  # whether a symbol is a formula shows here
    except InputError:
        raise
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        reason = str(error.args[0] if error.args else error).strip().rpartition("\n")[2].partition(". ")[0]
        reason += " is missing" if isinstance(error, KeyError) and " " not in reason else ""
        raise InputError(f"the dataset is not as lsvib makes it, so it cannot be drawn: {reason}.") from error
    return figure


def _picture(dataset: xr.Dataset, kind: str | None) -> style.Figure:
    motion = "event_kind" in dataset and _STATE in dataset and dataset[_STATE].dims == ("time",)
    if kind is not None and not (motion and kind in KINDS):
        raise InputError(f"{shown(kind)} cannot be drawn of this; of a motion {' and '.join(KINDS)} can.")
    if motion:
        return KINDS.get(kind or "", _motion)(dataset)
    if "attracting" in dataset and "changes" in dataset.attrs:
        return _branch(dataset)
    own = "system" in dataset.attrs  # one's own
    if own and "label" not in dataset:
        return _states(dataset)
    if not own and {"label", "cycle_angle", "boundary_angle"} & set(dataset):
        return attraction.draw(dataset)
    swept = tuple(name for name in dataset.dims if name in Drive.model_fields)
    if own:
        swept = tuple(map(str, dataset["label"].dims))
    numbers = [name for name, x in dataset.data_vars.items() if x.dims == swept and x.dtype.kind in _NUMBERS]
    if not {"attractor", "label"} & {*numbers} or len(swept) not in (1, 2):
        raise InputError(f"a dataset over {', '.join(map(str, dataset.dims)) or 'nothing'} cannot be drawn; {_CAN}.")
    return _curves(dataset[numbers]) if len(swept) == 1 else chart.draw(dataset)


def _motion(dataset: xr.Dataset) -> style.Figure:
    """A panel for the speed of the screw, and for each quantity that is stored besides the state."""
    time, rate = dataset.time, dataset[_STATE]
    turning = float(dataset["input_speed"])
    speed = dataset["screw_speed"] if "screw_speed" in dataset else (rate + turning).assign_attrs(
        long_name="angular speed of the screw", symbol=r"$\dot\theta$", units="rad s-1"
    )  # fmt: skip
    left_out = {"screw_speed", "commanded_speed", "mode", _STATE}
    stored = [x for x in dataset.data_vars.values() if x.dims == ("time",) and x.dtype.kind in _NUMBERS]
    others = [x for x in stored if x.name not in left_out]
    figure = style.new_figure(style.DOUBLE, _EDGE + _HEIGHT * (1 + len(others)))
    panels = figure.subplots(1 + len(others), 1, sharex=True, squeeze=False)[:, 0]
    command = dataset["commanded_speed"] if "commanded_speed" in dataset else xr.full_like(time, turning)
    panels[0].plot(time, command, **style.PRINTED, label="command")
    rests = drawing.rests(dataset["mode"])
    for axes, values in zip(panels, [speed, *others], strict=True):
        axes.plot(time, values, color=style.BLUE)
        axes.set_xlim(time[0], time[-1])
        _name(axes, values)
        if rests.any():
            axes.fill_between(
                time, 0, 1, where=rests, transform=axes.get_xaxis_transform(), step="post", color=style.GREEN,
                alpha=0.15, linewidth=0, label="rest",
            )  # fmt: skip
    seized = dataset.event_time.values[named(dataset.event_kind, "seizure")]
    if seized.size:
        panels[0].plot(seized, np.zeros(seized.size), "v", color=style.VERMILION, markersize=3.2, label="seizure")
    panels[-1].set_xlabel(style.label(time))
    figure.align_ylabels(panels)
    return style.legend(figure, panels[:1], 3)


def _states(dataset: xr.Dataset) -> style.Figure:
    """Each state of a system over time, with its events; or its cycles in the plane of the first two."""
    names = json.loads(dataset.attrs["system"])["states"]
    if "cycle" in dataset.dims:
        figure, pair = style.new_figure(style.SINGLE, 3.3), (names * 2)[:2]
        for one in dataset.cycle.values:
            axes = figure.axes[0] if figure.axes else figure.add_subplot()
            axes.plot(*(dataset[name].sel(cycle=one) for name in pair), label=f"cycle {one}")
        style.frame(axes, "", *(dataset[name] for name in pair))
        return style.legend(figure, [axes], 3)
    figure = style.new_figure(style.DOUBLE, _EDGE + _HEIGHT * len(names))
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    own = ~named(dataset.event_kind, *(x for x in flag_names(dataset.event_kind).values() if x.startswith("phase ")))
    for axes, name in zip(panels, names, strict=True):
        axes.plot(dataset.time, dataset[name], color=style.BLUE)
        axes.plot(
            dataset.event_time[own], dataset[f"event_{name}_after"][own], ".", color=style.VERMILION, label="event"
        )
        axes.set_xlim(dataset.time[0], dataset.time[-1])
        _name(axes, dataset[name])
    panels[-1].set_xlabel(style.label(dataset.time))
    return style.legend(figure, panels[:1], 3)


def _name(axes: style.Axes, values: xr.DataArray) -> None:
    """Put the words of a quantity above a panel, its symbol and unit beside it."""
    words, symbol = values.attrs.get("long_name", str(values.name)), values.attrs.get("symbol", "")
    axes.set_title(words[:1].upper() + words[1:], fontweight="normal", wrap=True)
    axes.set_ylabel(f"{symbol} {style.unit(values.attrs.get('units', '1'))}".strip())


def _curves(dataset: xr.Dataset) -> style.Figure:
    """Each number over one parameter, in colours and marks of what the drive does."""
    (along,), kinds = dataset.dims, chart.kinds(dataset)
    looks = chart.looks(kinds)
    left_out = ("attractor", "behaviour", "label", "turns")
    numbers = [x for name, x in dataset.data_vars.items() if name not in left_out and np.isfinite(x).any()]
    figure = style.new_figure(style.DOUBLE, _EDGE + _HEIGHT * len(numbers))
    panels = figure.subplots(len(numbers), 1, sharex=True, squeeze=False)[:, 0]
    for axes, values in zip(panels, numbers, strict=True):
        for name, mark in zip(flag_names(kinds).values(), _MARKS, strict=False):
            here, (colour, words) = named(kinds, name), looks[name]
            if here.any():
                axes.plot(dataset[along][here], values[here], mark, color=colour, label=words, **_MARK)
        _name(axes, values)
    panels[-1].set_xlabel(style.label(dataset[along]))
    figure.align_ylabels(panels)
    return style.legend(figure, panels[:1], 4)


def _branch(dataset: xr.Dataset) -> style.Figure:
    """Amplitude and period of a cycle along its branch, attracting or not, with what changes on it."""
    figure = style.new_figure(style.DOUBLE, 3.0)
    parameter = next(iter(dataset.data_vars))
    value, attracts = dataset[parameter], dataset.attracting.values.astype(bool)
    changes = json.loads(dataset.attrs["changes"])
    panels = figure.subplots(1, 2)
    for axes, name in zip(panels, ("amplitude", "period"), strict=True):
        here = dataset[name].values
        for mask, look, words in ((attracts, "-", "attracts"), (~attracts, "--", "does not attract")):
            # a point of either kind also ends the line of the other, so that no gap is left between them
            near = mask | np.append(mask[1:], False) if look == "--" else mask
            axes.plot(value, np.where(near, here, np.nan), look, color=style.BLUE, label=words)
        for change in changes:
            nearest = int(np.argmin(np.abs(value.values - change["value"])))
            axes.plot(change["value"], here[nearest], "o", color=style.VERMILION, markersize=3, label="change")
        axes.set_xlabel(style.label(value), labelpad=14)
        _name(axes, dataset[name])
    return style.legend(figure, panels[:1], 3)
