"""The ways to map a region of attraction that are compared: this engine and its rivals."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.maps.map_kernels import stepped_labels
from lsvib.basins.kernels import labels
from lsvib.basins.labels import PlanarMapper

_HORIZON = 1.0  # [s] after which the motion of a rival is unresolved: some hundred swings of the drive
_BUDGET = 100_000  # events after which a motion is unresolved

Label = Callable[[np.ndarray, np.ndarray, np.ndarray], None]  # (x, y, labels), filled


@dataclass(frozen=True)
class MapMethod:
    """A way to map: ``prepare`` makes the function that is timed."""

    label: str
    prepare: Callable[[PlanarMapper], Label]


def _engine(mapper: PlanarMapper) -> Label:
    tables, known = mapper.automaton.tables, mapper.sections.known
    none = np.empty((0, 0), dtype=np.int8)
    return lambda x, y, found: labels.map_labels(tables, known, labels.Cells(x, y, 0), _BUDGET, found, none)


def _stepped(mapper: PlanarMapper, step: float) -> Label:
    tables, known = mapper.automaton.tables, mapper.sections.known
    return lambda x, y, labels: stepped_labels(tables, known, x, y, step, _HORIZON, labels)


METHODS: dict[str, MapMethod] = {
    "engine": MapMethod("lsvib", _engine),
    "rk4_coarse": MapMethod("RK4, 1e-4 s", partial(_stepped, step=1e-4)),
    "rk4_fine": MapMethod("RK4, 1e-5 s", partial(_stepped, step=1e-5)),
}
