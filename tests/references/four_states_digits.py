"""Reference with 40 digits for the drives with four states: Newton's laws, closed forms, certified search.

Compliant threads, axial support, rotating nut. The contact is described by its normal force N and the friction
f along the helix, as unknowns beside the accelerations:

    axial force of the threads on the nut  -(N cos + f sin),     torque on the screw  -r (f cos - N sin),

the screw of the support model shifts by x_1 under +(N cos + f sin), the nut of the nut model turns by theta_2 under
+r (f cos - N sin); compliant threads press with N = cos (k_c e + c_c e'), e = x - r tan(lambda) theta. Slip in the
direction d: f = d mu |N|. Rest: the relative speed stays zero and |f| <= mu_s |N|.

A mode is (d, q, a): direction of slip (0: rest), sign of N (with a support that of the axial contact force at rest; 0
where it plays no part), direction of the second friction - F_0 on the slide of the support model, T_0 on the screw of
the nut model - or 0 where that body is held, or None where the scene has no such friction. The friction that acts along
with the slip is T_0 in the support model and F_0 in the nut model; rest lasts while the threads hold with that friction
at either end.

After an event the mode follows whose own flow fulfils its own conditions (``lasts``):
they are tried out one by one. In the Painleve region only law -1 is tried; if N = 0 there, the impact is computed from
the impulses of N and f.

The closed form of the motion and the search for roots are those of ``exponential_sums.py``. Speeds that a mode ties are
eliminated from its field, so that the rates left over are the modal ones and one zero for each tie. A mode follows if
each of its conditions holds; a condition that is zero holds if its first derivative along the mode's own flow that is
not zero is positive.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from mpmath import mp, mpf

from references.exponential_sums import UNIT, Function, TrueArc, affine, first_root, summed


class FourStatesDrive:
    """Parameters p (SI units, keys of the library); ``frictions`` names those of F_0 and T_0 that are there.

    State: u, w; the deviation of x_1 or theta_2 from steady sliding, or e, with its rate. Modes are made once.
    """

    def __init__(self, model, parameters, frictions=()):
        self.model, self.known, self.solved, self.inverses = model, {}, {}, {}
        self.p = p = {key: mpf(value) for key, value in parameters.items()}
        self.cos, self.sin, self.tan = (f(p["lead_angle"]) for f in (mp.cos, mp.sin, mp.tan))
        self.F0, self.T0 = (p.get(name, 0) * (name in frictions) for name in ("slide_friction", "bearing_friction"))
        self.along, self.second = (self.F0, self.T0) if model == "nut" else (self.T0, self.F0)
        self.reach, self.Omega = p["pitch_radius"] * self.tan, p["input_speed"]
        turning = 1 if self.Omega > 0 else -1
        # Steady sliding: screw at Omega, no shift of the screw, no rotation of the nut.
        axial = p["axial_force"] - p["translation_damping"] * self.reach * self.Omega - self.F0 * turning
        law = -1 if axial * turning < 0 else 1
        normal = axial / (self.cos + law * p["friction_coefficient"] * self.sin)
        torque = p["pitch_radius"] * normal * (law * p["friction_coefficient"] * self.cos - self.sin)
        self.z0 = -(torque + p["support_damping"] * self.Omega + self.T0 * turning) / p["coupling_stiffness"]
        self.static = p.get("static_friction_coefficient") or p["friction_coefficient"]
        inertia, own, self.q0 = p["screw_inertia"], p["mass"], mpf(0)
        if model == "support":
            self.q0 = axial / p["support_stiffness"]
            own = p["screw_mass"] * own / (p["screw_mass"] + own)
        elif model == "nut":
            self.q0 = torque / p["nut_stiffness"]
            inertia = inertia * p["nut_inertia"] / (inertia + p["nut_inertia"])
        xi = (p["friction_coefficient"] - self.tan) / (1 + p["friction_coefficient"] * self.tan)
        self.painleve = model != "threads" and inertia <= xi * self.tan * own * p["pitch_radius"] ** 2

    def speeds(self, x):
        """(speed of slip, speed of the second body, speed x' of the nut)."""
        if self.model == "nut":
            slip = self.Omega + x[1] - x[3]
            return slip, self.Omega + x[1], self.reach * slip
        travel = self.reach * (self.Omega + x[1]) + x[3]
        return self.Omega + x[1], travel, travel

    def bodies(self):
        """Rows of inertia and of the contact's forces over (theta'', second, N, f), and that of slip."""
        p, m, reach = self.p, self.p["mass"], self.reach
        arm = [-p["pitch_radius"] * self.sin, p["pitch_radius"] * self.cos]  # torque the threads take from the screw
        screw = [p["screw_inertia"], 0, *arm]
        if self.model == "nut":
            turning = [0, p["nut_inertia"], -arm[0], -arm[1]]
            return [screw, turning, [m * reach, -m * reach, self.cos, self.sin]], [1, -1, 0, 0]
        other = [0, p["screw_mass"], -self.cos, -self.sin] if self.model == "support" else [0, 0, 1, 0]
        return [screw, other, [m * reach, m, self.cos, self.sin]], [1, 0, 0, 0]

    def spring(self, x):
        """What acts on the second body beside the contact; of compliant threads, N itself."""
        p = self.p
        if self.model == "threads":
            return self.cos * (p["contact_stiffness"] * x[2] + p["contact_damping"] * x[3])
        if self.model == "support":
            return -p["support_stiffness"] * (self.q0 + x[2]) - p["axial_support_damping"] * x[3]
        return -p["nut_stiffness"] * (self.q0 + x[2]) - p["nut_damping"] * x[3]

    def forces_of_bodies(self, mode, x, along=None):
        """Solve for (theta'', second acceleration, N, f, T_0 friction, F_0 friction) at a state."""
        p, (d, q, a) = self.p, mode
        (screw, other, nut), slip = self.bodies()
        torque = -p["coupling_stiffness"] * (self.z0 + x[0]) - p["support_damping"] * (self.Omega + x[1])
        push = p["axial_force"] - p["translation_damping"] * self.speeds(x)[2]
        bearing, slide = [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]
        if self.model == "nut":
            held, fixed_along, fixed_second = [1, 0, 0, 0, 0, 0], slide, bearing
        else:
            held, fixed_along, fixed_second = [self.reach, 1, 0, 0, 0, 0], bearing, slide
        rows = [[*screw, 1, 0], [*other, 0, 0], [*nut, 0, 1]]
        rows.append([*slip, 0, 0] if d == 0 else [0, 0, -d * q * p["friction_coefficient"], 1, 0, 0])
        rows += [fixed_along, held if a == 0 else fixed_second]
        sides = [torque, self.spring(x), push, 0, self.along * d if along is None else along, self.second * (a or 0)]
        return self.solve(rows, sides)

    def field(self, mode, x):
        first, second, *_ = self.forces(mode, x)
        return [x[1], first, x[3], second]

    def conditions(self, mode):
        """Rows that are positive in a mode, and for each which speed (0: slip, 1: second) it is, or None."""
        d, q, a = mode
        found = []
        if d:
            found.append((d * self.row(lambda x: self.speeds(x)[0]), 0))
            found.append((q * self.row(lambda x: self.forces(mode, x)[2]), None))
        else:
            for way in (1, -1):
                found.append((self.row(lambda x, w=way: self.room(mode, x, w, q or self.side(w))), None))
            if q and self.model == "support":
                found.append((q * self.row(lambda x: self.axial(self.forces(mode, x))), None))
        if a:
            found.append((a * self.row(lambda x: self.speeds(x)[1]), 1))
        elif a == 0:
            index = 4 if self.model == "nut" else 5
            for way in (1, -1):
                found.append((self.row(lambda x, w=way: self.second - w * self.forces(mode, x)[index]), None))
        return found

    def side(self, way):
        """The side on which the thread bears while nothing but the load pushes."""
        return 1 if self.p["axial_force"] - self.along * way > 0 else -1

    def axial(self, forces):
        return forces[2] * self.cos + forces[3] * self.sin

    def room(self, mode, x, way, side):
        """How far static friction is from its limit."""
        forces = self.forces(mode, x, along=way * self.along)
        return self.static * side * forces[2] - way * forces[3]

    def modes(self):
        """Return the modes: direction of slip, sign of N, direction of the second friction."""
        ways = (1, -1, 0) if self.second else (None,)
        slips = [(d, q) for d, q in product((1, -1), (1, -1)) if not self.painleve or d * q < 0]
        rests = [(0, 0)] if self.model == "nut" else [(0, 1), (0, -1)]
        return [(d, q, a) for d, q in slips + rests for a in ways]

    def tie(self, x, zero):
        """Set the speeds with the indices in ``zero`` to exactly zero."""
        x = x.copy()
        if self.model == "nut":
            x[1] = -self.Omega if 1 in zero else x[1]
            x[3] = self.Omega + x[1] if 0 in zero else x[3]
        else:
            x[1] = -self.Omega if 0 in zero else x[1]
            x[3] = -self.reach * (self.Omega + x[1]) if 1 in zero else x[3]
        return x

    def choose(self, x, zero, after=None):
        """Mode at a state with the speeds ``zero`` on zero; ``after``: sign of the impulse of a seizure."""
        fits = [mode for mode in self.modes() if self.lasts(mode, x, zero)]
        if self.painleve:
            against = (-after, after, None) if after else None
            if against in fits and after * self.forces(against, x)[2] > 0:
                return against
        if self.painleve or self.static > self.p["friction_coefficient"]:
            fits = [mode for mode in fits if mode[0] == 0] or fits
        assert len(fits) == 1, f"{len(fits)} modes last at {x}: {fits}"
        return fits[0]

    def impact(self, x):
        """State after the slip has been stopped by impulses of N and f, and the sign of that of N."""
        bodies, slip = self.bodies()
        speed = self.speeds(x)[0]
        jump = self.solve([*bodies, slip], [0, 0, 0, -speed])
        assert abs(jump[3]) <= self.p["friction_coefficient"] * abs(jump[2]), "the impact needs too much friction"
        sign = 1 if jump[2] > 0 else -1
        assert sign * speed > 0
        return self.tie(x + np.array([0, jump[0], 0, jump[1]]), {0}), sign

    def solve(self, rows, sides):
        """Linear equations, with zero where an unknown is nothing but rounding; the matrices are few."""
        key = tuple(map(tuple, rows))
        if key not in self.inverses:
            self.inverses[key] = _inverse(mp.matrix(rows))
        inverse = self.inverses[key]
        return [summed(*(inverse[i, j] * side for j, side in enumerate(sides))) for i in range(len(sides))]

    def forces(self, mode, x, along=None):
        """Accelerations and forces at a state, from the affine functions of it that they are; solved once a mode."""
        key = mode, along
        if key not in self.solved:
            self.solved[key] = affine(lambda y: self.forces_of_bodies(mode, y, along))
        return [_at(row, x) for row in self.solved[key]]

    def row(self, function):
        return np.array(affine(lambda x: [function(x)])[0])

    def row_of_field(self, mode):
        return affine(lambda x: self.field(mode, x))

    def mode(self, mode):
        if mode not in self.known:
            self.known[mode] = FourStatesMode(self, mode)
        return self.known[mode]

    def lasts(self, mode, x, zero):
        d, _, a = mode
        slip, second = self.speeds(x)[:2]
        if d and 0 not in zero and d * slip < 0:  # the usual reason, seen without making the mode
            return False
        if a and 1 not in zero and a * second < 0:
            return False
        return self.mode(mode).lasts(x, zero)

    def cornered(self, x):
        """The state after a seizure; where the next ones lead to the corner at which N is zero, it is put there.

        Without a load, N is zero where the speed of slip stays zero. Each seizure squares the distance from there.
        """
        row = self.mode((1, -1, None)).rows[1]
        if self.p["axial_force"] == 0 == self.along and abs(_at(row, x)) < _CORNER * _size(row, [*map(abs, x)]):
            put_on_zero(row, x)
        return x


SPARE_DIGITS = 30  # extra working digits beyond the dps asked for

_BEHIND = 30  # Digits behind a condition, of its terms, that an event, or the start, has put on zero.
_CORNER = mpf(10) ** -20  # of its terms: N that the next seizures take to zero, each of which squares it


@dataclass
class FourStatesEvent:
    """An event: its time, the modes around it, the state after it, and whether it was a seizure."""

    time: mpf
    mode_before: tuple
    mode_after: tuple
    state: tuple
    seizure: bool

    @property
    def kind(self):
        """What happens to the slip or to the contact; ``other`` where only a second friction changes."""
        before, after = self.mode_before, self.mode_after
        if self.seizure:
            return "seizure"
        if before[0] == after[0]:
            return "other" if before[1] == after[1] else "contact_reversal"
        return "release" if before[0] == 0 else "reversal" if after[0] else "stick"


@dataclass
class FourStatesTruth:
    """A motion with all of its digits: its end, its events and its arcs."""

    time: mpf
    state: tuple
    mode: tuple
    events: list
    arcs: list  # (mode, state at the start, duration)
    complete: bool  # False: stopped at max_events
    drive: object

    def sampled(self, parts):
        found = []
        for mode, state, stay in self.arcs:
            arc = self.drive.mode(mode).arc(state)
            found += [arc.state(stay * part) for part in parts if stay]
        return found


def mode_name(mode, model):
    slip, contact, second = mode
    ways = {1: "forward", -1: "backward", 0: "held"}
    words = ["slip", ways[slip]] if slip else ["rest"]
    words += ["positive" if contact > 0 else "negative"] if contact else []
    words += [] if second is None else ["nut" if model == "support" else "screw", ways[second]]
    return "_".join(words)


class FourStatesMode:
    """Field, closed form and conditions of a mode (d, q, a) of a drive."""

    def __init__(self, drive, mode):
        self.drive, self.mode = drive, mode
        d, _, a = mode
        self.ties = ({0} if d == 0 else set()) | ({1} if a == 0 else set())
        rows = drive.row_of_field(mode)
        self.A, self.b = [row[:4] for row in rows], [row[4] for row in rows]
        found = drive.conditions(mode)
        self.rows, self.kinds = [list(row) for row, _ in found], [kind for _, kind in found]

    @cached_property
    def tied(self):
        """Rows over (u, w, ., ., 1) of the speeds that the mode ties, by index."""
        rows = affine(lambda x: self.drive.tie(np.array(x, dtype=object), self.ties))
        return {i: row for i, row in enumerate(rows) if row != [*UNIT[i], 0]}

    @cached_property
    def spectrum(self):
        """Rates and eigenvectors of what is left, their inverse, and the constant; the tied rates are zero."""
        alive = [i for i in range(4) if i not in self.tied]
        reduced, constant = mp.zeros(len(alive)), mp.zeros(len(alive), 1)
        for m, i in enumerate(alive):
            constant[m] = self.b[i] + sum(self.A[i][t] * row[4] for t, row in self.tied.items())
            for n, j in enumerate(alive):
                reduced[m, n] = self.A[i][j] + sum(self.A[i][t] * row[j] for t, row in self.tied.items())
        rates, vectors = mp.eig(reduced)
        order = sorted(range(len(alive)), key=lambda k: abs(rates[k]))
        zero = set(order[: len(self.tied)])
        rates = [mpf(0) if k in zero else rate for k, rate in enumerate(rates)]
        return alive, rates, vectors, _inverse(vectors), constant

    def arc(self, x):
        alive, rates, vectors, inverse, constant = self.spectrum
        c0, c1 = [[] for _ in range(4)], [[] for _ in range(4)]  # the terms that they are summed from
        kept, columns = [], []
        for k, rate in enumerate(rates):
            vector = [mpf(0)] * 4
            for m, i in enumerate(alive):
                vector[i] = vectors[m, k]
            weights = [inverse[k, m] * x[i] for m, i in enumerate(alive)]
            push = summed(*(inverse[k, m] * constant[m] for m in range(len(alive))))
            for i, v in enumerate(vector):
                if rate == 0:
                    c0[i].append(mp.re(summed(*weights) * v))
                    c1[i].append(mp.re(push * v))
                else:
                    c0[i].append(-mp.re(push / rate * v))
            real = abs(mp.im(rate)) < mpf(10) ** -(mp.dps // 2) * abs(rate)
            if rate != 0 and (real or mp.im(rate) > 0):  # a conjugate pair is twice the real part of one of the two
                column = [(1 if real else 2) * summed(*weights, push / rate) * v for v in vector]
                kept.append(mp.re(rate) if real else rate)
                columns.append([mp.re(c) for c in column] if real else column)
        c0, c1 = [summed(*terms) for terms in c0], [summed(*terms) for terms in c1]
        for t, row in self.tied.items():
            c0[t], c1[t] = _at(row, c0), _at([*row[:4], mpf(0)], c1)
            for column in columns:
                column[t] = _at([*row[:4], mpf(0)], column)
        if not kept:  # nothing swings; a rate of no weight sets the scale of time
            stiffness, inertia = self.drive.p["coupling_stiffness"], self.drive.p["screw_inertia"]
            kept, columns = [-mp.sqrt(stiffness / inertia)], [[mpf(0)] * 4]
        return TrueArc(kept, columns, c0, c1)

    def lasts(self, x, zero):
        """Whether the mode's own flow keeps all its conditions; the speeds in ``zero`` are zero exactly."""
        if not self.ties <= zero:
            return False
        return all(self._sign(row, x, kind, zero) > 0 for row, kind in zip(self.rows, self.kinds, strict=True))

    def _sign(self, row, x, kind, exactly):
        """Sign of a condition at x, or of its first derivative that is not zero; see ``lasts`` for ``exactly``."""
        value, size, zero = _at(row, x), _size(row, [*map(abs, x)]), mpf(10) ** (_BEHIND - mp.dps)
        if kind is not None and x[1] == -self.drive.Omega:  # then the other speed is that of the second body alone
            value, size = (self.mode[0], None, self.mode[2])[2 * kind] * self.drive.speeds(x)[kind], mpf(0)
        if kind not in exactly and abs(value) > zero * size:
            return mp.sign(value)
        rows = [[*a, b] for a, b in zip(self.A, self.b, strict=True)]
        rate, sizes = [_at(r, x) for r in rows], [_size(r, [*map(abs, x)]) for r in rows]
        row = [*row[:4], mpf(0)]
        for _ in range(4):
            value = _at(row, rate)
            if abs(value) > zero * _size(row, sizes):  # sizes: of the terms that the derivative is summed from
                return mp.sign(value)
            rows = [[*a, mpf(0)] for a in self.A]
            rate, sizes = [_at(r, rate) for r in rows], [_size(r, sizes) for r in rows]
        return 1  # it rests on zero, as F_0 = 0 does


def _at(row, x):
    return summed(row[4], *(g * c for g, c in zip(row[:4], x, strict=True)))


def _inverse(matrix):
    """Inverse of a matrix, with zero where an entry is nothing but rounding."""
    found = mp.inverse(matrix)
    sizes = found.apply(abs) * matrix.apply(abs) * found.apply(abs)
    for i, j in product(range(found.rows), range(found.cols)):
        if abs(found[i, j]) < mpf(10) ** (20 - mp.dps) * sizes[i, j]:
            found[i, j] = mpf(0)
    return found


def _size(row, x):
    return sum((abs(g) * c for g, c in zip(row[:4], x, strict=True)), abs(row[4]))


def put_on_zero(row, x):
    """Move the place in ``x`` that a function of the state depends on most, so that it is zero to the last digit."""
    place = max((0, 2), key=lambda i: abs(row[i] * x[i]))
    if row[place] != 0:
        x[place] -= _at(row, x) / row[place]


def simulate(parameters, model, frictions, start, t_end, *, dps=40, max_events=60):
    """Follow the motion from ``start`` (u, w and the deviation and rate of the second body) at t = 0 to t_end."""
    with mp.workdps(dps + SPARE_DIGITS):
        drive = FourStatesDrive(model, parameters, frictions)
        x, t, t_end = np.array([mpf(value) for value in start], dtype=object), mpf(0), mpf(t_end)
        events, arcs = [], []
        speeds = drive.speeds(x)
        zero = {k for k in (0, 1) if speeds[k] == 0 and (k == 0 or drive.second)}
        direction = int(mp.sign(speeds[0]))
        mode = (direction, -direction, None) if drive.painleve and direction else drive.choose(x, zero)
        while len(events) < max_events:
            here = drive.mode(mode)
            if drive.painleve and direction and not events and _at(here.rows[1], x) < 0:
                stay, fired = mpf(0), 1  # a start where law -1 is not admissible
            else:
                arc = here.arc(x)
                # A touch stops and lets go again, or takes N to zero and back; but a seizure it makes or not.
                touch = [not drive.painleve or mode[0] == 0 or kind is not None for kind in here.kinds]
                tiny = [kind is not None and kind not in zero for kind in here.kinds]
                guards = [Function(arc, *guard) for guard in zip(here.rows, touch, tiny, strict=True)]
                stay, fired = first_root(guards, [1] * len(guards), t_end - t)
                arcs.append((mode, tuple(x), stay))
                x = np.array(arc.state(stay), dtype=object) if stay else x
            t += stay
            if fired is None:
                return FourStatesTruth(t_end, tuple(x), mode, events, arcs, True, drive)
            zero, after = set(here.ties), None
            if stay and here.kinds[fired] is None:  # what is left of it is the rounding of the clock, which may be fast
                put_on_zero(here.rows[fired], x)
            if here.kinds[fired] is not None:
                zero.add(here.kinds[fired])
            seized = drive.painleve and mode[0] != 0 and here.kinds[fired] is None
            if seized:
                x, after = drive.impact(x)
                zero = {0}
            x = drive.tie(x, zero)
            x = drive.cornered(x) if seized else x
            before, mode = mode, drive.choose(x, zero, after)
            events.append(FourStatesEvent(t, before, mode, tuple(x), seized))
        return FourStatesTruth(t, tuple(x), mode, events, arcs, False, drive)
