"""Phase portraits of the contact force (Sect. 8.2), figures 8.1 and 8.2: dataset, checks and picture.

The abscissa is the chapter's χ = N b_s / W (8.8). The ordinate is its rate, scaled by the time and force scale of law −
on both sides, so that it is continuous at χ = 0; see :mod:`lsvib.chapter.contact_force`.
"""

import math
from collections.abc import Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers import spans
from lsvib.answers.attributes import Variables, attributes, drive_parameters, flagged, named, named_index, variable
from lsvib.chapter import contact_force, newton, printed_laws
from lsvib.chapter.checks import Check, each, every, never, some
from lsvib.chapter.common import EIGENVALUE, Figure, Motion, about
from lsvib.chapter.contact_force import ForceOutcome, Paradox
from lsvib.chapter.settings import ContactPortrait, Values
from lsvib.drives.chapter import PARTS
from lsvib.drives.drive import Drive
from lsvib.errors import InputError
from lsvib.pictures import drawing, style
from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels.layout import A1, ALPHA, BETA, EQUILIBRIUM, R1, R2, Status

_LAWS = (1, -1)  # sgn(θ′) sgn(N), in the order of the dimension
_UNIT = "kg-1 m-2"
_SIGN_OF_FORCE = {
    Paradox.INDETERMINATE: "theta' > 0 and W < 0, so that N has the sign opposite to chi",
    Paradox.INCONSISTENT: "theta' > 0 and W > 0, so that N has the sign of chi",
}
_OF_RATE = (
    "derivative of N b_- / W with respect to scaled time omega_- t, omega_-^2 = k_c cos(lambda) b_- Gamma_- / (m I), "
    "b_s = cos(lambda) + s mu sin(lambda); see (8.8), (8.9)"
)
# Each begins at the saddle; on the side of law + where the saddle lies, or across zero force to the side of law -.
_MANIFOLDS = [f"{kind}_{way}_zero_force" for kind in ("unstable", "stable") for way in ("away_from", "across")]


def portrait(settings: Values, paradox: Paradox, figure: str, places: str) -> xr.Dataset:
    """Compute motions of the contact force, their outcomes on a grid, and the saddle's manifolds; Γ₊ < 0, θ′ > 0."""
    base = Drive.of({"contact_stiffness": settings["contact_stiffness"], **settings["drive"]})
    drives = [base.replace(contact_damping=damping) for damping in settings["contact_dampings"]]
    cases = [contact_force.contact_automaton(drive, paradox) for drive in drives]
    force, rate = spans.even(settings["force"]), spans.even(settings["rate"])
    scale, count = contact_force.force_scale(base), settings["samples"]
    # A motion is followed until it is so many times the half width of the map away.
    limit = 30.0 * max(np.ptp(force), np.ptp(rate)) / 2

    def motions_from(starts: Sequence[tuple[float, float]]) -> list[list[Motion]]:
        """The motions of each case from χ and its rate."""
        own = [(float(_scaled(x, 1 / scale, paradox)), float(y)) for x, y in starts]
        return [[_followed(case, start) for start in own] for case in cases]

    followed = motions_from([(start["force"], start["rate"]) for start in settings["starts"]])
    states = np.array([[sample(motion, count, limit) for motion in case] for case in followed])
    on_grid = [[*map(contact_force.outcome, case)] for case in motions_from([*product(force, rate)])]
    ends, dims = [[*map(contact_force.outcome, case)] for case in followed], ("case", "start", "sample")
    plane, ratios = ("case", "grid_contact_force", "grid_contact_force_rate"), [c.tables.flow[1, A1] for c in cases]
    sides, on = [int(paradox), -int(paradox)], "sign of the contact force chi where the law holds"
    becomes, times = "outcome of the contact force", "times frequency over stiffness"
    outcomes = np.reshape(on_grid, (len(cases), force.size, rate.size))
    return xr.Dataset(
        {
            "contact_force": (dims, _scaled(states[..., 0], scale, paradox), _force("contact force")),
            "contact_force_rate": (dims, states[..., 1], _rate("rate of the contact force")),
            "start_outcome": flagged(dims[:2], ends, f"{becomes} in a motion", ForceOutcome),
            "grid_outcome": flagged(plane, outcomes, f"{becomes} from each state of the grid", ForceOutcome),
        }
        | _laws(cases, scale)
        | (_saddle_manifolds(drives, count, limit, scale) if paradox is Paradox.INDETERMINATE else {}),
        coords={
            "grid_contact_force": (plane[1], force, _force("contact force of the grid")),
            "grid_contact_force_rate": (plane[2], rate, _rate("rate of the grid")),
            "law": variable("law", np.array(_LAWS), "1", "friction law", "$s$"),
            "law_side": variable("law", sides, "1", on, comment=_SIGN_OF_FORCE[paradox]),
            "eigenvalue": EIGENVALUE,
            **drive_parameters(drives, along=("contact_damping",), no_effect=ContactPortrait.unused),
            "contact_damping_ratio": variable("case", ratios, "1", f"contact damping {times}", r"$\zeta$"),
            "force_scale": variable((), scale, "1", "factor between the force scales of the laws", "$b_+/b_-$"),
        },
        attrs=about(
            f"Figure {figure}: phase portrait of the contact force in the {paradox.name.lower()} case, without and "
            "with contact damping",
            "closed-form flow of the contact force (8.12) with exact changes of the law",
            places,
        ),
    )


def _followed(automaton: Automaton, start: tuple[float, float], most: int = 1000) -> Motion:
    """Follow (x, x′) until nothing changes the law any more, or for so many changes: then it repeats itself."""
    from lsvib.systems.motion import follow

    return follow(automaton, start, math.inf, max_events=most)


def _laws(cases: Sequence[Automaton], scale: float) -> Variables:
    """The equilibrium of each law, which contact damping does not move, and its eigenvalues."""
    flows = np.array([case.tables.flow for case in cases])
    real = np.where(flows[..., [BETA]] > 0, -flows[..., [ALPHA]], flows[..., [R1, R2]])
    imaginary = flows[..., [BETA]] * [1, -1]
    dims, part = ("case", "law", "eigenvalue"), "part of an eigenvalue of the law in scaled time"
    zero = "equilibrium of the law, zero of the right-hand side of (8.7)"
    return {
        "equilibrium_contact_force": ("law", flows[0, :, EQUILIBRIUM] * [scale, 1.0], _force(zero)),
        "scaled_eigenvalue_real_part": variable(dims, real, "1", f"real {part}", r"Re $\varepsilon$"),
        "scaled_eigenvalue_imaginary_part": variable(dims, imaginary, "1", f"imaginary {part}", r"Im $\varepsilon$"),
    }


def sample(motion: Motion, count: int, limit: float, end: float = math.inf) -> np.ndarray:
    """Sample (x, x′) at ``count`` times, evenly until ``end`` and where the law changes; shape (count, 2).

    A motion that repeats itself ends by its third change of law, one that does not beyond |x − x*| = ``limit`` of the
    last law, or after a turn or some decay times, when e⁻⁸ of it is left.
    """
    row, growing = motion.automaton.tables.flow[motion.end_mode], abs(contact_force.growing_part(motion))
    slowest = abs(row[ALPHA] if row[BETA] > 0 else row[R1])
    if motion.status != Status.SETTLED:
        last = motion.time[2]
    elif growing > 0:
        last = motion.end_time + max(math.log(limit / growing), 0.0) / row[R1]
    else:
        last = motion.end_time + (8.0 / slowest if slowest else 2 * math.pi / row[BETA])
    changes = motion.time[motion.time <= (end := min(end, last))]
    if count < (least := changes.size + 2):
        raise InputError(f"samples = {count} is outside the allowed range samples >= {least} of this motion.")
    return motion.at(np.sort([*changes, *np.linspace(0, end, count - changes.size)]))[0]


def _saddle_manifolds(drives: Sequence[Drive], count: int, limit: float, scale: float) -> Variables:
    """Unstable and, backwards in time, stable manifold of the saddle: a ray at the side of law +, and one beyond.

    Each from so close to the saddle that a picture cannot tell, on a straight line, until back at law +; without
    damping back to the saddle, by symmetry in the time that it took to leave.
    """
    side, lines = Paradox.INDETERMINATE, []
    for drive, back, outwards in product(drives, (False, True), (side, -side)):
        automaton = contact_force.contact_automaton(drive, side, backwards=back)
        row = automaton.tables.flow[0]
        near = 1e-6 * abs(row[EQUILIBRIUM]) * outwards
        motion = _followed(automaton, (row[EQUILIBRIUM] + near, row[R1] * near), 3)
        there, across, again = np.append(motion.time[:3], [math.inf] * 3)[:3]
        lines.append(sample(motion, count, limit, across + there if row[A1] == 0 else again))
    points = np.reshape(lines, (len(drives), 4, count, 2))
    points[:, 2:, :, 1] *= -1  # forwards in time again
    force, dims = _scaled(points[..., 0], scale, side), ("case", "manifold", "sample")
    order = "samples start at the saddle; along a stable branch they run backwards in time"
    return {
        "manifold_force": (dims, force, _force("contact force on a manifold of the saddle")),
        "manifold_force_rate": (dims, points[..., 1], _rate("rate on a manifold of the saddle")),
        "manifold": named_index("manifold", "branch of the manifolds of the saddle", _MANIFOLDS, comment=order),
    }


def _scaled(x: Any, scale: float, side: int) -> Any:
    """χ from x, or x from χ by one over the ``scale``: equal on the side of law −, scaled on that of law +."""
    return np.where(x * side > 0, x * scale, x)


def _force(long_name: str) -> dict[str, Any]:
    return attributes(_UNIT, long_name, r"$\chi$", comment="chi = N b_s / W, (8.8)")


def _rate(long_name: str) -> dict[str, Any]:
    return attributes(_UNIT, f"{long_name}, scaled by law - on both sides", r"$\chi'$", comment=_OF_RATE)


def _potential(case: xr.Dataset, force: xr.DataArray) -> Any:
    """Potential of x″: −ρ² x²/2 − x/Γ₋ on the side of law +, x²/2 − x/Γ₋ on that of law −."""
    plus, minus = (printed_laws.inertia(case, law) for law in _LAWS)
    x = (force / case.force_scale).where(force * case.law_side.sel(law=1, drop=True) > 0, force)
    stiffness = (case.force_scale * plus / minus).where(x * case.law_side.sel(law=1, drop=True) > 0, 1.0)
    return stiffness * x**2 / 2 - x / minus


def _by_newton(dataset: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Zeros (law), traces and determinants (case, law) of the Jacobian of N″ by Newton's laws alone, θ′ > 0.

    With constant T and P e″ = x″ − r_m tan λ θ″ is affine in N, and N″ = cos λ (k_c e″ + c_c ∂e″/∂N N′). Time in units
    of law − without contact damping.
    """
    p = {**newton.parameters(dataset), "contact_damping": 0.0}
    torque, lead = -0.01, p["pitch_radius"] * math.tan(p["lead_angle"])  # T [N m]; χ depends on it as little as on R
    rigidity = p["contact_stiffness"] * math.cos(p["lead_angle"])  # N over e
    accelerations = np.array([newton.equations(p, law, True)[0][3] for law in _LAWS])  # e″ over (z, …, 1)
    offsets = accelerations[:, 0] * -torque / p["coupling_stiffness"] + accelerations[:, -1]
    slopes = accelerations[:, 2] / rigidity
    drift = p["screw_inertia"] * p["axial_force"] - p["mass"] * lead * torque  # W
    zeros = -offsets / slopes * [float(printed_laws.lever(dataset, law)) for law in _LAWS] / drift
    unit = math.sqrt(-rigidity * slopes[1])  # 1/s
    dampings = dataset.contact_damping.values[:, None] * math.cos(p["lead_angle"])
    return zeros, dampings * slopes / unit, -rigidity * slopes / unit**2


def _common_checks(dataset: xr.Dataset, outcome: str) -> list[Check]:
    """Check what both portraits have: how motions of an ``outcome`` grow in the end, the energy, and Newton's laws.

    The closed forms (8.11), (8.12) make no use of these laws. Energy is constant along the motions of the case without
    contact damping, the first.
    """
    case, (zeros, traces, determinants) = dataset.isel(case=0), _by_newton(dataset)
    parts = xr.concat([_potential(case, case.contact_force), case.contact_force_rate**2 / 2], "part")
    total, size = parts.sum("part"), abs(parts).max(["part", "sample"])
    spread = (total.max("sample") - total.min("sample")) / size
    distance = dataset.contact_force[..., -1] - dataset.equilibrium_contact_force.sel(law=1)
    rate = dataset.contact_force_rate[..., -1] * dataset.force_scale / distance
    off = abs(rate / dataset.scaled_eigenvalue_real_part.sel(law=1).max("eigenvalue") - 1)
    growth = off.values[named(dataset.start_outcome, outcome)]
    gap = abs(dataset.equilibrium_contact_force / zeros - 1)
    values = dataset.scaled_eigenvalue_real_part + 1j * dataset.scaled_eigenvalue_imaginary_part
    first, second = values.isel(eigenvalue=0), values.isel(eigenvalue=1)
    trace, product = np.abs(first + second - traces) / np.abs(first), np.abs(first * second / determinants - 1)
    ratio = abs(dataset.contact_damping_ratio + traces[:, 1])
    return [
        Check.that("contact_portraits.equilibria", gap=each(gap, "<=", 1e-12)),
        Check.that("contact_portraits.eigenvalues", trace=each(trace, "<=", 1e-12), product=each(product, "<=", 1e-12),
                   damping_ratio=each(ratio, "<=", 1e-12)),
        Check.that("contact_portraits.energy", spread=each(spread, "<", 1e-12)),
        Check.that("contact_portraits.growth", gap=each(growth, "<", 0.01)),
    ]  # fmt: skip


def _indeterminate_checks(dataset: xr.Dataset) -> list[Check]:
    """Check saddle and centre, both outcomes and what decides between them, and the focus under contact damping.

    A contact force stays in the loop of the saddle's separatrix, by the energy integral of (8.11): 0 at the origin.
    """
    elastic, damped = dataset.isel(case=0), dataset.isel(case=1)
    bounded, unbounded = (named(elastic.grid_outcome, word) for word in ("bounded", "minus infinity"))
    energy = _potential(elastic, elastic.grid_contact_force) + elastic.grid_contact_force_rate**2 / 2
    top = elastic.equilibrium_contact_force.sel(law=1)
    level = float(_potential(elastic, top))
    inside = ((energy < level) & (elastic.grid_contact_force > top)).values
    rims = _potential(elastic, elastic.manifold_force) + elastic.manifold_force_rate**2 / 2
    last = dataset.contact_force.values[named(dataset.start_outcome, "minus infinity")][:, -1]
    real, imaginary = dataset.scaled_eigenvalue_real_part, dataset.scaled_eigenvalue_imaginary_part
    (saddle, growth), (twist, frequency) = ([part.sel(law=law) for law in _LAWS] for part in (real, imaginary))
    ends = damped.contact_force.values[named(damped.start_outcome, "bounded"), -1]
    # e⁻⁸ of a start is left where the motions end.
    gap = np.abs(ends * float(printed_laws.inertia(damped, -1)) - 1)
    stiff, focus = PARTS["threads"], damped.contact_damping_ratio
    node = focus / damped.contact_damping * np.sqrt(damped.contact_stiffness / stiff["contact_stiffness"])
    chi, eigenvalues = dataset.equilibrium_contact_force, str(saddle.values.round(4).tolist())
    return [
        *_common_checks(dataset, "minus infinity"),
        Check.that("fig8_01.manifolds", level=each(abs(rims / level - 1), "<", 1e-9)),
        Check.that("fig8_01.two_solutions", equilibria=every(chi * dataset.law_side > 0), chi=chi),
        Check.that("fig8_01.saddle", product=each(saddle.prod("eigenvalue"), "<", 0),
                   real_eigenvalues=every(twist == 0), eigenvalues=eigenvalues),
        Check.that("fig8_01.centre", undamped_eigenvalues=every(growth[0] == 0),
                   complex_eigenvalues=every(frequency[0] != 0), frequency=abs(frequency[0, 0])),
        Check.that("fig8_01.loop", exceptions=never(bounded != inside)),
        Check.that("fig8_01.outcomes", bounded=some(bounded), unbounded=some(unbounded),
                   starts=every(bounded | unbounded)),
        Check.that("fig8_01.unbounded", ends=each(last, "<", dataset.grid_contact_force.min())),
        Check.that("fig8_01.focus", real=each(growth[1], "<", 0), complex_eigenvalues=every(frequency[1] != 0),
                   node=each(node * stiff["contact_damping"], ">", 2), focus=focus,
                   imaginary=abs(frequency[1, 0])),
        Check.that("fig8_01.settles", gap=each(gap, "<", 0.01), ends=ends),
    ]  # fmt: skip


def _inconsistent_checks(dataset: xr.Dataset) -> list[Check]:
    """Check that nothing is in equilibrium and that every contact force ends growing in the first quadrant."""
    chi, sides = dataset.equilibrium_contact_force, dataset.law_side
    force, rate = (x.values[..., -2:] for x in (dataset.contact_force, dataset.contact_force_rate))
    return [
        *_common_checks(dataset, "plus infinity"),
        Check.that("fig8_02.no_solution", equilibria=every(chi * sides < 0), chi=chi, sides=sides),
        Check.that("fig8_02.every_start", starts=every(named(dataset.grid_outcome, "plus infinity"))),
        Check.that("fig8_02.drawn", motions=every(named(dataset.start_outcome, "plus infinity")),
                   force=each(force, ">", 0), force_rises=each(np.diff(force), ">", 0),
                   rate=each(rate, ">", 0), rate_rises=each(np.diff(rate), ">", 0)),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw motions, equilibria and manifolds, in a panel for each contact damping; the words say where a law holds.

    Equilibria are open where the law does not hold, so that they are none.
    """
    figure = style.new_figure(style.DOUBLE, 3.35)
    panels = figure.subplots(1, dataset.sizes["case"], sharey=True)
    limits = [dataset[name].values[[0, -1]] for name in ("grid_contact_force", "grid_contact_force_rate")]
    for axes, letter, case in zip(panels, "ab", (dataset.isel(case=i) for i in dataset.case.values), strict=True):
        _lines(axes, case)
        paths: list[drawing.DrawnLine] = []
        for motion in (case.isel(start=index) for index in dataset.start.values):
            x, y, stays = motion.contact_force.values, motion.contact_force_rate.values, motion.start_outcome
            bounded = named(stays, "bounded")
            colour, name = (style.BLUE, "bounded") if bounded else (style.ORANGE, "growing without bound")
            axes.plot(x, y, color=colour, linewidth=1.0, label=name, zorder=2)
            axes.plot(x[0], y[0], "o", color=colour, mfc="white", markersize=3.2, label="start", zorder=3,
                      clip_on=False)  # fmt: skip
            paths.append((x, y, colour))
        if "manifold_force" in case:  # all are stored outwards from the saddle
            manifolds = zip(case.manifold_force.values, case.manifold_force_rate.values, (1, 1, -1, -1), strict=True)
            paths += [(x[::along], y[::along], style.BLACK) for x, y, along in manifolds]
        for law, marker, words in ((1, "X", r"saddle $1/\Gamma_+$"), (-1, "D", r"centre or focus $1/\Gamma_-$")):
            x = float(case.equilibrium_contact_force.sel(law=law))
            real = x * float(case.law_side.sel(law=law)) > 0
            look = {"color": style.GREEN, "mfc": style.GREEN if real else "white", "markersize": 6, "linestyle": "none"}
            axes.plot(x, 0, marker, label=f"{words}{'' if real else ', virtual'}", zorder=5, **look)
        axes.axvline(0, color=style.GREY, linewidth=0.9, zorder=1)
        damping = float(case.contact_damping_ratio)
        words = f"ours: contact damping, $\\zeta$ = {damping:.2g}" if damping else "elastic contact"
        axes.set_title(f"({letter}) {words}", y=1.0, pad=13)  # clear of the power of ten
        axes.set(xlabel=style.label(case.contact_force, "scaled contact force"), xlim=limits[0], ylim=limits[1])
        drawing.arrows(axes, paths)
        for side, text in zip(case.law_side.values, ("law +: $N > 0$", "law −: $N < 0$"), strict=True):
            place = 0.02 * side * np.ptp(limits[0]), limits[1][0] + 0.04 * np.ptp(limits[1])
            axes.text(*place, text, ha="left" if side > 0 else "right")
    panels[0].set_ylabel(style.label(dataset.contact_force_rate, "rate"))
    return style.legend(figure, panels, 4 if "manifold_force" in dataset else 3)


def _lines(axes: style.Axes, case: xr.Dataset) -> None:
    """Draw the manifolds of the saddle and what they enclose, or the unstable one that every motion approaches."""
    dashed: dict[str, Any] = {"color": style.BLACK, "linewidth": 1.0, "linestyle": (0, (4, 2))}
    if "manifold_force" in case:
        x, y = case.manifold_force.values, case.manifold_force_rate.values
        rim = [np.concatenate([z[3], z[2][::-1]]) for z in (x, y)]
        axes.fill(*rim, color="#DCEBF7", linewidth=0, label="contact force stays bounded", zorder=0)
        for k, stable in enumerate((False, False, True, True)):
            look = {"color": style.BLACK, "linewidth": 1.5} if stable else dashed
            name = "stable manifold of the saddle" if stable else "unstable manifold"
            axes.plot(x[k], y[k], zorder=2.4, label=name, **look)
        return
    slope = float(case.scaled_eigenvalue_real_part.sel(law=1).max()) / float(case.force_scale)
    x = np.array([0.0, float(case.grid_contact_force[-1])])
    y = slope * (x - float(case.equilibrium_contact_force.sel(law=1)))
    axes.plot(x, y, label="asymptote from the virtual saddle", **dashed)


fig8_01 = Figure(
    ContactPortrait,
    """\
Phase portrait of the contact force in stiff threads, in the indeterminate case and with the screw turning forwards, (a)
without contact damping and (b), not in the chapter, with it. Abscissa: the chapter's force χ (8.8), of opposite sign
to N; ordinate: its rate, to the same scale on both sides. Law + has a saddle where N is positive, law − a centre or a
focus where it is negative; the saddle's stable manifold separates contact forces that stay bounded from those that grow
without bound. In (a), part of the unstable manifold coincides with it. Arrows point forward in time.
""",
    partial(portrait, paradox=Paradox.INDETERMINATE, figure="8.1", places="Sect. 8.2, Fig. 8.1, Remark 8.1"),
    _indeterminate_checks,
    draw,
)
fig8_02 = Figure(
    ContactPortrait,
    """\
Phase portrait of the contact force in stiff threads, in the inconsistent case and with the screw turning forwards, (a)
without contact damping and (b), not in the chapter, with it. Both equilibria lie where the other law holds, so there is
no solution; every contact force ends up growing in the first quadrant, along the unstable manifold of the virtual
saddle. Arrows point forward in time.
""",
    partial(portrait, paradox=Paradox.INCONSISTENT, figure="8.2", places="Sect. 8.2, Fig. 8.2"),
    _inconsistent_checks,
    draw,
)
