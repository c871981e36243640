"""Friction and efficiency against published tables, the rule of a third, and the force balance of a flank."""

import math

import numpy as np
import pytest
from references.chapter_sheet import LAW, sheet, values_of
from references.command_line import complaint

from lsvib.assess.drive import (
    coefficient_from_efficiency,
    lifting_efficiency,
    lowering_efficiency,
    point,
    square_coefficient,
)
from lsvib.assess.mechanisms import drive_of, reserves
from lsvib.assess.starting import starting
from lsvib.assess.threads import thread_size
from lsvib.assess.vibration import vibration
from lsvib.models import friction

# PBC Linear, white paper "Lead Screw Efficiency": per cent by lead [mm]; diameters 6, 10, 12, 16 mm.
COATED = {
    1: (39, 28, 24, 19), 2: (60, 45, 40, 33), 4: (71, 61, 56, 49), 5: (76, 66, 62, 55), 6: (77, 69, 65, 58),
    8: (81, 74, 71, 65), 10: (84, 78, 75, 69), 12: (84, 80, 77, 72), 16: (None, 84, 81, 77), 25: (None, 86, 85, 83),
}  # fmt: skip
UNCOATED = {
    1: (30, 21, 18, 14), 2: (51, 36, 31, 25), 4: (62, 52, 47, 40), 5: (68, 57, 53, 45), 6: (70, 61, 56, 49),
    8: (75, 66, 62, 56), 10: (78, 71, 67, 61), 12: (81, 74, 70, 64), 16: (None, 78, 75, 70), 25: (None, 83, 81, 77),
}  # fmt: skip
# Trapezoidal screws, transdev.co.uk: thread, lead angle [degree, minute], efficiency at friction 0.1 and 0.2.
TRAPEZOIDAL = [
    ("Tr 10x2", (4, 2), 0.41, 0.26), ("Tr 10x4 P2", (8, 3), 0.58, 0.40), ("Tr 12x3", (5, 12), 0.47, 0.31),
    ("Tr 12x6 P3", (10, 19), 0.63, 0.46), ("Tr 14x4", (6, 3), 0.51, 0.34), ("Tr 16x4", (5, 12), 0.47, 0.31),
    ("Tr 18x4", (4, 33), 0.44, 0.28), ("Tr 20x4", (4, 3), 0.41, 0.26), ("Tr 20x8 P4", (8, 3), 0.58, 0.40),
    ("Tr 22x5", (4, 40), 0.45, 0.28), ("Tr 24x5", (4, 14), 0.42, 0.27),
]  # fmt: skip


def rows(table: dict):
    """Lead and diameter [mm] and efficiency [per cent] of a table."""
    for lead, row in table.items():
        yield from ((lead, d, eta) for d, eta in zip((6, 10, 12, 16), row, strict=True) if eta is not None)


@pytest.mark.parametrize(("table", "low", "high"), [(COATED, 0.069, 0.085), (UNCOATED, 0.092, 0.123)])
def test_friction_follows_from_published_efficiencies(table, low, high):
    """μ from each entry of PBC's table, up to the rounding of the entry to whole per cent, and back to the entry."""
    for lead, diameter, eta in rows(table):
        angle = math.atan(lead / (math.pi * diameter))
        found = coefficient_from_efficiency(eta / 100, angle)
        ends = [coefficient_from_efficiency((eta + part) / 100, angle) for part in (0.5, -0.5)]
        if (lead, diameter) in [(2, 10), (1, 16), (10, 6)]:
            assert low - 0.0005 <= found <= high + 0.0005
        assert ends[0] < high + 0.01
        assert ends[1] > low - 0.02
        assert round(100 * lifting_efficiency(found, angle)) == eta


@pytest.mark.parametrize(("name", "angle", "at_01", "at_02"), TRAPEZOIDAL)
def test_trapezoidal_threads_have_the_published_lead_angle_and_efficiency(name, angle, at_01, at_02):
    """The published efficiencies leave the flank angle out; the lead angle is printed to a minute."""
    size = thread_size(name)
    lead_angle = math.atan(size.lead / (math.pi * size.pitch_diameter))
    assert math.degrees(lead_angle) == pytest.approx(angle[0] + angle[1] / 60, abs=1 / 60)  # some are cut off
    for coefficient, eta in ((0.1, at_01), (0.2, at_02)):
        assert lifting_efficiency(coefficient, lead_angle) == pytest.approx(eta, abs=0.0051)


def test_the_rule_of_a_third_is_a_friction_of_0106():
    """Lead < diameter / 3 is self-locking exactly for μ > 1 / (3 π)."""
    angle = math.atan(1 / (3 * math.pi))
    assert lowering_efficiency(0.1062, angle) < 0 < lowering_efficiency(0.1060, angle)


def test_a_flank_angle_raises_friction_as_in_the_force_balance():
    """Against the balance of forces on a flank, with its normal vector from a cross product."""
    lead_angle, half_angle, mu = 0.12, math.radians(15), 0.17
    along = np.array([0.0, math.cos(lead_angle), math.sin(lead_angle)])  # radial, around, axial
    radial = np.array([math.cos(half_angle), 0.0, math.sin(half_angle)])
    normal = np.cross(along, radial)
    normal *= math.copysign(1, normal[2]) / np.linalg.norm(normal)
    force = normal - mu * along  # of the screw on the nut's flank when lifting
    eta = math.tan(lead_angle) * force[2] / -force[1]
    assert lifting_efficiency(square_coefficient(mu, lead_angle, half_angle), lead_angle) == pytest.approx(
        eta, rel=1e-14
    )


SLOW = {"speed": "10 rad/s", "direction": "out"}


def test_the_fall_of_the_law_decides_from_the_onset_force_on():
    """At 10 rad/s C_0 + S vanishes at R = 64.305 N, where the law is that of the powered seat, without drag."""
    given = sheet(friction=LAW, operation=SLOW)
    values = values_of(given)
    found = [float(reserves(given, values, 1, 10.0, -force)["falling_friction"]) for force in (64.304, 64.307)]
    assert found[0] > 0 > found[1]
    below, above = (vibration(given, values, (1, 10.0, -force)) for force in (62.0, 67.0))
    assert (below.attractor, above.attractor) == ("steady sliding", "stick slip cycle")
    assert above.load_speed[0] == 0 < above.amplitude


def test_a_start_from_rest_keeps_jerking_up_to_the_stated_speed():
    """On either side of it by two parts in a thousand; small perturbations decay there, as steady sliding is stable."""
    given = sheet(friction={**LAW, "static": 0.4}, operation=SLOW, load={"mass": "1 kg", "force": "-60 N"})
    values = values_of(given)
    edge = starting(given, values, ()).even_speed
    moved = [vibration(given, values, (1, part * edge, -60.0), perturbation=None) for part in (0.998, 1.002)]
    assert [one.vibrates for one in moved] == [True, False]
    assert vibration(given, values, (1, 0.998 * edge, -60.0)).attractor == "steady sliding"


@pytest.mark.parametrize("exponent", [1, 2])
def test_a_flank_angle_raises_all_of_the_law_alike(exponent):
    """The drive that is followed has, at any speed, the coefficient and the slope that the reserves use."""
    law = {**LAW, "static": 0.25, "stribeck_exponent": exponent}
    thread = {"lead_angle": "5.57 deg", "pitch_diameter": "10.36 mm", "half_angle": "25 deg"}
    given, flat = sheet(friction=law, thread=thread), sheet(friction=law)
    values = values_of(given)
    drive, level = drive_of(given, values, 1, 3.0, 20.0), drive_of(flat, values_of(flat), 1, 3.0, 20.0)
    factor = square_coefficient(1.0, drive.lead_angle, math.radians(25))
    for key in ("friction_coefficient", "static_friction_coefficient", "stribeck_rise", "friction_slope"):
        assert getattr(drive, key) == pytest.approx(factor * getattr(level, key), rel=1e-14)
    assert (drive.stribeck_speed, drive.stribeck_exponent) == (0.013704, exponent)
    parameters, slope = point(given, values, 1, 3.0, 20.0)
    speed = friction.steady_speed(drive.replace(input_speed=3.0).exact())
    assert parameters["friction_coefficient"] == pytest.approx(
        float(friction.coefficient(drive.exact(), speed)), rel=1e-14
    )
    assert slope == pytest.approx(float(friction.unbounded(drive.exact(), speed)[1]), rel=1e-14)


@pytest.mark.parametrize(
    ("friction", "said"),
    [
        ({"stribeck_speed": None}, "friction.stribeck_rise needs friction.stribeck_speed"),
        ({"stribeck_rise": None}, "friction.stribeck_speed and friction.stribeck_exponent need friction.stribeck_rise"),
        ({"stribeck_speed": "0.01 s"}, "friction.stribeck_speed = '0.01 s' is not a speed"),
        ({"stribeck_exponent": 3}, "friction.stribeck_exponent = 3 is not one of 1 or 2"),
        ({"static": 0.23}, "friction.static, at least 0.23, is not above the friction of slow sliding"),
        ({"coefficient": None, "efficiency": 0.3}, "friction.efficiency and friction.stribeck_rise are both given"),
    ],
)
def test_a_law_that_does_not_fit_together_is_refused_in_one_sentence(friction, said):
    law = {key: value for key, value in {**LAW, **friction}.items() if value is not None}
    assert said in complaint(sheet, friction=law)
