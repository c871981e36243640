"""Motions of a system of one's own, what they end on, and its cycles."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

import numpy as np

from lsvib import numbers
from lsvib import variables as cf
from lsvib.errors import DivergenceError, EngineError, InputError, WorkSpentError
from lsvib.numbers import names_and_values, shown
from lsvib.systems.assembly import Made, made
from lsvib.systems.attractor import Attractor, Doubt, KnownCycles, end_of_motion, orbit_extremes
from lsvib.systems.cycles import Cycle, cycle_of, same_cycle
from lsvib.systems.kernels.layout import ACCUMULATION_KIND, Events, Status
from lsvib.systems.motion import Budget, Motion, follow


class Label(StrEnum):
    """The kind of what a motion of a system ends on; equal to its text, as in ``end.label == "cycle"``."""

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
    """What a motion of a system ends on.

    ``label``: its kind; ``state``, by name: the equilibrium, or a state of the cycle, in ``mode``. A cycle also has its
    ``period`` [s]; ``turns``, the same as a multiple of the period of the forcing (0 without forcing); ``multipliers``
    [1], the largest first, of the states without those of forcing and clocks; ``orbit``, one period; and ``cycle``,
    which knows more. A family has an ``orbit`` if it has a period. ``doubt``: why an end is unresolved, ``reason`` in
    words; ``starts``: how many starts of a search end here (docs/systems.md).

    >>> end = impact.steady_state("fly")  # of lsvib.systems.System
    >>> end.label == "cycle", end.mode, f"{end.state['v']:.6f}", end.turns, f"{end.multipliers[0]:.6f}"
    (True, 'fly', '-1.356586', 1, '-0.584295+0.005600j')
    >>> [round(value, 6) for value in end.extremes("x")]
    [-1.18406, 1.0]
    """

    label: Label
    mode: str
    state: Mapping[str, float]
    orbit: Motion | None = field(default=None, repr=False, compare=False)
    cycle: Cycle | None = field(default=None, repr=False, compare=False)
    turns: int = 0
    doubt: Doubt | None = None
    reason: str = ""
    starts: int = 1

    @property
    def period(self) -> float:
        """Period [s]; NaN if there is none."""
        return self.orbit.end_time if self.orbit else math.nan

    @property
    def multipliers(self) -> np.ndarray:
        """Multipliers [1], complex, the largest first; empty unless it is a cycle."""
        return self.cycle.multipliers if self.cycle else np.zeros(0)

    def extremes(self, k: int | str) -> tuple[float, float]:
        """Return the smallest and largest value of a state, by index or name; NaN if the motion does not settle."""
        if isinstance(k, str) and k not in self.state:
            raise InputError(f"{shown(k)} is not a state of the system; its states are {', '.join(self.state)}.")
        k = [*self.state].index(k) if isinstance(k, str) else k
        if self.orbit is not None:
            return orbit_extremes(self.orbit, np.eye(1, self.orbit.start_state.size + 1, k)[0])
        value = [*self.state.values()][k] if self.label == Label.EQUILIBRIUM else math.nan
        return value, value

    def to_json(self) -> dict[str, Any]:
        """Return it as plain numbers and names, without what does not exist."""
        found: dict[str, Any] = {"label": self.label.value, "mode": self.mode, "state": dict(self.state)}
        found |= {"period": self.period} if self.orbit else {}
        found |= {"turns": self.turns} if self.turns else {}
        if self.cycle is not None:
            found |= {name: self.cycle.to_json()[name] for name in ("attracting", "multipliers", "multiplier_error")}
            found["events"] = [*map(list, self.cycle.itinerary)]
        return found | ({"unresolved_because": self.reason} if self.doubt else {})

    def text(self) -> Iterator[str]:
        """Yield it in lines of text."""
        where = ", ".join(f"{name} = {x:.15g}" for name, x in self.state.items())
        yield f"{self.label}{f' in mode {self.mode}' if self.mode else ''}: {self.reason or where}"
        if self.orbit is not None:
            yield f"  period {self.period:.15g} s{f', {self.turns} of the forcing' if self.turns else ''}"
        if self.cycle is not None:
            yield f"  multipliers {self.cycle.multipliers_in_words()}"
            yield f"  events: {', '.join(f'{kind} into {mode}' for kind, mode in self.cycle.itinerary)}"


def start_of(system: Any, mode: str, state: Mapping[str, Any] | None = None) -> tuple[int, np.ndarray]:
    """Return the mode of a start, as the engine counts it, and all coordinates (n); missing states are zero.

    Clocks begin at zero unless they are given, harmonics at phase 0. A start beyond a surface is in the mode there, and
    an event whose condition holds already happens at once. ``InputError`` for one that is no start.
    """
    own, given = made(system), names_and_values("state", state)
    if mode not in [*own.modes]:
        raise InputError(f"{shown(mode)} is not a mode of the system; its modes are {', '.join(own.modes)}.")
    names, found = own.automaton.states, own.begin.copy()
    for name, value in given.items():
        if name not in system.states and name not in system.clocks:
            known = ", ".join([*system.states, *system.clocks])
            raise InputError(f"start has the unknown name {shown(name)}; known are {known}.")
        found[names.index(name)] = numbers.start(f"start {name}", value)
    return own.modes[_beside(own, mode, found)], found


def _beside(own: Made, mode: str, state: np.ndarray) -> str:
    """Return the mode on the side of the surfaces on which a state lies."""
    for border in own.borders * len(own.modes):  # of which one may lead beyond the next
        if mode not in (border.below, border.above, border.slides):
            continue
        value, low, high = np.array([[*map(float, row)] for row in (border.at, *border.rises)]) @ np.append(state, 1.0)
        if value == 0 and low < 0 < high:
            raise InputError(
                f"the start lies on the surface {border.text}, which motions leave on both sides; move it a little."
            )
        mode = mode if value == 0 else border.below if value < 0 else border.above
    return mode


def motion(own: Made, number: int, place: np.ndarray, t_end: float, budget: Budget | None = None) -> Motion:
    """Follow a motion from a mode and a state (n) to ``t_end`` [s], which may be infinite if it settles.

    Where events accumulate, what follows begins at the limit of their times. Raises ``EngineError`` in words of the
    system where nothing is said of what follows.
    """
    pieces = [*_pieces(own, number, place, t_end, budget)]
    columns: dict[str, Any] = {name: np.concatenate([getattr(one, name) for one in pieces]) for name in Events._fields}
    return replace(pieces[-1], start_mode=number, start_state=place, **columns)


def _pieces(own: Made, mode: int, place: np.ndarray, t_end: float, budget: Budget | None = None) -> Iterator[Motion]:
    """Yield a motion in pieces, each up to where events accumulate, of which it has those before their limit."""
    now, goes_on = 0.0, True
    while goes_on:
        try:
            stop = ACCUMULATION_KIND, -1
            piece = follow(own.automaton, place, max(t_end - now, 0.0), mode=mode, stop=stop, budget=budget)
        except EngineError as error:
            raise _in_words(own, now, error) from None
        time, place, kept = piece.end_time, piece.end_state, np.ones(piece.time.size, dtype=bool)
        if goes_on := piece.status == Status.STOP_EVENT:
            time, place = _limit(piece.time[:-1], piece.after[:-1]) or (time, place)
            piece.time[-1], piece.before[-1], piece.after[-1] = time, place, place
            kept = np.append(piece.time[:-1] < time, True)
        columns: dict[str, Any] = {name: getattr(piece, name)[kept] for name in Events._fields}
        columns["time"] = now + columns["time"]
        now, mode = now + time, piece.end_mode
        yield replace(piece, end_time=now, end_state=place, **columns)


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


def _in_words(own: Made, begun: float, error: EngineError) -> EngineError:
    """Say what a motion, from the time ``begun``, has come to of which the system does not say what follows."""
    last = error.motion
    if not isinstance(last, Motion) or last.status not in (Status.NO_BRANCH, Status.ACCUMULATED):
        return error
    here, where = own.automaton.modes[last.arcs()[0][-1]], f"at t = {begun + last.end_time:.6g} s"
    if last.status == Status.NO_BRANCH:
        on = [border for border in own.borders if here in (border.below, border.above, border.slides)]
        if len(on) == 1 and here != on[0].slides:
            return EngineError(
                f"the motion would slide along {on[0].text} {where}, but the derivative does not jump by the same "
                f"all along it, so that {on[0].below} and {on[0].above} determine no linear motion there."
            )
        texts = " or ".join(border.text for border in on)
        return EngineError(f"the motion from mode {here} meets two surfaces at once {where} ({texts} = 0).")
    limit = _limit(last.time, last.after)
    if limit is None:
        return EngineError(f"events follow each other {where} endlessly and without delay, from mode {here} on.")
    return EngineError(
        f"infinitely many events accumulate at t = {begun + limit[0]:.15g} s in mode {here}, and the system does not "
        "say what follows; give the mode as beyond of an event."
    )


def end_of(system: Any, mode: str, state: Mapping[str, Any] | None = None, max_events: int = 300_000) -> End:
    """Return what the motion from a start ends on."""
    return _end(made(system), *start_of(system, mode, state), max_events)


def ends_of(system: Any, starts: Iterable[tuple[str, Any]], max_events: int = 300_000) -> tuple[list[End], list[int]]:
    """Return what the motions from starts, modes and states, end on, each once, and the place of that of each start."""
    own, found, places = made(system), list[End](), list[int]()
    known = None
    for start in starts:
        end = _end(own, *start_of(system, *start), max_events, known)
        place = next((k for k, other in enumerate(found) if end is other or _same(end, other)), len(found))
        if place == len(found):
            found.append(end)
            # cycles that are not known are looked for after 1024 events
            known = KnownCycles.of([end for end in found if end.cycle], own.automaton, 1024)
        places.append(place)
    return found, places


def _end(own: Made, number: int, place: np.ndarray, work: int, known: KnownCycles | None = None) -> End:
    """Return what the motion from a mode and a state (n) ends on, with ``work`` in events; it may be a known end."""
    if own.period is not None and math.isnan(own.period):
        raise InputError(
            "no period of a harmonic or clock is a multiple of all others, so no motion is known to repeat; if they "
            "have a common period, give a clock with it."
        )
    for _ in range(_ROUNDS):
        steady, _ = end_of_motion(own.automaton, place, mode=number, max_events=work, known=known)
        if isinstance(steady, End):
            return steady
        brief = steady.orbit is not None and steady.orbit.end_time < own.brief
        if not brief and steady.doubt != Doubt.ACCUMULATION:
            break
        try:
            piece = next(_pieces(own, number, place, math.inf))
        except EngineError as error:
            where = _named(own, steady.state)
            return End(Label.UNRESOLVED, "", where, doubt=Doubt.ACCUMULATION, reason=str(error))
        number, place = piece.end_mode, piece.end_state
    label, doubt, orbit = _LABELS.get(steady.label, Label.CYCLE), steady.doubt, steady.orbit
    if label == Label.CYCLE:
        cycle = cycle_of(steady)
        if cycle is not None:
            turns = round(cycle.period / own.period) if own.period else 0
            mode, cycle = own.automaton.modes[cycle.orbit.start_mode], of_system(own, cycle)
            return End(label, mode, _named(own, cycle.state), cycle.orbit, cycle, turns)
        doubt, label = Doubt.ENGINE, Label.UNRESOLVED
    reason = str(doubt or "")
    try:
        if label == Label.EQUILIBRIUM:
            return _still(own, motion(own, number, place, math.inf, Budget(work)))
        if doubt is not None:
            motion(own, number, place, math.inf, Budget(_EXPLAINED))
    except DivergenceError:
        doubt, label, reason = None, Label.UNBOUNDED, ""
    except EngineError as error:
        reason = reason if isinstance(error, WorkSpentError) else str(error)
    mode = own.automaton.modes[orbit.start_mode] if orbit else ""
    return End(label, mode, _named(own, steady.state), orbit, doubt=doubt, reason=reason)


def of_system(own: Made, cycle: Cycle) -> Cycle:
    """Return a cycle with the multipliers alone that the forcing, or the direction of motion, does not give it."""
    return replace(cycle, multipliers=cycle.multipliers[: own.free])


def _still(own: Made, last: Motion) -> End:
    """Return where a motion that stays in its last mode for ever ends: rates of zero keep where it is, or it drifts.

    That is the projection on what the flow keeps, along all that it changes.
    """
    field, start = own.automaton.flow.field[last.end_mode], np.append(last.end_state, 1.0)
    left, values, right = np.linalg.svd(np.vstack([field, 0 * start]))
    none = values <= 1e-13 * values[0]
    stay, kept = right[none].T, left[:, none]
    still, across = not (field @ start).any(), kept.T @ stay  # singular where what is kept grows in proportion to time
    label = Label.EQUILIBRIUM if still or np.linalg.cond(across) < 1e10 else Label.UNBOUNDED
    if label == Label.EQUILIBRIUM and not still:
        start = stay @ np.linalg.solve(across, kept.T @ start)
    return End(label, own.automaton.modes[last.end_mode], _named(own, start[:-1]))


def _named(own: Made, state: np.ndarray) -> dict[str, float]:
    names = [name for name in own.automaton.states if name.isidentifier()]
    return dict(zip(names, state.tolist(), strict=False))


def _same(one: End, other: End) -> bool:
    """Whether two ends are one: a cycle, or what is side by side in one mode, or unresolved for one reason."""
    if one.cycle and other.cycle:
        return same_cycle(one.cycle, other.cycle)
    return (one.label, one.mode, one.doubt) == (other.label, other.mode, other.doubt)


def states_of(own: Made, dims: cf.Dims, values: np.ndarray, name: str = "{}", when: str = "") -> cf.Variables:
    """Return states (..., n) as variables, without the forcing's clock."""
    names = [(k, x) for k, x in enumerate(own.names) if x.isidentifier()]
    return {name.format(x): cf.variable(dims, values[..., k], "1", f"state {x}{when}") for k, x in names}


def variables_of(dims: cf.Dims, ends: Sequence[End], shape: Sequence[int] = (-1,)) -> cf.Variables:
    """Return label, period and the largest multiplier of ends as variables."""
    first = [end.multipliers[0] if end.multipliers.size else math.nan for end in ends]
    leading = [abs(x) if x.imag else x.real for x in first]
    table = {
        "period": ([end.period for end in ends], "s", "period of the attractor", "$T$"),
        "turns": ([end.turns for end in ends], "1", "number of forcing periods in that period, or zero"),
        "multiplier": (leading, "1", "largest multiplier, or its magnitude if it is complex"),
    }
    labels = np.reshape([list(Label).index(end.label) for end in ends], shape)
    return {"label": cf.flagged(dims, labels, "attractor of the motion", list(Label))} | cf.columns(dims, table, shape)
