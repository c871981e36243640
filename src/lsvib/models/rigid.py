r"""The rigid drive: one degree of freedom, nut and screw tied by x = r_m tan λ θ (Sect. 5.3, eqs 8.13–8.17).

          Ω t                θ                      x = r_m tan λ θ
    motor ──/\/\/\── k ──▶ (I) screw ═══threads═══▶ [m] nut ──▶ R
                            c to ground                c_x to ground

State (u, w): u = z − z_0 [rad] is the deviation of the coupling deflection z = θ − Ω t from steady sliding, w = u′
[rad/s] its rate; the screw turns at θ′ = Ω + w. With s = sgn(θ′)·sgn(N) and R̃ = R − r_m tan λ c_x Ω,

    Γ_s u″ + C_s u′ + k u = r_m (ξ_0 − ξ_s) R̃,        N = Q / [Γ_s (cos λ + s μ sin λ)],
    (8.16, 8.17) Q = r_m tan λ [m k u + (m c − I c_x) u′] + Γ_0 R̃,

so the motion is linear in each combination of signs of θ′ and Q, and at rest, where u′ = −Ω and static friction holds
while the coupling torque T_r = −k (z_0 + u) stays between r_m R ξ₊ and r_m R ξ₋.

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

from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from lsvib.engine.automaton import (
    SHORT_STAY,
    Automaton,
    Branch,
    Guard,
    Mode,
    Surface,
    Transition,
    assemble,
    eigenform,
    oscillator,
    scaled,
)
from lsvib.engine.exact.arithmetic import double, many_digits, root, sign
from lsvib.engine.kernels import layout
from lsvib.engine.kernels.layout import ACCUMULATION_KIND, FIRST_MODEL_KIND, GRAZE_KIND, Test
from lsvib.errors import InputError
from lsvib.models.drive import RigidDrive, once
from lsvib.models.mechanics import Coefficients, coefficients
from lsvib.models.model import Model, Powers, Resume

STATES = ("angle_deviation", "velocity_deviation")


class EventKind(IntEnum):
    """What happens at an event."""

    GRAZE = GRAZE_KIND  # a guard is touched, not crossed
    ACCUMULATION = ACCUMULATION_KIND  # infinitely many events end here
    CONTACT_REVERSAL = FIRST_MODEL_KIND  # N changes sign
    STICK = FIRST_MODEL_KIND + 1  # θ′ = 0, and static friction holds
    REVERSAL = FIRST_MODEL_KIND + 2  # θ′ = 0, and the screw turns back
    RELEASE = FIRST_MODEL_KIND + 3  # static friction gives way
    SEIZURE = FIRST_MODEL_KIND + 4  # θ′ jumps to zero by a tangential impact


class MotionMode(IntEnum):
    """Modes of the rigid drive; the second word of a slip mode is the sign of Q."""

    SLIP_FORWARD_POSITIVE = 0
    SLIP_FORWARD_NEGATIVE = 1
    SLIP_BACKWARD_POSITIVE = 2
    SLIP_BACKWARD_NEGATIVE = 3
    REST = 4


SLIPS = {  # mode: (sign of θ′, sign of Q)
    "slip_forward_positive": (1, 1),
    "slip_forward_negative": (1, -1),
    "slip_backward_positive": (-1, 1),
    "slip_backward_negative": (-1, -1),
}
_FORWARD, _BACKWARD = "slip_forward_negative", "slip_backward_positive"  # the slips under law −1


def rigid_automaton(drive: RigidDrive, *, rest: bool = True, resume: Resume = "contact_sign") -> Automaton:
    """Return the rigid drive's automaton.

    Arguments: the drive; ``rest=False`` leaves out θ′ = 0 with everything that belongs to it (reversal, rest, seizure),
    for motions that are known not to reach it – only outside the Painlevé region; ``resume``: see the module docstring.
    Observables: normal_force [N], coupling_torque [N m], coupling_deflection [rad], screw_speed [rad/s]. Raises
    ``InputError`` for ``rest=False`` in the Painlevé region.
    """
    # Without seizures the rules of resuming make no difference.
    return _automaton(drive, rest, resume if coefficients(drive).paradox else "contact_sign")


@once
def _automaton(drive: RigidDrive, rest: bool, resume: Resume) -> Automaton:
    return automaton_of(coefficients(drive), drive.exact(), rest, resume)


def automaton_of(c: Coefficients, d: Any, rest: bool, resume: Resume) -> Automaton:
    """Return the automaton from coefficients and exact parameters, of one drive or of many at once.

    The tables of doubles of many drives have one more axis, the first. ``resume`` is contact_sign outside the Painlevé
    region.
    """
    with many_digits():
        terms = {
            s: (
                c.gamma[s],
                c.damping[s],
                d.coupling_stiffness,
                d.pitch_radius * c.slack(s) * c.net_force,
            )
            for s in ((-1,) if c.paradox else (1, -1))
        }
        flows = {s: _SlipFlow(oscillator(*row), eigenform(*row)) for s, row in terms.items()}
        stand = _Stand(c, d)
        surfaces = {"contact": Surface(c.q_row, _mover(c, d))}
        if rest:
            surfaces["screw_speed"] = Surface((0, 1, d.input_speed), 1)
            surfaces["band_end"] = Surface(stand.band_end, 0)
        modes, transitions = _painleve(flows, stand, rest, resume) if c.paradox else _regular(flows, stand, rest)
        return assemble(
            states=STATES,
            surfaces=surfaces,
            modes=modes,
            transitions=transitions,
            observables=_observables(c, d, modes),
            shortest_stay=SHORT_STAY * np.min([flow.row[..., layout.TIME_SCALE] for flow in flows.values()], axis=0),
            rest_codes=(MotionMode.REST,),
            release_kinds=(EventKind.RELEASE,),
            sprag_kinds=(EventKind.SEIZURE,),
            passive=rest,
            contracts=_contracts(c),
        )


def _contracts(c: Coefficients) -> bool:
    """Whether the motion enlarges no area (see ``Automaton``): Γ₊ > 0 and both C_s > 0, or both zero.

    Slip changes an area at the rate −C_s / Γ_s. Both laws agree on Q = 0. Where θ′ passes zero, friction reverses: the
    acceleration forward is below that backward by |Q| (1/Γ₊ − 1/Γ₋) / (m r_m tan λ), so that areas are squeezed.
    """
    signs = [sign(damping, "support_damping") for damping in c.damping.values()]
    return not c.paradox and signs in ([0, 0], [1, 1])


def _mover(c: Coefficients, d) -> int:
    """Coordinate that is set on Q = 0: the one that moves Q more, so that its own rounding is not amplified."""
    time = root(c.gamma[-1] / d.coupling_stiffness)
    return 0 if sign(abs(c.q_row[0]) * time - abs(c.q_row[1])) >= 0 else 1


class _SlipFlow(NamedTuple):
    row: np.ndarray
    exact: tuple | None


class _Stand:
    """Rows and conditions at θ′ = 0 (positive where the name says)."""

    def __init__(self, c: Coefficients, d) -> None:
        def torque_above(law: int) -> tuple:
            """(T_r − r_m ξ R) / k [rad] as a function of (u, w) under a law; k z_0 is inserted: nothing cancels."""
            steady = (c.damping[c.steady_law] * d.input_speed) / d.coupling_stiffness
            friction = d.pitch_radius * c.slack(law) * d.axial_force / d.coupling_stiffness
            return -1, 0, steady + friction

        force = sign(d.axial_force)
        upper, lower = (1, -1) if force >= 0 else (-1, 1)
        self.above = torque_above(upper)
        self.below = scaled(torque_above(lower), -1)
        self.pushes_forward = torque_above(-1)  # slip under law −1 accelerates forward
        self.pushes_backward = scaled(self.pushes_forward, -1)
        self.q = c.q_row
        self.speed = (0, 1, d.input_speed)
        self.to_rest = ((1, 0, 0), (0, 0, -d.input_speed))
        # T_r grows at k Ω while the screw rests, so one end of the band is ahead; this row is positive before it.
        self.turning = sign(d.input_speed)
        self.band_end = scaled(self.above if self.turning > 0 else self.below, -1)
        # Without R the band is a point, the corner of θ′ = 0 and Q = 0. Events accumulate there when what is left of
        # them lies below rounding; rest then ends as soon as it begins, and the release begins in the very corner:
        # beside it, on the wrong side by a last place, the screw would stop again at once, and so for ever.
        self.cornered = _cornered(c, d, self.band_end[2])
        self.after_all = "rest" if self.cornered else None
        self.to_corner = ((0, 0, -self.turning * self.band_end[2]), (0, 1, 0)) if self.cornered else None
        self.release_sign = force or -self.turning

    def beyond_band(self, kinds: tuple[int, int], sign: int = 0) -> tuple[Branch, ...]:
        """Rest within the band, else slip under law −1 in the direction of the excess torque; kinds (rest, slip)."""
        return (
            Branch(_FORWARD, kinds[1], ((self.above, Test.POSITIVE),), sign),
            Branch(_BACKWARD, kinds[1], ((self.below, Test.POSITIVE),), sign),
            Branch("rest", kinds[0], (), sign),
        )


_CORNERED = 10**13  # part of u that counts: a tenth of it is what rounding may make of u


def _cornered(c: Coefficients, d: Any, place: Any) -> bool:
    """Whether at θ′ = 0 a double cannot tell the band of static friction, or what Q is at its end, from one corner.

    ``place``: u at the end of the band, or −u [rad]. At θ′ = 0 the band is R (Γ₋ − Γ₊) / (m k r_m tan λ) wide, and Q =
    0 lies R Γ₊ / (m k r_m tan λ) from its end.
    """
    if sign(d.axial_force) == 0:
        return True
    least = abs(place) * d.mass * d.coupling_stiffness * d.pitch_radius * d.tan_lead
    force = _CORNERED * abs(d.axial_force)
    return any(sign(force * x - least) <= 0 for x in (abs(c.gamma[1]), c.gamma[-1] - c.gamma[1]))


def _name(direction: int, q_sign: int) -> str:
    return f"slip_{'forward' if direction > 0 else 'backward'}_{'positive' if q_sign > 0 else 'negative'}"


def _rest_mode(stand: _Stand) -> Mode:
    return Mode(MotionMode.REST, oscillator(1, 0, 0, 0), (Guard("band_end", 1, "release"),), stand.after_all)


def _regular(flows, stand: _Stand, rest: bool):
    """Modes and transitions for Γ₊ > 0."""
    modes = {}
    for code, (name, (direction, q_sign)) in enumerate(SLIPS.items()):
        if not rest and direction != stand.turning:
            continue
        guards = (Guard("contact", q_sign, f"contact_reversal_{name}"),)
        if rest:
            guards += (Guard("screw_speed", direction, "stop"),)
        flow = flows[direction * q_sign]
        modes[name] = Mode(code, flow.row, guards, stand.after_all if rest else None, flow.exact)
    # Q′ at Q = 0 is the same under both laws; on the line itself it decides which side is entered.
    transitions = {"entry": Transition(tuple(_entry(modes, flows, stand, rest)))}
    for name in modes:
        direction, q_sign = SLIPS[name]
        other = Branch(_name(direction, -q_sign), EventKind.CONTACT_REVERSAL, sign=-q_sign)
        transitions[f"contact_reversal_{name}"] = Transition((other,))
    if rest:
        transitions["stop"] = Transition(_stop(stand))
        released = Branch(_name(stand.turning, stand.release_sign), EventKind.RELEASE)
        transitions["release"] = Transition((released,), reset=stand.to_corner)
        modes["rest"] = _rest_mode(stand)
    return modes, transitions


def _stop(stand: _Stand) -> tuple[Branch, ...]:
    """At θ′ = 0 with Γ₊ > 0: the torque beyond the band decides the direction, Q the law."""
    positive, negative = (stand.q, Test.POSITIVE), (scaled(stand.q, -1), Test.POSITIVE)
    above, below = (stand.above, Test.POSITIVE), (stand.below, Test.POSITIVE)
    return (
        Branch("slip_forward_positive", EventKind.REVERSAL, (above, positive)),
        Branch("slip_forward_negative", EventKind.REVERSAL, (above,)),
        Branch("slip_backward_negative", EventKind.REVERSAL, (below, negative)),
        Branch("slip_backward_positive", EventKind.REVERSAL, (below,)),
        Branch("rest", EventKind.STICK),
    )


def _entry(modes, flows, stand: _Stand, rest: bool):
    """Where a motion starts: by the signs of θ′ and Q; on Q = 0 by the sign of Q′; at θ′ = 0 as on stopping there."""
    flow = flows[1].row
    a0, a1, b = flow[..., layout.A0], flow[..., layout.A1], flow[..., layout.B]
    q_u, q_w = double(stand.q[0]), double(stand.q[1])
    with np.errstate(over="ignore", invalid="ignore"):  # what is beyond all numbers is refused with the tables
        q_rate = (-q_w * a0, q_u - q_w * a1, q_w * b)
    for direction in (1, -1):
        moving = ((scaled(stand.speed, direction), Test.POSITIVE),) if rest else ()
        if _name(direction, 1) not in modes:
            continue
        for q_sign in (1, -1):
            name = _name(direction, q_sign)
            yield Branch(name, EventKind.RELEASE, (*moving, (scaled(stand.q, q_sign), Test.POSITIVE)))
            yield Branch(
                name, EventKind.RELEASE, (*moving, (stand.q, Test.ZERO), (scaled(q_rate, q_sign), Test.NOT_NEGATIVE))
            )
    if rest:
        yield from _stop(stand)


def _painleve(flows, stand: _Stand, rest: bool, resume: Resume):
    """Modes and transitions for Γ₊ ≤ 0: slip under law −1 only, seizure at Q = 0."""
    if not rest:
        raise InputError(
            "physics leaves out rest, which a drive at or beyond its critical mass may always come to; list rest, or "
            "take mass < critical_mass (see lsvib thresholds)."
        )
    modes, transitions = {}, {}
    forward_now = ((scaled(stand.q, -1), Test.POSITIVE), (stand.pushes_forward, Test.POSITIVE))
    backward_now = ((stand.q, Test.POSITIVE), (stand.pushes_backward, Test.POSITIVE))
    standing = stand.beyond_band((EventKind.STICK, EventKind.REVERSAL))
    transitions["entry"] = Transition(
        (
            Branch(_FORWARD, EventKind.RELEASE, ((stand.speed, Test.POSITIVE),)),
            Branch(_BACKWARD, EventKind.RELEASE, ((scaled(stand.speed, -1), Test.POSITIVE),)),
            *standing,
        )
    )
    transitions["stop"] = Transition(standing)
    for name in (_FORWARD, _BACKWARD):
        direction, q_sign = SLIPS[name]
        guards = (Guard("contact", q_sign, f"seizure_{name}"), Guard("screw_speed", direction, "stop"))
        flow = flows[-1]
        modes[name] = Mode(MotionMode[name.upper()], flow.row, guards, "rest", flow.exact)
        # A forward impact leaves N > 0, with which law −1 slips backward; and the other way round.
        go_backward = Branch(_BACKWARD, EventKind.SEIZURE, backward_now, sign=direction)
        go_forward = Branch(_FORWARD, EventKind.SEIZURE, forward_now, sign=direction)
        if resume == "at_once":
            at_once = (go_forward, go_backward)
        else:
            at_once = (go_backward,) if direction > 0 else (go_forward,)
        later = stand.beyond_band((EventKind.SEIZURE, EventKind.SEIZURE), sign=direction)
        transitions[f"seizure_{name}"] = Transition((*at_once, *later), reset=stand.to_rest)
    released = Branch(_FORWARD if stand.turning > 0 else _BACKWARD, EventKind.RELEASE)
    transitions["release"] = Transition((released,), reset=stand.to_corner)
    modes["rest"] = _rest_mode(stand)
    return modes, transitions


def _observables(c: Coefficients, d, modes) -> dict[str, dict[str, tuple]]:
    stiffness, z0 = d.coupling_stiffness, c.deflection
    normal = {}
    for name in modes:
        if name == "rest":
            lever = stiffness * d.sin_lead / d.pitch_radius
            normal[name] = (lever, 0, d.axial_force * d.cos_lead + lever * z0)
        else:
            law = SLIPS[name][0] * SLIPS[name][1]
            normal[name] = scaled(
                c.q_row, 1 / (c.gamma[law] * (d.cos_lead + law * d.friction_coefficient * d.sin_lead))
            )
    return {
        "normal_force": normal,
        "coupling_torque": dict.fromkeys(modes, (-stiffness, 0, -stiffness * z0)),
        "coupling_deflection": dict.fromkeys(modes, (1, 0, z0)),
        "screw_speed": dict.fromkeys(modes, (0, 1, d.input_speed)),
    }


_FORCES = ("stick", "detach", "global_stability")  # thresholds of the axial force in closed form, also curves
MODEL = Model(
    drive=RigidDrive,
    build=lambda drive, physics, resume: rigid_automaton(drive, rest="rest" in physics, resume=resume),
    start=lambda drive, values: np.array([values["u"], values["w"]], dtype=float),
    modes=MotionMode,
    events=EventKind,
    states=STATES,
    terms=("support_damping", "translation_damping", "axial_force"),
    options=("rest",),
    equations="eqs 8.13-8.17",
    characteristic=lambda p, parts: parts.rigid(),
    constraint="Γ₊ = I − ξ₊ tan λ m r_m² = 0 (eq. 8.20)",
    thresholds=("onset", "kinematic_constraint", "negative_damping", *_FORCES, "fold", "cycle_birth", "rest_loss"),
    curves=("onset", *_FORCES, "kinematic_constraint", "negative_damping", "stick_slip_birth"),
    powers=Powers,
    section="5.3",
)
