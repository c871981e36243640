"""What the search for the end of a motion with two states follows next, and what it knows so far.

A plan holds numbers only, because compiled code takes no objects; what each of them means stands beside its name.
"""

import math
from typing import NamedTuple

import numpy as np

from lsvib.engine.kernels.flow_planar import ROUNDING
from lsvib.engine.kernels.jit import kernel
from lsvib.engine.kernels.layout import A0, A1, B

OPEN, SETTLED, CYCLE = range(3)  # outcomes: left to the caller; in one mode for ever; on a cycle
# What a motion is followed for; the numbers lie beyond those of outcomes.
PART = 3  # a part of the whole motion
OLDER, OLD, NEW = 4, 5, 6  # P(y) − y for the secant method: the state before the last, the last, the next ones
LEFT, RIGHT = 7, 8  # of an enclosure, its ends
AFTER, BEFORE = 9, 10  # of P′, its two places
STRAIGHT = 11  # P(y) − y of the last state, to see how many returns away the fixed point is
ORBIT = 12  # the cycle


class SearchLimits(NamedTuple):
    """The numbers of the search, as ``lsvib.dynamics.attractor`` and ``lsvib.dynamics.poincare_map`` have them."""

    chunk: int  # events that are looked at first
    patience: int  # events after which a motion is left to the caller
    returns: int  # returns over which a repetition is looked for
    solved: int  # returns among which the nearest one is looked for
    fewest: int  # returns that show where a motion goes
    repeats: float  # relative change that is rounding
    corner: float  # size of a fixed point, in scales of the motion, that is an equilibrium
    few: float  # returns within which a target counts as reached straight
    patience_of_return: float  # time that a return may take, in times of the longest one seen
    longest: int  # events in one return
    secants: int
    wider: float
    widest: float
    slope_step: float
    clear: float  # P(y) − y that is no rounding


class Facts(NamedTuple):
    """What the event kinds and modes of a model mean."""

    rest: int  # mode at rest, −1 if there is none
    sprag: int  # kind of a seizure
    reversal: int  # kind of a reversal of the contact force
    release: int  # kind of the end of rest


class Plan(NamedTuple):
    """What is followed next and what is known so far: numbers that change."""

    whole: np.ndarray  # (WHOLES,) counts and indices, by the names below
    real: np.ndarray  # (REALS,) numbers, by the names below
    left: np.ndarray  # (2,) state at the end of the last part of the whole motion
    origin: np.ndarray  # (2,) of the section
    direction: np.ndarray  # (2,) along it; zero if it is a point
    size: np.ndarray  # (2,) of the motion
    found: np.ndarray  # (2,) state on the cycle


# Of ``whole``: mode to start in, and most events; mode at the end of the last part, events of it, and of all parts;
# kind and mode of the section, whether it is a line, and the coordinate that measures its places; secants; whether the
# wider of two intervals is tried, and events of the return from its left end; whether the motion repeats to the last
# bit.
MODE, MOST, LEFT_MODE, CHUNK, USED, KIND, ENTERS, LINE, CHOSEN, SECANTS, WIDER, EVENTS, REPEATS = range(13)
WHOLES = 13  # how many they are
# Of ``real``: place that is followed; the last two places and P(y) − y there; half width of the interval; P(y) − y at
# its left end and at the first place of P′; longest time of a return; P′; the places between
# which motions go into the mode.
PLACE, Y_OLDER, F_OLDER, Y_OLD, F_OLD, WIDTH, F_LEFT, F_AFTER, LIMIT, SLOPE, FIRST, LAST = range(12)
REALS = 12  # how many they are


class Room(NamedTuple):
    """Working space: events as the event loop writes them, and the state."""

    times: np.ndarray
    kinds: np.ndarray
    signs: np.ndarray
    modes: np.ndarray
    before: np.ndarray
    after: np.ndarray
    state: np.ndarray
    scale: np.ndarray
    clock: np.ndarray
    other_kinds: np.ndarray  # events of another return, to compare with
    other_modes: np.ndarray


@kernel
def put(room, u, w):
    """Set the state, exact as given, and the clock to zero."""
    room.state[0], room.state[1] = u, w
    room.scale[0], room.scale[1] = abs(u), abs(w)
    room.clock[0] = room.clock[1] = room.clock[2] = 0.0
    room.clock[3] = math.inf


@kernel
def lay_section(tables, plan, u, w):
    """Lay the section of a plan through a state: a line if the state lies on one surface, else a point."""
    met, normal, size, direction = 0, 0, plan.size, plan.direction
    for s in range(tables.surfaces.shape[0]):
        row = tables.surfaces[s]
        value = row[0] * u + row[1] * w + row[2]
        if abs(value) <= ROUNDING * (abs(row[0]) * size[0] + abs(row[1]) * size[1] + abs(row[2])):
            met, normal = met + 1, s
    plan.origin[0], plan.origin[1] = u, w
    plan.whole[LINE] = met == 1
    if met == 1:
        direction[0], direction[1] = -tables.surfaces[normal, 1], tables.surfaces[normal, 0]
        length = max(abs(direction[0] / size[0]), abs(direction[1] / size[1]))
        direction[0], direction[1] = direction[0] / length, direction[1] / length
        plan.whole[CHOSEN] = abs(direction[1] / size[1]) > abs(direction[0] / size[0])
        _lay_inner_part(tables, plan)


@kernel
def _lay_inner_part(tables, plan):
    """Find the places of the line from which motions go into the mode; as ``Section`` does."""
    origin, along, size, real = plan.origin, plan.direction, plan.size, plan.real
    real[FIRST], real[LAST] = -math.inf, math.inf
    mode = plan.whole[ENTERS]
    a_0, a_1, b = tables.flow[mode, A0], tables.flow[mode, A1], tables.flow[mode, B]
    bend = -a_0 * origin[0] - a_1 * origin[1] + b
    more = -a_0 * along[0] - a_1 * along[1]
    far_w = max(abs(origin[1]), abs(origin[1] + along[1]))
    far_bend = abs(a_0) * max(abs(origin[0]), abs(origin[0] + along[0])) + abs(a_1) * far_w + abs(b)
    for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
        sign, row = tables.guard_sign[guard], tables.surfaces[tables.guard_surface[guard]]
        met = ROUNDING * (abs(row[0]) * size[0] + abs(row[1]) * size[1] + abs(row[2]))
        parallel = ROUNDING * (abs(row[0] * along[0]) + abs(row[1] * along[1]))
        on_it = abs(row[0] * origin[0] + row[1] * origin[1] + row[2]) <= met
        if on_it and abs(row[0] * along[0] + row[1] * along[1]) <= parallel:
            rate = sign * (row[0] * origin[1] + row[1] * bend)
            slope = sign * (row[0] * along[1] + row[1] * more)
            lost = ROUNDING * (abs(row[0]) * far_w + abs(row[1]) * far_bend)
            corner = -(rate + lost) / slope if abs(slope) > lost else -math.inf
            if slope > lost:
                real[FIRST] = max(real[FIRST], corner)
            elif slope < -lost:
                real[LAST] = min(real[LAST], corner)
            elif rate < -lost:
                real[FIRST], real[LAST] = math.inf, -math.inf


@kernel
def place(plan, u, w):
    """Place of a state along the line."""
    i = plan.whole[CHOSEN]
    return ((w if i == 1 else u) - plan.origin[i]) * (1.0 / plan.direction[i])


@kernel
def return_from(plan, search, room, phase, place):
    """Follow the return from a place of the section."""
    plan.real[PLACE] = place
    plan.whole[MODE], plan.whole[MOST] = plan.whole[ENTERS], search.longest
    put(room, plan.origin[0] + plan.direction[0] * place, plan.origin[1] + plan.direction[1] * place)
    return phase


@kernel
def cycle_from(plan, search, room, u, w):
    """Follow the cycle through a state, if it is one: a fixed point next to the equilibrium is not."""
    if plan.whole[REPEATS] == 0 and max(abs(u / plan.size[0]), abs(w / plan.size[1])) < search.corner:
        return OPEN
    plan.whole[MODE], plan.whole[MOST] = plan.whole[ENTERS], search.longest
    plan.found[0], plan.found[1] = u, w
    put(room, u, w)
    return ORBIT


@kernel
def go_on(plan, room):
    """Follow the next part of the whole motion, twice as long, from where the last one ended."""
    plan.whole[CHUNK] *= 2
    plan.whole[MOST], plan.whole[MODE] = plan.whole[CHUNK], plan.whole[LEFT_MODE]
    put(room, plan.left[0], plan.left[1])
    return PART
