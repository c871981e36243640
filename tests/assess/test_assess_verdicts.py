"""Verdicts that were too good: windows seen between their points, no damping, torque at rest, motion from rest."""

import numpy as np
import pytest
import yaml
from references.chapter_sheet import values_of
from references.random_sheets import random_sheet

from lsvib.assess.assessment import assess
from lsvib.assess.mechanisms import directions, reserves, worst
from lsvib.assess.sheet import Sheet
from lsvib.assess.summary import brief, rows
from lsvib.errors import InputError


def sheet(text, **more):
    return Sheet.of({"name": "a drive", **yaml.safe_load(text), **more})


FALLS_BETWEEN = """
    thread: {lead: 4 mm, pitch_diameter: 12 mm}
    screw: {inertia: 4e-6 kg*m^2}
    coupling: {stiffness: 5 N*m/rad}
    load: {mass: 1 kg, force: 100 N}
    operation: {speed: [1 rpm, 3000 rpm], direction: out}
    friction: {coefficient: 0.1, stribeck_rise: 0.05, stribeck_speed: 12 mm/s, stribeck_exponent: 2}
    damping: {rotational: 6e-3 N*m*s/rad, translational: 10 N*s/m}
"""
UNDAMPED = """
    thread: {size: Tr 16x4}
    screw: {length: 400 mm, material: steel}
    coupling: {stiffness: 50 N*m/rad}
    load: {mass: 20 kg, force: 100 N, orientation: horizontal}
    friction: {coefficient: 0.15}
"""
LIFT = """
    thread: {lead: 5 mm, pitch_diameter: 20 mm}
    screw: {length: 1 m}
    coupling: {stiffness: 500 N*m/rad}
    load: {mass: 80 kg, orientation: vertical}
    operation: {speed: 100 mm/s}
    friction: {efficiency: 85 %}
"""
FROM_REST = """
    thread: {size: Tr 8x2}
    screw: {length: 200 mm, material: stainless steel}
    coupling: {stiffness: 1 N*m/rad}
    load: {mass: 5 kg, force: 100 N}
    operation: {speed: 100 rpm, direction: out}
    friction: {coefficient: 0.2, static: 0.35}
    damping: {rotational: 2e-4 N*m*s/rad, translational: 20 N*s/m}
"""


def lowest_of_dense(given, values, name):
    """The lowest reserve over a dense grid of the window, as far as it is not where friction is at the cut."""
    speeds = np.geomspace(values["speed_low"], values["speed_high"], 4000)
    forces = np.linspace(values["force_low"], values["force_high"], 9)[:, None]
    return min(float(np.nanmin(reserves(given, values, side, speeds, forces)[name])) for side in directions(given))


def test_a_fall_of_friction_between_two_speeds_is_seen():
    """Unstable from 3.8 to 26 rpm of 1 to 3000."""
    given = sheet(FALLS_BETWEEN)
    found = assess(given, samples=64)
    assert found.verdict == "vibrates"
    one = found.mechanisms["falling_friction"]
    values = values_of(given)
    assert one.reserve == pytest.approx(lowest_of_dense(given, values, "falling_friction"), abs=1e-5)
    assert 3.8 < one.corner[1] * 30 / np.pi < 26


def windows(seed, indices):
    """Assert that no dense look at a window finds a mechanism where none is found; how many windows were looked at."""
    looked = 0
    for index in indices:
        try:
            given = Sheet.of(random_sheet(seed, index))
        except InputError:
            continue
        values = values_of(given)
        if values["speed_low"] == values["speed_high"]:
            low, high = 0.02 * values["speed_low"], 50 * values["speed_high"]
            speed = [f"{low!r} rad/s", f"{high!r} rad/s"]
            given = Sheet.of({**random_sheet(seed, index), "operation": {"speed": speed}})
            values = values_of(given)
        found = worst(given, values)
        own = {name: one.reserve[0] for name, one in found.items() if name != "after_perturbation"}
        if not np.isnan(list(own.values())).any() and min(own.values()) >= 0:
            dense = min(lowest_of_dense(given, values, name) for name in own)
            assert dense >= -1e-6, (index, dense, own)
        looked += 1
    return looked


def test_windows_are_seen_as_a_dense_look_sees_them():
    assert windows(11, range(40)) > 20


@pytest.mark.search
def test_a_thousand_windows_are_seen_as_a_dense_look_sees_them():
    assert windows(12, range(1100)) > 1000


@pytest.mark.parametrize("direction", ["out", "back", "both"])
@pytest.mark.parametrize(
    "parts",
    [
        {"support": {"stiffness": "1e7 N/m"}},
        {"contact": {"stiffness": "1e7 N/m", "damping": "0 N*s/m"}},
        {"support": {"stiffness": "1e7 N/m"}, "contact": {"stiffness": "1e7 N/m", "damping": "0 N*s/m"}},
    ],
)
def test_a_drive_that_nothing_damps_has_no_reserve(parts, direction):
    """Reserves of two undamped bodies say that no motion grows, not that one decays."""
    found = assess(sheet(UNDAMPED, operation={"speed": "10 mm/s", "direction": direction}, **parts), samples=64)
    assert found.verdict == "steady without reserve"
    assert found.mechanisms["negative_damping"].reserve == 0


@pytest.mark.parametrize("damping", ["1e-3", "4e-3", "5e-3"])
def test_no_guessed_damping_lessens_what_a_brake_must_hold(damping):
    given = sheet(LIFT, damping={"rotational": f"{damping} N*m*s/rad", "translational": "100 N*s/m"})
    found = assess(given, samples=64)
    for name in ("holding_torque", "braking_torque"):
        assert found.statics.rows[name].worst == pytest.approx(0.5144, abs=5e-5)
    assert any("514 mN m to hold at rest" in line for line in brief(found))


def test_a_lead_beside_a_nominal_diameter_needs_its_starts():
    """With one start the pitch diameter of 8 × 8 would be 4 mm; a Tr 8x8 P2 has four, and 7 mm."""
    thread = {"lead": "8 mm", "nominal_diameter": "8 mm"}
    with pytest.raises(InputError, match=r"needs thread.pitch, or thread.starts beside thread.lead"):
        sheet(LIFT, thread=thread)
    assert values_of(sheet(LIFT, thread={**thread, "starts": 4}))["pitch_diameter"] == pytest.approx(7e-3)


def test_vibration_that_starts_from_rest_alone_is_seen():
    """Motions from −5 Ω settle at every speed, those from rest vibrate up to 34.705 rad/s."""
    found = assess(sheet(FROM_REST), samples=64)
    assert found.starting.even_speed == pytest.approx(34.705, rel=1e-3)


def test_the_row_of_vibration_says_what_was_drawn():
    found = assess(
        sheet(UNDAMPED, operation={"speed": "10 mm/s"}, damping={"rotational": "1e-3 N*m*s/rad"}), samples=64
    )
    assert rows(found)[0][2] == "steady in all drives that were drawn"


def test_changes_name_a_damping_that_the_sheet_does_not_give():
    """Negative damping, which rotational damping alone would end."""
    given = sheet(
        UNDAMPED,
        load={"mass": "0.1 kg", "force": "-100 N"},
        operation={"speed": "10 mm/s", "direction": "out"},
        damping={"translational": "500 N*s/m"},
    )
    (line,) = (line for line in brief(assess(given, samples=64)) if "changes alone" in line)
    assert "rotational damping of the screw of at least" in line
    assert "of which the sheet gives none" in line
