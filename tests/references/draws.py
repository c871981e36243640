"""Distributions that parameters of random drives are drawn from, and drives with them; the caller has the generator."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

Draw = Callable[[np.random.Generator], float]


def uniform(low: float, high: float) -> Draw:
    return lambda rng: float(rng.uniform(low, high))


def power(low: float, high: float) -> Draw:
    """A number whose decimal logarithm lies between two ends."""
    return lambda rng: float(10 ** rng.uniform(low, high))


def about(value: float, factor: float = 2.0) -> Draw:
    """A number up to a factor away from a value."""
    return lambda rng: float(value * factor ** rng.uniform(-1, 1))


def one_of(*values: float) -> Draw:
    return lambda rng: float(rng.choice(values))


def times(*draws: Draw) -> Draw:
    return lambda rng: math.prod(draw(rng) for draw in draws)


def signed(draw: Draw) -> Draw:
    return times(one_of(-1, 1), draw)


def drawn(
    rng: np.random.Generator, draws: Mapping[str, Draw | float] | None = None, /, **more: Any
) -> dict[str, float]:
    """Values by name: what is drawn, in its order, and what is given as a number."""
    return {name: draw(rng) if callable(draw) else draw for name, draw in {**(draws or {}), **more}.items()}


LIKE_TABLE_8_1 = {
    "pitch_radius": about(5.18e-3),
    "lead_angle": about(0.0972),
    "screw_inertia": about(3.12e-6),
    "friction_coefficient": about(0.218),
}
LIKE_PARTS = {  # of the chapter, of each kind of drive
    "rigid": {},
    "threads": {"contact_stiffness": about(1e7, 10.0), "contact_damping": about(1e4, 10.0)},
    "support": {
        "screw_mass": about(10.0), "support_stiffness": about(1e5), "axial_support_damping": about(100.0),
        "slide_friction": times(about(2.0), one_of(0, 1)),
    },
    "nut": {
        "nut_inertia": about(3e-6), "nut_stiffness": about(1.0), "nut_damping": about(2e-4),
        "slide_friction": times(about(2.0), one_of(0, 1)),
    },
}  # fmt: skip
