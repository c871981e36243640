"""The dataset of a figure, read by a stranger: its motion can be repeated from the file alone."""

import numpy as np
import pytest
import xarray as xr
from references.bodies import Bodies
from references.figure_checks import dataset_of, scale
from scipy.integrate import solve_ivp

from lsvib.datasets.attributes import ASSUMED, origin_of
from lsvib.datasets.io import write_dataset
from lsvib.datasets.newton import residual
from lsvib.figures import style
from lsvib.figures.configuration import default_figures
from lsvib.models.drive import Drive


def test_origin_says_which_values_are_printed():
    assert origin_of("support_damping", 2e-4) == "printed: Table 8.1"
    assert origin_of("support_damping", 1e-3) == ASSUMED
    assert origin_of("support_damping", 1e-3, ["Fig. 8.14"]) == "printed: Fig. 8.14"
    assert origin_of("mass", [10.0, 11.0], ["Fig. 8.14"]) == f"{ASSUMED}, except 10 (printed: Fig. 8.14)"
    assert origin_of("mass", [10.0, 11.0], ["Sect. 8.6.1"]) == "printed: Sect. 8.6.1"
    assert origin_of("mass", 1.0) == ASSUMED


@pytest.mark.parametrize(("figure", "case"), [("fig8_04", 0), ("fig8_05", 0), ("fig8_06", 1)])
def test_a_motion_is_repeated_from_its_file_alone(figure, case, tmp_path):
    """The stated drive, integrated from the stated start by somebody else's solver, gives the motions of the file."""
    write_dataset(dataset_of(figure), tmp_path / "figure.nc")
    file = xr.open_dataset(tmp_path / "figure.nc").isel(case=case)
    laws = Bodies(Drive(**{name: float(file[name]) for name in dict(Drive())}))

    def mode_at(state):
        """The direction of slip and the sign of N, which that of N solved for has to be."""
        mode = {"slip": np.sign(state[1]), "contact": 1}
        return mode if laws.forces(state, mode)["N"] >= 0 else {**mode, "contact": -1}

    for start in range(file.sizes["start"]):
        motion = file.isel(start=start)
        time, deflection = motion.time.values, motion.coupling_deflection.values
        speed = motion.velocity_deviation.values + laws.p["input_speed"]

        def rate(_, state):
            return laws.rate(0, state, mode_at(state))

        times, which = np.unique(time, return_inverse=True)
        first = [deflection[0], speed[0]]
        found = solve_ivp(rate, times[[0, -1]], first, "DOP853", times, rtol=1e-9, atol=1e-12).y[:, which]
        assert np.abs(found[0] - deflection).max() < 1e-6 * np.ptp(deflection)
        assert np.abs(found[1] - speed).max() < 1e-5 * np.ptp(speed)
        force = [laws.forces(state, mode_at(state))["N"] for state in zip(deflection, speed, strict=True)]
        assert np.abs(force - motion.normal_force).max() < 1e-9 * np.abs(force).max()


@pytest.mark.parametrize("figure", default_figures())
def test_each_motion_is_plotted_over_its_time_and_nothing_is_empty(figure, tmp_path):
    write_dataset(dataset_of(figure), tmp_path / "figure.nc")
    file = xr.open_dataset(tmp_path / "figure.nc")
    assert [name for name, own in file.variables.items() if own.dtype.kind == "f" and np.isnan(own).all()] == []
    if "time" in file:
        force = file.normal_force[(0,) * (file.time.ndim - 1)]
        axes = style.new_figure().add_subplot()
        force.plot(ax=axes, x="time")
        assert len(axes.get_title()) < 80


@pytest.mark.parametrize("name", ["normal_force", "velocity_deviation", "angle_deviation", "coupling_deflection"])
def test_a_sample_that_is_off_shows(name):
    """The residual of Newton's laws sees a small error in any part of a stored motion, and none in a right one."""
    motion = dataset_of("fig8_09").isel(case=1, start=0)
    assert residual(motion) < 1e-12
    largest = int(abs(motion[name].values).argmax())
    assert residual(scale(name, 1 + 1e-6, largest)(motion)) > 1e-7


@pytest.mark.parametrize("name", ["mass", "friction_coefficient", "screw_inertia", "support_damping", "axial_force"])
def test_a_parameter_that_is_not_the_one_of_the_motion_shows(name):
    assert residual(scale(name, 1 + 1e-6)(dataset_of("fig8_09").isel(case=1, start=0))) > 1e-9
