"""Points of the friction law from a record in which the speed changes, and the speed of a record of positions.

Where the screw turns, T = T_steady(ω) + J dω/dt. Means with a weight that fades to zero at both ends of a window obey
the same equation, and with a parabola the mean of dω/dt is the slope of the straight line through the speed: nothing
has to be differentiated, and noise of neighbouring windows is independent. The mean speed between two positions is
exact, and goes with the mean torque between them.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lsvib.errors import InputError
from lsvib.sheets.torque.records import evenly
from lsvib.sheets.torque.starts import Number, grain
from lsvib.sheets.torque.tables import Point, Recording

FEWEST, MOST = 4, 1000  # samples of a window, and windows of a record
WINDOWS = 30  # of a record at least, if it has the samples
CHANGE = 0.1  # of the largest speed, by which it changes in a window
TURNS = 0.01  # of the largest speed, and
SURELY = 6.0  # standard deviations of its noise: a screw that is faster turns
GRAIN = 0.01  # of the largest speed: error that noise and steps of the position may make
SHORTEST = 100  # speeds that are told of a record of positions, if it has so many


def speed_of_position(recording: Recording, interval: float | None) -> tuple[Recording, float]:
    """Return a recording whose ``speed`` [rad/s] is that of the positions [rad] in its place, and its interval [s].

    Positions that stay within a turn start again from zero after it. Over so many intervals a speed is told that steps
    and noise of the position do not matter. Raises ``InputError`` where times do not ascend.
    """
    recording, step = evenly(recording, interval)
    at, torque = recording.speed, recording.torque
    if not step or at.size < FEWEST:
        raise InputError(f"{recording.name} has times that do not ascend, so positions tell no speed.")
    if np.ptp(at) <= 2 * math.pi:
        at = np.unwrap(at)
    noise = max(1.4826 * float(np.median(np.abs(np.diff(at, 3)))) / math.sqrt(20), grain(at) / math.sqrt(12))
    top = float(np.quantile(np.abs(np.diff(at)), 0.98))
    size = int(np.clip(math.sqrt(2) * noise / (GRAIN * top) if top else 1, 1, max(1, at.size // SHORTEST)))
    ends = np.arange(0, at.size, size)
    total = np.concatenate([[0.0], np.cumsum(0.5 * (torque[1:] + torque[:-1]))])[ends]
    speed, wide = np.diff(at[ends]) / (size * step), size * step
    found = replace(
        recording, speed=speed, torque=np.diff(total) / size, time=wide * np.arange(speed.size, dtype=float)
    )
    return found, wide


def moving_points(
    recording: Recording, interval: float | None, averaging: float | None, inertia: Number
) -> list[Point]:
    """Return means of where the screw surely turns, less the torque that accelerates ``inertia`` [kg m²]."""
    recording, step = evenly(recording, interval)
    speed, fast = recording.speed, np.abs(recording.speed)
    if not step or speed.size < FEWEST:
        return []
    noise = 1.4826 * float(np.median(np.abs(np.diff(speed, 2)))) / math.sqrt(6)
    sense = np.where(fast > max(SURELY * noise, 2 * grain(speed), TURNS * fast.max()), np.sign(speed), 0)
    reach = 1 + math.ceil(max(averaging or 0.0, step) / step - 1e-9)  # of samples in whose mean a rest takes part
    runs = [run[reach:-reach] for run in np.split(np.arange(speed.size), 1 + np.flatnonzero(np.diff(sense)))
            if sense[run[0]]]  # fmt: skip
    turning, apart = sum(run.size for run in runs), max(1, speed.size // (4 * WINDOWS))
    change = np.pad(np.abs(speed[apart:] - speed[:-apart]) / apart, (apart // 2, apart - apart // 2), mode="edge")
    pace = WINDOWS / max(turning, 1) + change / (CHANGE * fast.max())  # windows a sample
    pace = np.minimum(pace * min(1.0, MOST / float(pace.sum())), 1 / FEWEST)
    parts = []
    for run in runs:
        place = np.cumsum(pace[run])
        count = round(float(place[-1])) if run.size else 0  # none of what is less than half a window
        parts += np.split(run, np.searchsorted(place, place[-1] * np.arange(1, count) / count)) if count else []
    return [_mean(recording, part, step, inertia) for part in parts if part.size >= FEWEST]


def _mean(recording: Recording, part: NDArray[np.intp], step: float, inertia: Number) -> Point:
    """Return the mean of some samples, weighed by a parabola."""
    order = np.arange(part.size) - 0.5 * (part.size - 1)
    edges = np.concatenate([[0.0], -np.cumsum(order)])  # the parabola, between samples
    weight = 0.5 * (edges[1:] + edges[:-1]) / float(order @ order)
    speed, torque = recording.speed[part], recording.torque[part]
    rate = float(order @ speed) / (float(order @ order) * step)
    held, mean = float(weight @ torque) - inertia[0] * rate, float(weight @ speed)
    spread = math.sqrt(float(weight @ (speed - mean) ** 2))
    return Point(recording.name, mean, held, spread, np.nan, part.size, rate=rate)
