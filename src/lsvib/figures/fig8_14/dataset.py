"""Figure 8.14: region of attraction under a negative axial force, for both readings of the mass.

The text states m = 10 kg, for which Γ₊ > 0, but Sect. 8.7 assumes Γ₊ < 0: the same two forces are also computed for
a mass beyond m_cr.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from lsvib.datasets import phase_plane, spans
from lsvib.datasets.attributes import drive_parameters, flagged, labels, variable
from lsvib.datasets.checks import Check
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.figures.common import accumulation
from lsvib.models.drive import RigidDrive
from lsvib.models.model import RULES
from lsvib.models.rigid import EventKind, rigid_automaton
from lsvib.stability.force_thresholds import global_stability_force

_CHANGED = ("mass", "axial_force")  # in which the cases differ
_ASIDE = 1e-9  # relative distance from the threshold at which the attractor is computed, on either side
_DISTANCES = np.concatenate([[0.0], np.geomspace(1e-4, 2.0, 60)])  # rad; the cycles of the figure are 0.1 rad wide


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the four phase planes (mass by mass, force by force) and the force of global stability beyond m_cr.

    Seizures of the motion from the last of the ``starts`` accumulate under the chapter's reading of the rule.
    """
    drive = RigidDrive.of(settings["drive"])
    drives = [drive.replace(mass=m, axial_force=r) for m in settings["masses"] for r in settings["axial_forces"]]
    angle, velocity = spans.even(settings["angle"]), spans.even(settings["velocity"])
    plane = ("case", "grid_angle_deviation", "grid_velocity_deviation")
    grid = [_basin(d, angle, velocity) for d in drives]
    threshold = global_stability_force(drives[-1])
    bracket = [threshold * (1 - _ASIDE), threshold * (1 + _ASIDE)]
    released = [[_from_release(drives[-1].replace(axial_force=force), rule) for rule in RULES] for force in bracket]
    words = "attractor of the motion that leaves rest, beside the threshold"
    return xr.Dataset(
        phase_plane.portraits(drives, settings["starts"], settings["duration"], settings["samples"])
        | accumulation.reverse_slips(drives, settings["starts"][-1], settings["duration"], settings["samples"])
        | {
            "grid_attractor": flagged(plane, grid, phase_plane.ATTRACTOR, Attractor),
            "bracket_attractor": flagged(("bracket", "rule"), released, words, Attractor),
        }
        | _corners(drives),
        coords={
            **labels("case", drives, _CHANGED),
            **drive_parameters(drives, along=_CHANGED, printed=("Fig. 8.14", "Sect. 8.6")),
            **phase_plane.rule_coordinate(),
            **phase_plane.grid_axes(angle, velocity),
            "corner_distance": variable(
                "corner_distance", _DISTANCES, "rad", "distance of the start below the corner, at standstill"
            ),
            "bracket_axial_force": variable("bracket", bracket, "N", "axial force beside the threshold", "$R$"),
            "global_stability_force": variable(
                (), threshold, "N", phase_plane.GLOBAL_STABILITY, "$R$", comment="of the last two cases, beyond m_cr"
            ),
        },
        attrs={
            "title": "Figure 8.14: trajectories under a negative axial force",
            "source": "lsvib, exact event-driven motion and its return map",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.7, Fig. 8.14",
        },
    )


def _corners(drives: Sequence[RigidDrive]) -> phase_plane.Variables:
    """The corner of the lines N = 0 and θ′ = 0, and where the motions from standstill below it end."""
    corners = [accumulation.corner(d) for d in drives]
    ends = [[_from_standstill(d, rule) for rule in RULES] for d in drives]
    where = "deviation at which the lines N = 0 and theta' = 0 meet, as printed"
    words = "attractor of the motion from standstill so far below the corner"
    return {
        "corner_angle": variable("case", corners, "rad", where, "$u_0$"),
        "corner_attractor": flagged(("case", "rule", "corner_distance"), ends, words, Attractor),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check (a) and (b) for both readings of the mass, and the threshold of global stability between them."""
    no_cycle = "no limit cycle is found, unlike in the text: every start, drawn or not, leads to the origin"
    one_cycle = "every trajectory drawn ends on a limit cycle, the same under either rule of resuming"
    return [
        _inertia_check(dataset),
        _settling_check(dataset, 0, " (as printed)"),
        _settling_check(dataset, 2, ""),
        _one_attractor_check(dataset, 1, " (as printed)", Attractor.STEADY_SLIDING, no_cycle),
        _one_attractor_check(dataset, 3, "", Attractor.SPRAG_SLIP_CYCLE, one_cycle),
        *_corner_checks(dataset),
        *accumulation.checks(dataset),
        *_threshold_checks(dataset),
    ]


def _inertia_check(dataset: xr.Dataset) -> Check:
    """Check the sign of Γ₊ for both readings of the mass, two cases each."""
    mass, gamma = dataset.mass.values, dataset.effective_inertia_plus.values
    return Check.holds(
        "The printed mass has Γ₊ > 0, against the assumption of Sect. 8.7; the other one has Γ₊ < 0",
        "Sect. 8.7, Fig. 8.14",
        f"Γ₊ = {gamma[0]:.3g} kg m2 at {mass[0]:g} kg and {gamma[2]:.3g} kg m2 at {mass[2]:g} kg",
        bool((gamma[:2] > 0).all() and (gamma[2:] < 0).all()),
    )


def _settling_check(dataset: xr.Dataset, case: int, note: str) -> Check:
    """Check that all motions of a case of (a) settle, although those which are drawn meet N = 0."""
    grid, labels = dataset.grid_attractor.values[case], dataset.attractor.values[case]
    touches = _line_crossings(dataset, case)
    claim = "every trajectory drawn meets N = 0 and yet reaches the origin, as does every other start"
    return Check.holds(
        f"(a) {_drive(dataset, case, note)}: {claim}",
        "Sect. 8.7, Fig. 8.14a",
        f"meets N = 0 {' and '.join(str(n) for n in touches)} times; {_names(labels)}; of {grid.size} "
        f"other starts {int((grid == Attractor.STEADY_SLIDING).sum())} reach the origin",
        bool((labels == Attractor.STEADY_SLIDING).all() and (grid == Attractor.STEADY_SLIDING).all())
        and min(touches) > 0,
    )


def _one_attractor_check(dataset: xr.Dataset, case: int, note: str, expected: Attractor, claim: str) -> Check:
    """Check that the motions drawn of a case of (b) reach one attractor, and all others reach it or the origin."""
    grid, labels = dataset.grid_attractor.values[case], dataset.attractor.values[case]
    amplitude = dataset.amplitude.values[case].ravel()
    return Check.holds(
        f"(b) {_drive(dataset, case, note)}: {claim}",
        "Sect. 8.7, Fig. 8.14b",
        f"{_names(labels)}, amplitude {amplitude.min():.6g} to {amplitude.max():.6g} rad; origin: of "
        f"{grid.size} other starts {int((grid == Attractor.STEADY_SLIDING).sum())} reach it",
        bool((labels == expected).all())
        and float(np.ptp(amplitude)) <= 1e-12 * float(amplitude.max())
        and bool(np.isin(grid, [Attractor.STEADY_SLIDING, expected]).all()),
    )


def _threshold_checks(dataset: xr.Dataset) -> list[Check]:
    """Check that the motion that leaves rest changes its attractor at the threshold, between the forces of (a), (b)."""
    force, threshold = dataset.axial_force.values, float(dataset.global_stability_force)
    labels = dataset.bracket_attractor.values
    return [
        Check.holds(
            "The threshold of global stability lies between the forces of (a) and (b), beyond m_cr",
            "Sect. 8.7",
            f"R = {threshold:.10g} N",
            bool(force[2] < threshold < force[3]),
        ),
        Check.holds(
            "The motion that leaves rest changes from the cycle to the origin within 1e-9 R of it, under either rule",
            "Sect. 8.7",
            f"{_names(labels[0])} just above, {_names(labels[1])} just below {threshold:.10g} N",
            bool((labels[0] == Attractor.SPRAG_SLIP_CYCLE).all() and (labels[1] == Attractor.STEADY_SLIDING).all()),
        ),
    ]


def _drive(dataset: xr.Dataset, case: int, note: str) -> str:
    """Words for the drive of a case: mass, a note on it, and force."""
    return f"m = {dataset.mass.values[case]:g} kg{note}, R = {dataset.axial_force.values[case]:g} N"


def _corner_checks(dataset: xr.Dataset) -> list[Check]:
    """The end of Sect. 8.7, word for word: all starts at standstill up to the corner, beyond m_cr."""
    met = dataset.contact_line_angle.values + dataset.contact_line_slope.values * dataset.stop_velocity.values
    gap = float(np.abs(met / dataset.corner_angle.values - 1).max())
    settles = dataset.corner_attractor.values == Attractor.STEADY_SLIDING
    counts = settles.sum(axis=2)
    return [
        Check.holds(
            "The lines N = 0 and θ′ = 0 meet in the printed corner, to 1e-12",
            "Sect. 8.7",
            f"largest relative distance {gap:.1e}",
            gap < 1e-12,
        ),
        Check.holds(
            "Beyond m_cr every motion from standstill up to the corner reaches the origin in (a), where steady sliding "
            "is globally stable, and not every one in (b), under either rule of resuming",
            "end of Sect. 8.7",
            f"(a) {counts[2].min()} and (b) {counts[3].min()} to {counts[3].max()} of {settles.shape[2]} starts",
            bool(settles[2].all() and not settles[3].all(axis=1).any()),
        ),
    ]


def _from_standstill(drive: RigidDrive, rule: str) -> list[Attractor]:
    automaton, corner = rigid_automaton(drive, resume=rule), accumulation.corner(drive)
    return [steady_state(automaton, [corner - distance, -drive.input_speed]).label for distance in _DISTANCES]


def _basin(drive: RigidDrive, angle: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Attractors of the motions from each state of a grid, shape (angle, velocity)."""
    automaton = rigid_automaton(drive)
    return np.array([[steady_state(automaton, [u, w]).label for w in velocity] for u in angle], dtype=np.int8)


def _from_release(drive: RigidDrive, rule: str) -> Attractor:
    """Attractor of the motion from the end of rest, u = c Ω / k, u′ = −Ω."""
    start = [drive.support_damping * drive.input_speed / drive.coupling_stiffness, -drive.input_speed]
    return steady_state(rigid_automaton(drive, resume=rule), start).label


def _line_crossings(dataset: xr.Dataset, case: int) -> list[int]:
    """How often each motion of a case arrives at N = 0 after its start."""
    kinds, times = dataset.event_kind.values[case], dataset.event_time.values[case]
    meets = np.isin(kinds, [EventKind.SEIZURE, EventKind.CONTACT_REVERSAL]) & (times > 0)
    return meets.sum(axis=1).tolist()


def _names(labels: np.ndarray) -> str:
    return " and ".join(sorted({Attractor(label).name.lower().replace("_", " ") for label in labels.ravel()}))
