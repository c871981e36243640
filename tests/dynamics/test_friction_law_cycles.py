"""Periods and multipliers of cycles under a friction law against differences of an independent reference.

The reference follows a period from a place within the longest arc of the cycle, and from places beside it. The map over
the period has the eigenvalues 1, along the motion, and the multiplier, so that this is its trace less 1.
"""

import math

import numpy as np
import pytest
from engine.test_friction_law_digits import random_starts
from flint import arb, ctx
from references.friction_law_digits import LawDrive, simulate
from references.friction_law_series import PRECISION
from references.parts import threads_drive

import lsvib
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.errors import EngineError
from lsvib.models.names import Event
from lsvib.models.rigid import rigid_automaton

STEP = 1e-7  # of the differences, over the size of the motion


def end(drive, state, duration):
    """State after a time [s], in balls; None where the law of motion does not determine it."""
    truth = simulate(drive.model_dump(), *state, duration)
    return truth.state if truth.end == "time" else None


def differences(drive, cycle):
    """Return relative errors of the period and of closure, and the multiplier; None where nothing determines them."""
    orbit, T = cycle.orbit, cycle.period
    _, _, _, durations = orbit.arcs()
    slips = ~np.isin(orbit.automaton.codes[orbit.arcs()[0]], orbit.automaton.rest_codes)
    arc = int(np.argmax(durations * slips))
    begins = np.concatenate([[0.0], orbit.time])[arc]
    place = orbit.at([begins + 0.5 * durations[arc]])[0][0]
    size = np.maximum(np.abs(orbit.after).max(axis=0), np.abs(place))
    precision, ctx.prec = ctx.prec, PRECISION
    try:
        here = [arb(x) for x in place]
        back = end(drive, here, T)
        columns = []
        for k in range(2):
            step = arb(STEP * size[k])
            ends = [end(drive, [x + sign * step * (j == k) for j, x in enumerate(here)], T) for sign in (1, -1)]
            if back is None or None in ends:
                return None
            columns.append([float((a - b) / (2 * step)) for a, b in zip(*ends, strict=True)])
        gap = np.array([float(a - b) for a, b in zip(back, here, strict=True)])
        soon = end(drive, here, 1e-9)
        rate = np.array([float((a - b) / arb(1e-9)) for a, b in zip(soon, here, strict=True)])
    finally:
        ctx.prec = precision
    late = abs(gap / size @ (rate / size)) / np.sum((rate / size) ** 2)
    return late / T, np.abs(gap / size).max(), columns[0][0] + columns[1][1] - 1


def jams(drive, orbit):
    """Whether a cycle seizes where Γ₊ comes to zero."""
    edges = [float(edge) for edge in LawDrive(drive.model_dump()).jams]
    speeds = np.abs(orbit.before[orbit.kind == Event.SEIZURE, 1] + drive.input_speed)
    return any(abs(speed - edge) <= 1e-7 * edge for speed in speeds for edge in edges)


def agrees(drive, cycle):
    """Assert that a cycle agrees with the reference; return whether that determines it."""
    found = differences(drive, cycle)
    if found is None:
        return False
    late, gap, multiplier = found
    assert late <= 1e-13, drive
    assert gap <= 1e-13, drive
    # Before Γ₊ = 0 the acceleration grows to 1e8 of its size, and what rounding does to derivatives with it.
    assert abs(cycle.multiplier - multiplier) <= (1e-4 if jams(drive, cycle.orbit) else 2e-9), (drive, multiplier)
    return True


@pytest.mark.parametrize(("slope", "rise"), [(0.2, 0.016), (1.0, 0.087), (4.0, 0.284)])
@pytest.mark.parametrize("speed", [8.0, -8.0])
def test_cycles_of_pure_slip(speed, slope, rise):
    """Steady sliding where friction falls most steeply; at both ends of the vibration friction grows with the speed."""
    sliding = lsvib.Drive().pitch_radius * abs(speed) / math.cos(lsvib.Drive().lead_angle)
    drive = lsvib.Drive.of(
        friction_coefficient=0.1, stribeck_exponent=2, friction_slope=slope, stribeck_rise=rise,
        stribeck_speed=math.sqrt(2) * sliding, input_speed=speed, axial_force=math.copysign(60.0, speed),
        support_damping=2e-5, translation_damping=20.0,
    )  # fmt: skip
    cycle = steady_state(rigid_automaton(drive), [1e-3, 0.1 * speed])
    assert cycle.label == Attractor.OTHER_CYCLE
    assert 0.01 < cycle.multiplier < 1
    assert set(cycle.orbit.kind) == {Event.PASSAGE}
    assert agrees(drive, cycle)


def agreeing(seeds):
    """Return how many cycles of random drives agree, and how many of them have a multiplier that is not zero."""
    compared, moving = 0, 0
    for drive, start in random_starts(seeds):
        cycle = steady_state(rigid_automaton(drive), start)
        if cycle.orbit is not None and agrees(drive, cycle):
            compared, moving = compared + 1, moving + (abs(cycle.multiplier) > 1e-6)
    return compared, moving


def test_cycles_of_random_drives():
    compared, moving = agreeing(range(10))
    assert compared >= 4
    assert moving >= 2


@pytest.mark.slow
def test_cycles_of_many_random_drives():
    compared, moving = agreeing(range(10, 60))
    assert compared >= 14
    assert moving >= 4


def test_what_rounding_makes_is_no_cycle():
    """Undamped, slip next to steady sliding gains 1e-7 a turn: its return map changes sign by rounding alone."""
    found = lsvib.Drive(support_damping=0, stribeck_rise=0.05, stribeck_speed=0.0115).cycles()
    assert [cycle.label.name for cycle in found.cycles] == ["STICK_SLIP_CYCLE"]


def test_none_found_is_not_said_of_a_drive_that_cannot_be_followed():
    drive = threads_drive(stribeck_rise=0.05, stribeck_speed=0.02, input_speed=5, axial_force=50)
    with pytest.raises(EngineError, match=r"motions from all 8 starts are unresolved .* contact_damping smaller"):
        drive.cycles()


@pytest.mark.slow
def test_a_drive_whose_rates_lie_too_far_apart_is_refused_in_seconds():
    """One search of it would take 10¹³ steps."""
    with pytest.raises(EngineError, match=r"all 8 starts are unresolved .*work budget exhausted"):
        lsvib.Drive(translation_damping=1e15, friction_slope=-1e-5).cycles()
