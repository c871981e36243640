"""The residual of Newton's laws sees a small error in any part of a stored motion, and none in a right one."""

import pytest
from references.figure_checks import dataset_of, scale

from lsvib.datasets.newton import residual


@pytest.mark.parametrize("name", ["normal_force", "velocity_deviation", "angle_deviation", "coupling_deflection"])
def test_a_sample_that_is_off_shows(name):
    motion = dataset_of("fig8_09").isel(case=1, start=0)
    assert residual(motion) < 1e-12
    largest = int(abs(motion[name]).argmax())
    assert residual(scale(name, 1 + 1e-6, largest)(motion)) == pytest.approx(1e-6, rel=0.1)


@pytest.mark.parametrize("name", ["mass", "friction_coefficient", "screw_inertia", "support_damping", "axial_force"])
def test_a_parameter_that_is_not_the_one_of_the_motion_shows(name):
    assert residual(scale(name, 1 + 1e-6)(dataset_of("fig8_09").isel(case=1, start=0))) > 1e-9


def test_a_rest_that_ends_too_early_shows():
    motion = dataset_of("fig8_06").isel(case=2, start=0)  # stick-slip
    assert residual(motion) < 1e-12
    standing = motion.velocity_deviation.values == -float(motion.input_speed)
    last = int(standing.argmin() if standing[0] else standing.argmax()) + int((~standing[standing.argmax() :]).argmax())
    cut = motion.isel(sample=[i for i in range(motion.sizes["sample"]) if i != last - 1])
    assert residual(cut) > 1e-4
