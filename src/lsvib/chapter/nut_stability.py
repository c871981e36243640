"""Rotating nut: critical mass against the inertia of the nut (Remark 8.6), and the stability map of (8.33)."""

from typing import Any

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import attributes as cf
from lsvib.answers import spans
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, each, every, near, never
from lsvib.chapter.common import about, bisected, over_map, thinned
from lsvib.chapter.settings import DriveFigure, PositiveSpan, Span, Values
from lsvib.drives import chapter
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients, effective_inertia, together
from lsvib.errors import InputError
from lsvib.pictures import drawing, style
from lsvib.stability.boundaries import place_values
from lsvib.stability.spectrum import UndampedClass, eigenvalues, polynomial, reciprocal_squares, undamped_class

CAPTION = """\
Stability of steady sliding with a rotating nut (drive of Table 8.1, force in the direction of motion, assumed mass and
nut): (a) critical mass against the inertia of the nut, by (8.33) and by eigenvalues, below that of the rigid drive
(Remark 8.6); (b) classes by eigenvalues over friction coefficient and inertia of the nut, with the boundary (8.33).
Neither flutter nor divergence occurs.
"""

_COLOURS = {"stable": "#FFFFFF", "kinematic constraint": "#F7D9C4", "flutter": style.SKY, "divergence": style.BLUE}


class Settings(DriveFigure):
    engine = ()
    unused = ("axial_force", "coupling_stiffness", "input_speed", "support_damping", "translation_damping")

    nut_inertia: PositiveSpan = Field(description="I_2 [kg m2], spaced logarithmically.")
    friction_coefficient: Span = Field(description="mu, from zero or more.")


def build(settings: Values) -> xr.Dataset:
    """Compute the critical mass over the nut's inertia, in closed form and by eigenvalues, and the classes; c_x = 0."""
    drive = Drive.of(chapter.PARTS["nut"] | settings["drive"])
    inertia = spans.logarithmic(settings["nut_inertia"])
    without = drive.replace(**dict.fromkeys(chapter.PARTS["nut"]))
    nuts = [drive.replace(nut_inertia=float(value)) for value in inertia]
    masses = [place_values(one, "kinematic_constraint", "mass") for one in (without, *nuts)]
    if not all(masses):
        raise InputError("The drive is not self-locking (mu <= tan lambda), so it has no critical mass.")
    rigid, *closed = (least for least, *_ in masses)
    mu = [[*place_values(one, "kinematic_constraint", "friction_coefficient"), np.nan][0] for one in nuts]
    friction = spans.even(settings["friction_coefficient"])
    drive.replace(friction_coefficient=float(friction.max()))  # refuses what is beyond cot λ
    values = dict(drive) | {"nut_inertia": inertia}

    def passed(mass: np.ndarray) -> Any:
        """Whether one 1/ω² is negative, or vanishes."""
        squares = reciprocal_squares({**values, "mass": mass}, law=1)
        return ~(np.prod(np.sign(squares.real), axis=-1) > 0)

    passing = bisected(passed, 0 * inertia, np.full(inertia.size, rigid))
    grid = {**values, "friction_coefficient": friction[:, None]}
    kinds, plane = undamped_class(grid, law=1), ("friction_coefficient", "nut_inertia")
    holds = "friction coefficient above which (8.33) holds, missing if there is none"
    own, drawn, closed_form = drive.friction_coefficient, "drawn_friction_coefficient", "critical mass, in closed form"
    origin, deflection = cf.origin_of("friction_coefficient", own), float(coefficients(drive).deflection)
    by = "critical mass, where an eigenvalue 1/omega^2 passes through zero"
    return xr.Dataset(
        {
            "critical_mass_with_nut": cf.variable("nut_inertia", closed, "kg", closed_form, r"$m_\mathrm{cr}$"),
            "critical_mass_with_nut_by_eigenvalues": cf.variable("nut_inertia", passing, "kg", by, r"$m_\mathrm{cr}$"),
            "stability": cf.flagged(plane, kinds, "class of steady sliding", UndampedClass, comment="undamped"),
        },
        coords={
            "critical_friction_with_nut": cf.variable("nut_inertia", mu, "1", holds, r"$\mu$"),
            **cf.varied(nut_inertia=inertia, friction_coefficient=friction),
            "critical_mass": ((), rigid, cf.CRITICAL_MASS),
            drawn: ((), own, cf.parameter(drawn, origin, comment="of the critical masses")),
            "steady_deflection": cf.variable((), deflection, "rad", "coupling deflection in steady sliding", "$z_0$"),
            **cf.drive_parameters(
                drive,
                axes=plane,
                printed=("Sect. 8.6",),
                no_effect=("input_speed", "axial_force", "slide_friction", "bearing_friction"),
            ),
        },
        attrs=about(
            __doc__,
            "generalised eigenvalues of the matrices of Sect. 8.8.2, condition (8.33) in closed form",
            "Sect. 8.8.2, eq. 8.33, Remarks 8.5 and 8.6; docs/lemmas.md",
            comment="R Omega > 0; the dampings enter only where a check repeats the classes with damping",
        ),
    )


def _reduced(p: Values) -> tuple[np.ndarray, np.ndarray]:
    """Of drives with a nut, I_eff = I I_2 / (I + I_2) and Γ_0 of law + with it, negative where (8.33) holds [kg m²]."""
    tangent, mu = np.tan(p["lead_angle"]), p["friction_coefficient"]
    screw, factor = together(p["screw_inertia"], p["nut_inertia"]), (mu - tangent) / (1 + mu * tangent)
    return screw, effective_inertia(screw, p["mass"], p["pitch_radius"], tangent, factor)


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the map against (8.33) and det M_0, with damping too, the critical mass, and the printed deflections.

    The critical mass against Remark 8.6, by eigenvalues, and for a light and a heavy nut; the deflections of steady
    sliding by the force and the friction of the threads alone.
    """
    drive = newton.parameters(dataset)
    inertia, rigid = dataset.nut_inertia.values, float(dataset.critical_mass)
    mass, passing = dataset.critical_mass_with_nut.values, dataset.critical_mass_with_nut_by_eigenvalues.values
    factor = mass / rigid * (drive["screw_inertia"] + inertia) / inertia
    p = dataset.drop_vars("friction_coefficient").rename(drawn_friction_coefficient="friction_coefficient")
    printed_moment = float(p.pitch_radius * printed_laws.factor(p, 1) * p.axial_force)  # R Ω > 0, F_0 = T_0 = 0
    force, (mu, angle) = p.axial_force / printed_laws.lever(p, 1), (p.friction_coefficient, p.lead_angle)
    turns = float(p.pitch_radius * force * (mu * np.cos(angle) - np.sin(angle)))  # the nut, and brakes the screw
    on_screw = float(-p.coupling_stiffness * p.steady_deflection - p.support_damping * p.input_speed)
    plus, minus = (abs(on_screw - sign * printed_moment) / turns for sign in (1, -1))  # k_2 θ_20 = ± r_m ξ_0 R
    return [
        *_class_checks(dataset, drive),
        Check.of("nut_stability.lowered", factor, expected=1.0),
        Check.of("nut_stability.eigenvalues", passing / mass, expected=1.0),
        Check.that("nut_stability.light", steps=each(np.diff(mass), ">", 0), lowered=each(mass[-1], "<", rigid),
                   heavy_nut=near(mass[-1], rigid, 0.01), masses=mass, rigid=rigid),
        Check.of("nut_stability.deflection", on_screw / turns, expected=1.0),
        Check.that("nut_stability.balance", plus=each(plus, "<", 1e-12), minus=each(minus, ">", 1e-12)),
    ]  # fmt: skip


def _class_checks(dataset: xr.Dataset, drive: Values) -> list[Check]:
    """Check the classes by (8.33), its boundary in closed form, the printed inertia matrix and LAPACK with damping."""
    grid = over_map(dataset, drive)
    screw, reduced = _reduced(grid)
    clear, holds = np.abs(reduced) > 1e-9 * screw, reduced < 0  # closer to (8.33) rounding may decide
    kinematic, other = (cf.named(dataset.stability, *x) for x in (["kinematic constraint"], ["flutter", "divergence"]))
    part = thinned(dataset.assign(clear=(dataset.stability.dims, clear)), 40)
    grows = eigenvalues(over_map(part, drive), law=1)[..., -1].real > 0
    differ = (grows != cf.named(part.stability, "kinematic constraint"))[part.clear.values]
    opposite = (polynomial(grid, law=1)[0] < 0) != kinematic
    edge, friction = dataset.critical_friction_with_nut.values, dataset.friction_coefficient.values[:, None]
    off = kinematic != (friction > edge)  # no edge: none
    on_edge = {**drive, "friction_coefficient": edge, "nut_inertia": dataset.nut_inertia.values}
    screw, reduced = _reduced(on_edge)
    left = (np.abs(reduced) / screw)[np.isfinite(edge)]
    return [
        Check.that("nut_stability.classes", kinematic_points=every(kinematic[clear & holds]),
                   other_kinematic_points=never(kinematic[clear & ~holds])),
        Check.that("nut_stability.no_other", flutter_or_divergence=never(other)),
        Check.that("nut_stability.determinant", exceptions=never(opposite[clear])),
        Check.that("nut_stability.damped", exceptions=never(differ)),
        Check.that("nut_stability.boundary", exceptions=never(off[clear])),
        Check.that("nut_stability.equality", left=each(left, "<", 1e-12), edge=np.isfinite(edge)),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw (a) the critical mass over the inertia of the nut and (b) the classes over that and the friction."""
    figure = style.new_figure(style.DOUBLE, 3.5)
    mass, plane = figure.subplots(1, 2)
    rigid, inertia, screw = float(dataset.critical_mass), dataset.nut_inertia, float(dataset.screw_inertia)
    some = dataset.isel(nut_inertia=np.linspace(0, inertia.size - 1, 12).astype(int))
    mass.plot(inertia, dataset.critical_mass_with_nut, color=style.BLUE, label="boundary by (8.33)")
    mass.plot(some.nut_inertia, some.critical_mass_with_nut_by_eigenvalues, "o", color=style.VERMILION, zorder=3,
              label="by eigenvalues", clip_on=False)  # fmt: skip
    shade = {"color": _COLOURS["kinematic constraint"], "linewidth": 0}
    mass.fill_between(inertia, dataset.critical_mass_with_nut, 1.15 * rigid, **shade)
    mass.axhline(rigid, color=style.BLACK, linewidth=0.9, linestyle="--", label=f"fixed nut: {rigid:.3f} kg")
    mass.axvline(screw, color=style.BLACK, linewidth=0.6, linestyle=":", label="$I_2 = I$")
    friction, drawn = dataset.friction_coefficient, float(dataset.drawn_friction_coefficient)
    title = rf"(a) critical mass, $\mu$ = {style.number(drawn)}"
    style.frame(mass, title, inertia, "Critical mass $m_\\mathrm{cr}$ [kg]", xscale="log", ylim=(0, 1.15 * rigid))
    mass.set_xlim(inertia[[0, -1]])
    drawing.regions(plane, friction, inertia, dataset.stability.T, _COLOURS)
    plane.plot(dataset.critical_friction_with_nut, inertia, color=style.BLUE)
    tangent = float(np.tan(dataset.lead_angle))
    plane.axvline(tangent, color=style.BLACK, linewidth=0.6, linestyle=":")
    plane.axvline(drawn, color=style.GREY, linewidth=0.9, linestyle="--")
    look = {"fontsize": 6.5, "va": "top", "transform": plane.get_xaxis_transform()}
    plane.text(tangent, 0.94, r"$\mu = \tan\lambda$ ", ha="right", **look)
    plane.text(drawn, 0.94, rf" {drawn:g} of (a)", color="#505050", **look)
    limits = {"xlim": friction[[0, -1]], "ylim": inertia[[0, -1]]}
    title = f"(b) classes, $m$ = {style.number(dataset.mass)} kg"
    style.frame(plane, title, friction, inertia, yscale="log", **limits)
    words = {"kinematic constraint": "unstable: kinematic constraint", "stable": "stable"}
    patches = drawing.patches(((_COLOURS[name], None, label) for name, label in words.items()), style.GREY)
    return style.legend(figure, [mass, plane], 3, patches)
