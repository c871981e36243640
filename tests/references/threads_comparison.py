"""The comparison of an engine's motion with compliant threads with that of a reference in many digits."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from mpmath import mpf

from lsvib.drives.parameters import ThreadsParameters
from lsvib.drives.threads import ThreadsEvent, ThreadsMode, threads_automaton
from lsvib.engine.motion import Motion, follow
from references.threads_digits import ThreadsTruth

STATE_TOLERANCE = 1e-9  # of the size of each coordinate's motion, as the project demands
TIME_TOLERANCE = 1e-12  # s


class Comparison(NamedTuple):
    """A motion and the reference's; kinds are pairs of event and mode after it."""

    motion: Motion
    reference: ThreadsTruth
    kinds: list[tuple[str, str]]
    reference_kinds: list[tuple[str, str]]
    time_error: float  # s
    state_error: float  # of the size of each coordinate's motion

    @property
    def modes(self) -> set[str]:
        """Names of the modes that were visited."""
        return {mode for _, mode in self.kinds} | {_names(self.motion)[self.motion.start_mode]}

    def faults(self, name: str) -> list[str]:
        """Return what differs: the events, and times or final state by more than the tolerances; print how far off."""
        print(f"{name}: {len(self.kinds)} events, {self.time_error:.1e} s, state {self.state_error:.1e}")
        found = {
            f"events {self.kinds}, not {self.reference_kinds}": self.kinds != self.reference_kinds,
            f"times by {self.time_error} s": not self.time_error <= TIME_TOLERANCE,
            f"state by {self.state_error}": not self.state_error <= STATE_TOLERANCE,
        }
        return [f"{name}: {words}" for words, differs in found.items() if differs]


def compare(drive: ThreadsParameters, start, t_end: float, simulate: Callable[..., ThreadsTruth]) -> Comparison:
    """Follow a motion with the engine and with a reference."""
    reference = simulate(dict(drive), start, t_end)
    motion = follow(threads_automaton(drive), start, t_end, max_events=10_000)
    names = _names(motion)
    kinds = [(ThreadsEvent(k).name.lower(), names[m]) for k, m in zip(motion.kind, motion.mode, strict=True)]
    pairs = zip(motion.time, reference.events, strict=False)
    late = max((abs(float(mpf(float(t)) - event.time)) for t, event in pairs), default=0.0)
    passed = [start, *(event.state for event in reference.events), reference.state]
    size = np.abs(np.array(passed, dtype=float)).max(axis=0)
    gap = [abs(float(mpf(float(x)) - y)) for x, y in zip(motion.end_state, reference.state, strict=True)]
    theirs = [(event.kind, event.mode_after) for event in reference.events]
    return Comparison(motion, reference, kinds, theirs, late, float(np.max(np.array(gap) / size)))


def _names(motion: Motion) -> list[str]:
    return [ThreadsMode(int(code)).name.lower() for code in motion.automaton.codes]
