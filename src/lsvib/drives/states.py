"""States in which motions of a drive start: as in steady sliding, or standing, as before the motor is switched on."""

from typing import Any

import numpy as np

from lsvib.drives.drive import PARTS, Drive
from lsvib.drives.mechanism import Mechanism
from lsvib.drives.names import BODIES
from lsvib.systems.exact.arithmetic import doubles, many_digits, sign


def seated(mechanism: Mechanism) -> np.ndarray:
    """Return the state of steady sliding: compliant threads are compressed by N_0, all else is measured from it."""
    state = [0] * len(mechanism.states)
    if mechanism.compliant:
        state[mechanism.place["threads"]] = mechanism.compression
    return doubles(state, (len(state),))


def standing(m: Mechanism) -> np.ndarray:
    """Return the state in which the screw stands with the coupling relaxed, as before the motor is switched on.

    The threads carry no torque; what lets the load move along carries R, less what the slide holds of it as it slides.
    """
    d, state = m.d, list[Any]([0] * len(m.states))
    state[:2] = -m.deflection[-1], -d.input_speed
    left = abs(d.axial_force) - m.limits.get("slide", 0)
    contact = left * sign(d.axial_force) if sign(left) > 0 else 0
    for part in m.bodies:
        load, carried = {"contact": (m.force, contact), "torque": (m.twist, 0)}.get(BODIES[part].pushed, (0, 0))
        place = m.place[part]
        state[place] = (carried - load) / getattr(d, PARTS[part][1])
        if BODIES[part].on == "screw":
            state[place], state[place + 1] = state[place] + state[0], state[place + 1] + state[1]
        elif part == "motor":  # which stands, too, and whose controller has seen no error
            state[place : place + 2] = m.steady_torque / d.integral_gain, state[1]
            state[0] = state[0] + state[place]
    if m.compliant:
        state[m.place["threads"]] = contact / d.contact_stiffness
    return doubles(state, (len(state),))


@many_digits()
def standing_state(drive: Drive) -> np.ndarray:
    """Return the state of :func:`standing` of a drive."""
    d = drive.exact()
    return standing(Mechanism(d, drive.parts, d.steady_friction))


@many_digits()
def seated_state(drive: Drive, u: float, w: float) -> np.ndarray:
    """Return the state with a deviation u [rad] and w [rad/s], all else as in steady sliding of compliant threads."""
    d = drive.exact()
    state = seated(Mechanism(d, drive.parts, d.steady_friction))
    state[:2] = u, w
    return state
