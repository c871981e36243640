"""An oscillator under dry friction and a harmonic force: how often does it stop in a cycle?

x'' + x + f sign x' = cos Ωt. Without stops Den Hartog (Phil. Mag. 9, 1930, 801, section II) gives the amplitude in
closed form. Hong and Liu (J. Sound Vib. 229, 2000, 1171) find cycles with 0 to 14 stops, more at low frequencies.
`python examples/systems/coulomb_oscillator.py` writes coulomb_oscillator.png.
"""

import numpy as np
from matplotlib import pyplot as plt

from lsvib.systems import System

oscillator = System(
    states=["x", "v"],
    parameters={"w": "1.5", "f": "0.2"},
    harmonics={"c, s": "w"},
    modes={"back": {"x": "v", "v": "-x + f + c"}, "forth": {"x": "v", "v": "-x - f + c"}},
    surfaces=[{"between": ["back", "forth"], "at": "v"}],  # back where v < 0; at rest it slides along v = 0
)
print(f"amplitude {oscillator.steady_state('back').extremes(0)[1]:.12f} at frequency 1.5, friction 0.2")
found = oscillator.sweep("back", w=np.geomspace(0.035, 1.45, 45), f=np.linspace(0.02, 0.98, 25))
kinds = found.kind.attrs["flag_meanings"].split()
stops = found.events.isel(kind=kinds.index("slides_along_v"))
print(f"0 to {stops.max().item()} stops in a cycle, at frequencies from 0.035 on")

figure, axes = plt.subplots(figsize=(5.2, 3.4), layout="constrained")
mesh = axes.pcolormesh(found.w, found.f, stops.T, cmap=plt.colormaps["cividis"].resampled(8), vmin=-1, vmax=15)
axes.set(xscale="log", xlabel="frequency $\\Omega$ of the force", ylabel="friction $f$")
figure.colorbar(mesh, label="stops in a cycle", ticks=range(0, 15, 2))
figure.savefig("coulomb_oscillator.png", dpi=150)
