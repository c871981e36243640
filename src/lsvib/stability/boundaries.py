r"""Places at which steady sliding changes, as all roots of equations in one parameter of a drive.

Steady sliding changes its stability only at roots of R̃ and of the numbers whose signs decide
(:func:`lsvib.stability.spectrum.margins`); exact signs between them say where it is stable. The sign of Ω is kept on
each side of zero. The equations are polynomials in the parameter, but where it changes the sliding speed on which
friction depends. They, and why a list of their roots is complete, stand in docs/thresholds.md.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from itertools import islice, pairwise
from typing import Any

from flint import arb, fmpq, fmpq_poly

from lsvib.drives import friction
from lsvib.drives.complaints import bounds_of
from lsvib.drives.drive import Drive, may_vanish
from lsvib.drives.mechanics import LinearParts, net_force
from lsvib.drives.model import model_of
from lsvib.stability import spectrum
from lsvib.stability.solve import allowed, isolated_roots
from lsvib.stability.spectrum import SAME, margins
from lsvib.systems.exact.arithmetic import many_digits

_OF_SPEED = ("pitch_radius", "lead_angle", "input_speed", *friction.FADING.values())
"""Parameters of the exponential of the friction law."""

ParameterValues = Mapping[str, Any]
_DAMPING = "C₊ = c − ξ₊ r_m² tan λ c_x = 0 (eq. 8.19)"
_SLOPED = "C_0 + r_m² |R̃| μ′ / [cos³ λ (1 + s_0 μ tan λ)²] = 0 with μ and μ′ at the speed of steady sliding (eq. 8.19)"
_NET_FORCE = "R̃ = R − r_m tan λ c_x Ω = 0 (eqs 8.15, 8.19)"
_NET_FORCE_OF_SLIDE = "R − r_m tan λ c_x Ω − F_0 sgn Ω = 0 (eq. 8.15)"
_FLUTTER = "Hurwitz determinant {} of det(M s² + C s + K) = 0: two eigenvalues ± i ω"
FRICTIONLESS = "μ = 0 at the speed of steady sliding, beyond which friction is cut off"
_COUPLING = "p_2² − 4 p_4 p_0 of det(M s² + K) = 0: two frequencies meet (8.29)"


@dataclass(frozen=True)
class RootCondition:
    """``of(values, tan λ, sgn Ω)`` vanishes at the threshold; ``words`` say the equation."""

    words: str
    of: Callable[[ParameterValues, Any, int], Any]


@dataclass(frozen=True)
class Place:
    """A root of a ``condition``: the unknown as a ball (``value``) and sgn Ω there."""

    value: arb
    condition: RootCondition
    sense: int


@dataclass(frozen=True)
class StableSet:
    """Values of one parameter at which steady sliding is stable, all others held at those of the drive.

    ``intervals`` are open intervals (low, high) [unit of the parameter; of the lead angle its tangent] in ascending
    order, within the ``limits`` on both sides of zero, the ends of the range of the parameter; a single value without
    contact force, or on a boundary that is touched, divides none. With ``neutral`` the drive has no damping, and they
    are the values at which no motion grows; else those at which steady sliding is asymptotically stable. ``from_zero``
    says that zero is one of the values; ``changes`` are the places where stability changes.
    """

    key: str
    intervals: tuple[tuple[fmpq, fmpq], ...]
    neutral: bool
    from_zero: bool
    changes: tuple[Place, ...]
    drive: Drive
    limits: tuple[fmpq, ...]

    def places(self) -> list[Place]:
        """Return the changes that the drive can have, in ascending order."""
        return _in_order(self.drive, self.key, self.changes)

    def in_doubles(self) -> tuple[tuple[float | None, float | None], ...]:
        """Return the intervals in the unit of the parameter, None at the end of its range."""

        def end(x: fmpq) -> float | None:
            if abs(x) in self.limits:
                return None
            return math.atan(float(x)) if self.key == "lead_angle" else float(x)

        return tuple((end(low), end(high)) for low, high in self.intervals)

    def why_no_change(self) -> str:
        """Say in a sentence that stability never changes, as where it has no change within the range."""
        adverb, name = "neutrally" if self.neutral else "asymptotically", self.key.replace("_", " ")
        if not self.intervals:
            return f"steady sliding is not {adverb} stable for any {name}, with all other parameters fixed."
        if self.key == "input_speed" and len(self.intervals) == 1:  # zero itself is no steady sliding
            way = "below" if self.intervals[0][0] < 0 else "above"
            return f"steady sliding is {adverb} stable for all input speeds {way} zero and for none on the other side."
        if self.from_zero or self.intervals[0][0] < 0 or not may_vanish(self.key):
            return f"steady sliding is {adverb} stable for every {name} in its range, with all other parameters fixed."
        return f"steady sliding is {adverb} stable for every {name} above zero, but not at zero."


def _damping(values: ParameterValues, t: Any, sense: int) -> Any:
    return LinearParts.of(values, 1, t).level().polynomial()[1]


def _inertia(values: ParameterValues, t: Any, sense: int) -> Any:
    return LinearParts.of(values, 1, t).level().stiff().polynomial()[0]


CONDITIONS: dict[str, Callable[[Drive], RootCondition]] = {
    "kinematic_constraint": lambda drive: RootCondition(model_of(drive).constraint, _inertia),
    "negative_damping": lambda _: RootCondition(_DAMPING, _damping),
}
"""Thresholds that are roots of one equation of a drive."""
NAMES = ("onset", "flutter", *CONDITIONS)
"""Thresholds that are roots: also of whichever number decides on stability, or on flutter."""


def _friction(values: ParameterValues, t: Any, sense: int) -> Any:
    return friction.steady_sum(values, t)[0]


def _margins(drive: Drive, law: int, neutral: bool, sloped: bool) -> list[RootCondition]:
    """The numbers whose signs decide on stability under a law, each as a condition; ``sloped``: with a slope of μ."""
    model = model_of(drive)
    if len(model.states) == 2:
        words = [model.constraint, _SLOPED if sloped else _DAMPING][: 1 if neutral else 2]
    else:
        order = len(model.states)
        powers = (4, 2) if neutral and order == 4 else range(order, 0, -1)
        words = [f"p_{n} of det(M s² + C s + K) = 0" for n in powers]
        words += [f"Hurwitz determinant of order {k} of det(M s² + C s + K) = 0" for k in range(3, order - 1, 2)]
        last = "(p_3 p_2 − p_4 p_1) p_1 − p_3² p_0" if order == 4 else f"of order {order - 1}"
        words.append(_COUPLING if neutral and order == 4 else _FLUTTER.format(last))
        if not model.compliant:
            words[0] = model.constraint

    def condition(which: int, text: str) -> RootCondition:
        def number(values: ParameterValues, t: Any, sense: int) -> Any:
            return next(islice(margins(LinearParts.of(values, law, t).polynomial(), neutral), which, None))

        return RootCondition(text, number)

    return [condition(k, text) for k, text in enumerate(words)]


def searched(drive: Drive, unknown: str) -> bool:
    """Whether the equations are no polynomials, as the unknown changes the sliding speed on which friction depends."""
    return friction.depends_on_speed(drive) and unknown in _OF_SPEED


class Line:
    """The values that one parameter of a drive may take, on one side of zero, all others held."""

    def __init__(self, drive: Drive, unknown: str, side: int) -> None:
        self.drive, self.unknown, self.side = drive, unknown, side
        self.searched = searched(drive, unknown)
        self.fixed: dict[str, Any] = {key: arb(value) for key, value in drive}
        self.tangent: Any = self.fixed["lead_angle"].tan()
        if not self.searched:
            self.fixed, self.tangent = spectrum.enclosed(drive)[0]
            little = [name for name, x in self.fixed.items() if name.startswith("decay") and x < spectrum.LEAST]
            self.fixed |= dict.fromkeys(little, fmpq(0))  # which would only part double roots by as little
        self.neutral = spectrum.undamped(drive, unknown)
        self.sense = side if unknown == "input_speed" else 1 if drive.input_speed > 0 else -1
        self.sloped = friction.depends_on_speed(drive) or unknown in friction.OF_SPEED
        slide = getattr(drive, "slide_friction", 0.0) or unknown == "slide_friction"
        self.force = RootCondition(_NET_FORCE_OF_SLIDE if slide else _NET_FORCE, net_force)
        self.lowest, self.limit = fmpq(0), self._limit()
        if self.searched:  # up to where μ tan λ < 1 in steady sliding
            bounds = bounds_of(Drive, unknown)
            self.lowest = fmpq(*float(bounds.get("least", bounds["ge"])).as_integer_ratio())
            locked = RootCondition("", lambda values, t, sense: 1 - t * _friction(values, t, sense))
            self.limit = min([*(self.roots_of(locked) or []), self.limit])

    def _limit(self) -> Any:
        """The largest distance from zero, as far as it is no matter of the sliding speed in the law of friction."""
        drive, cot, one = self.drive, 1 / self.tangent, fmpq_poly([1])
        static = fmpq(*drive.static_friction_coefficient.as_integer_ratio())
        if self.unknown == "lead_angle":
            steepest = fmpq(10**17)  # more than tan λ of the largest double below π/2
            slowest = friction.slowest({key: fmpq(*value.as_integer_ratio()) for key, value in drive})
            most = max(slowest, static)
            return min(1 / most, steepest) if most else steepest
        at_rest = {"slide_friction": drive.slide_static_friction, "bearing_friction": drive.bearing_static_friction}
        if at_rest.get(self.unknown):  # which friction in motion is not above
            return fmpq(*at_rest[self.unknown].as_integer_ratio())
        if self.unknown not in ("friction_coefficient", "static_friction_coefficient", *friction.OF_SPEED):
            return fmpq(*float(bounds_of(Drive, self.unknown)["le"]).as_integer_ratio())
        place = self.at(fmpq_poly([0, 1]))
        limits = [fmpq(10**6)]  # of the slope; more than cot λ of the least lead angle
        for level, bound in ((one * friction.slowest(place[0]), static or cot), (one * _friction(*place), cot)):
            limits += [(bound - level[0]) / level[1]] if level[1] > 0 else []
        return min(limits)

    def at(self, x: Any) -> tuple[ParameterValues, Any, int]:
        """Return the arguments of a condition at a distance x ≥ 0 from zero, a number or the unknown of a polynomial.

        Of λ it is tan λ.
        """
        if self.searched and isinstance(x, fmpq):
            x = arb(x)
        if self.unknown == "lead_angle":
            return self.fixed, x, self.sense
        return {**self.fixed, self.unknown: self.side * x}, self.tangent, self.sense

    def roots(self, values: Any) -> list[fmpq] | None:
        """Return the x ≥ 0 at which a polynomial in x vanishes; None if it does not depend on x."""
        p = fmpq_poly([0]) + values
        if p.degree() < 1:
            return None
        # At the end of its range, as at μ = cot λ under law −, coefficients may vanish; nothing changes there.
        return ([fmpq(0)] if p[0] == 0 else []) + spectrum.positive_roots(p, self.limit * (1 - SAME))

    def roots_of(self, condition: RootCondition, *within: fmpq) -> list[fmpq] | None:
        """Return the distances x ≥ 0 from zero at which a condition vanishes; None if it does not depend on x.

        A search is ``within`` two of them, or as far as it may go.
        """
        if self.searched:
            return isolated_roots(lambda x: condition.of(*self.at(x)), *(within or (self.lowest, self.limit)))
        return self.roots(condition.of(*self.at(fmpq_poly([0, 1]))))

    def roots_with_friction(self, condition: RootCondition) -> list[fmpq] | None:
        """As :meth:`roots_of`, but only where friction is not cut off; beyond, a condition may vanish throughout."""
        if not self.searched:
            roots = self.roots_of(condition)
            return None if roots is None else [x for x in roots if self.rubs(x)]
        ends, off = [self.lowest, *self.cuts(), self.limit], 2 * SAME  # at a cut itself the law may count as cut off
        pairs = [(a, b) for a, b in pairwise(ends) if self.rubs(self.between(a, b))]
        found = [self.roots_of(condition, a * (1 + off), b * (1 - off)) for a, b in pairs]
        return None if None in found else [x for roots in found for x in roots or []]

    def cuts(self) -> list[fmpq]:
        """Return where friction begins to be cut off, or ends to be."""
        if self.unknown != "friction_slope" and self.drive.friction_slope >= 0:
            return []  # however little is left of a rise, it is above zero
        return self.roots_of(RootCondition(FRICTIONLESS, _friction)) or [] if self.sloped else []

    def between(self, a: fmpq, b: fmpq) -> fmpq:
        """Return a place between two ends, within the range that is searched."""
        return (max(a, self.lowest) + b) / 2

    def crosses(self, x: fmpq, condition: RootCondition) -> bool:
        """Whether a condition has different signs right below and above its root x > 0."""
        below, above = (condition.of(*self.at(x * (1 + side * 2 * SAME))) > 0 for side in (-1, 1))
        return bool(below != above)

    def law(self, x: fmpq) -> int:
        """Return the law s_0 of steady sliding, 0 where the contact carries no force."""
        force = net_force(*self.at(x)) * self.sense
        return int(force > 0) - int(force < 0)

    def rubs(self, x: fmpq) -> bool:
        """Whether friction is not cut off, so that what holds of the sum of its law holds of it."""
        return not self.sloped or bool(_friction(*self.at(x)) > 0)

    def margins(self, x: Any, law: int) -> tuple[Any, ...]:
        """Return the numbers that are all positive where steady sliding is stable under a law."""
        values, t, _ = self.at(x)
        return tuple(margins(LinearParts.of(values, law, t).polynomial(), self.neutral))

    def stable(self, x: fmpq) -> bool:
        """Whether steady sliding is stable (asymptotically; neutrally where nothing damps)."""
        law = self.law(x)
        return bool(law) and all(margin > 0 for margin in self.margins(x, law))

    def place(self, x: fmpq, condition: RootCondition) -> Place:
        """Return the place at a distance from zero."""
        with many_digits():
            value = arb(x).atan() if self.unknown == "lead_angle" else arb(self.side * x)
        return Place(value, condition, self.sense)

    def stability(self) -> tuple[list[tuple[fmpq, fmpq, bool]], list[Place], bool]:
        """Return intervals (distances from zero, whether stable), places of a change, whether anything depends on x."""
        found = self.roots_of(self.force)
        ends = [fmpq(0), *(x for x in found or [] if x), self.limit]
        laws = {self.law(self.between(a, b)) for a, b in pairwise(ends)} - {0}
        candidates = [(x, self.force) for x in found or []]
        depends = found is not None
        candidates += [(x, RootCondition(FRICTIONLESS, _friction)) for x in self.cuts()]
        for law in sorted(laws, reverse=True):
            conditions = _margins(self.drive, law, self.neutral, self.sloped)
            if self.searched:
                found_by = [self.roots_with_friction(condition) for condition in conditions]
            else:
                found_by = [self.roots(x) for x in self.margins(fmpq_poly([0, 1]), law)]
            for condition, roots in zip(conditions, found_by, strict=True):
                depends |= roots is not None
                candidates += [(x, condition) for x in roots or [] if self.law(x) == law and self.rubs(x)]
        cuts: list[tuple[fmpq, RootCondition]] = []
        for x, condition in candidates:  # the first of those that vanish together: determinants then have double roots
            if x and all(abs(x - other) > SAME * x for other, _ in cuts):
                cuts.append((x, condition))
        cuts.sort(key=lambda cut: cut[0])
        edges = [fmpq(0), *(x for x, _ in cuts), self.limit]
        parts = [(a, b, self.stable(self.between(a, b))) for a, b in pairwise(edges)]
        changed = [cut for cut, before, after in zip(cuts, parts, parts[1:], strict=False) if before[2] != after[2]]
        return parts, [self.place(*cut) for cut in changed], depends

    @classmethod
    def all_of(cls, drive: Drive, unknown: str) -> "list[Line]":
        """Return both sides of zero where the parameter may be negative, else the positive one."""
        lowest = bounds_of(Drive, unknown).get("ge", 0)
        return [cls(drive, unknown, side) for side in ((-1, 1) if lowest < 0 else (1,))]


@many_digits()
def stable_set(drive: Drive, key: str) -> StableSet | None:
    """Compute the values of the parameter ``key`` at which the steady sliding of a drive is stable.

    None if stability does not depend on it.
    """
    lines = Line.all_of(drive, key)
    found = [line.stability() for line in lines]
    turns = key == "input_speed" and len({stable for parts, *_ in found for *_, stable in parts}) > 1
    if not turns and not any(depends for *_, depends in found):
        return None
    parts, changes = [], []
    for line, (of_line, places, _) in zip(lines, found, strict=True):
        parts += [sorted((line.side * a, line.side * b)) for a, b, stable in of_line if stable]
        changes += places
    line = lines[-1]
    intervals: list[tuple[fmpq, fmpq]] = []
    for low, high in sorted(parts):
        touches = intervals and intervals[-1][1] == low and (low != 0 or key != "input_speed")
        intervals.append((intervals.pop()[0] if touches else low, high))
    if len(lines) == 2 and key != "input_speed":  # zero lies between both sides
        (before, *_), (after, *_) = found[0][0], found[1][0]
        vanishes = line.roots_of(line.force)
        if before[2] != after[2] and vanishes and vanishes[0] == 0:
            changes.append(line.place(fmpq(0), line.force))
    from_zero, limits = line.stable(line.lowest), tuple(line.limit for line in lines)
    return StableSet(key, tuple(intervals), line.neutral, from_zero, tuple(changes), drive, limits)


@many_digits()
def places(drive: Drive, name: str, unknown: str) -> list[Place] | None:
    """Return all places at which the one condition of a threshold vanishes, in ascending order.

    It changes sign there: where it only touches zero nothing begins. Of flutter it is that of the law that holds there.
    None if the unknown is not in the condition.
    """
    lines, neutral = Line.all_of(drive, unknown), spectrum.undamped(drive, unknown)
    if name == "flutter":
        wanted = {law: _margins(drive, law, neutral, False)[-1] for law in (1, -1)}
    else:
        wanted = {0: CONDITIONS[name](drive)}
    roots = [(line, law, c, line.roots_with_friction(c)) for line in lines for law, c in wanted.items()]
    if all(found is None for *_, found in roots):
        return None
    found = [
        line.place(x, condition)
        for line, law, condition, found in roots
        for x in found or []
        if x or line is lines[0]
        if not law or (line.law(x) == law and all(margin > 0 for margin in line.margins(x, law)[:-1]))
        if not x or line.crosses(x, condition)
    ]
    return _in_order(drive, unknown, found)


def place_values(drive: Drive, name: str, unknown: str) -> list[float]:
    """Return the values [SI unit] of a parameter at the :func:`places` of a threshold, none if it is not in it.

    >>> place_values(Drive(), "kinematic_constraint", "mass")
    [10.106965213139869]
    """
    return [float(place.value) for place in places(drive, name, unknown) or []]


def _in_order(drive: Drive, unknown: str, found: Iterable[Place]) -> list[Place]:
    return sorted((p for p in found if allowed(drive, unknown, float(p.value))), key=lambda p: float(p.value))
