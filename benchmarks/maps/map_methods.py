"""The ways to map a region of attraction that are compared: this engine and its rivals."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from benchmarks.maps.map_kernels import stepped_labels
from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid
from benchmarks.rivals.method_list import find_method
from benchmarks.rivals.race_scenes import RaceScene
from lsvib.basins.kernels import labelling
from lsvib.basins.kernels.labelling import UNKNOWN, UNRESOLVED
from lsvib.basins.planar_mapper import PlanarMapper
from lsvib.engine.kernels import columns

_HORIZON = 1.0  # [s] after which the motion of a rival is unresolved: some hundred swings of the drive
_BUDGET = 100_000  # events after which a motion is unresolved
_TOLERANCE = 1e-6  # relative tolerance of the general solver: enough for a label
_LIMIT = 30.0  # [s] of processor time for one motion of the general solver
_STEP_CAP = 2e-4  # [s] from which a solver looks for a guard that falls within its first step

Label = Callable[[np.ndarray, np.ndarray, np.ndarray], None]  # (x, y, labels), filled


@dataclass(frozen=True)
class MapMethod:
    """A way to map: ``prepare`` makes the function that is timed."""

    label: str
    prepare: Callable[[PlanarMapper], Label]


def _engine(mapper: PlanarMapper) -> Label:
    tables, known = mapper.automaton.tables, mapper.sections.known
    none = np.empty((0, 0), dtype=np.int8)
    return lambda x, y, labels: labelling.map_labels(tables, known, x, y, 0, _BUDGET, labels, none)


def _stepped(mapper: PlanarMapper, step: float) -> Label:
    tables, known = mapper.automaton.tables, mapper.sections.known
    return lambda x, y, labels: stepped_labels(tables, known, x, y, step, _HORIZON, labels)


def _lsoda(mapper: PlanarMapper) -> Label:
    """scipy's LSODA with events; a motion that stays in a damped mode is followed until its ellipse is trapped."""
    find_method("lsoda").require()
    from benchmarks.rivals.methods.scipy_events import integrator

    clock = Clock(_LIMIT)
    hybrid = Hybrid(RaceScene("map", "map", mapper.drive, (0.0, 0.0), _HORIZON, _STEP_CAP))
    integrate = integrator(hybrid, _TOLERANCE, clock, "LSODA")
    tables, known = mapper.automaton.tables, mapper.sections.known

    def label(start: tuple[float, float]) -> int:
        """Return the attractor of one start; GaveUp where the solver fails."""
        clock.start()
        (mode, state), now = hybrid.enter(start), 0.0
        while now < _HORIZON:
            guard = hybrid.due(mode, state)
            arrived = guard is None
            if arrived:
                end = now + _trapped_after(tables, known, mode, state)
                now, state, guard = integrate(mode, now, state, min(end, _HORIZON))
                if guard is None:
                    return int(known.settled[mode]) if now == end else UNRESOLVED
            transition = tables.guard_transition[hybrid.modes[mode].first_guard + guard]
            mode, state, _ = hybrid.fire(mode, guard, state, arrived)
            if known.resting[mode] != UNKNOWN:
                return int(known.resting[mode])
            surface = known.landing[transition]
            found = labelling.look_up(known, mode, surface, np.array(state)) if surface >= 0 else UNKNOWN
            if found != UNKNOWN:
                return int(found)
        return UNRESOLVED

    def fill(x: np.ndarray, y: np.ndarray, labels: np.ndarray) -> None:
        """Label every start (x[j], y[i]); what the solver gives up is unresolved."""
        for i, w in enumerate(y.tolist()):
            for j, u in enumerate(x.tolist()):
                try:
                    labels[i, j] = label((u, w))
                except GaveUp:
                    labels[i, j] = UNRESOLVED

    return fill


def _trapped_after(tables, known, mode: int, state: np.ndarray) -> float:
    """Time [s] after which a motion that stays in a mode is in the trapping ellipse; infinite if there is none."""
    kappa2, reach = known.trap[mode, :2]
    if not reach > 0.0:
        return math.inf
    row = tables.flow[mode]
    rate = 2.0 * row[columns.ALPHA] - abs(kappa2 - row[columns.BETA] ** 2) / math.sqrt(kappa2)
    return max(0.0, math.log(labelling.ellipse(tables, known, mode, np.array(state)) / reach) / rate)


METHODS: dict[str, MapMethod] = {
    "engine": MapMethod("lsvib", _engine),
    "rk4_coarse": MapMethod("RK4, 1e-4 s", partial(_stepped, step=1e-4)),
    "rk4_fine": MapMethod("RK4, 1e-5 s", partial(_stepped, step=1e-5)),
    "lsoda": MapMethod("LSODA with events", _lsoda),
}
