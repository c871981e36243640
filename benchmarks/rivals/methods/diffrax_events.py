"""diffrax with events: the whole loop from event to event compiled, with the tables of :class:`Hybrid` as arrays.

Needs jax in double precision and with one thread, which loading this module sees to, for the process. What is compiled
depends on the solver and on the rounded-up sizes of the tables only: scenes, tolerances and step caps share it.
"""

import os
from collections.abc import Callable
from enum import IntEnum
from functools import cache
from typing import Any, NamedTuple

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix
from jax import lax

from benchmarks.record import Record
from benchmarks.rivals.hybrid import MOST_STEPS, RETRIES, ROUNDING, Clock, Hybrid, Recorder
from benchmarks.rivals.padded_tables import ALWAYS, NEVER, EvenTables, even_tables
from lsvib.engine.kernels.status import Test

jax.config.update("jax_enable_x64", True)
# One thread, as all other methods have: run times are processor times, and a second worker of XLA that waits for work
# counts as much as one that works. XLA looks at this variable when the first array is made.
jax.config.update("jax_cpu_enable_async_dispatch", False)
os.environ.setdefault("NPROC", "1")

_CHUNK = 1024  # events, after which the compiled loop returns, so that the clock is looked at
_ROOT = 1e-15, 1e-17  # relative and absolute [s] tolerance of the time of an event
_FAINT = 1e-18  # factor of the guards: bisection asks for small values too, where only the sign matters
_SMALLEST = 1e-300  # keeps zero by zero out


class _Status(IntEnum):
    RUNNING = 0
    DONE = 1
    LOST = 2
    FAILED = 3
    STUCK = 4


_FAILURES = {
    _Status.LOST: "no branch fits",
    _Status.FAILED: f"the solver failed or took over {MOST_STEPS} steps",
    _Status.STUCK: "no step away from a guard",
}


class _Limits(NamedTuple):
    end: Any  # [s]
    rtol: Any
    atol: Any  # (n)
    cap: Any  # [s], largest step
    retry: Any  # [s], a quarter of it is the largest step of the first retry


class _March(NamedTuple):
    """State of the loop; of the events only those of the present chunk."""

    now: Any
    mode: Any
    state: Any
    status: Any
    tries: Any
    steps: Any
    count: Any
    times: Any  # (chunk,)
    kinds: Any  # (chunk,)
    modes: Any  # (chunk,)
    starts: Any  # (chunk, n)


def prepare(
    hybrid: Hybrid, setting: float, clock: Clock, max_events: int, solver: str, capped: bool = False
) -> Callable:
    """Return a function that runs ``solver`` on the scene at relative tolerance ``setting``; ``capped``: step cap.

    Absolute tolerances are ``setting`` times the sizes of the coordinates. Guards are watched through the least of
    them, relative to their terms, and the event is found by bisection on the solver's interpolation. Where that finds
    none but the start the arc is repeated with smaller steps.
    """
    scene = hybrid.scene
    tables = jax.tree_util.tree_map(jnp.asarray, even_tables(hybrid))
    cap = scene.step_cap if capped else np.inf
    limits = _Limits(*map(jnp.asarray, (scene.duration, setting, setting * scene.scales, cap, scene.step_cap)))
    march, blank = _compiled(solver), jax.tree_util.tree_map(jnp.asarray, _blank(scene.scales.size))

    def run() -> Callable[[], Record]:
        """March chunk after chunk to the end of the scene."""
        clock.start()
        mode, state = hybrid.enter()
        chunks, total, failure = [blank._replace(mode=np.int64(mode), state=np.array(state))], 0, ""
        while not failure:
            chunks.append(jax.block_until_ready(march(tables, limits, chunks[-1], max_events + 1 - total)))
            status, count = int(chunks[-1].status), int(chunks[-1].count)
            total += count
            if status == _Status.DONE:
                break
            failure = _FAILURES.get(status, f"over {max_events} events" if total > max_events else clock.over())
        return lambda: _record(hybrid, chunks, failure)

    return run


def _record(hybrid: Hybrid, marched: list[_March], failure: str) -> Record:
    """What is compared: events, final state, steady amplitude."""
    first, *chunks = (jax.tree_util.tree_map(np.asarray, chunk) for chunk in marched)
    record = Recorder(hybrid, int(first.mode), first.state)
    for chunk in chunks:
        own = slice(int(chunk.count))
        columns = chunk.times[own], chunk.kinds[own], chunk.modes[own], chunk.starts[own]
        for now, kind, mode, start in zip(*columns, strict=True):
            record.add(float(now), int(kind), int(mode), start)
    return record.close(float(chunks[-1].now), chunks[-1].state, failure)()


def _blank(n: int) -> _March:
    """The loop before its first chunk, with the types that it keeps."""
    zero, zeros = np.int64(0), np.zeros(_CHUNK, dtype=np.int64)
    return _March(
        np.float64(0.0), zero, np.zeros(n), zero, zero, zero, zero,
        np.zeros(_CHUNK), zeros, zeros, np.zeros((_CHUNK, n)),
    )  # fmt: skip


def _rate(matrix, constant, state):
    return jnp.sum(matrix * state, axis=-1) + constant


def _affine(rows, state):
    """Values of affine functions and the size of their terms."""
    terms = rows[..., :-1] * state
    return jnp.sum(terms, axis=-1) + rows[..., -1], jnp.sum(jnp.abs(terms), axis=-1) + jnp.abs(rows[..., -1])


def _due(t: EvenTables, mode, state):
    """(whether a guard is negative, or zero and falling; the first of them), as :meth:`Hybrid.due`."""
    matrix, constant, rows = t.matrix[mode], t.constant[mode], t.guards[mode]
    value, terms = _affine(rows, state)
    rate = _rate(matrix, constant, state)
    rate_size = jnp.sum(jnp.abs(matrix * state), axis=-1) + jnp.abs(constant)
    slope, slope_size = jnp.sum(rows[:, :-1] * rate, axis=-1), jnp.sum(jnp.abs(rows[:, :-1]) * rate_size, axis=-1)
    size = ROUNDING * terms
    due = (value < -size) | ((value <= size) & (slope < -ROUNDING * slope_size))
    return jnp.any(due), jnp.argmax(due)


def _fire(t: EvenTables, mode, guard, state, arrived):
    """(new mode, new state, kind, whether a branch fits), as :meth:`Hybrid.fire`."""
    row, snap, transition = t.guards[mode, guard], t.snap[mode, guard], t.transition[mode, guard]
    there = state.at[snap].add(-_affine(row, state)[0] / row[snap])
    state = jnp.where(arrived, there, state)
    state = _affine(t.resets[transition], state)[0]
    value, terms = _affine(t.rows[transition], state)
    size, test = ROUNDING * terms, t.tests[transition]
    fits = jnp.where(test == int(Test.POSITIVE), value > size, value >= -size)
    fits = jnp.where(test == int(Test.ZERO), jnp.abs(value) <= size, fits)
    fits = jnp.all(jnp.where(test == ALWAYS, True, jnp.where(test == NEVER, False, fits)), axis=-1)
    branch = jnp.argmax(fits)
    return t.mode[transition, branch], state, t.kind[transition, branch], jnp.any(fits)


def _field(time, state, mode):
    return _rate(mode[0], mode[1], state)


def _shares(rows, state):
    """Values of affine functions in sizes of their terms."""
    value, terms = _affine(rows, state)
    return value / jnp.maximum(terms, _SMALLEST)


def _least_guard(t, y, args, **_):
    """Least guard in size of its terms; positive at the start, where a guard may be zero and about to rise."""
    return _FAINT * jnp.where(t <= 0.0, 1.0, jnp.min(_shares(args[2], y)))


def _arc(solver, t: EvenTables, limits: _Limits, march: _March):
    """Integrate to the next guard: (time in the arc, state, guard, whether one was met, ok, steps)."""
    mode = (t.matrix[march.mode], t.constant[march.mode], t.guards[march.mode])
    shorter = limits.retry * 0.25**march.tries
    cap = jnp.where(march.tries > 0, jnp.minimum(limits.cap, shorter), limits.cap)
    found = diffrax.diffeqsolve(
        diffrax.ODETerm(_field), solver, 0.0, limits.end - march.now, None, march.state, mode,
        stepsize_controller=diffrax.PIDController(limits.rtol, limits.atol, dtmax=cap),
        event=diffrax.Event(_least_guard, optimistix.Bisection(*_ROOT, flip=True), direction=False),
        adjoint=diffrax.ForwardMode(), max_steps=MOST_STEPS, throw=False,
    )  # fmt: skip
    met = found.result == diffrax.RESULTS.event_occurred
    state = found.ys[-1]
    guard = jnp.argmin(_shares(mode[2], state))
    return found.ts[-1], state, guard, met, met | (found.result == diffrax.RESULTS.successful), found.stats["num_steps"]


def _event(solver, t: EvenTables, limits: _Limits, march: _March) -> _March:
    """One turn of the loop: to the next guard, and through its transition."""
    due, first = _due(t, march.mode, march.state)
    away, state, guard, met, ok, steps = lax.cond(
        due,
        lambda: (jnp.zeros(()), march.state, first, True, True, jnp.zeros_like(march.steps)),
        lambda: _arc(solver, t, limits, march),
    )
    again = met & ~due & (away <= _ROOT[1])
    mode, after, kind, fits = _fire(t, march.mode, guard, state, ~due)
    done = ok & ~met
    status = jnp.where(done, _Status.DONE, jnp.where(fits, _Status.RUNNING, _Status.LOST))
    status = jnp.where(again, jnp.where(march.tries + 1 == RETRIES, _Status.STUCK, _Status.RUNNING), status)
    status = jnp.where(ok, status, _Status.FAILED)
    fired = ok & met & ~again & fits
    now, slot = march.now + away, march.count
    return _March(
        jnp.where(again, march.now, now),
        jnp.where(fired, mode, march.mode),
        jnp.where(fired, after, jnp.where(again, march.state, state)),
        status.astype(march.status.dtype),
        jnp.where(again, march.tries + 1, 0),
        march.steps + steps,
        march.count + fired,
        march.times.at[slot].set(now),
        march.kinds.at[slot].set(kind),
        march.modes.at[slot].set(mode),
        march.starts.at[slot].set(after),
    )


@cache
def _compiled(solver: str) -> Callable:
    """The loop over a chunk of events: (tables, limits, last chunk, events that are left) -> chunk."""
    method = getattr(diffrax, solver)()

    def march(tables: EvenTables, limits: _Limits, last: _March, left) -> _March:
        """March from the last chunk over as many events as a chunk holds, ``left`` at most."""
        most = jnp.minimum(left, _CHUNK)

        def goes_on(march: _March):
            """Tell whether the chunk has room and the motion has not ended."""
            return (march.status == _Status.RUNNING) & (march.count < most) & (march.steps < MOST_STEPS)

        start = last._replace(count=jnp.zeros_like(last.count), steps=jnp.zeros_like(last.steps))
        return lax.while_loop(goes_on, lambda march: _event(method, tables, limits, march), start)

    return jax.jit(march)
