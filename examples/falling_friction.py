"""Friction that falls with the sliding speed: chatter begins at one force, and once begun stops only at a smaller one.

The drive of Table 8.1 with the full friction law measured for it. `python examples/falling_friction.py` writes
falling_friction.png, .pdf and .nc.
"""

import numpy as np

import lsvib

drive = lsvib.Drive(stribeck_rise=0.0203, stribeck_speed=0.013704, friction_slope=-0.08588598956673593)
speeds, forces = np.linspace(2, 50, 49), np.linspace(2, 100, 50)  # rad/s, N

# Two starts for every drive: next to steady sliding, where the onset decides, and from rest, far away.
onsets = [drive.replace(input_speed=speed).threshold("onset").solutions[-1].value for speed in speeds]
found = drive.sweep(axial_force=forces, input_speed=speeds, start="rest")
chatters = (found.attractor != lsvib.Attractor.STEADY_SLIDING).sel(input_speed=40).values
near = drive.sweep(axial_force=forces)  # at the 40 rad/s of Table 8.1
begins, goes_on = forces[near.amplitude > 0][0], forces[chatters][0]
print(f"steady sliding is unstable from {drive.threshold('onset').solutions[-1].value:.3f} N on")
print(f"chatter begins at {begins:g} N; from rest the drive chatters from {goes_on:g} N on")

figure = lsvib.draw(found)
figure.axes[0].plot(speeds, onsets, color="black", label="onset: unstable above")
figure.axes[0].legend(fontsize=8, loc="lower right")
for ending in ("png", "pdf"):
    figure.savefig(f"falling_friction.{ending}", dpi=150)
found.to_netcdf("falling_friction.nc")
