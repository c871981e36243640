"""Sweeps: every point is what its own drive gives, for any number of processes; thresholds lie where it changes."""

import json
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from references.parts import nut_drive, support_drive, threads_drive

import lsvib
from lsvib.dynamics.attractor import orbit_extremes
from lsvib.dynamics.impulses import event_impulses
from lsvib.engine.motion import follow

BASE = lsvib.Drive(translation_damping=1000)
START = {"u": 1e-3, "w": 0.0}


def assert_peaks(here, drive, motion, tolerance):
    low, high = orbit_extremes(motion, drive.automaton().observables["normal_force"])
    assert here.peak_normal_force.item() == pytest.approx(max(-low, high), rel=tolerance)
    impulses = np.abs(event_impulses(drive, motion).normal)
    assert here.peak_normal_impulse.item() == pytest.approx(impulses.max(initial=0.0), rel=tolerance, abs=1e-12)


def test_points_are_those_of_single_drives():
    """Random drives of all regimes, by long motions: amplitude, peak force and impulse once the motion has settled."""
    rng = np.random.default_rng(5)
    masses, forces = rng.uniform(0.5, 20, 5), rng.uniform(-60, 60, 6)
    drive = lsvib.Drive(support_damping=1e-3, translation_damping=300)
    found = drive.sweep(mass=masses, axial_force=forces, start={"u": 0.1, "w": 0.0})
    assert found.attractor.dims == ("mass", "axial_force")
    seen = set()
    for i, mass in enumerate(masses):
        for j, force in enumerate(forces):
            own, here = drive.replace(mass=mass, axial_force=force), found.isel(mass=i, axial_force=j)
            steady = own.steady_state({"u": 0.1, "w": 0.0})
            seen.add(steady.label)
            assert here.attractor == steady.label
            if steady.orbit is None:
                assert here.amplitude == 0
                row = own.automaton().observables["normal_force"][follow(own.automaton(), (0, 0), 1e-9).end_mode]
                assert here.peak_normal_force.item() == pytest.approx(abs(row[-1]), rel=1e-12)
                continue
            numbers = [steady.amplitude, steady.period, steady.multiplier]
            assert [here[name].item() for name in ("amplitude", "period", "multiplier")] == pytest.approx(
                numbers, rel=1e-9, nan_ok=True
            )
            late = follow(own.automaton(), steady.state, 3.5 * steady.period, mode=steady.orbit.start_mode)
            assert_peaks(here, own, late, 1e-6)
    assert {lsvib.Attractor.STEADY_SLIDING, lsvib.Attractor.SPRAG_SLIP_CYCLE} <= seen


def test_thresholds_lie_where_the_attractor_changes():
    for name, before, after in (("onset", 0, 3), ("stick", 3, 1)):
        threshold = BASE.threshold(name, "axial_force").value
        found = BASE.sweep(axial_force=[threshold * (1 - 1e-4), threshold * (1 + 1e-4)])
        assert found.attractor.values.tolist() == [before, after]


def test_same_bits_for_any_number_of_processes():
    forces = np.linspace(1.0, 60.0, 120)
    alone, told = BASE.sweep(axial_force=forces), []
    xr.testing.assert_identical(
        BASE.sweep(axial_force=forces, workers=2, progress=lambda *numbers: told.append(numbers)), alone
    )
    assert told[-1] == (120, 120)
    assert all(before[0] < after[0] <= after[1] == 120 for before, after in pairwise(told))
    order = np.random.default_rng(1).permutation(120)
    xr.testing.assert_identical(BASE.sweep(axial_force=forces[order]), alone.isel(axial_force=order))
    xr.testing.assert_identical(BASE.sweep(axial_force=forces[7:8]), alone.isel(axial_force=slice(7, 8)))


def test_any_parameter_can_be_swept():
    for name, value in lsvib.Drive():
        values = [value * 0.9, value * 1.1] if value else [1.0, 2.0]
        found = lsvib.Drive().sweep(**{name: values})
        assert found[name].attrs["units"]
        assert name not in json.loads(found.attrs["parameters"])
        for k, changed in enumerate(values):
            assert found.attractor[k] == lsvib.Drive(**{name: changed}).steady_state(START).label


def test_command(run):
    arguments = ["sweep", "--set", "translation_damping=1000", "--over", "axial_force=1:60:30"]
    code, out, _ = run(*arguments, "--over", "mass=1:2:2", "--out", "s.nc", "--json")
    result = json.loads(out)
    assert (code, result["points"]) == (0, 60)
    assert result["points_per_second"] > 0
    assert sum(result["attractors"].values()) == 60
    expected = BASE.sweep(axial_force=np.linspace(1, 60, 30), mass=np.linspace(1, 2, 2))
    with xr.open_dataset("s.nc") as written:
        assert all((written[name].values == expected[name].values).all() for name in ("attractor", "axial_force"))
        np.testing.assert_array_equal(written.amplitude, expected.amplitude)
    assert "points per second" in run(*arguments)[1]


@pytest.mark.parametrize(
    ("drive", "start"),
    [
        (threads_drive(mass=1, translation_damping=1000), {}),
        (threads_drive(mass=11, contact_damping=3e7), {"e": 1e-7, "v": 0.01}),
        (support_drive(mass=15, friction_coefficient=0.3, support_damping=1e-3), {"screw_shift": 1e-6}),
        (nut_drive(mass=6), {}),
    ],
)
def test_points_with_four_states_are_those_of_single_drives(drive, start):
    """Labels are equal; numbers agree to the rounding of tables that are made in other ways."""
    forces, begin = np.linspace(5.0, 55.0, 3), {"u": 1e-3, "w": 0.0} | start
    found = drive.sweep(axial_force=forces, start=begin)
    for k, value in enumerate(forces):
        own, here = drive.replace(axial_force=value), found.isel(axial_force=k)
        steady = own.steady_state(begin)
        assert here.attractor == steady.label
        if steady.label == lsvib.Attractor.UNRESOLVED:
            assert np.isnan(here.amplitude)
            continue
        assert here.amplitude.item() == pytest.approx(steady.amplitude, rel=1e-9)
        assert here.period.item() == pytest.approx(steady.period, rel=1e-9, nan_ok=True)
        if steady.orbit is not None:
            assert_peaks(here, own, steady.orbit, 1e-9)


def test_pairs_of_lead_angle_and_friction_are_checked():
    """μ < cot λ couples the two axes: every pair must be acceptable, though each value alone may be."""
    drive = lsvib.Drive(friction_coefficient=0.5)
    found = drive.sweep(lead_angle=[0.1, 1.2], friction_coefficient=[0.1, 0.38])
    assert found.attractor.shape == (2, 2)
    for leads, frictions in (([0.1, 1.2], [0.1, 0.5]), ([1.2, 0.1], [0.5, 0.1])):
        with pytest.raises(lsvib.InputError, match=r"friction_coefficient = 0\.5 is outside"):
            drive.sweep(lead_angle=leads, friction_coefficient=frictions)


def test_a_mask_that_hides_nothing_is_no_fault():
    found = BASE.sweep(mass=np.ma.masked_array([10.0, 11.0], [False, False]))
    assert found.mass.values.tolist() == [10.0, 11.0]


def test_points_are_judged_not_axes_beside_the_other_values_of_the_drive():
    """A rise needs a speed over which it fades."""
    found = lsvib.Drive().sweep(stribeck_rise=[0.01, 0.1], stribeck_speed=[0.01, 0.1])
    assert dict(found.sizes) == {"stribeck_rise": 2, "stribeck_speed": 2}
