"""Planar slices of models with more states, against the return map."""

import numpy as np
import pytest
from references.parts import nut_drive, support_drive, threads_drive

from lsvib.basins.grid import Axis, Grid
from lsvib.basins.mapping import mapper
from lsvib.dynamics.attractor import Attractor, steady_state

DRIVE = {"mass": 11.0, "support_damping": 1e-3, "axial_force": -10.0}
GRID = Grid(Axis("u", -0.05, 0.05, 6), Axis("w", -15, 15, 5))


@pytest.mark.parametrize(
    ("kind", "model"), [(threads_drive, "threads"), (support_drive, "support"), (nut_drive, "nut")]
)
def test_labels_against_the_return_map(kind, model):
    mapped = mapper(kind.of(DRIVE), model)
    found = mapped.cells(GRID, quantities=("label", "time", "seizures", "first_event"))
    for (i, j), label in np.ndenumerate(found["label"]):
        state = mapped.definition.initial_state(mapped.drive, {"u": GRID.x.centres()[j], "w": GRID.y.centres()[i]})
        assert steady_state(mapped.automaton, state).label == label
    assert Attractor.UNRESOLVED not in found["label"]
    assert np.isfinite(found["time"]).all()
    again = mapped.cells(GRID, slice(2, 5), slice(1, 4), quantities=("label", "time"), workers=2)
    assert again["time"].tobytes() == found["time"][2:5, 1:4].tobytes()
    assert again["label"].tobytes() == found["label"][2:5, 1:4].tobytes()
