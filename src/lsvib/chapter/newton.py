"""Newton's laws of screw and nut as an independent check: residuals along stored motions, and thresholds.

Everything follows from the numbers of a dataset, without the engine or the coefficients that it is made of. Where the
threads are rigid, the two equations

    I θ″ = −k z − c θ′ − r_m N (s μ cos λ − sin λ),    m x″ = R − c_x x′ − N (cos λ + s μ sin λ),    x = r_m tan λ θ,

of which (8.1), (8.3), (8.13), (8.16), (8.17) and (8.22) are consequences, are solved for θ″ and N as they stand; with
compliant threads N = cos λ (k_c e + c_c e′). The law s is read from the signs of the stored θ′ and N.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.attributes import named
from lsvib.chapter import printed_laws
from lsvib.chapter.checks import Check, each, every
from lsvib.drives.drive import Drive

TOLERANCE = 1e-10  # of the largest magnitude on the motion; rounding leaves 3e-14 with rigid threads, 3e-12 with others
_THREADS = ("thread_mismatch", "mismatch_rate")
_MOTION = ("time", "u", "w", "normal_force", "coupling_deflection", *_THREADS)


def residual(motion: xr.Dataset) -> float:
    """Return the worst residual [1] of Newton's laws along one motion, relative to the largest magnitude on it.

    ``motion``: variables along one dimension – ``time``, ``u``, ``w``, ``normal_force``,
    with compliant threads also ``thread_mismatch`` and ``mismatch_rate`` – and the parameters of the drive as scalars.
    Each event has two samples. Compared are: the normal force in each sample, and ``coupling_deflection`` if it is
    there; each state with what the linear equations make, in exponentials of their matrix, of the sample before it; the
    states on both sides of an event, which differ at most by a speed that drops to zero; and the friction of a screw at
    rest, which stays within μ |N| and reaches it where the rest ends.
    """
    p, time, force = parameters(motion), motion.time.values, motion.normal_force.values
    if np.isnan(time).any():  # of a cycle that is not there
        return np.nan
    deflection = motion.u.values + float(printed_laws.steady_deflection(motion))
    speed, more = motion.w.values + p["input_speed"], [n for n in _THREADS if n in motion]
    states = np.stack([deflection, speed, *(motion[n].values for n in more), 1 + 0 * time], 1)
    sizes = np.abs(states).max(axis=0)
    sizes[sizes == 0] = 1.0
    steps = np.diff(time) > 0
    rests = steps & (speed[:-1] == 0) & (speed[1:] == 0)
    laws = np.where(rests, 0, np.sign(speed[:-1] + speed[1:]) * np.sign(force[:-1] + force[1:]))
    jumps = np.abs(np.diff(states, axis=0)[~steps])
    jumps[:, 1] = np.minimum(jumps[:, 1], np.abs(states[1:, 1][~steps]))  # across an event a speed may drop to zero
    worst = [jumps / sizes]
    if "coupling_deflection" in motion:
        worst.append(np.abs(motion.coupling_deflection.values - deflection) / sizes[0])
    for law in (1, 0, -1):
        here = np.flatnonzero(steps & (laws == law))
        field, normal, friction = equations(p, law, bool(more))
        moved = _exponentials(field * sizes / sizes[:, None], np.diff(time)[here]) @ (states[here] / sizes)[..., None]
        worst.append(np.abs(moved[..., 0] - states[here + 1] / sizes))
        ends = np.union1d(here, here + 1)
        worst.append(np.abs(states[ends] @ normal - force[ends]) / np.abs(force).max())
        if law == 0 and here.size:
            needed, limit = np.abs(states @ friction), p["friction_coefficient"] * np.abs(force)
            last = np.setdiff1d(here + 1, [*here, time.size - 1])  # where a rest ends
            excess = np.append((needed - limit)[ends], np.abs(needed - limit)[last])
            worst.append(np.maximum(excess, 0) / np.abs(force).max())
    return float(np.max([values.max(initial=0.0) for values in worst]))  # NaN if a sample is


def laws_check(motions: xr.Dataset, source: str, what: str = "motion") -> Check:
    """Check Newton's laws along every motion of a dataset, along its dimension ``sample``; ``what``: its name."""
    worst = _residuals(motions)
    words = {"what": what, "limit": TOLERANCE, "place": source, "motions": worst.size}
    return Check.that("newton.laws", worst=each(worst, "<=", TOLERANCE), **words)


def _residuals(motions: xr.Dataset) -> np.ndarray:
    needed = motions[[name for name in (*_MOTION, *Drive.model_fields) if name in motions]]
    many = {dim: size for dim, size in needed.sizes.items() if dim != "sample"}
    places = [dict(zip(many, index, strict=True)) for index in np.ndindex(*many.values())]
    return np.array([residual(needed.isel(place)) for place in places])


def portrait_checks(planes: xr.Dataset, source: str) -> list[Check]:
    """Check phase planes: motions, their events, the lines N = 0 and θ′ = 0 with Γ₊, and limit cycles if there are."""
    speed = xr.DataArray([0.0, 1.0], dims="end") * planes.input_speed
    angle = planes.contact_line_angle + planes.contact_line_slope * (speed - planes.input_speed)
    parts = printed_laws.drift(planes, angle + printed_laws.steady_deflection(planes), speed)
    gap = (planes.effective_inertia_plus - printed_laws.inertia(planes, 1)) / planes.screw_inertia
    lines = Check.that("newton.lines", place=source, line=each(abs(sum(parts)) / sum(map(abs, parts)), "<", 1e-12),
                       standstills=every(planes.stop_velocity == -planes.input_speed),
                       inertia=each(abs(gap), "<", 1e-12))  # fmt: skip
    checks = [laws_check(planes, source), lines, _events_check(planes, source)]
    if "cycle_time" in planes:
        vibrates = np.isfinite(planes.cycle_time[:, 0].values)
        checks.append(cycle_check(planes.isel(case=vibrates), source, amplitude=planes.amplitude, period=planes.period))
    return checks


def _events_check(planes: xr.Dataset, source: str) -> Check:
    """Check that an event is two samples of its motion, and its impulses by the momenta of screw and nut."""
    times, clauses = planes.event_time, {}
    for when in ("before", "after"):
        same = times == planes.time
        for name in ("u", "w"):
            same &= planes[f"event_{name}_{when}"] == planes[name]
        clauses[f"states_{when}"] = every(times.isnull() | same.any("sample"))
    fall = planes.event_w_before - planes.event_w_after
    fall = fall.where(named(planes.event_kind, "seizure"), 0.0)
    torque, axial = planes.screw_inertia * fall, planes.mass * planes.pitch_radius * np.tan(planes.lead_angle) * fall
    normal = axial * np.cos(planes.lead_angle) - torque / planes.pitch_radius * np.sin(planes.lead_angle)
    for name, impulse in (("torque", torque), ("axial", axial), ("normal", normal)):
        right = abs(planes[f"event_{name}_impulse"] - impulse) <= 1e-12 * abs(impulse)
        clauses[f"{name}_impulses"] = every(times.isnull() | right)
    return Check.that("newton.events", place=source, **clauses)


def cycle_check(dataset: xr.Dataset, source: str, prefix: str = "cycle", **stated: Any) -> Check:
    """Check Newton's laws along cycles, that they close, and their ``amplitude`` and ``period`` as far as stated."""
    cycles = cycle_motion(dataset, prefix)
    low, high = cycles.min("sample"), cycles.max("sample")
    clauses = {"residual": each(_residuals(cycles), "<=", TOLERANCE)}
    for name in ("u", "w", *(name for name in _THREADS if name in cycles)):
        gap = cycles[name].isel(sample=-1) - cycles[name].isel(sample=0)
        clauses[f"gap_of_{name}"] = each(abs(gap / (high - low)[name]), "<", 1e-9)
    # The largest deviation may lie between two samples.
    seen = {"amplitude": ((high - low).u / 2, 1e-3), "period": (high.time - low.time, 1e-12)}
    for name, known in stated.items():
        known, expected = (x.fillna(0) for x in xr.broadcast(known, seen[name][0]))  # without a cycle both are zero
        clauses[f"{name}s"] = every(abs(known - expected) <= seen[name][1] * expected)
    return Check.that("newton.cycle", place=source, what=f"{prefix.replace('_', ' ')}s", limit=TOLERANCE, **clauses)


def cycle_motion(dataset: xr.Dataset, prefix: str = "cycle") -> xr.Dataset:
    """Return cycles that a dataset has as curves under the names of motions, with the parameters of their drives."""
    names = [str(name) for name in dataset.variables if str(name).startswith(f"{prefix}_")]
    cycles = dataset[[*names, *(name for name in Drive.model_fields if name in dataset)]]
    return cycles.rename({name: name.removeprefix(f"{prefix}_") for name in (*names, f"{prefix}_sample")})


def touching_check(drive: xr.Dataset, law: int, force: Any, words: str) -> Check:
    """Check that a threshold of the axial force [N] is :func:`touching_force` of a drive; ``words``: its name."""
    return Check.of("newton.touching", float(force), expected=touching_force(parameters(drive), law), force=words)


def parameters(dataset: xr.Dataset) -> dict[str, float]:
    """Return the parameters of the drive of a dataset but those that it varies."""
    return {name: float(dataset[name]) for name in Drive.model_fields if name in dataset and not dataset[name].ndim}


def touching_force(p: Mapping[str, float], law: int) -> Any:
    """Return the axial force [N] at which the slip that follows rest, under the law of steady sliding, touches N = 0.

    Ω > 0. The slip, less steady sliding, does not depend on the force; so one motion, in 4000 samples a turn, gives it.
    """
    field, normal, _ = equations(p, law, False)
    (stiffness, damping, _), speed = field[1], p["input_speed"]
    first = np.array([damping * speed / stiffness, -speed, 0.0])  # θ″ = 0 at standstill, less θ″ = 0 at Ω
    spans = np.linspace(0, 2 * np.pi / np.sqrt(-stiffness), 4001)
    slip = _exponentials(np.where(np.eye(3)[2], 0.0, field), spans) @ first
    stopped = np.flatnonzero(slip[1:, 1] < -speed)
    force = (slip @ normal)[: stopped[0] + 1 if stopped.size else None]
    r, (sin, cos) = p["pitch_radius"], (f(p["lead_angle"]) for f in (np.sin, np.cos))
    carried = -(law * force).min() * law * (cos + law * p["friction_coefficient"] * sin)
    return carried + r * sin / cos * p["translation_damping"] * speed


def touching_area(p: Mapping[str, float]) -> float:
    """Return the area [rad²/s] between N = 0 and the slip under law − that touches it, backwards from N = N′ = 0."""
    field, normal, _ = equations(p, -1, False)
    touch = np.linalg.solve([normal, normal @ field, np.eye(3)[2]], [0.0, 0.0, 1.0])
    slip = _exponentials(-field, np.linspace(0, 2 * np.pi / np.sqrt(-field[1, 0]), 4001)) @ touch
    back = 2 + np.flatnonzero((slip @ normal)[2:] > 0)[0]
    z, speed, _ = slip[: back + 1].T
    return float(abs(np.sum(z * np.roll(speed, 1) - speed * np.roll(z, 1)))) / 2


def equations(p: Mapping[str, float], law: int, compliant: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the field over (z, θ′, [e, e′,] 1) under a law, 0 at rest; N; and the friction that keeps it at rest."""
    r, sin, cos, tan = p["pitch_radius"], *(f(p["lead_angle"]) for f in (np.sin, np.cos, np.tan))
    unit, friction = np.eye(5 if compliant else 3), law * p["friction_coefficient"]
    torque = -p["coupling_stiffness"] * unit[0] - p["support_damping"] * unit[1]
    nut_speed = r * tan * unit[1] + (unit[3] if compliant else 0)
    push = p["axial_force"] * unit[-1] - p["translation_damping"] * nut_speed
    levers = r * (friction * cos - sin), cos + friction * sin  # of N in both equations
    if compliant:
        normal = cos * (p["contact_stiffness"] * unit[2] + p["contact_damping"] * unit[3])
        turning = (torque - levers[0] * normal) / p["screw_inertia"]
    elif law == 0:
        normal, turning = cos * push - sin * torque / r, 0 * torque
    else:
        matrix = [[p["screw_inertia"], levers[0]], [p["mass"] * r * tan, levers[1]]]
        turning, normal = np.linalg.solve(matrix, [torque, push])
    static = (torque / r + normal * sin) / cos
    turning = turning if law else 0 * torque
    rows = [unit[1] - p["input_speed"] * unit[-1], turning]
    if compliant:
        contact = levers[1] * normal if law else normal * cos + static * sin
        rows += [unit[3], (push - contact) / p["mass"] - r * tan * turning]
    return np.array([*rows, 0 * torque]), normal, static


def _exponentials(field: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """exp(field · span) for each span: Taylor series of a matrix of norm below 1/2, squared as often as need be."""
    halvings = max(0, int(np.ceil(np.log2(2 * max(np.abs(field).sum(axis=1).max() * spans.max(initial=0.0), 0.5)))))
    small = field * spans[:, None, None] / 2.0**halvings
    term = total = np.broadcast_to(np.eye(len(field)), small.shape)
    for k in range(1, 16):
        term = term @ small / k
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total
