"""A buck converter under voltage control: as the supply voltage rises, its cycle doubles again and again, into chaos.

The circuit of Fossas and Olivar (IEEE Trans. Circuits Syst. I 43, 1996, 13), whose cycle first doubles at 24.516 V.
`python examples/systems/buck_converter.py` writes buck_converter.png.
"""

import numpy as np
from matplotlib import pyplot as plt

from lsvib.systems import System

buck = System(
    states=["v", "i"],  # V, A
    parameters={"E": 24, "R": 22, "L": "20e-3", "C": "47e-6", "reference": "11.3", "gain": "8.4", "T": "400e-6"},
    clocks={"t": "T"},  # the ramp, from 3.8 V to 8.2 V
    modes={"on": {"v": "(i - v/R)/C", "i": "(E - v)/L"}, "off": {"v": "(i - v/R)/C", "i": "-v/L"}},
    events=[
        {"mode": "on", "when": "gain*(v - reference) > 3.8 + 4.4*t/T", "to": "off"},
        {"mode": "off", "when": "gain*(v - reference) < 3.8 + 4.4*t/T", "to": "on"},
    ],
)
start = {"v": 12, "i": 0.5}
branch = buck.follow(buck.steady_state("on", start), "E", (22, 28))
print(*(f"{change.name} at {change.value:.6f} V" for change in branch.changes if change.name))

figure, (voltage, plane) = plt.subplots(1, 2, figsize=(7.2, 3), width_ratios=(3, 2), layout="constrained")
for supply in np.linspace(22, 34, 97):
    motion = buck.replace(E=supply).simulate("on", start, 0.2, samples=2)
    returns = motion.event_v_after[motion.event_t_after == 0][-64:]
    voltage.plot(np.full(returns.size, supply), returns, "k.", markersize=1)
voltage.set(title="at each ramp, after 0.17 s", xlabel="supply [V]", ylabel="voltage as a ramp begins [V]")
multipliers = np.array([point.cycle.multipliers for point in branch.points])
plane.plot(np.cos(np.linspace(0, 2 * np.pi)), np.sin(np.linspace(0, 2 * np.pi)), "k:", label="unit circle")
plane.plot(multipliers.real, multipliers.imag, "C0.")
plane.set(
    title="multipliers, 22 to 28 V", xlabel="real part", ylabel="imaginary part", aspect="equal", adjustable="datalim"
)
figure.savefig("buck_converter.png", dpi=150)
