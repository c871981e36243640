"""The nodes through which the curves of charts are traced."""

import numpy as np
from references.wide_drives import wide_drive

import lsvib
from lsvib.cycles.ending_numbers import Endings
from lsvib.steady_sliding import boundary_curves
from lsvib.steady_sliding.boundary_curves import _after_rest, nodes_between, stops_again


def test_slip_after_rest_is_not_followed_to_a_slow_cycle(monkeypatch):
    """The cycles of this drive attract slowly: one took 20 ms to be found, and the nodes of a chart a minute."""

    def refuse(*_, **__):
        raise AssertionError("the end of a single motion was searched")

    monkeypatch.setattr("lsvib.cycles.endings_of_models.rigid.steady_state", refuse)
    names = "axial_force", "translation_damping"
    nodes = [nodes_between(-0.0226, 0.0226, 12, names[0]), nodes_between(5.144, 41.96, 12, names[1])]
    drive = wide_drive("rigid", 555, 17, 1).drive
    values = _after_rest(drive, names, nodes)
    assert np.isfinite(values).sum() > 40
    for j, i in np.argwhere(np.isfinite(values))[::17]:
        assert values[j, i] == stops_again(drive.replace(axial_force=nodes[0][i], translation_damping=nodes[1][j]))


def test_slip_after_rest_stops_where_motions_from_rest_end_on_a_cycle(monkeypatch):
    """What the search leaves open is decided by the slip alone, and alike."""
    drive, names = lsvib.RigidDrive(translation_damping=1000.0), ("mass", "axial_force")
    nodes = [nodes_between(0.5, 14.0, 60, "mass"), nodes_between(-60.0, 80.0, 60, "axial_force")]
    by_ends = _after_rest(drive, names, nodes)
    assert {-1.0, 1.0} <= set(by_ends[np.isfinite(by_ends)])

    def all_open(drives, *_):
        return Endings.unknown(drives.size), np.ones(drives.size, dtype=bool)

    monkeypatch.setattr(boundary_curves, "endings_at_once", all_open)
    np.testing.assert_array_equal(_after_rest(drive, names, nodes) > 0, by_ends > 0)


def test_flutter_is_traced_through_the_force_at_which_no_law_holds():
    """Nodes on R = 0 were a refusal. There the law changes, and with it the stability of drives beyond a mass."""
    drive = lsvib.ThreadsDrive(contact_damping=5e4)
    critical = drive.thresholds()["critical_mass"].value
    found = boundary_curves.boundary_curves(drive, ("mass", (5.0, 15.0)), ("axial_force", (-60.0, 60.0)))
    (line,) = found[boundary_curves.ChartBoundary.FLUTTER]
    on_zero = np.abs(line[:, 1]) < 1e-9
    assert on_zero.sum() > 10
    assert (line[on_zero, 0] > critical * (1 - 1e-12)).all()
    np.testing.assert_allclose(line[~on_zero, 0], critical, rtol=1e-11)
    assert line[~on_zero, 1].max() == 60.0


def test_without_any_force_there_is_no_curve_of_flutter():
    drive = lsvib.ThreadsDrive(contact_damping=5e4, axial_force=0.0)
    assert not boundary_curves.boundary_curves(drive, ("mass", (5.0, 15.0)), ("contact_stiffness", (1e6, 1e9)))
