"""How the rule follows motions, whatever the kind of their flow, by address: so it is compiled once for all kinds.

The types of a flow and of the scratch space of its search depend on their kind. For the rule both have one type, with a
place for each kind, of which two are empty; an entry below takes its own out. The first argument of an entry stands for
its kind and holds nothing, so that the entries of all kinds are called alike.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import types

from lsvib.systems.kernels import event_loop, flow_taylor, guard_sums, search_planar, single_mode
from lsvib.systems.kernels.jit import by_address, by_kind, entry, kernel
from lsvib.systems.kernels.layout import STEPS, ModalFlow, Tables, TaylorFlow

STEP = 0.1  # cost of a step of the search for an event, in events


class AnyFlow(NamedTuple):
    """A flow of any kind, in its place."""

    planar: np.ndarray
    modal: ModalFlow
    taylor: TaylorFlow


class AnyWork(NamedTuple):
    """The scratch space of a search in a flow of any kind, in its place."""

    planar: search_planar.Work
    modal: guard_sums.Sums
    taylor: flow_taylor.Series


class Machine(NamedTuple):
    """What the rule needs to follow motions: the addresses of the entries below, and scratch space."""

    run: int
    inner: int  # event_loop.run_in for the kind of flow
    derivative: int
    by_speed: bool  # friction depends on speed, so that motions cost more
    room: event_loop.Room


@kernel
def _planar(kind, place):
    return (place.planar,)


@kernel
def _modal(kind, place):
    return (place.modal,)


@kernel
def _taylor(kind, place):
    return (place.taylor,)


_own = by_kind(_planar, _modal, _taylor)  # in a tuple, in which kernels that count no references return arrays


@entry
def run(kind, inner, room, tables, mode, now, until, events):
    """Follow a motion as ``event_loop.run_in`` does, whose address is ``inner``."""
    own_room = event_loop.Room(room.state, room.guards, room.on_surface, _own(kind, room.work)[0])
    own_tables = Tables(_own(kind, tables.flow)[0], *tables[1:])
    return event_loop.run_at(inner, own_room, own_tables, mode, now, until, events)


@entry
def derivative(kind, flow, mode, start, time, out, size):
    """Write the derivative (n, n) of the state after a time by that at the start, and the sizes (n, n) of its terms."""
    single_mode.derivative(_own(kind, flow)[0], mode, start, time, out, size)
    return 0


@entry
def extremes(kind, inner, flow, modes, starts, durations, functionals):
    """Return what ``event_loop.extremes_of_arcs`` does, whose address is ``inner``."""
    return event_loop.extremes_at(inner, _own(kind, flow)[0], modes, starts, durations, functionals)


run_at = by_address(run, types.UniTuple(types.int64, 3))
derivative_at = by_address(derivative, types.int64)
extremes_at = by_address(extremes, types.UniTuple(types.float64, 2))


@kernel
def run_within(engine, tables, mode, now, until, events, budget):
    """Follow a motion by a machine within a ``budget`` (1,), in events, which is counted down by what it takes."""
    given = now.clock[STEPS] = max(budget[0], 0.0) / STEP
    status, mode, count = run_at(engine.run, engine.inner, engine.room, tables, mode, now, until, events)
    left = now.clock[STEPS]
    budget[0] -= count + (STEP * (given - left) if left < math.inf else 0.0)
    return status, mode, count
