"""Figure 8.15: instability regions of the drive with axial support over friction coefficient and support stiffness."""

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.datasets import newton, spans
from lsvib.datasets.analysis import analyse, value
from lsvib.datasets.attributes import drive_parameters, flagged, variable, varied
from lsvib.datasets.checks import Check
from lsvib.figures import drawing, style
from lsvib.figures.common import about, named, over_map, printed, thinned
from lsvib.figures.settings import DriveFigure, PositiveSpan, Span, Values, parameter
from lsvib.models import chapter
from lsvib.models.drive import PART_OF, Drive
from lsvib.stability import conditions
from lsvib.stability.linear import UndampedClass, eigenvalues, undamped_class, values_of

CAPTION = """\
Stability of the undamped drive with axial support, R Ω > 0, over friction coefficient and support stiffness, by the
generalised eigenvalues of (8.23) at each point, with the boundaries (8.29) in closed form and the critical friction
coefficient (8.27). Beyond the upper branch, where the effective inertia of the drive with a rigid support is negative,
both modes diverge by (8.25). The chapter calls the horizontally hatched region the primary one of the kinematic
constraint: there the reduced effective inertia is negative. The third region, of divergence, is not in the chapter; as
the support stiffens it becomes the kinematic instability of the rigid drive. The stiffness of the coupling is assumed,
because Table 7.1 is not in the chapter; the boundaries of mode coupling are in proportion to it.
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
    unused = ("support_damping", "friction_coefficient", "input_speed", "translation_damping", "axial_force")

    screw_mass: parameter("screw_mass")
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
    branches = conditions.flutter_boundaries({**dict(drive), "friction_coefficient": curve}, law=1)
    along, word = "boundary_friction_coefficient", "critical friction coefficient"
    passing = "friction coefficient where an eigenvalue 1/omega^2 passes through zero"
    by_eigenvalues = conditions.critical_friction_by_eigenvalues(drive)
    return xr.Dataset(
        {
            "stability": flagged(plane, kinds, "class of the steady sliding", UndampedClass),
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
            comment="R Omega > 0; undamped; the text names Table 7.1, which is not in the chapter, for the parameters",
        ),
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the critical friction, the boundaries, and the classes by it, by the printed conditions and by LAPACK.

    Classes but for rounding (``clear``), which may decide closer to a boundary.
    """
    drive, critical = newton.parameters(dataset), float(dataset.critical_friction)
    grid = over_map(dataset, drive)
    a_4, a_2, a_0 = conditions.characteristic_polynomial(grid, law=1)
    discriminant, size = a_2**2 - 4 * a_0 * a_4, a_2**2 + 4 * a_0 * np.abs(a_4)
    inertia = drive["screw_inertia"] * (drive["mass"] + drive["screw_mass"])
    clear = (np.abs(discriminant) > 1e-9 * size) & (np.abs(a_4) > 1e-9 * inertia)
    dataset = dataset.assign(clear=(dataset.stability.dims, clear))
    kinematic, part = named(dataset.stability, "kinematic constraint"), thinned(dataset, 100)
    off = kinematic != (dataset.friction_coefficient.values > critical)[:, None]
    wrong = int(np.sum(clear & (conditions.printed_class(grid, law=1) != dataset.stability.values)))
    theirs = eigenvalues(over_map(part, drive), law=1)
    limit = 1e-7 * np.abs(theirs).max(axis=-1)  # LAPACK keeps 1.5e-8 where two coincide
    growing, oscillates = (theirs.real > limit[..., None]).sum(axis=-1), np.abs(theirs[..., -1].imag) > limit
    kinds = [UndampedClass.STABLE, UndampedClass.FLUTTER, UndampedClass.KINEMATIC_CONSTRAINT]
    classes = np.select([growing == 0, oscillates, growing == 1], kinds, UndampedClass.DIVERGENCE)
    differ, counts = part.clear.values & (classes != part.stability.values), {"clear": clear, "unclear": ~clear}
    return [
        Check.of("fig8_15.critical_friction", critical),
        Check.of("fig8_15.eigenvalue", float(dataset.critical_friction_by_eigenvalues), expected=critical),
        Check.that("fig8_15.vertical", not off.any() and kinematic.any(), off=off),
        Check.that("fig8_15.classes", wrong == 0 and clear.mean() > 0.99, wrong=wrong, **counts),
        Check.without_exception("fig8_15.lapack", differ.sum(), part.clear.sum()),
        *_boundary_checks(dataset, drive, a_4, discriminant),
        *_support_checks(dataset, drive),
    ]


def _boundary_checks(dataset: xr.Dataset, drive: Values, a_4: np.ndarray, discriminant: np.ndarray) -> list[Check]:
    """Check that no point is in two regions, their bounds, and both branches against (8.29) and where they exist.

    By the signs of a_4 and the ``discriminant`` of (8.24).
    """
    flutter, kinematic, divergence = (
        named(dataset.stability, x) for x in ("flutter", "kinematic constraint", "divergence")
    )
    both = int(np.sum((discriminant < 0) & kinematic) + np.sum((a_4 < 0) & flutter))
    friction, k = dataset.friction_coefficient.values, drive["coupling_stiffness"]
    ends = [dataset[f"{name}_boundary"] for name in ("lower", "upper")]
    lower, upper = (end.reindex(boundary_friction_coefficient=friction).values[:, None] for end in ends)
    stiffness, rigid = dataset.support_stiffness.values, {"law": 1, "rigid": True}
    beyond = (stiffness > upper) & (conditions.effective_inertia(over_map(dataset, drive), **rigid) < 0)
    judged = dataset.clear.values & ~kinematic
    off = judged & ((flutter != ((stiffness > lower) & (stiffness < upper))) | (divergence != beyond))
    apart = both == 0 and flutter.any() and kinematic.any()
    own = {**drive, "friction_coefficient": dataset.boundary_friction_coefficient.values}
    branches = [end.values for end in ends]
    b_1, b_2, b_3 = conditions.boundary_coefficients(own, law=1)
    terms = [np.array([b_1 * x**2, b_2 * k * x, b_3 * k**2 * np.ones_like(x)]) for x in branches]
    residual = max(np.max(np.abs(term.sum(axis=0)) / np.abs(term).max(axis=0)) for term in terms)
    finite = np.isfinite(branches[0]) & ~np.isnan(branches[1])
    own["friction_coefficient"] = friction
    b_1, b_2, b_3 = conditions.boundary_coefficients(own, law=1)
    p, reduced = values_of(own, law=1), conditions.effective_inertia(own, law=1)
    roots = b_2**2 - 4 * b_1 * b_3
    form = 16 * p.factor * p.pitch_radius**2 * p.tan_lead * p.mass**2 * (p.mass + p.screw_mass) * reduced
    rewritten = np.max(np.abs(roots - form) / b_2**2)
    clear = np.abs(roots) > 1e-9 * b_2**2  # else (8.30) is zero to rounding
    odd = clear & (((roots >= 0) & (b_2 < 0)) != ((reduced >= 0) & (p.factor > 0)))
    real = not odd.any() and finite.all() and rewritten < 1e-12
    return [
        Check.that("fig8_15.apart", apart, both=both, flutter=flutter, kinematic=kinematic),
        Check.that("fig8_15.branches", not off.any(), off=off, judged=judged, divergence=divergence),
        Check.that("fig8_15.quadratic", residual < 1e-11, residual=residual),
        Check.that("fig8_15.real", real, odd=odd, finite=finite, rewritten=rewritten),
    ]


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
    paradox, inertia = solves[1] * solves[-1] < 0, conditions.effective_inertia(own, law=1, rigid=True)
    kinematic = named(dataset.stability, "kinematic constraint")
    stiffness = -drive["coupling_stiffness"] * (drive["mass"] + drive["screw_mass"]) / inertia
    there = (inertia < 0) & ~paradox  # k_1 > 0 with a_2 = 0
    kinds = undamped_class({**own, "support_stiffness": np.where(there, stiffness, 1.0)}, law=1)
    early = kinematic[own["friction_coefficient"] <= tan]
    against = min(np.min(conditions.effective_inertia(own, law=-1, rigid=rigid)) for rigid in (True, False))
    necessary = not early.any() and against >= drive["screw_inertia"]
    reduced_mass = drive["mass"] * drive["screw_mass"] / (drive["mass"] + drive["screw_mass"])
    rigid = {name: value for name, value in drive.items() if name not in PART_OF}
    locked = Drive.of(rigid, friction_coefficient=float(dataset.critical_friction))
    return [
        Check.that("fig8_15.necessary", necessary, early=early, against=against),
        Check.of("fig8_15.reduced_mass", conditions.critical_value(locked, "mass") or np.nan, expected=reduced_mass),
        Check.everywhere("fig8_15.paradoxes", kinematic == paradox[:, None], "points"),
        Check.everywhere("fig8_15.flutter", kinds[there] == UndampedClass.FLUTTER, "friction coefficients"),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the class map by eigenvalues, over it the boundaries in closed form and the critical friction."""
    figure = style.new_figure(style.DOUBLE, 3.8)
    axes = figure.add_subplot()
    friction, stiffness = dataset.friction_coefficient, dataset.support_stiffness
    colours = {name: colour for name, (colour, *_) in _REGIONS.items()}
    drawing.regions(axes, friction, stiffness, dataset.stability.T, colours)
    # 250 rows and columns are enough for hatching.
    coarse = thinned(dataset, 250)
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
    return style.legend(figure, [axes], 1, drawing.patches(_REGIONS.values(), _HATCH), "outside right upper")
