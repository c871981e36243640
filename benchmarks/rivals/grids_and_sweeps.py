"""Grids and sweeps against run time: maps and charts at several resolutions, and amplitudes over the axial force.

The judges are the exact boundary of the basin, the exact force from which on the drive sticks, and 40 digits.
"""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.polynomial import Chebyshev

from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid
from benchmarks.rivals.method_list import METHODS
from benchmarks.rivals.race import quiet
from benchmarks.rivals.race_scenes import RaceScene, scene
from lsvib.basins.boundary import basin
from lsvib.basins.curves import Window
from lsvib.basins.grid import Axis, Grid
from lsvib.basins.mapper import mapper
from lsvib.datasets.sweep import product_of
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.dynamics.behaviour import Behaviour, behaviours
from lsvib.dynamics.sweep import all_endings
from lsvib.models.drive import Drive, forget
from lsvib.stability.force_thresholds import threshold_force

GRIDS = ("map", "chart")
_MAPPED = Drive.of(mass=11.0, support_damping=1e-3, axial_force=-10.0)  # Fig. 8.14b beyond the critical mass
_WINDOW = Window(-0.3, 0.3, -150.0, 150.0)
_CHARTED = Drive.of(translation_damping=1e3)  # of Sect. 8.5.1
_MASSES, _FORCES = (1.0, 8.0), (20.0, 70.0)
_STICKS = (Behaviour.STICK_SLIP, Behaviour.STICK_SLIP_WITH_CONTACT_REVERSAL)
_DEGREE = 30  # of the polynomial through exact forces, which holds them to rounding
_SWEPT = (36.0, 60.0)  # N, where the drive sticks in each cycle, so that its amplitude is steady after one
_DURATION = 0.1  # [s] some seven cycles, of which the last fifth is looked at


def grids(resolutions: Sequence[int], repeats: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return error of a share (grid, resolution), cells on the wrong side of the exact curve, and times (…, repeats).

    The share is that of the window in which steady sliding attracts, and of the chart in which the drive sticks.
    """
    found = [[judge(count, repeats) for count in resolutions] for judge in (_map, _chart)]
    errors, wrong, times = (np.array([[one[k] for one in row] for row in found]) for k in range(3))
    return errors, wrong, times


def _map(count: int, repeats: int) -> tuple[float, int, list[float]]:
    """A map of count × count starts."""
    exact, sides = basin(_MAPPED), (("u", *_WINDOW[:2]), ("w", *_WINDOW[2:]))
    grid = Grid(*(Axis(*side, count) for side in sides))
    labels, times = _timed(lambda: mapper(_MAPPED).cells(grid, quantities=("label",))["label"], repeats)
    steady = labels == Attractor.STEADY_SLIDING
    u, w = (Axis(*side, count).centres() for side in sides)
    inside = np.array([[exact.contains((x, y)) for x in u] for y in w])
    return abs(float(steady.mean()) - exact.fraction(_WINDOW)), int((steady != inside).sum()), times


def _chart(count: int, repeats: int) -> tuple[float, int, list[float]]:
    """A chart of count × count drives."""
    curve = Chebyshev.interpolate(
        np.vectorize(lambda mass: threshold_force(_CHARTED.replace(mass=float(mass)), "stick")), _DEGREE, _MASSES
    )
    x, y = (Axis("", *ends, count).centres() for ends in (_MASSES, _FORCES))
    over = {"axial_force": y.tolist(), "mass": x.tolist()}
    (_, labels), times = _timed(lambda: behaviours(product_of(_CHARTED, over)), repeats)
    sticks = np.isin(labels, _STICKS).reshape(count, count)
    beyond = y[:, None] > curve(x)
    primitive = curve.integ()
    mean = (primitive(_MASSES[1]) - primitive(_MASSES[0])) / (_MASSES[1] - _MASSES[0])
    share = (_FORCES[1] - mean) / (_FORCES[1] - _FORCES[0])
    return abs(float(sticks.mean()) - share), int((sticks != beyond).sum()), times


def sweeps(
    count: int, judged: int, methods: Mapping[str, Sequence[float]], repeats: int, limit: float
) -> dict[str, tuple[float, list[float]]]:
    """Return the largest relative error of the amplitude and the times of one drive [s] of every way to sweep.

    Arguments: ``count`` of forces, of which ``judged`` are compared with 40 digits and are all that the other ways
    compute; ``methods`` with their settings, as of a race; ``repeats``; ``limit`` [s] of a motion.
    """
    forces = np.linspace(*_SWEPT, count)
    places = np.unique(np.linspace(0, count - 1, judged).round().astype(int))
    base = scene("stick_slip")
    scenes = [_motion(base, force) for force in forces[places]]
    truth = np.array([this.truth().amplitude for this in scenes])
    start = np.array(scenes[0].state)
    drives = product_of(base.drive, {"axial_force": forces.tolist()})

    def alone() -> np.ndarray:
        """Every drive by itself, its tables made anew."""
        forget()
        return np.array([steady_state(this.automaton(), start).amplitude for this in scenes])

    ways: dict[str, tuple[Callable[[], np.ndarray], int]] = {
        "sweep": (lambda: all_endings(drives, dict(zip("uw", start, strict=True))).amplitude[places], count),
        "single_drives": (alone, judged),
    }
    for name, settings in methods.items():
        for k, setting in enumerate(settings):
            ways[f"{name}_{k}"] = (_rival(name, setting, scenes, limit), judged)
    found = {}
    with quiet():
        for name, (way, size) in ways.items():
            amplitudes, times = _timed(way, repeats)
            found[name] = float(np.max(np.abs(amplitudes / truth - 1))), [seconds / size for seconds in times]
    return found


def _motion(base: RaceScene, force: float) -> RaceScene:
    """A motion of the drive at an axial force [N] that sticks in its first cycle."""
    return replace(base, drive=base.drive.replace(axial_force=float(force)), state=(0.05, 0.0), duration=_DURATION)


def _rival(name: str, setting: float, scenes: Sequence[RaceScene], limit: float) -> Callable[[], np.ndarray]:
    """A method that follows the motion of each drive."""
    clock = Clock(limit)
    runs = [METHODS[name].prepare(Hybrid(this), setting, clock, 1000) for this in scenes]

    def amplitudes() -> np.ndarray:
        """Return the amplitude of each motion; nan where the method gives up."""
        try:
            return np.array([run()().amplitude for run in runs])
        except GaveUp:
            return np.full(len(runs), math.nan)

    return amplitudes


def _timed(function: Callable[[], np.ndarray], repeats: int) -> tuple[np.ndarray, list[float]]:
    """Return what a function returns and its processor times [s], after one run that compiles."""
    found, times = function(), []
    for _ in range(repeats):
        begun = time.process_time()
        function()
        times.append(time.process_time() - begun)
    return found, times
