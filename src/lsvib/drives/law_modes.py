"""The modes of a drive whose friction depends on the sliding speed.

Under a friction law the sign of Γ₊ depends on the sliding speed. Below an interval in which Γ₊ > 0 lies the Painlevé
*band*: where law + comes to the end of it, the threads seize. What follows a seizure at a speed above the interval,
where friction has grown beyond all use, is not determined, and a motion that comes there has no branch. The friction of
a body that slides on its own is refused: while it holds, the force that is left is no affine function of the state.
"""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from lsvib.drives import friction, observables, sliding
from lsvib.drives.modes import Modes
from lsvib.drives.names import DIRECTIONS, Event, Key
from lsvib.drives.states import seated
from lsvib.errors import InputError
from lsvib.systems.automaton import Branch, Guard, Mode, Transition
from lsvib.systems.exact.arithmetic import Row, double, sign
from lsvib.systems.exact.taylor_form import Split
from lsvib.systems.kernels.layout import Test


class LawModes(Modes):
    """The modes of a drive under a friction law; arguments as of ``Modes``."""

    in_series = True

    def _speeds_without_paradox(self) -> tuple[Any, Any]:
        inertia, mass = self.m.effective()
        inertia = inertia - self.m.reach * self.m.d.collar * self.m.d.pitch_radius * mass
        level = sliding.critical_coefficient(inertia, self.m.d, mass)
        found = sliding.of_law(sliding.speeds_below, self.m.d, level)
        if found.shape[-2] == 0:
            return math.inf, math.inf
        low, high = (found[..., 0, end][()] for end in (0, 1))
        if self.m.compliant:  # the growing force brings motions to slow sliding
            return (math.inf if sign(low) else 0.0), math.inf
        if found.shape[-2] > 1:
            raise InputError(
                "friction leaves the Painlevé region in two ranges of speed, with the region between them; such drives "
                "are not followed."
            )
        return low, high

    def _refuse(self) -> None:
        for name in self.m.own:
            raise InputError(
                f"{self._given(name)} is not followed where friction of the threads depends on speed; leave friction "
                f"of the {name} out, or stribeck_rise and friction_slope at zero."
            )

    def _parts(self, modes: dict[str, Mode], seen: dict[str, dict[str, Row]]) -> dict[str, dict[str, Row]]:
        """Put the friction law into the modes that slip, and into what is seen of them, in place.

        Returns the rows of the observables that count η times, by name and mode.
        """
        rubbed = [name for name, one in observables.TABLE.items() if one.rubbed]
        parts: dict[str, dict[str, Row]] = {name: dict.fromkeys(modes, self.m.constant(0)) for name in rubbed}
        pieces = sliding.of_law(sliding.pieces_of, self.m.d)
        laws = {self.name(key): key for key in self.slips}
        if self.paradox and sign(np.isfinite(self.low) * 1.0):
            laws |= self._band(modes)
        split_of = cache(self._split)
        for name, key in laws.items():
            d, q, _ = key
            split, without, pressed = split_of(*self._known(key)[:2])
            row = sliding.speed_row(d, self.m.slip, self.m.d)
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
        row = sliding.speed_row(d, self.m.slip, self.m.d)
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
        sliding.divided(steady, Event.PASSAGE, modes, self.transitions, self.surfaces, seated(m))
        for of_mode in tables:
            of_mode[f"{steady}_slow"] = of_mode[steady]
