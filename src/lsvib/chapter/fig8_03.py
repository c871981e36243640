"""Figure 8.3: stability of steady sliding over effective inertia and damping, by eigenvalues (8.18)."""

from enum import IntEnum
from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import attributes as cf
from lsvib.answers import spans
from lsvib.answers.attributes import named
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, Clause, each, every, never, some
from lsvib.chapter.common import about, bisected
from lsvib.chapter.contact_force import Existence, existence
from lsvib.chapter.settings import DriveFigure, Span, Values
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.pictures import drawing, style
from lsvib.stability.spectrum import eigenvalue_pair

CAPTION = """\
Stability of steady sliding over effective inertia and effective damping, from the eigenvalues (8.18) at each point of
the plane. Colours and labels give the class; nodes and foci meet on the black curve.
"""

_INERTIA = cf.attributes("kg m2", "effective inertia", r"$\Gamma_0$")
_DAMPING = cf.attributes("N m s rad-1", "effective damping", "$C_0$")
_COLOURS = {  # stable classes in blues and greens, unstable ones in warm colours
    **{"stable node": "#9FD3C7", "stable focus": "#BFDDF2", "centre": style.GREY, "unstable focus": "#FBE3B5"},
    **{"unstable node": "#F4B78A", "saddle": "#E3C3D6", "degenerate": style.BLACK},
}


class Stability(IntEnum):
    """Classes by the eigenvalues."""

    STABLE_NODE = 0
    STABLE_FOCUS = 1
    CENTRE = 2
    UNSTABLE_FOCUS = 3
    UNSTABLE_NODE = 4
    SADDLE = 5
    DEGENERATE = 6


class Settings(DriveFigure):
    unused = ("mass", "translation_damping", "friction_coefficient", "axial_force")
    engine = ()

    inertia: Span = Field(description="Effective inertia [kg m2].")
    damping: Span = Field(description="Effective damping [N m s/rad].")


def build(settings: Values) -> xr.Dataset:
    """Compute the class map, the node–focus boundary, and drives beside the conditions of stability."""
    drive = Drive.of(settings["drive"])
    stiffness = drive.coupling_stiffness
    inertia, damping = spans.even(settings["inertia"]), spans.even(settings["damping"])
    kinds, plane = _classes(inertia[:, None], damping, stiffness), ("effective_inertia", "effective_damping")
    positive = inertia[-1] * np.linspace(0, 1, inertia.size)[1:] ** 2  # dense near the vertex of the parabola
    node = 4 * np.sqrt(stiffness * positive)  # damping at which the eigenvalues are real
    met = bisected(lambda c: eigenvalue_pair(positive, c, stiffness)[:, 1].imag == 0, 0 * node, node)
    along, words = "node_focus_effective_inertia", "effective damping at which the two eigenvalues meet"
    return xr.Dataset(
        {
            "stability": cf.flagged(plane, kinds, "class of steady sliding", Stability),
            "node_focus_effective_damping": cf.variable(along, met, "N m s rad-1", words, "$C_0$"),
        }
        | _many_drives(drive),
        coords={
            "effective_inertia": ("effective_inertia", inertia, _INERTIA),
            "effective_damping": ("effective_damping", damping, _DAMPING),
            along: (along, positive, _INERTIA),
            **cf.drive_parameters(drive, no_effect=Settings.unused),
        },
        attrs=about(__doc__, "eigenvalues in closed form (8.18)", "Sect. 8.4, Fig. 8.3"),
    )


def _classes(inertia: np.ndarray, damping: np.ndarray, stiffness: float) -> np.ndarray:
    """Class (:class:`Stability`) by the eigenvalues (8.18); a pair that coincides is a node, Γ_0 = 0 degenerate."""
    low, high = np.moveaxis(eigenvalue_pair(inertia, damping, stiffness), -1, 0)
    oscillates = high.imag != 0
    first_of = {
        Stability.DEGENERATE: np.isnan(high.real),
        Stability.STABLE_FOCUS: oscillates & (high.real < 0),
        Stability.UNSTABLE_FOCUS: oscillates & (high.real > 0),
        Stability.CENTRE: oscillates,
        Stability.STABLE_NODE: high.real < 0,
        Stability.UNSTABLE_NODE: low.real > 0,
    }
    return np.select([*first_of.values()], [*first_of], Stability.SADDLE).astype(np.int8)


def _many_drives(drive: Drive) -> cf.Variables:
    """Drives on both sides of every condition of (8.19) and (8.21): coefficients, growth, states without a solution."""
    tangent = float(np.tan(drive.lead_angle))
    mass = drive.screw_inertia / abs(tangent * drive.pitch_radius**2 * printed_laws.factor(drive, 1))  # m_cr
    axes = {
        "mass": mass * np.array([0.1, 0.5, 0.99, 1.01, 2.0]),
        "friction_coefficient": [*(tangent * np.array([0.1, 0.99, 1.01, 2.0, 3.0])), 0.9 / tangent],
        "axial_force": [-50.0, 50.0],
        "translation_damping": [0.0, 1e3],
    }
    angles = np.geomspace(1e-3, 1e3, 13) * np.array([[-1], [1]])
    u, w = np.meshgrid(angles, drive.input_speed * np.array([-3, 0.5]))
    rows = []
    for values in product(*axes.values()):
        own = drive.replace(**dict(zip(axes, map(float, values), strict=True)))
        c = coefficients(own)
        inertia, damping = float(c.gamma[c.steady_law]), float(c.damping[c.steady_law])
        growth = eigenvalue_pair(inertia, damping, drive.coupling_stiffness).real.max()
        none = (existence(own, u, w) == Existence.INCONSISTENT).any()
        rows.append((float(c.gamma[1]), float(c.gamma[-1]), inertia, damping, growth, none))
    table = np.moveaxis(np.array(rows).reshape(*map(len, axes.values()), 6), -1, 0)
    dims = tuple(f"swept_{name}" for name in axes)
    return {
        **cf.varied(**{f"swept_{name}": values for name, values in axes.items()}),
        "effective_inertia_plus": cf.variable(dims, table[0], "kg m2", "effective inertia of law +", r"$\Gamma_+$"),
        "effective_inertia_minus": cf.variable(dims, table[1], "kg m2", "effective inertia of law -", r"$\Gamma_-$"),
        "swept_effective_inertia": (dims, table[2], _INERTIA),
        "swept_effective_damping": (dims, table[3], _DAMPING),
        "growth_rate_of_steady_sliding": cf.variable(dims, table[4], "s-1", "largest real part of an eigenvalue"),
        "without_solution": cf.yes_no(dims, table[5], "some states of the drive have no contact force"),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the class map against the conditions of Sect. 8.4, and growth rates against eigenvalues by LAPACK."""
    inertia, damping = dataset.effective_inertia.values[:, None], dataset.effective_damping.values[None, :]
    stiffness, kinds = float(dataset.coupling_stiffness), dataset.stability
    regular = ~named(kinds, "degenerate")
    stable = named(kinds, "stable node", "stable focus")
    saddle, wrong = named(kinds, "saddle"), stable != ((inertia > 0) & (damping > 0))
    focus, squares = named(kinds, "stable focus", "unstable focus", "centre"), (damping**2, 4 * stiffness * inertia)
    apart = np.abs(squares[0] - squares[1]) > 1e-12 * squares[0]  # else rounding may decide
    ratio = dataset.node_focus_effective_damping**2 / (4 * stiffness * dataset.node_focus_effective_inertia)
    gamma, c = dataset.swept_effective_inertia.values, dataset.swept_effective_damping.values
    jacobian = np.zeros((*gamma.shape, 2, 2))
    jacobian[..., 0, 1], jacobian[..., 1, 0], jacobian[..., 1, 1] = 1, -stiffness / gamma, -c / gamma
    theirs = np.linalg.eigvals(jacobian).astype(complex)
    gap = abs(dataset.growth_rate_of_steady_sliding - theirs.real.max(axis=-1)) / np.abs(theirs).max(axis=-1)
    return [
        Check.that("fig8_03.stable", exceptions=never(wrong[regular]), stable_points=some(stable)),
        Check.that("fig8_03.saddle", exceptions=never((saddle != (inertia < 0))[regular])),
        Check.that("fig8_03.focus", exceptions=never((focus != (squares[0] < squares[1]))[regular & apart])),
        Check.of("fig8_03.node_focus", ratio, expected=1.0),
        Check.that("fig8_03.eigenvalues", largest=each(gap, "<", 1e-7)),  # LAPACK keeps 1.5e-8 where two coincide
        *_condition_checks(dataset),
    ]


def _condition_checks(dataset: xr.Dataset) -> list[Check]:
    """Check the conditions of the chapter, as printed, on drives on both sides of each of them."""
    swept = {name[6:]: dataset[name] for name in map(str, dataset.coords) if name.startswith("swept_")}
    p = SimpleNamespace(**newton.parameters(dataset) | swept)
    net, free = printed_laws.net_force(p), p.translation_damping == 0
    locking, pushed = p.friction_coefficient > np.tan(p.lead_angle), p.axial_force * p.input_speed > 0
    third, negative = printed_laws.inertia(p, 1) < 0, (net * p.input_speed > 0) & (printed_laws.damping(p, 1) < 0)
    plus, minus = dataset.effective_inertia_plus, dataset.effective_inertia_minus
    inertia, damping = dataset.swept_effective_inertia, dataset.swept_effective_damping
    unstable, none = dataset.growth_rate_of_steady_sliding > 0, dataset.without_solution == 1
    gaps = [abs(x - printed_laws.inertia(p, s)) / p.screw_inertia for s, x in ((1, plus), (-1, minus))]
    allowed = {s: s * net / printed_laws.lever(p, s) * p.input_speed > 0 for s in (1, -1)}
    off = abs(damping - printed_laws.damping(p, 1).where(allowed[1], printed_laws.damping(p, -1)))
    of_sign, against = plus.where(allowed[1], minus), free & ~pushed

    def among(truth: xr.DataArray, cases: xr.DataArray) -> Clause:
        return every(truth.broadcast_like(unstable).values[cases.broadcast_like(unstable).values])

    return [
        Check.that("fig8_03.inertias", law_plus=each(gaps[0], "<", 1e-9), law_minus=each(gaps[1], "<", 1e-9)),
        Check.that("fig8_03.one_sign", drives=every(allowed[1] != allowed[-1]), inertias=every(inertia == of_sign)),
        Check.that("fig8_03.law_minus", drives=every(minus > p.screw_inertia)),
        Check.that("fig8_03.law_plus", drives=among(locking, plus < 0)),
        Check.that("fig8_03.force_against", inertias=among((inertia == minus) & (minus > 0), against),
                   stable_drives=among(~unstable, against)),
        Check.that("fig8_03.paradoxes", drives=every(none == (locking & third))),
        Check.that("fig8_03.kinematic", drives=among(unstable == (locking & pushed & third), free)),
        Check.that("fig8_03.negative_damping", drives=every((damping < 0) == (locking & negative)),
                   gap=each(off / p.support_damping, "<", 1e-9)),
        Check.that("fig8_03.necessary", self_locking_drives=among(locking, unstable),
                   pushed_drives=among(pushed, unstable)),
        Check.that("fig8_03.locking", negative_inertias=some(inertia < 0), negative_dampings=some(damping < 0),
                   self_locking_drives=among(locking, (inertia < 0) | (damping < 0))),
        Check.that("fig8_03.either", drives_by_inertia=among(unstable, (inertia < 0) & (damping > 0)),
                   drives_by_damping=among(unstable, (inertia > 0) & (damping < 0))),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the class map and the node–focus boundary C_0² = 4kΓ_0."""
    figure = style.new_figure(style.SINGLE, 2.9)
    axes, line = figure.add_subplot(), dict[str, Any](color=style.BLACK, linewidth=1.0)
    inertia, damping = dataset.effective_inertia, dataset.effective_damping
    drawing.regions(axes, inertia, damping, dataset.stability.T, _COLOURS, shading="nearest")
    met = [dataset[f"node_focus_effective_{name}"] for name in ("inertia", "damping")]
    for sign in (1, -1):
        axes.plot(met[0], sign * met[1], **line)
    axes.text(float(met[0][-1]), float(met[1][-1]), r"$C_0^2 = 4 k \Gamma_0$  ", ha="right", va="bottom")
    axes.axvline(0, **line)
    axes.plot([0, inertia[-1]], [0, 0], **line)
    for name in cf.flag_names(dataset.stability).values():
        inside = dataset.stability.copy(data=named(dataset.stability, name))
        if inside.mean() > 0.01:  # lines such as the centres have no region
            axes.text(inertia.where(inside).mean(), damping.where(inside).mean(), name, ha="center")
    style.frame(axes, "", inertia, damping, xlim=inertia[[0, -1]], ylim=damping[[0, -1]])
    return figure
