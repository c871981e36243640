"""The twin of the engine in single precision: made from its source, without a double, and the same to its rounding."""

import math

import numba
import numpy as np
import pytest

from lsvib.basins.grid import Grid
from lsvib.basins.kernels import labelling
from lsvib.basins.mapper import mapper
from lsvib.bench.maps import single_precision
from lsvib.bench.maps.single_precision import double_arithmetic, in_single, twin
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import rigid_automaton
from lsvib.engine.kernels import columns, flow_planar

EPS = np.finfo(np.float32).eps
PARADOX = RigidParameters.of(mass=11.0, support_damping=1e-3, axial_force=-10.0)


def test_its_constants_are_single():
    found = twin("flow_planar")
    assert found.EPS == EPS
    assert found.ROUNDING == np.float32(flow_planar.ROUNDING / flow_planar.EPS * EPS)
    assert found.math.pi == math.pi  # the library itself is left alone
    assert twin("search_planar")._TWO_PI == np.float32(2 * math.pi)
    assert twin("event_loop").LARGEST == math.inf
    assert {type(found.EPS), type(twin("search_planar")._TWO_PI), type(twin("event_loop").LARGEST)} == {np.float32}
    assert flow_planar.EPS == np.finfo(np.float64).eps
    assert isinstance(found.BETA, int)


def test_tables_keep_their_integers():
    tables = rigid_automaton(PARADOX).tables
    single = in_single(tables)
    assert single.flow.dtype == np.float32
    assert single.guard_start.dtype == tables.guard_start.dtype
    assert isinstance(single.shortest_stay, np.float32)
    np.testing.assert_array_equal(single.surfaces, tables.surfaces.astype(np.float32))


def test_a_double_is_noticed():
    @numba.njit(error_model="numpy")
    def doubles(x, n):
        return x * n

    doubles(np.float32(0.5), 3)  # numba multiplies an integer and a float32 in double precision
    assert any("double" in line for line in double_arithmetic(doubles))


@pytest.mark.parametrize(
    ("equilibrium", "t"),
    [(0.0, 2.0), (1e3, 0.3), (1e3, 3.0)],  # by displacements from the equilibrium; far from it by a series; without
)
def test_the_flow_in_single_precision(equilibrium, t):
    """The same state to the rounding of single precision, a unit or two for each of a dozen operations; no double."""
    row = np.zeros(columns.COUNT)
    row[[columns.A0, columns.A1, columns.ALPHA, columns.TIME_SCALE]] = 1.0, 0.125, 0.0625, 1.0
    row[[columns.B, columns.EQUILIBRIUM, columns.BETA]] = (
        equilibrium,
        equilibrium,
        math.sqrt(1.0 - 0.0625**2),
    )
    state, found, expected = np.array([0.25, 0.5]), np.empty(2, np.float32), np.empty(2)
    twin("flow_planar").advance(in_single(row[None]), 0, in_single(state), np.float32(t), found)
    flow_planar.advance(row[None], 0, state, t, expected)
    assert (np.abs(found - expected) <= 32 * EPS * max(equilibrium, 1.0)).all()
    assert not np.array_equal(found, expected)  # it is single precision
    assert double_arithmetic(twin("flow_planar").advance) == []


def test_a_tolerance_that_the_engine_no_longer_has_is_an_error(monkeypatch):
    monkeypatch.setitem(single_precision._TOLERANCES, ("newton", "_GONE"), np.float32(1.0))
    with pytest.raises(AttributeError, match="no constant _GONE"):
        twin.__wrapped__("newton")


def test_a_module_without_arithmetic_has_no_twin():
    with pytest.raises(ValueError, match="tables has no twin"):
        twin("tables")


@pytest.mark.slow
def test_the_map_in_single_precision():
    """No double anywhere; labels differ from the engine's in next to no cell, where these are not within rounding."""
    found = mapper(PARADOX)
    grid = Grid.parse(["u=-0.05:0.05:300", "w=-15:15:300"])
    labels, none = np.empty((300, 300), dtype=np.int8), np.empty((0, 0), dtype=np.int8)
    tables, known = in_single(found.automaton.tables), in_single(found.sections.known)
    x, y = (axis.centres().astype(np.float32) for axis in (grid.x, grid.y))
    kernel = twin("labelling").map_labels
    kernel(tables, known, x, y, 0, 1000, labels, none)
    assert double_arithmetic(kernel) == []
    expected = found.cells(grid, quantities=("label",))["label"]
    # The boundary is two boxes long; labels within 1e-6 of it may differ: 4e-6 of 90 000 cells.
    assert np.count_nonzero(labels != expected) <= 4
    assert len(np.unique(expected)) == 2
    assert labelling.UNRESOLVED not in expected
