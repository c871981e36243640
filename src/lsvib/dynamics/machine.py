"""What the compiled rule needs to follow the motions of an automaton, of one type for all kinds of flow."""

import numpy as np

from lsvib.dynamics.kernels import machine as kernels
from lsvib.dynamics.kernels.machine import AnyFlow, AnyWork, Machine
from lsvib.engine.kernels import event_loop, flow_taylor, guard_sums, jit, layout, search_planar
from lsvib.engine.kernels.layout import Modal, ModalFlow, Now, Planar, Tables, Taylor, TaylorFlow
from lsvib.engine.motion import NEVER, new_events


def _empty(*dimensions: int, many: tuple[int, ...] = (), whole: tuple[int, ...] = ()) -> list[np.ndarray]:
    """Arrays of so many dimensions without an entry, of which some, by their places, are of whole numbers."""
    return [np.zeros((*many, *(0,) * d), dtype=np.int64 if k in whole else float) for k, d in enumerate(dimensions)]


def _no_flow(*many: int) -> AnyFlow:
    modal = _empty(*layout.MODAL_DIMENSIONS, many=many, whole=(0, 1))
    taylor = _empty(*layout.TAYLOR_DIMENSIONS, many=many, whole=(5,))
    return AnyFlow(np.zeros((*many, 0, 0)), ModalFlow(*modal), TaylorFlow(*taylor))


_NO_FLOW = _no_flow()
_NO_WORK = AnyWork(
    search_planar.Work(np.zeros(1)),
    guard_sums.Sums(*_empty(2, 1, 1, 1, 3, 4, 3, 1, 3, 3, 3, 1)),
    flow_taylor.Series(*_empty(2, 2, 1, 1, 2, 1, 1, 1, 1, 1, 1)),
)


def of_one_type(tables: Tables, *many: int) -> Tables:
    """Return tables whose flow has the type that all flows have for the rule; ``many``: drives that they are of."""
    flow = _no_flow(*many) if many else _NO_FLOW
    return tables._replace(flow=flow._replace(**{_PLACES[type(tables.flow)]: tables.flow}))


_PLACES = {np.ndarray: "planar", ModalFlow: "modal", TaylorFlow: "taylor"}  # of a flow, by its type
_KINDS = {"planar": Planar(), "modal": Modal(), "taylor": Taylor()}


def blank(states: int) -> Machine:
    """Return a machine that follows no motion, for its type."""
    room = event_loop.Room(np.zeros(states), np.zeros((1, states)), np.zeros(1, dtype=bool), _NO_WORK)
    return Machine(run=0, inner=0, derivative=0, by_speed=False, room=room)


def machine_for(tables: Tables, engine: event_loop.Engine) -> Machine:
    """Return the machine for the tables of an automaton, by an engine for them, whose scratch space it uses."""
    place, row = _PLACES[type(tables.flow)], np.empty(tables.surfaces.shape[1] - 1)
    room = engine.room._replace(work=_NO_WORK._replace(**{place: engine.room.work}))
    motion = engine.address, room, of_one_type(tables), 0, Now(row, row, row), NEVER, new_events(0, row.size)
    return Machine(
        run=jit.address(kernels.run, _KINDS[place], *motion),
        inner=engine.address,
        derivative=derivative_of(tables),
        by_speed=place == "taylor",
        room=room,
    )


def derivative_of(tables: Tables) -> int:
    """Return the address of the derivative of a flow for the tables of an automaton."""
    n, flow = tables.surfaces.shape[1] - 1, of_one_type(tables).flow
    row, square = np.empty(n), np.empty((n, n))
    found = jit.address(kernels.derivative, _KINDS[_PLACES[type(tables.flow)]], flow, 0, row, 0.0, square, square)
    return found  # type: ignore[no-any-return]  # a function where nothing is compiled


def extremes_of(tables: Tables) -> tuple[int, int]:
    """Return the address of the extremes over arcs for the tables of an automaton, and that which they call."""
    n, flow = tables.surfaces.shape[1] - 1, tables.flow
    arcs = np.zeros(0, dtype=np.int64), np.empty((0, n)), np.empty(0), np.empty((0, n + 1))
    inner, kind = jit.address(event_loop.extremes_of_arcs, flow, *arcs), _KINDS[_PLACES[type(flow)]]
    return jit.address(kernels.extremes, kind, inner, of_one_type(tables).flow, *arcs), inner
