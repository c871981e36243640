"""Maps of a planar drive by following every motion with fixed steps of Runge–Kutta.

A motion need not be followed further once it is within the ellipse that is never left (``Known.trap``), where it is
steady sliding, or once the label after an event is found in the engine's table of intervals.
"""

from benchmarks.jit import allocating_kernel, kernel
from lsvib.basins.kernels.labels import UNKNOWN, UNRESOLVED, ellipse, look_up, new_scratch
from lsvib.engine.kernels import event_loop
from lsvib.engine.kernels.flow_planar import ROUNDING
from lsvib.engine.kernels.layout import A0, A1, B


@kernel
def _enter(tables, scratch, u, w):
    """Put a start into ``scratch``; returns its mode, or −1."""
    scratch.now.state[0], scratch.now.state[1] = u, w
    scratch.now.scale[0], scratch.now.scale[1] = abs(u), abs(w)
    branch = event_loop.choose_branch(tables, 0, scratch.now.state, scratch.now.scale)
    return tables.branch_mode[branch] if branch >= 0 else -1


@kernel
def _passed(tables, known, guard, scratch):
    """Make the transition of a guard; returns (mode or −1, label or UNKNOWN)."""
    transition = tables.guard_transition[guard]
    event_loop.apply_reset(tables, transition, scratch.now.state, scratch.room.state)
    for i in range(2):
        scratch.now.scale[i] = max(scratch.now.scale[i], abs(scratch.now.state[i]))
    branch = event_loop.choose_branch(tables, transition, scratch.now.state, scratch.now.scale)
    if branch < 0:
        return -1, UNRESOLVED
    mode = tables.branch_mode[branch]
    if known.resting[mode] != UNKNOWN:
        return mode, known.resting[mode]
    surface = known.landing[transition]
    return mode, look_up(known, mode, surface, scratch.now.state) if surface >= 0 else UNKNOWN


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
def _label(tables, known, mode, scratch, step, limit):
    state, now = scratch.now.state, 0.0
    due = _due(tables, mode, state[0], state[1])
    while now < limit:
        guard, u, w = due, state[0], state[1]
        if guard < 0:
            if ellipse(tables, known, mode, state) < known.trap[mode, 1]:
                return known.settled[mode]
            u_next, w_next = _runge_kutta(tables.flow[mode], u, w, step)
            guard, part = _fired(tables, mode, u, w, u_next, w_next)
            if guard >= 0:
                u_next, w_next = _runge_kutta(tables.flow[mode], u, w, part * step)
            state[0], state[1] = u_next, w_next
            now += min(part, 1.0) * step
            if guard >= 0:
                scratch.now.scale[0], scratch.now.scale[1] = abs(u_next), abs(w_next)
                event_loop.put_on_surface(tables, guard, state, scratch.now.scale)
        if guard >= 0:
            mode, label = _passed(tables, known, guard, scratch)
            if label != UNKNOWN:
                return label
            due = _due(tables, mode, state[0], state[1])
    return UNRESOLVED


@allocating_kernel
def stepped_labels(tables, known, x, y, step, limit, labels):
    """Label the starts u = x, w = y of a grid by Runge–Kutta of order four with a fixed step; fills ``labels``.

    Arguments: tables, what is known (:class:`lsvib.basins.kernels.labels.Known`); x (columns) [rad], y (rows)
    [rad/s]; step [s]; limit [s], after which a motion is unresolved. Where a guard is negative after a step, the step
    is cut where a straight line between both values is zero; the stick test, and the jump from a start beyond a guard,
    are those of the tables.
    """
    scratch = new_scratch(tables)
    for i in range(y.size):
        for j in range(x.size):
            mode = _enter(tables, scratch, x[j], y[i])
            labels[i, j] = UNRESOLVED
            if mode >= 0:
                labels[i, j] = known.resting[mode]
                if labels[i, j] == UNKNOWN:
                    labels[i, j] = _label(tables, known, mode, scratch, step, limit)
