"""The limit process: what a compliant contact does after an impact, branch by branch, against the rigid drive.

docs/limit_process.md says what the branches are, which contacts have the rigid drive as their limit, and by what rule.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np

from lsvib.datasets.phase_plane import sample
from lsvib.dynamics.attractor import orbit_extremes, steady_state
from lsvib.dynamics.impulses import seizure_impulse
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.motion import Motion, follow
from lsvib.errors import InputError
from lsvib.models import friction
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.models.mechanism import seated_state
from lsvib.models.model import automaton_of
from lsvib.models.names import RULES, Event
from lsvib.models.rigid import rigid_automaton


def distance(one: Motion, other: Motion, scales: tuple[float, float], corners: int = 800) -> float:
    """Return the Hausdorff distance [1] of two orbits, u and w over ``scales`` [rad, rad/s].

    It is the largest distance of a point of either from the other: of 40 points, or four to an arc, from a polygon of
    so many ``corners``. Jumps, along which only the rate changes, are sides of it.
    """
    few, many = (
        [sample(m, max(count, 4 * m.time.size + 4))[1][:, :2] / np.array(scales) @ [1, 1j] for m in (one, other)]
        for count in (40, corners)
    )
    farthest = []
    for points, polygon in ((few[0], many[1]), (few[1], many[0])):
        side, away = np.diff(polygon), points[:, None] - polygon[:-1]
        part = np.clip((away * side.conj()).real / np.where(side == 0, 1.0, np.abs(side) ** 2), 0.0, 1.0)
        farthest.append(float(np.abs(away - part * side).min(axis=1).max()))
    return max(farthest)


class Region(IntEnum):
    """Where the screw stands after an impact, in ascending order of u; CYCLE for a branch that is a whole cycle."""

    CYCLE = 0
    TORQUE_ABOVE_BAND = 1
    IN_BAND_FORCE_NEGATIVE = 2  # Q < 0
    IN_BAND_FORCE_POSITIVE = 3  # Q > 0
    TORQUE_BELOW_BAND = 4


@dataclass(frozen=True)
class Impact:
    """A start u [rad], w [rad/s] that seizes at once: sign of θ′ (0: start of a cycle) and region where it stands."""

    sign: int
    region: Region
    u: float
    w: float


def impacts(drive: Drive, speed: float) -> Iterator[Impact]:
    """Yield an impact from θ′ = ±``speed`` [rad/s] for each region that it can reach, in the middle of what it reaches.

    The outer regions are taken as wide as the band. Raises ``InputError`` for friction that is not one number.
    """
    if wanted := friction.refusal(drive):
        raise InputError(f"the closed form of what follows an impact {wanted}.")
    c, torque = coefficients(drive), drive.pitch_radius * drive.axial_force
    damping, stiffness = float(c.damping[c.steady_law]), drive.coupling_stiffness
    with many_digits():
        low, high = sorted((damping * drive.input_speed + torque * float(c.slack(s))) / stiffness for s in (1, -1))
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    turn, *reaches = (-(q_w * (rate - drive.input_speed) + q_0) / q_u for rate in (0.0, speed, -speed))  # where Q = 0
    bounds = (2 * low - high, low, turn, high, 2 * high - low)
    for sign, reach in zip((1, -1), reaches, strict=True):
        for region, left, right in zip(list(Region)[1:], bounds[:-1], bounds[1:], strict=True):
            left, right = (max(left, reach), right) if sign > 0 else (left, min(right, reach))
            if left < right:
                yield Impact(sign, region, 0.5 * (left + right), sign * speed - drive.input_speed)


@dataclass(frozen=True)
class LimitBranch:
    """A branch: drive, impact or start of the cycle, and the rigid motion by each rule of resuming."""

    drive: Drive
    impact: Impact
    rigid: list[Motion]

    @property
    def differ(self) -> bool:
        """Whether the rules lead to different motions."""
        one, other = self.rigid
        if one.time.size != other.time.size or (one.mode != other.mode).any():
            return True
        return not np.allclose(one.time, other.time, rtol=0, atol=1e-9 * one.end_time)


def branches(drive: Drive, speed: float, duration: float, start: Sequence[float]) -> Iterator[LimitBranch]:
    """Yield the impacts from θ′ = ±``speed`` [rad/s], followed for ``duration`` [s], and the cycle from ``start``.

    Raises ``InputError`` if the drive is outside the Painlevé region, has c_x ≠ 0, or has no cycle.
    """
    if not coefficients(drive).paradox or drive.translation_damping != 0:
        raise InputError("The limit process needs a drive with Γ₊ <= 0 (mass above m_cr) and translation_damping = 0.")
    automata = [rigid_automaton(drive, resume=rule) for rule in RULES]
    for impact in impacts(drive, speed):
        yield LimitBranch(drive, impact, [follow(motions, (impact.u, impact.w), duration) for motions in automata])
    reached = [steady_state(automaton, start).orbit for automaton in automata]
    cycles = [orbit for orbit in reached if orbit is not None]
    if len(cycles) < len(reached):
        raise InputError(
            f"From start the drive with axial_force = {drive.axial_force:g} reaches no cycle; give another one."
        )
    yield LimitBranch(drive, Impact(0, Region.CYCLE, *start), cycles)


def deviations(branch: LimitBranch, drive: Drive) -> dict[str, Any]:
    """Return how far the compliant motion deviates from the rigid ones; empty if it should have a cycle and has none.

    ``motion_distance`` [1], with u in half its peak-to-peak and w in |Ω|, ``rest_error`` [s] and, of a cycle,
    ``period_error`` [1], one for each rule; ``impulse_error`` [1] and ``stop_time`` [s] of an impact, until the screw
    first stands.
    """
    automaton, seated, rigid = automaton_of(drive), seated_state(drive, branch.impact.u, branch.impact.w), branch.rigid
    is_cycle = not branch.impact.sign
    if is_cycle:
        motion = steady_state(automaton, seated, max_events=100_000).orbit
    else:
        motion = follow(automaton, seated, rigid[0].end_time)
    if motion is None:
        return {}

    def rest_time(motion: Motion) -> float:
        modes, _, _, durations = motion.arcs()
        return float(durations[np.isin(motion.automaton.codes[modes], motion.automaton.rest_codes)].sum())

    low, high = orbit_extremes(rigid[0], np.array([1.0, 0.0, 0.0]))
    scales, corners = (0.5 * (high - low), abs(drive.input_speed)), 3000 if is_cycle else 800  # it bends more
    values = {
        "motion_distance": [distance(motion, other, scales, corners) for other in rigid],
        "rest_error": [rest_time(motion) - rest_time(other) for other in rigid],
    }
    if is_cycle:
        return values | {"period_error": [motion.end_time / other.end_time - 1 for other in rigid]}
    expected = float(seizure_impulse(drive, drive.input_speed + branch.impact.w))
    stops = motion.time[np.isin(motion.kind, (Event.STICK, Event.REVERSAL))]
    return values | {
        "impulse_error": impact_impulse(drive, motion) / expected - 1,
        "stop_time": stops[0] if stops.size else math.nan,
    }


def impact_impulse(drive: Drive, motion: Motion) -> float:
    """Return the normal impulse [N s] of the first impact of a compliant motion (c_x = 0); nan if it never stands.

    The impact lasts from the last reversal of the contact force before the first rest to the end of that rest; the
    impulse of the static force during the rest is not counted. The momentum of the nut gives the impulse: in slip under
    law s ∫N dt = (R Δt − m Δx′) / (cos λ + s μ sin λ), at rest ∫(N − N_static) dt = −m cos λ Δx′.
    """
    modes, starts, ends, durations = motion.arcs()
    codes = motion.automaton.codes[modes]
    rests = np.flatnonzero(np.isin(codes, motion.automaton.rest_codes))
    if rests.size == 0:
        return math.nan
    stand = rests[0]
    reversals = np.flatnonzero(motion.kind[:stand] == Event.CONTACT_REVERSAL) + 1
    begin = reversals[-1] if reversals.size else 0
    reach = drive.pitch_radius * math.tan(drive.lead_angle)
    change = (ends[:, 3] - starts[:, 3]) + reach * (ends[:, 1] - starts[:, 1])  # of x′
    sine, cosine = math.sin(drive.lead_angle), math.cos(drive.lead_angle)
    law = np.where(np.isin(codes, motion.automaton.sprag_codes), 1, -1)
    slip = (drive.axial_force * durations - drive.mass * change) / (cosine + law * drive.friction_coefficient * sine)
    return float(slip[begin:stand].sum() - drive.mass * cosine * change[stand])


def fitted_order(stiffness: np.ndarray, error: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the order p of error ∝ stiffness^(−p) along the second axis and its standard error, both nan without one.

    By least squares in logarithms, of three values at least.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = np.log(stiffness), np.log(np.abs(np.moveaxis(error, 1, -1)))
        x, y = x - x.mean(), y - y.mean(-1, keepdims=True)
        slope = y @ x / (x @ x)
        return -slope, np.sqrt(((y - slope[..., None] * x) ** 2).sum(-1) / (x.size - 2) / (x @ x))
