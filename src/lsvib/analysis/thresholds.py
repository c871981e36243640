"""The axial forces at which the steady state changes kind: roots of closed-form conditions or of the return map."""

import math

import numpy as np

from lsvib.analysis.cycles import Attractor, steady_state
from lsvib.core import planar
from lsvib.core.status import Found
from lsvib.errors import InputError
from lsvib.models.coefficients import coefficients
from lsvib.models.motion import follow
from lsvib.models.parameters import LeadScrew
from lsvib.models.rigid import EventKind, MotionMode, rigid_drive

_INSIDE = 1e-9  # relative distance from the threshold at which the seizure next to it is looked at


class NoThreshold(InputError):
    """The drive has no such threshold; the sentence says why."""


def _require_negative_damping(drive: LeadScrew) -> None:
    c = coefficients(drive)
    if c.paradox:
        raise NoThreshold(
            "the drive is in the Painleve region (effective inertia of law + not positive), outside conditions (8.19)."
        )
    if c.damping[1] >= 0:
        raise NoThreshold(
            "the effective damping of law + is not negative, so conditions (8.19) hold for no axial force."
        )


def onset_force(drive: LeadScrew) -> float:
    """Axial force R [N] at which N_0 = 0 and steady sliding loses stability, R = r_m tan λ c_x Ω (eqs 8.15, 8.19)."""
    _require_negative_damping(drive)
    d = drive.exact()
    return float(d.pitch_radius * d.tan_lead * d.translation_damping * d.input_speed)


def stick_force(drive: LeadScrew) -> float:
    """Axial force R [N] at which the slip cycle first touches θ′ = 0.

    Without that guard the motion scales with R̃, so one cycle of the return map at R̃ = ±1 N with extreme velocity w_1
    gives R̃ = Ω / |w_1|. Raises ``NoThreshold`` if there is no such cycle.
    """
    onset = onset_force(drive)
    direction = math.copysign(1.0, drive.input_speed)
    # R̃ = R − onset is formed exactly in the model; a force large against the onset makes it a plain number.
    force = onset + direction * max(1.0, abs(onset))
    trial = drive.replace(axial_force=force)
    net_force = float(coefficients(trial).net_force)
    automaton = rigid_drive(trial, rest=False)
    law = next(k for k, code in enumerate(automaton.codes) if code in (0, 3))
    cycle = steady_state(automaton, _off_equilibrium(trial, automaton, law), mode=law)
    if cycle.label != Attractor.OTHER_CYCLE:
        raise NoThreshold(
            "slip without rest has no limit cycle for this drive, so there is no force at which one touches rest."
        )
    low, high = cycle.extremes(np.array([0.0, 1.0, 0.0]))
    fastest_backward = -low if direction > 0 else high
    return onset + net_force * abs(drive.input_speed) / fastest_backward


def _off_equilibrium(drive: LeadScrew, automaton, law: int) -> np.ndarray:
    """A state a little off the unstable equilibrium, well within N ≠ 0."""
    q_u, _, q_0 = (float(x) for x in coefficients(drive).q_row)
    return np.array([-0.5 * q_0 / q_u, 0.0])


def detach_force(drive: LeadScrew) -> float:
    """Axial force R [N] beyond which the stick–slip cycle no longer reaches N = 0.

    Rest ends at u = C₊ Ω / k whatever R is, and the slip under law + that follows depends on R only through N; so the
    cycle touches Q = Q_uw(u, w) + Γ₊ R̃ = 0 at R̃ = −min Q_uw / Γ₊ over that slip. Raises ``NoThreshold`` if slip does
    not end in rest.
    """
    onset = onset_force(drive)
    c = coefficients(drive)
    direction = math.copysign(1.0, drive.input_speed)
    automaton = rigid_drive(drive.replace(axial_force=2 * onset + direction * 1e3))
    mode = int(
        np.flatnonzero(
            automaton.codes
            == (MotionMode.SLIP_FORWARD_POSITIVE if direction > 0 else MotionMode.SLIP_BACKWARD_NEGATIVE)
        )[0]
    )
    flow = automaton.tables.flow
    start = np.array([float(c.damping[1]) * drive.input_speed / drive.coupling_stiffness, -drive.input_speed])
    speed = direction * np.array([0.0, 1.0, drive.input_speed])
    found, duration = planar.crossing(flow, mode, start, speed, True, math.inf)
    if found != Found.CROSSING:
        raise NoThreshold(
            "slip under law + does not come back to rest for this drive, so no stick-slip cycle can leave N = 0."
        )
    q = np.array([float(c.q_row[0]), float(c.q_row[1]), 0.0])
    low, high = planar.extremes(flow, mode, start, q, duration)
    return onset - (low if direction > 0 else high) / float(c.gamma[1])


def global_stability_force(drive: LeadScrew) -> float:
    """Axial force R [N] beyond which steady sliding is globally stable in the Painlevé region (end of Sect. 8.7).

    Every seizure ends in rest, and rest ends at u = c Ω / k whatever R is; the slip under law −1 that follows reaches
    the origin unless it meets Q = Q_uw(u, w) + Γ₋ R = 0. It touches that line at R = −max(Q_uw) / Γ₋ (Ω > 0). For c_x =
    0 and Γ₊ < 0, as in the chapter; raises ``NoThreshold`` otherwise.
    """
    c = coefficients(drive)
    if not c.paradox or drive.translation_damping != 0:
        raise NoThreshold(
            "the threshold of global stability is defined for the Painleve region without translation damping."
        )
    if drive.support_damping == 0:
        raise NoThreshold("without support damping steady sliding attracts nothing.")
    direction = math.copysign(1.0, drive.input_speed)
    against = drive.replace(axial_force=-direction)
    automaton = rigid_drive(against)
    code = MotionMode.SLIP_FORWARD_NEGATIVE if direction > 0 else MotionMode.SLIP_BACKWARD_POSITIVE
    mode = int(np.flatnonzero(automaton.codes == code)[0])
    start = np.array([drive.support_damping * drive.input_speed / drive.coupling_stiffness, -drive.input_speed])
    q = np.array([float(c.q_row[0]), float(c.q_row[1]), 0.0])
    # The extremes along a decaying flow lie within its first turn, or within a few times its slowest time.
    row = automaton.tables.flow[mode]
    horizon = 2 * math.pi / row[planar.BETA] if row[planar.BETA] > 0 else 40 / abs(row[planar.R1])
    low, high = planar.extremes(automaton.tables.flow, mode, start, q, horizon)
    reach = high if direction > 0 else -low
    if reach <= 0:
        raise NoThreshold("slip from rest never turns back towards Q = 0 for this drive, so rest starts no cycle.")
    force = -direction * reach / float(c.gamma[-1])
    nearby = drive.replace(axial_force=force * (1 - _INSIDE))
    if direction * _seizure_angle(nearby, start) < direction * start[0]:
        raise NoThreshold(
            "a seizure at the threshold does not lead to rest for this drive, so cycles without rest decide."
        )
    return force


def _seizure_angle(drive: LeadScrew, start: np.ndarray) -> float:
    """Angle u [rad] at which the slip from ``start`` seizes."""
    motion = follow(rigid_drive(drive), start, math.inf, stop=(EventKind.SEIZURE, -1), max_events=2)
    return float(motion.before[-1, 0])
