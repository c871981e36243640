r"""The rigid drive: one degree of freedom, nut and screw tied by x = r_m tan λ θ (Sect. 5.3, eqs 8.13–8.17).

          Ω t                θ                      x = r_m tan λ θ
    motor ──/\/\/\── k ──▶ (I) screw ═══threads═══▶ [m] nut ──▶ R
                            c to ground                c_x to ground

State (u, w): u = z − z_0 [rad] is the deviation of the coupling deflection z = θ − Ω t from steady sliding, w = u′
[rad/s] its rate; the screw turns at θ′ = Ω + w. With s = sgn(θ′)·sgn(N) and R̃ = R − r_m tan λ c_x Ω,

    Γ_s u″ + C_s u′ + k u = r_m (ξ_0 − ξ_s) R̃,        N = Q / [Γ_s (cos λ + s μ sin λ)],
    (8.16, 8.17) Q = r_m tan λ [m k u + (m c − I c_x) u′] + Γ_0 R̃,

so the motion is linear in each combination of signs of θ′ and Q, and at rest, where u′ = −Ω and static friction holds
while the coupling torque T_r = −k (z_0 + u) stays between r_m R ξ₊ and r_m R ξ₋, these two with the coefficient of
static friction. Where that is above the coefficient of sliding, a screw that comes to θ′ = 0 within the band might
also slip on; it is taken to stick, as it does in the limit of a coefficient that falls ever faster from rest on, and
as it must once it stands still.

Γ₊ > 0: the sign of N is that of Q, and N reverses where Q does.
Γ₊ ≤ 0 (Painlevé region): law s = −1 is followed where it is admissible (θ′ > 0, Q < 0 and θ′ < 0, Q > 0); elsewhere,
and on arriving at Q = 0, the screw *seizes*: θ′ jumps to zero, with an impulse of the sign of θ′. The contact then
still carries the sign of the impulse. If slip under law −1 with that sign of N is admissible and accelerates away from
rest, it starts at once; otherwise the screw rests, and goes on under law −1 when T_r leaves the band
(``resume="contact_sign"``, the limit of a compliant contact). With ``resume="at_once"`` – the chapter's reading – the
sign of Q alone decides; then seizures can accumulate at θ′ = 0, Q = 0, beyond which the screw rests.

R = 0: at θ′ = 0 both T_r and Q are zero in one place, the *corner*. Seizures from one side of it leave the coupling at
the deflections z_1, z_2, … with

    z_{n+1} = (c − I c_x / m) z_n² / (2 Γ₋ |Ω|) + O(z_n³),

so that infinitely many accumulate in the corner in finite time; after three or four the next one lies below the digits
of a double. The screw rests there for no time, and is released to the other side.
"""

import math
from collections.abc import Iterable, Iterator
from enum import IntEnum
from typing import Any

import numpy as np

from lsvib.engine.automaton import SHORT_STAY, Automaton, Branch, Guard, Mode, Surface, Transition, assemble, scaled
from lsvib.engine.exact.arithmetic import double, many_digits, root, sign
from lsvib.engine.exact.modal_form import PlanarMode
from lsvib.engine.kernels import layout
from lsvib.engine.kernels.layout import Test
from lsvib.errors import InputError
from lsvib.models import friction
from lsvib.models.drive import Drive, once
from lsvib.models.law_modes import automaton_of_parts
from lsvib.models.mechanics import Coefficients, by_law, coefficients
from lsvib.models.names import COORDINATES, DIRECTIONS, SIGNS, Event, Resume, mode_name

STATES = COORDINATES["screw"]


class MotionMode(IntEnum):
    """Modes of the rigid drive; the second word of a slip mode is the sign of Q."""

    SLIP_FORWARD_POSITIVE = 0
    SLIP_FORWARD_NEGATIVE = 1
    SLIP_BACKWARD_POSITIVE = 2
    SLIP_BACKWARD_NEGATIVE = 3
    REST = 4


SLIP_NAMES = {(d, q): mode_name((d, q, ()), ()) for d in DIRECTIONS for q in SIGNS}  # by the signs of θ′ and Q
SLIPS = {name: signs for signs, name in SLIP_NAMES.items()}
BY_LAW_MINUS = {1: "slip_forward_negative", -1: "slip_backward_positive"}  # by the sign of θ′


@once
def rigid_automaton(drive: Drive, *, rest: bool = True, resume: Resume = "contact_sign") -> Automaton:
    """Return the rigid drive's automaton.

    Arguments: the drive; ``rest=False`` leaves out θ′ = 0 with everything that belongs to it (reversal, rest, seizure),
    for motions that are known not to reach it – only outside the Painlevé region; ``resume``: see the module docstring.
    Observables: normal_force [N], coupling_torque [N m], coupling_deflection [rad], screw_speed [rad/s]. Raises
    ``InputError`` for ``rest=False`` in the Painlevé region.
    """
    if friction.depends_on_speed(drive):
        if not rest:
            raise InputError("physics leaves out rest, which a drive with a friction law always has; list rest.")
        return automaton_of_parts(drive, resume)
    return RigidBuild(coefficients(drive), drive.exact()).automaton(rest, resume)


class RigidBuild:
    """Flows, rows over (u, w, 1) and conditions that the model is made of; a row is positive where its name says.

    From coefficients and parameters, as balls or as arrays of doubles (many drives).

    ``flows``: the flow of slip by law; ``above``, ``below``: the torque T_r beyond an end of
    the band of static friction, whose factors are ``xi_rest`` and ``gamma_rest`` by law; ``band_end``: positive before
    the end that is ahead, as T_r grows at k Ω during rest.
    """

    @many_digits()
    def __init__(self, c: Coefficients, d: Any) -> None:
        self.c, self.d = c, d
        self.flows = {}
        for s in (-1,) if c.paradox else (1, -1):
            terms = c.gamma[s], c.damping[s], d.coupling_stiffness, d.pitch_radius * c.slack(s) * c.net_force
            self.flows[s] = PlanarMode.of(*terms)
        self.turning, force = sign(d.input_speed), sign(d.axial_force)
        self.same = d.static_friction is d.steady_friction  # rest then holds as much as sliding carries
        rest = (c.xi, c.gamma) if self.same else by_law(d, d.static_friction)
        self.xi_rest, self.gamma_rest = rest[0], rest[1]
        upper, lower = (1, -1) if force >= 0 else (-1, 1)
        self.above, self.below = self._torque_above(upper, True), scaled(self._torque_above(lower, True), -1)
        self.band_end = scaled(self.above if self.turning > 0 else self.below, -1)
        self.speed = (0, 1, d.input_speed)
        self.release_sign = force or -self.turning
        if force * self.turning > 0 and not self.same:
            # At the end of the band Q is R Γ₊ with static friction, which alone may reach the Painlevé region.
            self.release_sign *= sign(self.gamma_rest[1]) or 1
        # Where the band is a point, events accumulate there when what is left of them lies below rounding; rest then
        # ends as soon as it begins, and the release begins in the very corner: beside it, on the wrong side by a last
        # place, the screw would stop again at once, and so for ever.
        corner = ((0, 0, -self.turning * self.band_end[2]), (0, 1, 0))
        self.to_corner = corner if force == 0 or self._cornered() else None

    @many_digits()
    def automaton(self, rest: bool, resume: Resume) -> Automaton:
        """Return the automaton; the tables of doubles of many drives have one more axis, the first."""
        c = self.c
        if c.paradox and not rest:
            raise InputError(
                "physics leaves out rest, which a drive at or beyond its critical mass may always come to; list rest, "
                "or take mass < critical_mass (see lsvib thresholds)."
            )
        surfaces = {"contact": Surface(c.q_row, self.mover())}
        if rest:
            surfaces["screw_speed"] = Surface(self.speed, 1)
            surfaces["band_end"] = Surface(self.band_end, 0)
        modes, transitions = self.painleve(resume) if c.paradox else self.regular(rest)
        scales = [flow.row[..., layout.TIME_SCALE] for flow in self.flows.values()]
        return assemble(
            states=STATES,
            surfaces=surfaces,
            modes=modes,
            transitions=transitions,
            observables=self.observables(modes),
            shortest_stay=SHORT_STAY * np.min(scales, axis=0),
            rest_codes=(MotionMode.REST,),
            release_kinds=(Event.RELEASE,),
            sprag_kinds=(Event.SEIZURE,),
            passive=rest,
            contracts=self.contracts(),
        )

    def _torque_above(self, law: int, at_rest: bool) -> tuple[Any, ...]:
        """(T_r − r_m ξ R) / k [rad] under a law, static or sliding; k z_0 is inserted: nothing cancels."""
        c, d = self.c, self.d
        steady = (c.damping[c.steady_law] * d.input_speed) / d.coupling_stiffness
        other = at_rest and not self.same
        slack = c.xi[c.steady_law] - self.xi_rest[law] if other else c.slack(law)
        return -1, 0, steady + d.pitch_radius * slack * d.axial_force / d.coupling_stiffness

    def _cornered(self) -> bool:
        """Whether at θ′ = 0 a double cannot tell the band of static friction, or Q at its end, from a corner."""
        d, gamma = self.d, self.gamma_rest
        # The band is R (Γ₋ − Γ₊) / (m k r_m tan λ) wide, and Q = 0 R Γ₊ / (…) from its end.
        least = abs(self.band_end[2]) * d.mass * d.coupling_stiffness * d.pitch_radius * d.tan_lead
        force = 10**13 * abs(d.axial_force)  # this part of u counts: a tenth of it is what rounding may make of u
        return any(sign(force * x - least) <= 0 for x in (abs(gamma[1]), gamma[-1] - gamma[1]))

    def mover(self) -> int:
        """Coordinate that is set on Q = 0: the one that moves Q more, so that its own rounding is not amplified."""
        time = root(self.c.gamma[-1] / self.d.coupling_stiffness)
        return 0 if sign(abs(self.c.q_row[0]) * time - abs(self.c.q_row[1])) >= 0 else 1

    def contracts(self) -> bool:
        """Whether the motion enlarges no area (see ``Automaton``): Γ₊ > 0, both C_s > 0 or zero, one friction for all.

        Slip changes an area at the rate −C_s / Γ_s. Both laws agree on Q = 0. Where θ′ passes zero, friction reverses:
        the acceleration forward is below that backward by |Q| (1/Γ₊ − 1/Γ₋) / (m r_m tan λ), so that areas are
        squeezed. Static friction above that of sliding makes motions jump where rest begins.
        """
        signs = [sign(damping, "support_damping") for damping in self.c.damping.values()]
        return self.same and not self.c.paradox and signs in ([0, 0], [1, 1])

    def _slip(self, name: str, guards: tuple[Guard, ...], beyond: str | None) -> Mode:
        return Mode(MotionMode[name.upper()], self.flows[math.prod(SLIPS[name])], guards, beyond)

    def _rest(self) -> Mode:
        beyond = "rest" if self.to_corner else None
        return Mode(MotionMode.REST, PlanarMode.of(1, 0, 0, 0), (Guard("band_end", 1, "release"),), beyond)

    def regular(self, rest: bool) -> tuple[dict[str, Mode], dict[str, Transition]]:
        """Modes and transitions for Γ₊ > 0."""
        modes, beyond = {}, "rest" if rest and self.to_corner else None
        for name, (direction, q_sign) in SLIPS.items():
            if rest or direction == self.turning:
                guards = (Guard("contact", q_sign, f"contact_reversal_{name}"),)
                stop = (Guard("screw_speed", direction, "stop"),) if rest else ()
                modes[name] = self._slip(name, guards + stop, beyond)
        transitions = {"entry": Transition(tuple(self._entry(modes, rest)))}
        for name in modes:
            direction, q_sign = SLIPS[name]
            other = Branch(SLIP_NAMES[direction, -q_sign], Event.CONTACT_REVERSAL, sign=-q_sign)
            transitions[f"contact_reversal_{name}"] = Transition((other,))
        if rest:
            transitions["stop"] = Transition(self._stop())
            released = Branch(SLIP_NAMES[self.turning, self.release_sign], Event.RELEASE)
            transitions["release"] = Transition((released,), reset=self.to_corner)
            modes["rest"] = self._rest()
        return modes, transitions

    def _entry(self, modes: dict[str, Mode], rest: bool) -> Iterator[Branch]:
        """Where a motion starts: by the signs of θ′ and Q; on Q = 0 by Q′, the same by both laws; at θ′ = 0 a stop."""
        q, q_rate = self.c.q_row, self._q_rate()
        for name in modes:
            direction, q_sign = SLIPS[name]
            moving = ((scaled(self.speed, direction), Test.POSITIVE),) if rest else ()
            enters = (q, Test.ZERO), (scaled(q_rate, q_sign), Test.NOT_NEGATIVE)
            yield Branch(name, Event.RELEASE, (*moving, (scaled(q, q_sign), Test.POSITIVE)))
            yield Branch(name, Event.RELEASE, (*moving, *enters))
        if rest:
            yield from self._stop()

    def _q_rate(self) -> tuple[Any, ...]:
        flow, q = self.flows[1].row, self.c.q_row
        a0, a1, b = flow[..., layout.A0], flow[..., layout.A1], flow[..., layout.B]
        q_u, q_w = double(q[0]), double(q[1])
        with np.errstate(over="ignore", invalid="ignore"):  # what is beyond all numbers is refused with the tables
            return -q_w * a0, q_u - q_w * a1, q_w * b

    def _stop(self) -> tuple[Branch, ...]:
        """At θ′ = 0 with Γ₊ > 0: the torque beyond the band decides the direction, Q the law."""
        positive, negative = (self.c.q_row, Test.POSITIVE), (scaled(self.c.q_row, -1), Test.POSITIVE)
        above, below = (self.above, Test.POSITIVE), (self.below, Test.POSITIVE)
        return (
            Branch("slip_forward_positive", Event.REVERSAL, (above, positive)),
            Branch("slip_forward_negative", Event.REVERSAL, (above,)),
            Branch("slip_backward_negative", Event.REVERSAL, (below, negative)),
            Branch("slip_backward_positive", Event.REVERSAL, (below,)),
            Branch("rest", Event.STICK),
        )

    def painleve(self, resume: Resume) -> tuple[dict[str, Mode], dict[str, Transition]]:
        """Modes and transitions for Γ₊ ≤ 0: slip under law −1 only, seizure at Q = 0."""
        standing = self._beyond_band(Event.STICK, Event.REVERSAL)
        starts = tuple(
            Branch(name, Event.RELEASE, ((scaled(self.speed, direction), Test.POSITIVE),))
            for direction, name in BY_LAW_MINUS.items()
        )
        modes, transitions = {}, {"entry": Transition((*starts, *standing)), "stop": Transition(standing)}
        push = self._torque_above(-1, False)  # slip under law −1 accelerates forward
        to_rest = ((1, 0, 0), (0, 0, -self.d.input_speed))
        for direction, name in BY_LAW_MINUS.items():
            guards = Guard("contact", -direction, f"seizure_{name}"), Guard("screw_speed", direction, "stop")
            modes[name] = self._slip(name, guards, "rest")
            # A forward impact leaves N > 0, with which law −1 slips backward; and the other way round.
            at_once = tuple(
                Branch(
                    BY_LAW_MINUS[way],
                    Event.SEIZURE,
                    ((scaled(self.c.q_row, -way), Test.POSITIVE), (scaled(push, way), Test.POSITIVE)),
                    sign=direction,
                )
                for way in ((1, -1) if resume == "at_once" else (-direction,))
            )
            later = self._beyond_band(Event.SEIZURE, Event.SEIZURE, direction)
            transitions[f"seizure_{name}"] = Transition((*at_once, *later), reset=to_rest)
        released = Branch(BY_LAW_MINUS[self.turning], Event.RELEASE)
        transitions["release"] = Transition((released,), reset=self.to_corner)
        modes["rest"] = self._rest()
        return modes, transitions

    def _beyond_band(self, stays: int, slips: int, impulse: int = 0) -> tuple[Branch, ...]:
        """Rest within the band, else slip under law −1 in the direction of the excess torque; kinds of both events."""
        return (
            Branch(BY_LAW_MINUS[1], slips, ((self.above, Test.POSITIVE),), impulse),
            Branch(BY_LAW_MINUS[-1], slips, ((self.below, Test.POSITIVE),), impulse),
            Branch("rest", stays, (), impulse),
        )

    def observables(self, modes: Iterable[str]) -> dict[str, dict[str, tuple[Any, ...]]]:
        """Rows of the observables by name and mode."""
        c, d, stiffness, z0 = self.c, self.d, self.d.coupling_stiffness, self.c.deflection
        lever = stiffness * d.sin_lead / d.pitch_radius
        normal = {"rest": (lever, 0, d.axial_force * d.cos_lead + lever * z0)}
        for name in set(modes) - normal.keys():
            law = math.prod(SLIPS[name])
            push = c.gamma[law] * (d.cos_lead + law * d.steady_friction * d.sin_lead)
            normal[name] = scaled(c.q_row, 1 / push)
        return {
            "normal_force": normal,
            "coupling_torque": dict.fromkeys(modes, (-stiffness, 0, -stiffness * z0)),
            "coupling_deflection": dict.fromkeys(modes, (1, 0, z0)),
            "screw_speed": dict.fromkeys(modes, self.speed),
        }
