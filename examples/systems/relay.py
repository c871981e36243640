"""A relay in feedback with 1/(s (s² + 2 s + 3)): the cycle used to tune controllers, exactly and as a sine.

As a sine, by the describing function: period 2π/√3, amplitude 2/(3π). The exact period is the zero of a series
(Tsypkin, *Relay Control Systems*, 1984): 3.66190466725448922. `python examples/systems/relay.py` writes relay.png.
"""

import numpy as np
from matplotlib import pyplot as plt

from lsvib.systems import System

plant = {"x": "y", "y": "z"}
loop = System(
    states=["x", "y", "z"],
    modes={"push": plant | {"z": "-3*y - 2*z + 1"}, "pull": plant | {"z": "-3*y - 2*z - 1"}},
    surfaces=[{"between": ["push", "pull"], "at": "x"}],  # push where x < 0
)
cycle = loop.steady_state("push", {"x": -1})
period, amplitude = cycle.period, cycle.extremes(0)[1]
print(f"period {period:.14f}, amplitude {amplitude:.6f}, multipliers {cycle.multipliers.round(10)}")

motion = loop.simulate(cycle.mode, cycle.state, 2 * period)
peak = float(motion.time[np.argmax(motion.x.values)])
figure, (output, plane) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
output.plot(motion.time, motion.x, label="exact")
output.plot(motion.time, 2 / (3 * np.pi) * np.cos(np.sqrt(3) * (motion.time - peak)), "k--", label="as a sine")
output.step(motion.time, -0.1 * np.sign(motion.x), color="grey", linewidth=0.8, label="relay output / 10")
output.set(xlabel="time [s]", ylabel="output $x$", ylim=(-0.25, 0.45))
output.legend(loc="upper left")
for start in (-1, 0.02):
    motion = loop.simulate("push", {"x": start}, 30)
    plane.plot(motion.x, motion.y, linewidth=0.8, label=f"from $x$ = ${start}$")
plane.plot(*cycle.orbit.at(np.linspace(0, period, 500))[0].T[:2], "k", label="cycle")
plane.set(xlabel="output $x$", ylabel="its rate $y$")
plane.legend(loc="lower left")
figure.savefig("relay.png", dpi=150)
