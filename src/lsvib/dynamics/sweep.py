"""What the motions of many drives with the same parts end on: attractor, size, forces.

Every motion is asked of the one rule (:mod:`lsvib.dynamics.attractor`). Drives with two states are followed by one call
of it compiled, with tables made at once in plain doubles; what these do not hold to 1e-12, and all other drives, are
followed one by one, share by share, in processes of their own. No number depends on how the drives are shared out.
"""

import math
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from multiprocessing import get_context
from typing import Any, NamedTuple

import numpy as np

from lsvib.dynamics.attractor import Attractor, KnownCycles, new_found, orbit_extremes, records, steady_state
from lsvib.dynamics.impulses import event_impulses, normal_impulse
from lsvib.dynamics.kernels import sweep as kernels
from lsvib.dynamics.kernels.attractor import end_of
from lsvib.dynamics.kernels.single_mode import Outcome
from lsvib.dynamics.kernels.sweep import RESTS, REVERSES, SPRAGS
from lsvib.dynamics.machine import machine_for, of_one_type
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import jit, layout
from lsvib.engine.motion import engine_for, enter
from lsvib.errors import EngineError
from lsvib.models.drive import Drive
from lsvib.models.many import Group, ManyDrives, automata, groups
from lsvib.models.model import model_of
from lsvib.models.names import Event
from lsvib.numbers import Progress

WORK = 300_000.0  # events that a motion may take
_WITHOUT_NUMBERS = (Attractor.UNRESOLVED, Attractor.UNBOUNDED)


class Ending(NamedTuple):
    """What a motion ends on, or arrays (k) of what motions do; nan where it has no such number.

    ``attractor``, an :class:`lsvib.dynamics.attractor.Attractor`; ``happens``, what happens on a cycle: the sum of
    those of ``SPRAGS``, ``RESTS`` and ``REVERSES`` (the contact force changes its sign) that do; ``amplitude`` [rad],
    half the peak-to-peak of u; ``period`` [s]; ``multiplier`` [1] of the return map, the largest; ``peak_normal_force``
    [N], largest |N| without the impulses of seizures; ``peak_normal_impulse`` [N s], largest |J_N| of a seizure, 0
    without.
    """

    attractor: Any
    happens: Any
    amplitude: Any
    period: Any
    multiplier: Any
    peak_normal_force: Any
    peak_normal_impulse: Any

    @classmethod
    def without_numbers(cls, attractor: int) -> "Ending":
        """Return an ending of which only the attractor is known."""
        return cls(int(attractor), 0, *(math.nan,) * 5)

    @classmethod
    def unknown(cls, size: int) -> "Ending":
        """Return room for so many."""
        kinds = np.full(size, Attractor.UNRESOLVED, dtype=np.int8), np.zeros(size, dtype=np.int8)
        return cls(*kinds, *(np.full(size, np.nan) for _ in cls._fields[2:]))

    def put(self, places: Any, others: "Ending") -> None:
        """Copy other endings into some places of these."""
        for mine, theirs in zip(self, others, strict=True):
            mine[places] = theirs


def ending_of(drive: Drive, automaton: Automaton | None, state: np.ndarray) -> Ending:
    """Return what the motion of a drive from a state (n) ends on; unresolved where the engine has no automaton."""
    if automaton is None:
        return Ending.without_numbers(Attractor.UNRESOLVED)
    found = steady_state(automaton, state)
    orbit = found.orbit
    if found.label in _WITHOUT_NUMBERS or (orbit is None and found.label == Attractor.NEUTRAL_FAMILY):
        return Ending.without_numbers(found.label)
    if orbit is None:
        mode, _ = enter(automaton, found.state)
        (force,) = automaton.observe("normal_force", found.state[None], np.array([mode]))
        return Ending(int(found.label), 0, 0.0, math.nan, math.nan, abs(float(force)), 0.0)
    try:
        amplitude, peak = found.amplitude, max(map(abs, orbit_extremes(orbit, automaton.functional("normal_force"))))
    except EngineError:  # the rates of a mode lie too far apart to find the extremes
        amplitude = peak = np.nan
    happens = (
        SPRAGS * (found.label == Attractor.SPRAG_SLIP_CYCLE)
        + RESTS * bool(np.isin(automaton.codes[orbit.arcs()[0]], automaton.rest_codes).any())
        + REVERSES * bool((orbit.kind == Event.CONTACT_REVERSAL).any())
    )
    sprags = np.isin(orbit.kind, automaton.sprag_kinds).any()
    impulse = float(np.abs(event_impulses(drive, orbit).normal).max()) if sprags else 0.0
    return Ending(int(found.label), happens, amplitude, found.period, found.multiplier, peak, impulse)


def all_endings(
    drives: ManyDrives,
    starts: np.ndarray | None,
    workers: int = 1,
    progress: Progress | None = None,
    others: Mapping[str, float] | None = None,
) -> Ending:
    """Return what motions of drives with the same parts (k) end on, each from its own start, u [rad], w [rad/s] (k, 2).

    Without ``starts`` that is rest: the screw stands with the coupling relaxed, and the motor begins to turn.

    A motion depends on nothing but its own drive and start: no number depends on ``workers``, the number of processes
    and, with two states, of threads. ``progress`` is called with the numbers of motions done and in all. ``others``:
    values of the other states by name, by default as in steady sliding.
    """
    found, alone = Ending.unknown(drives.size), np.arange(drives.size)
    if drives.rigid.all():
        found, is_open = endings_at_once(drives, starts, workers)
        alone = np.flatnonzero(is_open)
        # motions left alone that make it worth while to start processes, which takes some seconds
        workers = workers if alone.size >= 1000 else 1
    done = drives.size - alone.size
    if progress is not None and done:
        progress(done, drives.size)
    # most and fewest drives that a process takes at a time: some seconds of work
    size = max(64, min(1024, -(-alone.size // (2 * workers))))
    shares = [alone[first : first + size] for first in range(0, alone.size, size)]
    cases = ((drives.some(share), None if starts is None else starts[share]) for share in shares)
    work, several = partial(_share, others=dict(others or {})), workers > 1 and len(shares) > 1
    with get_context("spawn").Pool(min(workers, len(shares))) if several else nullcontext() as processes:
        for share, part in zip(shares, processes.imap(work, cases) if processes else map(work, cases), strict=True):
            found.put(share, part)
            done += share.size
            if progress is not None:
                progress(done, drives.size)
    return found


def _share(case: tuple[ManyDrives, np.ndarray | None], others: Mapping[str, float]) -> Ending:
    """Return what motions of some drives end on, from their starts (k, 2) or from rest."""
    drives, starts = case
    found = Ending.unknown(drives.size)
    for place, drive, automaton in automata(drives):
        model = model_of(drive)
        u_and_w: Any = None if starts is None else zip("uw", starts[place].tolist(), strict=True)
        start = model.from_rest(drive) if u_and_w is None else {**dict(u_and_w), **others}
        found.put(place, ending_of(drive, automaton, model.initial_state(drive, start)))
    return found


def endings_at_once(drives: ManyDrives, starts: np.ndarray | None, workers: int = 1) -> tuple[Ending, np.ndarray]:
    """Return what motions of drives with two states (k) end on, and which must be followed alone (k).

    Those are the ones of drives whose tables are not safe in doubles, whose friction depends on speed, or without any
    damping.
    """
    found, is_open = Ending.unknown(drives.size), np.ones(drives.size, dtype=bool)
    # drives whose tables are made at once: half a gigabyte of numbers for a million would be too many
    size = max(1, min(8192, -(-drives.size // workers)))
    blocks = [np.arange(first, min(first + size, drives.size)) for first in range(0, drives.size, size)]

    def fill(block: np.ndarray) -> None:
        for group in groups(drives, block):
            closed, endings = _group_endings(drives, group, None if starts is None else starts[group.members])
            found.put(group.members[closed], Ending(*(column[closed] for column in endings)))
            is_open[group.members[closed]] = False

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(fill, blocks))
    return found, is_open


def _group_endings(drives: ManyDrives, group: Group, starts: np.ndarray | None) -> tuple[np.ndarray, Ending]:
    """Return which motions of a group (j), from ``starts`` (j, 2) or rest, are done, and what these end on."""
    automaton, size, found = group.automaton, group.members.size, Ending.unknown(group.members.size)
    flow, moving = automaton.tables.flow, ~np.isin(automaton.codes, automaton.rest_codes)
    done = group.safe & flow[:, moving, layout.A1].any(axis=1)
    if automaton.contracts:
        slides = done & (flow[..., layout.ALPHA] > 0).any(axis=1)
        _slide(group, slides, found)
        return slides, found
    outcomes, numbers = np.full(size, Outcome.OPEN, dtype=np.int8), np.full(size, np.nan, dtype=kernels.NUMBERS)
    none = KnownCycles.of((), automaton, 0).asked
    asked = none._replace(facts=none.facts._replace(conserves=False))
    reversal = np.int64(Event.CONTACT_REVERSAL)
    force = automaton.observables["normal_force"]
    speed = drives.values["input_speed"][group.members]
    if starts is None:  # the coupling is relaxed
        starts = np.stack([-np.asarray(group.coefficients.deflection), -speed], axis=1)
    starts = np.ascontiguousarray(starts, dtype=float)
    many, room = automaton.tables, records(2)
    split = ("flow", "surfaces", "guard_parts", "resets", "condition_row", "shortest_stay")
    one = many._replace(**{name: getattr(many, name)[0] for name in split})
    engine = machine_for(one, engine_for(one))
    address = jit.address(end_of, engine, of_one_type(one), asked, 0, starts[0], room, new_found(2, WORK))
    rule = kernels.Rule(address, engine, asked, WORK, room)
    members = kernels.Drives(of_one_type(many), starts, force, speed)
    answers = kernels.Answers(outcomes, found.happens, numbers)
    kernels.ends_of_many(rule, members, np.flatnonzero(done), reversal, answers)
    _slide(group, outcomes == Outcome.SLIDES, found)
    cycles = outcomes == Outcome.CYCLE
    bits = found.happens[cycles]
    labels = np.where(bits & RESTS, Attractor.STICK_SLIP_CYCLE, Attractor.OTHER_CYCLE)
    found.attractor[cycles] = np.where(bits & SPRAGS, Attractor.SPRAG_SLIP_CYCLE, labels)
    found.amplitude[cycles] = numbers["amplitude"][cycles]
    found.period[cycles] = numbers["period"][cycles]
    found.multiplier[cycles] = numbers["multiplier"][cycles]
    found.peak_normal_force[cycles] = numbers["force"][cycles]
    own = {name: column[group.members[cycles]] for name, column in drives.values.items()}
    values = {name: own[name] for name in ("mass", "pitch_radius", "screw_inertia")}
    impulses = normal_impulse(numbers["seizure_speed"][cycles], np.sin(own["lead_angle"]), **values)
    found.peak_normal_impulse[cycles] = np.abs(impulses)
    spent = (outcomes == Outcome.SPENT) | (outcomes == Outcome.SPENT_STEADILY)
    return cycles | spent | (outcomes == Outcome.SLIDES), found


def _slide(group: Group, here: np.ndarray, found: Ending) -> None:
    """Write steady sliding for some members of a group."""
    found.attractor[here] = Attractor.STEADY_SLIDING
    found.amplitude[here] = found.peak_normal_impulse[here] = 0.0
    found.peak_normal_force[here] = group.steady_force[here]
