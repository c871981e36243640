"""Motions with static friction in every dry contact at once, whose modes and events are found by trying all of them.

On Newton's laws body by body (:mod:`references.bodies`). A contact, of the threads, of the slide or of the bearing, is
at rest or moves one way. At each event, and at the start, all combinations of what may then rest or move are tried, the
ones with more at rest first; one is kept if all that it takes for granted holds now and just after: margins that are
zero to rounding are judged by their first rate that is not.
"""

import copy
from collections.abc import Iterator
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm, matrix_balance
from scipy.optimize import brentq, minimize_scalar

from references.bodies import Bodies, sign

FAR = 2.0**40  # at which an affine function shows its slopes without what rounding does to its constant
DECIDED = 1e-11  # of the terms of a margin or of a rate: more than rounding makes of zero
FLOOR = 1e-13  # of the terms of a margin along an arc, likewise
WINDOW = 64  # samples that are looked at together


class Happening(NamedTuple):
    """An event: its time [s], what it is called, and the absolute state and the mode after it."""

    time: float
    kind: str
    state: np.ndarray
    mode: dict


def affine(function, size: int) -> np.ndarray:
    """The matrix of an affine function of some numbers, its constant last.

    What is zero but for rounding is zero: with other steps it comes out otherwise.
    """
    constant, near = function(np.zeros(size)), np.full(size, 1e-6)

    def slopes(step: float) -> np.ndarray:
        return np.column_stack([(function(unit) - constant) / step for unit in step * np.eye(size)])

    def sure(found: np.ndarray, again: np.ndarray) -> np.ndarray:
        return np.where(np.abs(found - again) <= 1e-3 * np.abs(found), found, 0.0)

    rows = sure(slopes(FAR), slopes(1.37 * FAR))
    return np.column_stack([rows, sure(constant, function(near) - rows @ near)])


class Contacts(Bodies):
    """A drive, with a command that is straight between given ``speeds`` at given ``times`` (constant without them)."""

    def __init__(self, drive, times=(), speeds=()) -> None:
        super().__init__(drive)
        self.frictions = [body for body in ("bearing", "slide") if self.most(body)]
        self.dry = ["slip", *filter(self.free, self.frictions)]  # what may rest or move by itself
        rates = [(self.p["input_speed"] or 1.0) * (self.lead if name in "ye" else 1.0) for name in self.q]
        self.sizes = np.abs(self.steady) + np.abs(np.kron(rates, [1e-3, 1.0]))  # rates over a millisecond
        speeds = [*speeds] or [self.p["input_speed"]]
        self.pieces = [(0.0, times[0], speeds[0], 0.0)] if len(times) and times[0] > 0 else []
        for k, (begin, end) in enumerate(pairwise(times)):
            if end > begin:
                self.pieces.append((begin, end, speeds[k], (speeds[k + 1] - speeds[k]) / (end - begin)))
        self.pieces.append((times[-1] if len(times) else 0.0, np.inf, speeds[-1], 0.0))

    def follow(self, state: np.ndarray, duration: float, most: int) -> tuple[dict, list[Happening], np.ndarray]:
        """The first mode of a motion from an absolute state, its events, and the state at the end or the last event."""
        found, first = [], None
        for begin, end, speed, rate in self.pieces:
            self.commanded = lambda t, begin=begin, speed=speed, rate=rate: speed + rate * (t - begin)
            if first is None:
                first, state = self.entered(state)
                mode = first
            elif begin < duration:
                found.append(Happening(begin, "command", state, mode))
            time = begin
            while time < min(end, duration) and len(found) < most:
                time, state, fired = Arc(self, time, state, mode).end(min(end, duration))
                if fired:
                    kind, mode, state = self.after(time, state, mode, *fired)
                    found.append(Happening(time, kind, state, mode))
        return first, found[:most], found[most - 1].state if len(found) >= most else state

    def entered(self, state: np.ndarray) -> tuple[dict, np.ndarray]:
        """The mode in which a motion begins; what has no speed may rest or move."""
        slip, travel = self.speeds(state)
        ways = {"slip": sign(slip), "bearing": sign(state[1]), "slide": sign(travel)}
        return self.choose(0.0, state, ways, [name for name in self.dry if not ways[name]], {})

    def after(self, time: float, state: np.ndarray, mode: dict, contact: str, way: int) -> tuple[str, dict, np.ndarray]:
        """What happens where the margin of a contact is gone, and the mode and state after it.

        A ``way``: the contact was at rest and begins to move there. None: the contact force turns over, or what moved
        stops.
        """
        if contact == "contact":
            return "contact_reversal", mode | {"contact": -mode["contact"]}, state
        still = [name for name in self.dry if mode[name] == 0 or name == contact]
        mode, state = self.choose(time, state, mode, still, {contact: way} if way else {})
        kind = "release" if way else "reversal" if mode[contact] else "stick"
        return kind if contact == "slip" else f"{contact}_{kind}", mode, state

    def choose(self, time: float, state, before: dict, still: list, forced: dict) -> tuple[dict, np.ndarray]:
        """The mode that goes on, and the state with what is still at no speed.

        Tried are all ways of what is ``still``, but ``forced`` ones as they are: more at rest first, then threads at
        rest, then what was at rest before.
        """
        options = [
            (forced[name],) if name in forced else (0, 1, -1) if name in still else (before[name],) for name in self.dry
        ]

        def moving(ways):
            lost = sum(way != 0 and before[name] == 0 for name, way in zip(self.dry, ways, strict=True))
            return sum(map(abs, ways)), abs(ways[0]), lost

        state = self.settled(state, still)
        for ways in sorted(product(*options), key=moving):
            mode = dict.fromkeys(self.frictions, ways[0]) | dict(zip(self.dry, ways, strict=True))
            for side in (1, -1) if ways[0] or self.free("slide") else (0,):
                if Arc(self, time, state, mode | {"contact": side}).lasts(still):
                    return mode | {"contact": side}, state
        if forced:  # what lets go is held again by the force that another one, which lets go with it, then has
            return self.choose(time, state, before, still, {})
        raise AssertionError(f"no mode is consistent at {time} s, {state.tolist()}, after {before}")

    def settled(self, state: np.ndarray, still: list) -> np.ndarray:
        """A state in which what is still has no speed, but for rounding the same."""
        state, turns = state.copy(), "phi" in self.place
        if ("bearing" if turns else "slip") in still:
            state[1] = 0.0
        if turns and "slip" in still:
            state[self.place["phi"] + 1] = state[1]
        if "slide" in still:
            state[self.place["y" if "y" in self.place else "e"] + 1] -= self.speeds(state)[1]
        return state

    def frozen(self, state: np.ndarray) -> Bodies:
        """The drive with the friction that the threads have at a state."""
        same, slip = copy.copy(self), self.speeds(state)[0]
        constant = {"friction_coefficient": self.mu(slip), "static_friction_coefficient": self.static()}
        same.p = copy.copy(self.p)
        same.p |= constant | {"stribeck_rise": 0.0, "friction_slope": 0.0}
        return same


class Arc:
    """A mode from a state on: its rates and margins as affine functions of the state and of the time since then.

    Under a law of friction they are those of the friction at its beginning; states and margins along it are exact.
    """

    def __init__(self, laws: Contacts, begin: float, state: np.ndarray, mode: dict) -> None:
        self.laws, self.begin, self.state, self.mode = laws, begin, state, mode
        self.law = mode["slip"] != 0 and bool(laws.p["stribeck_rise"] or laws.p["friction_slope"])
        same = laws.frozen(state)
        self.margins = [*laws.margins(state, mode)]
        rows = affine(lambda x: same.rate(begin + x[-1], x[:-1], mode), state.size + 1)
        self.rows = affine(lambda x: np.array([*same.margins(x[:-1], mode).values()]), state.size + 1)
        matrix = np.vstack([rows, np.zeros((2, state.size + 2))])
        matrix[-2, -1] = 1.0
        self.matrix, (self.scale, _) = matrix_balance(matrix, permute=False, separate=True)
        self.rows *= self.scale
        self.rates = np.linalg.eigvals(self.matrix)

    def place(self, time: float, state: np.ndarray) -> np.ndarray:
        """State and time as the matrix takes them."""
        return np.array([*state, time - self.begin, 1.0]) / self.scale

    def lasts(self, still: list) -> bool:
        """Whether nothing that the mode takes for granted is violated at its beginning or just after it.

        What is ``still`` has no speed yet.
        """
        rows, place = self.rows, self.place(self.begin, self.state)
        most, sizes, signs = np.abs(rows), np.abs(self.matrix), np.zeros(len(rows))
        moving = np.array([unit in ("speed", "travel") for *_, unit in self.margins])
        unknown = moving & [contact in still for contact, *_ in self.margins]
        for _ in range(8):
            values = rows @ place
            unknown |= (signs != 0) | (np.abs(values) <= DECIDED * (most @ np.abs(place)))
            signs, unknown = np.where(unknown, signs, np.sign(values)), np.zeros_like(moving)
            rows, most = rows @ self.matrix, most @ sizes
        return not (signs < 0).any() and (signs[moving] > 0).all()

    def through(self, time: float, state: np.ndarray, times: np.ndarray) -> np.ndarray:
        """States at times from one before them."""
        if self.law:
            run = solve_ivp(
                lambda t, x: self.laws.rate(t, x, self.mode), (time, times[-1]), state, "DOP853", times, rtol=3e-14,
                atol=1e-16 * self.laws.sizes,
            )  # fmt: skip
            return run.y.T
        place = self.place(time, state)
        return np.array([expm(self.matrix * (t - time)) @ place for t in times])[:, :-2] * self.scale[:-2]

    def evenly(self, time: float, state: np.ndarray, step: float) -> np.ndarray:
        """States of a window of equal steps."""
        if self.law:
            return self.through(time, state, time + step * np.arange(1, WINDOW + 1))
        power, places = expm(self.matrix * step), [self.place(time, state)]
        for _ in range(WINDOW):
            places.append(power @ places[-1])
        return np.array(places[1:])[:, :-2] * self.scale[:-2]

    def windows(self, end: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Samples: doubling from next to nothing, then a tenth of the fastest swing's radian that has not yet died."""
        time, state, doubling = self.begin, self.state, True
        while time < end:
            lasting = self.rates[self.rates.real * (time - self.begin) > -40.0]
            step = 0.1 / max(np.abs(lasting).max(), 1.0 / (end - self.begin))
            ahead = 2.0 ** np.arange(-24, 1) if doubling else np.arange(1, WINDOW + 1)
            times = time + step * ahead
            if doubling or times[-1] >= end:
                times = np.unique(np.minimum(times, end))
                states = self.through(time, state, times)
            else:
                states = self.evenly(time, state, step)
            yield times, states
            time, state, doubling = times[-1], states[-1], False

    def values(self, times: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Margins at samples (times, margins), and what rounding makes of zero there."""
        places = np.array([self.place(time, state) for time, state in zip(times, states, strict=True)])
        floors = FLOOR * np.abs(places) @ np.abs(self.rows).T
        if self.law:
            return np.array([[*self.laws.margins(state, self.mode).values()] for state in states]), floors
        return places @ self.rows.T, floors

    def end(self, end: float) -> tuple[float, np.ndarray, tuple[str, int] | None]:
        """Time, state, and the contact and the way whose margin is gone first, or None at the given end."""
        times, states = np.array([self.begin]), self.state[None]
        armed = np.zeros(len(self.margins), dtype=bool)
        for more, onward in self.windows(end):
            times, states = np.append(times[-2:], more), np.vstack([states[-2:], onward])
            values, floors = self.values(times, states)
            gone = []
            for k, (value, floor) in enumerate(zip(values.T, floors.T, strict=True)):
                seen = armed[k] | np.logical_or.accumulate(value > floor)
                assert not (~seen & (value < -100 * floor)).any(), f"{self.margins[k]} is gone at once"
                gone += self.gone(k, times, states, value, floor, seen)
                armed[k] = seen[-1]
            if gone:
                time, k, state = min(gone, key=lambda one: one[0])
                return time, state, self.margins[k][:2]
        return end, states[-1], None

    def gone(self, k: int, times, states, value, floor, seen) -> list[tuple[float, int, np.ndarray]]:
        """When a margin first comes to zero among samples, also between two of them, and the state then; or nothing."""

        def margin(time, i):
            state = self.through(times[i], states[i], np.array([time]))[-1] if time > times[i] else states[i]
            return self.values(np.array([time]), state[None])[0][0, k]

        for i in range(1, len(times)):
            first, last = i - 1, times[i] if value[i] < 0 else None
            if last is None and 1 < i and value[i - 2] > value[i - 1] <= value[i]:  # a minimum near i − 1
                first = i - 2
                if value[i - 1] < max(value[i - 2], value[i]) - value[i - 1]:
                    low = minimize_scalar(
                        margin, bounds=(times[first], times[i]), args=(first,), method="bounded",
                        options={"xatol": 1e-9 * (times[i] - times[first])},
                    )  # fmt: skip
                    last = low.x if low.fun < -floor[i] else None
            if last is not None and seen[first]:
                time = brentq(margin, times[first], last, args=(first,), xtol=1e-300, rtol=1e-15)
                return [(time, k, self.through(times[first], states[first], np.array([time]))[-1])]
        return []
