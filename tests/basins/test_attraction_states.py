"""Planar slices of models with more states: against the return map."""

import numpy as np
import pytest

from lsvib.basins import slice_mapper
from lsvib.basins.grid import Grid
from lsvib.basins.mapper import mapper
from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.data import attraction_map
from lsvib.drives.parameters import NutParameters, SupportParameters, ThreadsParameters
from lsvib.engine.motion import follow

DRIVE = {"mass": 11.0, "support_damping": 1e-3, "axial_force": -10.0}
GRID = ["u=-0.05:0.05:6", "w=-15:15:5"]


@pytest.mark.parametrize(
    ("kind", "model"), [(ThreadsParameters, "threads"), (SupportParameters, "support"), (NutParameters, "nut")]
)
def test_labels_against_the_return_map(kind, model):
    mapped = mapper(kind.of(DRIVE), model)
    grid = Grid.parse(GRID)
    found = mapped.cells(grid, quantities=("label", "time", "seizures", "first_event"))
    for (i, j), label in np.ndenumerate(found["label"]):
        state = mapped.definition.initial_state(mapped.drive, {"u": grid.x.centres()[j], "w": grid.y.centres()[i]})
        assert steady_state(mapped.automaton, state).label == label
    assert Attractor.UNRESOLVED not in found["label"]
    assert np.isfinite(found["time"]).all()
    again = mapped.cells(grid, slice(2, 5), slice(1, 4), quantities=("label", "time"), workers=2)
    assert again["time"].tobytes() == found["time"][2:5, 1:4].tobytes()
    assert again["label"].tobytes() == found["label"][2:5, 1:4].tobytes()
    columns = np.tile(grid.x.centres(), 5)
    assert (mapped.labels_of(columns, np.repeat(grid.y.centres(), 6)) == found["label"].ravel()).all()


def test_what_is_open_after_many_events_is_asked_of_the_return_map_in_the_mode_reached(monkeypatch):
    """On a surface the state alone does not say in which mode the motion is."""
    mapped = mapper(ThreadsParameters.of(DRIVE), "threads")
    mapped.attractors = []
    state = mapped.definition.initial_state(mapped.drive, {"u": 0.05, "w": 15.0})
    asked = []

    def remember(automaton, state, *, mode, **how):
        asked.append((state, mode))
        return steady_state(automaton, state, mode=mode, **how)

    mapped._rounds = 1
    monkeypatch.setattr(slice_mapper, "steady_state", remember)
    mapped.destiny(state)
    motion = follow(mapped.automaton, state, np.inf, max_events=slice_mapper._CHUNK)
    assert asked[0][1] == motion.end_mode
    assert asked[0][0].tobytes() == motion.end_state.tobytes()


def test_a_cycle_of_many_arcs_is_sampled_for_the_picture(monkeypatch):
    monkeypatch.setattr(attraction_map, "_CYCLE_SAMPLES", 3)
    mapped = mapper(ThreadsParameters.of(DRIVE), "threads")
    found = attraction_map.surroundings(mapped, Grid.parse(GRID))
    assert len(found["cycle_angle"][1][0]) == 2 * (mapped.attractors[0].orbit.time.size + 1) > 3
