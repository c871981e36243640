"""Motions as the second opinions follow them, in the form in which judges compare motions."""

import numpy as np

from judge.second_opinions import strides, watch
from judge.second_opinions.stride_constants import FORCE, Ladders, ladders
from lsvib.bench.record import Record
from lsvib.bench.sweeps.families import Case
from lsvib.bench.sweeps.paths import MOST_EVENTS, mode_name, shortened, token
from lsvib.bench.sweeps.taylor import KINDS
from lsvib.drives.parameters import RigidParameters


def watched_path(case: Case, constants: watch.WatchConstants, size: np.ndarray) -> Record | None:
    """The motion in closed form, or None where double precision does not tell; ``size``: as for the stepper."""
    times, states = np.empty(MOST_EVENTS), np.empty((MOST_EVENTS, 2))
    kinds, modes = np.empty(MOST_EVENTS, dtype=np.int64), np.empty(MOST_EVENTS, dtype=np.int64)
    end, count, u, w, _ = watch.watch(
        constants, *case.start, watch.ANYWHERE, case.duration, False, times, kinds, modes, states
    )
    if end not in (watch.TIME_REACHED, watch.EVENTS_FULL):
        return None
    names = [KINDS[kind] for kind in kinds[:count]]
    return shortened(case, names, times[:count], (u, w), size, end == watch.TIME_REACHED)


def case_ladders(case: Case, longest: float) -> Ladders:
    """Constants of a drive with four states for :func:`strides_path`, for motions up to ``longest`` [s]."""
    return ladders(case.drive.model, dict(case.drive), case.physics, longest)


def strides_path(case: Case, constants: Ladders) -> Record | None:
    """The motion of a drive with four states by strides of propagators, or None where they do not tell."""
    times, size, end = np.empty(MOST_EVENTS), np.empty(4), np.empty(4)
    before, after, fired = (np.empty(MOST_EVENTS, dtype=np.int64) for _ in range(3))
    status, count, _ = strides.follow(
        constants, np.array(case.start), case.duration, strides.MOST_STRIDES, times, before, after, fired,
        np.empty((0, 4)), end, size,
    )  # fmt: skip
    if status not in (strides.TIME_REACHED, strides.EVENTS_FULL):
        return None
    kinds = []
    for one, other, kind in zip(before[:count], after[:count], fired[:count], strict=True):
        if case.drive.model == "threads":
            if constants.direction[one] == 0:
                kinds.append("release")
            elif kind == FORCE:
                kinds.append("contact_reversal")
            else:
                kinds.append("reversal" if constants.direction[other] else "stick")
        else:
            seconds = constants.second[other] if constants.has_second else None
            mode = (constants.direction[other], constants.contact[other], seconds)
            kinds.append(token(mode_name(mode, case.drive.model), kind == strides.SEIZURE))
    return shortened(case, kinds, times[:count], end, size, status == strides.TIME_REACHED)


def quick_path(case: Case, drive: RigidParameters, start: tuple[float, ...]) -> Record | None:
    """:func:`strides_path` in the place of :func:`lsvib.bench.sweeps.paths.exact_path`."""
    moved = case._replace(drive=drive, start=start)
    return strides_path(moved, case_ladders(moved, case.duration))
