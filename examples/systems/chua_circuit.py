"""Chua's circuit: three linear pieces and chaos, whose Lyapunov exponents follow from the times of its events.

The double scroll of Matsumoto, Chua and Komuro (IEEE Trans. Circuits Syst. 32, 1985, 797), with their exponents 0.23,
0 and −1.78. `python examples/systems/chua_circuit.py` writes chua_circuit.png.
"""

import numpy as np
from matplotlib import pyplot as plt
from scipy.linalg import expm

from lsvib.systems import System

END = 4000
CURRENTS = {"left": "0.3 - 0.5*u", "middle": "-0.8*u", "right": "-0.3 - 0.5*u"}  # through Chua's diode
circuit = System(
    states=["u", "v", "i"],
    modes={k: {"u": f"9*(0.7*(v - u) - ({g}))", "v": "0.7*(u - v) + i", "i": "-7*v"} for k, g in CURRENTS.items()},
    surfaces=[{"between": ["left", "middle"], "at": "u + 1"}, {"between": ["middle", "right"], "at": "u - 1"}],
)
motion = circuit.simulate("middle", {"u": 0.1}, END, samples=100 * END)

# The vector field is continuous, so the flows of the stays, one after the other, carry small deviations along.
flows = [np.array([[-9 * (0.7 + slope), 6.3, 0], [0.7, -0.7, 1], [0, -7, 0]]) for slope in (-0.5, -0.8, -0.5)]
stays = np.diff([0, *motion.event_time.values, END])
modes = [1, *motion.event_mode.values]
frame, grown = np.eye(3), []
for flow in expm(np.array([flows[mode] * stay for mode, stay in zip(modes, stays, strict=True)])):
    frame, change = np.linalg.qr(flow @ frame)
    grown.append(np.log(abs(np.diag(change))))
exponents = np.cumsum(grown, axis=0) / np.cumsum(stays)[:, None]
print("Lyapunov exponents {:.3f}, {:.3f}, {:.3f}".format(*exponents[-1]))

figure, (scroll, panel) = plt.subplots(1, 2, figsize=(7.2, 3), layout="constrained")
scroll.plot(motion.u[:20_000], motion.v[:20_000], linewidth=0.5)
scroll.set(xlabel="voltage $u$ at the diode", ylabel="voltage $v$", title="double scroll")
panel.semilogx(np.cumsum(stays), exponents)
panel.set(xlabel="time", title="Lyapunov exponents over time", ylim=(-2, 0.5))
figure.savefig("chua_circuit.png", dpi=150)
