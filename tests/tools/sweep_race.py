"""A sweep of the rigid drive by this engine and by solvers in time: errors of the amplitudes beside processor times.

    python tests/tools/sweep_race.py --points 200

A solver in time follows the motion of every drive for some seconds and takes the amplitude of the last fifth; the sweep
of this engine gives the amplitude of the attractor. What all need of a drive, its automaton, is made before the clock
starts for solvers, and is part of the time for the sweep. Entries take turns, round by round. The truth at some of the
points is the motion of the reference with 40 digits over the same time.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from benchmarks.rivals.hybrid import Clock, Hybrid
from benchmarks.rivals.method_list import find_method
from benchmarks.rivals.race import quiet
from benchmarks.rivals.race_scenes import RaceScene
from benchmarks.rivals.truth import reference
from lsvib.data.sweep import sweep
from lsvib.drives.parameters import RigidParameters

_DRIVE = RigidParameters(mass=1, translation_damping=1e3)  # Sect. 8.5.1; slip and stick–slip cycles beyond 20 N
_FORCES = (22.0, 60.0)  # N: all vibrate, and all have settled within the time
_START = {"u": 0.01, "w": 0.0}
_SOLVERS = {"rk4": (1e-4, 1e-5), "rk4_refined": (1e-4, 1e-5), "heyoka": (1e-9, 1e-15)}  # steps [s], tolerances
_LIMIT, _EVENTS = 60.0, 100_000  # s and events of one motion: none comes near
_STEP_CAP = 2e-4  # s; no method here has one


class Timed(NamedTuple):
    """A way to sweep: its name and setting, the function to time, and what its result says of the amplitudes [rad]."""

    name: str
    setting: str
    run: Callable[[], Any]
    amplitudes: Callable[[Any], np.ndarray]


def scenes(forces: np.ndarray, seconds: float) -> list[RaceScene]:
    """Return the motions to follow."""
    begin = tuple(_START.values())
    return [
        RaceScene("sweep", "a sweep", _DRIVE.replace(axial_force=force), begin, seconds, _STEP_CAP)
        for force in forces.tolist()
    ]


def entries(forces: np.ndarray, seconds: float) -> list[Timed]:
    """Return the ways to sweep over forces [N], each run on a short motion already, so that all is compiled."""

    def exact(some: np.ndarray) -> Any:
        return sweep(_DRIVE, {"axial_force": some}, _START)

    exact(forces[:2])
    found = [Timed("lsvib", "", lambda: exact(forces), lambda swept: swept.amplitude.values)]
    made = scenes(forces, seconds)
    for name, settings in _SOLVERS.items():
        method = find_method(name)
        for setting in settings:
            method.prepare(Hybrid(replace(made[0], duration=0.01)), setting, Clock(_LIMIT), _EVENTS)()
            each = [method.prepare(Hybrid(one), setting, Clock(_LIMIT), _EVENTS) for one in made]
            found.append(Timed(method.label, f"{setting:g}", lambda each=each: [one() for one in each], _amplitudes))
    return found


def _amplitudes(followed: list) -> np.ndarray:
    return np.array([np.ptp(one().extremes) / 2 for one in followed])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=2.0, help="of every motion [s]")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--checked", type=int, default=4, help="points with 40 digits")
    given = parser.parse_args()
    forces = np.linspace(*_FORCES, given.points)
    places = np.linspace(0, given.points - 1, given.checked).astype(int)
    truth = np.array([np.ptp(reference(one).extremes) / 2 for one in scenes(forces[places], given.seconds)])
    with quiet():
        ways, times = entries(forces, given.seconds), []
        for _ in range(given.rounds):
            for k, way in enumerate(ways):
                start = time.process_time()
                outcome = way.run()
                taken = time.process_time() - start
                if len(times) <= k:
                    found = way.amplitudes(outcome)
                    times.append(([], np.abs(found[places] / truth - 1).max(), found))
                times[k][0].append(taken)
    print("| method | setting | points per second | largest error, 40 digits | largest difference from lsvib |")
    print("|---|---|---|---|---|")
    for way, (seconds, error, found) in zip(ways, times, strict=True):
        apart = np.abs(found / times[0][2] - 1).max()
        rate = given.points / statistics.median(seconds)
        print(f"| {way.name} | {way.setting} | {float(f'{rate:.2g}'):g} | {error:.1g} | {apart:.1g} |")


if __name__ == "__main__":
    main()
