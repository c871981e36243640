"""A researcher's question: a system from a paper, an oscillator that meets a stiffer spring beyond a gap.

x″ + 2ζx′ + h(x) = β cos Ωt, h = x up to the gap x₀ and r²x + (1 − r²)x₀ beyond it (Shaw and Holmes, J. Sound Vib. 90,
1983, 129). `python examples/systems/piecewise_oscillator.py` writes piecewise_oscillator.png.
"""

# %%
# The state alone decides which equations apply, so the corner of h is a surface between two modes.
import numpy as np

import lsvib
from lsvib.systems import System

oscillator = System(
    states=["x", "v"],
    parameters={"zeta": "0.05", "r": 4, "x0": 1, "beta": "0.3", "Omega": "0.8"},
    harmonics={"c, s": "Omega"},  # c = cos Omega t
    modes={
        "free": {"x": "v", "v": "-2*zeta*v - x + beta*c"},
        "contact": {"x": "v", "v": "-2*zeta*v - r**2*x - (1 - r**2)*x0 + beta*c"},
    },
    surfaces=[{"between": ["free", "contact"], "at": "x - x0"}],
)
print(oscillator.steady_state("free"))

# %%
# As β grows, its cycle is that of a linear system until it touches the spring, at β² = x₀² ((1 − Ω²)² + (2ζΩ)²).
branch = oscillator.follow(oscillator.steady_state("free"), "beta", (0.2, 0.8))
for change in branch.changes[1:-1]:
    print(f"{change.name} at beta = {change.value:.15g}")

# %%
# Its motion over force and frequency, with the curve on which it touches the spring.
forces, rates = np.linspace(0.2, 1, 17), np.linspace(0.5, 1.1, 25)
figure = lsvib.draw(oscillator.sweep(beta=forces, Omega=rates))
figure.axes[0].plot(rates, abs(1 - rates**2 + 0.1j * rates), color="black")
figure.savefig("piecewise_oscillator.png", dpi=150)
figure  # noqa: B018 – a notebook shows it
