"""Seizures that accumulate in the corner θ′ = 0 = Q, as the chapter reads its rule of resuming (Sect. 8.7).

Let a reverse slip start at a distance d from the corner along θ′ = 0, and let it meet N = 0. With the line N = 0 as
u = u_0 + σ (u′ + Ω), σ < 0, and the acceleration −a, a > 0, it lasts τ = d / (Ω + |σ| a) and ends at the distance
|σ| a τ, both to first order in d. So the distances fall with the ratio q = |σ| a / (Ω + |σ| a), which is
c a / (k Ω + c a) without translation damping, and the time left is d / Ω: infinitely many seizures in finite time.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from lsvib.datasets import phase_plane
from lsvib.datasets.attributes import variable
from lsvib.datasets.checks import Check
from lsvib.engine.exact.arithmetic import many_digits
from lsvib.engine.motion import Motion, follow
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients
from lsvib.models.model import RULES
from lsvib.models.rigid import EventKind, rigid_automaton

_ROUNDING = 16 * np.finfo(float).eps  # of the corner: a few rounding errors of u and of the line N = 0


def reverse_slips(
    drives: Sequence[RigidDrive], start: Mapping[str, float], duration: float, samples: int
) -> phase_plane.Variables:
    """Compute, for each drive and rule of resuming, the seizures before the first release, and the motion until then.

    Arguments: drives (R < 0 < Ω); ``start`` u [rad], w [rad/s], in reverse rotation; ``duration`` [s] and number of
    ``samples``. Returns variables along (case, rule, seizure) and (case, rule, slip_sample), and along case the ratio
    of successive distances and the length over which it may change; both are missing where Γ₊ > 0.
    """
    state = [start["u"], start["w"]]
    motions = [[_until_release(drive, rule, state, duration) for rule in RULES] for drive in drives]
    found = [[_seizures(motion, drive) for motion in row] for row, drive in zip(motions, drives, strict=True)]
    size = (len(drives), len(RULES), max(1, max(times.size for row in found for times, _ in row)))
    table = np.full((2, *size), np.nan)
    for i, row in enumerate(found):
        for j, values in enumerate(row):
            table[:, i, j, : values[0].size] = values
    sampled = np.array([[phase_plane.sample(motion, samples)[1] for motion in row] for row in motions])
    limits = np.array([_limits(drive) for drive in drives])
    dims, line = ("case", "rule", "seizure"), ("case", "rule", "slip_sample")
    return {
        "seizure_time": variable(dims, table[0], "s", "time of a seizure before the first release", "$t$"),
        "seizure_distance": variable(
            dims, table[1], "rad", "distance of the seizure from the corner of N = 0 and theta' = 0", "$u - u_0$"
        ),
        **phase_plane.curve("slip", line, sampled, "until the first release"),
        "seizure_ratio": variable(
            "case", limits[:, 0], "1", "limit of the ratio of successive distances, by resuming at once", "$q$"
        ),
        "acceleration_length": variable(
            "case", limits[:, 1], "rad", "acceleration from rest in the corner over its derivative along theta' = 0"
        ),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that the seizures accumulate under the chapter's reading, in finite time, and are few under the other."""
    heavy = np.flatnonzero(np.isfinite(dataset.seizure_ratio.values))
    counts = np.isfinite(dataset.seizure_distance.values).sum(axis=-1)
    excess, timely, words = [], [], []
    for case in heavy:
        part = dataset.isel(case=case)
        ratio, length = float(part.seizure_ratio), float(part.acceleration_length)
        count = counts[case, 1]
        distance, time = (part[f"seizure_{name}"].values[1, :count] for name in ("distance", "time"))
        rounding = _ROUNDING * abs(float(part.corner_angle))
        clear = distance[1:] > rounding
        allowed = distance[:-1] / length + rounding / np.maximum(distance[1:], rounding)
        off = np.abs(distance[1:] / distance[:-1] / ratio - 1)
        excess.append(float(np.max((off / allowed)[clear], initial=0.0)) if clear.sum() > 1 else np.inf)
        speed = -float(part.stop_velocity)
        way, left = distance[:-1] - distance[-1], time[-1] - time[:-1]
        error = rounding / speed + _ROUNDING * time[-1]
        reverse = distance[1:] / -float(part.contact_line_slope)  # largest -θ′ of a slip, where it seizes
        timely.append(((left <= way / speed + error) & (left >= way / (speed + reverse) - error)).all())
        close = np.argmin(np.where(clear, off, np.inf))
        words.append(
            f"R = {float(part.axial_force):g} N: {count} seizures, ratio {distance[close + 1] / distance[close]:.7g} "
            f"against {ratio:.7g}, the last at {distance[-1]:.1e} rad and {1e3 * time[-1]:.6g} ms"
        )
    longest = 1e3 * float(np.nanmax(dataset.seizure_time.values[:, 1], initial=0.0))
    return [
        Check.holds(
            "If motion resumes at once, seizures accumulate in the corner: the ratio of successive distances from it "
            "is c a / (k Ω + c a), up to the relative change of the acceleration a over the distance",
            "Sect. 8.7",
            f"{'; '.join(words)}; deviation at most {max(excess, default=np.inf):.2f} of what is allowed",
            len(heavy) > 0 and max(excess) <= 1,
        ),
        Check.holds(
            "They do so in finite time: what is left after each of them lies between the distance over Ω and over the "
            "largest rate of the next slip",
            "Sect. 8.7",
            f"{sum(timely)} of {len(timely)} motions, the corner reached within {longest:.4g} ms",
            len(heavy) > 0 and all(timely),
        ),
        Check.holds(
            "By the sign of the contact force, the limit of a stiff contact, these motions rest after a few seizures",
            "rule of resuming, docs/physics.md",
            f"{' and '.join(str(n) for n in counts[heavy, 0])} seizures, at once {counts[heavy, 1].min()} or more",
            len(heavy) > 0 and bool((counts[heavy, 0] < counts[heavy, 1]).all()),
        ),
    ]


def _until_release(drive: RigidDrive, rule: str, state: Sequence[float], duration: float) -> Motion:
    """The motion up to its first release, or all of it."""
    automaton = rigid_automaton(drive, resume=rule)
    whole = follow(automaton, state, duration)
    released = np.flatnonzero(whole.kind == EventKind.RELEASE)
    return follow(automaton, state, float(whole.time[released[0]])) if released.size else whole


def _seizures(motion: Motion, drive: RigidDrive) -> tuple[np.ndarray, np.ndarray]:
    """Times [s] of the seizures of a motion, and their distances [rad] from the corner."""
    here = motion.kind == EventKind.SEIZURE
    return motion.time[here], motion.before[here, 0] - corner(drive)


def corner(drive: RigidDrive) -> float:
    """Return u_0 = c Ω / k − Γ₋ R / (k m r_m tan λ) [rad], R < 0 and Ω > 0 (Sect. 8.7)."""
    c, p = coefficients(drive), drive.exact()
    with many_digits():
        lever = p.coupling_stiffness * p.mass * p.pitch_radius * p.tan_lead
        return float(p.support_damping * p.input_speed / p.coupling_stiffness - c.gamma[-1] * p.axial_force / lever)


def _limits(drive: RigidDrive) -> tuple[float, float]:
    """Limit of the ratio [1], and the length [rad] over which the acceleration changes by all of it; NaN if Γ₊ > 0."""
    c = coefficients(drive)
    if c.gamma[1] > 0:
        return np.nan, np.nan
    length = corner(drive) - float(c.damping[-1]) * drive.input_speed / drive.coupling_stiffness
    with many_digits():
        slope = float(c.q_row[1] / c.q_row[0])
    gain = slope * drive.coupling_stiffness * length / float(c.gamma[-1])  # |σ| a
    return gain / (drive.input_speed + gain), length
