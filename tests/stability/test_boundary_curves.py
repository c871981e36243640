"""The curve of flutter in charts of compliant threads."""

import numpy as np
from references.parts import threads_drive

from lsvib.stability import curves


def test_flutter_is_traced_through_the_force_at_which_no_law_holds():
    """Nodes on R = 0 were a refusal. There the law changes, and with it the stability of drives beyond a mass."""
    drive = threads_drive(contact_damping=5e4)
    critical = drive.threshold("onset", "mass").value
    found = curves.boundary_curves(drive, ("mass", (5.0, 15.0)), ("axial_force", (-60.0, 60.0)))
    (line,) = found[curves.ChartBoundary.FLUTTER]
    on_zero = np.abs(line[:, 1]) < 1e-9
    assert on_zero.sum() > 10
    assert (line[on_zero, 0] > critical * (1 - 1e-12)).all()
    np.testing.assert_allclose(line[~on_zero, 0], critical, rtol=1e-11)
    assert line[~on_zero, 1].max() == 60.0


def test_without_any_force_there_is_no_curve_of_flutter():
    drive = threads_drive(contact_damping=5e4, axial_force=0.0)
    assert not curves.boundary_curves(drive, ("mass", (5.0, 15.0)), ("contact_stiffness", (1e6, 1e9)))
