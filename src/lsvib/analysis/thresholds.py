"""The axial forces at which the steady state changes kind: roots of closed-form conditions or of the return map."""

import math
from decimal import Decimal

import numpy as np

from lsvib.analysis.cycles import Attractor, steady_state
from lsvib.core import crossing, planar
from lsvib.core.status import Found
from lsvib.errors import InputError
from lsvib.models.coefficients import coefficients
from lsvib.models.parameters import LeadScrew
from lsvib.models.rigid import MotionMode, rigid_drive

_GRID = 1000  # times at which the returns of slip are looked at, before the largest is refined
_GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))


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
    """Axial force R [N] at which N_0 = 0 and steady sliding loses stability, R = r_m tan λ c_x Ω (eqs 8.15, 8.19).

    Raises ``NoThreshold`` in the Painlevé region and where the effective damping of law + is not negative.
    """
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
    found, duration = crossing.crossing(flow, mode, start, speed, True, math.inf)
    if found != Found.CROSSING:
        raise NoThreshold(
            "slip under law + does not come back to rest for this drive, so no stick-slip cycle can leave N = 0."
        )
    q = np.array([float(c.q_row[0]), float(c.q_row[1]), 0.0])
    low, high = crossing.extremes(flow, mode, start, q, duration)
    return onset - (low if direction > 0 else high) / float(c.gamma[1])


def global_stability_force(drive: LeadScrew) -> float:
    """Axial force R [N] against the motion beyond which steady sliding is globally stable (Γ₊ ≤ 0, end of Sect. 8.7).

    Slip under law −1 does not depend on R except through Q = Q_uw(u, w) + Γ₋ R̃, so that it meets Q = 0 at R̃ = −max Q_uw
    / Γ₋ at the latest (Ω > 0). Two kinds of motion can go on for ever:

    * from the end of rest, u = C₋ Ω / k, to a seizure, then rest again: until that slip no longer touches Q = 0;
    * from θ′ = 0 at u = x to a seizure at the same u, without rest. With w(x) the rate of slip coming back to u =
      x, this cycle has R̃ = −Q_uw(x, w(x)) / Γ₋; the last of them, at the maximum over x, has the multiplier 1.

    The one that ends last decides; there is no other threshold, see docs/basin.md. Raises ``NoThreshold`` outside the
    Painlevé region, without damping, and where steady sliding is globally stable under every force against the motion.
    """
    c = coefficients(drive)
    if not c.paradox:
        raise NoThreshold(
            "the drive is not in the Painleve region (effective inertia of law + positive), where forces against the "
            "motion start no cycle of seizures."
        )
    if c.damping[-1] <= 0:
        raise NoThreshold("without damping steady sliding attracts nothing.")
    speed = abs(drive.input_speed)
    # With R̃ < 0 the flow is that about steady sliding, whatever R̃ is.
    automaton = rigid_drive(drive.replace(input_speed=speed, axial_force=-1.0))
    mode = automaton.codes.tolist().index(MotionMode.SLIP_FORWARD_NEGATIVE)
    flow = automaton.tables.flow
    released = np.array([float(c.damping[-1]) * speed / drive.coupling_stiffness, -speed])
    q = np.array([float(c.q_row[0]), float(c.q_row[1]), 0.0])
    # The extremes along a decaying flow lie within its first turn, or within a few times its slowest time.
    row = flow[mode]
    horizon = 2 * math.pi / row[planar.BETA] if row[planar.BETA] > 0 else 40 / abs(row[planar.R1])
    _, reach = crossing.extremes(flow, mode, released, q, horizon)
    if q[1] > 0:  # otherwise a seizure is followed by slip backward or rest, and by no cycle but that with rest
        reach = max(reach, _widest_return(row, speed, q, released[0]))
    d = drive.exact()
    onset = d.pitch_radius * d.tan_lead * d.translation_damping * abs(d.input_speed)
    force = onset - Decimal(reach) / c.gamma[-1]
    if not force < -Decimal(planar.ROUNDING) * abs(onset):
        raise NoThreshold("steady sliding is globally stable under every axial force against the motion.")
    return math.copysign(float(force), -drive.input_speed)


def _widest_return(row: np.ndarray, speed: float, q: np.ndarray, largest: float) -> float:
    """Largest Q_uw at which slip from θ′ = 0 at u = x < ``largest`` [rad] comes back to u = x for the first time.

    With the responses S and C of the flow, slip that comes back after a time τ starts at x = −Ω S / (1 − C) and has the
    rate w = −Ω S′ − a₀ x S then: the maximum is one over τ.
    """

    def returned(time: float) -> tuple[float, float]:
        c, s, s_rate = planar.responses(row, time)
        x = -speed * s / (1.0 - c) if c < 1.0 else math.inf
        return x, -speed * s_rate - row[planar.A0] * x * s

    def height(time: float) -> float:
        x, w = returned(time)
        return q[0] * x + q[1] * w

    times = row[planar.TIME_SCALE] * np.linspace(0.0, 2 * math.pi, _GRID)[1:]
    back = [returned(t) for t in times]
    count = next((k for k, (x, w) in enumerate(back) if not (x < largest and w > 0)), len(back))
    if count == 0:
        return -math.inf
    best = max(range(count), key=lambda k: height(times[k]))
    low, high = times[max(best - 1, 0)], times[min(best + 1, count - 1)]
    for _ in range(100):
        left, right = low + _GOLDEN * (high - low), high - _GOLDEN * (high - low)
        low, high = (left, high) if height(left) < height(right) else (low, right)
    return height(0.5 * (low + high))
