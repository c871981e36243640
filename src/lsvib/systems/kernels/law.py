"""A piece of a friction law, written once in plain arithmetic: for floats, balls and arrays, and compiled for kernels.

    μ(σ) = constant + linear σ + rise exp(−(fade σ)^exponent)      from ≤ σ ≤ to

``law[k]`` is the column k below, a number or an array of numbers of many pieces. The exponent is 1 or 2, so that the
power of r = fade σ is r (2 − exponent + (exponent − 1) r), to the last bit and without a decision. As a power series it
stands in :mod:`lsvib.systems.kernels.flow_taylor`; nothing else knows its shape. Nothing here loads numba.
"""

import math
from collections.abc import Callable
from typing import Any

FROM, TO, CONSTANT, LINEAR, RISE, FADE, EXPONENT = range(7)  # columns of a piece
PIECE = 7  # of all columns


def exponent(law: Any, ratio: Any) -> Any:
    """Return (fade σ)^exponent at a sliding speed, by the ``ratio`` r [1]."""
    more = law[EXPONENT] - 1
    return ratio * (1 - more + more * ratio)


def value(law: Any, sigma: Any, ratio: Any, decay: Any) -> tuple[Any, Any, Any]:
    """Return μ and μ′ [s/m] at a sliding speed [m/s], and the logarithmic derivative of the exponential, ``decay``."""
    more, rise = law[EXPONENT] - 1, law[RISE] * decay
    falls = -law[FADE] * (1 - more + 2 * more * ratio)
    return law[CONSTANT] + rise + law[LINEAR] * sigma, law[LINEAR] + rise * falls, falls


def at(law: Any, sigma: Any, exponential: Callable[[Any], Any]) -> tuple[Any, Any]:
    """Return μ and μ′ [s/m] at a sliding speed [m/s], by the ``exponential`` of such numbers."""
    ratio = law[FADE] * sigma
    return value(law, sigma, ratio, exponential(-exponent(law, ratio)))[:2]


def bounds(law: Any) -> tuple[Any, Any]:
    """Return bounds of |μ′| [s/m] and of |μ″| [s²/m²] on a piece."""
    return abs(law[LINEAR]) + law[RISE] * law[FADE], 2 * law[RISE] * law[FADE] ** 2


def bends(law: Any) -> list[float]:
    """Return the sliding speeds [m/s] between which μ′ of a piece of floats only grows or only falls."""
    return [math.sqrt(0.5) / law[FADE]] if law[RISE] and law[EXPONENT] == 2 else []
