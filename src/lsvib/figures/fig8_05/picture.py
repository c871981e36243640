"""Figure 8.5: phase plane under negative damping with a contact force against the motion."""

import xarray as xr
from matplotlib.figure import Figure

from lsvib.figures import drawing, style


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw the motions, which all approach the origin, and the lines N = 0 and θ′ = 0."""
    return drawing.single(dataset)
