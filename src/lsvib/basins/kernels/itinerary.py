"""What decides the course of motions with two states, as a word of symbols, and where along a line the word changes."""

import numpy as np

from lsvib.basins.kernels.labels import UNKNOWN, ellipse, new_scratch, put, step
from lsvib.engine.kernels import event_loop
from lsvib.engine.kernels.flow_planar import EPS, level
from lsvib.engine.kernels.jit import allocating_entry, entry, kernel
from lsvib.engine.kernels.layout import GRAZE_KIND, Status

TOO_LONG, GRAZED, DIVERGED, STUCK = -3, -4, -5, -6  # codes of itineraries that end nowhere
_SETTLED = int(Status.SETTLED)
_DIVERGED = int(Status.DIVERGED)


@entry
def put_on(tables, surface, state):
    """Set the dependent coordinate of a point of a surface, as :func:`lsvib.engine.kernels.event_loop.put_on_surface`
    does."""
    row, chosen = tables.surfaces[surface], tables.snap[surface]
    state[chosen] = -(row[2] + row[1 - chosen] * state[1 - chosen]) / row[chosen]


@kernel
def _signs(tables, transition, state, scale):
    """The signs of all conditions of a transition at a state, as a number in base three."""
    number = 0
    for k in range(
        tables.condition_start[tables.branch_start[transition]],
        tables.condition_start[tables.branch_start[transition + 1]],
    ):
        value, size = level(tables.condition_row[k], state, scale)
        number = 3 * number + (0 if abs(value) <= size else 1 if value > 0.0 else 2)
    return number


@allocating_entry
def itinerary(tables, known, absorbing, mode, state, push, alternate, symbols):
    """Follow the motion from ``state`` (2, replaced by the last state) in ``mode`` and write what decides its course.

    Arguments: ``absorbing`` (j, 4), intervals of sections: mode, surface, low, high; ``push``: relative change of the
    free coordinate after every event, to see how rounding acts, with ``alternate`` of alternating sign; ``symbols``,
    filled: a number for each event, of the guard and the signs of all conditions of its transition. Returns (code,
    number of events, mode): code TOO_LONG if the symbols are used up, GRAZED, DIVERGED or STUCK; 3 i if the motion
    settles in mode i, 3 i + 1 if it comes to rest in it, 3 i + 2 if it enters absorbing interval i.
    """
    scratch, short = new_scratch(tables), 0
    put(scratch, state[0], state[1])
    code, count = TOO_LONG, 0
    while count < symbols.size and code == TOO_LONG:
        if ellipse(tables, known, mode, scratch.state) < known.trap[mode, 1]:
            code = 3 * mode
            break
        before = mode
        outcome, guard, kind, mode, stay, short = step(tables, mode, short, scratch)
        if outcome != event_loop.GOES_ON:
            code = 3 * before if outcome == _SETTLED else DIVERGED if outcome == _DIVERGED else STUCK
            break
        if kind == GRAZE_KIND:
            code = GRAZED
            break
        transition = tables.guard_transition[guard]
        number = _signs(tables, transition, scratch.state, scratch.scale)
        symbols[count] = (number * tables.guard_sign.size + guard) * 2 + (stay == 0.0)
        count += 1
        surface = known.landing[transition]
        if known.resting[mode] != UNKNOWN:
            code = 3 * mode + 1
        elif surface >= 0:
            free = known.free[surface]
            if push != 0.0:
                scratch.state[free] += push * max(scratch.scale[free], abs(scratch.state[free]))
                push = -push if alternate else push
                put_on(tables, surface, scratch.state)
            x = scratch.state[free]
            for k in range(absorbing.shape[0]):
                here = absorbing[k, 0] == mode and absorbing[k, 1] == surface
                if here and absorbing[k, 2] <= x <= absorbing[k, 3]:
                    code = 3 * k + 2
                    break
    state[0], state[1] = scratch.state
    return code, count, mode


@allocating_entry
def last_agreement(tables, known, absorbing, mode, surface, low, high, resolution, push, alternate, course, position):
    """Bisect a section between ``low``, whose motion has the ``course``, and ``high``, whose motion leaves it.

    ``course``: itinerary with −10 − code appended; ``position``: index at which ``high`` differs first. Returns the
    last coordinate that agrees up to there and the first that does not, apart by ``resolution`` or rounding at most.
    """
    symbols, state, free = np.empty(position + 1, dtype=np.int64), np.empty(2), known.free[surface]
    while high - low > max(resolution, EPS * min(abs(low), abs(high))):
        middle = 0.5 * (low + high)
        state[free] = middle
        put_on(tables, surface, state)
        code, count, _ = itinerary(tables, known, absorbing, mode, state, push, alternate, symbols)
        agrees = count == position + 1 or (count == position and -10 - code == course[position])
        for k in range(count):
            agrees = agrees and symbols[k] == course[k]
        if agrees:
            low = middle
        else:
            high = middle
    return low, high
