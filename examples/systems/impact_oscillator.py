"""An oscillator that hits a stop, driven at resonance: its cycle as the amplitude of the force varies.

Example 15.2 of Dankowicz and Schilder, *Recipes for Continuation* (SIAM, 2013): at A = 1 the speed after the impact is
−1.36, and at A = 0.1 the motion only grazes the stop. `python examples/systems/impact_oscillator.py` writes
impact_oscillator.png.
"""

import numpy as np
from matplotlib import pyplot as plt

from lsvib.systems import System

oscillator = System(
    states=["x", "v"],
    parameters={"A": 1, "w": 1, "r": "0.8"},
    harmonics={"c, s": "w"},  # c = cos w t, s = sin w t
    modes={"fly": {"x": "v", "v": "-x - 0.1*v + A*c"}},
    events=[{"mode": "fly", "when": "x > 1", "reset": {"v": "-r*v"}}],
)
cycle = oscillator.steady_state("fly")
branch = oscillator.follow(cycle, "A", (0.102, 1.1))
print(f"A = 1: speed {cycle.extremes(1)[0]:.14g} after the impact, multipliers {cycle.multipliers.round(9)}")

figure, (plane, impact) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
for amplitude, look in ((0.102, ":"), (0.5, "--"), (1, "-")):
    orbit = min(branch.points, key=lambda point: abs(point.value - amplitude)).cycle.orbit
    plane.plot(*orbit.at(np.linspace(0, orbit.end_time, 1000))[0].T[:2], look, label=f"$A$ = {amplitude}")
plane.axvline(1, color="grey", linewidth=3)
plane.set(title="cycles at the stop", xlabel="$x$", ylabel="$v$")
plane.legend(loc="center")
orbits = [point.cycle.orbit for point in branch.points]
impact.plot([point.value for point in branch.points], [max((o.before - o.after)[:, 1]) for o in orbits])
impact.plot(0.1, 0, "ko", label="grazes")
impact.set(title="the impact", xlabel="amplitude $A$ of the force", ylabel="jump of the velocity")
impact.legend()
figure.savefig("impact_oscillator.png", dpi=150)
