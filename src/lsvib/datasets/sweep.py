"""Over values of a drive's parameters: what motions end on, with its numbers, and the perturbations it tolerates.

A point depends on nothing but its own drive and start, so that no number depends on the other points, their order, or
the number of threads. Nothing is simulated for some time and looked at: the return map decides, as for one drive.
"""

import json
import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from lsvib import numbers
from lsvib.basins.curves import Part, Window
from lsvib.basins.resilience import Resilience, resilience
from lsvib.datasets.attributes import Variables, about_drive, attributes, flags, variable
from lsvib.dynamics.attractor import Attractor
from lsvib.dynamics.sweep import all_endings
from lsvib.errors import EngineError, InputError
from lsvib.models.drive import Drive, described, names_and_values
from lsvib.models.many import ManyDrives
from lsvib.models.model import model_of
from lsvib.models.scene import REST

START = {"u": 1e-3, "w": 0.0}  # next to steady sliding: rad, and rad/s
_MOST = 10_000_000  # points, of which each has some hundred bytes

_VARIABLES = {
    "attractor": attributes("1", "attractor that the motion reaches", **flags(Attractor)),
    "amplitude": attributes("rad", "amplitude of the steady vibration, half its peak-to-peak"),
    "period": attributes("s", "period of the steady vibration", "$T$"),
    "multiplier": attributes("1", "largest multiplier of the return map"),
    "peak_normal_force": attributes("N", "largest magnitude of the normal force, without the impulses of seizures"),
    "peak_normal_impulse": attributes("N s", "largest magnitude of the normal impulse of a seizure"),
}
_PERTURBATIONS = {  # where a resilience has it, unit, words
    "fatal_angle": ("angle", "rad", "largest tolerated perturbation of the deflection alone"),
    "fatal_speed": ("speed", "rad s-1", "largest tolerated perturbation of the speed alone"),
    "fatal_energy": ("energy", "J", "energy up to which every perturbation is tolerated"),
    "basin_fraction": ("fraction", "1", "share of the window that settles, exact"),
}


def sweep(
    drive: Drive,
    over: Mapping[str, Any],
    start: Mapping[str, Any] | str | None = None,
    workers: Any = 1,
    progress: numbers.Progress | None = None,
) -> xr.Dataset:
    """Return the attractor and its numbers over the product of values of some parameters of a drive of any model.

    Arguments: ``over``, values [SI units] by name of a parameter; ``start``, u [rad], w [rad/s] and what else the
    model has, by default next to steady sliding, or "rest"; number of ``workers`` – threads, with more than two states
    processes –, which changes no number; ``progress``, called with the numbers of points done and in all. The
    dataset has a dimension for each parameter, in the order given, and as variables the numbers of
    :class:`lsvib.dynamics.sweep.Ending`. Raises ``InputError`` for what is not acceptable.
    """
    at_once, axes = numbers.workers(workers), axes_of(over, _MOST)
    drives, sizes = product_of(drive, axes), tuple(map(len, axes.values()))
    first = drives.one(0)  # with the parts that are varied
    begin: dict[str, float] | str = REST
    if start == REST:
        found = all_endings(drives, None, at_once, progress)
    else:
        given = START if start is None else names_and_values("start", start)
        begin = {key: numbers.start(f"start {key}", value) for key, value in given.items()}
        model_of(first).initial_state(first, begin)  # refuses other keys
        starts = np.broadcast_to(np.array([begin["u"], begin["w"]]), (drives.size, 2))
        others = {key: value for key, value in begin.items() if key not in ("u", "w")}
        found = all_endings(drives, starts, at_once, progress, others)
    return _over(
        axes,
        first,
        {name: (tuple(axes), getattr(found, name).reshape(sizes), about) for name, about in _VARIABLES.items()},
        title=f"What a lead-screw drive ends on over {', '.join(axes)}",
        source="lsvib, exact event-driven motion and its return map",
        references=f"doi:10.1007/978-1-4419-1752-2_8, {model_of(first).equations}",
        initial_state=json.dumps(begin),
    )


def _over(axes: Mapping[str, Sequence[float]], drive: Drive, found: Variables, **more: str) -> xr.Dataset:
    """What was found over values of some parameters of a drive, with these as coordinates; ``more`` attributes."""
    about = {name: described(name) for name in axes}
    return xr.Dataset(
        found,
        {name: variable(name, np.array(x), about[name]["unit"], about[name]["long_name"]) for name, x in axes.items()},
        about_drive(drive, ((name, value) for name, value in drive if name not in axes)) | more,
    )


def known_key(name: Any, where: str = "") -> None:
    """Raise ``InputError`` unless drives have a parameter of this name."""
    if not isinstance(name, str) or name not in Drive.model_fields:
        known = ", ".join(Drive.model_fields)
        raise InputError(f"{where}{numbers.shown(name)} is not a known key; the known keys are {known}.")


def axes_of(over: Any, most: int) -> dict[str, list[float]]:
    """Return the values of each parameter of a product of ``most`` points at most; raises ``InputError``."""
    axes: dict[str, list[float]] = {}
    lists = names_and_values("over", over)
    for name, given in lists.items():
        known_key(name)
        if isinstance(given, str | bytes | Mapping) or getattr(given, "ndim", 1) != 1 or not hasattr(given, "__len__"):
            raise InputError(f"over: {name} = {numbers.shown(given)} is not a list of numbers.")
    total = math.prod(map(len, lists.values()))
    if not 1 <= total <= most:
        raise InputError(f"over has {total} points; the allowed range is 1 <= points <= {most}.")
    for name, given in lists.items():
        try:
            axes[name] = [numbers.number(value) for value in given]
        except numbers.NotNumber as error:
            raise InputError(f"over: {name} holds a value that {error}.") from None
    if not axes:
        raise InputError("over names no parameter; give the values of one, such as axial_force.")
    return axes


def product_of(drive: Drive, axes: Mapping[str, Sequence[float]]) -> ManyDrives:
    """Return the drives over the product of values of some parameters, the last one fastest.

    Raises ``InputError`` if one of them is not acceptable: all that couples ranges, such as μ < cot λ, is monotonic in
    each parameter, so that the corners of the product decide.
    """
    ends = []
    for values in axes.values():  # ranges may leave out what is near zero
        parts = ([x for x in values if np.sign(x) == sign] for sign in (-1, 0, 1))
        ends.append(sorted({end(part) for part in parts if part for end in (min, max)} | {x for x in values if x != x}))
    for corner in product(*ends):
        drive.replace(**dict(zip(axes, corner, strict=True)))
    grids = np.meshgrid(*axes.values(), indexing="ij")
    first = drive.replace(**{name: values[0] for name, values in axes.items()})
    return ManyDrives(dict(first) | {name: grid.ravel() for name, grid in zip(axes, grids, strict=True)})


def summary(found: xr.Dataset, seconds: float) -> dict[str, Any]:
    """Summarise a sweep for JSON: number of ``points``, of each of the ``attractors``, ``points_per_second``."""
    labels = found.attractor.values.ravel().tolist()
    kinds = {kind.name.lower(): labels.count(int(kind)) for kind in Attractor}
    return {
        "points": len(labels),
        "attractors": {name: count for name, count in kinds.items() if count},
        "points_per_second": len(labels) / seconds,
    }


def resilience_sweep(
    drive: Drive, over: Mapping[str, Any], window: Part | None = None, progress: numbers.Progress | None = None
) -> xr.Dataset:
    """Return the perturbations that steady sliding of the rigid drive tolerates over all combinations of some values.

    Arguments: ``over``, values [SI units] by name of a parameter; ``window`` as of
    :func:`lsvib.basins.resilience.resilience`; ``progress``, called with the numbers of points done and in all. Numbers
    are infinite where every perturbation is tolerated, zero where none is, nan where the basin is not covered, for the
    reasons in the attribute ``refused``. Raises ``InputError`` for values that are not acceptable.
    """
    window = None if window is None else Window.of(window)
    axes = axes_of(over, _MOST // 10)  # at some 10 ms each three hours
    drives = [drive.replace(**dict(zip(axes, values, strict=True))) for values in product(*axes.values())]
    found: list[Resilience | None] = []
    refused: list[str] = []
    for one in drives:
        try:
            found.append(resilience(one, window))
        except (InputError, EngineError) as error:
            found.append(None)
            refused.append(str(error))
        if progress is not None:
            progress(len(found), len(drives))
    sizes = tuple(map(len, axes.values()))

    def column(where: str) -> np.ndarray[Any, Any]:
        return np.array([math.nan if one is None else getattr(one, where) for one in found]).reshape(sizes)

    asked = {name: about for name, about in _PERTURBATIONS.items() if name != "basin_fraction" or window is not None}
    return _over(
        axes,
        drives[0],
        {name: variable(tuple(axes), column(where), *words) for name, (where, *words) in asked.items()},
        title=f"Perturbations that the rigid lead-screw drive tolerates over {', '.join(axes)}",
        source="lsvib, exact boundary of the region of attraction",
        references="doi:10.1007/978-1-4419-1752-2_8, Sect. 8.7",
        window=json.dumps(None if window is None else window._asdict()),
        refused=json.dumps(sorted(set(refused))),
    )
