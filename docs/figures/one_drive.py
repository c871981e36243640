"""Draw the picture of the README: one drive, its limit cycle, its region of attraction, its amplitude over the force.

Run it in the root of the repository: ``.venv/bin/python docs/figures/one_drive.py``.
"""

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import lsvib
from lsvib.pictures import attraction, drawing, style

DRIVE = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
START = {"u": 0.1, "w": 0.0}
GRID = {"u": (-0.14, 0.2, 680), "w": (-50.0, 35.0, 400)}
FORCES = np.linspace(-40.0, -0.5, 159)


@style.styled
def draw(found: xr.Dataset) -> Figure:
    """Draw the phase plane on the left, with its map, and the amplitude on the right."""
    figure = style.new_figure(style.DOUBLE, 2.9)
    plane, curve = figure.subplots(1, 2)
    attraction.draw_map(plane, found)
    # In grey the two colours are equal.
    plane.contour(found.u, found.w, found.label, [found.label.min() + 0.5], colors=style.BLACK, linewidths=0.8)
    motion = DRIVE.simulate(START, 0.02, samples=4001)
    path = [START["u"], *motion.u], [START["w"], *motion.w]  # it seizes at once
    plane.plot(*path, color=style.BLUE, label="a motion", linewidth=1)
    plane.plot(*START.values(), "o", color=style.BLUE, markersize=3)
    drawing.draw_cycle(plane, found.isel(cycle=0), name="its limit cycle")
    plane.plot(0, 0, "+", color=style.BLACK)
    plane.axis((*GRID["u"][:2], *GRID["w"][:2]))
    drawing.draw_lines(plane, found, style.VERMILION, "$N = 0$")
    drawing.label_axes(plane, found)
    plane.set_title("Outlined region: tolerated perturbations")
    plane.legend(loc="upper right", fontsize=6.5)
    _draw_curve(curve)
    return figure


def _draw_curve(axes) -> None:
    found = DRIVE.sweep(axial_force=FORCES.tolist(), start=START)
    limit = DRIVE.threshold("global_stability")
    size = found.amplitude.where(found.amplitude > 0)
    axes.plot(FORCES, size, ".-", color=style.ORANGE, markevery=10, label="sprag-slip after a perturbation")
    axes.axhline(0, color=style.SKY, linewidth=2, label="steady sliding, linearly stable")
    axes.axvline(limit.value, label=f"threshold: $R = {limit.value:.3f}$ N", **style.PRINTED)
    axes.plot(DRIVE.axial_force, size.sel(axial_force=DRIVE.axial_force), "ko", label="the drive on the left")
    axes.set_xlabel("Axial force $R$ [N]")
    axes.set_ylabel("Amplitude [rad]")
    axes.set_title("It slides or vibrates, depending on the start")
    axes.axis((FORCES[0], 0, -0.01, 0.2))
    axes.legend(fontsize=6.5)


if __name__ == "__main__":
    style.save(draw(DRIVE.attraction(GRID)), Path(__file__).with_suffix(".png"), resolution=150)
