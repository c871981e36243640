"""The parts that the characteristic polynomials of all models are made of, in the arithmetic of the parameters.

With t = tan λ, g = 1 + s_0 μ t, h = r_m² t (s_0 μ − t), the screw A = I s² + c s + k and the translating mass
B = m s² + c_x s, the polynomial of the rigid drive (8.13) is D = g A − h B = g (Γ_0 s² + C_0 s + k). A model with a
second coordinate has factor · A B + own · D, with a factor and a polynomial ``own`` that its file states.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self

from lsvib.engine.exact.arithmetic import multiplied

Polynomial = tuple[Any, ...]  # highest power first


@dataclass(frozen=True)
class LinearParts:
    """t, g, h, A and B of the module text, for one law and one value of tan λ (SI units)."""

    t: Any
    g: Any
    h: Any
    screw: Polynomial
    slide: Polynomial

    @classmethod
    def of(cls, p: Mapping[str, Any], law: int, t: Any) -> Self:
        """Make the parts from the parameters ``p`` of a drive, the law s_0 = ±1 and tan λ."""
        friction = law * p["friction_coefficient"]
        return cls(
            t=t,
            g=1 + friction * t,
            h=p["pitch_radius"] ** 2 * t * (friction - t),
            screw=(p["screw_inertia"], p["support_damping"], p["coupling_stiffness"]),
            slide=(p["mass"], p["translation_damping"], 0),
        )

    def rigid(self) -> Polynomial:
        """Return D, the polynomial of the rigid drive."""
        return tuple(self.g * a - self.h * b for a, b in zip(self.screw, self.slide, strict=True))

    def coupled(self, factor: Any, own: Polynomial) -> Polynomial:
        """Return factor · A B + own · D, the polynomial of a model with a second coordinate."""
        free, tied = multiplied(self.screw, self.slide), multiplied(own, self.rigid())
        return tuple(factor * a + b for a, b in zip(free, tied, strict=True))
