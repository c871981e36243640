"""Figure 8.10: the sprag–slip cycle with compliant threads, its phase plane and the peaks of its contact force."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.contact.curve_distance import Orbit
from lsvib.datasets import phase_plane, printed, spans
from lsvib.datasets.attributes import axis, drive_parameters, flagged, quantity, start_state, variable
from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor, SteadyState, orbit_extremes, steady_state
from lsvib.engine.automaton import Automaton
from lsvib.engine.motion import Motion, follow
from lsvib.figures.common.compliant_cycles import compliant_attractors, compliant_cycle, cycle_curves
from lsvib.models import chapter
from lsvib.models.drive import RigidDrive, ThreadsDrive
from lsvib.models.rigid import rigid_automaton
from lsvib.models.threads import ThreadsEvent, ThreadsMode, seated_state

_ZOOM = 400  # samples of the peak that is drawn alone
_PEAK = ("N", "largest normal force on the cycle", "$N$")
_DISTANCE = (
    "1",
    "distance of the compliant from the rigid cycle, in scales of the rigid amplitude and the input speed",
)
_FROM, _TO = -0.3, 1.6  # extent of that drawing, in durations of the sprag from its start


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute motion and cycle with compliant threads from a seated contact, the rigid cycle, and the effect of R."""
    contact = {key: settings[key] for key in ("contact_stiffness", "contact_damping")}
    drive, start = ThreadsDrive.of(settings["drive"], **contact), settings["start"]
    automaton, cycle = compliant_cycle(drive, start)
    rigid_cycle = steady_state(rigid_automaton(drive), [start["u"], start["w"]])
    motion = follow(automaton, seated_state(drive, start["u"], start["w"]), settings["duration"])
    forces = spans.even(settings["axial_force"])
    return xr.Dataset(
        _motion(motion, settings["samples"])
        | cycle_curves((), [cycle], settings["samples"])
        | cycle_curves((), [rigid_cycle], settings["samples"], "rigid_cycle")
        | _peak(automaton, cycle)
        | _comparison(drive, cycle, rigid_cycle)
        | _sensitivity(drive, forces, start),
        coords={
            **axis("swept_axial_force", forces),
            **drive_parameters(drive, printed=("Sect. 8.6", "Sect. 8.6.1")),
            **start_state(start, "with a seated contact: of the motion and of those whose cycles are found"),
            "printed_peak_normal_force": printed.variable(chapter.PEAK_FORCE, "largest contact force on the cycle"),
        },
        attrs={
            "title": "Figure 8.10: sprag-slip vibration with compliant threads",
            "source": "lsvib, exact event-driven motion with four states",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.6.1, Fig. 8.10",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the printed peak force, how little R changes it, and how close the motion stays to the rigid one."""
    force, peak = dataset.swept_axial_force.values, dataset.swept_peak_normal_force.values
    claim = chapter.PEAK_FORCE
    farthest = float(np.max(np.abs(peak / claim.value - 1)))
    labels = np.append(dataset.swept_attractor.values, [dataset.attractor, dataset.rigid_attractor])
    near = dataset.swept_orbit_distance.values
    sprags = dataset["mode"].values == ThreadsMode.REST_POSITIVE
    late = dataset.normal_force.values[sprags & (dataset.time.values > 0.5 * float(dataset.time[-1]))]
    highest = float(late.max()) if late.size else np.nan
    return [
        printed.check("Peak of the contact force on the cycle", claim, dataset.peak_normal_force),
        Check.holds(
            f"The peak stays within {100 * claim.tolerance:g} % of {claim.value / 1e3:g} kN whatever R is, which the "
            "text leaves out",
            claim.source,
            f"{peak.min() / 1e3:.2f} to {peak.max() / 1e3:.2f} kN for R from {force[0]:g} to {force[-1]:g} N",
            farthest <= claim.tolerance,
        ),
        Check.holds(
            "The cycle lies within 2 % of the rigid one of Fig. 8.9b, in scales of its amplitude and of Ω",
            "Sect. 8.6.1, Fig. 8.10a",
            f"distance {float(dataset.orbit_distance):.4f} (amplitude {float(dataset.amplitude):.6g} against "
            f"{float(dataset.rigid_amplitude):.6g} rad, period {float(dataset.period):.7g} against "
            f"{float(dataset.rigid_period):.7g} s); {near.min():.4f} to {near.max():.4f} over R",
            float(dataset.orbit_distance) <= 0.02,
        ),
        Check.holds(
            "With either model and for every R the motion ends on a sprag-slip cycle, which repeats to 1e-9",
            "Sect. 8.6.1, Fig. 8.10",
            f"{int((labels == Attractor.SPRAG_SLIP_CYCLE).sum())} of {labels.size}, residual "
            f"{float(dataset.period_residual):.1e}",
            bool((labels == Attractor.SPRAG_SLIP_CYCLE).all() and float(dataset.period_residual) <= 1e-9),
        ),
        Check.holds(
            "Largest sample of N(t) in the second half of the motion is the exact peak of the cycle, to 1e-6: the "
            "peak is at an event, which is a sample, and the motion is on its cycle",
            "resolution of Fig. 8.10b",
            f"{highest:.9g} N against {float(dataset.peak_normal_force):.9g} N",
            bool(abs(highest / dataset.peak_normal_force - 1) <= 1e-6),
        ),
    ]


def _motion(motion: Motion, samples: int) -> phase_plane.Variables:
    """The compliant motion with its contact force; both states of each event are samples, so every peak is."""
    times, states, modes = phase_plane.sample(motion, samples)
    # The same rows in every mode.
    row, deflection = (motion.automaton.observables[name][0] for name in ("normal_force", "coupling_deflection"))
    return {
        "time": variable("sample", times, "s", "time", "$t$"),
        "angle_deviation": ("sample", states[:, 0], quantity("angle_deviation")),
        "velocity_deviation": ("sample", states[:, 1], quantity("velocity_deviation")),
        "normal_force": ("sample", states @ row[:-1] + row[-1], quantity("normal_force")),
        "coupling_deflection": ("sample", states @ deflection[:-1] + deflection[-1], quantity("coupling_deflection")),
        **{name: ("sample", states[:, 2 + k], quantity(name)) for k, name in enumerate(motion.automaton.states[2:])},
        "mode": flagged("sample", motion.automaton.codes[modes], "mode of motion", ThreadsMode),
    }


def _peak(automaton: Automaton, cycle: SteadyState) -> phase_plane.Variables:
    """The contact force around a peak, over time from the start of the sprag."""
    (times, force), sprag = np.full((2, _ZOOM), np.nan), np.nan
    if cycle.label == Attractor.SPRAG_SLIP_CYCLE:  # else there is nothing to draw; the checks say so
        period = cycle.orbit.end_time
        twice = follow(automaton, cycle.state, 2 * period, mode=cycle.orbit.start_mode)
        stick = int(np.flatnonzero((twice.kind == ThreadsEvent.STICK) & (twice.time > 0.5 * period))[0])
        begin, sprag = twice.time[stick - 1], float(twice.time[stick] - twice.time[stick - 1])
        times = begin + sprag * np.linspace(_FROM, _TO, _ZOOM)
        times = np.sort(np.append(times, twice.time[stick - 1 : stick + 3]))
        force, times = automaton.observe("normal_force", *twice.at(times)), times - begin
    return {
        "close_up_time": variable("close_up_sample", times, "s", "time after the start of a sprag", "$t$"),
        "close_up_normal_force": ("close_up_sample", force, quantity("normal_force")),
        "sprag_duration": variable((), sprag, "s", "time from N = 0 until the screw stands"),
    }


def _comparison(drive: RigidDrive, cycle: SteadyState, rigid: SteadyState) -> phase_plane.Variables:
    """The cycle in numbers, beside the rigid one."""
    named: phase_plane.Variables = {}
    for name, steady, words in (("", cycle, ""), ("rigid_", rigid, ", of the rigid drive")):
        low, high = steady.extremes(np.eye(1, steady.state.size + 1)[0])  # of u
        named |= {
            f"{name}attractor": flagged((), steady.label, phase_plane.ATTRACTOR + words, Attractor),
            f"{name}amplitude": variable((), 0.5 * (high - low), "rad", phase_plane.AMPLITUDE + words),
            f"{name}period": variable((), steady.period, "s", phase_plane.PERIOD + words, "$T$"),
        }
    peak, distance = _cycle_values(drive, cycle, rigid)
    return named | {
        "peak_normal_force": variable((), peak, *_PEAK),
        "orbit_distance": variable((), distance, *_DISTANCE),
        "period_residual": variable((), cycle.residual, "1", "relative change of the section state over a period"),
    }


def _cycle_values(drive: RigidDrive, cycle: SteadyState, rigid: SteadyState) -> tuple[float, float]:
    """Largest |N| [N] on the compliant cycle, and its distance [1] from the rigid one; nan where there is none."""
    if cycle.orbit is None or rigid.orbit is None:
        return np.nan, np.nan
    low, high = orbit_extremes(cycle.orbit, cycle.orbit.automaton.observables["normal_force"])
    scales = (rigid.amplitude, abs(drive.input_speed))
    return max(-low, high), Orbit.of(cycle.orbit, scales).distance(Orbit.of(rigid.orbit, scales))


def _sensitivity(drive: ThreadsDrive, forces: np.ndarray, start: Mapping[str, float]) -> phase_plane.Variables:
    rows = []
    drives = [drive.replace(axial_force=float(force)) for force in forces]
    for pushed, cycle in zip(drives, compliant_attractors(drives, start), strict=True):
        rigid = steady_state(rigid_automaton(pushed), [start["u"], start["w"]])
        rows.append((cycle.label, *_cycle_values(pushed, cycle, rigid)))
    label, peak, distance = np.array(rows, dtype=float).T
    return {
        "swept_attractor": flagged("swept_axial_force", label, phase_plane.ATTRACTOR, Attractor),
        "swept_peak_normal_force": variable("swept_axial_force", peak, *_PEAK),
        "swept_orbit_distance": variable("swept_axial_force", distance, *_DISTANCE),
    }
