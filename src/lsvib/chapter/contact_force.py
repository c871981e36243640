"""The contact force: how many solutions the rigid drive has (8.5), and its transient in stiff threads (8.6)–(8.12).

For the short time of a contact transient θ′, T and P are constant. With N = k_c δ + c_c δ′ Newton's laws give, for
the law s = sgn(θ′) sgn(N), b_s = cos λ + s μ sin λ and W = I P − m r_m tan λ T,

    N″ = cos λ / (m I) [k_c (W − b_s Γ_s N) − c_c b_s Γ_s N′].

N and N′ are continuous where N changes its sign, so the motion is unique. The chapter's χ = N b_s / W (8.8) and time
ω̄_s t, ω̄_s² = k_c cos λ b_s |Γ_s| / (m I) (8.9), depend on the law: χ′ would jump where the law changes. Here the rate
and the time are scaled by law − on both sides,

    x = N b_- / W,   τ = ω̄_- t:    law −:  x″ + ζ x′ + x = 1/Γ_-            ζ = c_c ω̄_- / k_c   (Remark 8.1)
                                    law +:  x″ = ρ² (x + ζ x′) + 1/Γ_-        ρ² = b_+ |Γ_+| / (b_- Γ_-)

and χ = x on the side of law −, χ = x b_+ / b_- on that of law +. So law − has a centre (ζ > 0: focus, ζ ≥ 2: node) at
χ = 1/Γ_- and law +, with Γ_+ < 0, a saddle at χ = 1/Γ_+. For θ′ > 0, N has the sign of χ W (θ′ < 0
reverses all signs of N and W). In the **indeterminate** case W < 0, so χ < 0 means N > 0, law +, and χ > 0 law −: both
equilibria lie on their own sides. In the **inconsistent** case W > 0, χ > 0 is law + and χ < 0 law −: neither does.
"""

import math
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike

from lsvib.chapter.common import Motion
from lsvib.chapter.printed_laws import lever
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.names import Event
from lsvib.errors import InputError
from lsvib.systems.automaton import Automaton, Branch, Guard, Mode, Surface, Transition, assemble
from lsvib.systems.exact.modal_form import PlanarMode
from lsvib.systems.kernels.layout import DELTA, EQUILIBRIUM, R1, R2, Status, Test


class Paradox(IntEnum):
    """Which paradox the state is in, by the sign of θ′ W (Sect. 8.1)."""

    INDETERMINATE = -1
    INCONSISTENT = 1


class ForceOutcome(IntEnum):
    """What becomes of the contact force."""

    BOUNDED = 0
    MINUS_INFINITY = 1  # χ → −∞
    PLUS_INFINITY = 2  # χ → +∞


def contact_automaton(drive: Drive, paradox: Paradox, *, backwards: bool = False) -> Automaton:
    """Return the automaton of (x, x′) in the time τ, θ′ > 0 (module text); its modes are law + and law −.

    ``backwards``: that of (x, −x′) as time runs backwards, where the saddle's stable manifold is an unstable one.
    Raises ``InputError`` unless Γ_+ < 0. On x = 0 the sign of x′ decides which law holds; with x′ = 0 it is the right
    side, as x″ = 1/Γ_- > 0 there.
    """
    c = coefficients(drive)
    plus, minus = float(c.gamma[1]), float(c.gamma[-1])
    if plus >= 0:
        raise InputError("The effective inertia of law + is not negative, so there is no paradox.")
    square = -force_scale(drive) * plus / minus  # ρ²
    stiffness = drive.contact_stiffness * math.cos(drive.lead_angle) * lever(drive, -1)
    frequency = math.sqrt(stiffness * minus / (drive.mass * drive.screw_inertia))  # ω̄_- (eq. 8.9)
    damping = drive.contact_damping * frequency / drive.contact_stiffness * (-1) ** backwards
    terms = {"+": (1.0, -square * damping, -square, 1 / minus), "-": (1.0, damping, 1.0, 1 / minus)}
    right, left = ("+", "-")[::paradox]
    sides = {right: 1, left: -1}
    force, rate, kind = (1, 0, 0), (0, 1, 0), Event.CONTACT_REVERSAL
    on_right = (((force, Test.POSITIVE),), ((force, Test.ZERO), (rate, Test.NOT_NEGATIVE)))
    zero = (0, 0, 0), rate  # to the last bit, from where a start is nearer to it than the flow can tell, too
    return assemble(
        states=("contact_force", "contact_force_rate"),
        surfaces={"zero_force": Surface(force, 0)},
        modes={
            law: Mode(int(f"{law}1"), PlanarMode.of(*x), (Guard("zero_force", sides[law], law),))
            for law, x in terms.items()
        },
        transitions={
            "entry": Transition((*(Branch(right, kind, conditions) for conditions in on_right), Branch(left, kind))),
            "+": Transition((Branch("-", kind),), reset=zero),
            "-": Transition((Branch("+", kind),), reset=zero),
        },
        observables={},
        shortest_stay=0.0,
    )


def growing_part(motion: Motion) -> float:
    """Return the factor of the growing exponential of x on a motion's last arc, without end; 0 if nothing grows."""
    row, (x, rate) = motion.automaton.tables.flow[motion.end_mode], motion.end_state
    return (rate - row[R2] * (x - row[EQUILIBRIUM])) / (2 * row[DELTA]) if row[R1] > 0 else 0.0


def outcome(motion: Motion) -> ForceOutcome:
    """Return what becomes of the force, by the closed form of the last arc; one that still crosses N = 0 is bounded."""
    grows = growing_part(motion) if motion.status == Status.SETTLED else 0.0
    return (ForceOutcome.BOUNDED, ForceOutcome.PLUS_INFINITY, ForceOutcome.MINUS_INFINITY)[int(np.sign(grows))]


def force_scale(drive: Drive) -> float:
    """Return b_+ / b_-, the factor from x to the chapter's χ on the side of law + [1]."""
    return float(lever(drive, 1) / lever(drive, -1))


class Existence(IntEnum):
    """How many contact forces solve the rigid-body equations at a state."""

    INCONSISTENT = 0  # none
    UNIQUE = 1
    INDETERMINATE = 2  # two
    BOUNDARY = 3  # Q = 0 or θ′ = 0: the sign functions of (8.3) are not defined


def contact_forces(drive: Drive, u: ArrayLike, w: ArrayLike) -> np.ndarray:
    """Contact force that each friction law would give, N_s = Q / [Γ_s (cos λ + s μ sin λ)] (eqs 8.5, 8.17).

    Arguments: u [rad], w = u′ [rad/s], arrays of one shape; friction that does not depend on speed. Returns N₊ and N₋
    [N], shape (2, ...). The law is admissible where sgn(N_s) sgn(θ′) = s; Γ_s = 0 gives an infinite force.
    """
    c = coefficients(drive)
    q_u, q_w, q_0 = (float(x) for x in c.q_row)
    q = q_u * np.asarray(u) + q_w * np.asarray(w) + q_0
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([q / (float(c.gamma[s]) * lever(drive, s)) for s in (1, -1)])


def existence(drive: Drive, u: ArrayLike, w: ArrayLike) -> np.ndarray:
    """Classify states by their number of admissible contact forces; equal shapes in, ``Existence`` (int8) out."""
    forces = contact_forces(drive, u, w)
    direction = np.sign(drive.input_speed + np.asarray(w))
    admissible = [np.sign(force) * direction == s for force, s in zip(forces, (1, -1), strict=True)]
    count = np.where((direction == 0) | (forces[1] == 0), Existence.BOUNDARY, np.sum(admissible, axis=0))
    return count.astype(np.int8)
