"""Figures 8.3 and 8.8, the rounding of Table 8.1, stability over contact and nut, and the ablation.

Every check passes, each can fail, and the figure is drawn.
"""

import math

import numpy as np
import pytest
from references.figure_checks import (
    assert_drawn_from_file,
    assert_each_check_fails_on_some,
    dataset_of,
    draft,
    scale,
    set_to,
)

from benchmarks.figures.ablation import dataset as ablation
from lsvib.drives.parameters import RigidParameters
from lsvib.figures.fig8_03 import dataset as fig8_03
from lsvib.figures.table_rounding.dataset import PrintedThreshold
from lsvib.steady_sliding import input_rounding
from lsvib.steady_sliding.conditions import critical_mass
from lsvib.steady_sliding.eigenvalues_rigid import Stability
from lsvib.steady_sliding.eigenvalues_two_coordinates import UndampedClass
from lsvib.steady_sliding.solved_threshold import solve_threshold
from lsvib.steady_sliding.thresholds import onset_force


def test_each_check_of_figure_8_8_can_fail():
    spoilers = [
        scale("critical_mass", 1.03),
        scale("loss_of_stability", 1 + 1e-9, 0),
        set_to("eigenvalue_real_part", 1.0, 0, 0),
        set_to("eigenvalue_real_part", 1.0, slice(None), -1),
        scale("eigenvalue_imaginary_part", 0.9996),  # the largest sample of a grid that has none at the peak
        set_to("eigenvalue_imaginary_part", 1.0, 0, -1),
    ]
    assert_each_check_fails_on_some("fig8_08", dataset_of("fig8_08"), spoilers)


def test_each_check_of_the_rounding_can_fail():
    spoilers = [
        scale("print_residual", 20.0, PrintedThreshold.critical_mass),
        scale("print_residual", 5.0, PrintedThreshold.onset_force),
        scale("print_residual", 0.2, PrintedThreshold.detach_force),
        set_to("matching_detach_force", 46.6),
        set_to("matching_effective_damping_plus", -1.1e-4),
    ]
    assert_each_check_fails_on_some("table_rounding", dataset_of("table_rounding"), spoilers)


def test_rounding_is_the_derivative_times_half_a_unit():
    """Closed forms: m_cr = I / (xi tan(lambda) r_m²) is in proportion to I and 1 / r_m², the onset to Omega and r_m."""
    drive = RigidParameters.of(translation_damping=1e3)
    change = input_rounding.propagated(solve_threshold(drive, "kinematic"))
    value = critical_mass(drive)
    assert change["screw_inertia"] == pytest.approx(value * 0.005 / 3.12, rel=1e-14)
    assert change["pitch_radius"] == pytest.approx(-2 * value * 0.005 / 5.18, rel=1e-14)
    assert [change[name] for name in input_rounding.ROUND] == [0.0, 0.0, 0.0]
    change = input_rounding.propagated(solve_threshold(drive, "onset"))
    assert change["input_speed"] == pytest.approx(onset_force(drive) * 0.5 / 40, rel=1e-14)
    tangent, step = math.tan(drive.lead_angle), math.radians(0.005)
    expected = onset_force(drive) * step * (1 + tangent**2) / tangent
    assert change["lead_angle_deg"] == pytest.approx(expected, rel=1e-14)


def test_each_check_of_the_contact_stability_can_fail():
    spoilers = [
        set_to("critical_mass_with_contact", 7.0, 1),
        scale("critical_mass_with_contact", 1.001, 2),
        set_to("curve_critical_mass_with_contact", 10.2, 2, 5),
        set_to("growth_rate", -1.0, 0, 0, -1),
        scale("growth_scale", 1.1),
        scale("elastic_growth_limit", 1.1),
        scale("least_contact_damping", 0.1),
        scale("growth_rate", -1.0, 1, 0, 3),
        scale("window_of_soft_contact", 1.01, 0, 1),
    ]
    assert_each_check_fails_on_some("contact_stability", dataset_of("contact_stability"), spoilers)


def test_contacts_are_those_of_figures_8_10_and_8_13():
    contacts = draft("contact_stability")["contacts"]
    first = draft("fig8_10")
    assert contacts == [{key: first[key] for key in contacts[0]}, *draft("fig8_13")["contacts"]]


def test_each_check_of_the_nut_stability_can_fail():
    spoilers = [
        set_to("stability", UndampedClass.KINEMATIC, 0, 0),
        set_to("stability", UndampedClass.FLUTTER, -1, -1),
        scale("boundary_nut_inertia", 10.0),
        scale("critical_mass_with_nut", 1 + 1e-9, 3),
        scale("critical_mass_with_nut_by_eigenvalues", 1 + 1e-8, 3),
        set_to("critical_mass_with_nut", 20.0, -1),
        scale("critical_friction_with_nut", 1 + 1e-9, 7),
    ]
    assert_each_check_fails_on_some("nut_stability", dataset_of("nut_stability"), spoilers)


@pytest.mark.parametrize("figure", ["fig8_03", "fig8_08", "table_rounding", "contact_stability", "nut_stability"])
def test_is_drawn(figure, tmp_path):
    assert_drawn_from_file(figure, dataset_of(figure), tmp_path / "a.nc")


def test_each_check_of_figure_8_3_can_fail(monkeypatch):
    """One of them judges the closed form itself, at the places of the dataset: it is spoiled instead of the data."""

    def wrong_eigenvalues(dataset):
        right = fig8_03.eigenvalues
        monkeypatch.setattr(fig8_03, "eigenvalues", lambda *arguments: right(*arguments) * (1 + 1e-6))
        return dataset

    spoilers = [
        set_to("stability", Stability.UNSTABLE_NODE, -1, -1),
        set_to("stability", Stability.STABLE_FOCUS, 0, 0),
        scale("node_focus_effective_damping", 1 + 1e-11, 0),
        wrong_eigenvalues,
    ]
    assert_each_check_fails_on_some("fig8_03", dataset_of("fig8_03"), spoilers)


def test_ablation(monkeypatch, tmp_path):
    """Times are put in by hand: one run on a busy machine proves nothing, and to compile takes ten seconds."""
    monkeypatch.setattr(ablation, "compilation", lambda kinds: (10 * len(kinds), 3.0 * len(kinds)))
    dataset = ablation.build({"duration": 0.05, "repeats": 1, "compile": ["planar", "modal"]})
    assert dataset.specialisations.values.tolist() == [10, 20]
    for name in ("run_time", "build_time", "import_time"):
        assert (dataset[name] > 0).all()
    dataset.run_time[:], dataset.build_time[:] = np.array([1e-3, 2e-3]), np.array([1e-3, 2e-3])
    spoilers = [
        set_to("same_events", 0, 0),
        set_to("difference", 1e-11, -1),
        set_to("run_time", 3e-3, 1, 0),
        set_to("build_time", 3e-3, 1, 0),
        set_to("loads", 1),
    ]
    assert_each_check_fails_on_some("ablation", dataset, spoilers)
    assert_drawn_from_file("ablation", dataset, tmp_path / "a.nc")
