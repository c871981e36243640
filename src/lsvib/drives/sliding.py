"""Slip modes under a friction law: the law as the engine has it, its Painlevé band of speeds, and passages.

A motion that only slips, around steady sliding, meets no guard of its model. So a mode that steady sliding lies in is
divided at θ′ = Ω: the two halves have one code, and what leads from one to the other is an event, a *passage*. Every
vibration then has events, and so a Poincaré map.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np

from lsvib.drives import friction
from lsvib.drives.friction import coefficient, unbounded
from lsvib.numbers import bisected
from lsvib.systems.automaton import Branch, Guard, Mode, Surface, Transition, scaled
from lsvib.systems.exact.arithmetic import Divided, Row, double, doubles, many_digits, sign
from lsvib.systems.exact.taylor_form import settled_region
from lsvib.systems.kernels.law import FROM, PIECE, TO, bends
from lsvib.systems.kernels.layout import Test

_LAW = ("friction_coefficient", *friction.NAMES)


def of_law(found: Callable[..., Any], d: Any, *more: Any) -> np.ndarray:
    """Return what a function finds for the friction law ``d`` and ``more`` numbers, as an array.

    Of many laws, arrays of parameters (k), it has one more axis, the first; raises ``Divided`` where shapes differ.
    """
    columns = np.broadcast_arrays(*(double(getattr(d, name)) for name in _LAW), *more)
    rows, which = np.unique(np.stack(columns, axis=-1).reshape(-1, len(columns)), axis=0, return_inverse=True)
    split = [(SimpleNamespace(**dict(zip(_LAW, row, strict=False))), row[len(_LAW) :]) for row in rows.tolist()]
    answers = [np.array(found(law, *others)).reshape(-1, 2 if more else PIECE) for law, others in split]
    sizes = np.array([len(answer) for answer in answers])[which.ravel()]
    if (sizes != sizes[0]).any():
        raise Divided(sizes)
    return np.array(answers)[which.ravel()].reshape(*columns[0].shape, *answers[0].shape)


def pieces_of(drive: Any) -> np.ndarray:
    """Return the pieces of the friction law of a drive (p, columns as of :mod:`lsvib.systems.kernels.law`)."""
    piece = np.array(friction.piece_of(drive), dtype=float)
    if drive.friction_slope >= 0:
        return piece[None]
    # The law falls for ever, so it comes to zero once; with a rise later than without.
    low = high = drive.friction_coefficient / -drive.friction_slope
    while unbounded(drive, high)[0] > 0:
        high = 2 * high + 1e-300
    zero = np.zeros(PIECE)
    (end,) = _passes(lambda v: unbounded(drive, v)[0], [low, high]) or [low]
    zero[FROM], zero[TO], piece[TO] = end, math.inf, end
    return np.array([piece, zero])


def speeds_below(drive: Any, level: float) -> list[tuple[float, float]]:
    """Return the intervals of sliding speed [m/s] in which the coefficient is below a level, in ascending order."""
    if math.isinf(level):
        return [(0.0, math.inf)]
    # So far out the rise has faded, and the slope alone has taken the coefficient over the level, or down to zero.
    slope = abs(drive.friction_slope)
    fades = max(getattr(drive, speed) for speed in friction.FADING.values())
    far = 50 * fades + (2 * (drive.friction_coefficient + level) / slope if slope else 0.0)
    turns = _passes(lambda v: unbounded(drive, v)[1], [0.0, *bends(friction.piece_of(drive)), far])
    marks = [0.0, *_passes(lambda v: coefficient(drive, v) - level, [0.0, *turns, far]), math.inf]
    parts = [(a, b) for a, b in pairwise(marks) if a < b]
    middle = [0.5 * (a + b) if math.isfinite(b) else 2 * a + 1e-12 for a, b in parts]
    return [part for part, v in zip(parts, middle, strict=True) if coefficient(drive, v) < level]


def critical_coefficient(inertia: Any, d: Any, mass: Any) -> float:
    """Return the coefficient from which on Γ₊ = I − ξ₊ tan λ m r_m² ≤ 0, infinite if there is none [1].

    ``inertia`` I and ``mass`` m are those that a seizure has to stop; ``d``, the parameters of the drive in balls.
    """
    with many_digits():
        turned = mass * d.pitch_radius**2
        heavy = turned - inertia
        if sign(heavy, "mass") <= 0:
            return math.inf
        found: float = double((inertia + turned * d.tan_lead**2) / (heavy * d.tan_lead))
        return found


def _passes(function: Callable[[float], float], marks: Sequence[float]) -> list[float]:
    """Return where a function, which only grows or only falls between two ``marks``, becomes negative or ceases to."""
    pairs = [(low, high, function(low) < 0) for low, high in pairwise(marks) if low < high]
    ends = [(low, high, begins) for low, high, begins in pairs if (function(high) < 0) != begins]
    return [bisected(lambda v, b=begins: (function(v) < 0) != b, low, high) for low, high, begins in ends]  # type: ignore


def divided(
    name: str,
    kind: int,
    modes: dict[str, Mode],
    transitions: dict[str, Transition],
    surfaces: dict[str, Surface],
    steady: np.ndarray,
) -> None:
    """Divide the mode that ``steady`` sliding (n) lies in at w = 0, in place; ``kind``: of the event in between.

    The region that no motion leaves goes into both halves (:func:`lsvib.systems.exact.taylor_form.settled_region`).
    """
    slow, mode, n = f"{name}_slow", modes[name], steady.shape[-1]
    rows = [doubles(scaled(surfaces[guard.surface].row, guard.sign), (n + 1,)) for guard in mode.guards]
    flow = replace(mode.flow, settled=settled_region(mode.flow, rows, steady))
    deviation = tuple(1 if i == 1 else 0 for i in range(n + 1))
    surfaces["passage"] = Surface(deviation, 1)
    for own, other, side in ((name, slow, 1), (slow, name, -1)):
        guards = (*mode.guards, Guard("passage", side, f"passage_from_{own}"))
        modes[own] = replace(mode, flow=flow, guards=guards)
        transitions[f"passage_from_{own}"] = Transition((Branch(other, kind),))
    for key, transition in transitions.items():
        if not key.startswith("passage"):
            branches = tuple(x for branch in transition.branches for x in _halves(branch, name, slow, deviation))
            transitions[key] = replace(transition, branches=branches)


def _halves(branch: Branch, name: str, slow: str, deviation: Row) -> Iterator[Branch]:
    if branch.mode == name:
        yield branch._replace(conditions=(*branch.conditions, (deviation, Test.POSITIVE)))
        branch = branch._replace(mode=slow)
    yield branch


def speed_row(direction: int, speed: Row, d: Any) -> tuple[Any, ...]:
    """Return the row of the sliding speed [m/s] in a direction ±1, from that of the angular speed [rad/s]."""
    return scaled(speed, direction * d.pitch_radius / d.cos_lead)
