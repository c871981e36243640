"""The rigid drive under a friction law: its modes, with Γ₊ of either sign as the sliding speed has it."""

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from flint import arb

from lsvib.engine.automaton import (
    SHORT_STAY,
    Automaton,
    Branch,
    Guard,
    Mode,
    Surface,
    Transition,
    assemble,
    scaled,
)
from lsvib.engine.exact.arithmetic import double, many_digits
from lsvib.engine.exact.taylor_form import Split, still_mode, taylor_flow
from lsvib.engine.kernels.layout import Test
from lsvib.errors import InputError
from lsvib.models import friction, mechanics, sliding
from lsvib.models.drive import RigidDrive
from lsvib.models.mechanics import coefficients, plus, rate_of
from lsvib.models.model import DIRECTIONS, Resume
from lsvib.models.rigid import BY_LAW_MINUS, SLIP_NAMES, SLIPS, STATES, EventKind, MotionMode, RigidBuild


class SpeedBuild(RigidBuild):
    """The rigid drive under a friction law: its modes, with Γ₊ of either sign as the sliding speed has it.

    ``range``: the interval of sliding speed in which Γ₊ > 0, None if there is none. Below it lies the Painlevé band:
    where law + comes to the end of it, the screw seizes. What follows a seizure at a speed above it, where friction has
    grown beyond all use, is not determined, and a motion that comes there has no branch.
    """

    def __init__(self, drive: RigidDrive) -> None:
        super().__init__(coefficients(drive), drive.exact())
        self.drive, self.pieces = drive, sliding.pieces_of(drive)
        d = self.d
        with many_digits():
            self.probe = sliding.probe(d)
        found = sliding.speeds_below(drive, sliding.critical_coefficient(d.screw_inertia, d, d.mass))
        if len(found) > 1:
            raise InputError(
                "friction reaches the Painlevé region in two ranges of speed; such drives are not followed."
            )
        self.range = found[0] if found else None
        self.splits = {law: self._split(law) for law in (1, -1)}

    def _flows(self) -> dict[int, tuple]:
        return {}

    @many_digits()
    def _split(self, law: int) -> Split:
        (free, loose), (rubbed, pressed) = (self._rows(law, mu) for mu in (arb(0), self.probe))
        return Split.of(free, loose, rubbed, pressed, self.probe)

    def _rows(self, law: int, mu: arb) -> tuple[list[tuple], tuple]:
        """Rows of the field, and of N, under a law with a constant coefficient."""
        c, d = self.c, self.d
        xi = mechanics.friction_factor(mu, d.tan_lead, law)
        gamma = mechanics.effective_inertia(d.screw_inertia, d.mass, d.pitch_radius, d.tan_lead, xi)
        damping = mechanics.effective_damping(d.support_damping, d.translation_damping, d.pitch_radius, d.tan_lead, xi)
        coupling = scaled((1, 0, c.deflection), -d.coupling_stiffness)
        rest = plus(scaled(self.speed, -damping), (0, 0, -d.pitch_radius * xi * d.axial_force))
        normal = scaled(c.q_row, 1 / (gamma * (d.cos_lead + law * mu * d.sin_lead)))
        return [(0, 1, 0), scaled(plus(coupling, rest), 1 / gamma)], normal

    @many_digits()
    def automaton(self, rest: bool, resume: Resume) -> Automaton:
        """Return the automaton; rest is part of it."""
        if not rest:
            raise InputError("physics leaves out rest, which a drive with a friction law always has; list rest.")
        self.surfaces = {
            "contact": Surface(self.c.q_row, self.mover()),
            "screw_speed": Surface(self.speed, 1),
            "band_end": Surface(self.band_end, 0),
        }
        modes, transitions = self._modes(resume)
        steady = SLIP_NAMES[self.turning, self.c.steady_law * self.turning]
        if f"{steady}_fast" in modes and double(friction.steady_speed(self.d)) > self.range[0]:
            steady += "_fast"
        if steady in modes:
            sliding.divided(steady, EventKind.PASSAGE, modes, transitions, self.surfaces)
        flows = {mode.flow.field.tobytes(): mode.flow for mode in modes.values()}  # without friction most are one
        return assemble(
            states=STATES,
            surfaces=self.surfaces,
            modes=modes,
            transitions=transitions,
            observables=self.observables(modes),
            parts=self.parts(modes),
            shortest_stay=SHORT_STAY * min(scale for flow in flows.values() for scale in flow.time_scales),
            stack=taylor_flow,
            rest_codes=(MotionMode.REST,),
            release_kinds=(EventKind.RELEASE,),
            sprag_kinds=(EventKind.SEIZURE,),
            passive=True,
        )

    def _modes(self, resume: Resume) -> tuple[dict[str, Mode], dict[str, Transition]]:
        """Modes and transitions: below the interval ``range`` those of the Painlevé region, within it the others."""
        low, high = self.range or (math.inf, math.inf)
        if low == 0:
            modes, transitions = super().regular(True)
        else:
            modes, transitions = self.painleve(resume)
        if 0 < low < math.inf:
            self._band(modes, transitions, low)
        if math.isfinite(high):
            transitions["beyond"] = Transition(())
            for name in set(modes) - {*BY_LAW_MINUS.values(), "rest"}:
                direction = SLIPS[name.removesuffix("_fast")][0]
                if math.prod(SLIPS[name.removesuffix("_fast")]) > 0:
                    self._add(modes, name, f"end_{DIRECTIONS[direction]}", direction, high, -1, "beyond")
        return modes, transitions

    def _add(
        self, modes: dict[str, Mode], name: str, surface: str, direction: int, speed: float, side: int, leads: str
    ) -> None:
        """Add a guard to a mode, which lies above (``side`` 1) or below a sliding speed [m/s], and its transition."""
        row = sliding.speed_row(direction, self.speed, self.d)
        self.surfaces[surface] = Surface((*row[:-1], row[-1] - speed), 1)
        modes[name] = replace(modes[name], guards=(*modes[name].guards, Guard(surface, side, leads)))

    def _band(self, modes: dict[str, Mode], transitions: dict[str, Transition], low: float) -> None:
        """Add to the modes of the Painlevé region those above a sliding speed [m/s], where Γ₊ > 0."""
        starts = []
        for direction, minus in BY_LAW_MINUS.items():
            plus_name, fast, where = SLIP_NAMES[direction, direction], f"{minus}_fast", DIRECTIONS[direction]
            reversals = f"contact_reversal_{plus_name}", f"contact_reversal_{fast}"
            modes[plus_name] = self._slip(plus_name, (Guard("contact", direction, reversals[0]),), None)
            modes[fast] = self._slip(minus, (Guard("contact", -direction, reversals[1]),), None)
            transitions[reversals[0]] = Transition((Branch(fast, EventKind.CONTACT_REVERSAL, sign=-direction),))
            transitions[reversals[1]] = Transition((Branch(plus_name, EventKind.CONTACT_REVERSAL, sign=direction),))
            transitions[f"slower_{where}"] = Transition((Branch(minus, EventKind.PASSAGE),))
            transitions[f"faster_{where}"] = Transition((Branch(fast, EventKind.PASSAGE),))
            self._add(modes, minus, f"band_{where}", direction, low, -1, f"faster_{where}")
            self._add(modes, fast, f"band_{where}", direction, low, 1, f"slower_{where}")
            # Before Γ₊ = 0 the deceleration grows without bound, and what is left of the time as the square of the
            # distance: here it is below rounding. Nearer to it, the rounding of Γ₊ itself makes steps short.
            self._add(modes, plus_name, f"jam_{where}", direction, low * (1 + 3e-9), 1, f"seizure_{minus}")
            above = self.surfaces[f"jam_{where}"].row, Test.POSITIVE
            carried = scaled(self.c.q_row, direction), Test.POSITIVE
            enters = (self.c.q_row, Test.ZERO), (scaled(self._q_rate(), direction), Test.NOT_NEGATIVE)
            starts.append(Branch(plus_name, EventKind.RELEASE, (above, carried)))
            starts.append(Branch(plus_name, EventKind.RELEASE, (above, *enters)))
            starts.append(Branch(fast, EventKind.RELEASE, (above,)))
        transitions["entry"] = Transition((*starts, *transitions["entry"].branches))

    def _xi_slow(self) -> dict[int, Any]:
        slowest = friction.coefficient(self.d, arb(0))
        return {s: mechanics.friction_factor(slowest, self.d.tan_lead, s) for s in (1, -1)}

    def _q_rate(self) -> tuple:
        with many_digits():
            return rate_of(self.c.q_row, self.splits[1].free)

    def _still(self) -> Any:
        return still_mode([(0, 1, 0), (0, 0, 0)])

    def _slip(self, name: str, guards: tuple[Guard, ...], beyond: str | None) -> Mode:
        direction, law = SLIPS[name][0], math.prod(SLIPS[name])
        speed = sliding.speed_row(direction, self.speed, self.d)
        return Mode(MotionMode[name.upper()], self.splits[law].mode(speed, self.pieces), guards, beyond)

    def observables(self, modes: Iterable[str]) -> dict[str, dict[str, tuple]]:
        """Rows of the observables by name and mode, of the contact force in slip without friction."""
        found = super().observables(["rest"])
        one = {name: dict.fromkeys(modes, rows["rest"]) for name, rows in found.items()}
        return one | {"normal_force": {n: self._normal(n) or one["normal_force"][n] for n in modes}}

    def _normal(self, mode: str) -> tuple | None:
        law = self._law(mode)
        return self.splits[law].contact if law else None

    def _law(self, mode: str) -> int:
        """The law of a mode, 0 of rest."""
        name = mode.removesuffix("_slow").removesuffix("_fast")
        return math.prod(SLIPS[name]) if name in SLIPS else 0

    def parts(self, modes: Iterable[str]) -> dict[str, dict[str, tuple]]:
        """Rows of the observables that count η times, by name and mode: N = N_0 / (1 + B μ) = N_0 (1 − B η)."""
        own = {law: scaled(split.contact, -split.feedback) for law, split in self.splits.items()} | {0: (0, 0, 0)}
        return {"normal_force": {name: own[self._law(name)] for name in modes}}
