"""The phase plane of a motion, u and u′, with the lines at which slip stops and, of rigid drives, N vanishes."""

import json

import numpy as np
import xarray as xr

from lsvib.answers.phase_plane import lines
from lsvib.drives.drive import Drive
from lsvib.pictures import drawing, style


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw a motion from event to event; under a command, which moves it, the line N = 0 is left out."""
    undriven = dict.fromkeys(("support_damping", "translation_damping", "axial_force"), 0.0)  # unless they are given
    drive = Drive.of(undriven | json.loads(dataset.attrs["parameters"]))
    mode, after = dataset["mode"], dataset.event_mode.values
    ends = {"time": 2 * [dataset.event_time], "mode": [np.append(mode[:1], after)[: after.size], after]}
    for name in ("angle_deviation", "velocity_deviation"):
        ends[name] = [dataset[f"event_{name}_{when}"] for when in ("before", "after")]
    points = {name: np.append(np.stack(own, axis=1), dataset[name]) for name, own in ends.items()}
    order = np.argsort(points["time"], kind="stable")  # a sample at the time of an event is one after it
    case = dataset[[name for name, own in dataset.data_vars.items() if own.dims == ("event",)]]
    case = case.assign({name: ("sample", x[order], dataset[name].attrs) for name, x in points.items()})
    case = case.expand_dims("start").assign(stop_velocity=-drive.input_speed)
    axes = (figure := style.new_figure(style.SINGLE, 3.3)).add_subplot()
    drawing.phase_plane(axes, case)
    if drive.rigid and drive.input_speed and "command" not in dataset.attrs:
        drawing.draw_lines(axes, case.assign({name: own[0] for name, (_, own, _) in lines([drive]).items()}))
    else:
        drawing.draw_stop(axes, -drive.input_speed)
    drawing.draw_arrows(axes, case)
    drawing.label_axes(axes, dataset)
    return style.legend(figure, [axes], 2)
