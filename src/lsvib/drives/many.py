"""Many drives at once: their parameters in pairs of doubles, for the formulas that make the tables of one.

The formulas are those of one drive (:func:`lsvib.drives.coefficients.coefficients_of`,
:func:`lsvib.drives.rigid.automaton_of`); only the kind of number differs. Their doubles are the same to the last bit
(:mod:`lsvib.engine.exact.pair_arrays`).
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lsvib.drives.coefficients import Coefficients, coefficients_of
from lsvib.drives.parameters import RigidParameters, sine_and_cosine
from lsvib.drives.resumption import Resume
from lsvib.drives.rigid import automaton_of
from lsvib.engine.automaton import DIMENSIONS, Automaton
from lsvib.engine.exact.pair_arrays import Pairs, double, in_groups


class ExactMany:
    """Many drives in pairs of doubles: attributes as those of :class:`lsvib.drives.parameters.ExactParameters`."""

    def __init__(self, values: Mapping[str, Pairs]) -> None:
        self.__dict__.update(values)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Pairs: ...


@dataclass(frozen=True)
class Group:
    """Drives whose automata differ in doubles only.

    ``members`` (j) are their indices, and ``safe`` (j) says for which of them all is right to the last bit; the others
    need 50 digits. ``automaton``: its tables of doubles have an axis for the drives, the first; ``coefficients`` are
    pairs (j); ``steady_force`` (j) [N], |N_0| of steady sliding.
    """

    members: np.ndarray
    safe: np.ndarray
    automaton: Automaton
    coefficients: Coefficients
    steady_force: np.ndarray


class ManyDrives:
    """Drives of one model that are given by arrays of their parameters.

    ``values``: one value [SI unit] or an array (k) of each parameter of the model, within its range;
    ``drive_class`` is the class of the model's drives.
    """

    def __init__(
        self, values: Mapping[str, np.ndarray | float], drive_class: type[RigidParameters] = RigidParameters
    ) -> None:
        self.drive_class = drive_class
        # -0.0 and 0.0 are one drive, hence + 0.0 below
        self.size = max(np.size(value) for value in values.values())
        self.values = {
            name: np.broadcast_to(np.asarray(x, dtype=float) + 0.0, (self.size,)) for name, x in values.items()
        }
        # The sine of an angle takes three hundred operations, but few drives of a sweep differ in it.
        angles, self._angle = np.unique(self.values["lead_angle"], return_inverse=True)
        with np.errstate(all="ignore"):  # far terms of the series underflow
            self._sine, self._cosine = sine_and_cosine(Pairs.exactly(angles, np.zeros(angles.size, dtype=bool)))

        self._sines = np.array([math.sin(angle) for angle in angles])  # numpy's may differ in the last bit

    def some(self, entries: np.ndarray) -> "ManyDrives":
        """Return some of the drives, by their indices (j)."""
        return ManyDrives({name: column[entries] for name, column in self.values.items()}, self.drive_class)

    def one(self, entry: int) -> RigidParameters:
        """Return one of the drives."""
        return self.drive_class(**{name: float(column[entry]) for name, column in self.values.items()})

    def exact(self, entries: np.ndarray, unsafe: np.ndarray) -> ExactMany:
        """Return some of the drives (j) in pairs of doubles, with a record of what is unsafe (j)."""
        d = ExactMany({name: Pairs.exactly(column[entries], unsafe) for name, column in self.values.items()})
        d.sin_lead, d.cos_lead = (x.at(self._angle[entries], unsafe) for x in (self._sine, self._cosine))
        d.tan_lead = d.sin_lead / d.cos_lead
        return d

    def sines(self, entries: np.ndarray) -> np.ndarray:
        """Return sin λ (j) of some drives as doubles, as formulas in doubles have it."""
        return self._sines[self._angle[entries]]

    def groups(self, resume: Resume, entries: np.ndarray) -> Iterator[Group]:
        """Yield the rigid drives ``entries`` (j, indices) in groups, under a rule of resuming.

        Drives that are in no group need 50 digits, too.
        """

        def make(group: np.ndarray) -> Group:
            """Form the automata of some drives at once."""
            unsafe, here = np.zeros(group.size, dtype=bool), entries[group]
            d = self.exact(here, unsafe)
            c = coefficients_of(d)
            automaton = automaton_of(c, d, True, resume if c.paradox else "contact_sign")
            force = double(steady_force(c, d))
            return Group(here, ~unsafe, _layered(automaton, here.size), c, force)

        for _, group in in_groups(entries.size, make):
            yield group


def _layered(automaton: Automaton, size: int) -> Automaton:
    """Give the tables that are the same for all drives of a group, being numbers, the axis for the drives, too."""

    def layers(table: np.ndarray, dimensions: int) -> np.ndarray:
        """Return a table with a first axis for the drives, which it may have already."""
        table = np.asarray(table)
        if table.ndim > dimensions:
            return table
        # a copy, so that kernels see the same type of array for every group
        return np.array(np.broadcast_to(table, (size, *table.shape)), order="C")

    tables = automaton.tables
    dimensions = {"flow": 2, **DIMENSIONS}
    return replace(
        automaton,
        tables=tables._replace(**{name: layers(getattr(tables, name), n) for name, n in dimensions.items()}),
        observables={name: layers(table, 2) for name, table in automaton.observables.items()},
    )


def steady_force(c: Coefficients, d: Any) -> Any:
    """|N_0| of steady sliding (eq. 8.15): N_0 (cos λ + s_0 μ sin λ) = R − r_m tan λ c_x Ω."""
    return abs(c.net_force / (d.cos_lead + c.steady_law * d.friction_coefficient * d.sin_lead))
