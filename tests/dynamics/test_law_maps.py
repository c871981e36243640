"""Maps of two-state drives: what intervals of sections say, against the rule for each motion."""

import numpy as np
import pytest
from references.drives import random_drive, wide_drive
from references.sizes import sizes

import lsvib
from lsvib.answers.map import mapper
from lsvib.dynamics.curves import Arc, state_on
from lsvib.systems.attractor import Attractor, Doubt, steady_state
from lsvib.systems.grid import Axis, Grid
from lsvib.systems.kernels.next_section import put_on
from lsvib.systems.mapper import Mapper

SEAT = {"stribeck_rise": 0.0203, "stribeck_speed": 0.013704, "friction_slope": -0.08588598956673593}
LAWS = {  # with what motions of each end in
    "seat": (SEAT | {"mass": 5, "support_damping": 6e-4, "axial_force": 90, "input_speed": 8}, {0, 1}),
    "paradox": (SEAT | {"mass": 9, "support_damping": 2e-4, "axial_force": 15, "input_speed": 40}, {0, 2}),
    "band": (SEAT | {"mass": 11, "support_damping": 2e-4, "axial_force": -20, "input_speed": 20}, {0, 2}),
    "backwards": (SEAT | {"mass": 11, "support_damping": 2e-4, "axial_force": 15, "input_speed": -20}, {0, 2}),
    "no rest": (SEAT | {"mass": 11, "support_damping": 1.5e-3, "axial_force": 90, "input_speed": 8}, {2}),
    "rise": (
        {"stribeck_rise": 0.05, "stribeck_speed": 0.05, "mass": 5, "support_damping": 3e-4, "axial_force": 30}
        | {"input_speed": 20},
        {0},
    ),
    "slope": ({"friction_slope": -0.05, "mass": 5, "support_damping": 1e-3, "axial_force": 60}, {0}),
    "static": (
        {"static_friction_coefficient": 0.26, "stribeck_rise": 0.02, "stribeck_speed": 0.02, "mass": 5}
        | {"support_damping": 3e-4, "axial_force": 60, "input_speed": 10},
        {0, 1},
    ),
    "undamped": ({"static_friction_coefficient": 0.28, "mass": 7, "support_damping": 0, "axial_force": 1.6}, {1, 6}),
}


def grid_of(mapped, count: int) -> Grid:
    return Grid(*(Axis(name, -x, x, count) for name, x in zip("uw", mapped.starts.size * [8, 6], strict=True)))


@pytest.mark.parametrize("size", sizes([(100, 60)], [], [(500, 10_000)]))
@pytest.mark.parametrize("name", sizes(list(LAWS)[::2], [], list(LAWS)[1::2]))
def test_labels_against_the_rule(name, size):
    """Labels of random cells, and of cells beside boundaries; of undamped motions the rule does not tell all."""
    (keys, ends), (count, cells) = LAWS[name], size
    mapped = mapper(lsvib.Drive(**keys))
    rule, grid = Mapper(mapped.automaton, mapped.starts), grid_of(mapped, count)
    found = mapped.cells(grid, quantities=("label", "first_event"), workers=2)
    labels = found["label"]
    assert set(np.unique(labels)) == ends
    beside = np.zeros_like(labels, dtype=bool)
    for axis in (0, 1):
        changes = np.diff(labels, axis=axis) != 0
        beside |= np.insert(changes, 0, False, axis=axis) | np.insert(changes, count - 1, False, axis=axis)
    rng = np.random.default_rng(5)
    chosen = rng.permutation(np.argwhere(beside))[: cells // 10].tolist() + rng.integers(0, count, (cells, 2)).tolist()
    for i, j in chosen:
        one = rule.cells(grid, slice(i, i + 1), slice(j, j + 1), ("label", "first_event"))
        told = one["label"][0, 0] != Attractor.UNRESOLVED or name != "undamped"
        assert not told or all(one[key][0, 0] == found[key][i, j] for key in one), (i, j)


@pytest.mark.parametrize("index", sizes([0, 19, 75, 94], [], range(200)))
def test_labels_of_motions_that_come_to_edges_of_intervals(index):
    """Of drives that stick, the last three with a small region of attraction that events lead to."""
    rng = np.random.default_rng([73, index])
    static = {"friction_coefficient": 0.218, "static_friction_coefficient": rng.uniform(0.218, 0.35)}
    mapped = mapper(random_drive(rng, **static))
    sections, tables, starts = mapped.sections, mapped.automaton.tables, []
    for mode in np.flatnonzero(sections.way.pieces.level >= 0):
        for section, line in sections.lines.items():
            edges = line.points[1:-1][np.diff(line.labels) != 0]
            off = sections.size[section.free] * rng.choice([0, 1e-9, 1e-7, 1e-4, 0.02], 40) * rng.choice([-1, 1], 40)
            for x in rng.choice(edges, 40) + off if edges.size else ():
                state = np.full(2, x)
                put_on(tables, section.surface, state)
                starts.append(state_on(mapped.automaton.flow, Arc(int(mode), state, state, 0.0), -1e-3 * rng.random()))
    for start in starts:
        ends = zip("uw", start, 1e-12 * (sections.size + np.abs(start)), strict=True)
        grid = Grid(*(Axis(name, x - width, x + width, 1) for name, x, width in ends))
        state = (grid.x.centres()[0], grid.y.centres()[0])
        label = mapped.cells(grid, quantities=("label",))["label"][0, 0]
        assert steady_state(mapped.automaton, state).label in (label, Attractor.UNRESOLVED), state


@pytest.mark.parametrize("draw", [(11, 31), (11, 46), (32, 28)])
def test_each_cell_takes_a_share_of_the_work_where_most_come_to_no_interval(draw):
    mapped = mapper(wide_drive("rigid", *draw, 0).drive)
    found = mapped.cells(grid_of(mapped, 16), quantities=("label", "doubt"))
    spent = np.isin(found["doubt"], [list(Doubt).index(doubt) for doubt in (Doubt.EVENT_BUDGET, Doubt.RECURRENT)])
    assert mapped.work < 3000
    assert (spent == (found["label"] == Attractor.UNRESOLVED)).all()


def test_a_start_at_rest_and_cells_one_by_one():
    drive = lsvib.Drive(**LAWS["seat"][0])
    mapped, rule = mapper(drive), drive.steady_state
    grid = Grid(Axis("u", -0.03, 0.03, 4), Axis("w", -16.0, 0.0, 1))  # θ′ = 0 in the middle of the row
    found = mapped.cells(grid, quantities=("label",))["label"][0]
    assert [rule({"u": u, "w": -8.0}).label for u in grid.x.centres()] == found.tolist()
    assert mapped.cells(grid, columns=slice(2, 3), quantities=("label",))["label"][0, 0] == found[2]


def test_times_are_those_of_the_motions():
    mapped = mapper(lsvib.Drive(**LAWS["seat"][0]))
    grid = Grid(Axis("u", -0.03, 0.03, 3), Axis("w", -20, 20, 2))
    found = mapped.cells(grid, quantities=("label", "time", "doubt"))
    rule = Mapper(mapped.automaton, mapped.starts).cells(grid, quantities=("label", "time", "doubt"))
    assert all(array.tobytes() == rule[name].tobytes() for name, array in found.items())
    assert Attractor.UNRESOLVED not in found["label"]
