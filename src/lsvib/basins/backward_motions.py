"""Motions of the rigid drive followed backwards in time: on to the cycle on which they wind, and as arcs forward."""

import math

import numpy as np

from lsvib.basins.curves import Arc
from lsvib.dynamics import drift_two_states
from lsvib.dynamics.attractors import steady_state
from lsvib.dynamics.return_map import ReturnSection
from lsvib.dynamics.return_section import section_key
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import layout
from lsvib.engine.kernels.layout import Status
from lsvib.engine.motion import Motion, follow
from lsvib.errors import EngineError, InputError
from lsvib.models.drive import RigidDrive
from lsvib.models.rigid import MotionMode

_EVENTS = 32  # of a motion backwards, after which its return map is looked at
_ROUNDS = 200  # of _EVENTS events each, about half a second, after which turns that hardly grow are leapt over
_LEAPS = 4  # leaps and rounds in turn, after which the boundary is given up: each leap ends where the events change
_PATIENCE = 10.0  # time that a turn may take after a leap, in times of the longest turn seen
_FAR = 1e9  # growth of the turns after which they grow for ever: the constants of the drive are 1e-9 of the state
_CLOSED = 1e-9  # relative gap of an orbit that is closed
_BRIEF = 1e-3  # shortest turn, in time scales of slip; a turn has about 2π of them


def wind_up(drive: RigidDrive, back: Automaton, state, mode: int) -> Motion | None:
    """Return one turn of the cycle on to which a motion backwards winds; None if it grows or does not come back.

    The turns only grow (docs/basin.md). Once they have grown by ``_FAR`` the constants of the drive no longer count:
    each turn is in proportion to the one before, so they grow for ever. Turns that hardly grow, as with little damping,
    are leapt over along their return map (:mod:`lsvib.dynamics.drift_two_states`).
    """
    start = state = np.array(state, dtype=float)
    scale = back.tables.flow[mode, layout.TIME_SCALE]
    for _ in range(_LEAPS):
        for _ in range(_ROUNDS):
            trace = traced(back, state, mode, _EVENTS)
            if (
                trace is None
                or trace.status == Status.SETTLED
                or np.abs(trace.after).max() > _FAR * np.abs(start).max()
            ):
                return None
            state, mode = trace.end_state, trace.end_mode
            found = steady_state(back, state, mode=mode, max_events=1)
            # An event that recurs at once is not a turn.
            if found.orbit is not None and found.residual < _CLOSED and found.period > _BRIEF * found.returns * scale:
                once = found.orbit.time.size // found.returns
                return follow(back, found.orbit.start_state, math.inf, mode=found.orbit.start_mode, max_events=once)
        section = _section(trace)
        leap = None if section is None else drift_two_states.drift(section, _FAR)
        if leap is None:
            break
        if leap.end == drift_two_states.End.GROWS:
            return None
        state, mode = section.state(np.array([leap.place])), section.key[1]
        if leap.end == drift_two_states.End.CLOSES:
            return follow(back, state, math.inf, mode=mode, stop=section.key, max_events=_EVENTS)
    raise InputError(
        f"support_damping = {drive.support_damping:g} and translation_damping = {drive.translation_damping:g} change a "
        "motion so little in a turn that the boundary of the basin cannot be followed to its end."
    )


def _section(trace: Motion) -> ReturnSection | None:
    """Return the section of the rarest events of a motion backwards, at its last return; None if it is no line."""
    key = section_key(trace)
    if key is None:
        return None
    there = np.flatnonzero((trace.kind == key[0]) & (trace.mode == key[1]))
    longest = np.diff(trace.time[there]).max(initial=0.0)
    size = np.abs(trace.after).max(axis=0)
    section = ReturnSection(trace.automaton, key, trace.after[there[-1]], size, 1, _PATIENCE * longest)
    return section if section.dimension == 1 else None


def traced(back: Automaton, state: np.ndarray, mode: int, events: int) -> Motion | None:
    """Follow a motion backwards over some events; None if it leaves the range of numbers, as it does far away."""
    try:
        return follow(back, state, math.inf, mode=mode, max_events=events)
    except EngineError:
        return None


def forward_arcs(trace: Motion, drive_forward: Automaton) -> list[Arc]:
    """Return the arcs of a motion backwards as arcs forward in time, the earliest first; none has zero duration."""
    codes = drive_forward.codes.tolist()
    turned = np.array([1.0, -1.0])
    return [
        Arc(codes.index(trace.automaton.codes[mode]), end * turned, start * turned, float(duration))
        for mode, start, end, duration in zip(*trace.arcs(), strict=True)
        if duration > 0
    ][::-1]


def mode_index(automaton: Automaton, mode: MotionMode) -> int:
    """Return the place of a mode in the tables of an automaton."""
    return automaton.codes.tolist().index(int(mode))
