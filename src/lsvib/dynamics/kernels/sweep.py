"""Where motions of many drives with two states end, by the rule of :mod:`lsvib.dynamics.kernels.attractor`."""

import math
from typing import NamedTuple

import numpy as np

from lsvib.dynamics.kernels.attractor import NOTES, Asked, Found, Records, end_of
from lsvib.dynamics.kernels.machine import AnyFlow, Machine
from lsvib.dynamics.kernels.single_mode import Outcome
from lsvib.engine.kernels import event_loop, search_planar
from lsvib.engine.kernels.jit import allocating_entry, allocating_kernel, by_address
from lsvib.engine.kernels.layout import Tables

NUMBERS = np.dtype([(name, np.float64) for name in ("amplitude", "period", "multiplier", "force", "seizure_speed")])
end_of_at = by_address(end_of)
SPRAGS, RESTS, REVERSES = 1, 2, 4  # bits that say what happens on a cycle


@allocating_kernel
def _describe(tables, rule, reversal, found, force, speed, numbers):
    """Write the numbers of a cycle, a period of which is on record; returns the bits of what happens on it.

    ``reversal``: kind of an event that reverses the contact force; ``force`` (m, 3), that observable; ``speed`` [rad/s]
    of the motor.
    """
    times, kinds, _, modes, before, after = rule.records.one
    facts = rule.asked.facts
    count, mode, time, state, row = found.notes[0]["events"], found.notes[0]["mode"], 0.0, np.empty(2), np.zeros(3)
    low, high, least, most, fastest = math.inf, -math.inf, math.inf, -math.inf, 0.0
    row[0] = 1.0
    state[0], state[1] = found.state[0], found.state[1]
    bits = RESTS if facts.rests[mode] else 0
    for k in range(count):
        a, b = search_planar.extremes(tables.flow.planar, mode, state, row, times[k] - time)
        low, high = min(low, a), max(high, b)
        a, b = search_planar.extremes(tables.flow.planar, mode, state, force[mode], times[k] - time)
        least, most = min(least, a), max(most, b)
        time, mode, state[0], state[1] = times[k], modes[k], after[k, 0], after[k, 1]
        bits |= (RESTS if facts.rests[mode] else 0) | (REVERSES if kinds[k] == reversal else 0)
        if facts.sprag_kinds[kinds[k]]:
            bits |= SPRAGS
            fastest = max(fastest, abs(speed + before[k, 1]))
    numbers["period"], numbers["seizure_speed"] = time, fastest
    numbers["multiplier"] = found.slopes[0, 0] if found.notes[0]["dimension"] > 0 else 0.0
    bounded = math.isfinite(low + high + least + most)
    numbers["amplitude"] = 0.5 * (high - low) if bounded else math.nan
    numbers["force"] = max(abs(least), abs(most)) if bounded else math.nan
    return bits


class Rule(NamedTuple):
    """How motions are followed: the address of ``end_of``, the engine, what is asked, work for each in events, room."""

    address: int
    engine: Machine
    asked: Asked
    work: float
    records: Records


class Drives(NamedTuple):
    """Many drives: tables whose doubles have a first axis (k) for them, and what differs from drive to drive."""

    tables: Tables
    starts: np.ndarray  # (k, 2)
    force: np.ndarray  # (k, m, 3) normal force as an observable
    speed: np.ndarray  # (k,) [rad/s]


class Answers(NamedTuple):
    """What is filled for each drive."""

    outcomes: np.ndarray  # (k,)
    bits: np.ndarray  # (k,) what happens on a cycle
    numbers: np.ndarray  # (k,) of ``NUMBERS``


@allocating_entry
def ends_of_many(rule, drives, members, reversal, answers):
    """Follow the motions of many drives, each from its own start; ``members`` (j) are those that are wanted."""
    many, (outcomes, bits, numbers) = drives.tables, answers
    found = Found(np.zeros(1, dtype=NOTES), np.zeros(2), np.zeros((2, 2)))
    state, scale = np.empty(2), np.empty(2)
    for k in members:
        tables = Tables(
            flow=AnyFlow(many.flow.planar[k], many.flow.modal, many.flow.taylor),
            surfaces=many.surfaces[k],
            snap=many.snap,
            guard_start=many.guard_start,
            guard_surface=many.guard_surface,
            guard_sign=many.guard_sign,
            guard_transition=many.guard_transition,
            guard_parts=many.guard_parts[k],
            transition_reset=many.transition_reset,
            resets=many.resets[k],
            branch_start=many.branch_start,
            branch_mode=many.branch_mode,
            branch_kind=many.branch_kind,
            branch_sign=many.branch_sign,
            condition_start=many.condition_start,
            condition_row=many.condition_row[k],
            condition_test=many.condition_test,
            beyond_accumulation=many.beyond_accumulation,
            shortest_stay=many.shortest_stay[k],
        )
        for i in range(2):
            state[i], scale[i] = drives.starts[k, i], abs(drives.starts[k, i])
        found.notes[0]["left"], bits[k] = rule.work, 0
        branch = event_loop.choose_branch(tables, 0, state, scale)
        outcomes[k] = Outcome.OPEN
        if branch >= 0:
            mode = tables.branch_mode[branch]
            outcomes[k] = end_of_at(rule.address, rule.engine, tables, rule.asked, mode, state, rule.records, found)
        if outcomes[k] == Outcome.CYCLE:
            bits[k] = _describe(tables, rule, reversal, found, drives.force[k], drives.speed[k], numbers[k])
