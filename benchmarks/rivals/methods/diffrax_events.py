"""diffrax with events: each arc to the next guard is compiled; the automaton of :class:`Hybrid` leads to the next one.

Needs jax in double precision and with one thread, which loading this module sees to, for the process. What is compiled
depends on the solver and on the numbers of states and guards only: scenes, tolerances and step caps share it.
"""

import os
from collections.abc import Callable, Sequence
from functools import cache

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

from benchmarks.rivals.hybrid import MOST_STEPS, RETRIES, Clock, GaveUp, Hybrid, HybridMode, Integrate

jax.config.update("jax_enable_x64", True)
# One thread, as all other methods have: run times are processor times, and a second worker of XLA that waits for work
# counts as much as one that works. XLA looks at this variable when the first array is made.
jax.config.update("jax_cpu_enable_async_dispatch", False)
os.environ.setdefault("NPROC", "1")

_ROOT = 1e-15, 1e-17  # relative and absolute [s] tolerance of the time of an event
_FAINT = 1e-18  # factor of the guards: bisection asks for small values too, where only the sign matters
_SMALLEST = 1e-300  # keeps zero by zero out


def integrator(hybrid: Hybrid, setting: float, clock: Clock, solver: str, capped: bool = False) -> Integrate:
    """Return what follows one mode with ``solver`` at relative tolerance ``setting``; ``capped``: step cap.

    Absolute tolerances are ``setting`` times the sizes of the coordinates. Guards are watched through the least of
    them, relative to their terms, and the event is found by bisection on the solver's interpolation. Where that finds
    none but the start the arc is repeated with smaller steps.
    """
    scene, arc = hybrid.scene, _compiled(solver)
    modes = [tuple(map(jnp.asarray, (m.matrix, m.constant, _guards(m)))) for m in hybrid.modes]
    cap, n = scene.step_cap if capped else np.inf, scene.scales.size
    tolerances = jnp.asarray(setting), jnp.asarray(setting * scene.scales)
    for mode in modes:
        arc(mode, tolerances, np.array([*np.zeros(n), 1e-12, cap]))  # compiled here, not in what is timed

    def integrate(mode: int, now: float, state: Sequence[float], end: float):
        for tries in range(RETRIES):
            longest = min(cap, scene.step_cap * 0.25**tries) if tries else cap
            found = np.asarray(arc(modes[mode], tolerances, np.array([*state, end - now, longest]))).tolist()
            away, guard, met, ended, steps = found[n:]
            clock.spend(int(steps))
            if not (met or ended):
                raise GaveUp(f"the solver failed or took over {MOST_STEPS} steps")
            if not met or away > _ROOT[1]:
                return now + away, found[:n], int(guard) if met else None
        raise GaveUp("no step away from a guard")

    return integrate


def _guards(mode: HybridMode) -> np.ndarray:
    """The guards of a mode; one that never falls where there is none."""
    return mode.guards if len(mode.guards) else np.eye(1, mode.constant.size + 1, mode.constant.size)


def _shares(rows, state):
    """Values of affine functions in sizes of their terms."""
    terms = rows[:, :-1] * state
    size = jnp.sum(jnp.abs(terms), axis=-1) + jnp.abs(rows[:, -1])
    return (jnp.sum(terms, axis=-1) + rows[:, -1]) / jnp.maximum(size, _SMALLEST)


def _least_guard(t, y, args, **_):
    """Least guard in size of its terms; positive at the start, where a guard may be zero and about to rise."""
    return _FAINT * jnp.where(t <= 0.0, 1.0, jnp.min(_shares(args[2], y)))


@cache
def _compiled(solver: str) -> Callable:
    """An arc: (mode, tolerances, [state, time, largest step]) -> [state, time, guard, met, came to the end, steps]."""
    method = getattr(diffrax, solver)()

    def arc(mode, tolerances, start):
        """Integrate to the next guard."""
        found = diffrax.diffeqsolve(
            diffrax.ODETerm(lambda t, y, args: args[0] @ y + args[1]), method, 0.0, start[-2], None, start[:-2], mode,
            stepsize_controller=diffrax.PIDController(*tolerances, dtmax=start[-1]),
            event=diffrax.Event(_least_guard, optimistix.Bisection(*_ROOT, flip=True), direction=False),
            adjoint=diffrax.ForwardMode(), max_steps=MOST_STEPS, throw=False,
        )  # fmt: skip
        met, ended = (found.result == x for x in (diffrax.RESULTS.event_occurred, diffrax.RESULTS.successful))
        end = found.ys[-1]
        rest = found.ts[-1], jnp.argmin(_shares(mode[2], end)), met, ended, found.stats["num_steps"]
        return jnp.concatenate([end, jnp.stack([jnp.asarray(x, dtype=float) for x in rest])])

    return jax.jit(arc)
