"""Motions of a system of one's own, what they end on, and its cycles."""

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np

from lsvib import numbers
from lsvib.errors import AccumulationError, BranchError, DivergenceError, EngineError, InputError, WorkSpentError
from lsvib.numbers import names_and_values, shown
from lsvib.systems.assembly import Made, made
from lsvib.systems.attractor import Attractor, Doubt, KnownCycles, SteadyState, end_of_motion, orbit_extremes
from lsvib.systems.cycles import Cycle, cycle_of, same_cycle
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, Events, Status
from lsvib.systems.motion import Budget, Motion, follow
from lsvib.systems.system import System


class Label(StrEnum):
    """What a motion of a system ends on."""

    EQUILIBRIUM = "equilibrium"
    CYCLE = "cycle"
    FAMILY = "family"  # oscillations side by side, none attracting the others
    UNBOUNDED = "unbounded"
    UNRESOLVED = "unresolved"


# Part of the first stays on a wall of those whose roots rounding moves: a time is lost by it, over the speed there.
_NOISY = 1e-4
_ROUNDS = 20  # of accumulations, after each of which the end of a motion is asked for anew
_EXPLAINED = 20_000  # work, in events, that it may take to say why an end is unresolved
_LABELS = {
    Attractor.STEADY_SLIDING: Label.EQUILIBRIUM,
    Attractor.REST: Label.EQUILIBRIUM,
    Attractor.NEUTRAL_FAMILY: Label.FAMILY,
    Attractor.UNBOUNDED: Label.UNBOUNDED,
    Attractor.UNRESOLVED: Label.UNRESOLVED,
}


@dataclass(frozen=True)
class End:
    """What a motion ends on.

    ``state`` by name: the equilibrium, or a state of the cycle; ``mode`` in which it has that. A cycle also has its
    ``period`` [s], ``turns``, that as a multiple of the forcing's (0 without), ``multipliers`` [1], the largest first,
    of the states without those of forcing and clocks, ``multiplier_error``, a bound of their errors, and ``orbit``, one
    period. A family has an ``orbit`` if it has a period. ``doubt`` says why an end is unresolved, ``reason`` in words.
    """

    label: Label
    mode: str
    state: Mapping[str, float]
    cycle: Cycle | None = field(default=None, repr=False, compare=False)
    orbit: Motion | None = field(default=None, repr=False, compare=False)
    turns: int = 0
    multipliers: np.ndarray = field(default_factory=lambda: np.zeros(0))
    multiplier_error: float = math.nan
    doubt: Doubt | None = None
    reason: str = ""

    @property
    def period(self) -> float:
        """Period [s]; nan for what has none."""
        return self.orbit.end_time if self.orbit else math.nan

    def extremes(self, k: int) -> tuple[float, float]:
        """Return the smallest and largest value of a state, by its place; nan of what stays nowhere."""
        if self.orbit is not None:
            return orbit_extremes(self.orbit, np.eye(1, self.orbit.start_state.size + 1, k)[0])
        value = [*self.state.values()][k] if self.label == Label.EQUILIBRIUM else math.nan
        return value, value

    def to_json(self) -> dict[str, Any]:
        """Return it as plain numbers and names; what it has not is left out."""
        found: dict[str, Any] = {"label": self.label.value, "mode": self.mode, "state": dict(self.state)}
        if self.orbit is not None:
            found |= {"period": self.period} | ({"turns": self.turns} if self.turns else {})
        if self.cycle is not None:
            multipliers = self.cycle.to_json_multipliers()[: self.multipliers.size]
            error = self.multiplier_error if math.isfinite(self.multiplier_error) else None
            found |= {"attracting": self.cycle.attracting, "multipliers": multipliers, "multiplier_error": error}
            found |= {"events": [*map(list, self.cycle.itinerary)]}
        return found | ({"unresolved_because": self.reason} if self.doubt else {})

    def text(self) -> Iterator[str]:
        """Say it in lines."""
        where = ", ".join(f"{name} = {x:.15g}" for name, x in self.state.items())
        yield f"{self.label}{f' in mode {self.mode}' if self.mode else ''}: {self.reason or where}"
        if self.orbit is not None:
            turns = f", {self.turns} of the forcing" if self.turns else ""
            yield f"  period {self.period:.15g} s{turns}"
        if self.cycle is not None:
            values = (f"{x.real:.10g}{f' {x.imag:+.10g}i' if x.imag else ''}" for x in self.multipliers)
            yield f"  multipliers {', '.join(values) or 'none'} (± {self.multiplier_error:.1g})"
            yield f"  events: {', '.join(f'{kind} into {mode}' for kind, mode in self.cycle.itinerary)}"


class Known(NamedTuple):
    """Cycles that motions may join: what the rule knows of them, the ends that they are, of how many that are known."""

    table: KnownCycles
    ends: Mapping[int, End]
    known: int

    @classmethod
    def of(cls, own: Made, ends: Sequence[End]) -> "Known":
        """Return what is known where some ends are, of which the cycles count."""
        cycles = [one for one in ends if one.cycle]
        found = [SteadyState(Attractor.OTHER_CYCLE, one.orbit.start_state, one.orbit) for one in cycles if one.orbit]
        table = KnownCycles.of(found, own.automaton, 1024)  # others are looked for after so many events
        return cls(table, dict(zip(map(id, found), cycles, strict=True)), len(ends))


def start_of(system: System, mode: str, state: Mapping[str, Any] | None = None) -> tuple[int, np.ndarray]:
    """Return the mode of a start, as the engine counts it, and all coordinates (n); missing states are zero.

    Clocks begin at zero unless they are given, harmonics at phase 0. A start beyond a surface is in the mode there, and
    an event whose condition holds already happens at once. ``InputError`` for one that is no start.
    """
    own, given = made(system), names_and_values("state", state)
    if mode not in [*own.modes]:
        raise InputError(f"{shown(mode)} is no mode of the system; modes are {', '.join(own.modes)}.")
    names, found = own.automaton.states, own.begin.copy()
    for name, value in given.items():
        if name not in system.states and name not in system.clocks:
            known = ", ".join([*system.states, *system.clocks])
            raise InputError(f"start has the unknown name {shown(name)}; known are {known}.")
        found[names.index(name)] = numbers.start(f"start {name}", value)
    return own.modes[_beside(own, mode, found)], found


def _beside(own: Made, mode: str, state: np.ndarray) -> str:
    """Return the mode on the side of the surfaces on which a state lies."""
    for border in (border for _ in own.modes for border in own.borders):
        rows = np.array([[*map(float, row)] for row in (border.at, *border.rises)])
        value, low, high = rows @ np.append(state, 1.0)
        if mode not in (border.below, border.above, border.slides):
            continue
        if value == 0 and low < 0 < high:
            raise InputError(
                f"the start lies on the surface {border.text}, which motions leave to both sides; move it a little."
            )
        mode = mode if value == 0 else border.below if value < 0 else border.above
    return mode


def motion(own: Made, number: int, place: np.ndarray, t_end: float, budget: Budget | None = None) -> Motion:
    """Follow a motion from a mode and a state (n) to ``t_end`` [s], which may be infinite if it settles.

    Where events accumulate, what follows begins at the limit of their times. Raises ``EngineError`` in words of the
    system where nothing is said of what follows.
    """
    pieces: list[Motion] = []
    now = 0.0
    while not pieces or pieces[-1].status == Status.STOP_EVENT:
        piece = _stretch(own, number, place, now, max(t_end - now, 0.0), budget)
        pieces.append(replace(piece, time=now + piece.time))
        now, number, place = now + piece.end_time, piece.end_mode, piece.end_state
    first, last = pieces[0], pieces[-1]
    columns: dict[str, Any] = {name: np.concatenate([getattr(one, name) for one in pieces]) for name in Events._fields}
    return replace(last, start_mode=first.start_mode, start_state=first.start_state, end_time=now, **columns)


def _stretch(own: Made, mode: int, place: np.ndarray, now: float, t_end: float, budget: Budget | None) -> Motion:
    """Follow a motion to ``t_end`` [s], or up to where events accumulate, of which it has those before their limit."""
    try:
        stop = ACCUMULATION_KIND, -1
        piece = follow(own.automaton, place, t_end, mode=mode, stop=stop, budget=budget)
    except (AccumulationError, BranchError) as error:
        raise _in_words(own, mode, place, now, error) from None
    if piece.status != Status.STOP_EVENT:
        return piece
    time, place = _limit(piece.time[:-1], piece.after[:-1]) or (piece.end_time, piece.end_state)
    piece.time[-1], piece.before[-1], piece.after[-1] = time, place, place
    kept = np.append(piece.time[:-1] < time, True)
    columns: dict[str, Any] = {name: getattr(piece, name)[kept] for name in Events._fields}
    return replace(piece, end_time=float(time), end_state=place, **columns)


def _limit(times: np.ndarray, states: np.ndarray) -> tuple[float, np.ndarray] | None:
    """Return time [s] and state where events accumulate whose stays shrink geometrically; None if they do not.

    A turn may have up to six events. With the ratio q of two turns the rest is q / (1 − q) times the last one (Aitken);
    it is taken where it changes least, of turns that are not so short that rounding moves them.
    """
    for events in range(1, 7):
        k = np.arange(times.size - 1, -1, -events)[::-1]
        stays = np.diff(times[k])
        if stays.size < 6:
            break
        with np.errstate(all="ignore"):
            ratio = stays[1:] / stays[:-1]
            rest = ratio / (1 - ratio)
            limits, left = times[k[2:]] + stays[1:] * rest, times[-1] - times[k[2:]]
            good = (rest > 0) & (rest < 1e4) & (np.abs(limits - times[-1]) < 0.01 * left)
            good &= stays[1:] > _NOISY * np.max(stays[1:][good], initial=0.0)
            change = np.where(good[1:] & good[:-1], np.abs(np.diff(limits)), math.inf)
        if np.isfinite(change).sum() > 4:
            best = int(np.argmin(change)) + 1
            last, before = states[k[2 + best]], states[k[1 + best]]
            place, size = last + (last - before) * rest[best], np.abs(states[k]).max(axis=0)
            return float(limits[best]), np.where(np.abs(place) > 1e-9 * size, place, 0.0)
    return None


def _in_words(
    own: Made, mode: int, place: np.ndarray, begun: float, error: AccumulationError | BranchError
) -> EngineError:
    """Say what a motion has come to of which the system does not say what follows."""
    names, where = own.automaton.modes, f"at t = {begun + error.time:.6g} s"
    here = names.get(error.mode, names[mode])
    if isinstance(error, BranchError):
        on = [border for border in own.borders if here in (border.below, border.above, border.slides)]
        if len(on) == 1 and here != on[0].slides:
            return EngineError(
                f"the motion would slide along {on[0].text} {where}, but the derivative does not jump by the same "
                f"all along it, so that {on[0].below} and {on[0].above} determine no linear motion there."
            )
        texts = " or ".join(border.text for border in on)
        return EngineError(f"the motion from mode {here} meets two surfaces at once {where} ({texts} = 0).")
    limit = None
    with suppress(EngineError):
        before = follow(own.automaton, place, error.time * (1 - 1e-12), mode=mode)
        limit = _limit(before.time, before.after)
    if limit is None:
        return EngineError(f"events follow each other {where} without end and without time, from mode {here} on.")
    return AccumulationError(
        f"infinitely many events accumulate at t = {begun + limit[0]:.15g} s in mode {here}, and the system does not "
        "say what follows: an event with beyond names the mode."
    )


def end_of(system: System, mode: str, state: Mapping[str, Any] | None = None, max_events: int = 300_000) -> End:
    """Return what the motion from a start ends on."""
    return end_from(made(system), *start_of(system, mode, state), max_events)


def end_from(own: Made, number: int, place: np.ndarray, max_events: int = 300_000, known: Known | None = None) -> End:
    """Return what the motion from a mode and a state (n), as the engine counts them, ends on.

    It may be found to join ``known`` cycles.
    """
    if own.period is not None and math.isnan(own.period):
        raise InputError("harmonics and clocks of the system have no common period, so that no motion of it repeats.")
    for _ in range(_ROUNDS):
        joined = known and known.table
        steady, _ = end_of_motion(own.automaton, place, mode=number, max_events=max_events, known=joined)
        if known and id(steady) in known.ends:
            return known.ends[id(steady)]
        brief = steady.orbit is not None and steady.orbit.end_time < own.brief
        if not brief and steady.doubt != Doubt.ACCUMULATION:
            break
        try:
            piece = _stretch(own, number, place, 0.0, math.inf, None)
        except EngineError as error:
            return End(Label.UNRESOLVED, "", _named(own, steady.state), doubt=Doubt.ACCUMULATION, reason=str(error))
        number, place = piece.end_mode, piece.end_state
    label, orbit, reason = _LABELS.get(steady.label, Label.CYCLE), steady.orbit, str(steady.doubt or "")
    if label == Label.CYCLE:
        cycle = cycle_of(steady)
        if cycle is not None:
            return end_of_cycle(own, cycle)
        steady, label = replace(steady, doubt=Doubt.ENGINE), Label.UNRESOLVED
    try:
        if label == Label.EQUILIBRIUM:
            return _still(own, motion(own, number, place, math.inf, Budget(max_events)))
        if steady.doubt is not None:
            motion(own, number, place, math.inf, Budget(_EXPLAINED))
    except DivergenceError:
        steady, label, reason = replace(steady, doubt=None), Label.UNBOUNDED, ""
    except EngineError as error:
        reason = reason if isinstance(error, WorkSpentError) else str(error)
    mode = own.automaton.modes[orbit.start_mode] if orbit else ""
    return End(label, mode, _named(own, steady.state), orbit=orbit, doubt=steady.doubt, reason=reason)


def end_of_cycle(own: Made, cycle: Cycle) -> End:
    """Return a cycle as an end, attracting or not."""
    return End(
        Label.CYCLE, own.automaton.modes[cycle.orbit.start_mode], _named(own, cycle.state), cycle, cycle.orbit,
        turns=round(cycle.period / own.period) if own.period else 0,
        multipliers=cycle.multipliers[: own.free], multiplier_error=cycle.multiplier_error,
    )  # fmt: skip


def _still(own: Made, last: Motion) -> End:
    """Return where a motion that stays in its last mode for ever ends: rates of zero keep where it is, or it drifts.

    That is the projection on what the flow keeps, along all that it changes.
    """
    mode, field = own.automaton.modes[last.end_mode], own.automaton.flow.field[last.end_mode]
    start = np.append(last.end_state, 1.0)
    if not (field @ start).any():
        return End(Label.EQUILIBRIUM, mode, _named(own, last.end_state))
    left, values, right = np.linalg.svd(np.vstack([field, 0 * start]))
    none = values <= 1e-13 * values[0]
    stay, kept = right[none].T, left[:, none]
    across = kept.T @ stay  # singular where what is kept grows in proportion to time
    if not np.linalg.cond(across) < 1e10:
        return End(Label.UNBOUNDED, mode, _named(own, last.end_state))
    return End(Label.EQUILIBRIUM, mode, _named(own, (stay @ np.linalg.solve(across, kept.T @ start))[:-1]))


def _named(own: Made, state: np.ndarray) -> dict[str, float]:
    names = [name for name in own.automaton.states if name.isidentifier()]
    return dict(zip(names, state.tolist(), strict=False))


def same_end(one: End, other: End) -> bool:
    """Whether two ends are one: a cycle, or what is side by side in one mode, or unresolved for one reason."""
    if one.cycle and other.cycle:
        return same_cycle(one.cycle, other.cycle)
    return (one.label, one.mode, one.doubt) == (other.label, other.mode, other.doubt)
