"""Figures 8.4 and 8.5: phase planes under negative damping, with a force that makes the origin unstable or stable."""

from functools import partial
from typing import Literal

import numpy as np
import xarray as xr

from lsvib.answers import phase_plane
from lsvib.answers.attributes import named, variable
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, each, every, near
from lsvib.chapter.common import EIGENVALUE, Figure, about, spread
from lsvib.chapter.settings import PhasePlane, Values
from lsvib.drives.drive import Drive
from lsvib.pictures import drawing
from lsvib.stability.conditions import stability


def plane(settings: Values, figure: str, words: str) -> xr.Dataset:
    """Compute the phase plane and the eigenvalues of steady sliding."""
    drive, dims = Drive(**settings["drive"]), ("case", "eigenvalue")
    real = np.real([stability(drive).eigenvalues])
    planes = phase_plane.portraits(settings, [drive], (), ("Sect. 8.5.1",)).assign_coords(eigenvalue=EIGENVALUE)
    return planes.assign(
        eigenvalue_real_part=variable(dims, real, "s-1", "real part of the eigenvalue", r"Re $\varepsilon$")
    ).assign_attrs(
        about(
            f"Figure {figure}: phase plane {words}",
            "exact event-driven motion; eigenvalues in closed form (8.18)",
            f"Sect. 8.5, Fig. {figure}",
        )
    )


def _stability_checks(p: xr.Dataset, conditions: str, stable: str, way: Literal["<", ">"]) -> list[Check]:
    """Check the conditions (8.19), of which the second holds or not, by the ``way``, and the eigenvalues likewise."""
    push, real = printed_laws.net_force(p) * p.input_speed, p.eigenvalue_real_part
    law = np.sign(push)
    total = -printed_laws.damping(p, law) / printed_laws.inertia(p, law)
    margins = {
        "self_locking": each(p.friction_coefficient - np.tan(p.lead_angle), ">", 0),
        "net_force_times_speed": each(push, way, 0),
        "damping_of_law_plus": each(printed_laws.damping(p, 1), "<", 0),
    }
    return [
        Check.that(conditions, **margins),
        Check.that(
            stable,
            largest=each(real.max("eigenvalue"), way, 0),
            sum=near(real.sum("eigenvalue"), total, 1e-12),
            growth=real[0],
        ),
    ]


def _repelling_checks(dataset: xr.Dataset) -> list[Check]:
    """Check (8.19), that the origin repels, and that one limit cycle attracts from inside and outside.

    The first start lies within the cycle. Radii are the largest |u| in the first and in the last fifth of the time.
    """
    amplitudes, cycles = dataset.amplitude.values[0].ravel(), named(dataset.attractor, "other cycle")
    u, time = np.abs(dataset.u.values[0]), dataset.time.values[0]
    fifth = time[:, -1:] / 5
    first, last = np.where(time <= fifth, u, 0).max(axis=1), np.where(time >= 4 * fifth, u, 0).max(axis=1)
    return [
        *newton.portrait_checks(dataset, "Fig. 8.4"),
        *_stability_checks(dataset, "fig8_04.conditions", "fig8_04.unstable", ">"),
        _half_plane_check(dataset),
        Check.that("fig8_04.leaves", growth=each(last[0] / first[0], ">", 1), first=first[0], last=last[0]),
        Check.that("fig8_04.cycle", motions=every(cycles), swing=each(spread(amplitudes), "<", 1e-12),
                   inside=each(first[0], "<", amplitudes[0]), outside=each(first[1:], ">", amplitudes[0]),
                   amplitudes=amplitudes),
    ]  # fmt: skip


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
    plus, minus = printed_laws.damping(p, 1), printed_laws.damping(p, -1)
    return Check.that(
        "fig8_04.half_planes", samples=every(p.normal_force * law > -1e-9),  # θ′ > 0 here
        plus=each(plus, "<", 0), minus=each(minus, ">", 0),
        energy_plus=each(off[0], "<", 0.01), energy_minus=each(off[1], "<", 0.01),
    )  # fmt: skip


def _attracting_checks(dataset: xr.Dataset) -> list[Check]:
    """Check that only the second condition of (8.19) fails, and that the origin attracts."""
    return [
        *newton.portrait_checks(dataset, "Fig. 8.5"),
        *_stability_checks(dataset, "fig8_05.second_fails", "fig8_05.stable", "<"),
        Check.that("fig8_05.settles", motions=every(named(dataset.attractor, "steady sliding"))),
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
        words="under negative damping with N_0 Ω > 0: the origin is unstable, and a limit cycle attracts",
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
