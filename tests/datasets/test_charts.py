"""Charts: labels that two motions give each cell are those that the exact thresholds give, wherever no curve passes."""

import json
import math
from functools import lru_cache

import numpy as np
import pytest
import xarray as xr
from references.parts import threads_drive

import lsvib
from lsvib.datasets.chart import Plane, write_chart
from lsvib.datasets.io import write_dataset
from lsvib.dynamics.behaviour import Behaviour
from lsvib.errors import NoThreshold
from lsvib.models.mechanics import coefficients
from lsvib.stability.curves import ChartBoundary, _function, boundary_curves, starts_evenly
from lsvib.stability.force_thresholds import threshold_force

PAIRS = {  # of parameters, with the ends of both axes and the drive
    "mass over force": (("mass", 0.5, 14.0), ("axial_force", -60.0, 80.0), {"translation_damping": 1000.0}),
    "support damping over force": (("support_damping", 1e-4, 3e-3), ("axial_force", -90.0, 30.0), {"mass": 12.0}),
    "speed over force": (("input_speed", -90.0, -5.0), ("axial_force", -60.0, 60.0), {"translation_damping": 1000.0}),
    "mass and friction": (
        ("mass", 0.5, 14.0), ("friction_coefficient", 0.12, 0.4), {"translation_damping": 1000.0, "axial_force": 35.0},
    ),
}  # fmt: skip


@lru_cache(maxsize=100_000)
def force(name: str, drive) -> float | str:
    """A threshold of a drive without R, or in a word why there is none."""
    try:
        return threshold_force(drive, name)
    except NoThreshold as reason:
        return str(reason)


def expected(drive) -> Behaviour | None:
    """What the thresholds say that a drive does; None where they do not cover it. Written for Ω > 0, else mirrored."""
    c, way = coefficients(drive), math.copysign(1.0, drive.input_speed)
    plain, R = drive.replace(axial_force=0.0), way * drive.axial_force
    drags = float(c.net_force) * way > 0
    if c.paradox:
        if drags:
            return Behaviour.SPRAG_SLIP
        end = force("global_stability", plain)
        if isinstance(end, str):
            return Behaviour.NO_VIBRATION if "globally stable under every" in end else None
        if R < way * end:
            return Behaviour.NO_VIBRATION
        return {-1.0: Behaviour.VIBRATION_FROM_REST, 1.0: Behaviour.COEXISTENCE}.get(starts_evenly(drive))
    if c.damping[1] >= 0:
        return Behaviour.NO_VIBRATION
    if not drags:
        return {-1.0: Behaviour.VIBRATION_FROM_REST, 1.0: Behaviour.NO_VIBRATION}.get(starts_evenly(drive))
    stick, detach = force("stick", plain), force("detach", plain)
    if isinstance(stick, str) and "no limit cycle" not in stick:
        return None
    if not isinstance(stick, str) and R < way * stick:
        return Behaviour.PURE_SLIP
    if isinstance(detach, str):
        if "every cycle with rest reaches N = 0" in detach:
            return Behaviour.STICK_SLIP_WITH_CONTACT_REVERSAL
        return Behaviour.STICK_SLIP if "reaches N = 0 under no axial force" in detach else None
    return Behaviour.STICK_SLIP_WITH_CONTACT_REVERSAL if R < way * detach else Behaviour.STICK_SLIP


def looked_at(plane: Plane, said) -> tuple[np.ndarray, np.ndarray]:
    """What a function of both parameters says in the middle of each cell, and whether that is what its corners say."""

    def at(columns, rows) -> np.ndarray:
        return np.array([[said(a, b) for a in columns.tolist()] for b in rows.tolist()])

    middles = at(plane.x.centres(), plane.y.centres())
    nodes = at(*(axis.middles(np.arange(axis.count + 1) - 0.5) for axis in (plane.x, plane.y)))
    corners = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[:-1, 1:], nodes[1:, 1:]])
    return middles, (corners == middles).all(axis=0)


@pytest.mark.parametrize("name", PAIRS)
def test_labels_agree_with_the_exact_curves(name):
    """In every cell that no curve cuts: one of whose four corners and middle the thresholds say the same."""
    x, y, changes = PAIRS[name]
    count = 12 if name == "mass and friction" else 16
    plane = Plane.of(lsvib.Drive(**changes), (*x, count), (*y, count))

    def said(a: float, b: float) -> int:
        found = expected(plane.drive.replace(**{plane.x.name: a, plane.y.name: b}))
        return -9 if found is None else int(found)

    labels, (middles, whole) = plane.labels(workers=2), looked_at(plane, said)
    whole &= middles != -9
    np.testing.assert_array_equal(labels[whole], middles[whole])
    assert whole.sum() > 2 * (~whole).sum()
    assert len(set(labels[whole].tolist())) >= 2


def test_contact_chart_agrees_with_flutter():
    """Of a (k_c, c_c) chart, against the exact curve of flutter.

    The first motion begins next to steady sliding, so that it comes back to it where that is stable, and nowhere else.
    """
    names = "contact_stiffness", "contact_damping"
    plane = Plane.of(threads_drive(mass=9), (names[0], 1e5, 1e9, 6), (names[1], 3e3, 1e9, 6))
    labels, flutter = plane.labels(), _function(plane.drive, ChartBoundary.FLUTTER, names)  # zero on the curve
    stable, whole = looked_at(plane, lambda k, c: flutter(k, c) > 0)
    whole &= labels != Behaviour.UNRESOLVED  # one of the two motions is chaotic or too slow
    comes_back = np.isin(labels, [Behaviour.NO_VIBRATION, Behaviour.COEXISTENCE, Behaviour.VIBRATION_FROM_REST])
    np.testing.assert_array_equal(comes_back[whole], stable[whole])
    assert set(stable[whole].tolist()) == {True, False}
    assert whole.sum() > 22


def test_points_of_curves_are_roots():
    """Both sides of a point of a curve have different labels."""
    drive = lsvib.Drive(translation_damping=1000.0)
    found = boundary_curves(drive, ("mass", (0.5, 14.0)), ("axial_force", (-60.0, 80.0)))
    assert {kind.name for kind in found} == {
        "KINEMATIC_CONSTRAINT", "ONSET", "STICK", "DETACH", "GLOBAL_STABILITY", "EVEN_SPEED"
    }  # fmt: skip
    mass = drive.threshold("kinematic_constraint", "mass").value
    np.testing.assert_allclose(np.concatenate(found[ChartBoundary.KINEMATIC_CONSTRAINT])[:, 0], mass, rtol=1e-12)
    for kind in (ChartBoundary.STICK, ChartBoundary.DETACH, ChartBoundary.GLOBAL_STABILITY):
        for m, R in np.concatenate(found[kind])[::9]:
            exact = threshold_force(drive.replace(mass=m), kind.name.lower())
            assert exact == pytest.approx(R, rel=1e-10)


def test_chart_is_a_dataset(tmp_path):
    drive = lsvib.Drive(input_speed=30)
    found = drive.chart(("mass", 1, 12, 8), "axial_force=0:60:6")
    assert found.label.dims == ("axial_force", "mass")
    assert found.label.dtype == np.int8
    assert found.label.attrs["flag_meanings"].split()[
        int(found.label.sel(mass=2, axial_force=30, method="nearest")) + 1
    ]
    assert found.fraction.sum() == pytest.approx(1)
    assert {"mass", "axial_force"}.isdisjoint(json.loads(found.attrs["parameters"]))
    write_dataset(found, tmp_path / "chart.nc")
    with xr.open_dataset(tmp_path / "chart.nc") as written:
        np.testing.assert_array_equal(written.label, found.label)
        assert written.input_speed == 30
        assert "git_commit" in written.attrs
    plane = Plane.of(drive, ("mass", 1, 12, 8), ("axial_force", 0, 60, 6))
    np.testing.assert_array_equal(plane.labels(workers=3), found.label)


def test_the_chart_of_the_workflow_is_the_chart(tmp_path):
    settings = {
        "drive": {"input_speed": 30.0},
        "x": {"parameter": "mass", "start": 1.0, "stop": 15.0, "count": 7},
        "y": {"parameter": "axial_force", "start": 0.0, "stop": 60.0, "count": 5},
    }
    write_chart(settings, tmp_path / "chart.nc")
    whole = lsvib.Drive(input_speed=30).chart("mass=1:15:7", "axial_force=0:60:5")
    with xr.open_dataset(tmp_path / "chart.nc") as written:
        assert set(whole.variables) == set(written.variables)
        for name in whole.variables:
            np.testing.assert_array_equal(written[name], whole[name])


def test_flutter_is_traced_through_the_force_at_which_no_law_holds():
    """Nodes on R = 0 were a refusal. There the law changes, and with it the stability of drives beyond a mass."""
    drive = threads_drive(contact_damping=5e4)
    critical = drive.threshold("onset", "mass").value
    found = boundary_curves(drive, ("mass", (5.0, 15.0)), ("axial_force", (-60.0, 60.0)))
    (line,) = found[ChartBoundary.FLUTTER]
    on_zero = np.abs(line[:, 1]) < 1e-9
    assert on_zero.sum() > 10
    assert (line[on_zero, 0] > critical * (1 - 1e-12)).all()
    np.testing.assert_allclose(line[~on_zero, 0], critical, rtol=1e-11)
    assert line[~on_zero, 1].max() == 60.0


def test_without_any_force_there_is_no_curve_of_flutter():
    drive = threads_drive(contact_damping=5e4, axial_force=0.0)
    assert not boundary_curves(drive, ("mass", (5.0, 15.0)), ("contact_stiffness", (1e6, 1e9)))
