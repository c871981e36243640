"""What the motions of many drives with the same parts end on, attractor, size, forces, and what the drives do by that.

Every motion is asked of the one rule (:mod:`lsvib.systems.attractor`), block by block in one call of it compiled, with
tables made at once in arrays; drives whose tables these do not hold to 1e-12 are followed one by one. No number depends
on how the drives are shared out.

What a drive does, in one word, up to three motions tell. One starts next to steady sliding, where only its stability
counts; one far away on θ′ = 0, from where the screw is pulled forward. If the first ends in steady sliding and the
second on a cycle, both coexist. Then, and wherever static friction is above that of sliding, the drive is also started
from rest: the screw stands with the coupling relaxed, and the motor begins to turn. Nothing else is taken from the
equations of the drive: no threshold, no sign of a coefficient.
"""

import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from enum import IntEnum
from types import SimpleNamespace
from typing import Any

import numpy as np

from lsvib.drives import mechanics
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import STATIC, Drive
from lsvib.drives.many import Group, ManyDrives, groups
from lsvib.drives.model import model_of
from lsvib.drives.names import Event
from lsvib.dynamics.impulses import balances, event_impulses
from lsvib.dynamics.kernels import sweep as kernels
from lsvib.dynamics.kernels.sweep import REVERSES, SPRAGS, STICKS
from lsvib.errors import EngineError
from lsvib.numbers import Progress
from lsvib.systems.attractor import Attractor, KnownCycles, conserves, largest, new_found, records, steady_state
from lsvib.systems.automaton import Automaton
from lsvib.systems.kernels import jit, layout
from lsvib.systems.kernels.attractor import end_of
from lsvib.systems.kernels.layout import Tables
from lsvib.systems.kernels.single_mode import Outcome
from lsvib.systems.machine import extremes_of, machine_for, of_one_type
from lsvib.systems.motion import engine_for, enter

Starts = Mapping[str, np.ndarray | float]
WORK = 300_000.0  # events that a motion may take
_WITHOUT_NUMBERS = (Attractor.UNRESOLVED, Attractor.UNBOUNDED)
# What a motion ends on; not a number where it has no such number.
ENDING = np.dtype(
    [
        ("attractor", np.int8),  # of :class:`lsvib.systems.attractor.Attractor`
        ("happens", np.int8),  # on a cycle: the sum of those of SPRAGS, STICKS and REVERSES that do
        ("amplitude", float),  # [rad] half the peak-to-peak of u
        ("period", float),  # [s]
        ("multiplier", float),  # [1] of the return map, the largest
        ("peak_normal_force", float),  # [N] largest |N| without the impulses of seizures
        ("peak_normal_impulse", float),  # [N s] largest |J_N| of a seizure, 0 without
    ]
)


def _unknown(size: int) -> np.recarray:
    return np.array([(Attractor.UNRESOLVED, 0, *(math.nan,) * 5)] * size, dtype=ENDING).view(np.recarray)


def ending_of(drive: Drive, automaton: Automaton, state: np.ndarray) -> Any:
    """Return what the motion of a drive from a state (n) ends on."""
    (ending,), found = _unknown(1), steady_state(automaton, state)
    orbit, ending.attractor = found.orbit, found.label
    if found.label in _WITHOUT_NUMBERS or (orbit is None and found.label == Attractor.NEUTRAL_FAMILY):
        return ending
    ending.amplitude = ending.peak_normal_impulse = 0.0
    if orbit is None:
        mode, _ = enter(automaton, found.state)
        ending.peak_normal_force = abs(automaton.observe("normal_force", found.state[None], np.array([mode]))[0])
        return ending
    try:
        extremes = found.extremes(automaton.functional("normal_force"))
        ending.amplitude, ending.peak_normal_force = found.amplitude, max(map(abs, extremes))
    except EngineError:  # the rates of a mode lie too far apart to find the extremes
        ending.amplitude = np.nan
    ending.happens = (
        SPRAGS * (found.label == Attractor.SPRAG_SLIP_CYCLE)
        + STICKS * bool(automaton.marked(automaton.codes[orbit.arcs()[0]], "rest", "held").any())
        + REVERSES * bool((orbit.kind == Event.CONTACT_REVERSAL).any())
    )
    if automaton.marked(orbit.kind, "impact").any():
        ending.peak_normal_impulse = np.abs(event_impulses(drive, orbit).normal).max()
    ending.period, ending.multiplier = found.period, found.multiplier
    return ending


def all_endings(
    drives: ManyDrives, starts: Starts | None, workers: int = 1, progress: Progress | None = None
) -> np.recarray:
    """Return what motions of drives with the same parts (k) end on, an ``ENDING`` each (k).

    Each has its own start: values or arrays (k) of u [rad], w [rad/s] and other states by their keys, by default as in
    steady sliding. Without ``starts`` that is rest: the screw stands with the coupling relaxed, and the motor begins to
    turn.

    A motion depends on nothing but its own drive and start: no number depends on ``workers``, the number of threads.
    ``progress`` is called with the numbers of motions done and in all.
    """
    found, is_open = endings_at_once(drives, starts, workers, progress)
    own = {key: np.broadcast_to(value, (drives.size,)) for key, value in (starts or {}).items()}
    for done, place in enumerate(np.flatnonzero(is_open).tolist(), drives.size - is_open.sum() + 1):
        drive, automaton, model = drives.one(place), None, model_of(drives.one(place))
        with suppress(EngineError):  # rates that lie too far apart: nothing can be determined
            automaton = automaton_of(drive)
        if automaton is not None:
            given = {key: float(column[place]) for key, column in own.items()}
            start = model.initial_state(drive, model.from_rest(drive) if starts is None else given)
            found[place] = ending_of(drive, automaton, start)
        if progress is not None:
            progress(done, drives.size)
    return found


def endings_at_once(
    drives: ManyDrives, starts: Starts | None, workers: int = 1, progress: Progress | None = None
) -> tuple[np.recarray, np.ndarray]:
    """Return what motions of drives (k) end on, and which must be followed alone (k); arguments of :func:`all_endings`.

    Those are the ones of drives whose tables are not safe in doubles, or without any damping, and what does not end in
    steady sliding or on a cycle.
    """
    found, is_open = _unknown(drives.size), np.ones(drives.size, dtype=bool)
    # drives whose tables are made at once: half a gigabyte of numbers for all of a long sweep would be too many
    size = max(1, min(1024 if drives.one(0).parts else 8192, -(-drives.size // workers)))
    blocks = [np.arange(first, min(first + size, drives.size)) for first in range(0, drives.size, size)]

    def fill(block: np.ndarray) -> int:
        """Write what the motions of a block end on; returns how many are done."""
        for group in groups(drives, block):
            states = np.array(group.standing if starts is None else group.seated)
            for name, value in (starts or {}).items():
                column = np.broadcast_to(value, (drives.size,))[group.members]
                states[:, group.automaton.states.index(name)] = column
            closed, endings = _group_endings(drives, group, states)
            found[group.members[closed]] = endings[closed]
            is_open[group.members[closed]] = False
        return int((~is_open[block]).sum())

    done = 0
    with ThreadPoolExecutor(workers) as pool:
        for count in pool.map(fill, blocks):
            done += count
            if progress is not None and count:
                progress(done, drives.size)
    return found, is_open


def _group_endings(drives: ManyDrives, group: Group, starts: np.ndarray) -> tuple[np.ndarray, np.recarray]:
    """Return which motions of a group (j), from ``starts`` (j, n), are done, and what these end on."""
    automaton, size, n = group.automaton, group.members.size, starts.shape[1]
    found, done = _unknown(size), group.safe & ~conserves(automaton) & (not automaton.stands)
    if automaton.contracts:
        _slide(group, done, found)
        return done, found
    own = {name: column[group.members] for name, column in drives.values.items()}
    axial, torque = balances(own, automaton.states)
    along, across = np.cos(own["lead_angle"])[:, None], (np.sin(own["lead_angle"]) / own["pitch_radius"])[:, None]
    answers = kernels.Answers(
        outcomes=np.full(size, Outcome.OPEN, dtype=np.int8),
        bits=np.zeros(size, dtype=np.int8),
        numbers=np.full(size, np.nan, dtype=kernels.NUMBERS),
        slopes=np.zeros((size, n, n)),
    )
    one, row, rows = _in_rows(automaton.tables)
    members = kernels.Drives(
        tables=of_one_type(one),
        row=row,
        rows=rows,
        shortest_stay=np.asarray(automaton.tables.shortest_stay),
        starts=starts,
        force=automaton.functional("normal_force"),
        angle=np.tile(np.eye(1, n + 1), (len(automaton.codes), 1)),
        impulse=axial * along - torque * across,
    )
    followed, reverses = np.flatnonzero(done), np.int64(Event.CONTACT_REVERSAL)
    asked = KnownCycles.of((), automaton, 0).asked
    asked = asked._replace(facts=asked.facts._replace(conserves=False))
    engine, room, counts = machine_for(one, engine_for(one)), records(n), new_found(n, WORK)
    address = jit.address(end_of, engine, members.tables, asked, 0, np.zeros(n), room, counts)
    rule = kernels.Rule(address, extremes_of(one), engine, asked, WORK, room, counts)
    kernels.ends_of_many(rule, members, followed, reverses, answers)
    outcomes = answers.outcomes
    _slide(group, outcomes == Outcome.SLIDES, found)
    cycles = outcomes == Outcome.CYCLE
    found.happens[:] = answers.bits
    bits = answers.bits[cycles]
    labels = np.where(bits & STICKS, Attractor.STICK_SLIP_CYCLE, Attractor.OTHER_CYCLE)
    found.attractor[cycles] = np.where(bits & SPRAGS, Attractor.SPRAG_SLIP_CYCLE, labels)
    for name in kernels.NUMBERS.names or ():
        found[name][cycles] = answers.numbers[name][cycles]
    found.multiplier[cycles] = largest(answers.slopes[cycles])
    return np.isin(outcomes, (Outcome.SLIDES, Outcome.CYCLE, Outcome.SPENT, Outcome.SPENT_STEADILY)), found


def _in_rows(many: Tables) -> tuple[Tables, np.ndarray, np.ndarray]:
    """Return tables of one drive whose numbers stand in a row of bytes, that row, and the rows of all (k, bytes)."""
    flow, stays = many.flow, np.asarray(many.shortest_stay)
    parts = {} if isinstance(flow, np.ndarray) else flow._asdict()
    names = [name for name in layout.DIMENSIONS if name not in ("shortest_stay", "flow" if parts else "")]
    own = {name: getattr(many, name) for name in names} | parts
    kind = np.dtype([(name, table.dtype, table.shape[1:]) for name, table in own.items()], align=True)
    rows = np.empty(len(many.surfaces), kind)
    for name, table in own.items():
        rows[name] = table
    row = rows[:1].copy()
    split = {name: row[name][0] for name in names}
    if parts:
        split["flow"] = type(flow)(*(row[name][0] for name in parts))
    one = many._replace(shortest_stay=float(stays[0]), **split)
    return one, row.view(np.uint8), rows.view(np.uint8).reshape(rows.size, -1)


def _slide(group: Group, here: np.ndarray, found: np.recarray) -> None:
    found.attractor[here] = Attractor.STEADY_SLIDING
    found.amplitude[here] = found.peak_normal_impulse[here] = 0.0
    found.peak_normal_force[here] = group.steady_force[here]


class Behaviour(IntEnum):
    """What a drive does."""

    UNRESOLVED = -1
    NO_VIBRATION = 0  # every motion that was followed ends in steady sliding
    PURE_SLIP = 1
    STICK_SLIP = 2  # the contact force keeps its sign
    STICK_SLIP_WITH_CONTACT_REVERSAL = 3
    SPRAG_SLIP = 4
    COEXISTENCE = 5  # steady sliding attracts what is near, a cycle what is far
    NEUTRAL = 6  # undamped oscillations side by side
    VIBRATION_FROM_REST = 7  # steady sliding attracts what is near, a cycle the motion that begins at rest


_OF_CYCLES = {
    Attractor.OTHER_CYCLE: Behaviour.PURE_SLIP,
    Attractor.STICK_SLIP_CYCLE: Behaviour.STICK_SLIP,
    Attractor.SPRAG_SLIP_CYCLE: Behaviour.SPRAG_SLIP,
    Attractor.NEUTRAL_FAMILY: Behaviour.NEUTRAL,
}


def behaviours(
    drives: ManyDrives, workers: int = 1, progress: Progress | None = None
) -> tuple[np.recarray, np.ndarray]:
    """Return what motions next to steady sliding end on (k), and what the drives do (k, int8), a ``Behaviour`` each.

    Arguments: number of ``workers`` (:func:`lsvib.dynamics.sweep.all_endings`), which changes no label; ``progress``,
    called with the numbers of motions followed and the most that there may be.
    """
    near, far = near_and_far(drives)
    most = 3 * drives.size
    first = all_endings(drives, near, workers, progress and (lambda done, _: progress(done, most)))
    kinds = [first.attractor == kind for kind in _OF_CYCLES]
    found = np.select(kinds, list(_OF_CYCLES.values()), Behaviour.UNRESOLVED).astype(np.int8)
    reverses = (found == Behaviour.STICK_SLIP) & ((first.happens & REVERSES) > 0)
    found[reverses] = Behaviour.STICK_SLIP_WITH_CONTACT_REVERSAL
    steady = np.flatnonzero(first.attractor == Attractor.STEADY_SLIDING)

    def vibrating(start: Starts | None, done: int) -> np.ndarray:
        """Note which of the steady drives do not return from a start; return whether they vibrate then."""
        again = all_endings(drives.some(steady), start, workers, progress and (lambda n, _: progress(done + n, most)))
        found[steady[~np.isin(again.attractor, (Attractor.STEADY_SLIDING, *_OF_CYCLES))]] = Behaviour.UNRESOLVED
        return np.isin(again.attractor, list(_OF_CYCLES))

    if steady.size:
        found[steady] = Behaviour.NO_VIBRATION
        cycles = vibrating({key: column[steady] for key, column in far.items()}, drives.size)
        found[steady[cycles]] = Behaviour.COEXISTENCE
        static = np.any([drives.values.get(name, np.zeros(drives.size)) > 0 for name in STATIC], axis=0)
        steady = steady[cycles | static[steady]]
    if steady.size:
        found[steady[vibrating(None, 2 * drives.size)]] = Behaviour.VIBRATION_FROM_REST
    if progress is not None:
        progress(most, most)
    return first, found


@np.errstate(all="ignore")  # a drive whose lengths are beyond all numbers is refused with its tables
def near_and_far(drives: ManyDrives) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return starts next to steady sliding and far away, u [rad] and w [rad/s] (k), in plain double precision."""
    v = drives.values
    tangent = np.tan(v["lead_angle"])
    lever, speed, stiffness = v["pitch_radius"] * tangent, v["input_speed"], v["coupling_stiffness"]
    force = v["axial_force"] - lever * v["translation_damping"] * speed
    law = np.where(force * speed < 0, -1, 1)
    factors, inertias, dampings = mechanics.by_law(SimpleNamespace(**v, tan_lead=tangent), v["friction_coefficient"])
    inertia = np.where(law > 0, inertias[1], inertias[-1])
    to_contact = np.abs(inertia * force) / (lever * v["mass"] * stiffness)  # from steady sliding to Q = 0
    to_stop = np.abs(speed) * np.sqrt(v["screw_inertia"] / stiffness)
    band = v["pitch_radius"] * (factors[1] - factors[-1]) * np.abs(v["axial_force"]) / stiffness
    lengths = to_contact + to_stop + band + np.abs(dampings[-1] * speed) / stiffness
    # Without a net force steady sliding lies on Q = 0: beside it θ′ = 0 alone gives a length.
    nearest = np.where(to_contact > 0, np.minimum(to_contact, to_stop), to_stop)
    # u of the near start, in distances to the nearest event: it stays in one mode, and is no rounding
    near = {"u": 1e-6 * nearest, "w": np.zeros(drives.size)}
    # u of the far start, in sums of all lengths of the drive along u
    return near, {"u": -np.sign(speed) * 10.0 * lengths, "w": -speed}
