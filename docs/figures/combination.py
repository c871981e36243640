"""Draw the picture of docs/physics.md: what compliant threads change in the stability of a drive with axial support.

Run it in the root of the repository: ``.venv/bin/python docs/figures/combination.py``.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

import lsvib
from lsvib.pictures import style
from lsvib.stability.spectrum import eigenvalues

DRIVE = lsvib.Drive(mass=15, screw_mass=11.6, support_stiffness=1e7, axial_support_damping=200)
THREADS = {
    "Rigid threads": {},
    "Threads of 100 N/µm": {"contact_stiffness": 1e8, "contact_damping": 1e4},
    "Threads of 10 N/µm": {"contact_stiffness": 1e7, "contact_damping": 1e3},
}
FRICTION = np.linspace(0.1, 0.4, 301)
STIFFNESS = np.geomspace(3e5, 3e9, 321)  # N/m
KINDS = {"stable": "#FFFFFF", "flutter": style.SKY, "a motion grows without oscillation": "#F7D9C4"}


def kinds_of(drive: lsvib.Drive) -> np.ndarray:
    """Return the number of a kind over friction coefficient and support stiffness, by the eigenvalues that grow."""
    grid = {**dict(drive), "friction_coefficient": FRICTION, "support_stiffness": STIFFNESS[:, None]}
    values = eigenvalues(grid, law=1)
    grows = values.real > 0
    return grows.any(axis=-1).astype(int) + (grows & (values.imag == 0)).any(axis=-1)


def boundary_of(drive: lsvib.Drive) -> np.ndarray:
    """Return friction coefficients and the support stiffnesses at which steady sliding is lost or gained, exactly."""
    found = []
    for friction in FRICTION[::2]:
        try:
            onset = drive.replace(friction_coefficient=float(friction)).threshold("onset", unknown="support_stiffness")
        except lsvib.NoThreshold:
            continue
        found += [(friction, solution.value) for solution in onset.solutions]
    return np.array(found)


@style.styled
def draw(rigid: lsvib.Drive) -> Figure:
    """Draw a map for each of the threads, side by side."""
    figure = style.new_figure(style.DOUBLE, 2.7)
    panels = figure.subplots(1, 3, sharey=True)
    for panel, (words, threads) in zip(panels, THREADS.items(), strict=True):
        drive = rigid.replace(**threads)
        panel.contourf(FRICTION, STIFFNESS, kinds_of(drive), [-0.5, 0.5, 1.5, 2.5], colors=[*KINDS.values()])
        panel.plot(*boundary_of(drive).T, ".", color=style.BLACK, markersize=1.5)
        panel.set(title=words, xlabel=r"Friction coefficient $\mu$", yscale="log")
        panel.set(xlim=FRICTION[[0, -1]], ylim=STIFFNESS[[0, -1]])
    panels[0].set_ylabel("Support stiffness $k_1$ [N/m]")
    patches = [Patch(facecolor=colour, edgecolor="0.5", linewidth=0.5, label=name) for name, colour in KINDS.items()]
    figure.legend(handles=patches, loc="outside upper center", ncols=3)
    return figure


if __name__ == "__main__":
    style.save(draw(DRIVE), Path(__file__).with_suffix(".png"), resolution=150)
