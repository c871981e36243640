"""The force of global stability: on which side of it motions reach a cycle, and its value to 40 digits.

Two kinds of cycles end there (docs/basin.md), one with rest and one without, where the map of seizures has the slope 1.
The reference is ``references/threshold_digits.py``. 1e-13 is asked: a smooth maximum is known to rounding.
"""

import math

import numpy as np
import pytest
from mpmath import mp, mpf
from references.threshold_digits import WORK, gap, root

from lsvib.basins.boundary import Boundary, basin
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.engine.kernels.layout import Status
from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.rigid import rigid_automaton
from lsvib.stability.force_thresholds import NoThreshold, threshold_force, widest_return
from lsvib.stability.slip import SlipDrive

PARADOX = Drive.of(mass=11.0, support_damping=1e-3)
# Rest before slip forward and backward, slip on the way to Q = 0, far away on either side.
STARTS = [(0.1, 0.0), (0.0, -40.0), (-0.3, 30.0), (0.3, -90.0), (0.04, -40.0), (0.0, 500.0)]
# Damping: up to 1.30094e-3 the cycle with rest decides, above it the one without; 1e-2 is overdamped.
DAMPINGS = (1e-4, 1.3e-3, 1.4e-3, 2e-3, 1e-2)


def exact_force(cycle: str, drive: Drive, time: float, guess: float):
    """Axial force [N] at which a cycle ends, with 40 digits; ``time`` [s]: about how long its slip lasts."""
    with mp.workdps(WORK):
        return root(lambda force: gap(cycle, {**dict(drive), "axial_force": force}, (time,)), guess)


@pytest.mark.parametrize(("changes", "cycle", "time", "about"), [
    ({}, "global_stability", 0.016, -33.0),
    ({"support_damping": 1.4e-3}, "fold", 0.01596, -25.3),
    ({"support_damping": 2e-3}, "fold", 0.01457, -18.4),
    ({"support_damping": 1e-2}, "fold", 0.00718, -3.2),
    ({"support_damping": 2e-3, "translation_damping": 200.0}, "fold", 0.01454, -12.0),
    ({"support_damping": 2e-3, "mass": 20.0, "input_speed": 13.0}, "fold", 0.01971, -11.0),
])  # fmt: skip
def test_force_against_forty_digits(changes, cycle, time, about):
    """Of the cycle with rest the slip from the end of rest, which begins at u = c Ω / k; the others do not rest."""
    drive = PARADOX.replace(**changes)
    assert abs(threshold_force(drive, "global_stability") / exact_force(cycle, drive, time, about) - 1) < mpf("1e-13")


@pytest.mark.parametrize("speed", [40.0, -40.0])
@pytest.mark.parametrize("damping", DAMPINGS)
def test_the_threshold_separates_what_it_says(damping, speed):
    """Short of it, by 1e-6 and more, the basin has a boundary and motions end on a cycle; beyond it none does."""
    drive = PARADOX.replace(support_damping=damping, input_speed=speed)
    limit = threshold_force(drive, "global_stability")
    for share in (0.5, 0.99, 1 - 1e-6):
        assert basin(drive.replace(axial_force=share * limit)).boundary != Boundary.NONE
    for share in (1 + 1e-6, 1.01, 2.0):
        assert basin(drive.replace(axial_force=share * limit)).boundary == Boundary.NONE
    generator = np.random.default_rng(5)
    starts = generator.uniform([-0.5, -200.0], [0.5, 200.0], (10, 2))
    ends = []
    for share in (1 - 1e-5, 1 + 1e-5):
        automaton = rigid_automaton(drive.replace(axial_force=share * limit))
        ends.append({steady_state(automaton, start).label for start in starts})
    assert Attractor.SPRAG_SLIP_CYCLE in ends[0]
    assert ends[1] == {Attractor.STEADY_SLIDING}


@pytest.mark.parametrize("speed", [40.0, -40.0])
def test_limit_cycle_right_up_to_the_threshold(speed):
    """m = 11 kg, c = 1e-3, c_x = 0: one cycle from 10 N to 1e-8 short of the threshold, the origin 1e-8 beyond it."""
    drive = PARADOX.replace(input_speed=speed)
    limit = threshold_force(drive, "global_stability")
    for share in (*np.linspace(0.3, 0.9, 7), *(1 - 10.0**-n for n in (3, 6, 8)), *(1 + 10.0**-n for n in (8, 5, 2))):
        automaton = rigid_automaton(drive.replace(axial_force=share * limit))
        ends = [steady_state(automaton, start) for start in math.copysign(1, speed) * np.array(STARTS)]
        label = Attractor.SPRAG_SLIP_CYCLE if share < 1 else Attractor.STEADY_SLIDING
        assert {end.label for end in ends} == {label}, share
        if share < 1:  # one and the same cycle, to rounding
            periods = [cycle.period / cycle.returns for cycle in ends]
            np.testing.assert_allclose(periods, periods[0], rtol=1e-12)


@pytest.mark.parametrize("speed", [40.0, -40.0])
def test_forces_with_the_motion(speed):
    """c_x = 2000: every R < 0 is globally stable, and none is from 30.8 N (31.4 N with rest) to the onset, 40.4 N."""
    drive = PARADOX.replace(translation_damping=2000.0, input_speed=speed)
    forward = drive.replace(input_speed=40.0)
    assert exact_force("global_stability", forward, 0.016, 31.0) == pytest.approx(31.431833502858915, rel=1e-13)
    expected = float(exact_force("fold", forward, 0.01651, 31.0))
    limit = threshold_force(drive, "global_stability")
    assert limit == pytest.approx(math.copysign(expected, speed), rel=1e-13)
    inside = float(widest_return(SlipDrive.of(drive))[1])
    starts = [(math.copysign(1, speed) * u, math.copysign(1, speed) * w) for u, w in [*STARTS, (inside, -40.0)]]
    for share, stable in ((1 - 1e-6, True), (0.5, True), (-1.0, True), (1 + 1e-6, False), (1.2, False)):
        automaton = rigid_automaton(drive.replace(axial_force=share * limit))
        motions = [follow(automaton, start, math.inf, max_events=5000) for start in starts]
        assert all(motion.status == Status.SETTLED for motion in motions) == stable, share


def test_light_drives_are_globally_stable_without_translation_damping():
    """Γ₊ > 0, c_x = 0: steady sliding attracts everything under either sign of R, as docs/basin.md proves."""
    generator = np.random.default_rng(6)
    for _ in range(40):
        drive = Drive.of(
            mass=generator.uniform(0.1, 10.1),
            support_damping=10 ** generator.uniform(-5, -2),
            axial_force=generator.choice([-1, 1]) * 10 ** generator.uniform(-2, 3),
        )
        assert basin(drive).boundary == Boundary.NONE


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"mass": 10.0}, "not in the Painlevé region"),
        ({"support_damping": 0.0}, "attracts nothing"),
        (
            {"translation_damping": 2000.0, "support_damping": 0.1},
            "every axial force against the motion and under every",
        ),
    ],
)
def test_where_there_is_no_threshold(changes, words):
    drive = PARADOX.replace(**changes)
    with pytest.raises(NoThreshold, match=words):
        threshold_force(drive, "global_stability")
    if drive.translation_damping:
        assert all(basin(drive.replace(axial_force=-r)).boundary == Boundary.NONE for r in (1e-6, 1e-3, 1.0, 1e3))
