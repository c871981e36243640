"""Exact derivatives of motions against central differences of 40-digit references, over random drives.

The step 1e-10 of the differences leaves their truncation at 1e-20 of the third derivative; the reference has no events
missed and no rounding at this size. Tolerance 1e-9 of the largest entry, as the library promises for multipliers, and
the library's own bound of its rounding, with a factor for the rounding of the event times and states.
"""

import numpy as np
import pytest
from mpmath import mp, mpf
from references import four_states_digits, rigid_digits
from references.draws import drawn, one_of, power, uniform
from references.parts import threads_drive

from lsvib.dynamics.poincare_map import Section, derivative, section_key
from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.mechanism import seated_state
from lsvib.models.model import automaton_of
from lsvib.models.rigid import rigid_automaton

STEP = mpf(10) ** -10
EVENTS = 7
RIGID = {
    "mass": uniform(2, 16),
    "support_damping": power(-4, -2.5),
    "translation_damping": one_of(0.0, 10.0, 1000.0),
    "axial_force": uniform(-60, 60),
    "input_speed": one_of(-40.0, 40.0),
}


def random_rigid(seed):
    rng = np.random.default_rng(seed)
    return Drive.of(drawn(rng, RIGID)), (float(rng.uniform(-0.2, 0.2)), float(rng.uniform(-100, 100)))


def differences(simulate, state, count):
    """Derivative of the state after the event of a number, by central differences with 40 digits; None if changed."""
    with mp.workdps(40):
        columns, names = [], None
        for j in range(len(state)):
            ends = []
            for sign in (1, -1):
                start = [mpf(x) for x in state]
                step = STEP * max(abs(start[j]), mpf("1e-6"))
                start[j] += sign * step
                events = simulate(start)
                seen = [(event.kind, event.mode_after) for event in events[:count]]
                names = seen if names is None else names
                if seen != names or len(events) < count:
                    return None
                ends.append(events[count - 1])
            columns.append([(a - b) / (2 * step) for a, b in zip(*(end.state for end in ends), strict=True)])
        return np.array([[float(x) for x in column] for column in columns]).T


def agree(found, reference, rounding):
    """Whether a derivative is that of the reference, but for four times the library's own bound of its rounding."""
    away, largest = np.abs(found - reference), np.abs(reference).max()
    size = np.abs(reference).max(axis=1, keepdims=True)
    return (away <= 1e-9 * largest + 4 * rounding).all() and (away <= 1e-7 * size + 4 * rounding).all()


def qualified(motion):
    """Whether neighbours of a motion's start have the same events: it neither begins with one nor touches."""
    return motion.time.size and motion.time[0] > 0 and (motion.kind >= 2).all()


def rigid_motion(seed):
    """A random drive, and a motion of it that has events."""
    for attempt in range(50):
        drive, start = random_rigid(1000 * seed + attempt)
        motion = follow(rigid_automaton(drive), start, np.inf, max_events=EVENTS)
        if qualified(motion):
            return drive, start, motion
    raise AssertionError("no motion has events")


@pytest.mark.parametrize("seed", range(6))
def test_rigid_drives(seed):
    drive, start, motion = rigid_motion(seed)
    reference = differences(
        lambda x: rigid_digits.simulate(dict(drive), *x, float(motion.time[-1]) * 1.01 + 1e-4).events,
        start,
        motion.time.size,
    )
    found = derivative(motion)
    assert reference is not None
    sizes = np.abs(np.vstack([motion.after, [start]])).max(axis=0)
    assert (found.rounding <= 1e-10 * sizes[:, None] / sizes).all()  # so that its share of what is allowed is small
    assert agree(found.matrix, reference, found.rounding), (found.matrix, reference)


def test_compliant_threads():
    for attempt in range(50):
        rng = np.random.default_rng(attempt)
        rigid, (u, w) = random_rigid(attempt)
        stiffness = float(10 ** rng.uniform(5, 8))
        contact = {"contact_stiffness": stiffness, "contact_damping": stiffness * 10 ** rng.uniform(-3, 0)}
        drive = threads_drive(**dict(rigid), **contact)
        start = seated_state(drive, 0.1 * u, 0.1 * w)
        start[3] = 1e-6
        motion = follow(automaton_of(drive), start, np.inf, max_events=4)
        if qualified(motion):
            break
    end = float(motion.time[-1]) * 1.01 + 1e-6
    reference = differences(
        lambda x: four_states_digits.simulate(dict(drive), "threads", (), x, end).events,
        tuple(map(float, start)),
        motion.time.size,
    )
    assert reference is not None
    scale = np.abs(motion.after).max(axis=0)
    exact = derivative(motion)
    found, rounding = exact.matrix * scale / scale[:, None], exact.rounding * scale / scale[:, None]
    assert agree(found, reference * scale / scale[:, None], rounding), (found, reference)


def test_a_section_with_a_coordinate_that_is_zero_throughout():
    """Its scale was zero, and the section divided by it."""
    drive = threads_drive(mass=11.0, axial_force=50.0)
    automaton = automaton_of(drive)
    motion = follow(automaton, seated_state(drive, 0.003, -20.0), np.inf, max_events=40)
    key, size = section_key(motion), np.abs(motion.after).max(axis=0)
    ours = np.flatnonzero((motion.kind == key[0]) & (motion.mode == key[1]))
    origin, size = motion.after[ours[-1]].copy(), size.copy()
    origin[2] = size[2] = 0.0
    section = Section(automaton, key, origin, size, 1, 1.0)
    assert np.isfinite(section.directions).all()
    assert (section.place(origin) == 0).all()
