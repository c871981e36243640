"""Figure 8.4: phase plane under negative damping with N_0 Ω > 0: the origin is unstable, a limit cycle attracts."""

import numpy as np
import xarray as xr

from lsvib.datasets import newton, phase_plane
from lsvib.datasets.attributes import variable
from lsvib.datasets.checks import Check
from lsvib.figures import drawing, printed_laws
from lsvib.figures.common import EIGENVALUE, about, named, spread
from lsvib.figures.settings import PhasePlane, Values
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.stability.conditions import conditions
from lsvib.stability.spectrum import eigenvalue_pair

CAPTION = """\
Phase plane of the rigid drive under negative effective damping (8.19) with a contact force of the direction of motion
(N_0 Ω > 0). Steady sliding, the origin, is unstable, and motions from inside and from outside settle on a limit cycle.
Arrows point along time.
"""

SOURCE = "exact event-driven motion; eigenvalues in closed form (8.18)"
MARGINS = {  # the inequalities of (8.19): unit and wording; each holds where its margin is positive
    "self_locking": ("1", "margin of self-locking, mu - tan(lambda)"),
    "force_with_motion": ("N rad s-1", "margin of a contact force along the motion, by net force times input speed"),
    "negative_effective_damping": ("N m s rad-1", "margin of a negative effective damping of law +"),
}

Settings = PhasePlane
draw = drawing.single


def build(settings: Values) -> xr.Dataset:
    """Compute the phase plane (the first start lies within the cycle), the margins of (8.19), and eigenvalues."""
    drive = Drive(**settings["drive"])
    c = coefficients(drive)
    inertia, damping = float(c.gamma[c.steady_law]), float(c.damping[c.steady_law])
    margins = conditions(drive)["negative_damping"].margins
    real, dims = eigenvalue_pair(inertia, damping, drive.coupling_stiffness).real[None], ("case", "eigenvalue")
    planes = phase_plane.portraits(settings, [drive], (), ("Sect. 8.5.1",)).assign_coords(eigenvalue=EIGENVALUE)
    return planes.assign(
        {f"margin_{key}": variable("case", [margins[key]], *words) for key, words in MARGINS.items()}
        | {"eigenvalue_real_part": variable(dims, real, "s-1", "real part of the eigenvalue", r"Re $\varepsilon$")}
    ).assign_attrs(about(__doc__, SOURCE, "Sect. 8.5, Fig. 8.4"))


def margins_text(dataset: xr.Dataset) -> str:
    """Return the margins of (8.19) for the text of a check."""
    found = {key.replace("_", " "): dataset[f"margin_{key}"] for key in MARGINS}
    return ", ".join(f"{words} {float(margin[0]):.3g} {margin.attrs['units']}" for words, margin in found.items())


def radii(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Return each motion's largest |u| [rad] in the first and in the last fifth of the time."""
    u, time = np.abs(dataset.angle_deviation.values[0]), dataset.time.values[0]
    fifth = time[:, -1:] / 5
    return np.where(time <= fifth, u, 0).max(axis=1), np.where(time >= 4 * fifth, u, 0).max(axis=1)


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check (8.19), that the origin repels, and that one limit cycle attracts from inside and outside."""
    holds = all(float(dataset[f"margin_{key}"][0]) > 0 for key in MARGINS)
    growth, (first, last) = dataset.eigenvalue_real_part.values[0], radii(dataset)
    amplitudes = dataset.amplitude.values[0].ravel()
    swing, around = (
        spread(amplitudes),
        first[0] < amplitudes[0] and (first[1:] > amplitudes[0]).all() and first.size > 1,
    )
    return [
        newton.laws_check(dataset, "Fig. 8.4"),
        Check.of("fig8_04.conditions", margins_text(dataset), holds),
        Check.of("fig8_04.unstable", f"real parts {growth[0]:.4g} and {growth[1]:.4g} 1/s", growth.max() > 0),
        _half_plane_check(dataset),
        Check.of("fig8_04.leaves", f"largest |u| grows from {first[0]:.4g} to {last[0]:.4g} rad", last[0] > first[0]),
        Check.of(
            "fig8_04.cycle",
            f"amplitude {amplitudes[0]:.9g} rad, relative spread {swing:.1e} over {amplitudes.size} motions",
            named(dataset.attractor, "other cycle").all() and swing < 1e-12 and around,
        ),
    ]


def _half_plane_check(p: xr.Dataset) -> Check:
    """Check in both half planes the law, and Γ u′² + k (u − u*)² about its equilibrium u*, of rate −2 C u′²."""
    law, steady = printed_laws.laws(p), np.sign(printed_laws.net_force(p) * p.input_speed)
    slack = printed_laws.factor(p, steady) - printed_laws.factor(p, law)
    offset = p.angle_deviation - p.pitch_radius * slack * printed_laws.net_force(p) / p.coupling_stiffness
    energy = printed_laws.inertia(p, law) * p.velocity_deviation**2 + p.coupling_stiffness * offset**2
    within = (law == law.shift(sample=1)) & (law != 0)
    change = (energy - energy.shift(sample=1)).where(within)
    both = p.velocity_deviation**2 + p.velocity_deviation.shift(sample=1) ** 2
    lost = printed_laws.damping(p, law) * both * (p.time - p.time.shift(sample=1))
    left = [float(abs((change + lost).where(law == s).sum() / lost.where(law == s).sum())) for s in (1, -1)]
    sides = (p.normal_force * law > -1e-9).all()  # θ′ > 0 here
    gains = float(printed_laws.damping(p, 1)), float(printed_laws.damping(p, -1))
    found = f"C₊ = {gains[0]:.3g} and C₋ = {gains[1]:.3g} N m s/rad; off by {left[0]:.1e} and {left[1]:.1e}"
    return Check.of("fig8_04.half_planes", found, bool(sides) and gains[0] < 0 < gains[1] and max(left) < 0.01)
