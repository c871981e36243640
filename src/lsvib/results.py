"""What a drive answers in numbers: small values that cannot change. Everything else that it answers is a dataset."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Self


@dataclass(frozen=True)
class Quantity:
    """A number and its ``unit`` as UDUNITS spells it, "1" without a dimension; the ``value`` is None if it has none."""

    value: float | None
    unit: str


@dataclass(frozen=True)
class Condition:
    """A condition of instability; ``hold`` is true exactly if each of its inequalities has a positive margin.

    ``margins``: by name, in SI units of the quantity that the name says. Missing margins are omitted; a condition
    without margins does not hold.
    """

    hold: bool
    margins: Mapping[str, float]

    @classmethod
    def by_name(cls, table: Mapping[str, Any]) -> dict[str, Self]:
        """Make the conditions of a table of :func:`lsvib.stability`."""
        return {name: cls(entry["hold"], dict(entry["margins"])) for name, entry in table.items()}


@dataclass(frozen=True)
class UndampedStability:
    """What is known of the stability of the same drive without any damping (support, eqs 8.29–8.32).

    ``kind`` of steady sliding; ``conditions`` and ``quantities`` by name.
    """

    kind: str
    conditions: Mapping[str, Condition]
    quantities: Mapping[str, Quantity]


@dataclass(frozen=True)
class StabilityReport:
    """Linear stability of steady sliding (eqs 8.18–8.21 of the rigid drive).

    ``model``; ``stable``, whether it is asymptotically stable; ``kind``, its class in words, such as saddle or flutter;
    ``eigenvalues`` [1/s]; ``steady_law`` s_0, +1 or −1; ``conditions`` of instability by name; ``quantities`` by name,
    each with its unit: of the rigid drive the effective inertia [kg m²] and damping [N m s/rad] of both laws and the
    steady deflection [rad]; ``paradox_region``, whether Γ₊ ≤ 0 (rigid drive only, else None);
    ``characteristic_polynomial``, of s [1/s], highest power first (not of the rigid drive, there empty);
    ``without_damping`` (support only, else None).
    """

    model: str
    stable: bool
    kind: str
    eigenvalues: tuple[complex, ...]
    steady_law: int
    conditions: Mapping[str, Condition]
    quantities: Mapping[str, Quantity]
    paradox_region: bool | None = None
    characteristic_polynomial: tuple[float, ...] = ()
    without_damping: UndampedStability | None = None

    @classmethod
    def of(cls, table: Mapping[str, Any]) -> Self:
        """Make the report of a table of :func:`lsvib.stability`."""
        quantities = {name: Quantity(**entry) for name, entry in table.get("quantities", {}).items()}
        for name in ("effective_inertia", "effective_damping"):
            for law in ("plus", "minus") if name in table else ():
                quantities[f"{name}_{law}"] = Quantity(table[name][law], table[name]["unit"])
        if "steady_deflection" in table:
            quantities["steady_deflection"] = Quantity(**table["steady_deflection"])
        undamped = table.get("without_damping")
        return cls(
            model=table.get("model", "rigid"),
            stable=table["stable"],
            kind=table["class"],
            eigenvalues=tuple(complex(value["real"], value["imaginary"]) for value in table["eigenvalues"]),
            steady_law=table["steady_law"],
            conditions=Condition.by_name(table["conditions"]),
            quantities=quantities,
            paradox_region=table.get("paradox_region"),
            characteristic_polynomial=tuple(table.get("characteristic_polynomial", ())),
            without_damping=undamped
            and UndampedStability(
                kind=undamped["class"],
                conditions=Condition.by_name(undamped["conditions"]),
                quantities={name: Quantity(**entry) for name, entry in undamped["quantities"].items()},
            ),
        )


@dataclass(frozen=True)
class ThresholdSolution:
    """One solution of the equations of a threshold for a parameter of a drive.

    ``value`` of the parameter, a double in its SI unit; ``residual`` [1], what the equations leave at it, relative to
    their terms; ``error_bound`` in its unit, which includes the rounding to a double; ``derivatives``, of the value by
    every other parameter, by name, each with its unit, None beyond the range of doubles; ``equation``, what is solved,
    in words.
    """

    value: float
    residual: float
    error_bound: float
    derivatives: Mapping[str, Quantity]
    equation: str

    def change(self, by: Mapping[str, float]) -> dict[str, float]:
        """Return what changes of other parameters, by name in their SI units, change the value, to first order."""
        return {name: float(self.derivatives[name].value or 0.0) * step for name, step in by.items()}


@dataclass(frozen=True)
class SolvedThreshold:
    """A threshold by ``name``, solved for the parameter ``unknown`` of a drive of a ``model``.

    ``solutions``, at least one, in ascending order, in ``unit``; ``how`` says whether these are all. ``value``,
    ``residual``, ``error_bound``, ``derivatives`` and ``equation`` are those of the smallest one; ``several`` says that
    there are more.
    """

    name: str
    model: str
    unknown: str
    unit: str
    solutions: tuple[ThresholdSolution, ...]
    how: str

    @property
    def several(self) -> bool:
        """Whether there is more than one solution."""
        return len(self.solutions) > 1

    @property
    def value(self) -> float:
        """The smallest solution, in ``unit``."""
        return self.solutions[0].value

    @property
    def residual(self) -> float:
        """Residual [1] of the smallest solution."""
        return self.solutions[0].residual

    @property
    def error_bound(self) -> float:
        """Bound of the error of the smallest solution, in ``unit``."""
        return self.solutions[0].error_bound

    @property
    def derivatives(self) -> Mapping[str, Quantity]:
        """Derivatives of the smallest solution by all other parameters, by name."""
        return self.solutions[0].derivatives

    @property
    def equation(self) -> str:
        """Equation of the smallest solution, in words."""
        return self.solutions[0].equation

    def to_json(self) -> dict[str, Any]:
        """Return the threshold as plain numbers and names."""
        return asdict(self)


@dataclass(frozen=True)
class Threshold:
    """A value of a parameter at which the drive changes what it does.

    ``value`` in ``unit`` (UDUNITS spelling), None if there is none, for the ``reason`` given; ``statement``, what it
    divides (forces, for Ω > 0). Of the rigid drive, where the chapter prints the number for this very drive: its
    ``expected`` value in the same unit, the relative ``tolerance`` [1], the ``relative_error`` [1], whether it
    ``passed``; and the ``source``. ``by_eigenvalues``: the critical friction [1] as the root of an eigenvalue. Of other
    models: ``stability``, asymptotic or neutral, in the ``stable_intervals`` of the parameter in the same unit, from
    low to high, high None at the end of its range.
    """

    name: str
    value: float | None
    unit: str
    reason: str = ""
    statement: str = ""
    source: str = ""
    expected: float | None = None
    tolerance: float | None = None
    relative_error: float | None = None
    passed: bool | None = None
    by_eigenvalues: float | None = None
    stability: str = ""
    stable_intervals: tuple[tuple[float, float | None], ...] = field(default=())

    @classmethod
    def by_name(cls, table: Mapping[str, Mapping[str, Any]]) -> dict[str, Self]:
        """Make the thresholds of a table of :func:`lsvib.thresholds`."""
        found = {}
        for name, entry in table.items():
            intervals = tuple((part["low"], part["high"]) for part in entry.get("stable_intervals", ()))
            found[name] = cls(name=name, **{**entry, "stable_intervals": intervals})
        return found
