"""This engine; and the same with its tables rounded to single precision."""

from collections.abc import Callable

import numpy as np

from lsvib.bench.record import Run
from lsvib.bench.rivals.hybrid import Clock, GaveUp, Hybrid, arc_extremes, counted
from lsvib.engine.kernels.status import Status
from lsvib.engine.kernels.tables import Tables
from lsvib.engine.motion import Motion, follow
from lsvib.errors import EngineError


class _Followed:
    def __init__(self, hybrid: Hybrid, motion: Motion) -> None:
        self.hybrid, self.motion = hybrid, motion

    def run(self) -> Run:
        """Return what is compared: events, final state, steady amplitude."""
        motion, scene = self.motion, self.hybrid.scene
        ours = counted(motion.kind)
        modes, starts, _, _ = motion.arcs()
        times = [0.0, *motion.time]
        return Run(
            end_state=motion.end_state,
            times=motion.time[ours],
            kinds=[self.hybrid.names[int(kind)] for kind in motion.kind[ours]],
            extremes=arc_extremes(motion.automaton, modes, starts, times, motion.end_time, scene.window),
        )


def prepare(hybrid: Hybrid, setting: float, clock: Clock, max_events: int, single: bool = False) -> Callable:
    """Return a function that runs the engine on the scene; ``single``: with tables and start rounded to float32.

    The rounded tables are computed with in double precision, so its error is the least that a float32 engine has: it
    has no digits to spare. (In single precision throughout it exists for maps:
    :mod:`lsvib.bench.maps.single_precision`.)
    """
    automaton, state = hybrid.automaton, np.array(hybrid.scene.state)
    if single:
        automaton = type(automaton)(**{**vars(automaton), "tables": _rounded(automaton.tables)})
        state = state.astype(np.float32).astype(float)

    def run() -> _Followed:
        """Follow the motion by the engine."""
        try:
            motion = follow(automaton, state, hybrid.scene.duration, max_events=max_events)
        except EngineError as error:
            raise GaveUp(str(error)) from None
        if motion.status == Status.EVENTS_FULL:
            raise GaveUp(f"over {max_events} events")
        return _Followed(hybrid, motion)

    return run


def _rounded(tables: Tables) -> Tables:
    def round_floats(value):
        """Return an array of floats rounded to single precision, also within tuples; anything else as it is."""
        if isinstance(value, tuple):
            return type(value)(*map(round_floats, value))
        real = isinstance(value, np.ndarray) and value.dtype.kind == "f"
        return value.astype(np.float32).astype(float) if real else value

    return tables._replace(**{name: round_floats(value) for name, value in tables._asdict().items()})
