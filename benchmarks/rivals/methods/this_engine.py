"""This engine, run as its rivals are."""

from collections.abc import Callable

import numpy as np

from benchmarks.record import Record
from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid, arc_extremes, counted
from lsvib.engine.kernels.status import Status
from lsvib.engine.motion import Motion, follow
from lsvib.errors import EngineError


def prepare(hybrid: Hybrid, setting: float, clock: Clock, max_events: int) -> Callable:
    """Return a function that runs the engine on the scene; ``setting`` and ``clock`` are not needed."""
    automaton, state = hybrid.automaton, np.array(hybrid.scene.state)

    def run() -> Callable[[], Record]:
        """Follow the motion by the engine."""
        try:
            motion = follow(automaton, state, hybrid.scene.duration, max_events=max_events)
        except EngineError as error:
            raise GaveUp(str(error)) from None
        if motion.status == Status.EVENTS_FULL:
            raise GaveUp(f"over {max_events} events")
        return lambda: _record(hybrid, motion)

    return run


def _record(hybrid: Hybrid, motion: Motion) -> Record:
    """What is compared: events, final state, steady amplitude."""
    ours = counted(motion.kind)
    modes, starts, _, _ = motion.arcs()
    times, steady_from = [0.0, *motion.time], hybrid.scene.steady_from
    return Record(
        end=motion.end_state,
        times=motion.time[ours],
        kinds=[hybrid.names[int(kind)] for kind in motion.kind[ours]],
        extremes=arc_extremes(motion.automaton, modes, starts, times, motion.end_time, steady_from),
    )
