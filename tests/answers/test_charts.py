"""Charts and sweeps: labels by motions are those that the exact thresholds give; points are those of single drives."""

import json
import math
from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from references.drives import nut_drive, support_drive, threads_drive

import lsvib
from lsvib.answers.io import read_dataset
from lsvib.answers.sweep import product_of, write_chart
from lsvib.drives.mechanics import coefficients
from lsvib.dynamics.impulses import event_impulses
from lsvib.dynamics.sweep import Behaviour, behaviours
from lsvib.errors import NoThreshold
from lsvib.stability.curves import ChartBoundary, _function, boundary_curves, starts_evenly
from lsvib.stability.force_thresholds import threshold_force
from lsvib.systems.attractor import orbit_extremes
from lsvib.systems.motion import follow

PAIRS = {  # of parameters, with the ends of both axes and the drive
    "mass over force": (("mass", 0.5, 14.0), ("axial_force", -60.0, 80.0), {"translation_damping": 1000.0}),
    "support damping over force": (("support_damping", 1e-4, 3e-3), ("axial_force", -90.0, 30.0), {"mass": 12.0}),
    "speed over force": (("input_speed", -90.0, -5.0), ("axial_force", -60.0, 60.0), {"translation_damping": 1000.0}),
    "mass and friction": (
        ("mass", 0.5, 14.0), ("friction_coefficient", 0.12, 0.4), {"translation_damping": 1000.0, "axial_force": 35.0},
    ),
}  # fmt: skip


@lru_cache(maxsize=100_000)
def force(name: str, drive) -> float | str:
    """A threshold of a drive without R, or in a word why there is none."""
    try:
        return threshold_force(drive, name)
    except NoThreshold as reason:
        return str(reason)


def expected(drive) -> Behaviour | None:
    """What the thresholds say that a drive does; None where they do not cover it. Written for Ω > 0, else mirrored."""
    c, way = coefficients(drive), math.copysign(1.0, drive.input_speed)
    plain, R = drive.replace(axial_force=0.0), way * drive.axial_force
    drags = float(c.net_force) * way > 0
    if c.paradox:
        if drags:
            return Behaviour.SPRAG_SLIP
        end = force("global_stability", plain)
        if isinstance(end, str):
            return Behaviour.NO_VIBRATION if "globally stable under every" in end else None
        if R < way * end:
            return Behaviour.NO_VIBRATION
        return {-1.0: Behaviour.VIBRATION_FROM_REST, 1.0: Behaviour.COEXISTENCE}.get(starts_evenly(drive))
    if c.damping[1] >= 0:
        return Behaviour.NO_VIBRATION
    if not drags:
        return {-1.0: Behaviour.VIBRATION_FROM_REST, 1.0: Behaviour.NO_VIBRATION}.get(starts_evenly(drive))
    stick, detach = force("stick", plain), force("detach", plain)
    if isinstance(stick, str) and "no limit cycle" not in stick:
        return None
    if not isinstance(stick, str) and R < way * stick:
        return Behaviour.PURE_SLIP
    if isinstance(detach, str):
        if "every cycle with rest reaches N = 0" in detach:
            return Behaviour.STICK_SLIP_WITH_CONTACT_REVERSAL
        return Behaviour.STICK_SLIP if "no axial force beyond the onset" in detach else None
    return Behaviour.STICK_SLIP_WITH_CONTACT_REVERSAL if R < way * detach else Behaviour.STICK_SLIP


def labels_of(drive, x: tuple, y: tuple, said) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What drives do in the middles of cells between ends of two parameters, and what a function of these says there.

    And whether that is what it says at the four corners of the cell.
    """

    def at(columns, rows) -> np.ndarray:
        return np.array([[said(a, b) for a in columns.tolist()] for b in rows.tolist()])

    between = {name: (values[1::2], values[::2]) for name, values in (y, x)}
    _, labels = behaviours(product_of(drive, {name: own.tolist() for name, (own, _) in between.items()}), 2)
    middles, nodes = (at(between[x[0]][k], between[y[0]][k]) for k in (0, 1))
    corners = np.stack([nodes[:-1, :-1], nodes[1:, :-1], nodes[:-1, 1:], nodes[1:, 1:]])
    return labels.reshape(middles.shape), middles, (corners == middles).all(axis=0)


@pytest.mark.parametrize("name", PAIRS)
def test_labels_agree_with_the_exact_curves(name):
    """In every cell that no curve cuts: one of whose four corners and middle the thresholds say the same."""
    *spans, changes = PAIRS[name]
    x, y = ((key, np.linspace(*ends, 25 if name == "mass and friction" else 33)) for key, *ends in spans)
    drive = lsvib.Drive(**changes)

    def said(a: float, b: float) -> int:
        found = expected(drive.replace(**{x[0]: a, y[0]: b}))
        return -9 if found is None else int(found)

    labels, middles, whole = labels_of(drive, x, y, said)
    whole &= middles != -9
    np.testing.assert_array_equal(labels[whole], middles[whole])
    assert whole.sum() > 2 * (~whole).sum()
    assert len(set(labels[whole].tolist())) >= 2


def test_contact_chart_agrees_with_flutter():
    """Of a (k_c, c_c) chart, against the exact curve of flutter.

    The first motion begins next to steady sliding, so that it comes back to it where that is stable, and nowhere else.
    """
    names = "contact_stiffness", "contact_damping"
    drive, x, y = (
        threads_drive(mass=9),
        *zip(names, (np.geomspace(1e5, 1e9, 13), np.geomspace(3e3, 1e9, 13)), strict=True),
    )
    flutter = _function(drive, ChartBoundary.FLUTTER, names)  # zero on the curve
    labels, stable, whole = labels_of(drive, x, y, lambda k, c: flutter(k, c) > 0)
    whole &= labels != Behaviour.UNRESOLVED  # one of the two motions is chaotic or too slow
    comes_back = np.isin(labels, [Behaviour.NO_VIBRATION, Behaviour.COEXISTENCE, Behaviour.VIBRATION_FROM_REST])
    np.testing.assert_array_equal(comes_back[whole], stable[whole])
    assert set(stable[whole].tolist()) == {True, False}
    assert whole.sum() > 22


@pytest.mark.slow
def test_points_of_curves_are_roots():
    """Both sides of a point of a curve have different labels."""
    drive = lsvib.Drive(translation_damping=1000.0)
    found = boundary_curves(drive, ("mass", (0.5, 14.0)), ("axial_force", (-60.0, 80.0)))
    assert {kind.name for kind in found} == {
        "KINEMATIC_CONSTRAINT", "ONSET", "STICK", "DETACH", "GLOBAL_STABILITY", "EVEN_SPEED"
    }  # fmt: skip
    mass = drive.threshold("kinematic_constraint", "mass").value
    np.testing.assert_allclose(np.concatenate(found[ChartBoundary.KINEMATIC_CONSTRAINT])[:, 0], mass, rtol=1e-12)
    for kind in (ChartBoundary.STICK, ChartBoundary.DETACH, ChartBoundary.GLOBAL_STABILITY):
        for m, R in np.concatenate(found[kind])[::9]:
            exact = threshold_force(drive.replace(mass=m), kind.name.lower())
            assert exact == pytest.approx(R, rel=1e-10)


def test_a_chart_is_a_sweep_over_two_parameters_and_that_of_the_workflow(tmp_path):
    settings = {
        "drive": {"input_speed": 30.0},
        "x": {"parameter": "mass", "start": 9.0, "stop": 15.0, "count": 7},
        "y": {"parameter": "axial_force", "start": 0.0, "stop": 60.0, "count": 5},
    }
    found = lsvib.Drive(input_speed=30).sweep(axial_force=range(0, 61, 15), mass=range(9, 16), workers=3)
    assert (found.behaviour.dims, found.behaviour.dtype) == (("axial_force", "mass"), np.int8)
    assert "boundary_name" in found
    assert {"mass", "axial_force"}.isdisjoint(json.loads(found.attrs["parameters"]))
    write_chart(settings, tmp_path / "chart.nc")
    assert read_dataset(tmp_path / "chart.nc").drop_attrs().identical(found.drop_attrs())
    assert found.input_speed == 30


@pytest.mark.parametrize("over", [
    {"mass": [9, 9], "axial_force": [0, 60]}, {"slide_friction": [0, 20], "mass": [1, 2]},
    {"input_speed": [-5, 5], "mass": [1, 2]}, {"screw_mass": [3, 4], "support_stiffness": [1e6, 2e6]},
])  # fmt: skip
def test_where_no_exact_curve_is_known_there_is_none(over):
    found = lsvib.Drive().sweep(**over)
    assert ("behaviour" in found, "boundary_name" in found) == (True, False)


def test_flutter_is_traced_through_the_force_at_which_no_law_holds():
    """Nodes on R = 0 were a refusal. There the law changes, and with it the stability of drives beyond a mass.

    Without any force there is no such curve.
    """
    drive = threads_drive(contact_damping=5e4)
    critical = drive.threshold("onset", "mass").value
    found = boundary_curves(drive, ("mass", (5.0, 15.0)), ("axial_force", (-60.0, 60.0)))
    (line,) = found[ChartBoundary.FLUTTER]
    on_zero = np.abs(line[:, 1]) < 1e-9
    assert on_zero.sum() > 10
    assert (line[on_zero, 0] > critical * (1 - 1e-12)).all()
    np.testing.assert_allclose(line[~on_zero, 0], critical, rtol=1e-11)
    assert line[~on_zero, 1].max() == 60.0
    assert not boundary_curves(drive.replace(axial_force=0.0), ("mass", (5.0, 15.0)), ("contact_stiffness", (1e6, 1e9)))


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


def test_same_bits_for_any_number_of_processes():
    forces = np.linspace(1.0, 60.0, 120)
    alone, told = BASE.sweep(axial_force=forces), []
    again = BASE.sweep(axial_force=forces, workers=2, progress=lambda *numbers: told.append(numbers))
    xr.testing.assert_identical(again, alone)
    assert told[-1] == (360, 360)
    assert all(before[0] < after[0] <= after[1] == 360 for before, after in pairwise(told))
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


@pytest.mark.parametrize(
    ("drive", "start"),
    [
        (threads_drive(mass=1, translation_damping=1000), {}),
        (threads_drive(mass=11, contact_damping=3e7), {"thread_mismatch": 1e-7, "mismatch_rate": 0.01}),
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


def test_points_are_judged_not_axes_beside_the_other_values_of_the_drive():
    """μ < cot λ couples two axes, a rise needs a speed over which it fades; a mask that hides nothing is no fault."""
    drive = lsvib.Drive(friction_coefficient=0.5)
    assert drive.sweep(lead_angle=[0.1, 1.2], friction_coefficient=[0.1, 0.38]).attractor.shape == (2, 2)
    for leads, frictions in (([0.1, 1.2], [0.1, 0.5]), ([1.2, 0.1], [0.5, 0.1])):
        with pytest.raises(lsvib.InputError, match=r"friction_coefficient = 0\.5 is outside"):
            drive.sweep(lead_angle=leads, friction_coefficient=frictions)
    assert lsvib.Drive().sweep(stribeck_rise=[0.01, 0.1], stribeck_speed=[0.01, 0.1]).attractor.shape == (2, 2)
    found = BASE.sweep(mass=np.ma.masked_array([10.0, 11.0], [False, False]))
    assert found.mass.values.tolist() == [10.0, 11.0]
