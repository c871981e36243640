"""Figure 8.4: phase plane under negative damping with a contact force along the motion."""

import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import drawing, style


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the motions from inside and outside, the limit cycle, and the lines N = 0 and θ′ = 0."""
    return drawing.single(dataset)
