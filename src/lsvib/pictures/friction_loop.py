"""The friction loop of a motion: the friction torque over the sliding speed, in slip and at rest."""

import numpy as np
import xarray as xr

from lsvib.errors import InputError
from lsvib.pictures import drawing, style


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the loop of a motion that has both among its outputs; the line is parted at events."""
    if not {"sliding_speed", "friction_torque"} <= set(dataset):
        raise InputError("a friction loop needs sliding_speed and friction_torque among the outputs of the motion.")
    speed, torque, rests = dataset.sliding_speed, dataset.friction_torque, drawing.rests(dataset["mode"])
    happens = np.diff(np.searchsorted(dataset.event_time, dataset.time, side="right")) > 0
    figure = style.new_figure(style.SINGLE, 2.8)
    axes = figure.add_subplot()
    for here, colour, width, words in ((~rests, style.BLUE, 1.2, "slip"), (rests, style.GREEN, 3.0, "rest")):
        line = drawing.parted(np.where(here, speed, np.nan), np.where(here, torque, np.nan), happens)
        axes.plot(*line, color=colour, linewidth=width, solid_capstyle="butt", label=words)
    style.frame(axes, "", speed, style.label(torque, "friction torque"))
    return style.legend(figure, [axes], 2)
