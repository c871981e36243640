"""The limit process: what a compliant contact does after an impact, branch by branch, against the rigid drive.

docs/limit_process.md says what the branches are, and derives the force with which an overdamped contact throws the nut
back. The contact stiffens in one of three ways: viscous, c_c = k_c · 1 s; with a fixed damping ratio ζ of the nut on
the standing screw, c_c = 2 ζ √(k_c m); elastic, c_c = 0.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Self

import numpy as np

from lsvib.dynamics.attractor import orbit_extremes, steady_state
from lsvib.dynamics.impulses import seizure_impulses
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.motion import Motion, follow
from lsvib.errors import InputError
from lsvib.models import friction
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients
from lsvib.models.mechanism import seated_state
from lsvib.models.model import automaton_of
from lsvib.models.names import RULES, Event
from lsvib.models.rigid import MotionMode, rigid_automaton

_CORNERS = (800, 3000)  # that represent a motion after one impact, and a cycle, which is longer and bends more


def curve(motion: Motion, count: int) -> np.ndarray:
    """Return points (u, w) [rad, rad/s] along a motion, shape (k, 2), both ends of each arc among them.

    ``count`` points are shared out by duration, and half as many evenly among the arcs.
    """
    _, starts, ends, durations = motion.arcs()
    shares = max(2, count // (2 * durations.size)) + np.floor(count * durations / durations.sum()).astype(int)
    bounds = np.concatenate([[motion.start_time], motion.time, [motion.end_time]])
    times = np.concatenate([np.linspace(a, b, n) for a, b, n in zip(bounds[:-1], bounds[1:], shares, strict=True)])
    states, _ = motion.at(times)
    last = np.cumsum(shares) - 1
    states[last - shares + 1], states[last] = starts, ends
    return states[:, :2]


def farthest(points: np.ndarray, polygon: np.ndarray) -> float:
    """Return the largest distance of points (k, 2) from an open polygon through the corners (l, 2)."""
    corner_x, corner_y = np.ascontiguousarray(polygon.T)  # numbers that lie side by side are worked on twice as fast
    along_x, along_y = np.diff(corner_x), np.diff(corner_y)
    length = along_x**2 + along_y**2
    length[length == 0] = 1.0
    largest, few = 0.0, 8  # points at once, so that the arrays stay in the cache
    for first in range(0, len(points), few):
        block = points[first : first + few]
        x, y = block[:, :1] - corner_x[:-1], block[:, 1:] - corner_y[:-1]
        part = np.clip((x * along_x + y * along_y) / length, 0.0, 1.0)
        squares = (x - part * along_x) ** 2 + (y - part * along_y) ** 2
        largest = max(largest, float(squares.min(axis=1).max()))
    return math.sqrt(largest)


@dataclass(frozen=True)
class Orbit:
    """The curve of a motion in the phase plane, in scales of u [rad] and w [rad/s]: a polygon, and points to measure.

    Jumps, along which only the rate changes, are sides of the polygon.
    """

    scales: tuple[float, float]
    polygon: np.ndarray
    points: np.ndarray

    @classmethod
    def of(cls, motion: Motion, scales: tuple[float, float], corners: int = 800) -> Self:
        """Sample a motion at about so many ``corners`` and 40 points to measure, and both ends of its arcs."""
        return cls(scales, *(curve(motion, count) / np.array(scales) for count in (corners, 40)))

    def distance(self, other: Self) -> float:
        """Return the Hausdorff distance [1]: the largest distance of a point of either curve from the other one."""
        return max(farthest(self.points, other.polygon), farthest(other.points, self.polygon))


def rests_of(motion: Motion) -> np.ndarray:
    """Return the times [s] that a motion spends at rest, each time that it comes to rest.

    A rest that only begins as the motion ends is none.
    """
    modes, _, _, durations = motion.arcs()
    rests = np.isin(motion.automaton.codes[modes], motion.automaton.rest_codes)
    return np.asarray(durations[rests & (durations > 0)])


class Region(IntEnum):
    """Where the screw stands after an impact, in ascending order of u; CYCLE for a branch that is a whole cycle."""

    CYCLE = 0
    TORQUE_ABOVE_BAND = 1
    IN_BAND_FORCE_NEGATIVE = 2  # Q < 0
    IN_BAND_FORCE_POSITIVE = 3  # Q > 0
    TORQUE_BELOW_BAND = 4


class ImpactOutcome(IntEnum):
    """What follows a seizure of the rigid drive."""

    REST = 0
    FORWARD_SLIP = 1
    BACKWARD_SLIP = 2


@dataclass(frozen=True)
class Impact:
    """A start that seizes at once: sign of θ′, region in which the screw then stands, u [rad] and w [rad/s]."""

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
        ends = [(damping * drive.input_speed + torque * float(c.slack(s))) / stiffness for s in (1, -1)]
    low, high = min(ends), max(ends)

    def weightless(w: float) -> float:
        """Deviation [rad] at which Q = 0."""
        slope_u, slope_w, constant = (float(x) for x in c.q_row)
        return -(slope_w * w + constant) / slope_u

    turn = weightless(-drive.input_speed)
    bounds = (2 * low - high, low, turn, high, 2 * high - low)
    for sign in (1, -1):
        w = sign * speed - drive.input_speed
        reach = weightless(w)
        for region, left, right in zip(list(Region)[1:], bounds[:-1], bounds[1:], strict=True):
            left, right = (max(left, reach), right) if sign > 0 else (left, min(right, reach))
            if left < right:
                yield Impact(sign, region, 0.5 * (left + right), w)


@dataclass(frozen=True)
class LimitBranch:
    """A branch of the rule: drive, impact (none for the cycle), start (u, w), and the rigid motions to compare with.

    ``rigid`` and ``orbits``: one for each rule of resuming; ``differ``: whether the rules lead to different motions.
    """

    drive: Drive
    impact: Impact | None
    start: Sequence[float]
    rigid: list[Motion]
    orbits: list[Orbit]
    differ: bool

    @classmethod
    def of(cls, drive: Drive, impact: Impact | None, start: Sequence[float], rigid: list[Motion]) -> Self:
        """Prepare the comparison; scales are half the peak-to-peak of u [rad] of the first motion, and |Ω| [rad/s]."""
        one, other = rigid
        differ = one.time.size != other.time.size or not (
            np.allclose(one.time, other.time, rtol=0, atol=1e-9 * one.end_time) and (one.mode == other.mode).all()
        )
        low, high = orbit_extremes(one, np.array([1.0, 0.0, 0.0]))
        scales = (0.5 * (high - low), abs(drive.input_speed))
        orbits = [Orbit.of(motion, scales, _CORNERS[impact is None]) for motion in rigid]
        return cls(drive, impact, start, rigid, orbits, differ)


def branches(drive: Drive, speed: float, duration: float, start: Sequence[float]) -> Iterator[LimitBranch]:
    """Yield the impacts from θ′ = ±``speed`` [rad/s], followed for ``duration`` [s], and the cycle from ``start``.

    Raises ``InputError`` if the drive is outside the Painlevé region, has c_x ≠ 0, or has no cycle.
    """
    if not coefficients(drive).paradox or drive.translation_damping != 0:
        raise InputError("The limit process needs a drive with Γ₊ <= 0 (mass above m_cr) and translation_damping = 0.")
    automata = [rigid_automaton(drive, resume=rule) for rule in RULES]
    for impact in impacts(drive, speed):
        state = (impact.u, impact.w)
        yield LimitBranch.of(drive, impact, state, [follow(automaton, state, duration) for automaton in automata])
    reached = [steady_state(automaton, start).orbit for automaton in automata]
    cycles = [orbit for orbit in reached if orbit is not None]
    if len(cycles) < len(reached):
        raise InputError(
            f"From start the drive with axial_force = {drive.axial_force:g} reaches no cycle; give another one."
        )
    yield LimitBranch.of(drive, None, start, cycles)


def deviations(branch: LimitBranch, drive: Drive) -> dict[str, Any]:
    """Return how far the compliant motion deviates from the rigid ones; empty if it should have a cycle and has none.

    ``motion_distance`` [1], ``rest_error`` [s] and, of a cycle, ``period_error`` [1], one for each rule;
    ``impulse_error`` [1] and ``stop_time`` [s] of an impact, until the screw first stands.
    """
    automaton, seated = automaton_of(drive), seated_state(drive, *branch.start)
    if branch.impact is None:
        motion = steady_state(automaton, seated, max_events=100_000).orbit
    else:
        motion = follow(automaton, seated, branch.rigid[0].end_time)
    if motion is None:
        return {}
    orbit, rests = Orbit.of(motion, branch.orbits[0].scales, _CORNERS[branch.impact is None]), rests_of(motion)
    distance = [orbit.distance(rigid) for rigid in (branch.orbits if branch.differ else branch.orbits[:1])]
    values = {
        "motion_distance": distance if branch.differ else 2 * distance,
        "rest_error": [float(rests.sum() - rests_of(rigid).sum()) for rigid in branch.rigid],
    }
    if branch.impact is None:
        return values | {"period_error": [motion.end_time / rigid.end_time - 1 for rigid in branch.rigid]}
    expected = float(seizure_impulses(drive, drive.input_speed + branch.impact.w).normal)
    stops = motion.time[np.isin(motion.kind, (Event.STICK, Event.REVERSAL))]
    return values | {
        "impulse_error": impact_impulse(drive, motion) / expected - 1,
        "stop_time": stops[0] if stops.size else math.nan,
    }


def outcome(motion: Motion) -> ImpactOutcome:
    """Return what follows the first seizure of a rigid motion."""
    first = motion.mode[motion.kind == Event.SEIZURE][0]
    return {
        MotionMode.REST: ImpactOutcome.REST,
        MotionMode.SLIP_FORWARD_NEGATIVE: ImpactOutcome.FORWARD_SLIP,
        MotionMode.SLIP_BACKWARD_POSITIVE: ImpactOutcome.BACKWARD_SLIP,
    }[MotionMode(int(motion.automaton.codes[first]))]


def impact_impulse(drive: Drive, motion: Motion) -> float:
    """Return the normal impulse [N s] of the first impact of a compliant motion (c_x = 0); nan if it never stands.

    The impact lasts from the last reversal of the contact force before the first rest to the end of that rest; the
    impulse of the static force during the rest is not counted. The momentum of the nut gives the impulse: in slip under
    law s ∫N dt = (R Δt − m Δx′) / (cos λ + s μ sin λ), at rest ∫(N − N_static) dt = −m cos λ Δx′. Raises ``InputError``
    for friction that depends on the speed.
    """
    if wanted := friction.refusal(drive, rest=False):
        raise InputError(f"the closed form of the impulse of an impact {wanted}.")
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


def fitted_order(stiffness: np.ndarray, error: np.ndarray) -> tuple[float, float]:
    """Return the order p of error ∝ stiffness^(−p) and its standard error, by least squares in logarithms.

    Both nan with fewer than three finite errors that are not zero.
    """
    error = np.abs(error)
    good = np.isfinite(error) & (error > 0)
    if good.sum() < 3:
        return math.nan, math.nan
    (slope, _), covariance = np.polyfit(np.log(stiffness[good]), np.log(error[good]), 1, cov=True)
    return -float(slope), math.sqrt(covariance[0, 0])
