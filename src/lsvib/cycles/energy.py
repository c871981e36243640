r"""Work per cycle: what motor and load put in, what friction, damping and impacts take out. Of every model.

Each power is a quadratic form of (x, 1) in a mode. With Y the affine flow e^{Mt} of the mode in its inner coordinates,

    ∫₀ᵀ Yᵀ Q Y dt = W(T),      W(2h) = W(h) + Y(h)ᵀ W(h) Y(h),

starts from a step so short that Gauss' rule with eight nodes is exact to rounding, and doubles: nothing is sampled, and
neither equal rates nor rates decades apart are special. The terms are summed from different laws – input and load from
the ends of the drive, friction from N and the speed of sliding, impacts from the kinetic energy – so that their balance
is a check of the cycle.
"""

import math
from dataclasses import dataclass, fields

import numpy as np

from lsvib.cycles.variational import inner_coordinates, propagator
from lsvib.drives.parameters import NutParameters, RigidParameters, SupportParameters, ThreadsParameters
from lsvib.drives.registry import find_model
from lsvib.engine.automaton import Automaton
from lsvib.engine.kernels import columns
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.engine.motion import Motion

_SHORT = 0.5  # phase of the first step at the fastest rate: the rule is then wrong by less than 1e-20
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True)
class Work:
    """Work over one period [J]: ``motor`` and ``load`` put in (negative if they take), the others take out.

    ``friction`` of the threads, and of slide and bearing; ``damping``, all dampers; ``impacts``, kinetic energy that
    seizures destroy.
    """

    motor: float
    load: float
    friction: float
    damping: float
    impacts: float

    @property
    def balance(self) -> float:
        """What is put in less what is taken out, relative to the largest term [1]; zero but for rounding."""
        gained = self.motor + self.load - self.friction - self.damping - self.impacts
        largest = max(abs(getattr(self, term.name)) for term in fields(self))
        return gained / largest if largest else 0.0

    @property
    def efficiency(self) -> float:
        """Work that motor or load receives over what the other puts in; 0 if both put in."""
        put_in = max(self.motor, self.load)
        return max(-min(self.motor, self.load), 0.0) / put_in if put_in > 0 else math.nan


def quadratic_integrals(automaton: Automaton, mode: int, state: np.ndarray, time: float, forms: np.ndarray):
    """Return ∫ (x, 1)ᵀ Q (x, 1) dt (k) over a time [s] from a state (n) in a mode, of forms Q (k, n + 1, n + 1)."""
    if time == 0.0:
        return np.zeros(len(forms))
    into, out = inner_coordinates(automaton, mode)
    inner = out.T @ forms @ out
    doublings = max(0, math.ceil(math.log2(max(_fastest(automaton, mode) * time / _SHORT, 1e-300))))
    step = time * 0.5**doublings
    total = np.zeros_like(inner)
    for node, weight in zip(_NODES, _WEIGHTS, strict=True):
        moved = propagator(automaton, mode, 0.5 * step * (1.0 + node))
        total += 0.5 * step * weight * (moved.T @ inner @ moved)
    for k in range(doublings):
        moved = propagator(automaton, mode, step * 2.0**k)
        total = total + moved.T @ total @ moved
    start = into @ np.append(state, 1.0)
    return np.einsum("i,kij,j->k", start, total, start)


def _fastest(automaton: Automaton, mode: int) -> float:
    """Size of the fastest rate [1/s] of a mode."""
    flow = automaton.tables.flow
    if isinstance(flow, BlockFlow):
        return float(flow.rate[mode].max())
    if isinstance(flow, np.ndarray):
        rows, singles = flow[mode][None], np.zeros(0)
    else:
        rows, singles = flow.oscillators[mode, : flow.pairs[mode]], flow.rates[mode, : flow.singles[mode]]
    pairs = np.hypot(rows[:, columns.ALPHA], rows[:, columns.BETA]) + rows[:, columns.DELTA]
    return float(np.max(np.concatenate([np.abs(pairs), np.abs(singles)]), initial=0.0))


def means(orbit: Motion) -> dict[str, float]:
    """Return the exact means over one period of all observables, without the impulses of seizures."""
    names = list(orbit.automaton.observables)
    totals = np.zeros(len(names))
    one = np.eye(orbit.start_state.size + 1)[-1]
    for mode, start, _, duration in zip(*orbit.arcs(), strict=True):
        rows = [orbit.automaton.observables[name][mode] for name in names]
        totals += quadratic_integrals(
            orbit.automaton, mode, start, float(duration), np.array([_product(row, one) for row in rows])
        )
    return dict(zip(names, (float(x) for x in totals / orbit.end_time), strict=True))


def work(drive: RigidParameters, orbit: Motion) -> Work:
    """Return the work of each kind over one period of a cycle of a drive."""
    automaton = orbit.automaton
    powers = _Powers(drive, automaton)
    totals = dict.fromkeys(("motor", "load", "friction", "damping"), 0.0)
    for mode, start, _, duration in zip(*orbit.arcs(), strict=True):
        signed, losses = powers.of(int(mode))
        found = quadratic_integrals(automaton, mode, start, float(duration), np.array([*signed, *losses]))
        totals["motor"] += found[0]
        totals["load"] += found[1]
        totals["damping"] += found[2]
        totals["friction"] += found[3] + float(np.sum(np.abs(found[4:])))
    lost = [powers.kinetic(x) - powers.kinetic(y) for x, y in zip(orbit.before, orbit.after, strict=True)]
    seized = np.isin(orbit.kind, automaton.sprag_kinds)
    return Work(**{k: float(x) for k, x in totals.items()}, impacts=float(sum(np.array(lost)[seized])))


class _Powers:
    """Powers of a drive as quadratic forms of (x, 1) by mode."""

    def __init__(self, drive: RigidParameters, automaton: Automaton) -> None:
        self.drive, self.automaton = drive, automaton
        n = len(automaton.states)
        self.one, unit = np.eye(n + 1)[-1], np.eye(n + 1)
        self.screw = unit[1] + drive.input_speed * self.one
        self.reach = drive.pitch_radius * math.tan(drive.lead_angle)
        self.slip, self.second, self.nut = self.screw, np.zeros(n + 1), self.reach * self.screw
        if isinstance(drive, ThreadsParameters):
            self.nut = self.nut + unit[3]
        elif isinstance(drive, SupportParameters):
            self.second = unit[3]
            self.nut = self.nut + unit[3]
        elif isinstance(drive, NutParameters):
            self.second, self.slip = unit[3], self.screw - unit[3]
            self.nut = self.reach * self.slip

    def of(self, mode: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Motor, load, damping and signed friction; then powers of friction whose sign is that of the mode."""
        d, rows = self.drive, {name: table[mode] for name, table in self.automaton.observables.items()}
        damping = d.support_damping * _product(self.screw, self.screw)
        damping = damping + d.translation_damping * _product(self.nut, self.nut)
        signed, losses = np.zeros_like(damping), []
        sine, cosine = math.sin(d.lead_angle), math.cos(d.lead_angle)
        normal = rows["normal_force"]
        resting = self.automaton.codes[mode] in self.automaton.rest_codes
        if isinstance(d, ThreadsParameters):
            parting = np.eye(len(self.one))[3]
            damping = damping + d.contact_damping * cosine**2 * _product(parting, parting)
            if resting:  # static friction moves with the nut
                friction = (rows["coupling_torque"] / d.pitch_radius + sine * normal) / cosine
                signed = sine * _product(friction, parting)
            else:
                law = _law(find_model(d.model).modes(int(self.automaton.codes[mode])).name)
                sliding = d.pitch_radius / cosine * self.screw + sine * parting
                signed = law * d.friction_coefficient * _product(normal, sliding)
        elif not resting:
            losses.append(d.friction_coefficient * d.pitch_radius / cosine * _product(normal, self.slip))
        if isinstance(d, SupportParameters):
            damping = damping + d.axial_support_damping * _product(self.second, self.second)
        if isinstance(d, NutParameters):
            damping = damping + d.nut_damping * _product(self.second, self.second)
        if isinstance(d, SupportParameters | NutParameters):
            losses.append(d.slide_friction * _product(self.nut, self.one))
            losses.append(d.bearing_friction * _product(self.screw, self.one))
        motor = d.input_speed * _product(rows["coupling_torque"], self.one)
        return [motor, d.axial_force * _product(self.nut, self.one), damping, signed], losses

    def kinetic(self, state: np.ndarray) -> float:
        """Kinetic energy [J] at a state."""
        x, d = np.append(state, 1.0), self.drive
        second = {"support": "screw_mass", "nut": "nut_inertia"}.get(d.model)
        inertia = getattr(d, second) if second else 0.0
        return float(
            0.5 * (d.screw_inertia * (self.screw @ x) ** 2 + d.mass * (self.nut @ x) ** 2)
            + 0.5 * inertia * (self.second @ x) ** 2
        )


def _product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The product of two affine functions as a symmetric form."""
    return 0.5 * (np.outer(left, right) + np.outer(right, left))


def _law(name: str) -> int:
    """s of a mode of compliant threads, from the direction of slip and the sign of N in its name."""
    return (1 if "FORWARD" in name else -1) * (1 if name.endswith("POSITIVE") else -1)
