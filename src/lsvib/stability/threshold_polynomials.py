r"""Thresholds of steady sliding that are polynomials in every parameter: their equations, and all of their roots.

With t = tan λ the coefficients of :func:`lsvib.stability.spectrum.polynomial` and the net force R̃ are
polynomials in each parameter and in t. So all positive roots in any of them are isolated with certainty, in
rational numbers, and a list of them is complete. The sign of Ω is kept on each side of zero.

    onset               steady sliding gains or loses its asymptotic stability; one of the equations below, or R̃ = 0
    kinematic           det M = 0 under law +: Γ₊ = 0 (8.20), Γ̃₊ = 0 (8.28), Γ̂₊ = 0 (8.33)
    negative_damping    C₊ = 0 (8.19)
    flutter             a pair of eigenvalues on the imaginary axis: Hurwitz determinant of det(M s² + C s + K) = 0
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from lsvib.engine.exact.duals import tangent
from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.mechanics import LinearParts
from lsvib.models.model import find_model
from lsvib.stability.boundaries import interpolated, largest_friction, margins, undamped
from lsvib.stability.solve import Equations
from lsvib.stability.spectrum import DIGITS, SAME, polynomial, positive_roots, rationals, tangents

ParameterValues = Mapping[str, Any]
_DEGREE = 8  # more than that of any equation in any parameter: Hurwitz's is 6 in r_m and in t, since r_m² is in each p
_STEEPEST = Fraction(10) ** 17  # more than tan λ of the largest double below π/2


@dataclass(frozen=True)
class RootCondition:
    """``of(kind, values, tan λ, sgn Ω)`` vanishes at the threshold; ``words`` say the equation."""

    words: str
    of: Callable[[type[Drive], ParameterValues, Any, int], Any]

    def equations(self, kind: type[Drive], sense: int) -> Equations:
        """Return the same equation for numbers with derivatives."""
        return lambda values, inner: [self.of(kind, values, tangent(values["lead_angle"]), sense)]


@dataclass(frozen=True)
class Place:
    """A root of a ``condition``: the unknown (``value``; of λ too) and sgn Ω there."""

    value: float | Fraction
    condition: RootCondition
    sense: int


def _leading(kind: type[Drive], values: ParameterValues, t: Any, sense: int) -> Any:
    model = find_model(kind.model)
    return (model.constrained or model.characteristic)(values, LinearParts.of(values, 1, t))[0]


_DAMPING = "C₊ = c − ξ₊ r_m² tan λ c_x = 0 (eq. 8.19)"
_NET_FORCE = "R̃ = R − r_m tan λ c_x Ω = 0 (eqs 8.15, 8.19)"
_NET_FORCE_OF_SLIDE = "R − r_m tan λ c_x Ω − F_0 sgn Ω = 0 (eq. 8.15)"
_FLUTTER = "Hurwitz determinant (p_3 p_2 − p_4 p_1) p_1 − p_3² p_0 of det(M s² + C s + K) = 0: two eigenvalues ± i ω"
_COUPLING = "p_2² − 4 p_4 p_0 of det(M s² + K) = 0: two frequencies meet (8.29)"


def _damping(kind: type[Drive], values: ParameterValues, t: Any, sense: int) -> Any:
    return polynomial(kind, values, 1, t)[1]


def _net_force(kind: type[Drive], values: ParameterValues, t: Any, sense: int) -> Any:
    drag = values["pitch_radius"] * t * values["translation_damping"] * values["input_speed"]
    slide = values["slide_friction"] * sense if "slide_friction" in values else 0
    return values["axial_force"] - drag - slide


def _margin(law: int, neutral: bool, which: int, words: str) -> RootCondition:
    return RootCondition(
        words, lambda kind, values, t, sense: margins(polynomial(kind, values, law, t), neutral)[which]
    )


def conditions(drive: Drive, name: str, unknown: str) -> list[RootCondition]:
    """Return the conditions one of which holds at a threshold, by its name."""
    model, neutral = find_model(drive.model), undamped(drive, unknown)
    kinematic = RootCondition(model.constraint, _leading)
    if name == "kinematic_constraint":
        return [kinematic]
    if name == "negative_damping":
        return [RootCondition(_DAMPING, _damping)]
    last = 2 if neutral else 4
    flutter = {law: _margin(law, neutral, last, _COUPLING if neutral else _FLUTTER) for law in (1, -1)}
    if name == "flutter":
        return list(flutter.values())
    slide = getattr(drive, "slide_friction", 0.0) or unknown == "slide_friction"
    force = RootCondition(_NET_FORCE_OF_SLIDE if slide else _NET_FORCE, _net_force)
    if len(model.states) == 2:
        return [force, kinematic, *([] if neutral else [RootCondition(_DAMPING, _damping)])]
    rest = [_margin(law, neutral, k, f"p_{4 - (2 if neutral else 1) * k} of det(M s² + C s + K) = 0")
            for law in (1, -1) for k in range(last)]  # fmt: skip
    return [force, kinematic, *flutter.values(), *rest]


class Line:
    """The values that one parameter of a drive may take, on one side of zero, all others held."""

    def __init__(self, drive: Drive, unknown: str, side: int) -> None:
        self.drive, self.unknown, self.side = drive, unknown, side
        self.drive_class = type(drive)
        self.fixed = rationals(drive)
        self.tangent = tangents(drive, DIGITS)[0]
        self.neutral = undamped(drive, unknown)
        friction = self.fixed["friction_coefficient"]
        if unknown == "friction_coefficient":
            self.limit = largest_friction(self.tangent)
        elif unknown == "lead_angle":
            self.limit = min(1 / friction, _STEEPEST) if friction else _STEEPEST
        else:
            self.limit = Fraction(self.drive_class.model_json_schema()["properties"][unknown]["maximum"])

    def at(self, x: Fraction) -> tuple[dict[str, Fraction], Fraction, int]:
        """Return the parameters, tan λ and sgn Ω at a distance x ≥ 0 from zero; of λ it is tan λ."""
        x = self.side * x
        values = self.fixed if self.unknown == "lead_angle" else {**self.fixed, self.unknown: x}
        t = x if self.unknown == "lead_angle" else self.tangent
        return values, t, self.sense

    @property
    def sense(self) -> int:
        """Return sgn Ω."""
        return self.side if self.unknown == "input_speed" else 1 if self.drive.input_speed > 0 else -1

    def roots(self, condition: RootCondition) -> list[Fraction] | None:
        """Return the distances x ≥ 0 from zero at which a condition vanishes; None if it does not depend on x."""
        p = interpolated([condition.of(self.drive_class, *self.at(Fraction(x))) for x in range(_DEGREE + 1)])
        if len(p) < 2:
            return None
        return ([Fraction(0)] if p[-1] == 0 else []) + positive_roots(p, self.limit)

    def law(self, x: Fraction) -> int:
        """Return the law s_0 of steady sliding, 0 where the contact carries no force."""
        values, t, sense = self.at(x)
        force = _net_force(self.drive_class, values, t, sense) * sense
        return int(force > 0) - int(force < 0)

    def margins(self, x: Fraction, law: int) -> tuple[Fraction, ...]:
        """Return the numbers of :func:`margins` under a law."""
        values, t, _ = self.at(x)
        return margins(polynomial(self.drive_class, values, law, t), self.neutral)

    def stable(self, x: Fraction) -> bool:
        """Whether steady sliding is stable (asymptotically; neutrally where nothing damps)."""
        law = self.law(x)
        return bool(law and min(self.margins(x, law)) > 0)

    def value(self, x: Fraction) -> float | Fraction:
        """Return the value of the unknown at a distance from zero."""
        return math.atan(x) if self.unknown == "lead_angle" else self.side * x


def places(drive: Drive, name: str, unknown: str) -> list[Place] | None:
    """Return all places, in ascending order, at which a threshold lies; None if the unknown is in no equation."""
    wanted = conditions(drive, name, unknown)
    lowest = drive.model_json_schema()["properties"][unknown]
    lines = [Line(drive, unknown, side) for side in ((-1, 1) if lowest.get("minimum", 0) < 0 else (1,))]
    roots = [(line, [(condition, line.roots(condition)) for condition in wanted]) for line in lines]
    if all(found is None for _, of_line in roots for _, found in of_line):
        return None
    if name == "onset":
        found = _changes(unknown, roots)
    else:
        found = [
            Place(line.value(x), condition, line.sense)
            for line, of_line in roots
            for condition, distances in of_line
            for x in distances or []
            if (x or line is lines[0]) and (name != "flutter" or _flutters(line, condition, wanted, x))
        ]
    return sorted((place for place in found if allowed(drive, unknown, place.value)), key=lambda place: place.value)


def _flutters(line: Line, condition: RootCondition, wanted: list[RootCondition], x: Fraction) -> bool:
    """Whether the condition is that of the law of steady sliding, and all other eigenvalues decay."""
    law = line.law(x)
    return bool(law) and condition is wanted[0 if law > 0 else 1] and min(line.margins(x, law)[:-1]) > 0


def _changes(unknown: str, roots: list[tuple[Line, Any]]) -> list[Place]:
    """The places at which steady sliding gains or loses its stability."""
    found = []
    for line, of_line in roots:
        candidates = sorted((x, k) for k, (_, ds) in enumerate(of_line) for x in ds or [] if 0 < x < line.limit)
        cuts: list[Fraction] = []
        for x, _ in candidates:
            if not cuts or x - cuts[-1] > SAME * x:
                cuts.append(x)
        ends = [Fraction(0), *cuts, line.limit]
        verdicts = [line.stable((a + b) / 2) for a, b in pairwise(ends)]
        for x, before, after in zip(cuts, verdicts, verdicts[1:], strict=False):
            if before != after:
                which = next(k for y, k in candidates if abs(y - x) <= SAME * x)
                found.append(Place(line.value(x), of_line[which][0], line.sense))
        if line.side < 0 and unknown != "input_speed":  # zero lies between both sides
            other, of_other = roots[1]
            first = min((x for _, ds in of_other for x in ds or [] if x), default=other.limit)
            at_zero = [condition for condition, ds in of_line if ds and ds[0] == 0]
            if at_zero and line.stable(min([*cuts, line.limit]) / 2) != other.stable(min(first, other.limit) / 2):
                found.append(Place(0.0, at_zero[0], line.sense))
    return found


def allowed(drive: Drive, unknown: str, value: float | Fraction) -> bool:
    """Whether the drive may have this value of a parameter."""
    try:
        drive.replace(**{unknown: float(value)})
    except InputError:
        return False
    return True
