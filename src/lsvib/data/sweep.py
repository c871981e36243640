"""What the rigid drive ends on over values of its parameters: attractor, amplitude, period, forces of every point.

A point depends on nothing but its own drive and start, so that no number depends on the other points, their order, or
the number of processes. Nothing is simulated for some time and looked at: the return map decides, as for one drive.
"""

import json
import math
from collections.abc import Callable, Mapping
from functools import partial
from itertools import product
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from lsvib import numbers
from lsvib.cycles.attractors import Attractor, SteadyState, orbit_extremes, steady_state
from lsvib.cycles.impulses import seizure_impulses, seizure_speeds
from lsvib.data.attributes import attributes, flags
from lsvib.drives.coefficients import coefficients
from lsvib.drives.parameters import RigidParameters, described, names_and_values
from lsvib.drives.rigid import Resume, rigid_automaton
from lsvib.errors import EngineError, InputError

Progress = Callable[[int, int], None]
START = {"u": 1e-3, "w": 0.0}  # next to steady sliding: rad, and rad/s
_CHUNK = 50  # points that a process takes at a time, some 0.1 s; a thousand or so make starting it worth while
_MOST = 10_000_000  # points, of which each has some hundred bytes
_WITHOUT_EXTREMES = (Attractor.UNRESOLVED, Attractor.UNBOUNDED)


class Point(NamedTuple):
    """What a motion ends on; nan where it has no such number.

    ``amplitude`` [rad], half the peak-to-peak of u; ``period`` [s]; ``multiplier`` [1] of the return map, the largest;
    ``peak_normal_force`` [N], largest |N| without the impulses of seizures; ``peak_normal_impulse`` [N s], largest
    |J_N| of a seizure, 0 without one.
    """

    attractor: int
    amplitude: float
    period: float
    multiplier: float
    peak_normal_force: float
    peak_normal_impulse: float


_VARIABLES = {
    "attractor": attributes("1", "attractor that the motion reaches", **flags(Attractor)),
    "amplitude": attributes("rad", "amplitude of the steady vibration, half its peak-to-peak"),
    "period": attributes("s", "period of the steady vibration", "$T$"),
    "multiplier": attributes("1", "largest multiplier of the return map"),
    "peak_normal_force": attributes("N", "largest magnitude of the normal force, without the impulses of seizures"),
    "peak_normal_impulse": attributes("N s", "largest magnitude of the normal impulse of a seizure"),
}


def sweep(
    drive: RigidParameters,
    over: Mapping[str, Any],
    initial: Mapping[str, Any] | None = None,
    resume: Resume = "contact_sign",
    workers: Any = 1,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the attractor and its numbers over the product of values of some parameters of the rigid drive.

    Arguments: ``over``, values [SI units] by name of a parameter; ``initial``, u [rad] and w [rad/s], by default next
    to steady sliding; rule of resuming; number of processes; ``progress``, called with the numbers of points done and
    in all. The dataset has a dimension for each parameter, in the order given, and the variables of :class:`Point`.
    Raises ``InputError`` for values, starts or drives that are not acceptable.
    """
    axes = {name: parameter_values(name, values) for name, values in names_and_values("over", over).items()}
    if not axes:
        raise InputError("over names no parameter; give the values of one, such as axial_force.")
    total = math.prod(map(len, axes.values()))
    if not 1 <= total <= _MOST:
        raise InputError(f"over has {total} points; the allowed range is 1 <= points <= {_MOST}.")
    start = START if initial is None else names_and_values("initial", initial)
    if set(start) != {"u", "w"}:
        raise InputError(f"initial has the keys {', '.join(start) or 'none'}; it needs u and w.")
    state = tuple(numbers.start(f"initial {key}", start[key]) for key in ("u", "w"))
    drives = [drive.replace(**dict(zip(axes, values, strict=True))) for values in product(*axes.values())]
    found = _all(drives, partial(point, state=state, resume=resume), _processes(workers), progress)
    sizes = tuple(map(len, axes.values()))
    columns = {
        name: np.array([getattr(row, name) for row in found], dtype=np.int8 if name == "attractor" else float)
        for name in _VARIABLES
    }
    return xr.Dataset(
        {name: (tuple(axes), columns[name].reshape(sizes), attrs) for name, attrs in _VARIABLES.items()},
        coords={name: (name, np.array(values), coordinate(name)) for name, values in axes.items()},
        attrs={
            "title": f"What the rigid lead-screw drive ends on over {', '.join(axes)}",
            "source": "lsvib, exact event-driven motion and its return map",
            "references": "doi:10.1007/978-1-4419-1752-2_8, eqs 8.13-8.17",
            "model": drive.model,
            "parameters": json.dumps({key: value for key, value in drive if key not in axes}),
            "resume": resume,
            "initial_state": json.dumps(dict(zip(("u", "w"), state, strict=True))),
        },
    )


def point(drive: RigidParameters, state: tuple[float, ...], resume: Resume) -> Point:
    """Return what the motion of a rigid drive from a state (u [rad], w [rad/s]) ends on."""
    automaton = rigid_automaton(drive, resume=resume)
    found = steady_state(automaton, state)
    if found.label in _WITHOUT_EXTREMES:
        return Point(int(found.label), *(math.nan,) * 5)
    if found.orbit is None:  # steady sliding: a drive that turns does not rest for ever
        return Point(int(found.label), 0.0, math.nan, math.nan, _steady_force(drive), 0.0)
    try:
        amplitude = found.amplitude
        force = max(map(abs, orbit_extremes(found.orbit, automaton.observables["normal_force"])))
    except EngineError:  # the rates of a mode lie too far apart to find the extremes
        amplitude = force = math.nan
    return Point(int(found.label), amplitude, found.period, found.multiplier, force, _impulse(drive, found))


def _steady_force(drive: RigidParameters) -> float:
    """|N_0| of steady sliding (eq. 8.15): N_0 (cos λ + s_0 μ sin λ) = R − r_m tan λ c_x Ω."""
    c, d = coefficients(drive), drive.exact()
    return float(abs(c.net_force / (d.cos_lead + c.steady_law * d.friction_coefficient * d.sin_lead)))


def _impulse(drive: RigidParameters, found: SteadyState) -> float:
    """Largest |J_N| of the seizures of a cycle."""
    assert found.orbit is not None
    return float(np.max(np.abs(seizure_impulses(drive, seizure_speeds(drive, found.orbit)).normal), initial=0.0))


def evenly(name: str, text: str) -> np.ndarray:
    """Read START:STOP:COUNT as so many values with equal steps, both ends included; ``InputError`` for other text."""
    parts = text.split(":")
    if len(parts) != 3:
        raise InputError(f"over: {name}={text} is not of the form KEY=START:STOP:COUNT.")
    try:
        start, stop, count = numbers.number(parts[0]), numbers.number(parts[1]), numbers.whole(parts[2])
    except numbers.NotNumber as error:
        raise InputError(f"over: {name}={text} has a part that {error}.") from None
    if not 1 <= count <= _MOST:
        raise InputError(f"over: {name} has count = {count}; the allowed range is 1 <= count <= {_MOST}.")
    if not (math.isfinite(start) and math.isfinite(stop)):
        raise InputError(f"over: {name}={text} has an end beyond 1.8e308, the range of doubles.")
    return np.linspace(start, stop, count)


def summary(found: xr.Dataset, seconds: float) -> dict[str, Any]:
    """Summarise a sweep for JSON: number of ``points``, of each of the ``attractors``, ``points_per_second``."""
    labels = found.attractor.values.ravel().tolist()
    kinds = {kind.name.lower(): labels.count(int(kind)) for kind in Attractor}
    return {
        "points": len(labels),
        "attractors": {name: count for name, count in kinds.items() if count},
        "points_per_second": len(labels) / seconds,
    }


def _all(
    drives: list[RigidParameters], work: Callable[[RigidParameters], Point], workers: int, progress: Progress | None
) -> list[Point]:
    """The points of drives, in their order, by processes that each compute some at a time."""
    if workers == 1 or len(drives) <= _CHUNK:
        return _told(map(work, drives), len(drives), progress)
    with get_context("spawn").Pool(min(workers, -(-len(drives) // _CHUNK))) as pool:
        return _told(pool.imap(work, drives, _CHUNK), len(drives), progress)


def _told(points: Any, total: int, progress: Progress | None) -> list[Point]:
    found = []
    for k, one in enumerate(points, 1):
        found.append(one)
        if progress is not None:
            progress(k, total)
    return found


def parameter_values(name: str, given: Any) -> list[float]:
    """Return the values of a parameter as numbers; whether they are in its range is for the drive to say.

    Raises ``InputError`` for an unknown name, and for what is no list of numbers.
    """
    if name not in RigidParameters.model_fields:
        raise InputError(f"{name} is not a known key; the known keys are {', '.join(RigidParameters.model_fields)}.")
    if isinstance(given, str | bytes | Mapping) or not hasattr(given, "__len__") or not hasattr(given, "__iter__"):
        raise InputError(f"over: {name} = {numbers.shown(given)} is not a list of numbers.")
    try:
        return [numbers.number(value) for value in given]
    except numbers.NotNumber as error:
        raise InputError(f"over: {name} holds a value that {error}.") from None


def _processes(given: Any) -> int:
    most = 4096  # more than any machine has cores
    try:
        count = numbers.whole(given)
    except numbers.NotNumber as error:
        raise InputError(
            f"workers = {numbers.shown(given)} {error}; the allowed range is 1 <= workers <= {most}."
        ) from None
    if not 1 <= count <= most:
        raise InputError(f"workers = {count} is outside the allowed range 1 <= workers <= {most}.")
    return count


def coordinate(name: str) -> dict[str, Any]:
    about = described(RigidParameters, name)
    return attributes(about["unit"], about["long_name"])
