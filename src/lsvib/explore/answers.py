"""What the page asks of the engine, without a page: maps, motions and curves as plain arrays; and its exports."""

from collections import Counter
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock

import numpy as np
import xarray as xr
from matplotlib.colors import to_rgba_array

from lsvib.answers.io import write_dataset
from lsvib.answers.map import mapper
from lsvib.answers.motion import Simulation
from lsvib.answers.phase_plane import sample
from lsvib.answers.spans import stepped
from lsvib.answers.sweep import sweep
from lsvib.drives import friction
from lsvib.drives.drive import Drive
from lsvib.dynamics.curves import Window
from lsvib.errors import EngineError, LsvibError, WorkSpentError
from lsvib.explore.view import View
from lsvib.pictures.attraction import COLOURS
from lsvib.systems.attractor import Attractor, SteadyState, steady_state
from lsvib.systems.grid import Axis, Grid
from lsvib.systems.kernels.layout import Status
from lsvib.systems.mapper import Mapper
from lsvib.systems.motion import Budget, Motion
from lsvib.words import plain

_BESIDE = {"u": 1e-3, "w": 0.0}  # a start beside steady sliding: rad, and rad/s
# Work after which what a motion ends on is unresolved, in events, without and with a friction law; the latter is that
# of each motion which is drawn, too. A third of a second.
_MOST_WORK, _WORK_OF_LAW = 100_000, 20_000
# Cells of the map of a drive with two states while it is dragged, a seventieth of a second (under a friction law half a
# second), and when the hand rests, a fortieth; and of any other drive, of which every motion is followed.
DRAGGED, SETTLED, COARSE = (120, 90), (320, 240), (36, 27)


@dataclass(frozen=True)
class Followed:
    """A motion and what it ends on.

    ``time`` [s] (n), ``u`` [rad] (n), ``w`` [rad/s] (n), ``force`` (n), N [N]; ``cycle`` (k, 2), the limit cycle, empty
    without one; ``steady``, the attractor, None where the engine has no answer; the number of ``events``; ``sliding``
    (n), the sliding speed of the threads [m/s].
    """

    time: np.ndarray
    u: np.ndarray
    w: np.ndarray
    force: np.ndarray
    cycle: np.ndarray
    steady: SteadyState | None
    events: int
    sliding: np.ndarray


def moved(view: View) -> Simulation:
    """Follow the motion of a view; raises ``EngineError``, also where that takes more work than a page may do."""
    budget = Budget(_WORK_OF_LAW)
    with suppress(WorkSpentError):
        found = Simulation.of(view.scene(), budget)
        if found.motion.status != Status.WORK_SPENT:
            return found
    raise EngineError(
        f"the motion of {view.duration:g} s takes too long for a page; shorten it, or use lsvib simulate."
    )


def followed(view: View) -> Followed:
    """Follow the motion of a view and find its attractor; raises ``EngineError``."""
    motion = moved(view).motion
    time, states, modes = _sampled(motion)
    force = motion.automaton.observe("normal_force", states, modes)
    work = _WORK_OF_LAW if friction.depends_on_speed(view.drive) else _MOST_WORK
    steady, cycle = None, np.empty((0, 2))
    with suppress(EngineError):
        steady = steady_state(motion.automaton, motion.start_state, max_events=work)
    if steady is not None and steady.orbit is not None and steady.orbit.time.size:
        cycle = _sampled(steady.orbit)[1][:, :2]
    sliding = motion.automaton.observe("sliding_speed", states, modes)
    return Followed(time, states[:, 0], states[:, 1], force, cycle, steady, motion.time.size, sliding)


def window_around(drive: Drive, shown: Followed) -> Window:
    """Return a window that holds a motion, its limit cycle, steady sliding and the line θ′ = 0, with a margin."""
    u = np.concatenate([shown.u, shown.cycle[:, 0], [0.0]])
    w = np.concatenate([shown.w, shown.cycle[:, 1], [0.0, -drive.input_speed]])
    edges = []
    for values in (u, w):
        margin = 0.12 * (np.ptp(values) or 1.0)
        edges += [float(values.min() - margin), float(values.max() + margin)]
    return Window(*edges)


READY: set[tuple[bool, ...]] = set()  # kinds of drives for which all is compiled, or loaded, in this process


def kind_of(drive: Drive) -> tuple[bool, ...]:
    """Return what decides which engine a drive needs."""
    return drive.rigid, bool(drive.parts), friction.depends_on_speed(drive)


def make_ready(view: View) -> None:
    """Compile, or load, all that a page asks of a drive such as that of a view; raises ``LsvibError``."""
    try:
        window = window_around(view.drive, followed(view))
        if not laborious(view.drive):
            labels(view.drive, window, (12, 9))
        curves(view, [getattr(view.drive, view.over)])
    finally:  # what raises here is said where the page asks for it
        READY.add(kind_of(view.drive))


def at_once(drive: Drive) -> bool:
    """Return whether the map takes no longer than a drawing: of two states, under constant friction."""
    return drive.rigid and not friction.depends_on_speed(drive)


def cells_of(drive: Drive) -> tuple[int, int]:
    """Return the columns and rows of the map that is drawn when the hand rests."""
    return SETTLED if at_once(drive) else DRAGGED if drive.rigid else COARSE


def laborious(drive: Drive) -> bool:
    """Return whether the page draws no map of a drive: friction depends on speed and parts comply."""
    return bool(drive.parts) and friction.depends_on_speed(drive)


def friction_visited(drive: Drive, shown: Followed) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return sliding speeds (n) [m/s], the coefficient (n) at each, and whether (n) a motion takes such a speed.

    The speeds go from zero to a quarter beyond the fastest of the motion; those that it takes are all between its ends.
    """
    taken = np.abs(shown.sliding)
    ends = float(taken.min()), float(taken.max())
    if np.ptp(np.sign(shown.sliding)) == 2:  # it turns back in between
        ends = 0.0, ends[1]
    speeds = np.unique(np.append(np.linspace(0.0, 1.25 * ends[1] or 1.0, 301), ends))
    coefficients = np.maximum(np.broadcast_to(friction.unbounded(drive, speeds)[0], speeds.shape), 0.0)
    return speeds, coefficients, (speeds >= ends[0]) & (speeds <= ends[1])


def labels(drive: Drive, window: Window, cells: tuple[int, int]) -> np.ndarray:
    """Return the labels (rows, columns) of the attractors from every cell of a window; raises ``LsvibError``."""
    u, w = Axis("u", *window[:2], cells[0]), Axis("w", *window[2:], cells[1])
    made, turn = _mapper(drive)
    with turn:
        return np.asarray(made.cells(Grid(u, w), quantities=("label",))["label"])


def rgba(found: np.ndarray) -> np.ndarray:
    """Return labels (rows, columns) as colours (rows, columns) of 32 bits, as a browser takes them; −2 is clear."""
    return np.take(_PALETTE, found.astype(int) + 2)


def shares(found: np.ndarray) -> dict[Attractor, float]:
    """Return the share [1] of the cells of each attractor, the largest first."""
    return {Attractor(kind): count / found.size for kind, count in Counter(found.ravel().tolist()).most_common()}


def values_of(view: View, count: int) -> list[float]:
    """Return ``count`` values of the parameter of the amplitude curve."""
    return [*map(float, (np.geomspace if logarithmic(view) else stepped)(view.low, view.high, count))]


def curves(view: View, values: list[float]) -> list[xr.Dataset]:
    """Return two sweeps over values of the parameter of the amplitude curve.

    Motions start next to steady sliding, and where that of the view does.
    """
    return [sweep(view.drive, {view.over: values}, start) for start in (_BESIDE, view.scene().start)]


def logarithmic(view: View) -> bool:
    """Return whether the parameter of the amplitude curve spans decades, so that it is drawn over its logarithm."""
    return view.low > 0 and view.high >= 1e3 * view.low


def thresholds_over(view: View) -> dict[str, float]:
    """Return, by name, the thresholds of the drive that are values of the parameter of the amplitude curve."""
    known: tuple[str, ...] = ("onset",)
    if view.drive.rigid:
        forces = ("onset", "stick", "detach", "global_stability")
        known = forces if view.over == "axial_force" else ("kinematic_constraint",)
    found = {}
    for name in known:
        with suppress(LsvibError):
            if (value := view.drive.threshold(name, view.over).value) is not None:
                found[name] = value
    return found


def _sampled(motion: Motion) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As many samples as a screen has columns, and at least four of each arc."""
    return sample(motion, max(2000, 4 * (motion.time.size + 1)))


@lru_cache(maxsize=4)  # the drives of a few pages; a mapper holds the cycles of its drive
def _mapper(drive: Drive) -> tuple[Mapper, Lock]:
    """A mapper, and whose turn it is: it serves one thread at a time."""
    return mapper(drive), Lock()


# Colours of a map's labels, from −2 (not computed yet) on, as little-endian RGBA; motion and lines show on it.
_COLOURS = to_rgba_array(["none", *(COLOURS[plain(kind)] for kind in Attractor)], 0.45)
_PALETTE: np.ndarray = np.round(255 * _COLOURS).astype(np.uint8).view(np.uint32)[:, 0]

EXPORTS = {"scene.yaml": "application/yaml", "motion.nc": "application/x-netcdf"}
"""Files that can be had of a view, with their media types."""


def export(file: str, view: View) -> bytes:
    """Return the scene of a view, or its motion as ``lsvib simulate`` writes it; raises ``LsvibError``."""
    if file == "scene.yaml":
        return view.yaml().encode()
    found = moved(view)
    with TemporaryDirectory() as folder:
        path = Path(folder) / file
        write_dataset(found.file(), path, "lsvib.explore")
        return path.read_bytes()
