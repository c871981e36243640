"""Maps of the region of attraction against motions; the largest tolerated perturbations, from within and beyond."""

import json
import math

import numpy as np
import pytest
from references.drives import DRIVES
from references.known import BASINS, PARADOX

import lsvib
from lsvib.answers.map import mapper
from lsvib.drives.names import Event
from lsvib.systems.attractor import Attractor, steady_state
from lsvib.systems.grid import Axis, Grid
from lsvib.systems.motion import follow


@pytest.mark.parametrize("damping", [1e-3, 3e-3])
def test_labels_and_times_against_the_engine(damping):
    """The return map decides the label without the table; the time is where the engine enters the ellipse or cycle."""
    mapped = mapper(PARADOX.replace(support_damping=damping))
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


def test_time_to_steady_sliding():
    """In the mode of steady sliding |w + α u|² + β² u² falls as e^{−2αt}; the ellipse touches Q = 0."""
    mapped = mapper(PARADOX)
    grid = Grid(Axis("u", -0.03, 0.02, 9), Axis("w", -5, 5, 7))
    found = mapped.cells(grid)
    row = mapped.automaton.tables.flow[1]
    alpha, beta = row[3], row[4]
    q_u, q_w, q_0 = mapped.automaton.tables.surfaces[0]
    radius = abs(q_0) / np.hypot(q_w, (q_u - alpha * q_w) / beta)
    checked = 0
    for (i, j), label in np.ndenumerate(found["label"]):
        if label == Attractor.STEADY_SLIDING and found["time"][i, j] > 0:
            motion = follow(mapped.automaton, (grid.x.centres()[j], grid.y.centres()[i]), found["time"][i, j])
            u, w = motion.end_state
            assert np.hypot(w + alpha * u, beta * u) == pytest.approx(radius, rel=1e-10)
            checked += 1
    assert checked > 10


@pytest.mark.parametrize("model", ["threads", "support", "nut"])
def test_labels_of_planar_slices_against_the_return_map(model):
    mapped = mapper(DRIVES[model](PARADOX))
    grid = Grid(Axis("u", -0.05, 0.05, 6), Axis("w", -15, 15, 5))
    found = mapped.cells(grid, quantities=("label", "time", "seizures", "first_event"))
    for (i, j), label in np.ndenumerate(found["label"]):
        state = mapped.starts.state({"u": grid.x.centres()[j], "w": grid.y.centres()[i]})
        assert steady_state(mapped.automaton, state).label == label
    assert Attractor.UNRESOLVED not in found["label"]
    assert np.isfinite(found["time"]).all()
    again = mapped.cells(grid, slice(2, 5), slice(1, 4), quantities=("label", "time"), workers=2)
    assert again["time"].tobytes() == found["time"][2:5, 1:4].tobytes()
    assert again["label"].tobytes() == found["label"][2:5, 1:4].tobytes()


BOUNDED = ("Fig. 8.14b beyond m_cr", "touching slip", "near the fold", "the other way round", "friction law")
WINDOW = {"u": (-0.3, 0.3), "w": (-150, 150)}
CLOSE = 1e-7  # relative distance from the boundary: far above rounding


def settles(drive, states):
    labels = np.array([drive.steady_state({"u": u, "w": w}).label for u, w in states])
    assert (labels != lsvib.Attractor.UNRESOLVED).all()
    return labels == lsvib.Attractor.STEADY_SLIDING


def energy_of(drive, u, w):
    inertia = drive.screw_inertia + drive.mass * (drive.pitch_radius * math.tan(drive.lead_angle)) ** 2
    return 0.5 * drive.coupling_stiffness * u**2 + 0.5 * inertia * w**2


@pytest.mark.parametrize("name", BOUNDED)
def test_motions_on_both_sides_of_the_largest_tolerated_perturbations(name):
    """Along each axis and in the least energy that is not tolerated; every perturbation of less is."""
    boundary, drive = BASINS[name]
    found = drive.resilience()
    assert found.boundary == boundary
    for size, unit in ((found.angle, (1, 0)), (found.speed, (0, 1))):
        within = [(sign * size * (1 - CLOSE) * unit[0], sign * size * (1 - CLOSE) * unit[1]) for sign in (1, -1)]
        beyond = [(sign * size * (1 + CLOSE) * unit[0], sign * size * (1 + CLOSE) * unit[1]) for sign in (1, -1)]
        assert settles(drive, within).all()
        assert not settles(drive, beyond).all()
    u, w = found.state
    assert found.energy == pytest.approx(energy_of(drive, u, w), rel=1e-14)
    assert settles(drive, [(u * (1 - CLOSE), w * (1 - CLOSE))]).all()
    assert not settles(drive, [(u * (1 + CLOSE), w * (1 + CLOSE))]).any()
    angles = np.random.default_rng(3).uniform(0, 2 * math.pi, 2000)
    less = math.sqrt(2 * found.energy) * (1 - CLOSE)
    units = math.sqrt(drive.coupling_stiffness), math.sqrt(2 * energy_of(drive, 0.0, 1.0))
    assert settles(drive, less * np.stack([np.cos(angles), np.sin(angles)], 1) / units).all()


def test_nothing_and_everything_is_tolerated():
    unstable = lsvib.Drive(mass=11, axial_force=10).resilience(WINDOW)
    assert (unstable.angle, unstable.speed, unstable.energy, unstable.fraction) == (0, 0, 0, 0)
    for drive in (lsvib.Drive(), lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-50)):
        stable = drive.resilience(WINDOW)
        assert (stable.angle, stable.speed, stable.energy, stable.fraction) == (math.inf,) * 3 + (1.0,)
        assert json.loads(json.dumps(stable.to_json(), allow_nan=False))["energy"] is None

    found = lsvib.Drive(support_damping=0, axial_force=-10).resilience(WINDOW)
    assert (found.boundary, found.energy, found.fraction) == ("neutral", 0, 0)
    assert lsvib.Drive(mass=11, axial_force=10).resilience().boundary == "unstable"
    assert lsvib.Drive(mass=11, support_damping=0, axial_force=10).resilience().boundary == "unstable"
