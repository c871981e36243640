"""The automaton of a drive: its mechanism, the modes that this has, and the tables that these make.

Tables are made once for each drive and shared by all that are equal: do not change them.

Under a friction law the sign of Γ₊ depends on the sliding speed. Below an interval in which Γ₊ > 0 lies the Painlevé
*band*: where law + comes to the end of it, the threads seize. What follows a seizure at a speed above the interval,
where friction has grown beyond all use, is not determined, and a motion that comes there has no branch. The friction of
a body that slides on its own is refused: while it holds, the force that is left is no affine function of the state.

A motion that only slips, around steady sliding, meets no guard of its model. So a mode that steady sliding lies in is
divided at θ′ = Ω: the two halves have one code, and what leads from one to the other is an event, a *passage*. Every
vibration then has events, and so a Poincaré map.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
from flint import arb

from lsvib.drives import friction, observables
from lsvib.drives.drive import Drive, once
from lsvib.drives.friction import coefficient, unbounded
from lsvib.drives.mechanics import coefficients
from lsvib.drives.mechanism import Mechanism
from lsvib.drives.model import seated
from lsvib.drives.modes import Modes
from lsvib.drives.names import DIRECTIONS, Event, Key, Resume
from lsvib.drives.scene import Command, one_after_the_other
from lsvib.errors import InputError
from lsvib.numbers import bisected
from lsvib.systems.automaton import Automaton, Branch, Guard, Mode, Surface, Transition, assemble, scaled
from lsvib.systems.exact.arithmetic import Divided, Row, double, doubles, many_digits, sign
from lsvib.systems.exact.taylor_form import Split, settled_region
from lsvib.systems.kernels.law import FROM, PIECE, TO, bends
from lsvib.systems.kernels.layout import Test


def automaton_of(
    drive: Drive, resume: Resume = "contact_sign", command: Command | None = None, rest: bool = True
) -> Automaton:
    """Return the automaton of a drive, also under a command; without ``rest`` that of slip as the motor turns alone.

    Raises ``InputError`` for a resume rule that is known of the rigid drive only, where rest cannot be left out,
    or a dry friction leaves the motion undetermined; ``EngineError`` if the rates of a mode cannot be separated in
    double precision.
    """
    if resume != "contact_sign" and not drive.rigid:
        raise InputError(f"resume = {resume!r} needs a rigid drive; for others give contact_sign.")
    evenly = drive.rigid and drive.input_speed and not (command or friction.depends_on_speed(drive))
    if not rest and not (evenly and not coefficients(drive).paradox):
        raise InputError(
            "physics must list rest; only a rigid drive below its critical mass that turns at constant speed, with "
            "friction that does not depend on speed, may leave it out."
        )
    return _made(drive, resume, command, rest)


@once
def _made(drive: Drive, resume: Resume, command: Command | None, rest: bool) -> Automaton:
    with many_digits():
        d = drive.exact()
        if command is None:
            modes = modes_of(d, drive.parts, resume)
            return modes.automaton() if rest else modes.without_rest()
        # Each piece of the command has modes of its own. The clock, the last state, begins anew in each, so that no
        # digits of Ω(t) are lost late.
        pieces = [(modes_of(d, drive.parts, resume, (arb(s), arb(a))), x) for x, s, a in command.pieces()]
        return assemble(**one_after_the_other([(modes.layout(), duration) for modes, duration in pieces]))


def modes_of(
    d: Any, parts: tuple[str, ...], resume: Resume = "contact_sign", command: tuple[arb, arb] | None = None
) -> Modes:
    """Return the modes of a drive from its parameters as balls, or of many from arrays; see ``Mechanism``."""
    if not friction.depends_on_speed(d):
        return Modes(Mechanism(d, parts, d.steady_friction, command), resume)
    return LawModes(Mechanism(d, parts, friction.coefficient(d, 0 * d.pitch_radius), command), resume)


class LawModes(Modes):
    """The modes of a drive under a friction law; arguments as of ``Modes``."""

    in_series = True

    def _speeds_without_paradox(self) -> tuple[Any, Any]:
        inertia, mass = self.m.effective()
        inertia = inertia - self.m.reach * self.m.d.collar * self.m.d.pitch_radius * mass
        level = critical_coefficient(inertia, self.m.d, mass)
        found = of_law(speeds_below, self.m.d, level)
        if found.shape[-2] == 0:
            return math.inf, math.inf
        low, high = (found[..., 0, end][()] for end in (0, 1))
        if self.m.compliant:  # the growing force brings motions to slow sliding
            return (math.inf if sign(low) else 0.0), math.inf
        if found.shape[-2] > 1:
            raise InputError(
                "friction leaves the Painlevé region in two ranges of speed; such drives cannot be simulated."
            )
        return low, high

    def _refuse(self) -> None:
        for name in self.m.own:
            raise InputError(
                f"{self._given(name)} cannot be combined with thread friction that depends on speed; set friction of "
                f"the {name}, or stribeck_rise and friction_slope, to zero."
            )

    def _parts(self, modes: dict[str, Mode], seen: dict[str, dict[str, Row]]) -> dict[str, dict[str, Row]]:
        """Put the friction law into the modes that slip, and into what is seen of them, in place.

        Returns the rows of the observables that count η times, by name and mode.
        """
        rubbed = [name for name, one in observables.TABLE.items() if one.rubbed]
        parts: dict[str, dict[str, Row]] = {name: dict.fromkeys(modes, self.m.constant(0)) for name in rubbed}
        pieces = of_law(pieces_of, self.m.d)
        laws = {self.name(key): key for key in self.slips}
        if self.paradox and sign(np.isfinite(self.low) * 1.0):
            laws |= self._band(modes)
        split_of = cache(self._split)
        for name, key in laws.items():
            d, q, _ = key
            split, without, pressed = split_of(*self._known(key)[:2])
            row = speed_row(d, self.m.slip, self.m.d)
            modes[name] = replace(modes[name], flow=split.mode(row, pieces))
            seen[name] = without
            for observable, rows in parts.items():
                rows[name] = split.part(without[observable], pressed[observable])
            if sign(np.isfinite(self.high) * 1.0) and d * q > 0:
                self._bound(modes, name, f"beyond_{DIRECTIONS[d]}", d, self.high, -1, "beyond")
                self.transitions["beyond"] = Transition(())
        self._divide(modes, [seen, *parts.values()])
        return parts

    def _split(self, d: int, law: int) -> tuple[Split, dict[str, Row], dict[str, Row]]:
        """The field of slip as friction divides it, and what is seen of it without friction and with some."""
        t = self.m.d.tan_lead
        probe = t / 2 if sign(t - 1) < 0 else 1 / (2 * t)  # with which Γ_s > 0 under both laws, whatever the masses
        free, rubbed = (self.m.solve(d, law, (), mu) for mu in (0 * t, probe))
        split = Split.of(free.field, free.normal, rubbed.field, rubbed.normal, probe)
        return split, observables.rows(self.m, free), observables.rows(self.m, rubbed)

    def _bound(
        self, modes: dict[str, Mode], name: str, surface: str, d: int, speed: Any, side: int, leads: str
    ) -> None:
        """Let a mode lie above (``side`` 1) or below a sliding speed [m/s]."""
        row = speed_row(d, self.m.slip, self.m.d)
        guard = self._guard(surface, (*row[:-1], row[-1] - speed), side, leads, self.m.place.get("nut", 0) + 1)
        modes[name] = replace(modes[name], guards=(*modes[name].guards, guard))

    def _band(self, modes: dict[str, Mode]) -> dict[str, Key]:
        """Add to the modes of the Painlevé region those above the band, where Γ₊ > 0; returns what they are."""
        starts, found, low = [], dict[str, Key](), self.low
        for d in DIRECTIONS:
            minus, plus = self.name((d, -d, ())), self.name((d, d, ()))
            fast, where, surface = f"{minus}_fast", DIRECTIONS[d], modes[minus].guards[0].surface
            for name, other, side in ((plus, fast, d), (fast, plus, -d)):
                found[name], reversal = (d, side, ()), f"contact_reversal_{name}"
                modes[name] = Mode(self.codes[self.name(found[name])], None, (Guard(surface, side, reversal),))
                self.transitions[reversal] = Transition((Branch(other, Event.CONTACT_REVERSAL, sign=-side),))
            self.transitions[f"slower_{where}"] = Transition((Branch(minus, Event.PASSAGE),))
            self.transitions[f"faster_{where}"] = Transition((Branch(fast, Event.PASSAGE),))
            self._bound(modes, minus, f"band_{where}", d, low, -1, f"faster_{where}")
            self._bound(modes, fast, f"band_{where}", d, low, 1, f"slower_{where}")
            # Before Γ₊ = 0 the deceleration grows without bound, and what is left of the time as the square of the
            # distance: here it is below rounding. Nearer to it, the rounding of Γ₊ itself makes steps short.
            self._bound(modes, plus, f"jam_{where}", d, low * (1 + 3e-9), 1, f"contact_{minus}")
            above = self.surfaces[f"jam_{where}"].row, Test.POSITIVE
            starts.append(Branch(plus, Event.RELEASE, (above, *self._carries(*self._known((d, -d, ())))[d])))
            starts.append(Branch(fast, Event.RELEASE, (above,)))
        self.transitions["entry"] = Transition((*starts, *self.transitions["entry"].branches))
        return found

    def _divide(self, modes: dict[str, Mode], tables: list[dict[str, Any]]) -> None:
        """Divide the mode of steady sliding where θ′ passes Ω, unless there is none or the commanded speed changes.

        In the ``tables`` of what is seen of modes both halves have the same.
        """
        m = self.m
        if m.command or not m.turning:
            return
        steady = self.name((m.turning, m.steady_law * m.turning, ()))
        if f"{steady}_fast" in modes and sign(double(friction.steady_speed(m.d)) - self.low) > 0:
            steady += "_fast"
        if steady not in modes:
            return
        divided(steady, Event.PASSAGE, modes, self.transitions, self.surfaces, seated(m))
        for of_mode in tables:
            of_mode[f"{steady}_slow"] = of_mode[steady]


_LAW = ("friction_coefficient", *friction.NAMES)


def of_law(found: Callable[..., Any], d: Any, *more: Any) -> np.ndarray:
    """Return what a function finds for the friction law ``d`` and ``more`` numbers, as an array.

    Of many laws, arrays of parameters (k), it has one more axis, the first; raises ``Divided`` where shapes differ.
    """
    columns = np.broadcast_arrays(*(double(getattr(d, name)) for name in _LAW), *more)
    rows, which = np.unique(np.stack(columns, axis=-1).reshape(-1, len(columns)), axis=0, return_inverse=True)
    split = [(SimpleNamespace(**dict(zip(_LAW, row, strict=False))), row[len(_LAW) :]) for row in rows.tolist()]
    answers = [np.array(found(law, *others)).reshape(-1, 2 if more else PIECE) for law, others in split]
    sizes = np.array([len(answer) for answer in answers])[which.ravel()]
    if (sizes != sizes[0]).any():
        raise Divided(sizes)
    return np.array(answers)[which.ravel()].reshape(*columns[0].shape, *answers[0].shape)


def pieces_of(drive: Any) -> np.ndarray:
    """Return the pieces of the friction law of a drive (p, columns as of :mod:`lsvib.systems.kernels.law`)."""
    piece = np.array(friction.piece_of(drive), dtype=float)
    if drive.friction_slope >= 0:
        return piece[None]
    # The law falls for ever, so it comes to zero once; with a rise later than without.
    low = high = drive.friction_coefficient / -drive.friction_slope
    while unbounded(drive, high)[0] > 0:
        high = 2 * high + 1e-300
    zero = np.zeros(PIECE)
    (end,) = _passes(lambda v: unbounded(drive, v)[0], [low, high]) or [low]
    zero[FROM], zero[TO], piece[TO] = end, math.inf, end
    return np.array([piece, zero])


def speeds_below(drive: Any, level: float) -> list[tuple[float, float]]:
    """Return the intervals of sliding speed [m/s] in which the coefficient is below a level, in ascending order."""
    if math.isinf(level):
        return [(0.0, math.inf)]
    # So far out the rise has faded, and the slope alone has taken the coefficient over the level, or down to zero.
    slope = abs(drive.friction_slope)
    fades = max(getattr(drive, speed) for speed in friction.FADING.values())
    far = 50 * fades + (2 * (drive.friction_coefficient + level) / slope if slope else 0.0)
    turns = _passes(lambda v: unbounded(drive, v)[1], [0.0, *bends(friction.piece_of(drive)), far])
    marks = [0.0, *_passes(lambda v: coefficient(drive, v) - level, [0.0, *turns, far]), math.inf]
    parts = [(a, b) for a, b in pairwise(marks) if a < b]
    middle = [0.5 * (a + b) if math.isfinite(b) else 2 * a + 1e-12 for a, b in parts]
    return [part for part, v in zip(parts, middle, strict=True) if coefficient(drive, v) < level]


def critical_coefficient(inertia: Any, d: Any, mass: Any) -> float:
    """Return the coefficient from which on Γ₊ = I − ξ₊ tan λ m r_m² ≤ 0, infinite if there is none [1].

    ``inertia`` I and ``mass`` m are those that a seizure has to stop; ``d``, the parameters of the drive in balls.
    """
    with many_digits():
        turned = mass * d.pitch_radius**2
        heavy = turned - inertia
        if sign(heavy, "mass") <= 0:
            return math.inf
        found: float = double((inertia + turned * d.tan_lead**2) / (heavy * d.tan_lead))
        return found


def _passes(function: Callable[[float], float], marks: Sequence[float]) -> list[float]:
    """Return where a function, which only grows or only falls between two ``marks``, becomes negative or ceases to."""
    pairs = [(low, high, function(low) < 0) for low, high in pairwise(marks) if low < high]
    ends = [(low, high, begins) for low, high, begins in pairs if (function(high) < 0) != begins]
    return [bisected(lambda v, b=begins: (function(v) < 0) != b, low, high) for low, high, begins in ends]  # type: ignore


def divided(
    name: str,
    kind: int,
    modes: dict[str, Mode],
    transitions: dict[str, Transition],
    surfaces: dict[str, Surface],
    steady: np.ndarray,
) -> None:
    """Divide the mode that ``steady`` sliding (n) lies in at w = 0, in place; ``kind``: of the event in between.

    The region that no motion leaves goes into both halves (:func:`lsvib.systems.exact.taylor_form.settled_region`).
    """
    slow, mode, n = f"{name}_slow", modes[name], steady.shape[-1]
    rows = [doubles(scaled(surfaces[guard.surface].row, guard.sign), (n + 1,)) for guard in mode.guards]
    flow = replace(mode.flow, settled=settled_region(mode.flow, rows, steady))
    deviation = tuple(1 if i == 1 else 0 for i in range(n + 1))
    surfaces["passage"] = Surface(deviation, 1)
    for own, other, side in ((name, slow, 1), (slow, name, -1)):
        guards = (*mode.guards, Guard("passage", side, f"passage_from_{own}"))
        modes[own] = replace(mode, flow=flow, guards=guards)
        transitions[f"passage_from_{own}"] = Transition((Branch(other, kind),))
    for key, transition in transitions.items():
        if not key.startswith("passage"):
            branches = tuple(x for branch in transition.branches for x in _halves(branch, name, slow, deviation))
            transitions[key] = replace(transition, branches=branches)


def _halves(branch: Branch, name: str, slow: str, deviation: Row) -> Iterator[Branch]:
    if branch.mode == name:
        yield branch._replace(conditions=(*branch.conditions, (deviation, Test.POSITIVE)))
        branch = branch._replace(mode=slow)
    yield branch


def speed_row(direction: int, speed: Row, d: Any) -> tuple[Any, ...]:
    """Return the row of the sliding speed [m/s] in a direction ±1 from that of the angular speed, zero where it is."""
    return scaled(speed, direction * double(d.pitch_radius / d.cos_lead))
