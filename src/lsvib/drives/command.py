"""A commanded speed that changes with time, straight between given points: ramps, stays, and jumps.

In each piece Ω(t) = Ω_0 + α t by a clock that begins anew, so that the equations are those of a constant command with
time as one more state (:mod:`lsvib.drives.mechanism`). The pieces of one automaton follow each other: a mode has a copy
in each of them, and the end of a piece is an event like any other.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from lsvib.drives.complaints import Checked
from lsvib.drives.drive import Number
from lsvib.drives.names import Event
from lsvib.errors import InputError
from lsvib.systems.automaton import Branch, Guard, Surface, Transition

Values = Annotated[  # a thousand take ten seconds
    tuple[Number, ...],
    BeforeValidator(lambda given: given.tolist() if isinstance(given, np.ndarray) else given),
    Field(min_length=2, max_length=1000),
]


class Command(Checked):
    """The commanded speed of the motor, ``speeds`` [rad/s] at ``times`` [s] and straight between them.

    Before the first and after the last time it is constant; it jumps where a time stands twice.

    >>> Command(times=[0, 0.2, 1, 1.5], speeds=[0, 40, 40, 0]).at([0.1, 2.0])
    array([20.,  0.])
    """

    _about = "command: "

    times: Values
    speeds: Values

    def model_post_init(self, context: Any) -> None:
        """Check what couples times and speeds."""
        times = np.array(self.times)
        if len(self.speeds) != times.size:
            raise InputError(f"command has {times.size} times and {len(self.speeds)} speeds; give one for each.")
        if times[0] < 0 or times[-1] > 1e9 or (np.diff(times) < 0).any() or (times[2:] == times[:-2]).any():
            raise InputError("command.times must ascend within 0 <= time <= 1e9 s, with no time more than twice.")
        if np.abs(self.speeds).max() > 1e9:
            raise InputError("command.speeds has a speed outside the allowed range -1e9 <= speed <= 1e9 rad/s.")

    def pieces(self) -> Iterator[tuple[float, float, float]]:
        """Yield duration [s], speed at the start [rad/s] and its rate [rad/s²] of each piece; the last has no end."""
        if self.times[0] > 0:
            yield self.times[0], self.speeds[0], 0.0
        for k, duration in enumerate(np.diff(self.times).tolist()):
            if duration > 0:
                yield duration, self.speeds[k], (self.speeds[k + 1] - self.speeds[k]) / duration
        yield np.inf, self.speeds[-1], 0.0

    def angle(self, times: Any) -> np.ndarray:
        """Return the commanded angle [rad] at times [s], from zero at t = 0."""
        begun, found = 0.0, np.zeros(np.shape(times))
        for duration, speed, rate in self.pieces():
            stay = np.clip(times - begun, 0.0, duration)
            found, begun = found + stay * (speed + 0.5 * rate * stay), begun + duration
        return found

    def at(self, times: Any) -> np.ndarray:
        """Return the commanded speed [rad/s] at times [s]; at a jump, that after it."""
        return np.asarray(np.interp(times, self.times, self.speeds))  # which takes the last of two equal times


def one_after_the_other(pieces: Sequence[tuple[Mapping[str, Any], float]]) -> dict[str, Any]:
    """Join what automata are made of (:func:`lsvib.systems.automaton.assemble`), each for a duration [s]."""
    n = len(pieces[0][0]["states"])
    identity = np.eye(n, n + 1).astype(int).tolist()
    again = tuple(map(tuple, (*identity[:-1], [0] * (n + 1))))
    whole: dict[str, Any] = {
        **pieces[0][0],
        "shortest_stay": min(layout["shortest_stay"] for layout, _ in pieces),
        **{name: {} for name in ("surfaces", "modes", "transitions", "observables", "parts")},
    }
    for k, (layout, duration) in enumerate(pieces):
        for name in ("observables", "parts"):
            for of, rows in layout[name].items():
                whole[name].setdefault(of, {}).update({f"{mode} {k}": row for mode, row in rows.items()})
        whole["surfaces"] |= {f"{name} {k}": surface for name, surface in layout["surfaces"].items()}
        for name, transition in layout["transitions"].items():
            if k == 0 or name != "entry":
                branches = tuple(branch._replace(mode=f"{branch.mode} {k}") for branch in transition.branches)
                whole["transitions"][f"{name} {k}"] = replace(transition, branches=branches)
        if ends := duration < np.inf:
            whole["surfaces"][f"end {k}"] = Surface((*(0 for _ in range(n - 1)), -1, duration), n - 1)
        for name, mode in layout["modes"].items():
            guards = [Guard(f"{g.surface} {k}", g.sign, f"{g.transition} {k}") for g in mode.guards]
            if ends:
                onward = Branch(f"{name} {k + 1}", Event.COMMAND)
                whole["transitions"][f"end of {name} {k}"] = Transition((onward,), reset=again)
                guards.append(Guard(f"end {k}", 1, f"end of {name} {k}"))
            whole["modes"][f"{name} {k}"] = replace(mode, guards=tuple(guards))
    return whole
