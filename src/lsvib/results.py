"""Answers of a drive in numbers: small immutable values. Other answers are datasets."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from lsvib import words


@dataclass(frozen=True)
class Quantity:
    """A ``value``, None if it does not exist, and its ``unit`` as UDUNITS spells it, "1" if it has no dimension.

    >>> lsvib.Drive(mass=11).stability().quantities["effective_inertia_plus"]  # Γ₊, eq. 8.2
    Quantity(value=-2.756780572848153e-07, unit='kg m2')
    """

    value: float | None
    unit: str


@dataclass(frozen=True)
class Condition:
    """A condition of instability (eq. 8.19 or 8.21); ``hold`` is true exactly if all its ``margins`` are positive.

    ``margins``: those of its inequalities, by name, in SI units. Margins that do not exist are omitted; a condition
    without margins does not hold.

    >>> lsvib.Drive(mass=11).stability().conditions["kinematic_constraint"].margins["negative_effective_inertia"]
    2.7567805728481524e-07
    """

    hold: bool
    margins: Mapping[str, float]


@dataclass(frozen=True)
class StabilityReport:
    """Linear stability of steady sliding (eqs 8.18–8.21 for the rigid drive).

    ``parts`` of the drive; ``stable``, whether it is asymptotically stable; ``kind``, its class in words, such as
    saddle or flutter; ``eigenvalues`` [1/s] in ascending real part; ``steady_law`` s_0, +1 or −1; ``conditions`` of
    instability by name: steady sliding is unstable exactly if one holds; ``quantities`` by name, each with its unit: of
    the rigid drive the effective inertia [kg m²] and damping [N m s/rad] of both laws and the steady deflection [rad];
    ``characteristic_polynomial``, of s [1/s], highest power first; ``paradox_region``, whether Γ₊ ≤ 0 (rigid drive
    only, else None).

    >>> report = lsvib.Drive(mass=11).stability()
    >>> report.kind, report.paradox_region, [f"{value.real:.4f} 1/s" for value in report.eigenvalues]
    ('saddle', True, ['-1576.0725 1/s', '2301.5564 1/s'])
    """

    parts: tuple[str, ...]
    stable: bool
    kind: str
    eigenvalues: tuple[complex, ...]
    steady_law: int
    conditions: Mapping[str, Condition]
    quantities: Mapping[str, Quantity]
    characteristic_polynomial: tuple[float, ...]
    paradox_region: bool | None = None

    def to_json(self) -> dict[str, Any]:
        """Return the report as plain numbers and names; an eigenvalue has a ``real`` and an ``imaginary`` part."""
        return asdict(self) | {"eigenvalues": [{"real": x.real, "imaginary": x.imag} for x in self.eigenvalues]}

    def text(self) -> Iterator[str]:
        """Yield the report in lines of text."""
        kind, neutral = words.plain(self.kind), self.kind in ("neutral", "centre")
        verdict = "stable" if self.stable else "neutral" if neutral else "unstable"
        yield f"steady sliding is {verdict}{'' if kind == verdict else f' ({kind})'}"
        for value in self.eigenvalues:
            pitch = f", {abs(value.imag) / math.tau:.6g} Hz" if value.imag else ""
            yield f"  eigenvalue {value.real:.10g}{f' {value.imag:+.10g}i' if value.imag else ''} 1/s{pitch}"
        for key, found in self.quantities.items():
            yield f"  {key}: {words.quantity(found.value, found.unit)}"
        for key, condition in self.conditions.items():
            yield f"  {words.plain(key)} instability: {'occurs' if condition.hold else 'does not occur'}"


@dataclass(frozen=True)
class Derivative:
    """A derivative in its ``unit``: the nearest double, ``value``, and doubles ``low`` and ``high`` that enclose it.

    They are None beyond the range of doubles. See also :meth:`lsvib.Drive.threshold`.

    >>> slope = lsvib.Drive(mass=11).threshold("kinematic_constraint").derivatives["friction_coefficient"]
    >>> f"{slope.value:.6g} {slope.unit}", slope.low <= slope.value <= slope.high
    ('-82.9256 kg', True)
    """

    value: float | None
    unit: str
    low: float | None
    high: float | None


@dataclass(frozen=True)
class ThresholdSolution:
    """One solution of the equations of a :class:`Threshold` for a parameter of a drive.

    ``value``: the parameter [SI unit], as the nearest double; ``enclosure``: doubles (low, high) between which it lies
    with certainty; ``derivatives`` of the value by every other parameter, by name; ``equation``: the one solved.

    >>> lsvib.Drive(mass=11).threshold("kinematic_constraint").solutions[0].equation
    'Γ₊ = I − ξ₊ tan λ m r_m² = 0 (eq. 8.20)'
    """

    value: float
    enclosure: tuple[float, float]
    derivatives: Mapping[str, Derivative]
    equation: str


@dataclass(frozen=True)
class Threshold:
    """Where the behaviour of a drive with these ``parts`` changes: a condition, by ``name``, solved for ``unknown``.

    ``solutions``: all that were found, in ascending order, in ``unit`` (UDUNITS spelling); ``how`` says whether these
    are all. ``value``, ``enclosure`` and ``derivatives`` are those of the smallest one. If there is none, ``value`` and
    ``enclosure`` are None, and ``reason`` says why. ``statement``: what it divides (forces for Ω > 0). ``onset`` also
    has ``stability``, asymptotic or neutral, in the ``stable_intervals`` (low, high) of the unknown, None at the end of
    its range (docs/thresholds.md).

    >>> onset = lsvib.Drive(translation_damping=1000).threshold("onset", unknown="axial_force")  # R̃ = 0, eq. 8.19
    >>> f"{onset.value:.6f} {onset.unit}", onset.stable_intervals[0][0]
    ('20.206611 N', None)
    """

    name: str
    parts: tuple[str, ...]
    unknown: str
    unit: str
    solutions: tuple[ThresholdSolution, ...] = ()
    statement: str = ""
    how: str = ""
    reason: str = ""
    stability: str = ""
    stable_intervals: tuple[tuple[float | None, float | None], ...] = field(default=())

    @property
    def value(self) -> float | None:
        """The smallest solution, in ``unit``."""
        return self.solutions[0].value if self.solutions else None

    @property
    def enclosure(self) -> tuple[float, float] | None:
        """Doubles (low, high) between which the smallest solution lies with certainty, in ``unit``."""
        return self.solutions[0].enclosure if self.solutions else None

    @property
    def derivatives(self) -> Mapping[str, Derivative]:
        """Derivatives of the smallest solution by all other parameters, by name."""
        return self.solutions[0].derivatives if self.solutions else {}

    def to_json(self) -> dict[str, Any]:
        """Return the threshold as plain numbers and names."""
        return {"value": self.value, "enclosure": self.enclosure, **asdict(self)}

    def text(self) -> Iterator[str]:
        """Yield all solutions in lines of text, with their enclosures and derivatives."""
        count = len(self.solutions)
        yield f"{self.name}: {count} solution{'s' if count > 1 else ''} for {self.unknown}. {self.how}"
        yield self.statement
        for solution in self.solutions:
            low, high = solution.enclosure
            value = words.with_unit(repr(solution.value), self.unit)
            yield f"{self.unknown} = {value}, between {low!r} and {high!r}"
            yield f"  equation: {solution.equation}"
            for key, slope in solution.derivatives.items():
                if slope.value:
                    yield f"  d/d {key} = {words.quantity(slope.value, slope.unit)}"

    def rows(self) -> Iterator[tuple[str, str, str]]:
        """Yield rows of a table: name, value of the unknown, remark."""
        if self.value is None:
            yield self.name, "none", self.reason
        for solution in self.solutions:
            yield self.name, f"{self.unknown} = {words.quantity(solution.value, self.unit)}", ""
        for low, high in self.stable_intervals:
            first = "" if low is None else f" from {low:.12g}"
            last = "" if high is None else f"{' up' if low is None else ''} to {high:.12g}"
            ends = words.with_unit(first + last, self.unit) + (" on" if first and not last else "")
            yield "", "", f"{self.stability} stability{ends}"
