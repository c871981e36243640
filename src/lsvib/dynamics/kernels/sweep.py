"""Where motions of many drives with the same parts end, by the rule of :mod:`lsvib.systems.kernels.attractor`."""

import math
from typing import NamedTuple

import numpy as np
from numba import types

from lsvib.systems.kernels import event_loop
from lsvib.systems.kernels.attractor import Asked, Found, Records, end_of
from lsvib.systems.kernels.jit import by_address, entry, kernel, on_stack
from lsvib.systems.kernels.layout import Tables
from lsvib.systems.kernels.machine import Machine, extremes_at
from lsvib.systems.kernels.single_mode import Outcome

NUMBERS = np.dtype([(name, np.float64) for name in ("amplitude", "period", "peak_normal_force", "peak_normal_impulse")])
end_of_at = by_address(end_of, types.int64)
SPRAGS, STICKS, REVERSES = 1, 2, 4  # bits that say what happens on a cycle


class Rule(NamedTuple):
    """How motions are followed: the address of ``end_of``, the engine, what is asked, work for each in events, room.

    ``extremes``: addresses of ``machine.extremes`` and of what it calls.
    """

    address: int
    extremes: tuple[int, int]
    engine: Machine
    asked: Asked
    work: float
    records: Records
    found: Found


class Drives(NamedTuple):
    """Many drives: tables of one, and what differs from drive to drive, which is written into them in its turn."""

    tables: Tables
    row: np.ndarray  # (bytes,) in which the tables have all numbers of a drive but the last
    rows: np.ndarray  # (k, bytes) those of each drive
    shortest_stay: np.ndarray  # (k,) the last
    starts: np.ndarray  # (k, n)
    force: np.ndarray  # (k, m, n + 1 or 2 n + 2) normal force as an observable
    angle: np.ndarray  # (m, n + 1) the deviation u as an observable
    impulse: np.ndarray  # (k, n) by which the state jumps in a seizure [N s] for each unit of it


class Answers(NamedTuple):
    """What is filled for each drive."""

    outcomes: np.ndarray  # (k,)
    bits: np.ndarray  # (k,) what happens on a cycle
    numbers: np.ndarray  # (k,) of ``NUMBERS``
    slopes: np.ndarray  # (k, n, n) P′ of the return map, zero beyond its dimension


@kernel
def _describe(tables, rule, reversal, drives, k, numbers, slopes):
    """Write the numbers of a cycle, a period of which is on record; returns the bits of what happens on it.

    ``reversal``: kind of an event that reverses the contact force; ``k``, the number of the drive.
    """
    (times, kinds, _, modes, before, after), other, found = rule.records.one, rule.records.other, rule.found
    facts, note, n = rule.asked.facts, found.notes[0], found.state.size
    count, mode, time, hardest = note["events"], note["mode"], 0.0, 0.0
    at, starts, stays = other.mode[:count], other.before[:count], other.time[:count]  # room that is free by now
    bits = STICKS if facts.sticks[mode] else 0
    for i in range(count):
        at[i], stays[i] = mode, times[i] - time
        for x in range(n):
            starts[i, x] = after[i - 1, x] if i else found.state[x]
        time, mode = times[i], modes[i]
        bits |= (STICKS if facts.sticks[mode] else 0) | (REVERSES if kinds[i] == reversal else 0)
        bits |= SPRAGS if facts.sprag_kinds[kinds[i]] or facts.sprag_modes[mode] else 0
        if facts.sprag_kinds[kinds[i]]:
            impulse = 0.0
            for x in range(n):
                impulse += drives.impulse[k, x] * (before[i, x] - after[i, x])
            hardest = max(hardest, abs(impulse))
    address, inner = rule.extremes
    low, high = extremes_at(address, inner, tables.flow, at, starts, stays, drives.angle)
    least, most = extremes_at(address, inner, tables.flow, at, starts, stays, drives.force[k])
    numbers["period"], numbers["peak_normal_impulse"] = time, hardest
    bounded = math.isfinite(low + high + least + most)
    numbers["amplitude"] = 0.5 * (high - low) if bounded else math.nan
    numbers["peak_normal_force"] = max(abs(least), abs(most)) if bounded else math.nan
    for i in range(note["dimension"]):
        for j in range(note["dimension"]):
            slopes[i, j] = found.slopes[i, j]
    return bits


@entry
def ends_of_many(rule, drives, members, reversal, answers):
    """Follow the motions of many drives, each from its own start; ``members`` (j) are those that are wanted."""
    found, (outcomes, bits, numbers, slopes) = rule.found, answers
    n = drives.starts.shape[1]
    state, scale = on_stack(n), on_stack(n)
    for k in members:
        for i in range(drives.row.size):
            drives.row[i] = drives.rows[k, i]
        tables = Tables(*drives.tables[:-1], drives.shortest_stay[k])
        for i in range(n):
            state[i], scale[i] = drives.starts[k, i], abs(drives.starts[k, i])
        found.notes[0]["left"], bits[k] = rule.work, 0
        branch = event_loop.choose_branch(tables, 0, state, scale)
        outcomes[k] = Outcome.OPEN
        if branch >= 0:
            mode = tables.branch_mode[branch]
            outcomes[k] = end_of_at(rule.address, rule.engine, tables, rule.asked, mode, state, rule.records, found)
        if outcomes[k] == Outcome.CYCLE:
            bits[k] = _describe(tables, rule, reversal, drives, k, numbers[k], slopes[k])
