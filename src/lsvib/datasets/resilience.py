"""The perturbations that steady sliding of the rigid drive tolerates, as a dataset over values of its parameters."""

import json
import math
from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np
import xarray as xr

from lsvib import numbers
from lsvib.basins.curves import Window
from lsvib.basins.resilience import Resilience, resilience
from lsvib.datasets.attributes import variable
from lsvib.datasets.sweep import axes_of, coordinate
from lsvib.errors import EngineError, InputError
from lsvib.models.drive import RigidDrive, names_and_values
from lsvib.numbers import Progress

_MOST_POINTS = 1_000_000  # of a sweep: at some 10 ms each three hours
_FARTHEST = 1e150  # of an edge of a window: its area is still a number

_VARIABLES = {  # where a resilience has it, unit, words
    "fatal_angle": ("angle", "rad", "largest tolerated perturbation of the deflection alone"),
    "fatal_speed": ("speed", "rad s-1", "largest tolerated perturbation of the speed alone"),
    "fatal_energy": ("energy", "J", "energy up to which every perturbation is tolerated"),
    "basin_fraction": ("fraction", "1", "share of the window that settles, exact"),
}


def resilience_sweep(
    drive: RigidDrive,
    over: Mapping[str, Any],
    window: Window | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the perturbations that steady sliding of the rigid drive tolerates over all combinations of some values.

    Arguments: ``over``, values [SI units] by name of a parameter; ``window`` as of
    :func:`lsvib.basins.resilience.resilience`; ``progress``, called with the numbers of points done and in all. Numbers
    are infinite where every perturbation is tolerated, zero where none is, nan where the basin is not covered, for the
    reasons in the attribute ``refused``. Raises ``InputError`` for values that are not acceptable.
    """
    axes = axes_of(over, RigidDrive, _MOST_POINTS)
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

    asked = {name: about for name, about in _VARIABLES.items() if name != "basin_fraction" or window is not None}
    return xr.Dataset(
        {name: variable(tuple(axes), column(where), *words) for name, (where, *words) in asked.items()},
        coords={name: (name, np.array(values), coordinate(name)) for name, values in axes.items()},
        attrs={
            "title": f"Perturbations that the rigid lead-screw drive tolerates over {', '.join(axes)}",
            "source": "lsvib, exact boundary of the region of attraction",
            "references": "doi:10.1007/978-1-4419-1752-2_8, Sect. 8.7",
            "model": drive.model,
            "parameters": json.dumps({key: value for key, value in drive if key not in axes}),
            "window": json.dumps(None if window is None else window._asdict()),
            "refused": json.dumps(sorted(set(refused))),
        },
    )


def window_of(given: Any) -> Window | None:
    """Return a window from one, None, or edges ``{"u": (low, high), "w": (low, high)}``, else raise ``InputError``."""
    if given is None:
        return None
    if isinstance(given, Window):
        given = {"u": (given.left, given.right), "w": (given.bottom, given.top)}
    edges = names_and_values("window", given)
    if set(edges) != {"u", "w"}:
        raise InputError(f"window has the keys {', '.join(edges) or 'none'}; it needs u and w.")
    ends: list[float] = []
    for name in ("u", "w"):
        pair = edges[name]
        if not isinstance(pair, tuple | list) or len(pair) != 2:
            raise InputError(f"window {name} = {numbers.shown(pair)} is not a low and a high end.")
        try:
            low, high = (numbers.number(value) for value in pair)
        except numbers.NotNumber as error:
            raise InputError(f"window {name} = {numbers.shown(pair)} has an end that {error}.") from None
        if not -_FARTHEST <= low < high <= _FARTHEST:
            raise InputError(
                f"window {name} = {low:g} to {high:g} is outside the allowed range "
                f"-{_FARTHEST:g} <= low < high <= {_FARTHEST:g}."
            )
        ends += [low, high]
    return Window(*ends)
