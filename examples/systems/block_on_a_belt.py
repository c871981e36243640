"""A block on a belt: stick–slip, and the belt speed at which it ends.

Static friction exceeds kinetic friction by D. With a little damping z the cycle ends at a speed near D/√(4πz)
(Brockley, Cameron and Potter, ASME J. Lubrication Technology 89, 1967, 101; mass and stiffness are 1).
`python examples/systems/block_on_a_belt.py` writes block_on_a_belt.png.
"""

import numpy as np
from matplotlib import pyplot as plt

from lsvib.systems import System

block = System(
    states=["x", "v"],  # x from where kinetic friction balances the spring
    parameters={"D": 1, "z": "0.01", "V": 2},
    modes={"slip": {"x": "v", "v": "-x - 2*z*v"}, "stick": {"x": "v", "v": 0}},
    events=[
        {"mode": "slip", "when": "v > V", "to": "stick"},
        {"mode": "stick", "when": "x + 2*z*V > D", "to": "slip"},
    ],
)
branch = block.follow(block.steady_state("slip", {"x": 3}), "V", (0.4, 4))
end = branch.changes[-1]
print(f"stick–slip up to V = {end.value:.10f}, where the cycle ends by {end.name}")

figure, (plane, size) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
for speed, look in ((0.5, ":"), (1.5, "--"), (end.value, "-")):
    orbit = min(branch.points, key=lambda point: abs(point.value - speed)).cycle.orbit
    plane.plot(*orbit.at(np.linspace(0, orbit.end_time, 1000))[0].T, look, label=f"$V$ = {speed:.2f}")
plane.set(xlabel="$x$", ylabel="$v$", xlim=(-3.2, 7.5))
plane.legend(loc="center right")
size.plot([point.value for point in branch.points], [point.cycle.amplitude for point in branch.points])
size.axvline(1 / np.sqrt(0.04 * np.pi), color="black", linestyle=":", label="$D/\\sqrt{4 \\pi z}$")
size.set(xlabel="speed $V$ of the belt", ylabel="amplitude")
size.legend()
figure.savefig("block_on_a_belt.png", dpi=150)
