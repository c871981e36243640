"""The basin of steady sliding: its exact size against force, damping, mass and friction, and against grids."""

from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from typing import Annotated

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.basins.grid import Axis, Grid
from lsvib.datasets import newton, phase_plane, spans
from lsvib.datasets.analysis import analyse
from lsvib.datasets.attributes import CRITICAL_MASS, Variables, axis, drive_parameters, flagged, variable, varied
from lsvib.datasets.checks import Check
from lsvib.figures import drawing, style
from lsvib.figures import settings as of
from lsvib.figures.common import Basin, about, flag_names, named, spread
from lsvib.models.drive import Drive
from lsvib.stability.force_thresholds import threshold_force

CAPTION = """\
The basin of steady sliding: (a) to (c) its exact boundary, one kind to a panel, with the part of the window that it
fills and the part of a grid of starts that settles; (d) to (g) the exact fraction of the window u = −0.3 to 0.3 rad, u′
= −150 to 150 rad/s over one parameter at a time around m = 11 kg, c = 1e-3 N m s/rad, R = −10 N (dashed), with the
limits of global stability: a force, a damping, the critical mass m_cr and the friction coefficient at which the
effective inertia of law + vanishes. See docs/basin.md.
"""

_SWEPT = {  # what each panel is called, its threshold, how that is named, decimals
    "axial_force": ("axial force", "global_stability_force", "$R$", 2),
    "support_damping": ("support damping", "", "$10^3\\,c$", 3),
    "mass": ("mass", "critical_mass", "$m_\\mathrm{cr}$", 3),
    "friction_coefficient": ("friction", "critical_friction_of_rigid_drive", "$\\mu_\\mathrm{cr}$", 4),
}
_FRACTION = "fraction of the window that steady sliding attracts, exact"
_PRINTED = ("Fig. 8.14", "Sect. 8.6")
_KINDS = {  # what bounds the basin: colour, words
    "none": (style.BLACK, "no boundary: globally stable"),
    "touching motion": (style.BLUE, "bounded by the motion that touches $N = 0$, and by $N = 0$"),
    "touching slip": (style.ORANGE, "bounded by the slip from $\\dot\\theta = 0$ that touches $N = 0$"),
    "cycle": (style.PURPLE, "bounded by a cycle that repels"),
}


class SweepCase(of.SettingsSection):
    """Changes of `drive`, and the window in which its basin is drawn."""

    drive: of.DriveChanges
    window: of.PlaneWindow


class Settings(of.DriveFigure):
    window: of.PlaneWindow
    axial_force: of.Span = Field(description="R [N], against the motion.")
    support_damping: of.PositiveSpan = Field(description="c [N m s/rad].")
    mass: of.PositiveSpan = Field(description="m [kg].")
    friction_coefficient: of.PositiveSpan = Field(description="mu [1].")
    cases: of.several(SweepCase, 1, 3, "Drives whose basins are drawn and compared with grids.")
    resolutions: Annotated[list[Annotated[int, Field(ge=2, le=10_000)]], *of.Unique] = Field(
        min_length=2, description="Starts along each edge of the grids, ascending."
    )
    masses: of.MassPair = Field(description="Mass as printed for Fig. 8.14, and mass beyond the critical one [kg].")
    axial_forces: of.OpposingForces = Field(description="Axial forces of Fig. 8.14 (a) and (b) [N].")


def analysis(settings: of.Values) -> xr.Dataset:
    """Analyse the drive: up to which force, mass and friction its basin is the whole plane."""
    unknowns = ("mass", "friction_coefficient")
    limits = ("global_stability", "axial_force"), *(("kinematic_constraint", unknown) for unknown in unknowns)
    return analyse([Drive.of(settings["drive"])], limits, printed=_PRINTED)


def maps(settings: of.Values) -> xr.Dataset:
    """Map a grid of starts of the window of each case to their attractors, at each resolution."""
    from lsvib.basins.mapper import mapper

    drive, found = Drive.of(settings["drive"]), Variables()
    drives, windows = zip(*((drive.replace(**c["drive"]), c["window"]) for c in settings["cases"]), strict=True)
    for n in settings["resolutions"]:
        grids = [Grid(Axis("u", w["left"], w["right"], n), Axis("w", w["bottom"], w["top"], n)) for w in windows]
        pairs = zip(drives, grids, strict=True)
        labels = [mapper(one).cells(grid, quantities=("label",))["label"] for one, grid in pairs]
        dims, words = ("case", f"velocity_{n}", f"angle_{n}"), f"{phase_plane.ATTRACTOR}, from {n} x {n} starts"
        found[f"attractor_{n}"] = phase_plane.attractors(dims, labels, words)
    return xr.Dataset(
        found, attrs=about(__doc__, "exact event-driven motion from the middle of every cell", "Sect. 8.7, Fig. 8.14")
    )


def build(settings: of.Values, analysis: xr.Dataset, maps: xr.Dataset) -> xr.Dataset:
    """Compute the basins of a few drives, exactly and on grids, and the exact share of a window along four sweeps."""
    from lsvib.basins.boundary import Boundary, basin
    from lsvib.basins.curves import Window

    drive, window, variables = Drive.of(settings["drive"]), Window(**settings["window"]), Variables()
    swept = {name: _swept(drive, name, spans.even(settings[name])) for name in _SWEPT}
    for name, (values, basins) in swept.items():
        dim, kinds = f"swept_{name}", [b.boundary for b in basins]
        variables |= axis(dim, values)
        variables[f"fraction_{name}"] = variable(dim, [b.fraction(window) for b in basins], "1", _FRACTION)
        variables[f"boundary_kind_{name}"] = flagged(dim, kinds, "what bounds the basin", Boundary)
    areas, words = [b.area() for b in swept["axial_force"][1]], "area of the basin, infinite where it has no bound"
    variables["basin_area_axial_force"] = variable("swept_axial_force", areas, "rad2 s-1", words)
    masses, forces = settings["masses"], settings["axial_forces"]
    readings = [[basin(drive.replace(mass=m, axial_force=r)).fraction(window) for r in forces] for m in masses]
    variables |= varied(reading_mass=masses, reading_axial_force=forces)
    variables["reading_fraction"] = variable(("reading_mass", "reading_axial_force"), readings, "1", _FRACTION)
    variables |= phase_plane.window_edges("window", "edge", window) | _cases(drive, settings["cases"], maps)
    dampings, friction = swept["support_damping"][0], analysis.kinematic_constraint_friction_coefficient[0]
    stable, damped = ("N", phase_plane.GLOBAL_STABILITY, "$R$"), [drive.replace(support_damping=c) for c in dampings]
    limits = [threshold_force(d, "global_stability") for d in damped]
    variables |= {
        "swept_global_stability_force": variable("swept_support_damping", limits, *stable),
        "critical_mass": ((), float(analysis.kinematic_constraint_mass[0]), CRITICAL_MASS),
        "critical_friction_of_rigid_drive": ((), float(friction), friction.attrs),
        "global_stability_force": variable((), float(analysis.global_stability_axial_force[0]), *stable),
    }
    return xr.Dataset(
        variables,
        coords=drive_parameters(drive, printed=_PRINTED),
        attrs=about(
            __doc__, "exact boundary of the basin; grids by the map of the region of attraction", "Sect. 8.7, Fig. 8.14"
        ),
    )


def _swept(drive: Drive, name: str, values: np.ndarray) -> tuple[np.ndarray, list[Basin]]:
    """The basins along one parameter; where the kind of boundary changes, two more values close to the change."""
    from lsvib.basins.boundary import basin

    @cache
    def at(value: float) -> Basin:
        return basin(drive.replace(**{name: value}))

    chosen = set(values.tolist())
    for low, high in pairwise(values.tolist()):
        kind = at(low).boundary
        while at(high).boundary != kind and high - low > 1e-6 * max(abs(low), abs(high)):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if at(middle).boundary == kind else (low, middle)
        chosen |= {low, high}
    return np.array(sorted(chosen)), [at(value) for value in sorted(chosen)]


def _cases(drive: Drive, cases: Sequence[of.Values], maps: xr.Dataset) -> Variables:
    """Basins to be drawn: boundary and region as sampled curves, exact fraction of their window, fractions on grids."""
    from lsvib.basins.boundary import Boundary, basin
    from lsvib.basins.curves import Window, sampled

    drives, windows = [drive.replace(**c["drive"]) for c in cases], [Window(**c["window"]) for c in cases]
    basins = [basin(d) for d in drives]
    pairs = list(zip(basins, windows, strict=True))
    lines, regions = [b.line(w, 60) for b, w in pairs], [sampled(b.flow, b.clipped(w), 60) for b, w in pairs]
    resolutions = [labels.shape[-1] for labels in maps.values()]
    grid = np.array([named(labels, "steady sliding").mean(axis=(1, 2)) for labels in maps.values()]).T
    # A boundary passes from cell to cell across one edge at a time; 16 for its ends and where it turns.
    steps = [
        float(np.nansum(np.abs(np.diff(line, axis=0)) / [w.right - w.left, w.top - w.bottom]))
        for line, w in zip(lines, windows, strict=True)
    ]
    bound = [[(n * step + 16) / n**2 for n in resolutions] for step in steps]
    changed = tuple(name for name, value in drive if len({value, *(getattr(d, name) for d in drives)}) > 1)
    own = drive_parameters(drives, along=changed, printed=_PRINTED)
    dims, exact = ("case", "resolution"), "fraction of the case's window that steady sliding attracts, exact"
    return {
        "case": own.pop("case"),
        **{f"case_{x}": own[x] for x in own if x in changed or x in ("axial_force", "support_damping")},
        **phase_plane.lines(drives),
        **_points("boundary", lines, "on the exact boundary"),
        **_points("region", regions, "on the curves around the basin within the window"),
        "resolution": variable("resolution", list(resolutions), "1", "starts along each edge of a grid"),
        **phase_plane.window_edges("case", ("case", "edge"), windows, " of the case"),
        "case_boundary_kind": flagged("case", [b.boundary for b in basins], "what bounds the basin", Boundary),
        "case_fraction": variable("case", [b.fraction(w) for b, w in pairs], "1", exact),
        "grid_fraction": variable(dims, grid, "1", "the same fraction, counted on a grid of starts"),
        "grid_bound": variable(dims, bound, "1", "fraction of the cells of the grid that the boundary cuts at most"),
    }


def _points(name: str, curves: Sequence[np.ndarray], where: str) -> Variables:
    """Sampled curves of each case, (case, point); shorter ones end in NaN, as do their parts."""
    table = np.full((len(curves), max(len(points) for points in curves), 2), np.nan)
    for row, points in zip(table, curves, strict=True):
        row[: len(points)] = points
    return phase_plane.curve(name, ("case", f"{name}_point"), table, where)


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the claims of Sect. 8.7 on the basin, and exact areas against grids.

    Along all four sweeps the basin is the whole plane exactly on one side of a critical value.
    """
    reading, force = dataset.reading_fraction.values, dataset.swept_axial_force.values
    fraction, threshold = dataset.fraction_axial_force.values, float(dataset.global_stability_force)
    touching, beyond = named(dataset.boundary_kind_axial_force, "touching motion"), force < threshold
    scaled = spread(dataset.basin_area_axial_force.values[touching] / force[touching] ** 2)
    error = np.abs(dataset.grid_fraction - dataset.case_fraction)
    worst = float((error / dataset.grid_bound).max())
    orders = [-np.polyfit(np.log(dataset.resolution), np.log(np.maximum(e, 1e-12)), 1)[0] for e in error.values]
    area = dataset.basin_area_axial_force.values[force > threshold]
    local = area.size > 0 and area.min() > 0 and np.isfinite(area).all()
    readings = (reading[0] == 1).all() and reading[1, 0] == 1 > reading[1, 1]
    damping, limit = dataset.swept_support_damping.values, dataset.swept_global_stability_force.values
    whole = {name: named(dataset[f"boundary_kind_{name}"], "none") for name in _SWEPT}
    stable, parted, words = whole["support_damping"], [], {}
    for name in ("mass", "friction_coefficient"):
        swept, here, critical = dataset[f"swept_{name}"].values, whole[name], float(dataset[_SWEPT[name][1]])
        parted.append((here == (swept <= critical)).all() and 0 < here.sum() < here.size)
        words |= {name: critical, f"last_{name}": swept[here].max(initial=-np.inf)}
    sides, forces = ((fraction == 1) == beyond).all(), {"below": fraction[beyond] == 1, "above": fraction[~beyond] < 1}
    forced = sides and (fraction <= 1).all() and 0 < beyond.sum() < beyond.size
    damped = (stable == (limit > float(dataset.axial_force))).all()
    return [
        Check.that("basin_sweep.force", forced, threshold=threshold, **forces),
        Check.that("basin_sweep.damping", damped, stable=stable, damping=damping[stable]),
        Check.that("basin_sweep.mass_and_friction", all(parted), **words),
        newton.touching_check(dataset, -1, dataset.global_stability_force, "Force of global stability"),
        Check.that("basin_sweep.small", 0 < reading[1, 1] < 0.01, percent=100 * reading[1, 1]),
        Check.that("basin_sweep.local", local, area=area),
        Check.that("basin_sweep.readings", readings, readings=reading),
        Check.that("basin_sweep.square", scaled < 1e-12 and touching.sum() > 1, touching=touching, spread=scaled),
        Check.that("basin_sweep.fraction", worst <= 1, worst=worst, orders=orders),
    ]


@style.styled
def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw the basins of the cases above, and the fraction of the window that belongs to the basin below."""
    figure = style.new_figure(style.DOUBLE, 6.0)
    rows = figure.subfigures(2, 1, height_ratios=(1.0, 1.05))
    above = np.atleast_1d(rows[0].subplots(1, dataset.sizes["case"]))
    for index, axes in enumerate(above):
        _basin(axes, dataset.isel(case=index), "abc"[index])
    below = rows[1].subplots(1, len(_SWEPT), sharey=True)
    for axes, name, letter in zip(below, _SWEPT, "defg", strict=True):
        _sweep(axes, dataset, name, letter)
    below[0].set_ylabel("Fraction of the window")
    style.legend(rows[0], above, 4)
    style.legend(rows[1], below, 2)
    return figure


def _basin(axes: style.Axes, case: xr.Dataset, letter: str) -> None:
    """Shade the basin of one case, draw its boundary, N = 0 and θ′ = 0."""
    region = np.column_stack([case.region_angle, case.region_velocity])
    for part in np.split(region, np.flatnonzero(np.isnan(region[:, 0]))):
        part = part[np.isfinite(part[:, 0])]
        if len(part):
            axes.fill(*part.T, color="#CFE3F1", label="basin of steady sliding", zorder=0.5)
    colour, _ = _KINDS[flag_names(case.case_boundary_kind)[int(case.case_boundary_kind)]]
    axes.plot(case.boundary_angle, case.boundary_velocity, color=colour, linewidth=1.8,
              label="exact boundary, colours as below", zorder=2)  # fmt: skip
    drawing.mark_origin(axes)
    axes.set(xlim=case.case_angle.values, ylim=case.case_velocity.values)
    drawing.draw_lines(axes, case)
    axes.set_xlabel(style.label(case.boundary_angle, "deviation"))
    axes.set_ylabel(style.label(case.boundary_velocity, "rate"), labelpad=1)
    axes.locator_params(nbins=5)
    force, damping = case.case_axial_force, case.case_support_damping
    words = f"$c$ = {style.number(damping)} {style.unit(damping.units)[1:-1]}"
    axes.set_title(f"({letter}) $R$ = {style.number(force)} N,\n{words}")
    starts, exact, counted = int(case.resolution[-1]), float(case.case_fraction), float(case.grid_fraction[-1])
    words = f"{100 * exact:.2f} % of the panel\n{100 * counted:.2f} % of starts\n({starts} × {starts})"
    axes.text(0.97, 0.96, words, transform=axes.transAxes, ha="right", va="top", fontsize=6)


def _sweep(axes: style.Axes, dataset: xr.Dataset, name: str, letter: str) -> None:
    """Draw the fraction over one parameter, coloured by what bounds the basin."""
    title, known, symbol, digits = _SWEPT[name]
    scale = 1e3 if name == "support_damping" else 1.0
    values, fraction = dataset[f"swept_{name}"].values * scale, dataset[f"fraction_{name}"].values
    kinds = dataset[f"boundary_kind_{name}"]
    for word in flag_names(kinds).values():
        colour, words = _KINDS[word]
        axes.plot(values, np.where(named(kinds, word), fraction, np.nan), color=colour, linewidth=1.8, label=words)
    for k in np.flatnonzero(np.diff(kinds.values)):
        axes.plot(values[k : k + 2], fraction[k : k + 2], color=style.GREY, linewidth=0.8, linestyle=":",
                  label="jump of the fraction")  # fmt: skip
    axes.axvline(scale * float(dataset[name]), color=style.GREY, linewidth=0.9, linestyle=(0, (5, 2)),
                 label="drive of (a)")  # fmt: skip
    label = style.label(dataset[f"swept_{name}"], " ").strip()
    axes.set(yscale="log", title=f"({letter}) {title}", xlabel=label.replace("[", "[10⁻³ ") if scale > 1 else label)
    axes.margins(x=0)
    axes.set_ylim(None, 1.6)
    # Where global stability begins or ends: a root in closed form, over the damping the change of the basin.
    stable = values[named(kinds, "none")]
    place = scale * float(dataset[known]) if known else float(stable.min(initial=np.inf))
    left, right = axes.get_xlim()
    if left <= place <= right:
        dotted = {"linewidth": 0.9, "linestyle": (0, (2, 1.5)), "label": "limit of global stability"}
        axes.axvline(place, color=style.VERMILION, **dotted)
        value, late = f"{place:.{digits}f}".replace("-", "−"), place > (left + right) / 2
        axes.text(place, 0.06, f" {symbol} = {value} ", color=style.VERMILION, backgroundcolor="#FFFFFFC0",
                  fontsize=7.5, ha="right" if late else "left", transform=axes.get_xaxis_transform())  # fmt: skip
