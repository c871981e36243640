"""Coefficients of the equations of motion (8.13)–(8.17), and what the characteristic polynomials of all models share.

The formulas are plain arithmetic, and decide by the sign of a number alone. So the same lines serve the balls of one
drive (``Drive.exact()``), arrays of doubles, which are many drives, and power series, which carry derivatives
(:mod:`lsvib.engine.exact.arithmetic`). Symbols are those of the chapter: ``law`` is s = sgn(θ̇)·sgn(N) = ±1,
``tan_lead`` is tan λ, ``factor`` is ξ_s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from flint import arb

from lsvib.engine.exact.arithmetic import added, ball, many_digits, multiplied, root, sign
from lsvib.models import friction
from lsvib.models.drive import Drive, once

if TYPE_CHECKING:
    from lsvib.engine.automaton import Row

Polynomial = tuple[Any, ...]  # highest power first


def friction_factor(friction_coefficient: Any, tan_lead: Any, law: Any) -> Any:
    """Friction factor of the threads, ξ_s = (s μ − tan λ) / (1 + s μ tan λ) [1] (eqs 5.11, 8.4).

    >>> round(friction_factor(0.218, 0.0975, 1), 4)
    0.118
    """
    return (law * friction_coefficient - tan_lead) / (1 + law * friction_coefficient * tan_lead)


def effective_inertia(screw_inertia: Any, mass: Any, pitch_radius: Any, tan_lead: Any, factor: Any) -> Any:
    """Effective inertia Γ_s = I − ξ_s tan λ m r_m² [kg m²] (eq. 8.2)."""
    return screw_inertia - factor * tan_lead * mass * pitch_radius**2


def effective_damping(
    support_damping: Any, translation_damping: Any, pitch_radius: Any, tan_lead: Any, factor: Any
) -> Any:
    """Effective damping C_s = c − ξ_s r_m² tan λ c_x [N m s/rad] (below eq. 8.13)."""
    return support_damping - factor * tan_lead * translation_damping * pitch_radius**2


@dataclass(frozen=True)
class Coefficients:
    """Coefficients of eqs (8.13)–(8.17) as balls (``flint.arb``: a midpoint and a radius), in SI units.

    ``xi`` ξ_s [1], ``gamma`` Γ_s [kg m²] and ``damping`` C_s [N m s/rad] by the law s = ±1; ``steady_law`` s_0 =
    sgn(R̃ Ω); ``net_force`` R̃ = R − r_m tan λ c_x Ω [N]; ``deflection`` z_0 of the coupling in steady sliding [rad];
    ``q_row``, Q as an affine function of u and w, the constant last. ``float()`` rounds a ball to double.
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
        """True in the Painlevé region, Γ₊ ≤ 0."""
        return sign(self.gamma[1], "mass") <= 0

    def slack(self, law: int) -> arb | int:
        """Return ξ_0 − ξ_s [1], exactly zero for the law of steady sliding."""
        return 0 if law == self.steady_law else self.xi[self.steady_law] - self.xi[law]


@once
def coefficients(drive: Drive) -> Coefficients:
    """Return the coefficients of eqs (8.13)–(8.17) for a drive, as balls."""
    return coefficients_of(drive.exact())


def coefficients_of(d: Any) -> Coefficients:
    """Return the coefficients from parameters as balls, arrays of doubles or power series."""
    with many_digits():
        r, tan = d.pitch_radius, d.tan_lead
        xi = {s: friction_factor(d.steady_friction, tan, s) for s in (1, -1)}
        gamma = {s: effective_inertia(d.screw_inertia, d.mass, r, tan, xi[s]) for s in xi}
        damping = {s: effective_damping(d.support_damping, d.translation_damping, r, tan, xi[s]) for s in xi}
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


def steady_force(c: Coefficients, d: Any) -> Any:
    """Return |N_0| of steady sliding [N] (eq. 8.15): N_0 (cos λ + s_0 μ sin λ) = R̃."""
    return abs(c.net_force / (d.cos_lead + c.steady_law * d.steady_friction * d.sin_lead))


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
    """The parts of the characteristic polynomials of all models, in any kind of number (SI units).

    With t = tan λ, g = 1 + s_0 μ t, h = r_m² t (s_0 μ − t), the ``screw`` A = I s² + c s + k and the translating mass,
    ``slide``, B = m s² + c_x s, the polynomial of the rigid drive (8.13) is D = g A − h B = g (Γ_0 s² + C_0 s + k). A
    model with a second coordinate has factor · A B + own · D; its file states factor and ``own``.

    Where friction depends on the sliding speed, μ is that of steady sliding, and its change with the speed damps (see
    docs/physics.md): D has the term σ s more, with σ = (1 + t²) r_m² |N_0| μ′, and the other models σ s (B + own) or
    σ s (A + own). As |N_0| is |R̃| / (g cos λ), all is then multiplied by g, called ``times``, so that it is a
    polynomial in every parameter but those of the sliding speed; ``sloped`` is g σ, None without such a law.
    """

    t: Any
    g: Any
    h: Any
    screw: Polynomial
    slide: Polynomial
    times: Any = 1
    sloped: Any = None

    @classmethod
    def of(cls, p: Mapping[str, Any], law: int, t: Any) -> Self:
        """Make the parts from the parameters ``p`` of a drive, the law s_0 = ±1 and tan λ."""
        moves = friction.moves(p)
        level, rate = friction.steady(p, t) if moves else (p["friction_coefficient"], None)
        level = law * level
        level_only = cls(
            t=t,
            g=1 + level * t,
            h=p["pitch_radius"] ** 2 * t * (level - t),
            screw=(p["screw_inertia"], p["support_damping"], p["coupling_stiffness"]),
            slide=(p["mass"], p["translation_damping"], 0),
        )
        if not moves:
            return level_only
        secant = p["secant"] if "secant" in p else root(1 + t * t)
        sloped = p["pitch_radius"] ** 2 * (1 + t * t) * secant * carried(p, t, law) * rate
        return replace(level_only, times=level_only.g, sloped=sloped)

    def level(self) -> Self:
        """Return the same parts without the slope of friction, as if it stayed what it is in steady sliding."""
        return replace(self, times=1, sloped=None)

    def rigid(self) -> Polynomial:
        """Return D, the polynomial of the rigid drive, times ``times``."""
        tied = tuple(self.g * a - self.h * b for a, b in zip(self.screw, self.slide, strict=True))
        return tied if self.sloped is None else self._sloped(tied, (1,))

    def coupled(self, factor: Any, own: Polynomial, slips: Polynomial | None = None) -> Polynomial:
        """Return factor · A B + own · D, the polynomial of a model with a second coordinate, times ``times``.

        ``slips`` + ``own`` is what the slope of friction is multiplied by, with B for ``slips`` if it is not given.
        """
        free, tied = multiplied(self.screw, self.slide), multiplied(own, self.level().rigid())
        whole = tuple(factor * a + b for a, b in zip(free, tied, strict=True))
        if self.sloped is None:
            return whole
        return self._sloped(whole, [a + b for a, b in zip(slips or self.slide, own, strict=True)])

    def _sloped(self, level: Polynomial, by: Sequence[Any]) -> Polynomial:
        """A polynomial times ``times`` and, with the slope of friction, σ s times another one."""
        more = [0] * (len(level) - 1 - len(by)) + [self.sloped * x for x in by] + [0]
        return tuple(self.times * a + b for a, b in zip(level, more, strict=True))


def plus(*rows: "Row") -> tuple[Any, ...]:
    """Return the sum of rows; terms that cancel leave exactly zero."""
    return tuple(added(*column) for column in zip(*rows, strict=True))


def rate_of(row: "Row", field: Sequence["Row"]) -> tuple[Any, ...]:
    """Return the rate of an affine function of the state along a field."""
    return plus(*(tuple(weight * x for x in rates) for weight, rates in zip(row[:-1], field, strict=True)))


def constant(value: Any) -> tuple[Any, ...]:
    """Return the row of a constant."""
    return (0, 0, 0, 0, value)


def solved(matrix: Sequence[Sequence[Any]], sides: Sequence["Row"]) -> list[tuple[Any, ...]]:
    """Solve linear equations whose right-hand sides are rows, by elimination.

    What cancels is exactly zero, so that steady sliding is an equilibrium to the last bit.
    """
    n = len(matrix)
    table = [[ball(x) for x in (*left, *right)] for left, right in zip(matrix, sides, strict=True)]
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(table[i][k]).mid())
        table[k], table[pivot] = table[pivot], table[k]
        first = table[k][k]
        table[k] = [x / first for x in table[k]]
        for i in range(n):
            if i != k:
                factor = table[i][k]
                pairs = [(x, -factor * y) for x, y in zip(table[i], table[k], strict=True)]
                table[i] = [added(x, y) for x, y in pairs]
    return [tuple(row[n:]) for row in table]
