"""Values between two ends, as the settings of a figure give them: ``start``, ``stop`` and ``count``."""

from collections.abc import Mapping
from typing import Any

import numpy as np


def evenly_chosen(count: int, most: int) -> np.ndarray:
    """Return the indices of at most ``most`` of ``count`` values, evenly spaced, both ends included."""
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def even(settings: Mapping[str, Any]) -> np.ndarray:
    """Return evenly spaced values from ``start`` to ``stop``, both included, ``count`` of them."""
    return np.linspace(settings["start"], settings["stop"], settings["count"])


def logarithmic(settings: Mapping[str, Any]) -> np.ndarray:
    """Return values in equal ratios from ``start`` to ``stop``, both included, ``count`` of them."""
    return np.geomspace(settings["start"], settings["stop"], settings["count"])
