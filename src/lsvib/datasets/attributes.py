"""Attributes of the variables that datasets share: names, units, symbols, flags."""

from collections.abc import Iterable, Mapping, Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from lsvib.models.model import find_model, model_names

_LONG_NAMES = {
    "angle_deviation": ("deviation of the coupling deflection from steady sliding", "rad", "$u$"),
    "velocity_deviation": ("rate of the deviation from steady sliding", "rad s-1", r"$\dot u$"),
    "normal_force": ("normal force of the threads", "N", "$N$"),
    "axial_contact_force": ("axial force that the threads carry", "N", "$n$"),
    "coupling_torque": ("torque of the coupling", "N m", "$T_r$"),
    "coupling_deflection": ("coupling deflection", "rad", "$z$"),
    "screw_speed": ("angular speed of the screw", "rad s-1", r"$\dot\theta$"),
    "nut_speed": ("speed of the nut along the axis", "m s-1", r"$\dot x$"),
}


Dims = str | tuple[str, ...]
Variable = tuple[Dims, Any, dict[str, Any]]  # as xarray.Dataset takes one


def flags(kinds: Iterable[IntEnum]) -> dict[str, Any]:
    """Return the CF attributes ``flag_values`` and ``flag_meanings`` for an ``IntEnum``."""
    return {
        "flag_values": np.array([int(kind) for kind in kinds], dtype=np.int8),
        "flag_meanings": " ".join(kind.name.lower() for kind in kinds),
    }


def flags_or_none(kinds: Iterable[IntEnum]) -> dict[str, Any]:
    """Return :func:`flags` with one more, −1 for none of the kinds."""
    known = flags(kinds)
    return {
        "flag_values": np.append(known["flag_values"], np.int8(-1)),
        "flag_meanings": f"{known['flag_meanings']} none",
    }


def quantity(name: str, when: str = "") -> dict[str, str]:
    """Return ``long_name``, ``units`` and ``symbol`` of a quantity of a drive, before or after an event if so said."""
    long_name, units, symbol = _LONG_NAMES[name] if name in _LONG_NAMES else _of_one_model(name)
    return {"long_name": f"{long_name}, {when} the event" if when else long_name, "units": units, "symbol": symbol}


def _of_one_model(name: str) -> tuple[str, str, str]:
    """Long name, unit and symbol of a quantity that only one model has."""
    models = map(find_model, model_names())  # imported one by one, up to the one that has it
    return next(model.quantities[name] for model in models if name in model.quantities)


def attributes(units: str, long_name: str, symbol: str = "", **more: Any) -> dict[str, Any]:
    """Return the attributes of a variable; an empty symbol is left out."""
    return {"units": units, "long_name": long_name, **({"symbol": symbol} if symbol else {}), **more}


def variable(dims: Dims, values: Any, units: str, long_name: str, symbol: str = "", **more: Any) -> Variable:
    """Return a variable: its dimensions, values of any shape that these have, and :func:`attributes`."""
    return dims, values, attributes(units, long_name, symbol, **more)


def flagged(dims: Dims, values: Any, long_name: str, kinds: Iterable[IntEnum], **more: Any) -> Variable:
    """Return a variable that holds members of ``kinds``, as int8 with flags."""
    return dims, np.asarray(values, dtype=np.int8), attributes("1", long_name, **flags(kinds), **more)


def fractions(dim: str, long_name: str, counts: Mapping[Any, int]) -> dict[str, Variable]:
    """Return the fraction of the cells of each kind, from their numbers, along the coordinate ``dim`` of the kinds."""
    share = np.array(list(counts.values())) / sum(counts.values())
    return {
        dim: flagged(dim, list(counts), long_name, counts),
        "fraction": variable(dim, share, "1", "fraction of the cells"),
    }


def yes_no(dims: Dims, values: Any, long_name: str) -> Variable:
    """Return a variable that is 1 where a statement is true, else 0, as int8 with flags."""
    return named_flags(dims, values, long_name, {0: "no", 1: "yes"})


def yes_no_or(other: str, dims: Dims, values: Sequence[bool | None], long_name: str) -> Variable:
    """Return a variable as :func:`yes_no`, −1 and named ``other`` where a value is None."""
    return named_flags(dims, [-1 if x is None else x for x in values], long_name, {-1: other, 0: "no", 1: "yes"})


def named_flags(dims: Dims, values: Any, long_name: str, words: Mapping[int, str], **more: Any) -> Variable:
    """Return a variable of numbers that ``words`` name, as int8 with flags."""
    flag_values = np.array(list(words), dtype=np.int8)
    about = attributes("1", long_name, flag_values=flag_values, flag_meanings=" ".join(words.values()), **more)
    return dims, np.asarray(values, dtype=np.int8), about


def named_index(dim: str, long_name: str, words: Sequence[str], **more: Any) -> Variable:
    """Return the coordinate along ``dim`` of things that have names: their index, whose flags are the names."""
    return named_flags(dim, range(len(words)), long_name, dict(enumerate(words)), **more)


CRITICAL_MASS = attributes("kg", "critical mass of the rigid drive (8.20)", r"$m_\mathrm{cr}$")
# Of events: the impulses of seizures, zero in other events, and a sign.
IMPULSES = {
    "normal_impulse": attributes("N s", "normal impulse of the threads of the event"),
    "axial_impulse": attributes("N s", "impulse of the threads along the axis of the event"),
    "torque_impulse": attributes("N m s", "impulse of the threads about the axis of the event"),
}
WITHOUT_IMPULSES = "without the impulses of seizures, which are in event_normal_impulse"
SIGNS = attributes(
    "1",
    "sign of the impulse of a seizure, or of the normal force after a contact reversal",
    flag_values=np.array([-1, 0, 1], dtype=np.int8),
    flag_meanings="negative none positive",
)
