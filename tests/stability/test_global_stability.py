"""The force of global stability: on which side of it motions reach a cycle, and its value to 40 digits.

Two kinds of cycles end there (docs/basin.md). For the one with rest the reference is in test_thresholds.py. For the one
without, the reference below maximises the closed form R(τ) of the cycle over its duration τ, by the root of its
derivative, with 40 digits and from the parameters. 1e-13 is asked: a smooth maximum is known to rounding.
"""

import math

import numpy as np
import pytest
from mpmath import diff, findroot, mp, mpf
from references.rigid_digits import GUARD_DIGITS, RigidTrueDrive, RigidTrueFlow

from lsvib.basins.boundary import Boundary, basin
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.engine.kernels.layout import Status
from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.rigid import rigid_automaton
from lsvib.stability.force_thresholds import NoThreshold, threshold_force, widest_return
from lsvib.stability.slip import SlipDrive

DIGITS = 40
PARADOX = Drive.of(mass=11.0, support_damping=1e-3)
# Rest before slip forward and backward, slip on the way to Q = 0, far away on either side.
STARTS = [(0.1, 0.0), (0.0, -40.0), (-0.3, 30.0), (0.3, -90.0), (0.04, -40.0), (0.0, 500.0)]
# Damping: up to 1.30094e-3 the cycle with rest decides, above it the one without; 1e-2 is overdamped.
DAMPINGS = (1e-4, 1.3e-3, 1.4e-3, 2e-3, 1e-2)


def returning_force(drive: Drive):
    """Largest −R of a cycle that leaves θ′ = 0 at u = x and seizes at u = x, with 40 digits; slip at R̃ < 0."""
    d = RigidTrueDrive({**dict(drive), "axial_force": -1.0}, DIGITS)

    def net_force(time):
        # Slip is linear in its start: u(τ) = a x + b, so that u(τ) = x at x = b / (1 − a).
        a = RigidTrueFlow(d, -1, mpf(1), mpf(0)).state(time)[0]
        b = RigidTrueFlow(d, -1, mpf(0), -d.Omega).state(time)[0]
        x = b / (1 - a)
        u, w = RigidTrueFlow(d, -1, x, -d.Omega).state(time)
        return (d.p * d.m * d.k * u + d.p * (d.m * d.c - d.I * d.cx) * w) / d.Gamma(-1)

    scale = mp.sqrt(d.Gamma(-1) / d.k)
    grid = [k * scale / 20 for k in range(10, 100)]
    largest = max(grid, key=net_force)
    time = findroot(lambda t: diff(net_force, t), (largest, largest + scale / 50))
    return net_force(time) - d.p * d.cx * d.Omega


@pytest.mark.parametrize("changes", [{"support_damping": c} for c in DAMPINGS[2:]] + [
    {"support_damping": 2e-3, "translation_damping": 200.0},
    {"support_damping": 2e-3, "mass": 20.0, "input_speed": 13.0},
])  # fmt: skip
def test_cycle_without_rest_decides(changes):
    drive = PARADOX.replace(**changes)
    with mp.workdps(DIGITS + GUARD_DIGITS):
        assert abs(-mpf(threshold_force(drive, "global_stability")) / returning_force(drive) - 1) < mpf("1e-13")


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
def test_forces_with_the_motion(speed):
    """c_x = 2000: every R < 0 is globally stable, and none is from 30.8 N (31.4 N with rest) to the onset, 40.4 N."""
    drive = PARADOX.replace(translation_damping=2000.0, input_speed=speed)
    with mp.workdps(DIGITS + GUARD_DIGITS):
        d = RigidTrueDrive({**dict(drive), "input_speed": 40.0, "axial_force": -1.0}, DIGITS)
        onset = d.p * d.cx * d.Omega

        def excess(force):
            flow = RigidTrueFlow(d, -1, (d.C(-1) * d.Omega - d.r * (d.xi(1) - d.xi(-1)) * force) / d.k, -d.Omega)
            q = (d.p * d.m * d.k, d.p * (d.m * d.c - d.I * d.cx), mpf(0))
            values = [q[0] * u + q[1] * w for u, w in map(flow.state, flow.extrema(q, mpf("0.1")))]
            return max(values) - d.Gamma(-1) * (onset - force)

        assert findroot(excess, (mpf(30), mpf(31))) == pytest.approx(31.431833502858915, rel=1e-13)
        expected = float(-returning_force(drive.replace(input_speed=40.0)))
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
