"""The price of certainty, of the certain search beside a plain one: ``python -m benchmarks.cost_of_certainty``.

The plain search looks for changes of sign at the nodes of the certain one, which it takes as given. It is the cheapest
search possible, since it need not even find out where to look. The design promises that certainty costs less than twice
as much; measured were 1.2 to 1.5 times on the arcs of Fig. 8.10, k_c = c_c = 1e8.
"""

import types
from time import perf_counter

import numba
import numpy as np

from lsvib.engine.kernels import guard_sums, search_modal
from lsvib.engine.kernels.flow_planar import level
from lsvib.engine.kernels.layout import Decision
from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.model import automaton_of

_LIMIT = 1.0
_OPTIONS = {"error_model": "numpy", "_nrt": False}  # those of the kernels


def arcs():
    """Every arc of the motion of Fig. 8.10: tables, modes, states at the start, guards, which of them are zero."""
    drive = Drive(mass=11.0, axial_force=100.0, contact_stiffness=1e8, contact_damping=1e8)
    automaton = automaton_of(drive)
    motion = follow(automaton, [0.005, 0.0, 0.0, 0.0], 0.05)
    tables = automaton.tables
    modes, starts, _, _ = motion.arcs()
    guards, zero = np.empty((modes.size, 2, 5)), np.zeros((modes.size, 2), dtype=bool)
    for i, (mode, state) in enumerate(zip(modes, starts, strict=True)):
        first = tables.guard_start[mode]
        assert tables.guard_start[mode + 1] - first == 2
        for k in (0, 1):
            guards[i, k] = tables.guard_sign[first + k] * tables.surfaces[tables.guard_surface[first + k]]
            value, size = level(guards[i, k], state, np.abs(state))
            zero[i, k] = value <= size
    return tables.flow, modes, starts, guards, zero


def nodes_of(flow, modes, starts, guards, zero):
    """Lengths of the steps that the certain search accepts on each arc, and its roots."""
    steps, roots = [], []
    for mode, state, rows, on in zip(modes, starts, guards, zero, strict=True):
        taken = []

        def decide(*arguments, taken=taken):
            outcome = search_modal.decide(*arguments)
            taken.append((arguments[3], arguments[6], outcome[0]))
            return outcome

        names = {**vars(search_modal), "decide": decide}
        search = types.FunctionType(search_modal.search.py_func.__code__, names)
        found, guard, when = search(flow, mode, state, rows, on.copy(), _LIMIT, guard_sums.room_for(flow, 2))
        roots.append((int(found), guard, when))
        undecided = {step for _, step, outcome in taken if outcome == Decision.UNDECIDED}
        steps.append([step for guard, step, _ in taken if guard == 1 and step not in undecided])
    return steps, roots


@numba.njit(**_OPTIONS, forceinline=True)
def no_bounds(row, value, rate, out):
    """What a plain search needs of :func:`lsvib.engine.kernels.guard_sums.pair_bounds`."""


def compared(repeats: int = 2000) -> tuple[float, float]:
    """Return the least time [s] of so many turns over all arcs, of the certain and of the plain search."""
    flow, modes, starts, guards, zero = arcs()
    steps, roots = nodes_of(flow, modes, starts, guards, zero)
    most = max(map(len, steps))
    nodes = np.full((modes.size, most), np.nan)
    for row, taken in zip(nodes, steps, strict=True):
        row[: len(taken)] = taken

    # The parts of the guards without their bounds.
    names = {**vars(guard_sums), "pair_bounds": no_bounds, "ORDERS": 3}
    parts = numba.njit(**_OPTIONS, forceinline=True)(types.FunctionType(guard_sums.prepare.py_func.__code__, names))

    @numba.njit(**_OPTIONS)
    def plain(flow, mode, state, guards, steps, off_surface, work):
        count = guards.shape[0]
        parts(flow, mode, state, guards, work)
        a = 0.0
        for step in steps:
            b = a + step
            guard_sums.go_to(flow, mode, work, b, 1)
            change = False
            for guard in range(count):
                guard_sums.evaluate(flow, mode, work, guard, 1)
                change = change or work.values[1, guard, 0] <= 0.0
            if change:
                rate = search_modal.fastest(flow, mode)
                return search_modal._earliest(flow, mode, work, 1, a, b, off_surface, rate)[1]
            a = b
        return a

    @numba.njit(error_model="numpy")
    def all_certain(flow, modes, starts, guards, zero, out):
        work = guard_sums.room_for(flow, 2)
        for i in range(modes.size):
            on = zero[i].copy()
            out[i] = search_modal.search(flow, modes[i], starts[i], guards[i], on, _LIMIT, work)[2]

    @numba.njit(error_model="numpy")
    def all_plain(flow, modes, starts, guards, nodes, out):
        work, off_surface = guard_sums.room_for(flow, 2), np.zeros(2, dtype=np.bool_)
        for i in range(modes.size):
            out[i] = plain(flow, modes[i], starts[i], guards[i], nodes[i], off_surface, work)

    certain, simple = np.empty(modes.size), np.empty(modes.size)
    best = [np.inf, np.inf]
    for _ in range(repeats):
        begun = perf_counter()
        all_certain(flow, modes, starts, guards, zero, certain)
        middle = perf_counter()
        all_plain(flow, modes, starts, guards, nodes, simple)
        best = [min(best[0], middle - begun), min(best[1], perf_counter() - middle)]
    # The first arc starts on N = 0, where the plain search finds its own start.
    if not (np.array_equal(certain, [when for _, _, when in roots]) and np.array_equal(certain[1:], simple[1:])):
        raise ArithmeticError("the searches find different roots")
    return best[0], best[1]


if __name__ == "__main__":
    certain, plain = compared()
    print(f"certain {certain * 1e6:.1f} us, plain {plain * 1e6:.1f} us, {certain / plain:.2f} times as much")
