"""The contact force: how many the rigid drive has (8.5), and how it moves while the threads are stiff (8.6)–(8.12).

For the short time of a contact transient θ′, T and P are constant. With N = k_c δ + c_c δ′ Newton's laws give, for
the law s = sgn(θ′) sgn(N), b_s = cos λ + s μ sin λ and W = I P − m r_m tan λ T,

    N″ = cos λ / (m I) [k_c (W − b_s Γ_s N) − c_c b_s Γ_s N′].

N and N′ are continuous where N changes its sign, so the motion is unique. The chapter's χ = N b_s / W (8.8) and time
ω̄_s t, ω̄_s² = k_c cos λ b_s |Γ_s| / (m I) (8.9), depend on the law: χ′ would jump where the law changes. Here the rate
and the time are scaled by law − on both sides,

    x = N b_- / W,   τ = ω̄_- t:    law −:  x″ + ζ x′ + x = 1/Γ_-            ζ = c_c ω̄_- / k_c   (Remark 8.1)
                                    law +:  x″ = ρ² (x + ζ x′) + 1/Γ_-        ρ² = b_+ |Γ_+| / (b_- Γ_-)

and χ = x on the side of law −, χ = x b_+ / b_- on that of law +. So law − has a centre (ζ > 0: focus, ζ ≥ 2: node) at
χ = 1/Γ_- and law +, with Γ_+ < 0, a saddle at χ = 1/Γ_+. Which side is whose, with θ′ > 0 (θ′ < 0 turns all signs of N
and W): N has the sign of χ W. In the **indeterminate** case W < 0, so χ < 0 means N > 0, law +, and χ > 0 law −: both
equilibria lie on their sides. In the **inconsistent** case W > 0, χ > 0 is law + and χ < 0 law −: neither does.

These motions are followed here and not by the engine, so that Figs 8.1 and 8.2 load no numba.
"""

import cmath
import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lsvib.errors import InputError
from lsvib.models import friction
from lsvib.models.drive import Drive
from lsvib.models.mechanics import coefficients, effective_inertia, friction_factor
from lsvib.numbers import bisected

ForceState = tuple[float, float]


class Paradox(IntEnum):
    """Which paradox the state is in, by the sign of θ′ W (Sect. 8.1)."""

    INDETERMINATE = -1
    INCONSISTENT = 1


class ForceOutcome(IntEnum):
    """What becomes of the contact force."""

    BOUNDED = 0
    MINUS_INFINITY = 1  # χ → −∞
    PLUS_INFINITY = 2  # χ → +∞


@dataclass(frozen=True)
class ForceFlow:
    """x″ + p x′ + q (x − x*) = 0 where ``side`` · x ≥ 0."""

    side: int
    equilibrium: float
    damping: float
    stiffness: float

    def rates(self) -> tuple[complex, complex]:
        """Return the eigenvalues; the first has the larger real part, or the positive imaginary one.

        Of two real ones that nearer to zero follows from their product, as their sum would cancel.
        """
        root = cmath.sqrt(self.damping**2 - 4 * self.stiffness)
        if root.imag != 0 or self.damping == 0:
            return (root - self.damping) / 2, (-root - self.damping) / 2
        far = (-self.damping - math.copysign(root.real, self.damping)) / 2
        near = self.stiffness / far
        return complex(max(near, far)), complex(min(near, far))

    def amplitudes(self, start: ForceState) -> tuple[complex, complex]:
        """Return the factors of both exponentials in x − x* for a motion from ``start``."""
        first, second = self.rates()
        distance = start[0] - self.equilibrium
        return (start[1] - second * distance) / (first - second), (first * distance - start[1]) / (first - second)

    def at(self, start: ForceState, time: float) -> ForceState:
        """Return the state after ``time``, in closed form (8.12)."""
        (first, second), (a, b) = self.rates(), self.amplitudes(start)
        a, b = a * cmath.exp(first * time), b * cmath.exp(second * time)
        return self.equilibrium + (a.real + b.real), (a * first).real + (b * second).real

    def crossing(self, start: ForceState) -> float | None:
        """Return the first time > 0 at which x leaves the side, None if it never does.

        Between its extrema, which are known in closed form, x is monotone, so the first of them beyond x = 0 isolates
        the root; bisection finds it to the last bit. An oscillation that does not grow crosses by its second extremum.
        """

        def left(time: float) -> bool:
            return self.side * self.at(start, time)[0] < 0

        inner = 0.0
        for outer in self._extrema(start):
            if left(outer):
                return bisected(left, inner, outer)
            inner = outer
        return None

    def _extrema(self, start: ForceState) -> list[float]:
        """Times between which x is monotone; without oscillation the last one lies beyond every crossing."""
        (first, second), (a, b) = self.rates(), self.amplitudes(start)
        ratio = -b * second / (a * first) if a != 0 else math.nan
        if first.imag != 0:
            half_turn = math.pi / first.imag
            return [cmath.phase(ratio) % (2 * math.pi) / (2 * first.imag) + n * half_turn for n in range(3)]
        turn = max(math.log(ratio.real) / (first - second).real, 0.0) if ratio.real > 0 else 0.0
        times = [turn] if turn > 0 else []
        limit = a.real if first.real > 0 else self.equilibrium
        if self.side * limit < 0:
            times.append(2 * turn + 1 / abs(first))
            while self.side * self.at(start, times[-1])[0] >= 0:
                times[-1] *= 2
        return times


@dataclass(frozen=True)
class ForceArc:
    """Motion under one law from ``start`` on for ``duration``, infinite if it never leaves the law."""

    flow: ForceFlow
    start: ForceState
    duration: float


def contact_flows(drive: Drive, paradox: Paradox) -> dict[int, ForceFlow]:
    """Return the flow of each law, θ′ > 0 (module text). Raises ``InputError`` unless Γ_+ < 0, or if ζ = 2 exactly."""
    c = coefficients(drive)
    plus, minus = float(c.gamma[1]), float(c.gamma[-1])
    if plus >= 0:
        raise InputError("The effective inertia of law + is not negative: there is no paradox.")
    ratio = _lever(drive, 1) / _lever(drive, -1)
    damping = drive.contact_damping * contact_frequency(drive) / drive.contact_stiffness
    if damping == 2:
        raise InputError("The contact is damped critically, for which the closed form has no two exponentials.")
    square = -ratio * plus / minus
    return {
        1: ForceFlow(int(paradox), 1 / (ratio * plus), -square * damping, -square),
        -1: ForceFlow(-int(paradox), 1 / minus, damping, 1.0),
    }


def contact_frequency(drive: Drive) -> float:
    """Frequency of the contact under law −, ω̄_- = √(k_c cos λ b_- Γ_- / (m I)) [1/s] (eq. 8.9)."""
    inertia = drive.mass * drive.screw_inertia
    stiffness = drive.contact_stiffness * math.cos(drive.lead_angle) * _lever(drive, -1)
    return math.sqrt(stiffness * float(coefficients(drive).gamma[-1]) / inertia)


def force_scale(drive: Drive) -> float:
    """Return b_+ / b_-, the factor from x to the chapter's χ on the side of law + [1]."""
    return _lever(drive, 1) / _lever(drive, -1)


def _lever(drive: Drive, law: int) -> float:
    return math.cos(drive.lead_angle) + law * float(drive.exact().steady_friction) * math.sin(drive.lead_angle)


def follow(flows: dict[int, ForceFlow], start: ForceState) -> tuple[list[ForceArc], ForceOutcome]:
    """Follow a motion of (x, x′) from arc to arc; return them and the outcome, read off the last arc's closed form.

    On x = 0 the sign of x′ decides which law follows; with x′ = 0 it is the right side, as x″ = 1/Γ_- > 0 there. A
    motion that crosses x = 0 again as it did two arcs before repeats itself; the arcs end there.
    """
    arcs: list[ForceArc] = []
    while len(arcs) < 1000:  # a motion that still crosses N = 0 then counts as bounded
        inside = start[0] or start[1]
        flow = next(flow for flow in flows.values() if (inside >= 0) == (flow.side > 0))
        time = flow.crossing(start)
        if time is None:
            arcs.append(ForceArc(flow, start, math.inf))
            grows = flow.stiffness < 0 and flow.amplitudes(start)[0] != 0
            ending = ForceOutcome.PLUS_INFINITY if flow.side > 0 else ForceOutcome.MINUS_INFINITY
            return arcs, ending if grows else ForceOutcome.BOUNDED
        arcs.append(ForceArc(flow, start, time))
        start = 0.0, flow.at(start, time)[1]
        if len(arcs) > 2 and abs(start[1] - arcs[-2].start[1]) <= 1e-13 * abs(start[1]):
            break
    return arcs, ForceOutcome.BOUNDED


def reversed_in_time(flows: dict[int, ForceFlow]) -> dict[int, ForceFlow]:
    """Return the flows of (x, −x′) as time runs backwards: the saddle's stable manifold is an unstable one there."""
    return {law: ForceFlow(flow.side, flow.equilibrium, -flow.damping, flow.stiffness) for law, flow in flows.items()}


class Existence(IntEnum):
    """How many contact forces solve the rigid-body equations at a state."""

    INCONSISTENT = 0  # none
    UNIQUE = 1
    INDETERMINATE = 2  # two
    BOUNDARY = 3  # Q = 0 or θ′ = 0: the sign functions of (8.3) are not defined


def contact_forces(drive: Drive, u: ArrayLike, w: ArrayLike) -> np.ndarray:
    """Contact force that each friction law would give, N_s = Q / [Γ_s (cos λ + s μ sin λ)] (eqs 8.5, 8.17).

    Arguments: u [rad], w = u′ [rad/s], arrays of one shape. Returns N₊ and N₋ [N], shape (2, ...). The law is
    admissible where sgn(N_s) sgn(θ′) = s; Γ_s = 0 gives an infinite force. Where friction depends on the speed, Γ_s and
    μ are those at the sliding speed of the state; Q is the same.
    """
    c = coefficients(drive)
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    q = q_u * np.asarray(u) + q_w * np.asarray(w) + q_0
    cosine, sine = np.cos(drive.lead_angle), np.sin(drive.lead_angle)
    mu, gamma = drive.friction_coefficient, {s: float(inertia) for s, inertia in c.gamma.items()}
    if friction.depends_on_speed(drive):
        mu, gamma = _at_speed(drive, np.asarray(w, dtype=float))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([q / (gamma[s] * (cosine + s * mu * sine)) for s in (1, -1)])


def _at_speed(drive: Drive, w: np.ndarray) -> tuple[Any, dict[int, Any]]:
    """μ and Γ_s at the rate w [rad/s] of states."""
    tangent = np.tan(drive.lead_angle)
    mu, _ = friction.steady({**dict(drive), "input_speed": np.atleast_1d(drive.input_speed + w)}, tangent)
    mu = mu.reshape(w.shape)
    factors = {s: friction_factor(mu, tangent, s) for s in (1, -1)}
    geometry = drive.screw_inertia, drive.mass, drive.pitch_radius, tangent
    return mu, {s: effective_inertia(*geometry, factor) for s, factor in factors.items()}


def existence(drive: Drive, u: ArrayLike, w: ArrayLike) -> np.ndarray:
    """Classify states by their number of admissible contact forces; equal shapes in, ``Existence`` (int8) out."""
    forces = contact_forces(drive, u, w)
    direction = np.sign(drive.input_speed + np.asarray(w))
    admissible = [np.sign(force) * direction == s for force, s in zip(forces, (1, -1), strict=True)]
    count = np.where((direction == 0) | (forces[1] == 0), Existence.BOUNDARY, np.sum(admissible, axis=0))
    return count.astype(np.int8)
