"""Figure 8.2: phase portrait of the contact force in the inconsistent case."""

import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import style
from lsvib.figures.drawing import contact_forces


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the motions, all of which end in the first quadrant, and both equilibria on the wrong side."""
    return contact_forces.portrait(dataset, ("law −: $N < 0$", "law +: $N > 0$"), columns=3)
