"""Coefficients of the equations of motion (8.13)–(8.17), and what the characteristic polynomials of all models share.

The formulas are plain arithmetic, and decide by the sign of a number alone. So the same lines serve the balls of one
drive (``Drive.exact()``), arrays of doubles, which are many drives, and power series, which carry derivatives
(:mod:`lsvib.systems.exact.arithmetic`). Symbols are those of the chapter: ``law`` is s = sgn(θ̇)·sgn(N) = ±1,
``tan_lead`` is tan λ, ``factor`` is ξ_s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import Any, Self

import numpy as np
from flint import arb

from lsvib.drives import friction
from lsvib.drives.drive import PARTS, Drive, once, require_direction
from lsvib.drives.names import BODIES
from lsvib.systems.automaton import scaled
from lsvib.systems.exact.arithmetic import Row, added, many_digits, multiplied, nothing, root, sign

Polynomial = tuple[Any, ...]  # highest power first
Fraction = tuple[Sequence[Any], Sequence[Any]]  # of two polynomials


def friction_factor(friction_coefficient: Any, tan_lead: Any, law: Any) -> Any:
    """Friction factor of the threads, ξ_s = (s μ − tan λ) / (1 + s μ tan λ) [1] (eqs 5.11, 8.4).

    >>> round(friction_factor(0.218, 0.0975, 1), 4)
    0.118
    """
    return (law * friction_coefficient - tan_lead) / (1 + law * friction_coefficient * tan_lead)


def relieved_half(force: Any, preload: Any, share: Any) -> Any:
    """Axial force [N] on the half of a preloaded nut that a load relieves, max(P − (1 − σ) F, 0).

    The other half bears that and the ``force`` F: P + σ F while the ``preload`` P [N] lasts. ``share`` σ of the load is
    its own: 1 where a soft spring keeps the preload, a half where both halves are as stiff.
    """
    return np.maximum(preload - (1 - share) * force, 0.0)


def thread_force(force: Any, relieved: Any, friction_coefficient: Any, tan_lead: Any, law: Any) -> Any:
    """Torque of steadily turned threads over r_m [N]: F tan(φ − s λ), s = −1 against the ``force`` F ≥ 0, 1 with it.

    ``relieved`` F′ on the :func:`relieved_half` adds F′ (tan(φ + λ) + tan(φ − λ)), as both halves rub under it.
    """
    own, other = (side * friction_factor(friction_coefficient, tan_lead, side) for side in (law, -law))
    return force * own + relieved * (own + other)


def holding_coefficient(torque: Any, force: Any, relieved: Any, tan_lead: Any, law: Any) -> Any:
    """The friction coefficient [1] at which :func:`thread_force` is ``torque`` [N], the one below jamming."""
    square = tan_lead * (torque * tan_lead - law * force)
    linear, constant = (1 + tan_lead**2) * (force + 2 * relieved), torque + law * tan_lead * force
    return 2 * constant / (linear + np.sqrt(linear**2 + 4 * square * constant))


def effective_inertia(screw_inertia: Any, mass: Any, pitch_radius: Any, tan_lead: Any, factor: Any) -> Any:
    """Effective inertia Γ_s = I − ξ_s tan λ m r_m² [kg m²] (eq. 8.2)."""
    return screw_inertia - factor * tan_lead * mass * pitch_radius**2


def effective_damping(
    support_damping: Any, translation_damping: Any, pitch_radius: Any, tan_lead: Any, factor: Any
) -> Any:
    """Effective damping C_s = c − ξ_s r_m² tan λ c_x [N m s/rad] (below eq. 8.13)."""
    return support_damping - factor * tan_lead * translation_damping * pitch_radius**2


def together(*values: Any) -> Any:
    """Return 1 / (1 / a + 1 / b) of two inertias, or one alone; what a drive does not have is None."""
    first, *other = (value for value in values if value is not None)
    return first * other[0] / (first + other[0]) if other else first


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of eqs (8.13)–(8.17) as balls (``flint.arb``: a midpoint and a radius), in SI units.

    ``xi`` ξ_s [1], ``gamma`` Γ_s [kg m²] and ``damping`` C_s [N m s/rad] by the law s = ±1; ``steady_law`` s_0 =
    sgn(R̃ Ω); ``net_force`` R̃ = R − r_m tan λ c_x Ω [N]; ``deflection`` z_0 of the coupling in steady sliding [rad];
    ``q_row``, Q as an affine function of u and w, the constant last. ``float()`` rounds a ball to double.

    >>> found = coefficients(Drive(mass=11))
    >>> f"{float(found.gamma[1]):.6e} kg m²", f"{float(found.xi[1]):.6f}", float(found.net_force), found.steady_law
    ('-2.756781e-07 kg m²', '0.117970', 50.0, 1)
    """

    xi: dict[int, arb]
    gamma: dict[int, arb]
    damping: dict[int, arb]
    steady_law: int
    net_force: arb
    deflection: arb
    q_row: tuple[arb, arb, arb]

    @property
    def paradox(self) -> bool:
        """Whether the drive is in the Painlevé region, Γ₊ ≤ 0 (eq. 8.20)."""
        return sign(self.gamma[1], "mass") <= 0

    def slack(self, law: int) -> arb | int:
        """Return ξ_0 − ξ_s [1], exactly zero for the law of steady sliding."""
        return 0 if law == self.steady_law else self.xi[self.steady_law] - self.xi[law]


def by_law(d: Any, mu: Any) -> tuple[dict[int, Any], dict[int, Any], dict[int, Any]]:
    """Return ξ_s, Γ_s and C_s by the law s, with a friction coefficient."""
    r, tan = d.pitch_radius, d.tan_lead
    xi = {s: friction_factor(mu, tan, s) for s in (1, -1)}
    gamma = {s: effective_inertia(d.screw_inertia, d.mass, r, tan, x) for s, x in xi.items()}
    return xi, gamma, {s: effective_damping(d.support_damping, d.translation_damping, r, tan, xi[s]) for s in xi}


@once
def coefficients(drive: Drive) -> Coefficients:
    """Return the coefficients of eqs (8.13)–(8.17) for a drive, as balls; ``InputError`` for one that is let go."""
    require_direction(drive)
    return coefficients_of(drive.exact())


def coefficients_of(d: Any) -> Coefficients:
    """Return the coefficients from parameters as balls, arrays of doubles or power series."""
    with many_digits():
        r, tan = d.pitch_radius, d.tan_lead
        xi, gamma, damping = by_law(d, d.steady_friction)
        net_force = d.axial_force - r * tan * d.translation_damping * d.input_speed
        law = -1 if sign(net_force * d.input_speed, "axial_force") < 0 else 1
        return Coefficients(
            xi=xi,
            gamma=gamma,
            damping=damping,
            steady_law=law,
            net_force=net_force,
            deflection=-(damping[law] * d.input_speed + r * xi[law] * d.axial_force) / d.coupling_stiffness,
            q_row=(
                r * tan * d.mass * d.coupling_stiffness,
                r * tan * (d.mass * d.support_damping - d.screw_inertia * d.translation_damping),
                gamma[law] * net_force,
            ),
        )


def net_force(p: Mapping[str, Any], t: Any, sense: Any) -> Any:
    """Return R̃ less the friction of the slide, R − r_m tan λ c_x Ω − F_0 sgn Ω [N] (eq. 8.15)."""
    drag = p["pitch_radius"] * t * p["translation_damping"] * p["input_speed"]
    return p["axial_force"] - drag - p.get("slide_friction", 0) * sense


def carried(p: Mapping[str, Any], t: Any, law: Any) -> Any:
    """Return s sgn Ω (R̃ − F_0 sgn Ω) [N], its size under the law that holds; arguments as :func:`net_force`."""
    sense = np.sign(p["input_speed"]) if isinstance(p["input_speed"], np.ndarray) else sign(p["input_speed"])
    return law * sense * net_force(p, t, sense)


def damping_by_slope(
    slope: Any, force: Any, friction_coefficient: Any, pitch_radius: Any, cos_lead: Any, tan_lead: Any, law: Any
) -> Any:
    """Damping S = μ′ |R̃| r_m² / [cos³ λ (1 + s μ tan λ)²] [N m s/rad] of the rigid drive by a ``slope`` μ′ [s/m].

    It is the rate at which the torque of the threads r_m ξ_s R̃ changes with θ′, as dξ_s/dμ = s (1 + tan² λ) / (1 + s μ
    tan λ)², dv/d|θ′| = r_m / cos λ and s = sgn(R̃ Ω); C_s + S is what damps. ``force`` is |R̃| [N].
    """
    return slope * force * pitch_radius**2 / (cos_lead**3 * (1 + law * friction_coefficient * tan_lead) ** 2)


@dataclass(frozen=True)
class LinearParts:
    """What the characteristic polynomial of steady sliding is made of, in any kind of number (SI units).

    It is 1 + t² times the sum of docs/physics.md, g (1/B + 1/Y) − h (1/A + 1/W) + (1 + t²) / E, times all denominators,
    with t = tan λ, g = 1 + s_0 μ t and h = r_m² t (s_0 μ − t) + s_0 r_m t μ_b r_b g. ``along`` are B and Y, ``turning``
    A and W, ``contact`` E or nothing. A body that is carried by another one adds I s² S / (I s² + S) to its polynomial,
    S = c s + k, so that these are pairs, what stands above and below a line.

    Where friction depends on the sliding speed the sum has a term with σ = (1 + t²) r_m² |N_0| μ′ more. As |N_0| is
    |R̃| / (g cos λ), all is then multiplied by g, called ``times``, so that it is a polynomial in every parameter but
    those of the sliding speed; ``sloped`` is g σ, None without such a law.
    """

    t: Any
    g: Any
    h: Any
    along: tuple[Fraction, ...]
    turning: tuple[Fraction, ...]
    contact: Polynomial | None = None
    times: Any = 1
    sloped: Any = None

    @classmethod
    def of(cls, p: Mapping[str, Any], law: int, t: Any) -> Self:
        """Make the parts from the parameters ``p`` of a drive, the law s_0 = ±1 and tan λ."""
        moves = friction.moves(p)
        level, rate = friction.steady(p, t) if moves else (p["friction_coefficient"], None)
        level = law * level
        screw = _turned(p)
        pushed: dict[str, list[Fraction]] = {"contact": [((p["mass"], p["translation_damping"], 0), [1])], "torque": []}
        for part, body in BODIES.items():
            inertia, stiffness, damping = PARTS[part]
            if inertia in p and body.pushed:
                pushed[body.pushed].append(((p[inertia], p[damping], p[stiffness]), [1]))
            elif inertia in p and body.on == "screw":
                screw = _carrying(screw, (p[inertia], 0, 0), (p[damping], p[stiffness]))
        contact = (p["contact_damping"], p["contact_stiffness"]) if "contact_stiffness" in p else None
        factor = p["pitch_radius"] * t * (level - t)
        if "collar_friction" in p:
            factor = factor + law * t * p["collar_friction"] * p.get("collar_radius", 0) * (1 + level * t)
        g, times, sloped = 1 + level * t, 1, None
        if moves:
            secant = p["secant"] if "secant" in p else root(1 + t * t)
            times, sloped = g, p["pitch_radius"] ** 2 * (1 + t * t) * secant * carried(p, t, law) * rate
        along, turning = tuple(pushed["contact"]), (screw, *pushed["torque"])
        return cls(t, g, p["pitch_radius"] * factor, along, turning, contact, times, sloped)

    def level(self) -> Self:
        """Return the same parts without the slope of friction, as if it stayed what it is in steady sliding."""
        return replace(self, times=1, sloped=None)

    def stiff(self) -> Self:
        """Return the same parts with rigid threads."""
        return replace(self, contact=None)

    @property
    def excess(self) -> Any:
        """The positive factor by which the polynomial exceeds det(M s² + C s + K)."""
        return self.times * (self.g if self.contact is None else 1 + self.t**2)

    def polynomial(self) -> Polynomial:
        """Return the characteristic polynomial, times ``times``."""
        along, turning = (
            reduce(multiplied, (above for above, _ in these), [1]) for these in (self.along, self.turning)
        )
        shift, turn = _sum_of_inverses(self.along), _sum_of_inverses(self.turning)
        below = [(self.g, multiplied(shift, turning)), (-self.h, multiplied(turn, along))]
        both = shift
        if self.contact is not None:
            below = [(factor, multiplied(one, self.contact)) for factor, one in below]
            below.append((1 + self.t**2, multiplied(along, turning)))
            both = _total([(1, multiplied(shift, self.contact)), (1, along)])
        if self.sloped is not None:
            below = [(self.times * factor, one) for factor, one in below]
            below.append((self.sloped, [*multiplied(turn, both), 0]))
        return tuple(_total(below))


def _turned(p: Mapping[str, Any]) -> Fraction:
    """Return the polynomial of the screw on its coupling S = d s + k; behind a motor M that is S M / (S + M)."""
    own, spring = (p["screw_inertia"], p["support_damping"], 0), (p.get("coupling_damping", 0), p["coupling_stiffness"])
    if "motor_inertia" not in p:
        return (*own[:2], p["coupling_stiffness"]), [1]
    return _carrying((own, [1]), (p["motor_inertia"], p["speed_gain"], p["integral_gain"]), spring)


def _carrying(carrier: Fraction, moved: Polynomial, spring: Polynomial) -> Fraction:
    """Return the polynomial of a body that carries another one, ``moved``, on a spring, as a fraction."""
    above, below = carrier
    own, carried_along = _total([(1, moved), (1, spring)]), multiplied(moved, spring)
    return _total([(1, multiplied(above, own)), (1, multiplied(below, carried_along))]), multiplied(below, own)


def _sum_of_inverses(fractions: Sequence[Fraction]) -> Sequence[Any]:
    """Return what stands above the line in the sum of the inverses of one or two fractions, over both numerators."""
    if len(fractions) == 1:
        return fractions[0][1]
    (first, below_first), (second, below_second) = fractions
    return _total([(1, multiplied(below_second, first)), (1, multiplied(below_first, second))])


def _total(terms: Sequence[tuple[Any, Sequence[Any]]]) -> list[Any]:
    """Return the sum of polynomials, each times a factor."""
    found: list[Any] = [0] * max(len(one) for _, one in terms)
    for factor, one in terms:
        for k, x in enumerate(one, len(found) - len(one)):
            found[k] = found[k] + factor * x
    return found


def plus(*rows: Row) -> tuple[Any, ...]:
    """Return the sum of rows; terms that cancel leave exactly zero."""
    return tuple(map(added, *rows))


def rate_of(row: Row, field: Sequence[Row]) -> tuple[Any, ...]:
    """Return the rate of an affine function of the state along a field."""
    moving = [scaled(rates, weight) for weight, rates in zip(row[:-1], field, strict=True) if not nothing(weight)]
    return plus(*moving) if len(moving) > 1 else moving[0] if moving else (0,) * len(row)
