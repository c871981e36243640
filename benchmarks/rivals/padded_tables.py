"""The tables of a scene as arrays of equal length for every mode and transition, as compiled array code wants them."""

from typing import Any, NamedTuple

import numpy as np

from benchmarks.rivals.hybrid import Hybrid

_FLOORS = {"modes": 8, "guards": 2, "transitions": 8, "branches": 16, "conditions": 4}
ALWAYS, NEVER = -1, -2  # tests beside those of ``Test``, for what is filled up


class EvenTables(NamedTuple):
    """m modes, g guards of each, t transitions, b branches of each, c conditions of each; n states."""

    matrix: Any  # (m, n, n)
    constant: Any  # (m, n)
    guards: Any  # (m, g, n + 1), positive inside
    snap: Any  # (m, g)
    transition: Any  # (m, g)
    resets: Any  # (t, n, n + 1), the identity if there is none
    rows: Any  # (t, b, c, n + 1)
    tests: Any  # (t, b, c)
    mode: Any  # (t, b)
    kind: Any  # (t, b)


def even_tables(hybrid: Hybrid) -> EvenTables:
    """Return the tables of a scene, filled up by what never acts."""
    t, n = hybrid.tables, len(hybrid.scene.state)
    used = {
        "modes": len(hybrid.modes),
        "guards": np.diff(t.guard_start).max(),
        "transitions": t.transition_reset.size,
        "branches": np.diff(t.branch_start).max(),
        "conditions": np.diff(t.condition_start).max(),
    }
    m, g, k, b, c = (max(floor, 1 << int(used[name] - 1).bit_length()) for name, floor in _FLOORS.items())
    filled = EvenTables(
        np.zeros((m, n, n)), np.zeros((m, n)), np.zeros((m, g, n + 1)), np.zeros((m, g), dtype=np.int64),
        np.zeros((m, g), dtype=np.int64), np.zeros((k, n, n + 1)), np.zeros((k, b, c, n + 1)),
        np.full((k, b, c), ALWAYS), np.zeros((k, b), dtype=np.int64), np.zeros((k, b), dtype=np.int64),
    )  # fmt: skip
    filled.guards[:, :, -1] = 1.0
    filled.resets[:, :, :-1] = np.eye(n)
    filled.tests[:, :, 0] = NEVER
    for i, mode in enumerate(hybrid.modes):
        filled.matrix[i], filled.constant[i] = mode.matrix, mode.constant
        own = slice(len(mode.guards))
        found = slice(mode.first_guard, mode.first_guard + len(mode.guards))
        filled.guards[i, own] = mode.guards
        filled.snap[i, own] = t.snap[t.guard_surface[found]]
        filled.transition[i, own] = t.guard_transition[found]
    for i, reset in enumerate(t.transition_reset):
        if reset >= 0:
            filled.resets[i] = t.resets[reset]
        for j, branch in enumerate(range(t.branch_start[i], t.branch_start[i + 1])):
            own = slice(t.condition_start[branch], t.condition_start[branch + 1])
            size = own.stop - own.start
            filled.tests[i, j, 0] = ALWAYS
            filled.rows[i, j, :size], filled.tests[i, j, :size] = t.condition_row[own], t.condition_test[own]
            filled.mode[i, j], filled.kind[i, j] = t.branch_mode[branch], t.branch_kind[branch]
    return filled
