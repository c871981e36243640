"""From section to section: the next event of motions with two states, for any kind of flow.

A *section* is a mode with a surface on which it is entered (:mod:`lsvib.basins.labels`). ``Pieces`` holds what motions
from sections end in, as far as that is known: intervals of the coordinate along each section.
"""

from typing import NamedTuple

import numpy as np

from lsvib.basins.kernels.labels import UNKNOWN, UNRESOLVED, look_up, new_scratch, put, put_on, signs, step
from lsvib.engine.kernels import event_loop
from lsvib.engine.kernels.jit import allocating_entry, by_address, entry
from lsvib.engine.kernels.layout import GRAZE_KIND, Status, Tables

LEAVES, STAYS, RESTS, LOST = range(4)  # what the next event of a motion is: one, none, the begin of rest, not told
_SETTLED = int(Status.SETTLED)


class Pieces(NamedTuple):
    """What motions from the sections of an automaton with m modes and s surfaces end in.

    Section (i, j) has the edges ``first[i, j]`` to ``last[i, j]``, both included, and between an edge and the next one
    the label of the former.
    """

    landing: np.ndarray  # (t,) surface on which a transition leaves the state, −1 for a corner
    free: np.ndarray  # (s,) the coordinate along a surface
    resting: np.ndarray  # (m,) label of what is in a mode at rest; UNKNOWN for slip
    settled: np.ndarray  # (m,) label of what stays in a mode for ever
    first: np.ndarray  # (m, s)
    last: np.ndarray  # (m, s) equal to the first if nothing is known
    edges: np.ndarray  # (e,)
    labels: np.ndarray  # (e,)


class Way(NamedTuple):
    """How motions are followed: address of :func:`to_next_event`, tables, and steps that a search may take."""

    address: int
    tables: Tables
    pieces: Pieces
    steps: float


@entry
def to_next_event(tables, pieces, mode, short, steps, scratch):
    """Go on past the next event; returns what it is, guard, kind, mode after, stay [s] and short stays in a row."""
    scratch.room.work.steps[0] = steps
    outcome, guard, kind, after, stay, short = step(tables, mode, short, scratch)
    if outcome == _SETTLED:
        return STAYS, guard, kind, mode, stay, short
    if outcome != event_loop.GOES_ON or kind == GRAZE_KIND:
        return LOST, guard, kind, mode, stay, short
    return RESTS if pieces.resting[after] != UNKNOWN else LEAVES, guard, kind, after, stay, short


_next_at = by_address(to_next_event)


@allocating_entry
def images(way, section, points, found, image):
    """Follow motions from ``points`` (k) of a section (mode, surface) to their next event.

    Filled: ``found`` (k, 4), what the next event is, a number for the guard and the signs of all conditions of its
    transition, odd where it comes at once, mode and surface after it; ``image`` (k), the coordinate there.
    """
    address, tables, pieces, steps = way
    scratch, (mode, surface) = new_scratch(tables), section
    state = scratch.now.state
    for k in range(points.size):
        state[pieces.free[surface]] = points[k]
        put_on(tables, surface, state)
        put(scratch, state[0], state[1])
        outcome, guard, _, after, stay, _ = _next_at(address, tables, pieces, mode, 0, steps, scratch)
        found[k, 0], found[k, 1], found[k, 2], found[k, 3], image[k] = outcome, 0, after, -1, 0.0
        if outcome in (LEAVES, RESTS):
            transition = tables.guard_transition[guard]
            number = signs(tables, transition, state, scratch.now.scale)
            found[k, 1] = (number * tables.guard_sign.size + guard) * 2 + (stay == 0.0)
            found[k, 3] = pieces.landing[transition]
            image[k] = state[pieces.free[found[k, 3]]]


@allocating_entry
def map_labels(way, cells, budget, labels, first_events):
    """Label the starts of a grid: ``labels`` and ``first_events`` (rows, columns) are filled.

    A motion goes on from event to event until it comes to a piece, rests, or stays in its mode. The label is UNKNOWN
    where ``budget`` events are not enough, or the next one is not told; UNRESOLVED where no mode fits the start.
    """
    address, tables, pieces, steps = way
    scratch, (x, y, across) = new_scratch(tables), cells
    state = scratch.now.state
    for i in range(y.size):
        for j in range(x.size):
            put(scratch, y[i] if across else x[j], x[j] if across else y[i])
            branch = event_loop.choose_branch(tables, 0, state, scratch.now.scale)
            label, first, short = UNRESOLVED if branch < 0 else UNKNOWN, event_loop.NO_KIND, 0
            mode = tables.branch_mode[max(branch, 0)]
            rests = pieces.resting[mode]  # what starts at rest leaves it at a corner, which no piece holds
            for count in range(budget if label == UNKNOWN else 0):
                outcome, guard, kind, mode, _, short = _next_at(address, tables, pieces, mode, short, steps, scratch)
                first = kind if count == 0 else first
                if rests != UNKNOWN:
                    label = rests
                elif outcome == LEAVES:
                    label = look_up(pieces, mode, pieces.landing[tables.guard_transition[guard]], state)
                elif outcome == STAYS:
                    label = pieces.settled[mode]
                elif outcome == RESTS:
                    label = pieces.resting[mode]
                if label != UNKNOWN or outcome == LOST:
                    break
            labels[i, j], first_events[i, j] = label, first
