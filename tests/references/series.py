"""Motions by Newton's laws (:mod:`references.bodies`) in many digits, with dry friction in every contact at once.

A contact, of the threads, of the slide or of the bearing, is at rest or moves one way. At each event, and at the start,
all that has no speed is held; if one contact then needs more friction than it has, it lets go, and if several do, all
combinations are tried. Margins that are zero to rounding are judged by their first derivative that is not.

In a mode G x' = (A + μ B) x, where G, affine in μ like the rest, is the inertia over that without friction. With
dt = G ds there is no quotient, and what seizes at G = 0 comes there at a simple zero. Under a constant coefficient x is
an exponential of the matrix, under a law a power series in s, a step of which is about a sixth of its radius.
"""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise, product
from operator import mul
from typing import NamedTuple

import numpy as np
from flint import arb, arb_mat, ctx
from scipy.linalg import matrix_balance
from scipy.optimize import minimize_scalar

from references.bodies import Bodies, sign

SPARE = 30  # working digits beyond those asked for
TERMS, TAIL = 28, 1e-23  # of a power series; its last terms over its largest
SPEEDS = "speed", "travel"  # units of margins that are not over G
FIRST = 2.0**-40  # sample of an arc, in a tenth of the fastest swing's radian
ALIKE, NOTHING = 14.0, 60.0  # change of an exponent in a step; exponent of what is below all digits of a series
Sample = tuple[arb, arb_mat, Callable]  # a number s, the place there, and what gives places from there on to the next


class Happening(NamedTuple):
    """An event: its time [s], what it is called, and the state and the mode after it."""

    time: arb
    kind: str
    state: np.ndarray
    mode: dict


class Undetermined(Exception):
    """What follows is not said by Newton's laws of rigid threads: ``beyond`` G = 0 in faster slip, or in its corner."""


def exact(x: arb) -> arb:
    """A number without its ball; zero if it may be zero."""
    return arb(0) if x.contains(0) else x.mid()


def doubles(x: arb_mat) -> np.ndarray:
    return np.array([float(value) for value in x.entries()]).reshape(x.nrows(), x.ncols())


def zero(f: Callable, low: arb, high: arb) -> arb:
    """Where a function, positive at the low end and not at the high one, is zero: secants that halve a stuck end."""
    at_low, at_high, side = f(low).mid(), f(high).mid(), 0
    while True:
        middle = (high - at_high * (high - low) / (at_high - at_low)).mid()
        if not low < middle < high or high - low < arb(10) ** (5 - ctx.dps) * high:
            return low if middle <= low else high
        value = f(middle).mid()
        if value > 0:
            low, at_low, at_high, side = middle, value, at_high / 2 if side > 0 else at_high, 1
        else:
            high, at_high, at_low, side = middle, value, at_low / 2 if side < 0 else at_low, -1
        if abs(value) < arb(10) ** (SPARE // 2 - ctx.dps) * (at_low - at_high):
            return middle


class Form:
    """Rates and margins of a mode as they are affine in μ: rates and forces times the inertia G = 1 + loss μ."""

    def __init__(self, laws: "Series", mode: dict) -> None:
        def affine(first, second) -> tuple[arb_mat, arb_mat]:
            """Rows at μ = 0 and their slopes, from those at a step."""
            return tuple(arb_mat([[*map(exact, row)] for row in part]) for part in (first, (second - first) / step))

        step = arb(2) ** -10
        self.still, turning = (laws.equations(mode, mu)[1].det() for mu in (arb(0), step))
        self.loss = exact((turning / self.still - 1) / step)
        self.rates = affine(laws.rates(mode, arb(0)), laws.rates(mode, step) * (1 + self.loss * step))
        first, second = (laws.margins(mode, mu) for mu in (arb(0), step))
        second = {name: row * (1 if name[2] in SPEEDS else 1 + self.loss * step) for name, row in second.items()}
        self.margins, self.rows = [*first], affine(*(np.array([*part.values()]) for part in (first, second)))
        self.sizes = [np.abs(doubles(part)) for part in self.rows]


class Series(Bodies):
    """A drive, with a command that is straight between given ``speeds`` at given ``times`` (constant without them)."""

    def __init__(self, drive, times=(), speeds=(), digits: int = 40) -> None:
        self.digits, self.forms = digits, {}
        with ctx.workdps(digits + SPARE):
            super().__init__(drive)
            self.ways = {contact: arb_mat([list(row)]) for contact, row in self.speeds.items()}
            self.frictions = [body for body in ("bearing", "slide") if self.most(body) > 0]
            self.dry = ["slip", *filter(self.free, self.frictions)]  # what may rest or move by itself
            speeds = [arb(speed) for speed in speeds] or [self.p["input_speed"]]
            times = [arb(0), *map(arb, times), arb(math.inf)]
            knots = pairwise(zip(times, [speeds[0], *speeds, speeds[-1]][: len(times)], strict=True))
            self.pieces = [(a, b, v, (w - v) / (b - a) if w != v else arb(0)) for (a, v), (b, w) in knots if b > a]
            self.varies = bool(self.p["stribeck_rise"] != 0 or self.p["friction_slope"] != 0)
            plus, minus = (self.form({"slip": 1, "contact": side}) for side in (1, -1))  # laws of rigid threads
            self.loss, self.turned = plus.loss, sign(plus.still / minus.still)  # −1 where a collar alone seizes

    def form(self, mode: dict) -> Form:
        key = tuple(sorted(mode.items()))
        if key not in self.forms:
            self.forms[key] = Form(self, mode)
        return self.forms[key]

    def speed(self, place: arb_mat, contact: str = "slip"):
        """A speed at a place: a column of the state, the commanded speed, its rate, the time, and 1."""
        return (self.ways[contact] * place)[0, 0].mid()

    def inertia(self, slip):
        """Inertia under law + of rigid threads, over that without friction; below 0 law + does not hold."""
        return self.turned * (1 + self.loss * self.mu(slip))

    def follow(self, state, duration: float, most: int, watched: dict | None = None) -> tuple[dict, list[Happening]]:
        """The first mode of a motion from a state, its events; the last is the end, or what is cut off.

        States are those of the package; what is zero but for their rounding is zero, as of a relaxed spring.
        ``watched``: functions of place and mode, by the name that the event at which they are zero shall have.
        """
        with ctx.workdps(self.digits + SPARE):
            found, first, mode, place, duration = [], {}, {}, None, arb(duration)
            self.largest = np.zeros(self.size + 4)  # of all places, by which rounding is told
            self.arcs = []  # with the places at their ends
            try:
                for begin, end, *command in self.pieces:
                    if place is None:
                        pairs = [(x, x + steady) for x, steady in zip(map(arb, state), self.steady, strict=True)]
                        whole = [y if abs(y) >= 1e-14 * abs(x) else 0 for x, y in pairs]
                        place = arb_mat([[arb(x)] for x in (*whole, *command, begin, 1)])
                        first, place = self.begin(place)
                        mode = first
                    elif begin < duration:
                        place[self.size, 0], place[self.size + 1, 0] = command
                        found.append(self.happening("command", place, mode))
                    arc, last = Arc(self, place, mode, watched), min(end, duration)
                    while begin < duration and len(found) < most:
                        place, fired = arc.end(last)
                        self.arcs.append((arc, place))
                        if fired[0] == "end":
                            break
                        kind, clamped = fired[0], None
                        if kind == "law":
                            clamped = not arc.clamped
                        elif kind not in arc.watched:
                            kind, mode, place = self.after(place, mode, *fired)
                        if kind != "law":
                            found.append(self.happening(kind, place, mode))
                        arc = Arc(self, place, mode, watched, clamped)
            except Undetermined as why:
                return first, [*found, self.happening(str(why), place, mode)]
            return first, [*found, self.happening("end", place, mode)]

    def happening(self, kind: str, place: arb_mat, mode: dict) -> Happening:
        *state, _, _, time, _ = place.entries()
        return Happening(time, kind, np.array(state) - self.steady, mode)

    def begin(self, place: arb_mat) -> tuple[dict, arb_mat]:
        """The first mode, and the place after what is at once."""
        ways = {contact: sign(self.speed(place, contact)) for contact in ("slip", *self.frictions)}
        mode, place = self.choose(place, ways, [name for name in self.dry if not ways[name]], {})
        if mode["slip"] and Arc(self, place, mode).signs([]).get(("contact", 0, "force"), 1) < 0:
            if self.grows(place):
                raise Undetermined("beyond")
            mode, place = self.seized(place, mode)
        return mode, place

    def after(self, place: arb_mat, mode: dict, contact: str, way: int) -> tuple[str, dict, arb_mat]:
        """What happens where a margin is gone, mode and place after it; ``way``: that in which a contact lets go."""
        jams = contact == "contact" and mode["contact"] != mode["slip"] and not self.inertia(self.speed(place)) > 0
        if contact == "jam" or jams:
            if self.grows(place):
                raise Undetermined("beyond")
            return "seizure", *self.seized(place, mode)
        if contact == "contact":
            return "contact_reversal", mode | {"contact": -mode["contact"]}, place
        still = [name for name in self.dry if mode[name] == 0 or name == contact]
        mode, place = self.choose(place, mode, still, {contact: way} if way else {})
        kind = "release" if way else "reversal" if mode[contact] else "stick"
        return kind if contact == "slip" else f"{contact}_{kind}", mode, place

    def grows(self, place: arb_mat) -> bool:
        """Whether friction has grown with speed to where law + does not hold."""
        slower = (self.inertia(self.speed(place) * float(x)) > 0 for x in np.linspace(0.01, 0.999, 100))
        return bool(self.p["friction_slope"] > 0) and any(slower)

    def seized(self, place: arb_mat, mode: dict) -> tuple[dict, arb_mat]:
        """Mode and place after an impact that stops the slip; it leaves a force of its sign, with which law − slips."""
        names, equations, _ = self.equations(mode | {"slip": 0, "contact": 0}, arb(0))
        jumps = arb_mat(len(names), 1)
        jumps[len(self.q) + 2, 0] = -self.speed(place)
        jumps, place = equations.solve(jumps), place * 1
        for name, k in self.place.items():
            place[k + 1, 0] += jumps[names.index(name), 0]
        way = mode["slip"]
        place, turned = self.settled(place.mid(), ["slip"]), mode | {"slip": -way} | dict.fromkeys(self.frictions, -way)
        if min(Arc(self, place, turned | {"contact": way}).signs(["slip"]).values()) > 0:
            return turned | {"contact": way}, place
        return self.choose(place, mode, ["slip"], {})

    def choose(self, place: arb_mat, before: dict, still: list, forced: dict) -> tuple[dict, arb_mat]:
        """The mode that goes on, and the place with what is still at no speed.

        What is ``still`` is held, but for what is ``forced`` to let go. If only one contact then needs more friction
        than it has, it lets go, and so on. If several do, all combinations are tried, with more at rest first.
        """
        place = self.settled(place, still)
        mode = {name: 0 if name in still else before[name] for name in self.dry} | forced
        while True:
            whole, good, beyond = self.begun(place, mode, still)
            if good:
                return whole, place
            if len(beyond) != 1:
                break
            mode |= beyond
        free = [name for name in still if mode[name] == 0]
        modes = [mode | dict(zip(free, ways, strict=True)) for ways in product((0, 1, -1), repeat=len(free))]

        def rank(one: dict) -> tuple:
            moving = [name for name in free if one[name]]
            return len(moving), "slip" in moving, len([name for name in moving if before[name] == 0])

        for one in sorted(modes, key=rank):
            whole, good, _ = self.begun(place, one, still)
            if good:
                return whole, place
        raise AssertionError(f"no mode is consistent at {place.str(10)}, after {before}")

    def begun(self, place: arb_mat, mode: dict, still: list) -> tuple[dict, bool, dict]:
        """A mode with its contact, whether all holds and goes on, and what cannot be held, by the way it goes."""
        both = (1, -1) if mode["slip"] or self.free("slide") else (0,)
        for side in (-mode["slip"],) if mode["slip"] and not self.inertia(self.speed(place)) > 0 else both:
            whole = dict.fromkeys(self.frictions, mode["slip"]) | mode | {"contact": side}
            signs = Arc(self, place, whole).signs(still)
            if signs.pop(("contact", 0, "force"), 0) >= 0:
                break
        starts = all(sign > 0 for (name, way, _), sign in signs.items() if name in still and not way)
        beyond = {name: way for (name, way, _), sign in signs.items() if way and sign < 0}
        return whole, starts and not beyond, beyond

    def settled(self, place: arb_mat, still: list) -> arb_mat:
        """A place in which what is still has no speed, but for rounding the same."""
        place, turns = place * 1, "phi" in self.place
        if ("bearing" if turns else "slip") in still:
            place[1, 0] = arb(0)
        if turns and "slip" in still:
            place[self.place["phi"] + 1, 0] = place[1, 0]
        if "slide" in still:
            place[self.place["y" if "y" in self.place else "e"] + 1, 0] -= self.speed(place, "slide")
        return place


class Arc:
    """A mode from a place on; ``clamped``: whether a law that would be negative is zero."""

    def __init__(self, laws: Series, place: arb_mat, mode: dict, watched=None, clamped: bool | None = None) -> None:
        self.laws, self.place, self.mode, self.form = laws, place, mode, laws.form(mode)
        law = laws.varies and mode["slip"] != 0
        self.clamped = bool(self.raw(place) < 0) if clamped is None else clamped
        self.law, self.mu = law and not self.clamped, arb(0) if self.clamped else laws.mu(laws.speed(place))
        self.matrix = (self.form.rates[0] + self.form.rates[1] * self.mu).mid()
        self.extra = {"end": lambda place: -place[laws.size + 2, 0]}  # what has to be positive beside the margins
        if law:
            self.extra["law"] = lambda place: self.raw(place) * (-1 if self.clamped else 1)
        if self.law and mode["contact"] == mode["slip"]:
            self.extra["jam"] = lambda place: 1 + self.form.loss * self.raw(place)
        self.watched = [name for name, one in (watched or {}).items() if one(place, mode) is not None]
        self.extra |= {name: lambda place, one=watched[name]: one(place, mode) for name in self.watched}

    def raw(self, place: arb_mat):
        """The law, also where it is negative."""
        return self.laws.law(self.laws.speed(place))

    def friction(self, place: arb_mat):
        return self.raw(place) if self.law else self.mu

    def coefficients(self, place: arb_mat, terms: int) -> tuple[list[arb_mat], list[arb]]:
        """Power series of the place in s, and of μ."""
        p, (fixed, rubbed), places, mu = self.laws.p, self.form.rates, [place], []
        slip, lever = self.laws.ways["slip"], self.mode["slip"] * p["pitch_radius"] / self.laws.cos
        ratio, square = lever / (p["stribeck_speed"] if p["stribeck_rise"] != 0 else 1), p["stribeck_exponent"] == 2
        turned, steep, fade = [], [], []
        for k in range(terms):
            turned.append((slip * places[k])[0, 0])
            if self.law:
                mu.append(p["friction_slope"] * lever * turned[k] + (p["friction_coefficient"] if k == 0 else 0))
                power = -ratio * (ratio * sum(map(mul, turned, turned[::-1])) if square else turned[k])
                steep.append(k * power)
                fade.append(sum(map(mul, steep[1:], fade[::-1])) / k if k else power.exp())
                mu[k] += p["stribeck_rise"] * fade[k]
            elif k == 0:
                mu.append(self.mu)
            places.append((fixed * places[k] + rubbed * convolved(mu, places, k)) * (arb(1) / (k + 1)))
        return places, mu

    def signs(self, still: list) -> dict:
        """Signs of the margins at its beginning, or of their first rates; of what is ``still`` those of the rates."""
        sizes = np.maximum(self.laws.largest, np.abs(doubles(self.place)[:, 0])) * 10.0 ** (10 - self.laws.digits)
        balls = [[x + arb(0, size) if x != 0 else x] for x, size in zip(self.place.entries(), sizes, strict=True)]
        places, mu = self.coefficients(arb_mat(balls), 8)
        signs, (fixed, rubbed) = dict.fromkeys(self.form.margins, 0), self.form.rows
        for k in range(8):
            values = (fixed * places[k] + rubbed * convolved(mu, places, k)).entries()
            for name, value in zip(signs, values, strict=True):
                known = k > 0 or name[0] not in still or name[2] not in SPEEDS
                signs[name] = signs[name] or known * sign(value)
        return signs

    def exactly(self, k: int, place: arb_mat):
        """A margin, or what else has to be positive, at a place."""
        fixed, rubbed = self.form.rows
        if k < fixed.nrows():
            return ((fixed + rubbed * self.friction(place)) * place)[k, 0]
        return [*self.extra.values()][k - fixed.nrows()](place)

    def values(self, place: arb_mat) -> tuple[np.ndarray, np.ndarray]:
        """All of them as doubles, and what rounding makes of zero there."""
        mu, (fixed, rubbed), sizes = self.friction(place), self.form.rows, self.form.sizes
        values = [*((fixed + rubbed * mu) * place).entries(), *(one(place) for one in self.extra.values())]
        self.laws.largest = np.maximum(self.laws.largest, np.abs(doubles(place)[:, 0]))
        floors = (sizes[0] + sizes[1] * abs(float(mu))) @ self.laws.largest
        floors = [*floors, *[1.0] * len(self.extra)]
        return np.array([float(x) for x in values]), 10.0**-self.laws.digits * np.array(floors)

    def by_exponential(self, end) -> Iterator[Sample]:
        """First next to nothing, then steps that double up to a tenth of a radian of the fastest swing that lasts."""
        balanced, _ = matrix_balance(doubles(self.matrix), permute=False)
        rates = np.linalg.eigvals(balanced)
        whole = float((end - self.place[self.laws.size + 2, 0]) / (1 + self.form.loss * self.mu))

        def longest(s: float) -> float:
            return 0.1 / max(np.abs(rates[rates.real * s > -40.0]).max(initial=0.0), 1.0 / whole)

        s, place, step = arb(0), self.place, FIRST * longest(0.0)
        flow = (self.matrix * arb(step)).exp().mid()
        while True:
            yield s, place, lambda ds, place=place: ((self.matrix * ds).exp() * place).mid()
            s, place = s + step, (flow * place).mid()
            if 2 * step <= min(float(s), longest(float(s))):
                step, flow = 2 * step, (flow * flow).mid()

    def by_series(self) -> Iterator[Sample]:
        """Five samples a step of a power series, and first some from next to nothing on, as slip may end at once."""
        begin, place, parts = arb(0), self.place, [0.0, *8.0 ** np.arange(-8, 0), 0.2, 0.4, 0.6, 0.8]
        for _ in range(4000):
            if abs(1 + self.form.loss * self.raw(place)) < 1e-20:
                raise Undetermined("corner")
            places = [one.mid() for one in self.coefficients(place, TERMS)[0]]
            step = self.step(places)

            def at(s, places=places):
                total = places[-1]
                for one in places[-2::-1]:
                    total = total * s + one
                return total.mid()

            for part in parts:
                ahead = arb(step * part)
                yield begin + ahead, at(ahead), lambda ds, at=at, ahead=ahead: at(ahead + ds)
            begin, place, parts = begin + arb(step), at(arb(step)), [0.0, 0.2, 0.4, 0.6, 0.8]
        raise AssertionError("where law + of rigid threads hardly holds, they are too stiff for this")

    def step(self, places: list[arb_mat]) -> float:
        """How far a series is good; the exponential of a law, which may only begin to count, not farther than it is."""
        p, rows = self.laws.p, np.hstack([doubles(one) for one in places])
        with np.errstate(divide="ignore", invalid="ignore"):
            logs = np.log(np.abs(rows[: self.laws.size]))
            radii = [
                ((logs[:, :3] - logs[:, [n]]) / (n - np.arange(3))).max(axis=1) + math.log(TAIL) / n
                for n in (TERMS - 1, TERMS)
            ]
        step = float(np.exp(np.nanmin(radii)))
        if p["stribeck_rise"] != 0:
            unit, power = self.laws.cos * p["stribeck_speed"] / p["pitch_radius"], float(p["stribeck_exponent"]) or 1.0
            speeds = self.mode["slip"] * (doubles(self.laws.ways["slip"]) @ rows)[0, ::-1] / float(unit)
            most = min(speeds[-1] ** power - ALIKE, NOTHING)
            while (least := np.polyval(speeds, step * np.linspace(0, 1, 9)).min()) * abs(least) ** (power - 1) < most:
                step /= 2
        return step

    def end(self, end) -> tuple[arb_mat, tuple[str, int]]:
        """The place, and the contact and the way whose margin is gone first, or what else is zero there first."""
        self.extra["end"] = lambda place: end - place[self.laws.size + 2, 0]
        names = [*(name[:2] for name in self.form.margins), *((name, 0) for name in self.extra)]
        watched = np.array([name in self.watched for name, _ in names])
        ways, seen, last, found = np.ones(len(names)), np.zeros(len(names), dtype=bool), [], []
        for s, place, flow in self.by_series() if self.law else self.by_exponential(end):
            value, floor = self.values(place)
            fresh = ~seen & (np.abs(value) > floor)
            ways[fresh & watched] = np.sign(value[fresh & watched])  # of what is watched either sign is right
            value = value * ways
            assert not (fresh & (value < -100 * floor)).any(), "a margin is gone at once"
            seen = seen | (value > floor)
            last = [*last[-2:], (s, flow, value, seen)]
            for k in range(len(names)) if len(last) > 1 else ():
                found += [(time, k) for time in self.gone(k, ways[k], floor[k], last)]
            if found and not min(found)[0] > last[-2][0]:  # with a sample behind it, which tells of one more touch
                time, k = min(found)
                return through(last, time), names[k]
        raise AssertionError("there is no end")

    def gone(self, k: int, way: float, floor: float, last: list) -> Iterator[arb]:
        """Where a margin first comes to zero among three samples, also between two of them; or nothing."""

        def margin(s):
            return way * self.exactly(k, through(last, s))

        values, (begin, _, value, seen) = [sample[2][k] for sample in last], last[-2]
        high = last[-1][0]
        if values[-1] >= -floor:  # what dies away comes to the rounding of zero, and not to zero
            low, sides = values[-2], max(values[0], values[-1])
            if len(last) < 3 or not (values[0] > low <= values[-1] and 2 * low < sides and last[0][3][k]):
                return
            begin, value, span = last[0][0], last[0][2], float(high - last[0][0])
            options = {"bounds": (0, span), "method": "bounded", "options": {"xatol": 1e-9 * span}}
            least = minimize_scalar(lambda ds: float(margin(begin + ds)), **options)
            if least.fun >= -floor:
                return
            high = begin + least.x
        elif not seen[k] or value[k] < 0:
            return
        yield zero(margin, begin, high)


def convolved(mu: list, places: list[arb_mat], k: int) -> arb_mat:
    """The term of a product of power series."""
    total = places[k] * mu[0]
    for j in range(1, min(k + 1, len(mu))):
        total = total + places[k - j] * mu[j]
    return total


def through(samples: list, s) -> arb_mat:
    """The place at a number s, from the last sample before it."""
    begin, flow, *_ = next(sample for sample in reversed(samples) if sample[0] <= s)
    return flow(s - begin)
