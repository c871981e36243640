"""Friction that rises towards slow sliding: vibration sets in at the same force, but sticking at a lower one.

The drive is that of Fig. 8.6. `python examples/stribeck_rise.py` writes stribeck_rise.png, .pdf and .nc.
"""

import numpy as np

import lsvib

drive = lsvib.Drive(mass=1, translation_damping=1000, stribeck_speed=0.0137)
rises = np.linspace(0, 0.3, 21) * drive.friction_coefficient  # of the coefficient, above its value in steady sliding
forces = np.linspace(15, 50, 71)  # N

found = drive.sweep(stribeck_rise=rises, axial_force=forces)  # from a start next to steady sliding
sticks = found.attractor == lsvib.Attractor.STICK_SLIP_CYCLE
onsets = [drive.replace(stribeck_rise=rise).threshold("onset").solutions[-1].value for rise in rises]
for rise, onset, row in list(zip(rises, onsets, sticks.values, strict=True))[::5]:
    print(f"rise {rise:.3f}: vibration from {onset:.2f} N on, sticking from {forces[row][0]:.1f} N on")

figure = lsvib.draw(found)
figure.axes[0].plot(onsets, rises, color="black", label="exact onset")
figure.axes[0].legend(fontsize=8)
for ending in ("png", "pdf"):
    figure.savefig(f"stribeck_rise.{ending}", dpi=150)
found.to_netcdf("stribeck_rise.nc")
