"""What the compiled rule needs to follow the motions of an automaton, of one type for all kinds of flow."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels import event_loop, jit, layout
from lsvib.systems.kernels import machine as kernels
from lsvib.systems.kernels.layout import Modal, ModalFlow, Now, Planar, Tables, Taylor, TaylorFlow
from lsvib.systems.kernels.machine import AnyFlow, AnyWork, Machine
from lsvib.systems.motion import NEVER, engine_for, new_events


def _empty(flow: type) -> Any:
    return flow(*(np.zeros((0,) * own[0], *own[1:]) for own in layout.annotated(flow).values()))


_NO_FLOW = AnyFlow(np.zeros((0, 0)), _empty(ModalFlow), _empty(TaylorFlow))
_NO_WORK = AnyWork(*(event_loop.workspace(flow, 0) for flow in _NO_FLOW))


def of_one_type(tables: Tables) -> Tables:
    """Return tables whose flow has the type that all flows have for the rule."""
    return tables._replace(flow=_NO_FLOW._replace(**{_PLACES[type(tables.flow)]: tables.flow}))


_PLACES = {np.ndarray: "planar", ModalFlow: "modal", TaylorFlow: "taylor"}  # of a flow, by its type
_KINDS = {"planar": Planar(), "modal": Modal(), "taylor": Taylor()}


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


@contextmanager
def lent(automaton: Automaton) -> Iterator[tuple[Machine, Tables]]:
    """Lend the machine of an automaton and its tables, of the one type, to one who follows motions by the rule."""
    engine = automaton.engines.pop() if automaton.engines else engine_for(automaton.tables)
    yield machine_for(automaton.tables, engine), of_one_type(automaton.tables)
    automaton.engines.append(engine)


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
