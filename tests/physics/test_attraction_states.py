"""Planar slices of models with more states: against the return map, and in the limit of a stiff contact."""

import numpy as np
import pytest

from lsvib.analysis.attraction import mapper
from lsvib.analysis.cycles import Attractor, steady_state
from lsvib.analysis.grid import Grid
from lsvib.datasets import attraction_limit
from lsvib.models.parameters import NutDrive, SupportDrive, ThreadsDrive

DRIVE = {"mass": 11.0, "support_damping": 1e-3, "axial_force": -10.0}
GRID = ["u=-0.05:0.05:6", "w=-15:15:5"]


@pytest.mark.parametrize(("kind", "model"), [(ThreadsDrive, "threads"), (SupportDrive, "support"), (NutDrive, "nut")])
def test_labels_against_the_return_map(kind, model):
    mapped = mapper(kind.of(DRIVE), model)
    grid = Grid.parse(GRID)
    found = mapped.cells(grid, quantities=("label", "time", "seizures", "first_event"))
    for (i, j), label in np.ndenumerate(found["label"]):
        state = mapped.kind.initial_state(mapped.drive, {"u": grid.x.centres()[j], "w": grid.y.centres()[i]})
        assert steady_state(mapped.automaton, state).label == label
    assert Attractor.UNRESOLVED not in found["label"]
    assert np.isfinite(found["time"]).all()
    again = mapped.cells(grid, slice(2, 5), slice(1, 4), quantities=("label", "time"), threads=2)
    assert again["time"].tobytes() == found["time"][2:5, 1:4].tobytes()
    assert again["label"].tobytes() == found["label"][2:5, 1:4].tobytes()


def test_slice_tends_to_the_rigid_map():
    """First order in 1 / k_c: the contact that follows at once is left out in the limit."""
    dataset = attraction_limit.build(
        {
            "drive": DRIVE,
            "grid": {key: {"start": -x, "stop": x, "count": 20} for key, x in (("u", 0.05), ("w", 15))},
            "stiffnesses": [1e7, 1e8, 1e9],
            "rays": 5,
        }
    )
    assert all(check.passed for check in attraction_limit.checks(dataset))
    assert dataset.different[-1] == 0
    assert float(dataset.order) == pytest.approx(1.0, abs=0.05)
