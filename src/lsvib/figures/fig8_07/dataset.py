"""Figure 8.7: the four sectors of the phase plane in the Painlevé region, without a solution or with two."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.contact.contact_force import Existence, existence
from lsvib.datasets import phase_plane, spans
from lsvib.datasets.attributes import drive_parameters, flagged, labels, variable
from lsvib.datasets.checks import Check
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.kernels import flow_planar, layout
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.models.rigid import EventKind, MotionMode, rigid_automaton

_LONG = 60.0  # times the decay time of law −1, after which e⁻⁶⁰ of a start is left


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Compute the existence map, motions from each sector, and where the flow of law −1 leads; R > 0, Ω > 0, Γ₊ < 0."""
    drive = RigidDrive.of(settings["drive"])
    angle, velocity = spans.even(settings["angle"]), spans.even(settings["velocity"])
    kinds = existence(drive, *np.meshgrid(angle, velocity, indexing="ij"))
    xi = coefficients(drive).xi
    with many_digits():
        equilibrium = drive.pitch_radius * float(xi[1] - xi[-1]) * drive.axial_force / drive.coupling_stiffness
    u, w = np.array([_end_of_flow(drive, start) for start in settings["starts"]]).T
    ended = "at which the flow of law - ends, if nothing stops it"
    return xr.Dataset(
        {
            "existence": flagged(
                ("grid_angle_deviation", "grid_velocity_deviation"), kinds, "solutions for the contact force", Existence
            ),
            "law_minus_angle": variable("start", u, "rad", f"deviation {ended}", "$u$"),
            "law_minus_velocity": variable("start", w, "rad s-1", f"rate {ended}", r"$\dot u$"),
        }
        | phase_plane.portraits([drive], settings["starts"], settings["duration"], settings["samples"]),
        coords={
            **phase_plane.grid_axes(angle, velocity),
            "equilibrium_angle": variable((), equilibrium, "rad", "equilibrium of the equation of law -", "$u_0$"),
            **labels("case", [drive], ()),
            **drive_parameters([drive], printed=("Sect. 8.6",)),
            **phase_plane.rule_coordinate(),
        },
        attrs={
            "title": "Figure 8.7: sectors of the phase plane without a solution or with two",
            "source": "lsvib, existence of the contact force (8.5) and exact event-driven motion",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.6, Fig. 8.7",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the map by signs alone, the motions of each sector, and where the flow of law −1 leads."""
    stop = float(dataset.stop_velocity[0])
    q = np.sign(_beyond_line(dataset, dataset.grid_angle_deviation, dataset.grid_velocity_deviation)).values
    direction = np.sign(dataset.grid_velocity_deviation - stop).values[None, :]
    by_sign = np.where(q * direction > 0, Existence.INCONSISTENT, Existence.INDETERMINATE)
    regular = (dataset.existence.values != Existence.BOUNDARY) & (q * direction != 0)
    wrong = int(np.sum((by_sign != dataset.existence.values) & regular))
    found = [int((dataset.existence == kind).sum()) for kind in (Existence.INCONSISTENT, Existence.INDETERMINATE)]
    u, w = dataset.angle_deviation.values[0, :, 0], dataset.velocity_deviation.values[0, :, 0]
    signs = np.sign(w - stop)
    inconsistent = np.sign(_beyond_line(dataset, u, w)) == signs
    seized = (dataset.event_kind.values[0, :, 0] == EventKind.SEIZURE) & (dataset.event_time.values[0, :, 0] == 0)
    impulse = dataset.event_sign.values[0, :, 0] == signs
    slips = np.where(signs > 0, MotionMode.SLIP_FORWARD_NEGATIVE, MotionMode.SLIP_BACKWARD_POSITIVE)
    follows = (dataset["mode"].values[0, :, 0] == slips) & ~seized
    gap = np.abs(dataset.law_minus_angle.values / float(dataset.equilibrium_angle) - 1).max()
    leftover = np.abs(dataset.law_minus_velocity.values).max()
    virtual = float(_beyond_line(dataset, float(dataset.equilibrium_angle), 0.0))
    return [
        Check.holds(
            "The existence analysis finds no solution where sgn Q = sgn θ' and two where they differ, nowhere else",
            "Sect. 8.6, Fig. 8.7, eq. 8.5",
            f"{wrong} exceptions among {int(regular.sum())} states; {found[0]} without a solution, {found[1]} with two",
            wrong == 0 and min(found) > 0 and bool(regular.mean() > 0.9),
        ),
        Check.holds(
            "A motion that starts in a sector without a solution seizes at once, with an impulse of the sign of θ'",
            "Sect. 8.6, Fig. 8.7",
            f"{int((seized & impulse & inconsistent).sum())} of {int(inconsistent.sum())} starts",
            bool((seized & impulse)[inconsistent].all() and inconsistent.any()),
        ),
        Check.holds(
            "A motion that starts in a sector with two solutions slips under law -1",
            "Sect. 8.6, Fig. 8.7",
            f"{int((follows & ~inconsistent).sum())} of {int((~inconsistent).sum())} starts",
            bool(follows[~inconsistent].all() and (~inconsistent).any()),
        ),
        Check.holds(
            "The flow of law -1 converges to u_0 = r_m (xi_+ - xi_-) R / k, to 1e-12",
            "Sect. 8.6",
            f"u_0 = {float(dataset.equilibrium_angle):.9g} rad, relative distance {gap:.1e}, rate {leftover:.1e} rad/s",
            gap < 1e-12 and leftover < 1e-9,
        ),
        Check.holds(
            "u_0 lies beyond the line N = 0, in a sector without a solution: every motion towards it is cut short",
            "Sect. 8.6, Fig. 8.7",
            f"{virtual:.4g} rad beyond the line",
            virtual > 0,
        ),
    ]


def _beyond_line(dataset: xr.Dataset, u, w):
    """Distance [rad] of states beyond the line N = 0; it has the sign of Q."""
    return u - (float(dataset.contact_line_angle[0]) + float(dataset.contact_line_slope[0]) * w)


def _end_of_flow(drive: RigidDrive, start: Mapping[str, float]) -> np.ndarray:
    """State in which the closed-form flow of law −1 ends, guards left out."""
    automaton = rigid_automaton(drive)
    mode = int(np.flatnonzero(automaton.codes == MotionMode.SLIP_FORWARD_NEGATIVE)[0])
    row = automaton.tables.flow[mode]
    slowest = row[layout.ALPHA] if row[layout.BETA] > 0 else -row[layout.R1]
    state = np.array([start["u"], start["w"]])
    flow_planar.advance(automaton.tables.flow, mode, state, _LONG / slowest if slowest > 0 else math.inf, state)
    return state
