"""A move of the load from what a sheet says of it: its speed and ramps, and what is left of its start after a ramp."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.drives.model import standing_state
from lsvib.drives.scene import Command
from lsvib.errors import EngineError, InputError, WorkSpentError
from lsvib.sheets.drive_entries import Move
from lsvib.sheets.formulas import Values

SETTLED = 0.01  # of the speed: a ripple below it counts as gone, and what is rounded as the same
_PIECES, _FEW = 12, 2  # of half an s-curve in a command; what 12 add is far below SETTLED; 2 if only its end is asked
_SAMPLES = 2000
_GIVEN = ("distance", "time", "speed", "acceleration_time")
_WORK = 20_000.0  # units of an ordinary event: a tenth of a second, or two
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


class Course(NamedTuple):
    """A move: highest ``speed`` [m/s] and ``acceleration`` [m/s²] of the load, ``time`` and that of a ``ramp`` [s]."""

    speed: Any
    ramp: Any
    time: Any
    acceleration: Any


@np.errstate(divide="ignore", invalid="ignore")  # of a time that is all ramp
def course(move: Move, entries: Values, lead: Any) -> Course:
    """Return a move by the entries of its sheet, d = v (T − t) with the time t of a ramp; ``lead`` [m].

    Raises ``InputError`` where its speed is not reached.
    """
    get: Any = entries.get
    distance, time, speed, ramp = map(get, (f"operation.move.{key}" for key in _GIVEN))
    if move.speed is not None and move.speed.unit == "rad/s":
        speed = speed * lead / (2 * math.pi)
    share = 1 / 2 if move.profile == "triangle" else 1 / 3  # of the time in a ramp, if one of the three is given
    if time is None:
        ramp = share / (1 - share) * distance / speed if ramp is None else ramp
        time = ramp / share if speed is None else distance / speed + ramp
    if ramp is None:
        ramp = share * time if speed is None else time - distance / speed
    speed = np.divide(distance, time - ramp) if speed is None else speed
    apart, left = np.abs(speed * (time - ramp) / distance - 1), time - 2 * ramp
    wrong = (ramp <= 0) | (left < -1e-9 * time) | (apart > SETTLED) | ((share == 1 / 2) & (left > SETTLED * time))
    if np.any(wrong):
        raise InputError(
            "operation.move is inconsistent: it needs distance = speed * (time - acceleration_time), with an "
            "acceleration_time above zero and below half of the time (half of it for a triangle)."
        )
    return Course(speed, ramp, time, speed / ramp * (2 if move.profile == "s-curve" else 1))


def nodes(profile: str) -> NDArray[np.float64]:
    """Return points of a move (4, k): shares of its speed and acceleration, weights of the times of ramp and even run.

    Weights are those of Gauss, exact for squares of what is linear in both; where they are zero, torque can be largest.
    """
    inner, weights = 0.5 * (_NODES + 1), 0.5 * _WEIGHTS
    if profile == "s-curve":  # by the share of the acceleration in either half of a ramp
        rising = np.concatenate([np.linspace(0.05, 1.0, 20), inner])
        weights = np.tile(np.concatenate([np.zeros(20), 0.5 * weights]), 2)
        ramp = np.array([np.concatenate([0.5 * rising**2, 1 - 0.5 * rising**2]), np.tile(rising, 2), weights])
    else:
        ramp = np.array([[0.0, 1.0, *inner], np.ones(2 + inner.size), [0.0, 0.0, *weights]])
    speed, most, weight = np.hstack([ramp, [[1.0], [0.0], [0.0]], ramp * [[1.0], [-1.0], [1.0]]])
    return np.array([speed, most, weight, most == 0])


@dataclass(frozen=True)
class Ripple:
    """The speed of the load after a ramp, ``looked`` at for a time [s]: ``peak_to_peak`` [m/s], or a ``reason``.

    ``settled`` [s]: from when on it is within :data:`SETTLED` of its end, if it is; ``coupling_torque`` [N m]: most.
    """

    peak_to_peak: float | None = None
    settled: float | None = None
    looked: float | None = None
    coupling_torque: float | None = None
    reason: str | None = None


def started(drive: Drive, move: Move | None, ramp: float, looked: float = 0.0, work: float = _WORK) -> Any:
    """Return the motion from rest to the speed of a drive in a ``ramp`` [s], and for the time ``looked`` after it.

    If it is looked at, a ``move`` that goes back then does so likewise, with no stay where it turns.
    """
    from lsvib.systems.motion import Budget, follow  # the engine is loaded by what follows a motion

    curved, pieces = move is not None and move.profile == "s-curve", 2 * (_PIECES if looked else _FEW)
    part = np.linspace(0.0, 1.0, pieces + 1 if curved else 2)
    times, shares = part * ramp, np.where(part < 0.5, 2 * part**2, 1 - 2 * (1 - part) ** 2)
    if looked and move and move.back:
        times = np.concatenate([times, ramp + looked + times, 2 * ramp + looked + times[1:]])
        shares = np.concatenate([shares, 1 - shares, -shares[1:]])
    if curved and {"support", "threads"} & set(drive.parts):  # of as many pieces: seconds
        raise InputError("an s-curve cannot be computed with a compliant support or threads.")
    command = Command(times=tuple(times), speeds=tuple(drive.input_speed * shares))
    start = np.append(standing_state(drive), 0.0)  # by the command's clock
    motion = follow(automaton_of(drive, command=command), start, times[-1] + looked, budget=Budget(work))
    if motion.end_time < times[-1] + looked:
        raise WorkSpentError("the motion takes too long to compute.")
    return motion


def ripple(drive: Drive, move: Move | None, ramp: float, looked: float) -> Ripple:
    """Return what is left of the start of a drive, see :func:`started`."""
    from lsvib.systems.attractor import orbit_extremes

    try:
        motion = started(drive, move, ramp, looked)
        torque = max(map(abs, orbit_extremes(motion, motion.automaton.functional("coupling_torque"))))
    except (InputError, EngineError) as error:
        return Ripple(reason=str(error))
    times = ramp + looked * np.linspace(0.0, 1.0, _SAMPLES) ** 2  # the first swings, which are the largest, most finely
    speeds = motion.automaton.observe("load_speed", *motion.at(times))
    final = drive.input_speed * drive.pitch_radius * math.tan(drive.lead_angle)
    off = np.flatnonzero(np.abs(speeds - final) > SETTLED * abs(final))
    settled = 0.0 if not off.size else None if off[-1] == _SAMPLES - 1 else float(times[off[-1] + 1] - ramp)
    return Ripple(float(np.ptp(speeds)), settled, looked, torque)
