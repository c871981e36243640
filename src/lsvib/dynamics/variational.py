r"""Derivatives of motions with respect to their start: the flow of a mode, and what an event does to a neighbour.

In a mode x′ = A x + b, so that neighbours separate as e^{Aτ}. A neighbour meets the surface gᵀx + g_0 = 0 of an event
earlier or later; seen from event to event, with the field f before it and the affine reset x ↦ R x + r of the event,

    D = R (I − f gᵀ / gᵀf) e^{Aτ}

is the derivative of the state after the event with respect to that after the one before. Times and the field after the
event do not enter: the product over a period is the derivative of the return map, whose eigenvalues are the Floquet
multipliers without the trivial 1. (With it, the saltation matrix is R + (f⁺ − R f) gᵀ / gᵀf.) Release from rest of the
rigid drive has g = ±(1, 0) and f = (−Ω, 0), so that D is zero: a rest phase makes a cycle superstable.
"""

import math
from dataclasses import dataclass

import numpy as np

from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import flow_planar, layout
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, GRAZE_KIND
from lsvib.engine.motion import Motion

_TERMS = 8.0  # most roundings in a term of a product of two matrices with up to five rows


@dataclass(frozen=True)
class Derivative:
    """Derivative ``matrix`` (n, n) of a state with respect to an earlier one; a bound (n, n) of its ``rounding``."""

    matrix: np.ndarray
    rounding: np.ndarray


def inner_coordinates(automaton: Automaton, mode: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the matrices (q + 1, n + 1) into and (n + 1, q + 1) out of the coordinates that the flow is held in."""
    flow, n = automaton.tables.flow, len(automaton.states)
    if isinstance(flow, np.ndarray):
        return np.eye(n + 1), np.eye(n + 1)
    q = int(2 * flow.pairs[mode] + flow.singles[mode])
    unit = np.eye(max(n, q) + 1)
    columns = np.concatenate([flow.from_modal[mode][:, :q], flow.from_modal[mode][:, -1:]], axis=1)
    return np.vstack([flow.to_modal[mode, :q], unit[n, : n + 1]]), np.vstack([columns, unit[q, : q + 1]])


def propagator(automaton: Automaton, mode: int, time: float) -> np.ndarray:
    """Return the affine flow of a mode over a time [s] in its inner coordinates with a one, (q + 1, q + 1)."""
    flow = automaton.tables.flow
    if isinstance(flow, np.ndarray):
        row = flow[mode]
        c, s, s_rate = flow_planar.responses(row, time)
        moved = flow_planar.integrated_response(row, time)
        a0, b = row[layout.A0], row[layout.B]
        pushed = b * moved if b else 0.0  # in a rest so long that t² is beyond all numbers as well
        return np.array([[c, s, pushed], [-a0 * s, s_rate, b * s], [0.0, 0.0, 1.0]])
    pairs, singles = int(flow.pairs[mode]), int(flow.singles[mode])
    found = np.eye(2 * pairs + singles + 1)
    for pair in range(pairs):
        row = flow.oscillators[mode, pair]
        c, s, s_rate = flow_planar.responses(row, time)
        found[2 * pair : 2 * pair + 2, 2 * pair : 2 * pair + 2] = [[c, s], [-row[layout.A0] * s, s_rate]]
    for single in range(singles):
        k, rate, push = 2 * pairs + single, float(flow.rates[mode, single]), float(flow.pushes[mode, single])
        more = math.expm1(min(rate * time, flow_planar.OVERFLOW))
        found[k, k], found[k, -1] = 1.0 + more, push * (more / rate if rate else time)
    return found


def flow_derivative(
    automaton: Automaton, mode: int, time: float, coordinates: tuple[np.ndarray, np.ndarray]
) -> Derivative:
    """Return e^{Aτ} of a mode after a time τ [s]; ``coordinates`` as of :func:`inner_coordinates`."""
    n = len(automaton.states)
    into, out = coordinates
    inner = propagator(automaton, mode, time)
    size = np.abs(out) @ np.abs(inner) @ np.abs(into)
    return Derivative((out @ inner @ into)[:n, :n], _TERMS * flow_planar.EPS * size[:n, :n])


def field(automaton: Automaton, mode: int, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return x′ (n) at a state (n) in a mode, and the sizes (n) of the terms that it is summed from."""
    flow = automaton.tables.flow
    if isinstance(flow, np.ndarray):
        row = flow[mode]
        rows = np.array([[0.0, 1.0, 0.0], [-row[layout.A0], -row[layout.A1], row[layout.B]]])
    else:
        rows = flow.field[mode]
    return rows[:, :-1] @ state + rows[:, -1], np.abs(rows[:, :-1]) @ np.abs(state) + np.abs(rows[:, -1])


def crossed_guard(automaton: Automaton, mode: int, kind: int, after: int, before: np.ndarray) -> int:
    """Return the guard of ``mode`` that an event of ``kind`` into the mode ``after`` belongs to; −1 if there is none.

    Of several it is the one whose surface is nearest to the state ``before`` the event: that one is met to rounding.
    """
    tables, found, nearest = automaton.tables, -1, math.inf
    for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
        transition = tables.guard_transition[guard]
        branches = slice(tables.branch_start[transition], tables.branch_start[transition + 1])
        if not ((tables.branch_mode[branches] == after) & (tables.branch_kind[branches] == kind)).any():
            continue
        row = tables.surfaces[tables.guard_surface[guard]]
        size = np.abs(row[:-1]) @ np.abs(before) + abs(row[-1])
        distance = abs(row[:-1] @ before + row[-1]) / size if size else 0.0
        if distance < nearest:
            found, nearest = guard, distance
    return found


def event_derivative(automaton: Automaton, mode: int, kind: int, after: int, before: np.ndarray) -> Derivative:
    """Return R (I − f gᵀ / gᵀf) of an event that ends ``mode`` in the state ``before`` (n).

    nan if the surface is only touched by the field, or infinitely many events end here: there is no derivative.
    """
    n, tables = before.size, automaton.tables
    if kind == GRAZE_KIND:
        return Derivative(np.eye(n), np.zeros((n, n)))
    guard = -1 if kind == ACCUMULATION_KIND else crossed_guard(automaton, mode, kind, after, before)
    f, f_size = field(automaton, mode, before)
    normal = tables.surfaces[tables.guard_surface[guard], :-1] if guard >= 0 else np.zeros(n)
    speed = float(normal @ f)
    if not 0.0 < speed * speed < math.inf:  # whose square has underflown is that of what rounding leaves of a motion
        return Derivative(np.full((n, n), math.nan), np.full((n, n), math.nan))
    across, size = f[:, None] * normal, np.abs(normal)
    matrix = np.eye(n) - across / speed
    # The quotient's own rounding, that of its parts, and of the difference in gᵀf.
    lost = f_size[:, None] * size / abs(speed)
    lost = lost + np.abs(across) * (size @ f_size) / speed**2
    lost = _TERMS * flow_planar.EPS * (lost + np.abs(matrix))
    reset = tables.transition_reset[tables.guard_transition[guard]]
    if reset < 0:
        return Derivative(matrix, lost)
    back = tables.resets[reset][:, :-1]
    return Derivative(back @ matrix, np.abs(back) @ lost)


def eigenvalues(matrix: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the eigenvalues of a real matrix, complex, and the largest condition of one, |y| |x| / |yᵀx|."""
    if len(matrix) == 1:
        return matrix[0].astype(complex), 1.0
    values, right = np.linalg.eig(matrix)
    try:
        left = np.linalg.inv(right)
    except np.linalg.LinAlgError:
        return values.astype(complex), math.inf
    with np.errstate(over="ignore"):  # hypot alone keeps the squares of large entries within the range of numbers
        conditions = np.hypot.reduce(np.abs(left), axis=1) * np.hypot.reduce(np.abs(right), axis=0)
    return values.astype(complex), float(np.max(conditions))


def then(first: Derivative, second: Derivative) -> Derivative:
    """Return the derivative of ``second`` after ``first``."""
    size = np.abs(second.matrix) @ np.abs(first.matrix)
    lost = second.rounding @ np.abs(first.matrix) + np.abs(second.matrix) @ first.rounding
    return Derivative(second.matrix @ first.matrix, lost + _TERMS * flow_planar.EPS * size)


def derivative(motion: Motion) -> Derivative:
    """Return the derivative of the state after a motion's last event with respect to its start.

    nan if an event has none. The start's own mode is kept: neighbours start in it. A rounding beyond all numbers is
    infinite or nan: a surface is hardly crossed there.
    """
    automaton, n = motion.automaton, motion.start_state.size
    total = Derivative(np.eye(n), np.zeros((n, n)))
    modes, _, _, durations = motion.arcs()
    coordinates: dict[int, tuple[np.ndarray, np.ndarray]] = {}
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(motion.time.size):
            mode, after = int(modes[k]), int(motion.mode[k])
            if mode not in coordinates:
                coordinates[mode] = inner_coordinates(automaton, mode)
            total = then(total, flow_derivative(automaton, mode, float(durations[k]), coordinates[mode]))
            total = then(total, event_derivative(automaton, mode, int(motion.kind[k]), after, motion.before[k]))
    return total


def rounding(motion: Motion) -> np.ndarray:
    """Return how far (2) the last digits of a planar motion move its end, summed over its arcs.

    Each arc rounds its states by as much as they swing in it, and the derivative of all that follows carries that on:
    from the last arc backwards, with the signs that let strong growth and strong decay cancel. nan if an event has no
    derivative.
    """
    automaton, lost, onwards = motion.automaton, np.zeros(2), np.eye(2)
    modes, _, states, durations = motion.arcs()
    for k in reversed(range(motion.time.size)):
        mode, (angle, speed) = int(modes[k]), np.maximum(np.abs(states[k]), np.abs(motion.before[k]))
        turning = automaton.tables.flow[mode, layout.BETA]
        swing = np.array([angle + (speed / turning if turning > 0 else 0.0), speed + turning * angle])
        flow = flow_derivative(automaton, mode, float(durations[k]), (np.eye(3), np.eye(3)))
        event = event_derivative(automaton, mode, int(motion.kind[k]), int(motion.mode[k]), motion.before[k])
        onwards = onwards @ event.matrix
        lost = lost + np.abs(onwards) @ (flow_planar.EPS * swing)
        onwards = onwards @ flow.matrix
    return lost
