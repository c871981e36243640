"""A stiff contact after an impact and where there are two solutions, compared with the rigid drive (Sects 8.2, 8.6).

docs/limit_process.md explains the branches, the contacts whose limit is the rigid drive, and the rule of this limit.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise, product
from types import SimpleNamespace
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers import attributes as cf
from lsvib.answers.attributes import named
from lsvib.answers.phase_plane import RULE, sample
from lsvib.chapter import newton, printed_laws
from lsvib.chapter.checks import Check, each, every
from lsvib.chapter.common import Motion
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.model import seated_state
from lsvib.drives.names import RULES, Event

# All assumed: Γ₊ < 0, and forces of both signs and dampings with which impacts reach every branch.
_MASS, _FORCES, _DAMPINGS, _DURATION = 15.0, (60.0, -20.0), (1e-4, 2e-3), 0.004  # kg, N, N m s/rad, s
_START = (0.1, -20.0)  # of the cycles [rad, rad/s]
_STIFFNESS = np.array([1e5, 1e7, 1e8, 1e9, 3e9, 1e10, 3e10, 1e11])  # k_c [N/m]; c_c = k_c · 1 s
_FITTED = slice(3, None)
_ORDER = 0.8  # of convergence, at least: the first order shows as 0.86 to 0.94 at stiffnesses that are finite
_MULTIPLES = (2.0, 0.5)  # of the contact force of the saddle, beyond it and short of it
_SHORT = 0.05  # rad, of the line N = 0, where there are two solutions


def distance(one: Motion, other: Motion, scales: tuple[float, float], corners: int = 800) -> float:
    """Return the Hausdorff distance [1] of two orbits, u and w over ``scales`` [rad, rad/s].

    It is the largest distance of a point of either from the other: of 100 points, or four to an arc, from a polygon of
    so many ``corners``. Jumps, along which only the rate changes, are sides of it.
    """
    few, many = (
        [sample(m, max(count, 4 * m.time.size + 4))[1][:, :2] / np.array(scales) @ [1, 1j] for m in (one, other)]
        for count in (100, corners)
    )
    farthest = []
    for points, polygon in ((few[0], many[1]), (few[1], many[0])):
        side, away = np.diff(polygon), points[:, None] - polygon[:-1]
        part = np.clip((away * side.conj()).real / np.where(side == 0, 1.0, np.abs(side) ** 2), 0.0, 1.0)
        farthest.append(float(np.abs(away - part * side).min(axis=1).max()))
    return max(farthest)


def impacts(drive: Drive, speed: float) -> Iterator[tuple[int, float, float]]:
    """Yield sign, u [rad] and w [rad/s] of an impact from θ′ = ±``speed`` [rad/s] in each region where it may end.

    Along u they are: torque above the band of static friction, in it with Q < 0, in it with Q > 0, below it, the outer
    ones taken as wide as the band; an impact is in the middle of what it reaches.
    """
    c, torque = coefficients(drive), drive.pitch_radius * drive.axial_force
    held = [float(c.damping[c.steady_law]) * drive.input_speed + torque * float(c.slack(s)) for s in (1, -1)]
    low, high = sorted(x / drive.coupling_stiffness for x in held)
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    turn, *reaches = (-(q_w * (rate - drive.input_speed) + q_0) / q_u for rate in (0.0, speed, -speed))  # where Q = 0
    bounds = (2 * low - high, low, turn, high, 2 * high - low)
    for sign, reach in zip((1, -1), reaches, strict=True):
        for left, right in pairwise(bounds):
            left, right = (max(left, reach), right) if sign > 0 else (left, min(right, reach))
            if left < right:
                yield sign, 0.5 * (left + right), sign * speed - drive.input_speed


def limit(drive: Drive) -> cf.Variables:
    """Compute how far motions with compliant threads are from the rigid ones, on each branch over the stiffness.

    Branches are the impacts of some drives from θ′ = ±2 Ω, and their cycles.
    """
    pairs, rows = product(_FORCES, _DAMPINGS), []
    drives = [drive.replace(mass=_MASS, axial_force=r, support_damping=c) for r, c in pairs]
    for own in drives:
        for sign, *state in (*impacts(own, 2 * own.input_speed), (0, *_START)):
            rows.append((own.axial_force, own.support_damping, sign, *map(np.array, _branch(own, sign, state))))
    forces, dampings, signs, distances, times = map(np.array, zip(*rows, strict=True))
    dims, far = ("branch", "swept_contact_stiffness"), "distance of the motion from the rigid one in the phase plane"
    return {
        **cf.varied(swept_contact_stiffness=_STIFFNESS),
        **cf.varied(dims[1], swept_contact_damping=_STIFFNESS),
        **cf.varied("branch", case_mass=0 * forces + _MASS, case_axial_force=forces, case_support_damping=dampings),
        "rule": RULE,
        "impact_sign": ("branch", signs.astype(np.int8), cf.SIGNS | {"long_name": "sign of the impact, 0: a cycle"}),
        "motion_distance": cf.variable((*dims, "rule"), distances, "1", far),
        "stop_time": cf.variable(dims, times, "s", "duration of an impact, until the screw first stops"),
        **_between_solutions(drives[0]),
    }


def _branch(drive: Drive, sign: int, start: Sequence[float]) -> tuple[list[list[float]], list[float]]:
    """Distances (stiffness, rule) of an impact or a cycle from the rigid motions, NaN without a cycle; impact times.

    u is taken in half its peak-to-peak, w in |Ω|; a cycle bends more.
    """
    from lsvib.systems.attractor import orbit_extremes, steady_state
    from lsvib.systems.motion import follow

    def motion(automaton: Any, state: Any) -> Any:
        return follow(automaton, state, _DURATION) if sign else steady_state(automaton, state, max_events=10**5).orbit

    def away(one: Any, other: Any) -> float:
        if one is None or other is None:
            return np.nan
        low, high = orbit_extremes(rigid[0], np.array([1.0, 0.0, 0.0]))
        return distance(one, other, (0.5 * (high - low), abs(drive.input_speed)), 800 if sign else 3000)

    rigid = [motion(automaton_of(drive, rule), start) for rule in RULES]
    contacts = [drive.replace(contact_stiffness=k, contact_damping=k) for k in _STIFFNESS.tolist()]
    stiff = [motion(automaton_of(own), seated_state(own, *start)) for own in contacts]
    stands = [m.time[np.isin(m.kind, (Event.STICK, Event.REVERSAL))] if sign else () for m in stiff]
    return [[away(m, other) for other in rigid] for m in stiff], [(*found, np.nan)[0] for found in stands]


def _between_solutions(drive: Drive) -> cf.Variables:
    """The first event of motions between two solutions, from contact forces of _MULTIPLES times the saddle's, θ′ = 2 Ω.

    Without contact damping N′ = 0 at the start.
    """
    from lsvib.systems.motion import follow

    c, w, cosine = coefficients(drive), drive.input_speed, float(np.cos(drive.lead_angle))
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    u = -(q_w * w + q_0) / q_u - _SHORT  # N < 0 under law − there
    saddle = -q_u * _SHORT / float(printed_laws.lever(drive, 1) * c.gamma[1])
    events, instants = [], []
    for damped, multiple, k in product((1, 0), _MULTIPLES, _STIFFNESS.tolist()):
        contact = drive.replace(contact_stiffness=k, contact_damping=damped * k)
        mismatch = multiple * saddle / (k * cosine)
        state = [u, w, 0.0, mismatch] if damped else [u, w, mismatch, 0.0]
        motion = follow(automaton_of(contact), state, _DURATION, max_events=1)
        events.append((*motion.kind, -1)[0])
        instants.append((*motion.time, np.nan)[0])
    dims = ("contact_kind", "multiple", "swept_contact_stiffness")
    kinds, times = (np.reshape(x, (2, len(_MULTIPLES), _STIFFNESS.size)) for x in (events, instants))
    event = "first event from a multiple of the saddle's contact force"
    return {
        "indeterminate_event": (dims, kinds.astype(np.int8), cf.attributes("1", event, **cf.flags(Event, none=True))),
        "indeterminate_time": cf.variable(dims, times, "s", f"time of the {event}"),
    }


def _lost(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Velocity that the screw has lost when it first stands, over 2 Ω, by the chapter's formula and by its limit.

    From the times at which it stands, beyond the saddle and without contact damping (Sect. 8.2).
    """
    p = SimpleNamespace(**newton.parameters(dataset) | {"mass": float(dataset.case_mass[0])})
    lead, gamma, inertia = p.mass * p.pitch_radius * np.tan(p.lead_angle), printed_laws.inertia(p, 1), p.screw_inertia
    drift = -_SHORT * p.coupling_stiffness * lead  # W = I P − m r_m tan λ T
    torque, speed = (inertia * float(dataset.case_axial_force[0]) - drift) / lead, 2 * p.input_speed
    t, stiffness = dataset.indeterminate_time[1, 0], dataset.swept_contact_stiffness
    pulse = np.sqrt(stiffness * np.cos(p.lead_angle) * printed_laws.lever(p, 1) * abs(gamma) / (p.mass * inertia))  # ω̄
    factor = p.pitch_radius * printed_laws.factor(p, 1) * drift / inertia / speed
    growth = factor * (_MULTIPLES[0] - 1) / (2 * gamma) / pulse
    limit = growth * np.exp(pulse * t)
    return limit - growth * np.exp(-pulse * t) + (factor / gamma - torque / inertia / speed) * t, limit


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check the rule that each branch follows, what impacts do, and the chapter's formula of one."""
    stiff, impact = dataset.isel(swept_contact_stiffness=_FITTED), dataset.impact_sign.values != 0
    k, stops = stiff.swept_contact_stiffness.values, stiff.stop_time.values[impact]
    told, other = np.moveaxis(stiff.motion_distance.values, -1, 0)
    orders, brief = (-np.polyfit(np.log(k), np.log(x).T, 1)[0] for x in (told, stops))
    part = other[other[:, -1] > 10 * told[:, -1]]
    stays = part[:, -1] > 0.9 * part[:, -2]
    seizes, turns = (named(stiff.indeterminate_event, kind) for kind in ("stick", "contact reversal"))
    time = stiff.indeterminate_time.values[:, 0]
    error = np.abs(np.stack(_lost(stiff)) - 1)
    numbers = {"order": _ORDER, "stiffest": k[-1], "branches": impact.size}
    return [
        Check.that("impacts.converges", least_order=each(orders, ">=", _ORDER),
                   last=each(told[:, -1], "<", 1e-3),  # nothing that a picture shows
                   distance=told[:, -1], orders=orders, **numbers),
        Check.that("impacts.rules", branches=every(stays)),
        Check.that("impacts.time", steps=each(np.diff(stops), "<", 0), least_order=each(brief, ">=", _ORDER),
                   orders=brief, times=stops[:, -1], **numbers),
        Check.that("impacts.stands", impacts=every(np.isfinite(dataset.stop_time.values[impact]))),
        Check.that("impacts.seizes", seizes=every(seizes[:, 0]), steps=each(np.diff(time), "<", 0), time=time[..., -1]),
        Check.that("impacts.turns_on", contacts=every(turns[:, 1])),
        Check.that("impacts.formula", steps=each(np.diff(error), "<", 0), last=each(error[:, -1], "<", 0.05),
                   whole=error[0, -1], limit=error[1, -1]),
    ]  # fmt: skip
