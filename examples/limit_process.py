"""After an impact, motions with ever stiffer threads approach the jump of the rigid drive.

`python examples/limit_process.py` writes limit_process.png, .pdf and the motion with the stiffest contact, .nc.
"""

import numpy as np
from matplotlib import pyplot as plt

import lsvib

START = {"u": 0.1, "w": 40.0}  # rad, rad/s: no contact force solves the equations, so the rigid screw stops at once
STIFFNESS = np.geomspace(1e5, 1e10, 11)  # of the contact [N/m]; its damping [N s/m] has the same number
RELAXED = {**START, "thread_mismatch": 0.0, "mismatch_rate": 0.0}  # the threads carry nothing

rigid = lsvib.Drive(mass=15, axial_force=60)
exact = rigid.simulate(START, 0.01, samples=4001)
figure, (plane, force, error) = plt.subplots(1, 3, figsize=(9.6, 3.4), layout="constrained")
plane.plot(exact.u, exact.w, color="black", linewidth=4, alpha=0.3, label="rigid")
distances = []
for index, stiffness in enumerate(STIFFNESS):
    drive = rigid.replace(contact_stiffness=stiffness, contact_damping=stiffness)
    motion = drive.simulate(RELAXED, 0.01, samples=4001)
    distances.append(float(abs(motion.u - exact.u).max()))
    if index % 2 == 0 and stiffness < 1e10:
        look = {"label": f"{stiffness:.0e} N/m", "color": plt.colormaps["viridis"](index / 9), "linewidth": 1.2}
        plane.plot(motion.u, motion.w, **look)
        impact = drive.simulate(RELAXED, 40 / stiffness**0.85, samples=4001)
        force.loglog(impact.time[1:], abs(impact.normal_force)[1:], **look)

slope = np.polyfit(np.log(STIFFNESS[-5:]), np.log(distances[-5:]), 1)[0]
print(f"largest distance {distances[-1]:.2e} rad, falling with the stiffness to the power {slope:.2f}")
plane.set(title="first motion", xlabel="deviation $u$ [rad]", ylabel="its rate [rad/s]")
force.set(title="contact force of the impact", xlabel="time [s]", ylabel="$|N|$ [N]", ylim=(1, None))
error.loglog(STIFFNESS, distances, "o-", label=f"last five: slope {slope:.2f}")
error.set(title="distance to the rigid motion", xlabel="contact stiffness [N/m]", ylabel="largest $|\\Delta u|$ [rad]")
error.legend()
figure.legend(*plane.get_legend_handles_labels(), loc="outside lower center", ncols=6)
for ending in ("png", "pdf"):
    figure.savefig(f"limit_process.{ending}", dpi=150)
motion.to_netcdf("limit_process.nc")
