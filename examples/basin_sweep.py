"""The basin of steady sliding: its exact boundary, and its share of a window over force, damping and mass.

The drive of Fig. 8.14b beyond its critical mass. `python examples/basin_sweep.py` writes basin_sweep.png and .pdf.
"""

import numpy as np
from matplotlib import pyplot as plt

import lsvib

WINDOW = {"u": (-0.3, 0.3), "w": (-150, 150)}  # rad, rad/s
SWEPT = {
    "axial_force": ("axial force [N]", np.linspace(-40, -0.5, 80)),
    "support_damping": ("support damping [N m s/rad]", np.linspace(1e-4, 5e-3, 99)),
    "mass": ("mass [kg]", np.linspace(9, 25, 81)),
}

drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
limits = {"axial_force": drive.threshold("global_stability"), "mass": drive.threshold("kinematic_constraint", "mass")}
print(f"area of the basin: {drive.basin().area():.6f} rad2/s")
print(f"every motion settles below {limits['axial_force'].value:.4f} N or {limits['mass'].value:.4f} kg")

figure, panels = plt.subplots(2, 2, figsize=(7.2, 5.4), layout="constrained")
plane, *others = panels.flat
for force in (-30, -20, -10):
    basin = drive.replace(axial_force=force).basin()
    plane.fill(*basin.line(WINDOW).T, alpha=0.3, label=f"{force} N: {basin.fraction(WINDOW):.2%} of the window")
plane.plot(0, 0, "k+")
plane.set(title="basin of steady sliding", ylim=(-42, 48), xlabel="deviation $u$ [rad]", ylabel="its rate [rad/s]")
plane.legend(fontsize="small", loc="upper right")
for axes, (name, (label, values)) in zip(others, SWEPT.items(), strict=True):
    shares = [drive.replace(**{name: value}).basin().fraction(WINDOW) for value in values]
    axes.semilogy(values, shares, ".-", markersize=3)
    axes.axvline(getattr(drive, name), color="grey", linestyle="--", label="drive of Fig. 8.14b")
    if name in limits:
        axes.axvline(limits[name].value, color="C1", linestyle=":", label="limit of global stability")
    axes.set(xlabel=label, ylabel="fraction of the window")
    axes.legend(fontsize="small")
for ending in ("png", "pdf"):
    figure.savefig(f"basin_sweep.{ending}", dpi=150)
