"""Many drives at once: their parameters in pairs of doubles, for the formulas that make the tables of one.

The formulas are those of one drive (:func:`lsvib.models.mechanics.coefficients_of`, ``automaton_of`` of the model);
only the kind of number differs. Their doubles are the same to the last bit (:mod:`lsvib.engine.exact.pair_arrays`).
:mod:`lsvib.models.tables_of_models` makes the tables.
"""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lsvib.engine.exact.pair_arrays import Pairs
from lsvib.models.drive import Drive, RigidDrive, sine_and_cosine


class ExactMany:
    """Many drives in pairs of doubles: attributes as those of :class:`lsvib.models.drive.ExactParameters`."""

    def __init__(self, values: Mapping[str, Pairs]) -> None:
        self.__dict__.update(values)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Pairs: ...


class ManyDrives:
    """Drives of one model that are given by arrays of their parameters.

    ``values``: one value [SI unit] or an array (k) of each parameter of the model, within its range;
    ``drive_class`` is the class of the model's drives.
    """

    def __init__(self, values: Mapping[str, np.ndarray | float], drive_class: type[Drive] = RigidDrive) -> None:
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

    def one(self, entry: int) -> Drive:
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
