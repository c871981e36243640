"""What a motion passes on: impulses of seizures, and over a cycle, with these, the mean load of the threads and work.

In a seizure the screw and the nut come to rest within no time, so that only the contact acts. With N normal and F
tangential force,

    m Δx′ = −∫(N cos λ + F sin λ) dt,      I Δθ′ = −∫ r_m (F cos λ − N sin λ) dt,      x′ = r_m tan λ θ′.

From θ′ = v to zero the axial impulse is therefore m r_m tan λ v, the impulsive torque I v, and, solving for ∫N dt, the
normal impulse

    J_N = v sin λ (m r_m − I / r_m).

With axial support or a rotating nut x′ has a second part and Δθ′ is not all of θ′, but the two balances are the same;
:func:`event_impulses` takes Δx′ and Δθ′ from the states before and after.

Over a whole cycle the momenta of screw and nut do not change. With c_x = 0 the mean axial contact force is then R, and
the mean contact torque is −k ⟨z⟩ − c Ω.

Work per cycle is that of motor and load, and what friction, damping and impacts take out. Each power is a quadratic
form of (x, 1) in a mode (:mod:`lsvib.drives.powers`), whose integral the flow knows to rounding. The terms are summed
from different laws – input and load from the ends of the drive, friction from N and the speed of sliding, impacts from
the kinetic energy – so that their balance is a check of the cycle.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lsvib.drives.drive import Drive
from lsvib.drives.powers import Powers
from lsvib.systems.automaton import product
from lsvib.systems.cycles import integrals, observable_integrals
from lsvib.systems.motion import Motion


@dataclass(frozen=True)
class Impulses:
    """Impulses of events, arrays of one shape: ``normal`` and ``axial`` [N s], ``torque`` [N m s]."""

    normal: np.ndarray
    axial: np.ndarray
    torque: np.ndarray


def seizure_impulse(drive: Drive, speed: ArrayLike) -> np.ndarray:
    """Return the normal impulse J_N [N s] by which the screw stops from ``speed`` θ′ [rad/s] (array); see above."""
    lever = drive.mass * drive.pitch_radius - drive.screw_inertia / drive.pitch_radius
    return np.asarray(speed, dtype=float) * math.sin(drive.lead_angle) * lever


def event_impulses(drive: Drive, motion: Motion) -> Impulses:
    """Return the impulses of each event of a motion of any model, shape (events), from the balances of momentum.

    With A = −m Δx′ along the axis and T = −I Δθ′ about it the normal impulse is A cos λ − (T / r_m) sin λ. They are
    zero for an event that is no seizure, and so in every event of compliant threads, whose contact force is finite.
    """
    automaton = motion.automaton
    change = np.where(automaton.marked(motion.kind, "impact")[:, None], motion.before - motion.after, 0.0)
    axial, torque = (change @ row for row in balances(dict(drive), automaton.states))
    normal = axial * math.cos(drive.lead_angle) - torque / drive.pitch_radius * math.sin(drive.lead_angle)
    return Impulses(normal=normal, axial=axial, torque=torque)


def balances(p: Mapping[str, Any], states: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows (n) of the axial and the torsional impulse over the fall of the state, or of many drives (k, n).

    Arguments: parameters by name, numbers or arrays (k) in SI units; the names of the coordinates (n).
    """
    lead = p["mass"] * p["pitch_radius"] * np.tan(p["lead_angle"])
    axial = {"w": lead, "shift_rate": p["mass"], "nut_rate": -lead}
    torque = {"w": p["screw_inertia"]}
    rows = ([shares.get(name, 0.0 * lead) for name in states] for shares in (axial, torque))
    first, second = (np.stack(np.broadcast_arrays(*row), axis=-1) for row in rows)
    return first, second


def mean_load(drive: Drive, orbit: Motion) -> np.ndarray:
    """Return the means over one cycle, impulses included, in closed form (c_x = 0, |N| of one sign in each mode).

    They are those of the coupling deflection z [rad], of |N| [N], of its part that comes from seizures [N], and of the
    axial force [N] and the torque [N m] that the threads carry. In slip under law s the threads carry N (cos λ + s μ
    sin λ) along the axis and r_m N (s μ cos λ − sin λ) about it, in rest R and T_r = −k z.
    """
    impulses = event_impulses(drive, orbit)
    sine, cosine = math.sin(drive.lead_angle), math.cos(drive.lead_angle)
    automaton, (modes, starts, ends, durations) = orbit.automaton, orbit.arcs()
    seen = "normal_force", "coupling_torque", "coupling_deflection"
    normal, torque, deflection = observable_integrals(orbit, seen).T
    # Neither θ′ nor N changes its sign along an arc.
    force = automaton.observe("normal_force", starts, modes) + automaton.observe("normal_force", ends, modes)
    law = np.sign(force * (2 * drive.input_speed + starts[:, 1] + ends[:, 1]))
    powers, rows, one = Powers(drive, automaton), automaton.observables["normal_force"], np.eye(starts.shape[1] + 1)[-1]
    rubbed = law * integrals(orbit, lambda mode: [powers.rubbed(product(rows[mode], one))])[:, 0]  # ∫ μ N dt
    rests = automaton.marked(automaton.codes[modes], "rest")
    axial = np.where(rests, drive.axial_force * durations, normal * cosine + rubbed * sine)
    torque = np.where(rests, torque, drive.pitch_radius * (rubbed * cosine - normal * sine))
    impulsive = np.abs(impulses.normal).sum()
    carried = axial.sum() + impulses.axial.sum(), torque.sum() + impulses.torque.sum()
    return np.array([deflection.sum(), np.abs(normal).sum() + impulsive, impulsive, *carried]) / orbit.end_time


@dataclass(frozen=True)
class Work:
    """Work over one period [J]: ``motor`` and ``load`` do it (negative if they receive it), the others dissipate it.

    ``motor``: Ω ∫ T dt, with the torque T of the coupling or, behind a motor, of its controller, T = K_p (Ω − θ_m′)
    + K_i ∫ (Ω − θ_m′) dt. Such a speed loop acts as a spring and a damper to the commanded motion: K_p ∫ (Ω − θ_m′)² dt
    is part of ``damping``, and the rotor receives that much less, ∫ T θ_m′ dt. ``friction``: of threads, slide, bearing
    and collar; ``damping``: of all dampers; ``impacts``: kinetic energy lost in seizures.
    """

    motor: float
    load: float
    friction: float
    damping: float
    impacts: float

    @property
    def balance(self) -> float:
        """Work done less work dissipated, relative to the largest term [1]; zero except for rounding."""
        gained = self.motor + self.load - self.friction - self.damping - self.impacts
        largest = max(abs(getattr(self, term.name)) for term in fields(self))
        return gained / largest if largest else 0.0

    @property
    def efficiency(self) -> float:
        """Work received by load or motor over work done by the other [1]; 0 if both do work, NaN if neither does."""
        put_in = max(self.motor, self.load)
        return max(-min(self.motor, self.load), 0.0) / put_in if put_in > 0 else math.nan


def work(drive: Drive, orbit: Motion) -> Work:
    """Return the work of each kind over one period of a cycle of a drive."""
    automaton = orbit.automaton
    powers, totals = Powers(drive, automaton), np.zeros(4)
    for mode, start, _, duration in zip(*orbit.arcs(), strict=True):
        code = int(mode)
        forms = [powers.motor(code), powers.load(), powers.signed_friction(code), powers.damping()]
        forms += powers.friction(code)
        found = automaton.flow.integral(mode, start, float(duration), forms)
        totals += found[:4]
        totals[2] += np.abs(found[4:]).sum()
    lost = np.array([powers.kinetic(x) - powers.kinetic(y) for x, y in zip(orbit.before, orbit.after, strict=True)])
    seized = automaton.marked(orbit.kind, "impact")
    return Work(*map(float, [*totals, lost[seized].sum()]))
