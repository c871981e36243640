"""Maps of the region of attraction against independent motions, and their invariances."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from references import many_starts

from lsvib.basins.cells import QUANTITIES
from lsvib.basins.grid import Grid
from lsvib.basins.mapper import mapper
from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import EventKind
from lsvib.engine.motion import follow

PARADOX = RigidParameters.of(mass=11.0, support_damping=1e-3, axial_force=-10.0)
# Drive, box (u [rad], w [rad/s]), duration and watch [s] of the reference. The watch is longer than two periods of the
# cycle; in the duration steady sliding, with α = 40 1/s and more, shrinks by e^{-12}, and cycles are reached.
SCENES = {
    "small basin": (PARADOX, 0.1, 60.0, 0.3, 0.1),
    "large basin": (PARADOX.replace(axial_force=-30.0), 0.1, 60.0, 0.3, 0.1),
    "two cycles' worth of boundaries": (PARADOX.replace(support_damping=3e-3), 0.15, 90.0, 0.3, 0.1),
    "stick-slip": (RigidParameters.of(mass=1.0, translation_damping=1e3, axial_force=40.0), 0.1, 60.0, 0.3, 0.06),
    "pure slip": (RigidParameters.of(mass=1.0, translation_damping=1e3, axial_force=25.0), 0.1, 60.0, 0.3, 0.06),
}


@pytest.fixture(scope="module")
def mappers():
    known = {}

    def get(drive, **options):
        key = (drive.model_dump_json(), *options.items())
        if key not in known:
            known[key] = mapper(drive, **options)
        return known[key]

    return get


def boundary_points(mapped, box, count, rng) -> list[tuple[np.ndarray, np.ndarray]]:
    """Pairs of starts on either side of a boundary, 2e-7 of the box apart, by bisection between random starts."""
    pairs = []
    for _ in range(40 * count):
        ends = rng.uniform(-1, 1, (2, 2)) * box
        labels = mapped.labels_of(*ends.T)
        if labels[0] == labels[1]:
            continue
        while np.abs((ends[0] - ends[1]) / box).max() > 2e-7:
            middle = ends.mean(axis=0)
            ends[int(mapped.labels_of([middle[0]], [middle[1]])[0] == labels[1])] = middle
        pairs.append((ends[0], ends[1]))
        if len(pairs) == count:
            break
    return pairs


def check_scene(mapped, scene, starts: int, near: int, step: float, pieces: int) -> tuple[int, set[int]]:
    """Compare labels; returns the number of starts that the fixed steps left to 30 digits, and the labels met."""
    drive, u_size, w_size, duration, watch = SCENES[scene]
    rng = np.random.default_rng(20261121)
    box = np.array([u_size, w_size])
    u, w = (rng.uniform(-1, 1, (starts, 2)) * box).T
    ours = mapped.labels_of(u, w)
    theirs = np.concatenate(
        [
            many_starts.labels(dict(drive), *part, duration, step, watch)
            for part in np.array_split(np.array([u, w]), pieces, axis=1)
        ]
    )
    doubtful = np.flatnonzero(ours != theirs)
    for k in doubtful:
        assert ours[k] == many_starts.exact_label(dict(drive), u[k], w[k], duration, watch), (scene, u[k], w[k])
    for pair in boundary_points(mapped, box, near, rng):
        for x, y in pair:
            assert mapped.labels_of([x], [y])[0] == many_starts.exact_label(dict(drive), x, y, duration, watch)
    return doubtful.size, set(ours.tolist())


@pytest.mark.parametrize(
    "scene",
    [pytest.param(name, marks=pytest.mark.slow if name in ("small basin", "large basin") else ()) for name in SCENES],
)
def test_labels_against_fixed_steps_and_mpmath(mappers, scene):
    left, met = check_scene(mappers(SCENES[scene][0]), scene, 60, 2, 2e-5, 1)
    assert left <= 2  # the steps are tight enough to be a test of their own
    assert Attractor.UNRESOLVED not in met


@pytest.mark.long
@pytest.mark.parametrize("scene", SCENES)
def test_many_labels_against_fixed_steps_and_mpmath(mappers, scene):
    left, met = check_scene(mappers(SCENES[scene][0]), scene, 10_000, 100, 1e-5, 10)
    assert left <= 50
    assert Attractor.UNRESOLVED not in met


@pytest.mark.parametrize("rule", ["contact_sign", "at_once"])
@pytest.mark.parametrize("damping", [1e-3, 3e-3])
def test_labels_and_times_against_the_engine(mappers, rule, damping):
    """The return map decides the label without the table; the time is where the engine enters the ellipse or cycle."""
    mapped = mappers(PARADOX.replace(support_damping=damping), resume=rule)
    grid = Grid.parse(["u=-0.1:0.1:23", "w=-80:60:19"])
    found = mapped.cells(grid)
    cycle = next(a for a in mapped.attractors if a.label == Attractor.SPRAG_SLIP_CYCLE)
    for (i, j), label in np.ndenumerate(found["label"]):
        start = (grid.x.centres()[j], grid.y.centres()[i])
        assert steady_state(mapped.automaton, start).label == label
        motion = follow(mapped.automaton, start, found["time"][i, j] * (1 + 1e-12))
        assert found["first_event"][i, j] == (motion.kind[0] if motion.time.size else -1)
        assert found["seizures"][i, j] == np.sum(motion.kind == EventKind.SEIZURE)
        if label == Attractor.SPRAG_SLIP_CYCLE:
            gap = np.abs(cycle.orbit.after - motion.after[-1]) / np.abs(cycle.orbit.after).max(axis=0)
            assert gap.max(axis=1).min() <= 1.001e-9


def test_time_to_steady_sliding(mappers):
    """In the mode of steady sliding |w + α u|² + β² u² falls as e^{−2αt}; the ellipse touches Q = 0."""
    mapped = mappers(PARADOX)
    found = mapped.cells(Grid.parse(["u=-0.03:0.02:9", "w=-5:5:7"]))
    row = mapped.automaton.tables.flow[1]
    alpha, beta = row[3], row[4]
    q_u, q_w, q_0 = mapped.automaton.tables.surfaces[0]
    radius = abs(q_0) / np.hypot(q_w, (q_u - alpha * q_w) / beta)
    checked = 0
    for (i, j), label in np.ndenumerate(found["label"]):
        if label == Attractor.STEADY_SLIDING and found["time"][i, j] > 0:
            grid = Grid.parse(["u=-0.03:0.02:9", "w=-5:5:7"])
            motion = follow(mapped.automaton, (grid.x.centres()[j], grid.y.centres()[i]), found["time"][i, j])
            u, w = motion.end_state
            assert np.hypot(w + alpha * u, beta * u) == pytest.approx(radius, rel=1e-10)
            checked += 1
    assert checked > 10


@given(u=st.floats(-0.12, 0.12), w=st.floats(-80.0, 80.0), part=st.floats(0.0, 1.0))
def test_points_of_one_motion_have_one_label(mappers, u, w, part):
    mapped = mappers(PARADOX.replace(support_damping=3e-3))
    state = follow(mapped.automaton, (u, w), 0.02 * part).end_state
    before, after = mapped.labels_of([u, state[0]], [w, state[1]])
    assert before == after


def test_symmetry(mappers):
    """(u, w, Ω, R) → −(u, w, Ω, R) maps motions to motions."""
    drive = PARADOX.replace(support_damping=3e-3)
    turned = drive.replace(axial_force=-drive.axial_force, input_speed=-drive.input_speed)
    grid = Grid.parse(["u=-0.1:0.1:40", "w=-80:80:30"])
    one, other = mappers(drive).cells(grid), mappers(turned).cells(grid)
    for name in ("label", "seizures", "first_event"):
        assert np.array_equal(one[name], other[name][::-1, ::-1])
    np.testing.assert_allclose(one["time"], other["time"][::-1, ::-1], rtol=1e-12)  # sums of a few rounded stays
    assert len(np.unique(one["label"])) == 2


@pytest.mark.parametrize("quantities", [("label",), QUANTITIES])
def test_same_bits_for_any_tiles_and_workers(mappers, quantities):
    mapped = mappers(PARADOX.replace(support_damping=3e-3))
    grid = Grid.parse(["w=-80:80:70", "u=-0.1:0.1:150"])
    whole = mapped.cells(grid, quantities=quantities)
    for workers in (2, 3):
        again = mapped.cells(grid, quantities=quantities, workers=workers)
        assert all(whole[name].tobytes() == again[name].tobytes() for name in quantities)
    for rows, columns in (((0, 31, 150), (0, 70)), ((0, 1, 77, 150), (0, 13, 14, 70))):
        for top, bottom in pairwise(rows):
            for left, right in pairwise(columns):
                tile = mapped.cells(grid, slice(top, bottom), slice(left, right), quantities)
                for name in quantities:
                    assert np.array_equal(tile[name], whole[name][top:bottom, left:right])


@pytest.mark.parametrize("quantities", [("label",), ("label", "first_event")])
@pytest.mark.parametrize(
    "drive", [PARADOX, PARADOX.replace(axial_force=-50.0), PARADOX.replace(mass=10.0), SCENES["stick-slip"][0]]
)
def test_labels_do_not_depend_on_what_else_is_asked(mappers, drive, quantities):
    """The label alone takes a shorter way; the way with the first event is the reference."""
    grid = Grid.parse(["u=-0.1:0.1:60", "w=-80:80:60"])
    assert np.array_equal(
        mappers(drive).cells(grid, quantities=quantities)["label"], mappers(drive).cells(grid)["label"]
    )


def test_start_on_a_boundary_is_unresolved_only_to_rounding(mappers):
    """On the line θ′ = 0 of a drive with two attractors: labels of both sides, and what lies between is 1e-12 wide."""
    mapped = mappers(PARADOX.replace(support_damping=3e-3))
    known = mapped.sections.known
    edges, labels = known.edges, known.labels
    unresolved = [edges[k + 1] - edges[k] for k in range(len(edges) - 1) if labels[k] == Attractor.UNRESOLVED]
    assert unresolved
    assert max(unresolved) < 1e-11 * mapped.sections.size[0]
