"""The example that sticks on its guide: from which speed on it runs evenly, by a block and by its own motions."""

import math
from pathlib import Path

import numpy as np

import lsvib
from lsvib.sheets.assessment import assess
from lsvib.sheets.draw import Draw, Operation
from lsvib.sheets.from_rest import Starter
from lsvib.sheets.report import brief
from lsvib.sheets.sheet import Sheet
from lsvib.stability.solve import bracketed_root

SHEET = Sheet.read(Path(__file__).parents[2] / "examples" / "positioning_slide.yaml")


def slowest_of_a_block(v: float, mass: float, stiffness: float, damping: float, shed: float) -> float:
    """Lowest speed, over v, of a block on spring and damper that move at v, after it has let go and shed a friction.

    It lags behind steady sliding by (shed − c v) / k, at −v: y = Re A exp(root t). Below zero it would turn back.
    """
    root = complex(-damping, math.sqrt(4 * mass * stiffness - damping**2)) / (2 * mass)
    lag = (damping * v - shed) / stiffness
    speed = complex(lag, (v + root.real * lag) / root.imag) * root * np.exp(root * np.linspace(1e-6, 0.03, 300001))
    return float(speed.real.min() / v) + 1 - 1e-9  # at its start it is zero, too


def test_with_a_light_screw_on_a_stiff_coupling_it_is_a_block():
    block = bracketed_root(lambda v: slowest_of_a_block(v, 500.0, 5e7, 15811.0, 981.0 - 736.0), 1e-3, 3e-3, 1e-9)
    assert abs(block - 1.7015e-3) < 1e-7
    draw = Draw.of(SHEET).changed(coupling_stiffness=1e6, screw_inertia=1e-6, screw_mass=1e-3)
    for direction in (1, -1):
        there = [Operation(draw, direction, part * block / draw.travel, 0.0) for part in (0.999, 1.001)]
        runs = [Starter(SHEET).evenly(one) for one in there]
        assert runs == [False, True]


def test_the_report_says_below_which_speed_the_slide_jerks_and_what_ends_it():
    found = assess(SHEET, samples=64)
    started = found.from_rest
    assert (found.verdict, started.cause) == ("jerks", "guide")
    assert abs(started.even_speed * found.draw.travel - 1.71e-3) < 5e-6
    assert started.motion.load_speed[0] == 0 < started.motion.screw_speed[0]  # it is the load that stands
    for direction, part in ((1, 0.995), (1, 1.005), (-1, 0.995), (-1, 1.005)):  # events long after the start
        drive = Operation(found.draw, direction, part * started.even_speed, 0.0).drive
        motion = lsvib.Drive.of(drive).simulate("rest", 1.0)
        assert (motion.event_time.values.max() > 0.5) == (part < 1)
    ends = {row.quantity: row.value for row in found.changes}
    # The speed is in proportion to what is shed; a change is rounded up to the two digits that are printed.
    assert 0 < (736 + 245 / 1.712) - ends["slide_static_friction"] < 0.01 * (736 + 245)
    assert ends.keys() >= {"speed", "axial_support_damping"}
    assert "at 10.3 rpm (1.71 mm/s at the load) and above it runs steadily" in brief(found)[0]
    assert "static friction of the guide 11 % smaller" in brief(found)[-2]
