"""Maps of the region of attraction against motions that are followed one by one, and their invariances."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references.parts import DRIVES

from lsvib.basins.grid import Axis, Grid
from lsvib.basins.mapping import mapper
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.names import Event

PARADOX = Drive.of(mass=11.0, support_damping=1e-3, axial_force=-10.0)


@pytest.fixture(scope="module")
def mappers():
    known = {}

    def get(drive, **options):
        key = (drive.model_dump_json(), *options.items())
        if key not in known:
            known[key] = mapper(drive, **options)
        return known[key]

    return get


@pytest.mark.parametrize("damping", [1e-3, 3e-3])
def test_labels_and_times_against_the_engine(mappers, damping):
    """The return map decides the label without the table; the time is where the engine enters the ellipse or cycle."""
    mapped = mappers(PARADOX.replace(support_damping=damping))
    grid = Grid(Axis("u", -0.1, 0.1, 23), Axis("w", -80, 60, 19))
    found = mapped.cells(grid)
    cycle = next(a for a in mapped.attractors if a.label == Attractor.SPRAG_SLIP_CYCLE)
    for (i, j), label in np.ndenumerate(found["label"]):
        start = (grid.x.centres()[j], grid.y.centres()[i])
        assert steady_state(mapped.automaton, start).label == label
        motion = follow(mapped.automaton, start, found["time"][i, j] * (1 + 1e-12))
        assert found["first_event"][i, j] == (motion.kind[0] if motion.time.size else -1)
        assert found["seizures"][i, j] == np.sum(motion.kind == Event.SEIZURE)
        if label == Attractor.SPRAG_SLIP_CYCLE:
            gap = np.abs(cycle.orbit.after - motion.after[-1]) / np.abs(cycle.orbit.after).max(axis=0)
            assert gap.max(axis=1).min() <= 1.001e-9


def test_time_to_steady_sliding(mappers):
    """In the mode of steady sliding |w + α u|² + β² u² falls as e^{−2αt}; the ellipse touches Q = 0."""
    mapped = mappers(PARADOX)
    found = mapped.cells(Grid(Axis("u", -0.03, 0.02, 9), Axis("w", -5, 5, 7)))
    row = mapped.automaton.tables.flow[1]
    alpha, beta = row[3], row[4]
    q_u, q_w, q_0 = mapped.automaton.tables.surfaces[0]
    radius = abs(q_0) / np.hypot(q_w, (q_u - alpha * q_w) / beta)
    checked = 0
    for (i, j), label in np.ndenumerate(found["label"]):
        if label == Attractor.STEADY_SLIDING and found["time"][i, j] > 0:
            grid = Grid(Axis("u", -0.03, 0.02, 9), Axis("w", -5, 5, 7))
            motion = follow(mapped.automaton, (grid.x.centres()[j], grid.y.centres()[i]), found["time"][i, j])
            u, w = motion.end_state
            assert np.hypot(w + alpha * u, beta * u) == pytest.approx(radius, rel=1e-10)
            checked += 1
    assert checked > 10


@given(u=st.floats(-0.12, 0.12), w=st.floats(-80.0, 80.0), part=st.floats(0.0, 1.0))
def test_points_of_one_motion_have_one_label(mappers, u, w, part):
    mapped = mappers(PARADOX.replace(support_damping=3e-3))
    state = follow(mapped.automaton, (u, w), 0.02 * part).end_state
    cells = (
        Grid(*(Axis(key, x - 1e-3, x + 1e-3, 1) for key, x in zip("uw", at, strict=True))) for at in ((u, w), state)
    )
    before, after = (mapped.cells(cell, quantities=("label",))["label"] for cell in cells)
    assert before == after


def test_symmetry(mappers):
    """(u, w, Ω, R) → −(u, w, Ω, R) maps motions to motions."""
    drive = PARADOX.replace(support_damping=3e-3)
    turned = drive.replace(axial_force=-drive.axial_force, input_speed=-drive.input_speed)
    grid = Grid(Axis("u", -0.1, 0.1, 40), Axis("w", -80, 80, 30))
    one, other = mappers(drive).cells(grid), mappers(turned).cells(grid)
    for name in ("label", "seizures", "first_event"):
        assert np.array_equal(one[name], other[name][::-1, ::-1])
    np.testing.assert_allclose(one["time"], other["time"][::-1, ::-1], rtol=1e-12)  # sums of a few rounded stays
    assert len(np.unique(one["label"])) == 2


@pytest.mark.parametrize("model", ["threads", "support", "nut"])
def test_labels_of_planar_slices_against_the_return_map(model):
    mapped = mapper(DRIVES[model](PARADOX), model)
    grid = Grid(Axis("u", -0.05, 0.05, 6), Axis("w", -15, 15, 5))
    found = mapped.cells(grid, quantities=("label", "time", "seizures", "first_event"))
    for (i, j), label in np.ndenumerate(found["label"]):
        state = mapped.definition.initial_state(mapped.drive, {"u": grid.x.centres()[j], "w": grid.y.centres()[i]})
        assert steady_state(mapped.automaton, state).label == label
    assert Attractor.UNRESOLVED not in found["label"]
    assert np.isfinite(found["time"]).all()
    again = mapped.cells(grid, slice(2, 5), slice(1, 4), quantities=("label", "time"), workers=2)
    assert again["time"].tobytes() == found["time"][2:5, 1:4].tobytes()
    assert again["label"].tobytes() == found["label"][2:5, 1:4].tobytes()
