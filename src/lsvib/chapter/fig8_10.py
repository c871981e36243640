"""Figure 8.10: the sprag–slip cycle with compliant threads, its phase plane and the peaks of its contact force."""

import numpy as np
import xarray as xr
from pydantic import Field

from lsvib.answers import phase_plane, spans
from lsvib.answers.attributes import Variables, drive_parameters, named, start_state, variable, varied
from lsvib.chapter import impacts, newton
from lsvib.chapter import settings as of
from lsvib.chapter.checks import Check, each, every, near
from lsvib.chapter.common import SteadyState, about, printed
from lsvib.drives.chapter import claims
from lsvib.drives.drive import Drive
from lsvib.drives.model import model_of
from lsvib.pictures import drawing, style

CAPTION = """\
Compliant threads: (a) phase plane with the cycle of the rigid drive; (b) contact force on a broken axis, with its peaks
in kN above and the sliding between them in N below. Not in the chapter: (c) peak (left) and distance from the rigid
cycle (right) against R, which the text does not state. The dot marks the force of (a) and (b).
"""

_PEAK = ("N", "largest normal force on the cycle", "$N$")
_DISTANCE = (
    "1", "distance between compliant and rigid cycle, scaled by the rigid amplitude and the input speed",
)  # fmt: skip


class Settings(of.DriveFigure, of.Contact):
    engine = ("planar", "modal")
    start: of.State
    duration: of.Duration
    samples: of.Samples
    axial_force: of.PositiveSpan = Field(description="R [N] over which the dependence is shown.")


def build(settings: of.Values) -> xr.Dataset:
    """Compute motion and cycle with compliant threads from a seated contact, the rigid cycle, and the effect of R."""
    contact = {key: settings[key] for key in of.Contact.model_fields}
    drive, start, samples = Drive.of(settings["drive"], **contact), settings["start"], settings["samples"]
    without = drive.replace(**dict.fromkeys(contact))
    cycle, rigid = (phase_plane.reached(own, start) for own in (drive, without))
    motion = phase_plane.followed(drive, start, settings["duration"])
    # Both states of each event are samples, so every peak is.
    sampled = phase_plane.sampled(motion, samples, model_of(drive).modes)
    forces = np.unique([*spans.even(settings["axial_force"]), drive.axial_force])
    rows, dim, numbers = [], "swept_axial_force", Variables()
    for force in forces.tolist():
        swept, beside = (phase_plane.reached(own.replace(axial_force=force), start) for own in (drive, without))
        rows.append((swept.label, *_cycle_values(drive, swept, beside)))
    label, peaks, distances = np.array(rows, dtype=float).T
    for name, steady, words in (("", cycle, ""), ("rigid_", rigid, ", of the rigid drive")):
        numbers |= {
            f"{name}attractor": phase_plane.attractors((), steady.label, phase_plane.ATTRACTOR + words),
            f"{name}amplitude": variable((), steady.amplitude, "rad", phase_plane.AMPLITUDE + words),
            f"{name}period": variable((), steady.period, "s", phase_plane.PERIOD + words, "$T$"),
        }
    peak, distance = _cycle_values(drive, cycle, rigid)
    return xr.Dataset(
        {name: ("sample", *own) for name, own in sampled.items()}
        | phase_plane.cycle_curves((), [cycle], samples)
        | phase_plane.cycle_curves((), [rigid], samples, "rigid_cycle")
        | numbers
        | {
            "peak_normal_force": variable((), peak, *_PEAK),
            "orbit_distance": variable((), distance, *_DISTANCE),
            "swept_attractor": phase_plane.attractors(dim, label),
            "swept_peak_normal_force": variable(dim, peaks, *_PEAK),
            "swept_orbit_distance": variable(dim, distances, *_DISTANCE),
        }
        | impacts.limit(without),
        coords={
            **varied(swept_axial_force=forces),
            **drive_parameters(drive, printed=("Sect. 8.6", "Sect. 8.6.1")),
            **start_state(start, "of the motion and of those whose cycles are found, with a seated contact"),
            "printed_peak_normal_force": printed("fig8_10.peak_force", "largest contact force on the cycle"),
        },
        attrs=about(__doc__, "exact event-driven motion with four states", "Sect. 8.6.1, Fig. 8.10"),
    ).set_coords("time")


def _cycle_values(drive: Drive, cycle: SteadyState, rigid: SteadyState) -> tuple[float, float]:
    """Largest |N| [N] on the compliant cycle, and its distance [1] from the rigid one; nan where there is none."""
    if cycle.orbit is None or rigid.orbit is None:
        return np.nan, np.nan
    low, high = cycle.extremes(cycle.orbit.automaton.observables["normal_force"])
    return max(-low, high), impacts.distance(cycle.orbit, rigid.orbit, (rigid.amplitude, abs(drive.input_speed)))


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the printed peak force, how little R changes it, and how close the motion stays to the rigid one."""
    force, peak, apart = dataset.swept_axial_force, dataset.swept_peak_normal_force, dataset.swept_orbit_distance
    claim, exact = claims()["fig8_10.peak_force"], float(dataset.peak_normal_force)
    found = (dataset.swept_attractor, dataset.attractor, dataset.rigid_attractor)
    sprags = np.hstack([named(attractor, "sprag slip cycle") for attractor in found])
    numbers = {str(name): float(x) for name, x in dataset.variables.items() if not x.ndim}
    late = named(dataset["mode"], "rest positive") & (dataset.time.values > 0.5 * float(dataset.time[-1]))
    highest, own = dataset.normal_force.values[late].max(initial=-np.inf), force.values == float(dataset.axial_force)
    limits = {"percent": 100 * claim.tolerance, "peak": claim.value / 1e3}
    away = numbers.pop("orbit_distance")
    rigid = {name: dataset[f"rigid_{name}"] for name in ("amplitude", "period")}
    return [
        newton.laws_check(dataset, "Fig. 8.10"),
        newton.cycle_check(dataset, "Fig. 8.10", amplitude=dataset.amplitude, period=dataset.period),
        newton.cycle_check(dataset, "Fig. 8.10", "rigid_cycle", **rigid),
        Check.of("fig8_10.peak_force", exact),
        Check.that("fig8_10.any_force", peaks_apart=each(abs(peak / claim.value - 1), "<=", claim.tolerance),
                   peaks_here=every(peak[own] == exact), forces=force, peaks=peak / 1e3, **limits),
        Check.that("fig8_10.close", orbit_distance=each(away, "<=", 0.02), distances_here=every(apart[own] == away),
                   points=near(away, _apart(dataset), 0.005), near=apart, forces=force, **numbers),
        Check.that("fig8_10.repeats", cycles=every(sprags)),
        Check.that("fig8_10.resolved", peak=near(highest, exact, 1e-6), highest=highest, exact=exact),
        *impacts.checks(dataset),
    ]  # fmt: skip


def _apart(dataset: xr.Dataset) -> float:
    """Distance [1] of both cycles, by the nearest of many points along the other."""
    few, many = list[np.ndarray](), list[np.ndarray]()
    for prefix in ("cycle", "rigid_cycle"):
        u, w = (dataset[f"{prefix}_{name}"].values for name in "uw")
        curve = u / float(dataset.rigid_amplitude) + 1j * w / float(dataset.input_speed)
        way = np.append(0.0, np.cumsum(np.abs(np.diff(curve))))
        for points, count in ((few, 600), (many, 20_000)):
            points.append(np.interp(np.linspace(0, way[-1], count), way, curve))
    return float(max(np.abs(x - other).min() for points, other in zip(few, many[::-1], strict=True) for x in points))


def draw(dataset: xr.Dataset) -> style.Figure:
    """Draw (a) the phase plane, (b) N(t) on a broken axis, (c) peak force, left, and distance, right, over R."""
    figure = style.new_figure(style.DOUBLE, 3.0)
    panels = figure.subplot_mosaic([["a", "peaks", "c"], ["a", "sliding", "c"]], width_ratios=(1, 1.15, 0.9))
    plane, over, start = panels["a"], panels["c"], dataset.isel(sample=0)
    plane.plot(dataset.u, dataset.w, color=style.SKY, linewidth=0.8, label="motion")
    plane.plot(dataset.rigid_cycle_u, dataset.rigid_cycle_w, color=style.ORANGE, linewidth=2.6,
               label="cycle of the rigid drive", zorder=2)  # fmt: skip
    plane.plot(dataset.cycle_u, dataset.cycle_w, color=style.BLUE, linewidth=1.0,
               label="cycle with compliant threads", zorder=2.1)  # fmt: skip
    plane.plot(start.u, start.w, "o", color=style.SKY, mfc="white", label="start")
    drawing.mark_origin(plane)
    drawing.draw_stop(plane, -float(dataset.input_speed))
    drawing.arrows(plane, [(dataset.cycle_u.values, dataset.cycle_w.values, style.BLUE)])
    drawing.label_axes(plane, dataset, "(a) phase plane")
    plane.locator_params(axis="x", nbins=5)
    _force(panels["peaks"], panels["sliding"], dataset)
    claim = dataset.printed_peak_normal_force
    printed, part = claim / 1e3, claim.attrs["relative_tolerance"]
    force = dataset.swept_axial_force
    over.axhspan(printed * (1 - part), printed * (1 + part), color=style.VERMILION, alpha=0.15, linewidth=0,
                 label=f"printed ± {100 * part:g} %")  # fmt: skip
    over.plot(force, dataset.swept_peak_normal_force / 1e3, color=style.BLUE)
    over.plot(dataset.axial_force, dataset.peak_normal_force / 1e3, "o", color=style.BLUE)
    over.set(title="(c) ours: against $R$", xlabel=style.label(force, "Axial force"), xlim=(0, float(force[-1])))
    over.set_ylabel("Peak of $N$ [kN]", color=style.BLUE)
    over.tick_params(axis="y", which="both", right=False)
    distance = over.twinx()
    distance.plot(force, 100 * dataset.swept_orbit_distance, color=style.GREEN, linestyle="--")
    distance.set_ylabel("Distance from rigid cycle [%]", color=style.GREEN)
    distance.set_ylim(0, None)
    return style.legend(figure, [plane, panels["peaks"], over], 4)


def _force(peaks: style.Axes, sliding: style.Axes, dataset: xr.Dataset) -> None:
    """Contact force over time: the peaks above, sliding below, on the same axis of time; its own axis is broken."""
    time, printed = dataset.time * 1e3, float(dataset.printed_peak_normal_force) / 1e3
    for axes, unit, edge, spine in ((peaks, 1e3, 0, "bottom"), (sliding, 1, 1, "top")):
        axes.plot(time, dataset.normal_force / unit, color=style.BLUE, linewidth=0.8)
        axes.spines[spine].set_visible(False)
        axes.set_xlim(0, float(time[-1]))
        axes.plot([0, 1], [edge, edge], marker=[(-1, -0.6), (1, 0.6)], markersize=7, linestyle="none", mew=0.8,
                  color=style.BLACK, transform=axes.transAxes, clip_on=False, zorder=10)  # fmt: skip
    peaks.axhline(printed, color=style.VERMILION, linestyle="--", linewidth=0.9, label=f"{printed:g} kN, as printed")
    sliding.axhline(0, color=style.GREY, linewidth=0.6)
    highest = max(printed, float(dataset.normal_force.max()) / 1e3)
    peaks.set(title="(b) contact force", ylim=(0, 1.06 * 1.15 * highest), ylabel="$N$ [kN]")
    sliding.set(ylim=(-60.0, 160.0), xlabel="Time $t$ [ms]", ylabel="$N$ [N]")
    peaks.tick_params(labelbottom=False, bottom=False, top=False)
    sliding.tick_params(top=False)
