"""Motions with static friction in every dry contact at once, whose modes and events are found from the forces alone.

On Newton's laws body by body (:mod:`references.bodies`). A contact, of the threads, of the slide or of the bearing, is
at rest or moves one way. At each event, and at the start, all that has no speed is held; if one contact then needs more
friction than it has, it lets go, and if several do, all combinations are tried. Margins that are zero to rounding are
judged by their first rate that is not.
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


class Happening(NamedTuple):
    """An event: its time [s], what it is called, and the absolute state and the mode after it."""

    time: float
    kind: str
    state: np.ndarray
    mode: dict


def affine(function, size: int) -> np.ndarray:
    """The matrix of an affine function of some numbers, its constant last; what is zero but for rounding is zero."""

    def matrix(step: float, origin: float) -> np.ndarray:
        base = function(np.full(size, origin))
        rows = np.column_stack([(function(origin + x) - base) / step for x in step * np.eye(size)])
        return np.column_stack([rows, base - rows.sum(axis=1) * origin])

    found, again = matrix(FAR, 0.0), matrix(1.37 * FAR, 1e-6)  # rounding comes out otherwise by other points
    return np.where(np.abs(found - again) <= 1e-3 * np.abs(found), found, 0.0)


class Contacts(Bodies):
    """A drive, with a command that is straight between given ``speeds`` at given ``times`` (constant without them)."""

    def __init__(self, drive, times=(), speeds=()) -> None:
        super().__init__(drive)
        self.frictions = [body for body in ("bearing", "slide") if self.most(body)]
        self.dry = ["slip", *filter(self.free, self.frictions)]  # what may rest or move by itself
        rates = [(self.p["input_speed"] or 1.0) * (self.lead if name in "ye" else 1.0) for name in self.q]
        self.sizes = np.abs(self.steady) + np.abs(np.kron(rates, [1e-3, 1.0]))  # rates over a millisecond
        speeds = [*speeds] or [self.p["input_speed"]]
        knots = [(0.0, speeds[0]), *zip(times, speeds, strict=False), (np.inf, speeds[-1])]
        self.pieces = [(a, b, v, (w - v) / (b - a)) for (a, v), (b, w) in pairwise(knots) if b > a]

    def follow(self, state: np.ndarray, duration: float, most: int) -> tuple[dict, list[Happening]]:
        """The first mode of a motion from an absolute state, its events; the last is the end, or what is cut off."""
        found, first = [], {}
        for time, end, speed, rate in self.pieces:
            self.commanded = lambda t, begin=time, speed=speed, rate=rate: speed + rate * (t - begin)
            if not first:
                slip, travel = self.speeds(state)  # what has none may rest or move
                ways = {"slip": sign(slip), "bearing": sign(state[1]), "slide": sign(travel)}
                first, state = self.choose(0.0, state, ways, [name for name in self.dry if not ways[name]], {})
                if first["slip"] and Arc(self, 0.0, state, first).signs([]).get(("contact", 0, "force"), 1) < 0:
                    first, state = self.seized(0.0, state, first)
                mode = first
            elif time < duration:
                found.append(Happening(time, "command", state, mode))
            while time < min(end, duration) and len(found) < most:
                time, state, fired = Arc(self, time, state, mode).end(min(end, duration))
                if fired:
                    kind, mode, state = self.after(time, state, mode, *fired)
                    found.append(Happening(time, kind, state, mode))
        return first, [*found, Happening(duration, "end", state, mode)]

    def after(self, time: float, state: np.ndarray, mode: dict, contact: str, way: int) -> tuple[str, dict, np.ndarray]:
        """What happens where a margin is gone, mode and state after it; ``way``: that in which a contact lets go."""
        if contact == "jam" or (contact == "contact" and mode["contact"] != mode["slip"] and self.inertia(state) <= 0):
            return "seizure", *self.seized(time, state, mode)
        if contact == "contact":
            return "contact_reversal", mode | {"contact": -mode["contact"]}, state
        still = [name for name in self.dry if mode[name] == 0 or name == contact]
        mode, state = self.choose(time, state, mode, still, {contact: way} if way else {})
        kind = "release" if way else "reversal" if mode[contact] else "stick"
        return kind if contact == "slip" else f"{contact}_{kind}", mode, state

    def inertia(self, state: np.ndarray) -> float:
        """Inertia under law + of rigid threads that slip, over that without friction; below 0 law + does not hold."""
        if "e" in self.place:
            return 1.0
        found = [np.linalg.det(self.system(state, {"slip": 1, "contact": law})[1]) for law in (1, 0)]
        return found[0] / found[1]

    def seized(self, time: float, state: np.ndarray, mode: dict) -> tuple[dict, np.ndarray]:
        """Mode and state after an impact that stops the slip; it leaves a force of its sign, with which law − slips."""
        names, matrix, sides = self.system(state, mode | {"slip": 0, "contact": 0})
        jumps = np.zeros(len(sides))
        jumps[len(self.q) + 2] = -self.speeds(state)[0]
        jumps, state = np.linalg.solve(matrix, jumps), state.copy()
        for name, k in self.place.items():
            state[k + 1] += jumps[names.index(name)]
        way = mode["slip"]
        state, turned = self.settled(state, ["slip"]), mode | {"slip": -way} | dict.fromkeys(self.frictions, -way)
        signs = Arc(self, time, state, turned | {"contact": way}).signs(["slip"])
        if min(signs.values()) > 0:
            return turned | {"contact": way}, state
        return self.choose(time, state, mode, ["slip"], {})

    def choose(self, time: float, state, before: dict, still: list, forced: dict) -> tuple[dict, np.ndarray]:
        """The mode that goes on, and the state with what is still at no speed.

        What is ``still`` is held, but for what is ``forced`` to let go. If only one contact then needs more friction
        than it has, it lets go, and so on. If several do, all combinations are tried, with more at rest first.
        """
        state = self.settled(state, still)
        mode = {name: 0 if name in still else before[name] for name in self.dry} | forced
        while True:
            arc, good, beyond = self.begun(time, state, mode, still)
            if good:
                return arc.mode, state
            if len(beyond) != 1:
                break
            mode |= beyond
        free = [name for name in still if mode[name] == 0]
        modes = [mode | dict(zip(free, ways, strict=True)) for ways in product((0, 1, -1), repeat=len(free))]

        def rank(one: dict) -> tuple:
            moving = [name for name in free if one[name]]
            return len(moving), "slip" in moving, len([name for name in moving if before[name] == 0])

        for one in sorted(modes, key=rank):
            arc, good, _ = self.begun(time, state, one, still)
            if good:
                return arc.mode, state
        raise AssertionError(f"no mode is consistent at {time} s, {state.tolist()}, after {before}")

    def begun(self, time: float, state, mode: dict, still: list) -> tuple["Arc", bool, dict]:
        """The arc of a mode, whether all holds now and just after, and what cannot be held, by the way it goes."""
        both = (1, -1) if mode["slip"] or self.free("slide") else (0,)
        for side in (-mode["slip"],) if mode["slip"] and self.inertia(state) <= 0 else both:
            arc = Arc(self, time, state, dict.fromkeys(self.frictions, mode["slip"]) | mode | {"contact": side})
            signs = arc.signs(still)
            if signs.pop(("contact", 0, "force"), 0) >= 0:
                break
        starts = all(sign > 0 for (name, way, _), sign in signs.items() if name in still and not way)
        beyond = {name: way for (name, way, _), sign in signs.items() if way and sign < 0}
        return arc, starts and not beyond, beyond

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


class Arc:
    """A mode from a state on: its rates and margins as affine functions of the state and of the time since then.

    Under a law of friction they are those of the friction at its beginning; states and margins along it are exact.
    """

    def __init__(self, laws: Contacts, begin: float, state: np.ndarray, mode: dict) -> None:
        self.laws, self.begin, self.state, self.mode = laws, begin, state, mode
        self.law = mode["slip"] != 0 and bool(laws.p["stribeck_rise"] or laws.p["friction_slope"])
        same, mu = copy.copy(laws), laws.mu(laws.speeds(state)[0])
        same.p = laws.p | {"friction_coefficient": mu, "static_friction_coefficient": laws.static()}
        same.p |= {"stribeck_rise": 0.0, "friction_slope": 0.0}
        self.margins = [*laws.margins(state, mode)]
        rows = affine(lambda x: same.rate(begin + x[-1], x[:-1], mode), state.size + 1)
        self.rows = affine(lambda x: np.array([*same.margins(x[:-1], mode).values()]), state.size + 1)
        matrix = np.vstack([rows, np.eye(2, state.size + 2, state.size + 1)])
        self.matrix, (self.scale, _) = matrix_balance(matrix, permute=False, separate=True)
        self.rows *= self.scale
        self.rates = np.linalg.eigvals(self.matrix)
        self.jammed = None  # time and state at which a law of friction comes to the Painlevé region

        def jams(_, state) -> float:
            return laws.inertia(state) - 1e-7

        jams.terminal = True
        self.jams = jams

    def place(self, time: float, state: np.ndarray) -> np.ndarray:
        """State and time as the matrix takes them."""
        return np.array([*state, time - self.begin, 1.0]) / self.scale

    def signs(self, still: list) -> dict:
        """Signs of the margins at its beginning, or of their first rates; of what is ``still`` those of the rates."""
        rows, place = self.rows, self.place(self.begin, self.state)
        most, sizes, signs = np.abs(rows), np.abs(self.matrix), np.zeros(len(rows))
        unknown = np.array([unit in ("speed", "travel") and contact in still for contact, _, unit in self.margins])
        for _ in range(8):
            values = rows @ place
            unknown |= (signs != 0) | (np.abs(values) <= DECIDED * (most @ np.abs(place)))
            signs, unknown = np.where(unknown, signs, np.sign(values)), np.zeros_like(unknown)
            rows, most = rows @ self.matrix, most @ sizes
        return dict(zip(self.margins, signs, strict=True))

    def through(self, time: float, state: np.ndarray, times: np.ndarray) -> np.ndarray:
        """States at times from one before them."""
        if self.law:
            least, self.asked = 1e-16 * self.laws.sizes, 0
            span, jams = (time, times[-1]), self.jams if self.mode["contact"] == self.mode["slip"] else None
            found = solve_ivp(self.rate, span, state, "DOP853", times, events=jams, rtol=3e-14, atol=least)
            if found.status == 1:
                self.jammed = found.t_events[0][0], found.y_events[0][0]
            return np.reshape(found.y, (len(state), -1)).T
        flows = expm(self.matrix * (times - time)[:, None, None])
        return (flows @ self.place(time, state))[:, :-2] * self.scale[:-2]

    def rate(self, time: float, state: np.ndarray) -> np.ndarray:
        self.asked += 1
        assert self.asked < 6_000, "where law + of rigid threads hardly holds, they are too stiff for this"
        return self.laws.rate(time, state, self.mode)

    def values(self, times: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Margins at samples (times, margins), and what rounding makes of zero there."""
        places = np.array([self.place(time, state) for time, state in zip(times, states, strict=True)])
        floors = FLOOR * np.abs(places) @ np.abs(self.rows).T
        if self.law:
            return np.array([[*self.laws.margins(state, self.mode).values()] for state in states]), floors
        return places @ self.rows.T, floors

    def end(self, end: float) -> tuple[float, np.ndarray, tuple[str, int] | None]:
        """Time, state, and the contact and the way whose margin is gone first, or None at the given end.

        By samples: doubling from next to nothing, then a tenth of the fastest swing's radian that has not yet died.
        """
        times, states, armed = np.array([self.begin]), self.state[None], np.zeros(len(self.margins), dtype=bool)
        ahead = 2.0 ** np.arange(-24, 1)
        while times[-1] < end:
            lasting = self.rates[self.rates.real * (times[-1] - self.begin) > -40.0]
            step = 0.1 / max(np.abs(lasting).max(), 1.0 / (end - self.begin))
            more = np.unique(np.minimum(times[-1] + step * ahead, end))
            states = np.vstack([states[-2:], self.through(times[-1], states[-1], more)])
            more = more[: len(states) - len(times[-2:])]
            times, ahead, gone = np.append(times[-2:], more), np.arange(1, 65), []
            for k, (value, floor) in enumerate(zip(*(x.T for x in self.values(times, states)), strict=True)):
                seen = armed[k] | np.logical_or.accumulate(value > floor)
                assert not (~seen & (value < -100 * floor)).any(), f"{self.margins[k]} is gone at once"
                gone += self.gone(k, times, states, value, floor, seen)
                armed[k] = seen[-1]
            if gone:
                time, k, state = min(gone, key=lambda one: one[0])
                return time, state, self.margins[k][:2]
            if self.jammed:
                return *self.jammed, ("jam", 0)
        return end, states[-1], None

    def gone(self, k: int, times, states, value, floor, seen) -> Iterator[tuple[float, int, np.ndarray]]:
        """When a margin first comes to zero among samples, also between two of them, and the state then; or nothing."""

        def margin(time, i):
            state = self.through(times[i], states[i], np.array([time]))[-1] if time > times[i] else states[i]
            return self.values(np.array([time]), state[None])[0][0, k]

        sides, low = np.maximum(value[:-2], value[2:]), value[1:-1]
        dips = np.flatnonzero((value[:-2] > low) & (low <= value[2:]) & (2 * low < sides)) + 2
        for i in sorted({*dips, *np.flatnonzero(value < 0)} - {0}):
            first, last = i - 1, times[i]
            if value[i] >= 0:
                first, ends, fine = i - 2, (times[i - 2], times[i]), {"xatol": 1e-9 * (times[i] - times[i - 2])}
                least = minimize_scalar(margin, bounds=ends, args=(first,), method="bounded", options=fine)
                if least.fun >= -floor[i]:
                    continue
                last = least.x
            if seen[first]:
                time = brentq(margin, times[first], last, args=(first,), xtol=1e-300, rtol=1e-15)
                yield time, k, self.through(times[first], states[first], np.array([time]))[-1]
                return
