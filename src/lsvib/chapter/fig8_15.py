"""Figure 8.15: instability regions of the drive with axial support over friction coefficient and support stiffness."""

import math
from types import SimpleNamespace

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import spans
from lsvib.answers.analysis import analyse, value
from lsvib.answers.attributes import drive_parameters, flagged, named, variable, varied
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, each, every, never, some
from lsvib.chapter.common import about, over_map, printed, thinned
from lsvib.chapter.settings import DriveFigure, PositiveSpan, Span, Values, parameter
from lsvib.drives import chapter
from lsvib.drives.drive import PART_OF, Drive
from lsvib.drives.mechanics import effective_inertia, together
from lsvib.numbers import bisected
from lsvib.pictures import drawing, style
from lsvib.stability.boundaries import place_values
from lsvib.stability.spectrum import UndampedClass, eigenvalues, reciprocal_squares, undamped_class

CAPTION = """\
Stability of the undamped drive with axial support, R Ω > 0, over friction coefficient and support stiffness, from the
generalised eigenvalues of (8.23) at each point, with the boundaries (8.29) in closed form and the critical friction
coefficient (8.27). Beyond the upper branch, where the effective inertia of the drive with a rigid support is negative,
both modes diverge by (8.25). In the horizontally hatched region, which the chapter calls the primary kinematic
instability region, the reduced effective inertia is negative. The third region, of divergence, is not in the chapter;
as the support stiffens it grows towards the instability of the rigid drive. The coupling stiffness is assumed, because
Table 7.1 is not in the chapter; the boundaries of mode coupling are proportional to it.
"""

_DAMPINGS = ("support_damping", "translation_damping", "axial_support_damping")
_REGIONS = {  # fill, hatch as in the chapter, words
    "stable": ("#FFFFFF", None, "stable"),
    "flutter": ("#CFE3F3", "////", "mode coupling (flutter)"),
    "divergence": ("#FBE3B5", "....", "third region: both modes diverge, $\\Gamma_0 < 0 < \\tilde\\Gamma_0$"),
    "kinematic constraint": ("#F7D9C4", "---", "primary kinematic region, $\\tilde\\Gamma_0 < 0$"),
}
_HATCH = "#7F8FA0"


class Settings(DriveFigure):
    engine = ()
    unused = ("support_damping", "friction_coefficient", "input_speed", "translation_damping", "axial_force")

    screw_mass: float = parameter("screw_mass")
    friction_coefficient: Span = Field(description="mu, from zero or more.")
    support_stiffness: PositiveSpan = Field(description="k_1 [N/m], spaced logarithmically.")


def _drive(settings: Values) -> Drive:
    return Drive.of(chapter.PARTS["support"] | {"screw_mass": settings["screw_mass"]} | settings["drive"])


def analysis(settings: Values) -> xr.Dataset:
    """Analyse the drive: its critical friction coefficient."""
    return analyse([_drive(settings)], [("kinematic_constraint", "friction_coefficient")])


def build(settings: Values, analysis: xr.Dataset) -> xr.Dataset:
    """Compute the undamped class map by eigenvalues, flutter boundaries in closed form, critical friction both ways."""
    drive = _drive(settings)
    friction, stiffness = spans.even(settings["friction_coefficient"]), spans.logarithmic(settings["support_stiffness"])
    drive.replace(friction_coefficient=float(friction.max()))  # refuses what is beyond cot λ
    critical = value(analysis.kinematic_constraint_friction_coefficient)
    # From tan λ on, crowded at both ends, and the friction coefficients of the map between.
    start = float(np.tan(drive.lead_angle))
    crowded = start + (critical - start) * (1 - np.cos(np.linspace(0, np.pi, 801))) / 2
    curve = np.unique(np.concatenate([crowded, friction[(friction > start) & (friction < critical)]]))
    grid = {**dict(drive), "friction_coefficient": friction[:, None], "support_stiffness": stiffness}
    kinds, plane = undamped_class(grid, law=1), ("friction_coefficient", "support_stiffness")
    branches = _branches(_printed({**dict(drive), "friction_coefficient": curve}))
    along, word = "boundary_friction_coefficient", "critical friction coefficient"
    passing = "friction coefficient at which an eigenvalue 1/omega^2 passes through zero"
    largest = math.nextafter(1 / math.tan(drive.lead_angle), 0)

    def turned(coefficient: float) -> bool:
        """Whether one 1/ω² of (8.23) under law + is negative: it has a simple root where ω² has a pole."""
        squares = reciprocal_squares({**dict(drive), "friction_coefficient": coefficient}, law=1)
        return bool(np.prod(np.sign(squares.real)) < 0)

    by_eigenvalues = bisected(turned, 0.0, largest)
    return xr.Dataset(
        {
            "stability": flagged(plane, kinds, "class of steady sliding", UndampedClass),
            "lower_boundary": variable(along, branches[:, 0], "N m-1", "lower boundary of mode coupling", "$k_1$"),
            "upper_boundary": variable(along, branches[:, 1], "N m-1", "upper boundary of mode coupling", "$k_1$"),
            "critical_friction": variable((), critical, "1", f"{word}, closed form", r"$\mu$"),
            "critical_friction_by_eigenvalues": variable((), by_eigenvalues, "1", passing, r"$\mu$"),
        },
        coords={
            **varied(friction_coefficient=friction, support_stiffness=stiffness, boundary_friction_coefficient=curve),
            "printed_critical_friction": printed(chapter.THRESHOLDS["critical_friction"], word),
            **drive_parameters(
                drive.replace(**dict.fromkeys(_DAMPINGS, 0.0)),
                axes=plane,
                printed=("Fig. 8.15", "Sect. 8.8.1"),
                assumed=("coupling_stiffness",),
                no_effect=("input_speed", "axial_force", "slide_friction", "bearing_friction"),
            ),
        },
        attrs=about(
            __doc__,
            "generalised eigenvalues of (8.23), boundaries (8.29) in closed form",
            "Sect. 8.8.1, Fig. 8.15",
            comment="R Omega > 0; undamped; for the parameters the text cites Table 7.1, which is not in the chapter",
        ),
    )


def _printed(values: Values, law: int = 1) -> SimpleNamespace:
    """Parameters and what is printed of them: b_1, b_2, b_3 of (8.29), and inertias.

    ``total`` S = m + m_1, ``lever`` χ = ξ_s r_m² tan λ, ``inertia`` Γ_0 = I − m χ of the drive with a rigid support,
    ``reduced`` Γ̃_0 = I − m̃ χ (8.28).
    """
    p = SimpleNamespace(**{name: np.asarray(value, dtype=float) for name, value in values.items()})
    geometry = p.pitch_radius, np.tan(p.lead_angle), printed_laws.factor(p, law)
    p.total, p.lever = p.mass + p.screw_mass, geometry[2] * geometry[0] ** 2 * geometry[1]
    p.inertia = effective_inertia(p.screw_inertia, p.mass, *geometry)
    p.reduced = effective_inertia(p.screw_inertia, together(p.mass, p.screw_mass), *geometry)
    turned = geometry[2] * p.mass * geometry[0] ** 2 * geometry[1]
    p.b_1, p.b_3 = (p.screw_inertia - turned) ** 2, p.total**2
    p.b_2 = 2 * (p.screw_mass * (turned - p.screw_inertia) - p.mass * (turned + p.screw_inertia))
    return p


def _branches(p: SimpleNamespace) -> np.ndarray:
    """Support stiffness k_1 [N/m] on both branches of the flutter boundary (8.29), the lower one first, last axis.

    With A² = S Γ̃_0 and B² = m² χ the coefficients of (8.29) are −b_2 = 2 (A² + B²), b_2² − 4 b_1 b_3 = 16 A² B² and
    S Γ_0 = A² − B², so the branches are perfect squares,

        k_1 = k [S / (A + B)]²   and   k_1 = k [(A + B) / Γ_0]²,

    without any subtraction but that inside Γ_0 and Γ̃_0. They are real and positive exactly if ξ_0 ≥ 0 and Γ̃_0 ≥ 0
    (8.32), NaN elsewhere; the upper one is infinite where Γ_0 = 0. They meet at μ = tan λ in k_1 = k S / I and on the
    kinematic constraint Γ̃_0 = 0 in k_1 = k S² m̃ / (m² I).
    """
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        both = np.sqrt(p.total * p.reduced) + p.mass * np.sqrt(p.lever)
        return np.stack([p.coupling_stiffness * x**2 for x in (p.total / both, both / p.inertia)], axis=-1)


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the critical friction, the boundaries, and the classes by it, by the printed conditions and by LAPACK.

    Classes but for rounding (``clear``), which may decide closer to a boundary.
    """
    drive, critical = newton.parameters(dataset), float(dataset.critical_friction)
    p = _printed(over_map(dataset, drive))
    p.a_4 = p.screw_inertia * p.total - p.mass * p.screw_mass * p.lever  # of ω⁴, as printed below (8.23)
    p.a_2 = -p.coupling_stiffness * p.total - p.support_stiffness * (p.screw_inertia - p.lever * p.mass)
    p.a_0 = p.coupling_stiffness * p.support_stiffness
    p.discriminant, size = p.a_2**2 - 4 * p.a_0 * p.a_4, p.a_2**2 + 4 * p.a_0 * np.abs(p.a_4)
    clear = (np.abs(p.discriminant) > 1e-9 * size) & (np.abs(p.a_4) > 1e-9 * p.screw_inertia * p.total)
    dataset = dataset.assign(clear=(dataset.stability.dims, clear))
    kinematic, part = named(dataset.stability, "kinematic constraint"), thinned(dataset, 100)
    off = kinematic != (dataset.friction_coefficient.values > critical)[:, None]
    # By (8.24) to (8.26); flutter where the last two hold.
    holds = np.broadcast_arrays(p.a_4 < 0, p.discriminant < 0, (p.a_4 > 0) & (p.a_2 > 0))
    printed_kinds = [UndampedClass.KINEMATIC_CONSTRAINT, UndampedClass.FLUTTER, UndampedClass.DIVERGENCE]
    by_print = np.select(holds, printed_kinds, UndampedClass.STABLE)
    wrong = by_print != dataset.stability.values
    theirs = eigenvalues(over_map(part, drive), law=1)
    limit = 1e-7 * np.abs(theirs).max(axis=-1)  # LAPACK keeps 1.5e-8 where two coincide
    growing, oscillates = (theirs.real > limit[..., None]).sum(axis=-1), np.abs(theirs[..., -1].imag) > limit
    kinds = [UndampedClass.STABLE, UndampedClass.FLUTTER, UndampedClass.KINEMATIC_CONSTRAINT]
    classes = np.select([growing == 0, oscillates, growing == 1], kinds, UndampedClass.DIVERGENCE)
    differ = classes != part.stability.values
    return [
        Check.of("fig8_15.critical_friction", critical),
        Check.of("fig8_15.eigenvalue", float(dataset.critical_friction_by_eigenvalues), expected=critical),
        Check.that("fig8_15.vertical", exceptions=never(off), kinematic_points=some(kinematic)),
        Check.that("fig8_15.classes", exceptions=never(wrong[clear])),
        Check.that("fig8_15.lapack", exceptions=never(differ[part.clear.values])),
        *_boundary_checks(dataset, drive, p),
        *_support_checks(dataset, drive),
    ]


def _boundary_checks(dataset: xr.Dataset, drive: Values, p: SimpleNamespace) -> list[Check]:
    """Check that no point is in two regions, their bounds, and both branches against (8.29) and where they exist.

    By the signs of a_4 and the discriminant of (8.24).
    """
    kinds = ("flutter", "kinematic constraint", "divergence")
    discriminant, a_4 = np.broadcast_arrays(p.discriminant, p.a_4)
    flutter, kinematic, divergence = (named(dataset.stability, kind) for kind in kinds)
    friction, k = dataset.friction_coefficient.values, drive["coupling_stiffness"]
    ends = [dataset[f"{name}_boundary"] for name in ("lower", "upper")]
    lower, upper = (end.reindex(boundary_friction_coefficient=friction).values[:, None] for end in ends)
    stiffness = dataset.support_stiffness.values
    beyond = (stiffness > upper) & (p.inertia < 0)
    judged = dataset.clear.values & ~kinematic
    first = friction[divergence.argmax(axis=0)[divergence.any(axis=0)]]  # by the stiffness of the support
    rigid = friction[p.inertia[:, 0] < 0].min(initial=np.inf)
    odd_flutter = (flutter != ((stiffness > lower) & (stiffness < upper)))[judged]
    branches = [end.values for end in ends]
    p = _printed({**drive, "friction_coefficient": dataset.boundary_friction_coefficient.values})
    terms = [np.array([p.b_1 * x**2, p.b_2 * k * x, p.b_3 * k**2 * np.ones_like(x)]) for x in branches]
    residual = [np.abs(term.sum(axis=0)) / np.abs(term).max(axis=0) for term in terms]
    p = _printed({**drive, "friction_coefficient": friction})
    roots = p.b_2**2 - 4 * p.b_1 * p.b_3
    rewritten = np.abs(roots - 16 * p.lever * p.mass**2 * p.total * p.reduced) / p.b_2**2
    clear = np.abs(roots) > 1e-9 * p.b_2**2  # else (8.30) is zero to rounding
    odd = ((roots >= 0) & (p.b_2 < 0)) != ((p.reduced >= 0) & (p.lever > 0))
    return [
        Check.that("fig8_15.apart", flutter_points=some(flutter), kinematic_points=some(kinematic),
                   flutter_in_both=never(a_4[flutter] < 0), kinematic_in_both=never(discriminant[kinematic] < 0)),
        Check.that("fig8_15.branches", exceptions=never(odd_flutter),
                   exceptions_beyond=never((divergence != beyond)[judged]), divergence=divergence),
        Check.that("fig8_15.third", steps=each(np.diff(first), "<=", 0), lowered=each(first[-1:] - first[:1], "<", 0),
                   above_rigid=each(first[-1:] - rigid, ">=", 0), first=first, rigid=rigid),
        Check.that("fig8_15.quadratic", lower=each(residual[0], "<", 1e-11), upper=each(residual[1], "<", 1e-11)),
        Check.that("fig8_15.real", exceptions=never(odd[clear]), rewritten=each(rewritten, "<", 1e-12)),
    ]  # fmt: skip


def _support_checks(dataset: xr.Dataset, drive: Values) -> list[Check]:
    """Check the kinematic constraint: (8.27) by Newton's laws, its necessary conditions, Remark 8.3; and flutter.

    The necessary conditions are μ > tan λ and R Ω > 0; there is flutter where a_2 = 0.
    """
    own = {**drive, "friction_coefficient": dataset.friction_coefficient.values}
    tan, r = np.tan(drive["lead_angle"]), drive["pitch_radius"]
    solves = {}  # x″ − x_1″ = r_m tan λ θ″ gives N: its coefficient has a sign for each law
    for law in (1, -1):
        push, friction = np.cos(drive["lead_angle"]), law * own["friction_coefficient"]
        turn = r**2 * tan * (friction - tan) * push / drive["screw_inertia"]
        solves[law] = push * (1 + friction * tan) * (1 / drive["mass"] + 1 / drive["screw_mass"]) - turn
    paradox, inertia = solves[1] * solves[-1] < 0, _printed(own).inertia
    kinematic = named(dataset.stability, "kinematic constraint")
    stiffness = -drive["coupling_stiffness"] * (drive["mass"] + drive["screw_mass"]) / inertia
    there = (inertia < 0) & ~paradox  # k_1 > 0 with a_2 = 0
    kinds = undamped_class({**own, "support_stiffness": np.where(there, stiffness, 1.0)}, law=1)
    early = kinematic[own["friction_coefficient"] <= tan]
    minus = _printed(own, law=-1)
    against = np.concatenate([minus.inertia, np.ravel(minus.reduced)])
    rigid = {name: value for name, value in drive.items() if name not in PART_OF}
    locked = Drive.of(rigid, friction_coefficient=float(dataset.critical_friction))
    critical_mass = [*place_values(locked, "kinematic_constraint", "mass"), np.nan][0]
    return [
        Check.that("fig8_15.necessary", points=never(early), law_minus=each(against, ">=", drive["screw_inertia"])),
        Check.of("fig8_15.reduced_mass", critical_mass, expected=together(drive["mass"], drive["screw_mass"])),
        Check.that("fig8_15.paradoxes", points=every(kinematic == paradox[:, None])),
        Check.that("fig8_15.flutter", frictions=every(kinds[there] == UndampedClass.FLUTTER)),
    ]


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the class map by eigenvalues, over it the boundaries in closed form and the critical friction."""
    figure = style.new_figure(style.DOUBLE, 3.8)
    axes = figure.add_subplot()
    friction, stiffness = dataset.friction_coefficient, dataset.support_stiffness
    colours = {name: colour for name, (colour, *_) in _REGIONS.items()}
    drawing.regions(axes, friction, stiffness, dataset.stability.T, colours)
    coarse = thinned(dataset, 250)  # enough rows and columns for hatching
    for name, (_, hatch, _) in _REGIONS.items():
        inside = named(coarse.stability, name).T.astype(float)
        if hatch and inside.any():
            drawing.hatched(axes, coarse.friction_coefficient, coarse.support_stiffness, inside, hatch, _HATCH)
    for which, dashes in (("lower", "-"), ("upper", "--")):
        axes.plot(dataset.boundary_friction_coefficient, dataset[f"{which}_boundary"], color=style.BLUE,
                  linestyle=dashes, linewidth=1.4, label=f"{which} branch of (8.29)")  # fmt: skip
    critical, printed = float(dataset.critical_friction), float(dataset.printed_critical_friction)
    axes.axvline(critical, color=style.VERMILION, linewidth=1.4, label=rf"$\mu_\mathrm{{kc}}$ = {critical:.4f}")
    axes.axvline(printed, **style.PRINTED, label=rf"$\mu_\mathrm{{kc}}$ = {printed:g}, as printed")
    style.frame(axes, "", friction, stiffness, yscale="log", xlim=friction[[0, -1]], ylim=stiffness[[0, -1]])
    return style.legend(figure, [axes], 2, drawing.patches(_REGIONS.values(), _HATCH))
