"""Every figure: its checks pass, and refuse spoiled data; its file alone gives a picture, and repeats its motions.

Figures 8.1 to 8.15 and those that the book describes without a picture, on draft settings.
"""

from collections import defaultdict

import numpy as np
import pytest
import xarray as xr
from references.bodies import Bodies
from references.figure_checks import (
    assert_drawn_from_file,
    assert_listed_checks_exist,
    checks_of,
    dataset_of,
    scale,
    set_to,
)
from scipy.integrate import solve_ivp

from lsvib.basins.boundary import Boundary
from lsvib.contact.contact_force import ForceOutcome
from lsvib.datasets.attributes import ASSUMED, FIELDS, NO_EFFECT, VARIED, origin_of
from lsvib.datasets.io import write_dataset
from lsvib.datasets.newton import residual
from lsvib.dynamics.attractor import Attractor
from lsvib.figures import style
from lsvib.figures.configuration import default_figures
from lsvib.figures.limit_process import BranchVerdict
from lsvib.models.drive import Drive
from lsvib.models.names import Event
from lsvib.stability.linear import Stability, UndampedClass

NO_GROWTH, GROWTH = (set_to("growth_rate_of_steady_sliding", rate) for rate in (-1.0, 1.0))
STRAIGHT, TO_ORIGIN = set_to("probe_later_events", 0), set_to("probe_attractor", Attractor.STEADY_SLIDING)
SPOILED = [  # figure, words of a check, and what it must refuse; below, those that the chapter's list rests on
    ("fig8_01", "exactly inside the loop", set_to("grid_outcome", ForceOutcome.BOUNDED, 0, 0, 0)),
    ("fig8_02", "Every start ends growing", set_to("grid_outcome", ForceOutcome.BOUNDED, 1, 3, 3)),
    ("fig8_03", "Steady sliding is stable exactly where", set_to("stability", Stability.UNSTABLE_NODE, -1, -1)),
    ("fig8_04", "unstable by its eigenvalues", set_to("eigenvalue_real_part", -1.0)),
    ("fig8_05", "settles on the origin", set_to("attractor", Attractor.OTHER_CYCLE, 0, 1, 0)),
    ("fig8_06", "first touches rest", scale("stick_force", 1.03)),
    ("fig8_07", "existence analysis", set_to("existence", 1, 10, 10)),
    ("fig8_08", "Critical mass, root of", scale("critical_mass", 1.03)),
    ("fig8_09", "one sprag-slip cycle", scale("amplitude", 1 + 1e-9, 1, 1, 1)),
    ("fig8_10", "Peak of the contact force", scale("peak_normal_force", 1.03)),
    ("fig8_11", "amplitude falls", scale("amplitude", 2.0, 2, 0, 0)),
    ("fig8_12", "axial contact force", scale("mean_axial_contact_force", 1 + 1e-9, 0, 5)),
    ("fig8_13", "repeats to 1e-9", set_to("period_residual", 1e-8, 1)),
    ("fig8_14", "(a) m = 10 kg", set_to("event_kind", Event.STICK, 0, 0)),
    ("fig8_15", "root of Γ̃_0", scale("critical_friction", 1.03)),
    ("limit_process", "rules of resuming part", set_to("rule_followed", BranchVerdict.BOTH)),
    ("basin_sweep", "Over the damping", set_to("boundary_kind_support_damping", Boundary.CYCLE, -1)),
    ("contact_stability", "With enough contact damping", scale("least_contact_damping", 0.1)),
    ("falling_friction", "Chatter that has begun", set_to("attractor", Attractor.STEADY_SLIDING, 1)),
    ("measured_drive", "leaves at most 0.045 mN m", scale("residual", 1.5)),
    ("stribeck_rise", "The rise leaves the onset force", scale("stick_force", 0.5, 0)),
    (
        "nut_stability",
        "kinematic exactly where (8.33) holds",
        set_to("stability", UndampedClass.KINEMATIC_CONSTRAINT, 0, 0),
    ),
    ("fig8_01", "that grow end in exponential growth", scale("contact_force_rate", 1.1)),
    ("fig8_03", "are those of (8.4)", scale("effective_inertia_plus", 1.001)),
    ("fig8_03", "the one sign of N_0", scale("swept_effective_inertia", 1.001)),
    ("fig8_03", "Law − has Γ₋ > I", scale("effective_inertia_minus", -1)),
    ("fig8_03", "takes μ > tan λ", set_to("effective_inertia_plus", -1.0)),
    ("fig8_03", "With R against the motion", GROWTH),
    ("fig8_03", "Some state has no contact force", set_to("without_solution", 0)),
    ("fig8_03", "three conditions of (8.21)", set_to("growth_rate_of_steady_sliding", 1.0, -1, -1, 0, 0)),
    ("fig8_03", "three conditions of (8.19)", scale("swept_effective_damping", -1)),
    ("fig8_03", "necessary for each instability", GROWTH),
    ("fig8_03", "can be negative where μ > tan λ", set_to("swept_effective_damping", -1.0)),
    ("fig8_03", "alone makes unstable", NO_GROWTH),
    ("fig8_04", "Where N > 0 the motions follow", scale("normal_force", -1)),
    ("fig8_04", "Where N > 0 the motions follow", scale("axial_force", 1.05)),
    ("fig8_05", "tends to N_0", scale("normal_force", 1.01)),
    ("fig8_06", "self-locking", set_to("holds_without_torque", 1)),
    ("fig8_06", "moves towards the origin", set_to("contact_line_angle", 0.1)),
    ("fig8_06", "Newton's laws of screw", scale("normal_force", 1.01)),
    ("fig8_06", "At R = 25 N", set_to("attractor", Attractor.STEADY_SLIDING)),
    ("fig8_07", "need not resume at once", set_to("rest_after_seizure", 0.0)),
    ("fig8_07", "opposite to the assumed one", scale("mass", 0.9)),
    ("fig8_07", "the energy about u_0", scale("equilibrium_angle", 0.5)),
    ("fig8_09", "stationary solution of (8.7)", scale("normal_force", 1.01)),
    ("fig8_09", "tends to N_0", scale("normal_force", 1.01)),
    ("fig8_09", "tends to z_0", scale("coupling_deflection", 1.01)),
    ("fig8_11", "Every motion that reaches N = 0 seizes", set_to("event_kind", Event.CONTACT_REVERSAL, 1, 0, 1)),
    ("fig8_12", "considerable effect", set_to("mean_deflection", -0.1)),
    ("fig8_14", "From N > 0 and θ′ > 0", set_to("probe_velocity_after", 0.0)),
    ("fig8_14", "From N < 0 and θ′ < 0", set_to("probe_velocity_after", 0.0)),
    ("fig8_14", "by some starts, not by all", lambda dataset: TO_ORIGIN(STRAIGHT(dataset))),
    ("fig8_14", "that do not touch N = 0", set_to("probe_attractor", Attractor.SPRAG_SLIP_CYCLE)),
    ("fig8_14", "Every trajectory that reaches N = 0", scale("event_velocity_deviation_after", 0.99)),
    ("fig8_14", "The corner is the printed one", scale("seizure_distance", 1e6)),
    ("fig8_15", "exactly where (8.27) holds", scale("screw_mass", 1.1)),
    ("nut_stability", "Torque of the coupling at the deflection θ_0", scale("steady_deflection", 1.01)),
    ("nut_stability", "balance with θ_20", scale("steady_deflection", 1.01)),
    ("basin_sweep", "locally stable and yet lost", set_to("basin_area_axial_force", 0.0)),
    ("basin_sweep", "beyond m_cr at (a) alone", set_to("reading_fraction", 1.0)),
    ("contact_stability", "it still rises", scale("growth_rate", 100.0, 0, 0, -2)),
    ("limit_process", "brings the screw to a stand", set_to("stop_time", float("nan"))),
    ("limit_process", "N > 0 grows until the screw stands", set_to("indeterminate_event", Event.CONTACT_REVERSAL)),
    ("limit_process", "Short of the saddle", set_to("indeterminate_event", Event.STICK)),
    ("limit_process", "that of the chapter's formula", scale("formula_velocity", 1.2)),
]


@pytest.mark.parametrize(("figure", "words", "spoil"), SPOILED, ids=lambda x: x if isinstance(x, str) else "")
def test_a_check_refuses_spoiled_data(figure, words, spoil):
    found = [check.passed for check in checks_of(figure, spoil(dataset_of(figure))) if words in check.claim]
    assert found == [False]


@pytest.mark.parametrize("figure", default_figures())
def test_every_check_passes(figure):
    """And each claim that config/chapter.yaml says a figure checks is one of its checks; one is seen to fail."""
    checks = checks_of(figure, dataset_of(figure))
    assert checks
    assert figure in {name for name, *_ in SPOILED}
    assert [check.sentence() for check in checks if not check.passed] == []
    assert_listed_checks_exist(figure, checks)


@pytest.mark.parametrize("figure", default_figures())
def test_it_is_drawn_from_its_file(figure, tmp_path):
    """No variable of which is empty; and a motion in it is plotted over its time."""
    assert_drawn_from_file(figure, dataset_of(figure), tmp_path / "a.nc")
    file = xr.open_dataset(tmp_path / "a.nc")
    assert [name for name, own in file.variables.items() if own.dtype.kind == "f" and np.isnan(own).all()] == []
    if "time" in file:
        axes = style.new_figure().add_subplot()
        file.normal_force[(0,) * (file.time.ndim - 1)].plot(ax=axes, x="time")
        assert len(axes.get_title()) < 80


def test_a_name_has_one_meaning_in_all_files():
    found = defaultdict(set)
    for figure in default_figures():
        for name, variable in dataset_of(figure).variables.items():
            found[name].add((variable.attrs["units"], variable.attrs["long_name"]))
    assert {name: meanings for name, meanings in found.items() if len(meanings) > 1} == {}


@pytest.mark.parametrize("figure", default_figures())
def test_every_parameter_is_stated_with_its_origin(figure):
    dataset = dataset_of(figure)
    assert set(dict(Drive())) <= set(dataset.variables)
    for name in set(FIELDS) & set(dataset.variables):
        attributes = dataset[name].attrs
        known = ("printed: ", "given: ", ASSUMED, VARIED, NO_EFFECT)
        assert attributes["origin"].startswith(known), (name, attributes)
        assert attributes["symbol"], name
        assert attributes["origin"] != VARIED or dataset[name].ndim >= 1, name  # an axis, or along one


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
