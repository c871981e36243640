"""Figures 8.4 and 8.5: phase plane under negative damping, with a force that lets the origin repel or attract."""

from functools import partial

import numpy as np
import xarray as xr

from lsvib.answers import phase_plane
from lsvib.answers.attributes import named, variable
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check
from lsvib.chapter.common import EIGENVALUE, Figure, about, spread
from lsvib.chapter.settings import PhasePlane, Values
from lsvib.drives.drive import Drive
from lsvib.pictures import drawing
from lsvib.stability.conditions import stability

_MARGINS = {  # the inequalities of (8.19): unit and wording; each holds where its margin is positive
    "self_locking": ("1", "margin of self-locking, mu - tan(lambda)"),
    "force_with_motion": ("N rad s-1", "margin of a contact force along the motion, by net force times input speed"),
    "negative_effective_damping": ("N m s rad-1", "margin of a negative effective damping of law +"),
}


def plane(settings: Values, figure: str, words: str) -> xr.Dataset:
    """Compute the phase plane, the margins of (8.19), and eigenvalues."""
    drive = Drive(**settings["drive"])
    report, dims = stability(drive), ("case", "eigenvalue")
    margins, real = report.conditions["negative_damping"].margins, np.real([report.eigenvalues])
    planes = phase_plane.portraits(settings, [drive], (), ("Sect. 8.5.1",)).assign_coords(eigenvalue=EIGENVALUE)
    return planes.assign(
        {f"margin_{key}": variable("case", [margins[key]], *words) for key, words in _MARGINS.items()}
        | {"eigenvalue_real_part": variable(dims, real, "s-1", "real part of the eigenvalue", r"Re $\varepsilon$")}
    ).assign_attrs(
        about(
            f"Figure {figure}: phase plane {words}",
            "exact event-driven motion; eigenvalues in closed form (8.18)",
            f"Sect. 8.5, Fig. {figure}",
        )
    )


def _conditions_check(dataset: xr.Dataset, id: str, signs: tuple[int, int, int]) -> Check:
    """Check which of the conditions (8.19) hold, in their order."""
    margins = [dataset[f"margin_{key}"][0] for key in _MARGINS]
    words = [
        f"{key.replace('_', ' ')} {float(x):.3g} {x.attrs['units']}" for key, x in zip(_MARGINS, margins, strict=True)
    ]
    return Check.that(id, (np.sign(margins) == signs).all(), margins=words)


def _repelling_checks(dataset: xr.Dataset) -> list[Check]:
    """Check (8.19), that the origin repels, and that one limit cycle attracts from inside and outside.

    The first start lies within the cycle. Radii are the largest |u| in the first and in the last fifth of the time.
    """
    growth, amplitudes = dataset.eigenvalue_real_part[0], dataset.amplitude.values[0].ravel()
    u, time = np.abs(dataset.u.values[0]), dataset.time.values[0]
    fifth = time[:, -1:] / 5
    first, last = np.where(time <= fifth, u, 0).max(axis=1), np.where(time >= 4 * fifth, u, 0).max(axis=1)
    swing, one, one_cycle = spread(amplitudes), amplitudes[0], named(dataset.attractor, "other cycle").all()
    around = first[0] < one and (first[1:] > one).all() and first.size > 1
    return [
        newton.laws_check(dataset, "Fig. 8.4"),
        _conditions_check(dataset, "fig8_04.conditions", (1, 1, 1)),
        Check.that("fig8_04.unstable", growth.max() > 0, growth=growth),
        _half_plane_check(dataset),
        Check.that("fig8_04.leaves", last[0] > first[0], first=first[0], last=last[0]),
        Check.that("fig8_04.cycle", one_cycle and swing < 1e-12 and around, amplitudes=amplitudes, swing=swing),
    ]


def _half_plane_check(p: xr.Dataset) -> Check:
    """Check in both half planes the law, and Γ u′² + k (u − u*)² about its equilibrium u*, of rate −2 C u′²."""
    law, steady = printed_laws.laws(p), np.sign(printed_laws.net_force(p) * p.input_speed)
    slack = printed_laws.factor(p, steady) - printed_laws.factor(p, law)
    offset = p.u - p.pitch_radius * slack * printed_laws.net_force(p) / p.coupling_stiffness
    energy = printed_laws.inertia(p, law) * p.w**2 + p.coupling_stiffness * offset**2
    within = (law == law.shift(sample=1)) & (law != 0)
    change = (energy - energy.shift(sample=1)).where(within)
    both = p.w**2 + p.w.shift(sample=1) ** 2
    lost = printed_laws.damping(p, law) * both * (p.time - p.time.shift(sample=1))
    off = [float(abs((change + lost).where(law == s).sum() / lost.where(law == s).sum())) for s in (1, -1)]
    sides = (p.normal_force * law > -1e-9).all()  # θ′ > 0 here
    plus, minus = printed_laws.damping(p, 1), printed_laws.damping(p, -1)
    holds = sides and plus < 0 < minus and max(off) < 0.01
    return Check.that("fig8_04.half_planes", holds, plus=plus, minus=minus, off=off)


def _attracting_checks(dataset: xr.Dataset) -> list[Check]:
    """Check that only the second condition of (8.19) fails, and that the origin attracts."""
    growth = dataset.eigenvalue_real_part[0]
    return [
        newton.laws_check(dataset, "Fig. 8.5"),
        _conditions_check(dataset, "fig8_05.second_fails", (1, -1, 1)),
        Check.that("fig8_05.stable", growth.max() < 0, growth=growth),
        Check.everywhere("fig8_05.settles", named(dataset.attractor, "steady sliding")),
        *printed_laws.steady_checks(dataset),
    ]


fig8_04 = Figure(
    PhasePlane,
    """\
Phase plane of the rigid drive with negative effective damping (8.19) and a contact force in the direction of motion
(N_0 Ω > 0). Steady sliding, the origin, is unstable, and motions from inside and outside settle on a limit cycle.
Arrows point forward in time.
""",
    partial(
        plane,
        figure="8.4",
        words="under negative damping with N_0 Ω > 0: the origin is unstable, a limit cycle attracts",
    ),
    _repelling_checks,
    drawing.single,
)
fig8_05 = Figure(
    PhasePlane,
    """\
Phase plane of the rigid drive with negative effective damping (8.19) and a contact force against the direction of
motion (N_0 Ω < 0). Steady sliding, the origin, is stable. Arrows point forward in time.
""",
    partial(plane, figure="8.5", words="as in figure 8.4 but with N_0 Ω < 0: the origin is stable"),
    _attracting_checks,
    drawing.single,
)
