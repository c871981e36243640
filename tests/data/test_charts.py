"""Charts: labels that two motions give each cell are those that the exact thresholds give, wherever no curve passes."""

import json
import math
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import lsvib
from lsvib.cycles.behaviour import Behaviour
from lsvib.data import chart as charts
from lsvib.data.chart import ChartAxis, Plane
from lsvib.data.chart_tiles import chart_tile, gather_chart
from lsvib.data.writer import write_dataset
from lsvib.drives.coefficients import coefficients
from lsvib.errors import NoThreshold
from lsvib.figures.chart.picture import draw
from lsvib.steady_sliding import thresholds
from lsvib.steady_sliding.boundary_curves import ChartBoundary, _function, boundary_curves, stops_again

DAMPED = {"support_damping": 1e-3, "translation_damping": 300.0}
PAIRS = {  # of parameters, with the ends of both axes and the drive
    "mass over force": (("mass", 0.5, 14.0), ("axial_force", -60.0, 80.0), {"translation_damping": 1000.0}),
    "friction over force": (("friction_coefficient", 0.02, 0.6), ("axial_force", -60.0, 80.0), DAMPED | {"mass": 6.0}),
    "slide damping over force": (("translation_damping", 10.0, 1500.0), ("axial_force", -60.0, 80.0), {"mass": 4.0}),
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
        return getattr(thresholds, f"{name}_force")(drive)
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
        return Behaviour.NO_VIBRATION if R < way * end else Behaviour.COEXISTENCE
    if c.damping[1] >= 0:
        return Behaviour.NO_VIBRATION
    if not drags:
        return {1.0: Behaviour.COEXISTENCE, -1.0: Behaviour.NO_VIBRATION}.get(stops_again(drive))
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


def cell_by_cell(drive, names, columns, rows) -> np.ndarray:
    """What the thresholds say at every place of a grid (rows, columns); −9 where they do not cover it."""
    found = [[expected(drive.replace(**dict(zip(names, (a, b), strict=True)))) for a in columns] for b in rows]
    return np.array([[-9 if one is None else int(one) for one in row] for row in found])


def column_by_column(drive, names, columns, rows) -> np.ndarray:
    """The same where the rows are forces."""
    return np.stack([expected_over_force(drive.replace(**{names[0]: a}), np.array(rows)) for a in columns], axis=1)


def edges(axis: ChartAxis) -> np.ndarray:
    """The edges of the cells of an axis."""
    return axis.middles(np.arange(axis.count + 1) - 0.5)


def compare(plane: Plane, said=cell_by_cell) -> tuple[int, int, set[int]]:
    """Numbers of cells compared and left out because a curve cuts them, and the labels seen.

    A curve cuts a cell if what is ``said`` of its four corners and of its middle is not all alike.
    """
    labels, names = plane.labels(workers=2), (plane.x.name, plane.y.name)
    nodes, middles = (
        said(plane.drive, names, *(places.tolist() for places in axes))
        for axes in ((edges(plane.x), edges(plane.y)), (plane.x.centres(), plane.y.centres()))
    )
    corners = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[:-1, 1:], nodes[1:, 1:]])
    whole = (corners == middles).all(axis=0) & (middles != -9)
    wrong = np.argwhere(whole & (labels != middles))
    assert not len(wrong), (
        len(wrong),
        [
            (Behaviour(labels[i, j]).name, Behaviour(middles[i, j]).name, plane.x.centres()[j], plane.y.centres()[i])
            for i, j in wrong[:9]
        ],
    )
    return int(whole.sum()), int((~whole).sum()), set(labels[whole].tolist())


def plane_of(name: str, count: int) -> Plane:
    x, y, changes = PAIRS[name]
    return Plane.of(lsvib.RigidDrive(**changes), (*x, count), (*y, count))


@pytest.mark.parametrize("name", PAIRS)
def test_labels_agree_with_the_exact_curves(name):
    whole, cut, seen = compare(plane_of(name, 12 if name == "mass and friction" else 20))
    assert whole > 2 * cut
    assert len(seen) >= 2


def expected_over_force(drive, forces: np.ndarray) -> np.ndarray:
    """What the thresholds say of one drive under many forces; −9 where they do not cover it.

    Between the thresholds in R all is the same, so one force stands for all between two of them.
    """
    c, way = coefficients(drive), math.copysign(1.0, drive.input_speed)
    names = ["global_stability"] if c.paradox else ["stick", "detach"] if c.damping[1] < 0 else []
    ends = [
        value for value in (force(name, drive.replace(axial_force=0.0)) for name in names) if value.__class__ is float
    ]
    onset = drive.axial_force - float(c.net_force)
    if not c.paradox and c.damping[1] < 0:
        ends += birth(drive, onset, forces.min() if way > 0 else forces.max())
    ends = np.sort([-np.inf, *ends, onset, np.inf])
    found = np.empty(forces.size, dtype=int)
    for low, high in pairwise(ends):
        here = (low <= forces) & (forces < high)
        if here.any():
            one = expected(drive.replace(axial_force=float(np.median(forces[here]))))
            found[here] = -9 if one is None else int(one)
    return found


def birth(drive, onset: float, far: float) -> list[float]:
    """The force below the onset at which slip from the end of rest begins to come back to θ′ = 0, by bisection."""
    near = onset + 1e-6 * (far - onset)
    signs = [stops_again(drive.replace(axial_force=R)) for R in (near, far)]
    if signs[0] == signs[1] or (far - onset) * drive.input_speed >= 0:
        return []
    for _ in range(40):
        middle = 0.5 * (near + far)
        if stops_again(drive.replace(axial_force=middle)) == signs[0]:
            near = middle
        else:
            far = middle
    return [near]


@pytest.mark.long
@pytest.mark.parametrize("name", PAIRS)
def test_labels_agree_in_large_charts(name):
    """400 × 400 cells; a minute or two each, (m, μ) a quarter of an hour, because each cell has its own thresholds."""
    plane = plane_of(name, 400)
    whole, cut, _ = compare(plane, column_by_column if plane.y.name == "axial_force" else cell_by_cell)
    assert whole > 0.97 * (whole + cut)


def test_points_of_curves_are_roots():
    """Both sides of a point of a curve have different labels."""
    drive = lsvib.RigidDrive(translation_damping=1000.0)
    found = boundary_curves(drive, ("mass", (0.5, 14.0)), ("axial_force", (-60.0, 80.0)))
    assert {kind.name for kind in found} == {
        "KINEMATIC", "ONSET", "STICK", "DETACH", "GLOBAL_STABILITY", "STICK_SLIP_BIRTH"
    }  # fmt: skip
    mass = drive.thresholds()["critical_mass"].value
    np.testing.assert_allclose(np.concatenate(found[ChartBoundary.KINEMATIC])[:, 0], mass, rtol=1e-12)
    for kind in (ChartBoundary.STICK, ChartBoundary.DETACH, ChartBoundary.GLOBAL_STABILITY):
        for m, R in np.concatenate(found[kind])[::9]:
            exact = getattr(thresholds, f"{kind.name.lower()}_force")(drive.replace(mass=m))
            assert exact == pytest.approx(R, rel=1e-10)


@pytest.mark.parametrize("mass", [1.0, 11.0, 20.0])
@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_without_a_force_nothing_is_told_from_steady_sliding_itself(mass, damping):
    """Q = 0 passes through it, so a motion that starts in it says nothing of those beside it."""
    drive = lsvib.RigidDrive(support_damping=damping)
    found = drive.chart(("mass", mass - 0.1, mass + 0.1, 1), ("axial_force", -1, 1, 1))
    assert found.axial_force.item() == 0
    seizes, slides = Behaviour.SPRAG_SLIP, Behaviour.NO_VIBRATION if damping else Behaviour.NEUTRAL
    assert found.label.item() == (slides if mass < 10 else seizes)
    for start in ({"u": 1e-9, "w": 0}, {"u": -1e-9, "w": 0}, {"u": 0, "w": 1e-6}):
        settles = drive.replace(mass=mass, axial_force=0).steady_state(start).label == lsvib.Attractor.STEADY_SLIDING
        assert settles == (found.label.item() == Behaviour.NO_VIBRATION)


def test_chart_is_a_dataset(tmp_path):
    drive = lsvib.RigidDrive(translation_damping=1000)
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
        assert written.translation_damping == 1000
        assert "git_commit" in written.attrs
    plane = Plane.of(drive, ("mass", 1, 12, 8), ("axial_force", 0, 60, 6))
    np.testing.assert_array_equal(plane.labels(workers=3), found.label)
    np.testing.assert_array_equal(plane.labels(slice(2, 5), slice(3, 7)), found.label[2:5, 3:7])  # a tile


def compare_with_flutter(stiffness: tuple[float, float], damping: tuple[float, float], count: int) -> tuple[int, int]:
    """Numbers of cells of a (k_c, c_c) chart compared with the exact curve of flutter, and not resolved.

    A cell is compared if its four corners and its middle are alike. The first motion begins next to steady sliding, so
    that it comes back to it where that is stable, and nowhere else.
    """
    plane = Plane.of(
        lsvib.ThreadsDrive(mass=9), ("contact_stiffness", *stiffness, count), ("contact_damping", *damping, count)
    )
    labels = plane.labels(workers=2 if count > 20 else 1)

    flutter = _function(
        plane.drive, ChartBoundary.FLUTTER, ("contact_stiffness", "contact_damping")
    )  # zero on the curve

    def stable(columns, rows) -> np.ndarray:
        return np.array([[flutter(k, c) > 0 for k in columns] for c in rows])

    nodes = stable(edges(plane.x).tolist(), edges(plane.y).tolist())
    middles = stable(plane.x.centres().tolist(), plane.y.centres().tolist())
    corners = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[:-1, 1:], nodes[1:, 1:]])
    whole = (corners == middles).all(axis=0)
    comes_back = np.isin(labels, [Behaviour.NO_VIBRATION, Behaviour.COEXISTENCE])
    open_ends = labels == Behaviour.UNRESOLVED  # one of the two motions, chaotic or too slow
    np.testing.assert_array_equal(comes_back[whole & ~open_ends], middles[whole & ~open_ends])
    assert middles[whole].any()
    assert not middles[whole].all()
    return int(whole.sum()), int((whole & open_ends).sum())


def test_contact_chart_agrees_with_flutter():
    compared, unresolved = compare_with_flutter((1e5, 1e9), (3e3, 1e9), 6)
    assert compared > 24
    assert unresolved <= 2


@pytest.mark.long
def test_large_contact_chart_agrees_with_flutter():
    compared, unresolved = compare_with_flutter((1e5, 1e9), (3e3, 1e9), 400)
    assert compared > 150_000
    assert unresolved <= 0.02 * compared


@pytest.mark.slow
def test_processes_change_nothing(monkeypatch):
    """Labels and curves that processes share are those of one, in the same order."""
    drive, axes = lsvib.RigidDrive(translation_damping=1000), (("mass", 1, 12, 9), ("axial_force", 0, 60, 7))
    alone, told = drive.chart(*axes), []
    monkeypatch.setattr(charts, "_WORTH", 1)
    monkeypatch.setattr(charts, "_BLOCK", 18)
    xr.testing.assert_identical(drive.chart(*axes, workers=2, progress=lambda *n: told.append(n)), alone)
    assert told[-1] == (63, 63)


def test_both_readings_of_the_text_are_marked():
    """m = 1 or 8 kg of Sect. 8.5.1, 10 or 11 kg of Fig. 8.14: on charts of these drives, and on no others."""
    axes = ("mass", 0.5, 14.0, 2), ("axial_force", -60.0, 80.0, 2)
    for changes, masses in (
        ({"translation_damping": 1000.0}, [1.0, 8.0]), ({"support_damping": 1e-3}, [10.0, 11.0]),
        ({"support_damping": 1e-3, "axial_force": -10.0}, [10.0, 11.0]), ({"translation_damping": 999.0}, None),
    ):  # fmt: skip
        frame = Plane.of(lsvib.RigidDrive(**changes), *axes).frame(curves={})
        assert (frame.reading_mass.values.tolist() if "reading_mass" in frame else None) == masses
    plane = Plane.of(lsvib.RigidDrive(translation_damping=1000.0), axes[0], ("friction_coefficient", 0.1, 0.3, 2))
    assert plane.frame(curves={}).reading_mass.values.tolist() == [1.0, 8.0]
    assert "reading_mass" not in Plane.of(lsvib.RigidDrive(translation_damping=1000), axes[1], (
        "friction_coefficient", 0.1, 0.3, 2)).frame(curves={})  # fmt: skip
    found = lsvib.RigidDrive(translation_damping=1000).chart(*axes)
    texts = [text.get_text() for text in draw(found).axes[0].texts]
    assert sum("Sect. 8.5.1" in text for text in texts) == 2, texts


def test_a_chart_in_tiles_is_the_chart(tmp_path):
    settings = {
        "drive": {"translation_damping": 1000.0},
        "x": {"parameter": "mass", "start": 1.0, "stop": 5.0, "count": 7},
        "y": {"parameter": "axial_force", "start": 0.0, "stop": 60.0, "count": 5},
    }
    tiles = [str(tmp_path / f"{k}-of-4.nc") for k in range(1, 5)]
    for tile in tiles:
        chart_tile(settings, Path(tile).stem, tile)
    gather_chart(settings, tiles, tmp_path / "chart.nc")
    whole = lsvib.RigidDrive(translation_damping=1000).chart("mass=1:5:7", "axial_force=0:60:5")
    with xr.open_dataset(tmp_path / "chart.nc") as gathered:
        assert set(whole.variables) == set(gathered.variables)
        for name in whole.variables:
            np.testing.assert_array_equal(gathered[name], whole[name])
    with pytest.raises(lsvib.InputError, match="it needs parameter, start, stop and count"):
        chart_tile(settings | {"x": {"parameter": "mass"}}, "1-of-4", tiles[0])


@pytest.mark.parametrize(
    ("x", "y", "words"),
    [
        ("mass=1:20", "axial_force=0:1:2", "KEY=START:STOP:COUNT"),
        (("mass", 1, 2, 3), ("mass", 1, 2, 3), "both mass"),
        (("mass", 0, 2, 3), ("axial_force", 1, 2, 3), "mass = 0"),
        (("mass", 2, 1, 3), ("axial_force", 1, 2, 3), "start < stop"),
        (("weight", 1, 2, 3), ("axial_force", 1, 2, 3), "not a known key"),
        (("mass", 1, 2, 0), ("axial_force", 1, 2, 3), "count = 0"),
        (3, ("axial_force", 1, 2, 3), "is not a parameter with start"),
        (("mass", 1, 2, 20_000), ("axial_force", 1, 2, 20_000), "more than"),
        (("contact_damping", 1, 2, 3), ("axial_force", 1, 2, 3), "not a known key"),
    ],
)
def test_refuses(x, y, words):
    with pytest.raises(lsvib.InputError, match=words):
        lsvib.RigidDrive().chart(x, y)


def test_compliant_threads():
    """Stiff and damped contacts below the critical mass slide; soft ones with little damping flutter."""
    drive = lsvib.ThreadsDrive(mass=9)
    found = drive.chart(("contact_stiffness", 1e6, 1e9, 2), ("contact_damping", 1e2, 1e8, 2))
    least = (
        drive.replace(contact_stiffness=float(found.contact_stiffness[0])).thresholds()["least_contact_damping"].value
    )
    assert found.contact_damping[0] < least < found.contact_damping[1]
    assert (found.label[1] == Behaviour.NO_VIBRATION).all()
    assert found.label[0, 0] not in (Behaviour.NO_VIBRATION, Behaviour.UNRESOLVED)
    with pytest.raises(lsvib.InputError, match="rigid and threads"):
        lsvib.NutDrive().chart(("mass", 1, 2, 3), ("axial_force", 1, 2, 3))
