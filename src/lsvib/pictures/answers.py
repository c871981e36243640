"""Pictures of a user's own answers: a motion, a sweep, cycles, a branch of cycles, a basin, a map.

The variables of a dataset tell what it is, so a file is drawn like what was just computed.
"""

import json
import os
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.attributes import flag_names, named, quantity, variable
from lsvib.answers.io import read_dataset
from lsvib.answers.phase_plane import curve, lines, orbits
from lsvib.drives.drive import Drive
from lsvib.errors import InputError
from lsvib.numbers import shown
from lsvib.pictures import attraction, chart, drawing, style

_CAN = "motions, sweeps of one or two parameters, cycles, branches, basins, and maps of u and w can"
_NUMBERS = "bfiu"  # kinds of types
_HEIGHT, _EDGE = 1.3, 0.6  # of a panel over time, and of what is around all of them [inch]
_MARKS = "X.os^vDP*"  # of what drives do, for readers in grey
_CHANGES = {"fold": "o", "period doubling": "s", "Neimark–Sacker": "D", "grazing": "v", "border collision": "^"}
_CHANGES |= {"crossing-sliding": "<", "grazing-sliding": ">", "switching-sliding": "d", "adding-sliding": "P"}
_PLAIN = {"fontweight": "normal", "wrap": True}  # title of a panel
_MARK = dict[str, Any](markersize=3, markeredgecolor=style.BLACK, markeredgewidth=0.3)


def draw(answer: Any, kind: str | None = None) -> style.Figure:
    """Draw an answer of lsvib.

    Arguments: ``answer``, the dataset of a motion, of a sweep over one or two parameters or of a map of starts; what
    ``cycles``, ``follow`` and ``basin`` return; or the path of a file with a dataset. ``kind``, for a motion only:
    ``phase_plane``, or ``friction_loop``, which needs sliding_speed and friction_torque among its outputs. Returns a
    matplotlib figure, 7.2 or 3.5 inches wide, which a notebook shows. Raises ``InputError`` for anything else. See also
    ``lsvib draw``, of a file in the shell.

    >>> motion = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10).simulate({"u": 0.1, "w": 0}, 0.1)
    >>> figure = lsvib.draw(motion)  # figure.savefig("motion.pdf") writes it
    >>> figure.axes[0].get_title("left")[:26]
    'Angular speed of the screw'
    """
    if isinstance(answer, str | os.PathLike):
        answer = read_dataset(answer)
    return _drawn(answer if isinstance(answer, xr.Dataset) else _dataset(answer), kind)


def open(file: str | os.PathLike[str]) -> xr.Dataset:
    """Return the dataset in a netCDF file of lsvib, with its units, as the method that made it returned it.

    Raises ``InputError`` if the file is missing or not a readable netCDF file. See also :func:`lsvib.draw`.

    >>> motion = lsvib.Drive(mass=11).simulate({"u": 0.1, "w": 0}, 0.1)
    >>> motion.to_netcdf("motion.nc")
    >>> lsvib.open("motion.nc").identical(motion)
    True
    """
    return read_dataset(file)


def _dataset(answer: Any) -> xr.Dataset:
    """The dataset of what a method of a drive returned, which has loaded the engine by then."""
    from lsvib.answers.cycles import Cycles, branch_dataset
    from lsvib.dynamics.boundary import Basin
    from lsvib.systems import End
    from lsvib.systems.continuation import CycleBranch

    if isinstance(answer, CycleBranch):
        return branch_dataset(answer)
    answer = [answer] if isinstance(answer, End) else answer
    if isinstance(answer, list) and (ends := [one for one in answer if isinstance(one, End) and one.cycle]):
        names, dims = [*ends[0].state], ("cycle", "sample")
        states = np.array([one.cycle.orbit.at(np.linspace(0.0, one.period, 4001))[0] for one in ends if one.cycle])
        data = {name: variable(dims, states[..., k], "1", f"state {name}") for k, name in enumerate(names)}
        return xr.Dataset(data, {"cycle": np.arange(len(ends)) + 1}, {"system": json.dumps({"states": names})})
    steady = {name: ((), 0.0, quantity(name)) for name in ("u", "w")}
    if isinstance(answer, Basin) and answer.curves:
        return xr.Dataset(steady | curve("boundary", "boundary_point", answer.line(), "on the exact boundary"))
    if isinstance(answer, Cycles) and answer.cycles:
        attracting = ("cycle", [cycle.attracting for cycle in answer.cycles])
        return xr.Dataset(steady | orbits([cycle.orbit for cycle in answer.cycles]) | {"attracting": attracting})
    empty = {Basin: "a basin without a boundary", Cycles: "an answer without a cycle"}
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
        raise InputError(f"the dataset is not one that lsvib writes, so it cannot be drawn: {reason}.") from error
    return figure


def _picture(dataset: xr.Dataset, kind: str | None) -> style.Figure:
    own = "system" in dataset.attrs  # one's own
    motion = not own and "event_kind" in dataset and "w" in dataset and dataset.w.dims == ("time",)
    kinds = {"phase_plane": _phase_plane, "friction_loop": _friction_loop}  # of a motion, besides that over time
    if kind is not None and not (motion and kind in kinds):
        raise InputError(f"{shown(kind)} cannot be drawn from this; of a motion of a drive {' and '.join(kinds)} can.")
    if motion:
        return kinds.get(kind or "", _motion)(dataset)
    if "attracting" in dataset and "changes" in dataset.attrs:
        return _branch(dataset)
    if own and "behaviour" not in dataset:
        return _states(dataset)
    if not own and {"label", "cycle_u", "boundary_u"} & set(dataset):
        return attraction.draw(dataset)
    swept = dataset["behaviour"].dims if own else tuple(x for x in dataset.dims if x in Drive.model_fields)
    numbers = [name for name, x in dataset.data_vars.items() if x.dims == swept and x.dtype.kind in _NUMBERS]
    if ("behaviour" if own else "attractor") not in numbers or len(swept) not in (1, 2):
        raise InputError(f"a dataset over {', '.join(map(str, dataset.dims)) or 'nothing'} cannot be drawn; {_CAN}.")
    return _curves(dataset[numbers]) if len(swept) == 1 else chart.draw(dataset)


def _motion(dataset: xr.Dataset) -> style.Figure:
    """A panel for the speed of the screw, and for each quantity that is stored besides the state."""
    turning = float(dataset["input_speed"])
    seized = dataset.event_time.values[named(dataset.event_kind, "seizure")]
    dataset = drawing.with_events(dataset, begin=False)
    time, rests = dataset.time, drawing.rests(dataset["mode"])
    speed = dataset["screw_speed"] if "screw_speed" in dataset else (dataset.w + turning).assign_attrs(
        long_name="angular speed of the screw", symbol=r"$\dot\theta$", units="rad s-1"
    )  # fmt: skip
    left_out = {"screw_speed", "commanded_speed", "mode", "time", "w"}
    others = [x for name, x in dataset.data_vars.items() if x.dims == time.dims and name not in left_out]
    figure, panels = _column(time, [speed, *others])
    command = dataset["commanded_speed"] if "commanded_speed" in dataset else xr.full_like(time, turning)
    panels[0].plot(time, command, **style.PRINTED, label="command")
    look = dict[str, Any](color=style.GREEN, alpha=0.15, linewidth=0, label="rest")
    for axes, values in zip(panels, [speed, *others], strict=True):
        axes.plot(time, values, color=style.BLUE)
        if rests.any():
            axes.fill_between(time, 0, 1, where=rests, transform=axes.get_xaxis_transform(), **look)
    if seized.size:
        panels[0].plot(seized, np.zeros(seized.size), "v", color=style.VERMILION, markersize=3.2, label="seizure")
    return style.legend(figure, panels[:1], 3)


def _column(along: xr.DataArray, quantities: Sequence[xr.DataArray]) -> tuple[style.Figure, np.ndarray]:
    """A panel for each quantity over one that they share."""
    figure = style.new_figure(style.DOUBLE, _EDGE + _HEIGHT * len(quantities))
    panels = figure.subplots(len(quantities), 1, sharex=True, squeeze=False)[:, 0]
    for axes, values in zip(panels, quantities, strict=True):
        axes.set_title(style.label(values), **_PLAIN)
        if along.name == "time":
            axes.margins(x=0)
    panels[-1].set_xlabel(style.label(along))
    return figure, panels


def _phase_plane(dataset: xr.Dataset) -> style.Figure:
    """A motion from event to event; under a command, which moves it, the line N = 0 is left out."""
    undriven = dict.fromkeys(("support_damping", "translation_damping", "axial_force"), 0.0)  # unless they are given
    drive = Drive.of(undriven | json.loads(dataset.attrs["parameters"]))
    case = drawing.with_events(dataset).expand_dims("start").assign(stop_velocity=-drive.input_speed)
    axes = (figure := style.new_figure(style.SINGLE, 3.3)).add_subplot()
    drawing.phase_plane(axes, case)
    if drive.rigid and drive.input_speed and "command" not in dataset.attrs:
        drawing.draw_lines(axes, case.assign({name: own[0] for name, (_, own, _) in lines([drive]).items()}))
    else:
        drawing.draw_stop(axes, -drive.input_speed)
    drawing.draw_arrows(axes, case)
    drawing.label_axes(axes, dataset)
    return style.legend(figure, [axes], 2)


def _friction_loop(dataset: xr.Dataset) -> style.Figure:
    """The friction torque over the sliding speed, in slip and at rest; the line is parted at events."""
    if not {"sliding_speed", "friction_torque"} <= set(dataset):
        raise InputError("a friction loop needs sliding_speed and friction_torque among the outputs of the motion.")
    dataset = drawing.with_events(dataset, begin=False)
    speed, torque, rests = dataset.sliding_speed, dataset.friction_torque, drawing.rests(dataset["mode"])
    events = np.diff(dataset.time) == 0
    axes = (figure := style.new_figure(style.SINGLE, 2.8)).add_subplot()
    for here, colour, width, words in ((~rests, style.BLUE, 1.2, "slip"), (rests, style.GREEN, 3.0, "rest")):
        line = drawing.parted(np.where(here, speed, np.nan), np.where(here, torque, np.nan), events)
        axes.plot(*line, color=colour, linewidth=width, solid_capstyle="butt", label=words)
    style.frame(axes, "", speed, style.label(torque, "friction torque"))
    return style.legend(figure, [axes], 2)


def _states(dataset: xr.Dataset) -> style.Figure:
    """Each state of a system over time, with its events; or its cycles in the plane of the first two."""
    names = json.loads(dataset.attrs["system"])["states"]
    if "cycle" in dataset.dims:
        axes, pair = (figure := style.new_figure(style.SINGLE, 3.3)).add_subplot(), (names * 2)[:2]
        for one in dataset.cycle.values:
            axes.plot(*(dataset[name].sel(cycle=one) for name in pair), label=f"cycle {one}")
        style.frame(axes, "", *(dataset[name] for name in pair))
        return style.legend(figure, [axes], 3)
    dataset = drawing.with_events(dataset)
    figure, panels = _column(dataset.time, [dataset[name] for name in names])
    own = ~named(dataset.event_kind, *(x for x in flag_names(dataset.event_kind).values() if x.startswith("phase ")))
    for axes, name in zip(panels, names, strict=True):
        axes.plot(dataset.time, dataset[name], color=style.BLUE)
        at, after = dataset.event_time[own], dataset[f"event_{name}_after"][own]
        axes.plot(at, after, ".", color=style.VERMILION, label="event")
    return style.legend(figure, panels[:1], 3)


def _curves(dataset: xr.Dataset) -> style.Figure:
    """Each number over one parameter, in colours and marks of what the drive does."""
    (along,), kinds = dataset.dims, chart.kinds(dataset)
    looks = chart.looks(kinds)
    left_out = ("attractor", "behaviour", "label", "turns")
    numbers = [x for name, x in dataset.data_vars.items() if name not in left_out and np.isfinite(x).any()]
    figure, panels = _column(dataset[along], numbers)
    for axes, values in zip(panels, numbers, strict=True):
        for name, mark in zip(flag_names(kinds).values(), _MARKS, strict=False):
            here, (colour, words) = named(kinds, name), looks[name]
            if here.any():
                axes.plot(dataset[along][here], values[here], mark, color=colour, label=words, **_MARK)
    return style.legend(figure, panels[:1], 4)


def _branch(dataset: xr.Dataset) -> style.Figure:
    """Amplitude of a cycle along its branch, and its period or, if forcing gives that, largest multiplier."""
    if forced := bool({"harmonics", "clocks"} & {*json.loads(dataset.attrs.get("system") or "{}")}):
        sizes = np.hypot(dataset.multiplier_real_part, dataset.multiplier_imaginary_part).max("multiplier_number")
        dataset = dataset.assign(multiplier=sizes.assign_attrs(long_name="largest multiplier in magnitude", units="1"))
    value, attracts = dataset[next(iter(dataset.data_vars))], dataset.attracting.values.astype(bool)
    # A piece of the line attracts if both its ends do, and all pieces are drawn.
    repels = ~attracts | np.append(~attracts[1:], False) | np.append(False, ~attracts[:-1])
    changes = [(one["name"] or one["kind"], one["along"]) for one in json.loads(dataset.attrs["changes"])]
    panels = (figure := style.new_figure(style.DOUBLE, 3.0)).subplots(1, 2)
    for axes, name in zip(panels, ("amplitude", "multiplier" if forced else "period"), strict=True):
        here = dataset[name].values
        for mask, look, words in ((attracts, "-", "attracts"), (repels, "--", "does not attract")):
            axes.plot(value, np.where(mask, here, np.nan), look, color=style.BLUE, label=words)
        for kind in dict(changes) if name != "multiplier" else ():  # which may leap between two points
            places = [np.interp([at for word, at in changes if word == kind], dataset.along, x) for x in (value, here)]
            axes.plot(*places, _CHANGES.get(kind, "|"), color=style.VERMILION, markersize=3, label=kind)
        if name == "multiplier":  # and grow without bound towards a graze
            axes.axhline(1.0, **style.PRINTED)
            axes.set_ylim(0.0, min(3.0, 1.1 * np.fmax.reduce([1.0, *here])))
        elif np.ptp(here) < 1e-6 * here.max():  # it is constant but for rounding
            axes.set_ylim(0.9 * here.max(), 1.1 * here.max())
        axes.set_xlabel(style.label(value))
        axes.set_title(style.label(dataset[name]), **_PLAIN)
    return style.legend(figure, panels[:1], 3)
