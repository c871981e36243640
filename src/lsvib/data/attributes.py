"""Attributes of the variables that datasets share: names, units, symbols, flags."""

from collections.abc import Iterable, Sequence
from enum import IntEnum
from typing import Any

import numpy as np

from lsvib.drives.model_files import model_names
from lsvib.drives.registry import find_model

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


def flags(kinds: Iterable[IntEnum]) -> dict[str, Any]:
    """Return the CF attributes ``flag_values`` and ``flag_meanings`` for an ``IntEnum``."""
    return {
        "flag_values": np.array([int(kind) for kind in kinds], dtype=np.int8),
        "flag_meanings": " ".join(kind.name.lower() for kind in kinds),
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


def yes_no(long_name: str) -> dict[str, Any]:
    """Return the attributes of an int8 variable that is 1 where a statement is true, else 0."""
    return attributes("1", long_name, flag_values=np.array([0, 1], dtype=np.int8), flag_meanings="no yes")


def flag(long_name: str, kinds: Iterable[IntEnum]) -> dict[str, Any]:
    """Return the attributes of an int8 variable that holds members of ``kinds``."""
    return attributes("1", long_name, **flags(kinds))


def named_index(dim: str, long_name: str, words: Sequence[str], **more: Any) -> tuple[str, np.ndarray, dict[str, Any]]:
    """Return the coordinate along ``dim`` of things that have names: their index, whose flags are the names."""
    index = np.arange(len(words), dtype=np.int8)
    return dim, index, attributes("1", long_name, flag_values=index, flag_meanings=" ".join(words), **more)


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
