"""Values between two ends, as the settings of a figure give them: ``start``, ``stop`` and ``count``."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lsvib.drives.drive import LOGARITHMIC
from lsvib.errors import InputError


def evenly_chosen(count: int, most: int) -> np.ndarray:
    """Return the indices of at most ``most`` of ``count`` values, evenly spaced, both ends included."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def even(settings: Mapping[str, Any]) -> np.ndarray:
    """Return evenly spaced values from ``start`` to ``stop``, both included, ``count`` of them."""
    return np.linspace(settings["start"], settings["stop"], settings["count"])


def stepped(start: float, stop: float, count: int) -> np.ndarray:
    """Return values with equal steps, both ends included; one between them that is zero but for rounding is zero."""
    values = np.linspace(start, stop, count)
    # 10⁷ steps round at 10⁻¹⁶ of their whole length, and a value that is meant is farther off.
    rounded = np.abs(values[1:-1]) < 1e-9 * abs(stop - start) / max(count - 1, 1)
    values[1:-1][rounded] = 0.0
    return values


def spaced(name: str, start: float, stop: float, count: int) -> np.ndarray:
    """Return values of a parameter, both ends included, with equal steps; of one that spans decades in equal ratios.

    Raises ``InputError``.
    """
    if name not in LOGARITHMIC:
        return stepped(start, stop, count)
    if not (start > 0 and stop > 0):
        raise InputError(f"{name} goes from {start:g} to {stop:g}; its values have equal ratios, so both must be > 0.")
    return np.geomspace(start, stop, count)


def logarithmic(settings: Mapping[str, Any]) -> np.ndarray:
    """Return values in equal ratios from ``start`` to ``stop``, both included, ``count`` of them."""
    return np.geomspace(settings["start"], settings["stop"], settings["count"])
