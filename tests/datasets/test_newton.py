"""The residual of Newton's laws sees a small error in any part of a stored motion, and none in a right one."""

import pytest
from references.figure_checks import dataset_of, scale

from lsvib.datasets.newton import residual


@pytest.mark.parametrize("name", ["normal_force", "velocity_deviation", "angle_deviation", "coupling_deflection"])
def test_a_sample_that_is_off_shows(name):
    motion = dataset_of("fig8_09").isel(case=1, start=0)
    assert residual(motion) < 1e-12
    largest = int(abs(motion[name].values).argmax())
    assert residual(scale(name, 1 + 1e-6, largest)(motion)) > 1e-7


@pytest.mark.parametrize("name", ["mass", "friction_coefficient", "screw_inertia", "support_damping", "axial_force"])
def test_a_parameter_that_is_not_the_one_of_the_motion_shows(name):
    assert residual(scale(name, 1 + 1e-6)(dataset_of("fig8_09").isel(case=1, start=0))) > 1e-9
