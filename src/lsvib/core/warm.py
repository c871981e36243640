"""Compile every kernel once, so that parallel jobs find a filled cache."""

import numpy as np

from lsvib.core import loop, planar
from lsvib.core.status import Test
from lsvib.core.tables import Tables


def compile_engine() -> None:
    """Compile and cache each entry point of the engine by running it on an oscillator that bounces off a surface."""
    flow = np.zeros((1, planar.COLUMNS))
    flow[0, [planar.A0, planar.BETA, planar.TIME_SCALE]] = 1.0
    none, one = np.array([-1]), np.array([0])
    tables = Tables(
        flow=flow,
        surfaces=np.array([[1.0, 0.0, 0.5]]),
        snap=one,
        guard_start=np.array([0, 1]),
        guard_surface=one,
        guard_sign=np.array([1.0]),
        guard_transition=np.array([1]),
        transition_reset=np.array([-1, 0]),
        resets=np.array([[[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]]),
        branch_start=np.array([0, 1, 2]),
        branch_mode=np.array([0, 0]),
        branch_kind=np.array([2, 2]),
        branch_sign=np.array([0, 0]),
        condition_start=np.array([0, 0, 1]),
        condition_row=np.array([[0.0, 1.0, 0.0]]),
        condition_test=np.array([int(Test.POSITIVE)]),
        beyond_accumulation=none,
        shortest_stay=0.0,
    )
    state = np.array([1.0, 0.0])
    events = tuple(
        np.zeros(shape, dtype)
        for shape, dtype in ((8, float), (8, np.int8), (8, np.int8), (8, np.int64), ((8, 2), float), ((8, 2), float))
    )
    _, _, count = loop.run(tables, 0, state, np.zeros(2), 10.0, -1, -1, events)
    if count != 2:
        raise AssertionError(f"the compiled engine bounced {count} times instead of 2")
    loop.choose_branch(tables, 0, state, np.abs(state))
    times = np.array([0.0, 1.0])
    loop.states_at(
        tables, 0.0, 0, state, events[0], events[3], events[5], times, np.zeros((2, 2)), np.zeros(2, dtype=np.int64)
    )
    planar.crossing(flow, 0, state, tables.surfaces[0], False, 1.0)
    planar.extremes(flow, 0, state, tables.surfaces[0], 1.0)
    planar.guard_at(flow, 0, state, np.abs(state), tables.surfaces[0])
    planar.magnitudes(flow, 0, state, 1.0, np.zeros(2))
    planar.advance(flow, 0, state, 1.0, state)
