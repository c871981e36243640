"""Compile what runs of the engine need, so that parallel jobs find a filled cache.

The kernels of maps are compiled when they are first used.
"""

import numpy as np

from lsvib.engine.kernels import event_loop, layout, search_planar
from lsvib.engine.kernels.layout import ModalFlow, Tables, Test


def compile_engine(kinds: tuple[str, ...] = ("planar", "modal")) -> None:
    """Compile and cache each entry point for the kinds of flow, on an oscillator that bounces off a surface."""
    for kind in kinds:
        _bounce(tables_of(kind))


def tables_of(kind: str) -> Tables:
    """Return the tables of an oscillator that bounces off a surface; ``kind`` of its flow: planar or modal."""
    row = np.zeros(layout.COUNT)
    row[[layout.A0, layout.BETA, layout.TIME_SCALE]] = 1.0
    same = np.array([[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]])
    one = np.array([1])
    field = np.array([[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]])
    alone = np.zeros((1, 0))
    modal = ModalFlow(one, np.array([0]), np.array([[row]]), alone, alone, same, same, field)
    first = np.array([0])
    flow = {"planar": np.array([row]), "modal": modal}[kind]
    return Tables(
        flow=flow,
        surfaces=np.array([[1.0, 0.0, 0.5]]),
        snap=first,
        guard_start=np.array([0, 1]),
        guard_surface=first,
        guard_sign=np.array([1.0]),
        guard_transition=np.array([1]),
        guard_parts=np.zeros((1, 3 if isinstance(flow, np.ndarray) else 0)),
        transition_reset=np.array([-1, 0]),
        resets=np.array([[[1.0, 0.0, 0.0], [0.0, -1.0, 0.0]]]),
        branch_start=np.array([0, 1, 2]),
        branch_mode=np.array([0, 0]),
        branch_kind=np.array([2, 2]),
        branch_sign=np.array([0, 0]),
        condition_start=np.array([0, 0, 1]),
        condition_row=np.array([[0.0, 1.0, 0.0]]),
        condition_test=np.array([int(Test.POSITIVE)]),
        beyond_accumulation=np.array([-1]),
        shortest_stay=0.0,
    )


def _bounce(tables: Tables) -> None:
    flow, state = tables.flow, np.array([1.0, 0.0])
    events = tuple(
        np.zeros(shape, dtype)
        for shape, dtype in ((8, float), (8, np.int8), (8, np.int8), (8, np.int64), ((8, 2), float), ((8, 2), float))
    )
    _, _, count = event_loop.run(
        tables, 0, state, np.abs(state), np.array([0.0, 0.0, 0.0, np.inf]), 10.0, -1, -1, events
    )
    if count != 2:
        raise AssertionError(f"the compiled engine bounced {count} times instead of 2")
    event_loop.choose_branch(tables, 0, state, np.abs(state))
    times = np.array([0.0, 1.0])
    event_loop.states_at(
        tables, 0.0, 0, state, events[0], events[3], events[5], times, np.zeros((2, 2)), np.zeros(2, dtype=np.int64)
    )
    surface, first = tables.surfaces[0], np.zeros(1, dtype=np.int64)
    event_loop.extremes_of_arcs(flow, first, state[None], np.ones(1), surface[None])
    event_loop.advance(flow, 0, state, 1.0, state)
    if isinstance(flow, np.ndarray):
        search_planar.crossing(flow, 0, state, surface, False, 1.0)
