"""This engine, run as its rivals are."""

from collections.abc import Callable

import numpy as np

from benchmarks.judge import Record
from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid, Recorder, counted
from lsvib.errors import EngineError
from lsvib.systems.kernels.layout import Status
from lsvib.systems.motion import Motion, follow


def runner(hybrid: Hybrid, setting: float, clock: Clock, max_events: int) -> Callable:
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
    record = Recorder(hybrid, motion.start_mode, motion.start_state)
    for k in np.flatnonzero(counted(motion.kind)):
        record.add(motion.time[k], int(motion.kind[k]), int(motion.mode[k]), motion.after[k])
    return record.close(motion.end_time, motion.end_state)()
