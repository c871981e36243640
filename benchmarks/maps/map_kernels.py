"""Maps of a planar drive by following every motion: with fixed steps of Runge–Kutta, and from event to event.

Two rules say when a motion need not be followed further; under both it is steady sliding once it is within the ellipse
that is never left (``Known.trap``). ``seizures`` = 0, the rule of the engine's own map: the label after an event is
looked up in the table of intervals. ``seizures`` = n, the rule of whoever has no such table: after n of them it is
taken for a sprag–slip cycle.
"""

import math

from benchmarks.jit import allocating_kernel, kernel
from lsvib.basins.kernels.labelling import UNKNOWN, UNRESOLVED, ellipse, look_up, new_scratch
from lsvib.engine.kernels import event_loop
from lsvib.engine.kernels.columns import A0, A1, B
from lsvib.engine.kernels.flow_planar import ROUNDING
from lsvib.engine.kernels.status import Found

_NONE = int(Found.NONE)
_CROSSING = int(Found.CROSSING)


@kernel
def _enter(tables, scratch, u, w):
    """Put a start into ``scratch``; returns its mode, or −1."""
    scratch.state[0], scratch.state[1] = u, w
    scratch.scale[0], scratch.scale[1] = abs(u), abs(w)
    branch = event_loop.choose_branch(tables, 0, scratch.state, scratch.scale)
    return tables.branch_mode[branch] if branch >= 0 else -1


@kernel
def _passed(tables, known, sprags, guard, scratch, count, seizures, cycle):
    """Make the transition of a guard; returns (mode or −1, label or UNKNOWN, number of seizures)."""
    transition = tables.guard_transition[guard]
    event_loop.apply_reset(tables, transition, scratch.state, scratch.spare)
    for i in range(2):
        scratch.scale[i] = max(scratch.scale[i], abs(scratch.state[i]))
    branch = event_loop.choose_branch(tables, transition, scratch.state, scratch.scale)
    if branch < 0:
        return -1, UNRESOLVED, count
    mode = tables.branch_mode[branch]
    if seizures == 0:
        if known.resting[mode] != UNKNOWN:
            return mode, known.resting[mode], count
        surface = known.landing[transition]
        return mode, look_up(known, mode, surface, scratch.state) if surface >= 0 else UNKNOWN, count
    for k in range(sprags.size):
        count += tables.branch_kind[branch] == sprags[k]
    return mode, cycle if count >= seizures else UNKNOWN, count


@kernel
def _runge_kutta(row, u, w, h):
    """One step of the classical method for u″ = b − a₀ u − a₁ w."""
    a0, a1, b = row[A0], row[A1], row[B]
    k1 = b - a0 * u - a1 * w
    w2 = w + 0.5 * h * k1
    k2 = b - a0 * (u + 0.5 * h * w) - a1 * w2
    w3 = w + 0.5 * h * k2
    k3 = b - a0 * (u + 0.5 * h * w2) - a1 * w3
    w4 = w + h * k3
    k4 = b - a0 * (u + h * w3) - a1 * w4
    return u + h / 6.0 * (w + 2.0 * (w2 + w3) + w4), w + h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4)


@kernel
def _guard(tables, guard, u, w):
    row = tables.surfaces[tables.guard_surface[guard]]
    return tables.guard_sign[guard] * (row[0] * u + row[1] * w + row[2])


@kernel
def _due(tables, mode, u, w):
    """The guard of a mode that is negative on entering it, where a jump is due, or −1."""
    for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
        row = tables.surfaces[tables.guard_surface[guard]]
        if _guard(tables, guard, u, w) < -ROUNDING * (abs(row[0] * u) + abs(row[1] * w) + abs(row[2])):
            return guard
    return -1


@kernel
def _fired(tables, mode, u, w, u_next, w_next):
    """The guard of a mode that is negative after a step and was zero first, and the part of the step until then."""
    fired, first = -1, 2.0
    for guard in range(tables.guard_start[mode], tables.guard_start[mode + 1]):
        after = _guard(tables, guard, u_next, w_next)
        if after < 0.0:
            before = max(_guard(tables, guard, u, w), 0.0)
            if before / (before - after) < first:
                fired, first = guard, before / (before - after)
    return fired, first


@kernel
def _stepped_label(tables, known, sprags, mode, scratch, step, limit, seizures, cycle):
    state, now, count = scratch.state, 0.0, 0
    due = _due(tables, mode, state[0], state[1])
    while now < limit:
        guard, u, w = due, state[0], state[1]
        if guard < 0:
            if ellipse(tables, known, mode, state) < known.trap[mode, 1]:
                return known.settled[mode]
            row, h = tables.flow[mode], step
            if known.resting[mode] != UNKNOWN:  # at rest the guard falls at a constant rate: one step to its zero
                first = tables.guard_start[mode]
                value = _guard(tables, first, u, w)
                h = max(h, 2.0 * value / (value - _guard(tables, first, u + w, w)))
            u_next, w_next = _runge_kutta(row, u, w, h)
            guard, part = _fired(tables, mode, u, w, u_next, w_next)
            if guard >= 0:
                h *= part
                u_next, w_next = _runge_kutta(row, u, w, h)
            state[0], state[1] = u_next, w_next
            now += h
            if guard >= 0:
                scratch.scale[0], scratch.scale[1] = abs(u_next), abs(w_next)
                event_loop.put_on_surface(tables, guard, state, scratch.scale)
        if guard >= 0:
            mode, label, count = _passed(tables, known, sprags, guard, scratch, count, seizures, cycle)
            if label != UNKNOWN:
                return label
            due = _due(tables, mode, state[0], state[1])
    return UNRESOLVED


@allocating_kernel
def stepped_labels(tables, known, sprags, x, y, step, limit, seizures, cycle, labels):
    """Label the starts u = x, w = y of a grid by Runge–Kutta of order four with a fixed step; fills ``labels``.

    Arguments: tables, what is known (:class:`lsvib.basins.kernels.labelling.Known`), event kinds that sprag; x
    (columns) [rad], y (rows) [rad/s]; step [s]; limit [s], after which a motion is unresolved; ``seizures`` as in the
    module's text, ``cycle``, the label of their cycle. Where a guard is negative after a step, the step is cut where a
    straight line between both values is zero; the stick test, and the jump from a start beyond a guard, are those of
    the tables; rest is left in one step.
    """
    scratch = new_scratch(tables)
    for i in range(y.size):
        for j in range(x.size):
            mode = _enter(tables, scratch, x[j], y[i])
            labels[i, j] = UNRESOLVED
            if mode >= 0:
                labels[i, j] = _stepped_label(tables, known, sprags, mode, scratch, step, limit, seizures, cycle)


@kernel
def _followed_label(tables, known, sprags, mode, scratch, budget, seizures, cycle):
    state, scale, count = scratch.state, scratch.scale, 0
    for _ in range(budget):
        if ellipse(tables, known, mode, state) < known.trap[mode, 1]:
            return known.settled[mode]
        found, guard, stay = event_loop.next_event(
            tables, mode, state, scale, math.inf, scratch.room, scratch.zeros, scratch.work
        )
        if found == _NONE:
            return known.settled[mode]
        event_loop.arrive(tables, mode, state, scale, guard, stay, scratch.work)
        if found != _CROSSING:
            return UNRESOLVED
        mode, label, count = _passed(tables, known, sprags, guard, scratch, count, seizures, cycle)
        if label != UNKNOWN:
            return label
    return UNRESOLVED


@allocating_kernel
def followed_labels(tables, known, sprags, x, y, budget, seizures, cycle, labels):
    """As :func:`stepped_labels`, exactly, from event to event; ``budget``: events after which it is unresolved."""
    scratch = new_scratch(tables)
    for i in range(y.size):
        for j in range(x.size):
            mode = _enter(tables, scratch, x[j], y[i])
            labels[i, j] = UNRESOLVED
            if mode >= 0:
                labels[i, j] = _followed_label(tables, known, sprags, mode, scratch, budget, seizures, cycle)
