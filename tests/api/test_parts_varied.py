"""Parameters of parts and frictions against the ground, varied from a drive that does not have them."""

import json

import numpy as np
import pytest

import lsvib

PARADOX = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18.37)
CONTACT = {"contact_stiffness": (1e4, 1e9, 3), "contact_damping": (1.0, 1e9, 3)}


def test_a_chart_over_the_contact_is_that_of_compliant_threads():
    axes = [(name, *span) for name, span in CONTACT.items()]
    found = lsvib.Drive(mass=9).chart(*axes)
    right = lsvib.Drive(mass=9, contact_stiffness=1e6, contact_damping=1e6).chart(*axes)
    np.testing.assert_array_equal(found.label.values, right.label.values)
    np.testing.assert_array_equal(found.boundary_name.values, right.boundary_name.values)
    assert found.attrs["parts"] == "threads"


def test_a_chart_that_only_some_of_its_drives_could_have_is_refused():
    with pytest.raises(
        lsvib.InputError, match="charts are for rigid drives without friction of slide, bearing and collar"
    ):
        lsvib.Drive(mass=2).chart(("slide_friction", 0, 20, 3), ("axial_force", 10, 60, 3))


def test_a_sweep_says_the_parts_that_it_varies():
    found = lsvib.Drive().sweep(start={"u": 0.0, "w": 1.0, "e": 0.0}, contact_stiffness=[1e6, 1e7])
    assert found.attrs["parts"] == "threads"
    assert json.loads(found.attrs["parameters"])["contact_damping"] == 0.0


def test_resilience_has_no_number_where_the_basin_has_no_closed_form():
    found = PARADOX.resilience_sweep(slide_friction=[0.0, 5.0])
    assert found.fatal_speed.values[0] == PARADOX.resilience().speed
    assert np.isnan(found.fatal_speed.values[1])
    assert "for rigid drives only" in found.attrs["refused"]
    assert np.isnan(PARADOX.resilience_sweep(contact_stiffness=[1e6]).fatal_speed.values[0])


def test_a_cycle_is_followed_from_a_rigid_drive_to_friction_of_its_slide():
    """The tables of both are of different kinds; the end is what the cycle of that drive is by itself."""
    drive = PARADOX.replace(axial_force=-10)
    cycle = next(cycle for cycle in drive.cycles().cycles if cycle.attracting)
    branch = drive.follow(cycle, "slide_friction", (0.0, 0.3), points=60)
    last = max(branch.points, key=lambda point: point.value)
    own = drive.replace(slide_friction=last.value).cycles().cycles
    assert last.value == 0.3
    assert min(abs(one.period / last.cycle.period - 1) for one in own) < 1e-9


def test_what_a_drive_does_not_have_is_no_reason():
    cycle = PARADOX.cycles().cycles[0]
    with pytest.raises(
        lsvib.InputError, match="contact_stiffness is a parameter of compliant threads, which this drive"
    ):
        PARADOX.follow(cycle, "contact_stiffness", (1e6, 1e8))
    found = lsvib.Drive().thresholds("slide_friction")
    assert "closed form without friction of slide, bearing and collar only" in found["stick"].reason
    assert "does not depend on" in found["negative_damping"].reason
    with pytest.raises(lsvib.InputError, match="list rest"):
        lsvib.Drive(slide_friction=2.0).simulate(
            {"u": 0, "w": 0}, 0.1, physics=["axial_force", "support_damping", "slide_friction"]
        )
