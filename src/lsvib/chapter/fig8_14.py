"""Figure 8.14: region of attraction under a negative axial force, for both readings of the mass.

The text states m = 10 kg, for which Γ₊ > 0, but Sect. 8.7 assumes Γ₊ < 0: the two forces are also computed for a
mass beyond m_cr.

Beyond m_cr, as the chapter reads its resume rule, seizures accumulate at the corner θ′ = 0 = Q. With the line N = 0
as u = u_0 + σ (u′ + Ω), σ < 0, and the acceleration −a, a reverse slip from a distance d lasts d / (Ω + |σ| a) to first
order, so the distances fall with the ratio q = |σ| a / (Ω + |σ| a): infinitely many seizures in finite time.
"""

import json
from collections.abc import Sequence

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import phase_plane, spans
from lsvib.answers.analysis import analyse, value
from lsvib.answers.attributes import Variables, attributes, counted, flag_names, flags, named, variable, varied
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, Clause, each, every, near, never, some
from lsvib.chapter.common import about, spread
from lsvib.chapter.settings import Cells, MassPair, OpposingForces, PhasePlane, Values
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.names import RULES, Event, MotionMode, Resume
from lsvib.pictures import drawing, style
from lsvib.words import plain

CAPTION = """\
Trajectories under a negative axial force, c = 1e-3 N m s/rad, (a) for R = −50 N and (b) for R = −10 N, as in the
chapter, whose mass of 10 kg gives no limit cycle in (b). Not in the chapter: (c), (d) the same for m = 11 kg, beyond
the critical mass as Sect. 8.7 assumes, where (d) has the limit cycle. Shading shows the attractor reached from each
initial state. If motion resumes at once after a seizure, as in the chapter, seizures accumulate in finite time at the
corner of N = 0 and θ′ = 0 in (c) and (d); those drawn follow the sign of the contact force. See docs/physics.md.
"""

_CHANGED = ("mass", "axial_force")  # in which the cases differ
_PRINTED = ("Fig. 8.14", "Sect. 8.6")
_DISTANCES = np.concatenate([[0.0], np.geomspace(1e-4, 2.0, 60)])  # rad; the cycles of the figure are 0.1 rad wide
_FORCES = np.linspace(-40.0, -0.5, 80)  # N, over which the area of the basin is computed
_ROUNDING = 16 * np.finfo(float).eps  # of the corner: a few rounding errors of u and of the line N = 0
_STARTS = {  # colour of the starts by their attractor
    "steady sliding": ("#E4F4E8", "attracted by steady sliding"),
    "sprag slip cycle": ("#CCCCCC", "attracted by the cycle"),
}


class Settings(PhasePlane):
    unused = ("mass", "axial_force")

    masses: MassPair = Field(description="Mass as printed, and mass beyond the critical one [kg].")
    axial_forces: OpposingForces = Field(description="Axial forces of panels (a) and (b) [N].")
    angle: Cells = Field(description="Deviations u of the starts whose attractors are found [rad].")
    velocity: Cells = Field(description="Rates w of those starts [rad/s].")


def _drives(settings: Values) -> list[Drive]:
    drive = Drive.of(settings["drive"])
    return [drive.replace(mass=m, axial_force=r) for m in settings["masses"] for r in settings["axial_forces"]]


def analysis(settings: Values) -> xr.Dataset:
    """Analyse the four drives; beyond m_cr they have a force of global stability."""
    return analyse(_drives(settings), [("global_stability", "axial_force")], _CHANGED, _PRINTED)


def maps(settings: Values) -> xr.Dataset:
    """Map the starts of the four drives to their attractors."""
    from lsvib.answers.map import grids_of

    return grids_of(_drives(settings), settings["angle"], settings["velocity"])


def build(settings: Values, analysis: xr.Dataset, maps: xr.Dataset) -> xr.Dataset:
    """Compute the four phase planes, mass by mass and force by force, and what Sect. 8.7 says of them."""
    drives, threshold = _drives(settings), value(analysis.global_stability_axial_force, -1)
    below = "distance of the start below the corner, at standstill"
    planes = phase_plane.portraits(settings, drives, _CHANGED, _PRINTED).assign_coords(
        {
            **{name: maps[name].variable for name in ("grid_u", "grid_w")},
            "corner_distance": variable("corner_distance", _DISTANCES, "rad", below),
            "global_stability_force": variable(
                (), threshold, "N", phase_plane.GLOBAL_STABILITY, "$R$", comment="of the last two cases, beyond m_cr"
            ),
        }
    )
    return planes.assign(
        _reverse_slips(drives, settings["starts"][-1], settings["duration"])
        | _corners(drives)
        | _first_events(drives, maps, settings["duration"])
        | _basins(drives, settings, threshold)
        | {"grid_attractor": maps.grid_attractor.variable}
    ).assign_attrs(about(__doc__, "exact event-driven motion and its return map", "Sect. 8.7, Fig. 8.14"))


def _first_events(drives: Sequence[Drive], maps: xr.Dataset, duration: float) -> Variables:
    """Of motions from some cells of the map: what happens at once, if anything, the rate after it, and later events.

    A rest counts as a later event even if it begins at once.
    """
    places = {name: maps[name] for name in ("grid_u", "grid_w")}
    few = maps.isel({name: spans.evenly_chosen(axis.size, 16) for name, axis in places.items()})
    few = few.stack(probe=list(places), create_index=False)
    u, w = (few[name].values for name in places)
    first, rate, mode, later = (np.full((len(drives), u.size), value) for value in (-1, np.nan, -1, 0))
    for case, probe in np.ndindex(first.shape):
        motion = phase_plane.followed(drives[case], {"u": float(u[probe]), "w": float(w[probe])}, duration)
        at_once = motion.time == 0
        if at_once.any():
            first[case, probe], rate[case, probe] = motion.kind[0], motion.after[0, 1]
            mode[case, probe] = motion.automaton.codes[motion.mode[at_once][-1]]
        rests = motion.automaton.codes[motion.mode[at_once]] == MotionMode.REST
        later[case, probe] = (~at_once).sum() + rests.sum()
    dims, when, about_first = ("case", "probe"), "of the motion from the cell", flags(Event, none=True)
    about_mode = attributes("1", f"mode after the immediate event {when}", **flags(MotionMode, none=True))
    return {
        **phase_plane.curve("probe", "probe", np.transpose([u, w]), "of a cell of the map"),
        "probe_attractor": phase_plane.attractors(dims, few.grid_attractor.transpose(*dims).values),
        "probe_event": (dims, first.astype(np.int8), attributes("1", f"immediate event {when}", **about_first)),
        "probe_mode_after": (dims, mode.astype(np.int8), about_mode),
        "probe_w_after": variable(dims, rate, "rad s-1", f"rate of the deviation after the immediate event {when}"),
        "probe_later_events": variable(dims, later, "1", f"number of later events and rests {when}"),
    }


def _corners(drives: Sequence[Drive]) -> Variables:
    """Where the motions from standstill below the corner of the lines N = 0 and θ′ = 0 end."""
    ends = []
    for drive in drives:
        starts = [{"u": _corner(drive) - x, "w": -drive.input_speed} for x in _DISTANCES]
        ends.append([[phase_plane.reached(drive, start, rule).label for start in starts] for rule in RULES])
    words = "attractor of the motion from standstill at this distance below the corner"
    return {
        "corner_attractor": phase_plane.attractors(("case", "rule", "corner_distance"), ends, words),
    }


def _basins(drives: Sequence[Drive], settings: Values, threshold: float) -> Variables:
    """The share of the window that settles, and the area over the force, also beside a threshold, in closed form."""
    from lsvib.dynamics.boundary import basin

    window = {x: (settings[name]["start"], settings[name]["stop"]) for x, name in (("u", "angle"), ("w", "velocity"))}
    forces = np.unique([*_FORCES, threshold * (1 - 1e-6), threshold * (1 + 1e-6)])
    areas = [basin(drives[-1].replace(axial_force=force)).area() for force in forces.tolist()]
    shares, words = [basin(drive).fraction(window) for drive in drives], "area of the basin, infinite if unbounded"
    return {
        "basin_fraction": variable("case", shares, "1", "fraction of the window that steady sliding attracts, exact"),
        **varied(swept_axial_force=forces),
        "basin_area": variable("swept_axial_force", areas, "rad2 s-1", words),
    }


def _corner(drive: Drive) -> float:
    """Return u_0 = c Ω / k − Γ₋ R / (k m r_m tan λ) [rad], R < 0 and Ω > 0 (Sect. 8.7)."""
    c, p = coefficients(drive), drive.exact()
    lever = p.coupling_stiffness * p.mass * p.pitch_radius * p.tan_lead
    return float(p.support_damping * p.input_speed / p.coupling_stiffness - c.gamma[-1] * p.axial_force / lever)


def _reverse_slips(drives: Sequence[Drive], start: Values, duration: float) -> Variables:
    """The deviations u [rad] at the seizures before the first release, by both rules."""

    def seized(drive: Drive, rule: Resume) -> np.ndarray:
        motion = phase_plane.followed(drive, start, duration, rule)
        released = np.cumsum(motion.kind == Event.RELEASE) > 0
        return np.compress(~released & (motion.kind == Event.SEIZURE), motion.before[:, 0])

    seizures = [[seized(drive, rule) for rule in RULES] for drive in drives]
    longest = max(1, *(angles.size for row in seizures for angles in row))
    table = [[np.append(x, [np.nan] * (longest - x.size)) for x in row] for row in seizures]
    words = "deviation at the seizures of the last motion before its first release"
    return {"seizure_angle": variable(("case", "rule", "seizure"), table, "rad", words, "$u$")}


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check (a) and (b) for both readings of the mass, and the threshold of global stability between them.

    All starts at standstill up to the corner, beyond m_cr: the end of Sect. 8.7.
    """
    mass, gamma, force = dataset.mass.values, dataset.effective_inertia_plus.values, dataset.axial_force.values
    threshold = float(dataset.global_stability_force)
    first, second = named(dataset.corner_attractor, "steady sliding")[2:]
    told = {"starts": first.shape[1], "first": first.sum(1), "second": second.sum(1), "mass": mass[2]}
    return [
        *newton.portrait_checks(dataset, "8.22, Fig. 8.14"),
        Check.that("fig8_14.inertia", inertias=every(np.sign(gamma) == [1, 1, -1, -1]), gamma=gamma, mass=mass),
        Check.that("fig8_14.cells", **_cells(dataset)),
        _attractor_check(dataset.isel(case=0), "fig8_14.settles", "steady sliding", " (as printed)"),
        _attractor_check(dataset.isel(case=2), "fig8_14.settles", "steady sliding"),
        _attractor_check(dataset.isel(case=1), "fig8_14.no_cycle", "steady sliding"),
        _attractor_check(dataset.isel(case=3), "fig8_14.cycle", "sprag slip cycle"),
        *_event_checks(dataset.isel(case=[2, 3])),
        Check.that("fig8_14.corner", starts_of_a=every(first), rules_of_b=every(~second.all(1)), **told, forces=force),
        Check.that("fig8_14.between", force_of_a=each(force[2], "<", threshold),
                   force_of_b=each(force[3], ">", threshold), threshold=threshold, mass=mass[2]),
        *_basin_checks(dataset, threshold),
        *_accumulation_checks(dataset.isel(case=gamma < 0)),
    ]  # fmt: skip


def _cells(dataset: xr.Dataset) -> dict[str, Clause]:
    """That cells have their middles where the settings ask for cells, and motions start in some of them."""
    clauses, asked = {}, json.loads(dataset.attrs["settings"])
    for short, name in (("u", "angle"), ("w", "velocity")):
        middles, probes = dataset[f"grid_{short}"].values, dataset[f"probe_{short}"]
        edges = np.linspace(asked[name]["start"], asked[name]["stop"], middles.size + 1)
        clauses[f"middles_by_{name}"] = each(abs(middles - (edges[1:] + edges[:-1]) / 2), "<", 1e-9 * np.ptp(edges))
        clauses[f"starts_by_{name}"] = every(np.isin(probes, middles))
    return clauses


def _attractor_check(case: xr.Dataset, id: str, expected: str, reading: str = "") -> Check:
    """Check that the motions drawn of a case reach one attractor, and all others reach it or the origin.

    Those that settle in (a) also meet N = 0 after their start.
    """
    grid, amplitude = named(case.grid_attractor, "steady sliding"), case.amplitude.values
    drawn, others = (named(labels, expected) for labels in (case.attractor, case.grid_attractor))
    touches = (named(case.event_kind, "seizure", "contact reversal") & (case.event_time.values > 0)).sum(axis=1)
    clauses = {"motions": every(drawn), "other_starts": every(grid | others)}
    if id == "fig8_14.settles":
        clauses["least"] = each(touches, ">", 0)
    if id == "fig8_14.cycle":
        clauses["spread"] = each(spread(amplitude), "<", 1e-12)
    reached = " and ".join(sorted(map(plain, counted(case.attractor))))
    words = {"touches": " and ".join(map(str, touches)), "attractors": reached, "reading": reading}
    numbers = {"mass": case.mass, "force": case.axial_force, "grid": grid, "amplitude": amplitude}
    return Check.that(id, **clauses, **words, **numbers)


def _event_checks(heavy: xr.Dataset) -> list[Check]:
    """Check beyond m_cr what Sect. 8.7 says of starts, by the signs of N under law − and of θ′, and of N = 0."""
    first, u, w, later = xr.broadcast(heavy.probe_event, heavy.probe_u, heavy.probe_w, heavy.probe_later_events)
    positive = u - heavy.contact_line_slope * w > heavy.contact_line_angle  # Q, and N under law −
    stop = heavy.stop_velocity
    forward = w > stop
    jumps = first.copy(data=named(first, "seizure")) & (heavy.probe_w_after == stop)
    origin = jumps.copy(data=named(heavy.probe_attractor, "steady sliding"))
    alone, back = ~positive & forward & (later == 0), ~positive & ~forward & (w < stop)
    straight = ((later == 0) & origin).where(back)
    arrivals = heavy.event_kind.copy(data=named(heavy.event_kind, "seizure"))
    after, reversals = heavy.event_w_after, named(heavy.event_kind, "contact reversal")
    falls = (u - heavy.contact_line_slope * stop < heavy.contact_line_angle).values  # Q < 0 after a stop
    left, right = ((positive & forward).values & side for side in (falls, ~falls))
    modes = heavy.probe_mode_after
    forces = zip(straight, heavy.axial_force, strict=True)
    counted = [f"{int(x.sum())} of {int(x.count())} starts at R = {float(r):g} N" for x, r in forces]
    return [
        Check.that("fig8_14.stops", starts=every(jumps.values[(positive & forward).values])),
        Check.that("fig8_14.left_of_corner", left=every(named(modes, "rest", "slip forward negative")[left]),
                   right=every(named(modes, "slip backward positive")[right])),
        Check.that("fig8_14.stops_backwards", starts=every(jumps.values[back.values])),
        Check.that("fig8_14.some_starts", disturbed_starts=some(later.values[back.values] > 0), counted=counted),
        Check.that("fig8_14.origin", starts=every(origin.values[alone.values])),
        Check.that("fig8_14.seizes", seizures=every((after == stop).values[arrivals.values]),
                   reversals=never(reversals), arrivals=arrivals),
    ]  # fmt: skip


def _basin_checks(dataset: xr.Dataset, threshold: float) -> list[Check]:
    """Check the size of the basin, over the force and in the window, and the threshold by Newton's laws."""
    area, force, readings = dataset.basin_area.values, dataset.swept_axial_force.values, dataset.basin_fraction.values
    bounded, local, last = np.isfinite(area), area[force >= threshold], dataset.isel(case=3)
    below, above, per_square = ~bounded[force < threshold], bounded[force >= threshold], (area / force**2)[bounded]
    cells = [dataset.grid_u, dataset.grid_w]
    window = np.prod([float(x[-1] - x[0]) * x.size / (x.size - 1) for x in cells])
    inside, mass = newton.touching_area(newton.parameters(last)), float(last.mass)
    return [
        newton.touching_check(last, -1, threshold, f"Force of global stability with m = {mass:g} kg"),
        Check.that("fig8_14.force", below=every(below), above=every(above), threshold=threshold, mass=mass),
        Check.that("fig8_14.local", basins=every(above), least=each(local, ">", 0), area=local),
        Check.that("fig8_14.square", spread=each(spread(per_square), "<", 1e-12), forces=local.size,
                   area=near(per_square, inside / float(last.axial_force) ** 2, 1e-4)),
        Check.that("fig8_14.small", least=each(readings[3], ">", 0), most=each(readings[3], "<", 0.01),
                   area=near(readings[3] * window, inside, 1e-4), percent=100 * readings[3]),
        Check.that("fig8_14.readings", whole_windows=every(readings[:3] == 1), last=each(readings[3], "<", 1),
                   readings=readings, mass=mass),
    ]  # fmt: skip


def _accumulation_checks(heavy: xr.Dataset) -> list[Check]:
    """Check that the seizures accumulate under the chapter's reading, in its corner u_0, and are few under the other.

    u_0 = c Ω / k − Γ₋ R / (k m r_m tan λ). How far a ratio is off is counted in what is allowed.
    """
    k, speed, minus = heavy.coupling_stiffness, heavy.input_speed, printed_laws.inertia(heavy, -1)
    lever = heavy.mass * heavy.pitch_radius * np.tan(heavy.lead_angle)
    corner = (heavy.support_damping * speed - minus * heavy.axial_force / lever) / k
    length = corner - printed_laws.damping(heavy, -1) * speed / k  # over which the acceleration changes by all of it
    gain = -heavy.contact_line_slope * k * length / minus  # |σ| a
    limits, away = gain / (speed + gain), heavy.seizure_angle - corner
    few, many = away.count("seizure").values.T
    stops = heavy.seizure_angle.isel(rule=0).min("seizure") / corner
    distance, rounding = away.isel(rule=1), _ROUNDING * abs(corner)
    before = distance.shift(seizure=1)
    ratio, clear = distance / before, before.notnull() & (distance > rounding)
    off = abs(ratio / limits - 1).where(clear, np.inf)
    allowed = before / length + rounding / np.maximum(distance, rounding)
    excess = (off / allowed).where(clear, 0.0).max("seizure").where(clear.sum("seizure") > 1, np.inf)
    closest = ratio.isel(seizure=off.argmin("seizure"))
    ends = distance.isel(seizure=distance.count("seizure") - 1)
    told = zip(heavy.axial_force.values, many, closest.values, limits.values, ends.values, strict=True)
    words = [
        f"R = {r:g} N: {n} seizures, ratio {found:.7g} against {limit:.7g}, the last at {end:.1e} rad"
        for r, n, found, limit, end in told
    ]
    drawn = heavy.seizure_angle[:, :, 0] == heavy.event_u_before[:, -1, 0]
    return [
        Check.that("fig8_14.accumulate", most=each(excess, "<=", 1), first_seizures=every(drawn),
                   motions="; ".join(words)),
        Check.that("fig8_14.in_corner", gap=each(abs(ends / corner), "<", 1e-12)),
        Check.that("fig8_14.few", motions=every(few < many), short=each(stops, ">", 1.001), places=stops,
                   few=" and ".join(map(str, few)), many=many, mass=heavy.mass[0]),
    ]  # fmt: skip


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw four phase planes, printed mass above, one beyond m_cr below."""
    figure = style.new_figure(style.DOUBLE, 5.9)
    panels = figure.subplots(2, 2, sharex=True, sharey=True).ravel()
    cases = [dataset.isel(case=index) for index in range(4)]
    for axes, case, letter in zip(panels, cases, "abcd", strict=True):
        _region(axes, case)
        drawing.phase_plane(axes, case, (2.2, 1.0, 1.0, 1.0))  # the first motion shows on both sides of a later one
        note, ours = ("as printed", "") if letter in "ab" else ("$m > m_\\mathrm{cr}$", "ours: ")
        force, mass = style.number(case.axial_force), style.number(case.mass)
        drawing.label_axes(axes, dataset, f"({letter}) {ours}$R$ = {force} N, $m$ = {mass} kg, {note}")
    edges = np.array([dataset[name].values[[0, -1]] for name in ("grid_u", "grid_w")])
    panels[0].axis(np.ravel(edges))  # all motions begin there
    for axes, case in zip(panels, cases, strict=True):
        drawing.draw_lines(axes, case)
        axes.label_outer()
    patches = [patch for axes in panels for patch in axes.patches]
    return drawing.guide(style.legend(figure, panels, 4, patches), panels, cases)


def _region(axes: style.Axes, case: xr.Dataset) -> None:
    """Shade the starts by the attractor of their motion."""
    labels, names = case.grid_attractor, flag_names(case.grid_attractor)
    looks = {name: _STARTS.get(name, (style.PURPLE, f"attracted by {name}")) for name in names.values()}
    colours = {name: colour for name, (colour, _) in looks.items()}
    drawing.regions(axes, case.grid_u, case.grid_w, labels.T, colours, zorder=0)
    for colour, words in (looks[names[flag]] for flag in np.unique(labels).tolist()):
        axes.fill([], [], color=colour, label=words)
