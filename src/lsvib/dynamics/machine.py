"""What the compiled rule needs to follow the motions of an automaton, of one type for all kinds of flow."""

import numpy as np

from lsvib.dynamics.kernels import machine as kernels
from lsvib.dynamics.kernels.machine import AnyFlow, AnyWork, Machine
from lsvib.engine.kernels import event_loop, flow_taylor, guard_sums, jit, search_planar
from lsvib.engine.kernels.layout import Modal, ModalFlow, Planar, Tables, Taylor, TaylorFlow
from lsvib.engine.motion import new_events


def _empty(*dimensions: int, whole: int = 0) -> list[np.ndarray]:
    """Arrays of so many dimensions without an entry, the first ``whole`` of them of whole numbers."""
    return [np.zeros((0,) * d, dtype=np.int64 if k < whole else float) for k, d in enumerate(dimensions)]


_NO_FLOW = AnyFlow(
    np.zeros((0, 0)),
    ModalFlow(*_empty(1, 1, 3, 2, 2, 3, 3, 3, whole=2)),
    TaylorFlow(*_empty(3, 2, 2, 2, 1), np.zeros(0, dtype=np.int64), *_empty(2, 2, 3, 1)),
)
_NO_WORK = AnyWork(
    search_planar.Work(np.zeros(1)),
    guard_sums.Sums(*_empty(2, 1, 1, 1, 3, 4, 3, 1, 3, 3, 3, 1)),
    flow_taylor.Series(*_empty(2, 2, 1, 1, 2, 1, 1, 1, 1, 1, 1)),
)


def of_one_type(tables: Tables) -> Tables:
    """Return tables whose flow has the type that all flows have for the rule."""
    flow = tables.flow
    place = "taylor" if isinstance(flow, TaylorFlow) else "modal" if isinstance(flow, ModalFlow) else "planar"
    return tables._replace(flow=_NO_FLOW._replace(**{place: flow}))


def blank(states: int) -> Machine:
    """Return a machine that follows no motion, for its type."""
    room = event_loop.Room(np.zeros(states), np.zeros((1, states)), np.zeros(1, dtype=bool), _NO_WORK)
    return Machine(run=0, inner=0, derivative=0, by_speed=False, room=room)


def machine_for(tables: Tables, engine: event_loop.Engine) -> Machine:
    """Return the machine for tables (:func:`of_one_type`), by an engine for them, whose scratch space it uses."""
    flow, room, n = tables.flow, engine.room, tables.surfaces.shape[1] - 1
    kinds = {"planar": Planar(), "modal": Modal(), "taylor": Taylor()}
    place = next(place for place in kinds if getattr(flow, place) is not getattr(_NO_FLOW, place))
    kind, row, square = kinds[place], np.empty(n), np.empty((n, n))
    room = room._replace(work=_NO_WORK._replace(**{place: room.work}))
    run = (engine.address, room, tables, 0, row, row, row, 0.0, -1, -1, new_events(0, n))
    return Machine(
        run=jit.address(kernels.run, kind, *run),
        inner=engine.address,
        derivative=jit.address(kernels.derivative, kind, flow, 0, row, 0.0, square, square),
        by_speed=place == "taylor",
        room=room,
    )
