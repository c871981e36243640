"""Friction laws in every model: against constant friction, and against Newton's laws with adaptive steps."""

import numpy as np
import pytest

from lsvib.dynamics.attractor import Attractor
from lsvib.dynamics.sweep import all_endings, ending_of
from lsvib.models.drive import RigidDrive, ThreadsDrive
from lsvib.models.many import ManyDrives
from lsvib.models.model import find_model


@pytest.mark.parametrize("kind", [RigidDrive, ThreadsDrive])
def test_a_sweep_makes_drives_with_a_law_one_by_one(kind):
    """Drives with and without a law in one sweep end as each alone; tables of many hold to 1e-12, not to the bit."""
    law = {"stribeck_rise": 0.06, "stribeck_speed": 0.05}
    laws = [{}, law, {"friction_slope": -0.05}, {"static_friction_coefficient": 0.3}, law | {"stribeck_exponent": 2}]
    drives = [kind(mass=mass, support_damping=2e-3, axial_force=40, **law) for law in laws for mass in (1, 3)]
    many = ManyDrives({name: [getattr(drive, name) for drive in drives] for name in kind.model_fields}, kind)
    starts = np.tile([0.05, -20.0], (len(drives), 1))
    found, model = all_endings(many, starts, "contact_sign"), find_model(kind.model)
    for place, drive in enumerate(drives):
        automaton = model.build(drive, model.physics_of(drive), "contact_sign")
        alone = ending_of(drive, automaton, model.initial_state(drive, {"u": 0.05, "w": -20.0}))
        one = [column[place] for column in found]
        assert one[:2] == list(alone[:2])
        np.testing.assert_allclose(one[2:], alone[2:], rtol=1e-9)
    assert Attractor.UNRESOLVED not in found.attractor
