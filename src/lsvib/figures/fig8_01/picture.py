"""Figure 8.1: phase portrait of the contact force in the indeterminate case."""

import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import style
from lsvib.figures.drawing import contact_forces


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the motions, the saddle's manifolds and the basin of bounded contact forces, elastic and damped."""
    return contact_forces.portrait(dataset, ("law +: $N > 0$", "law −: $N < 0$"), columns=4)
