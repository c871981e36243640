"""What two tellings of one motion may differ by, so that neither of them is wrong."""

from collections.abc import Callable, Container
from dataclasses import replace

import numpy as np

from lsvib.bench.record import Record
from lsvib.bench.sweeps import case_judge
from lsvib.bench.sweeps.families import Case
from lsvib.bench.sweeps.paths import TOUCHES

_INSTANT = 1e-7  # Events before this part of the duration follow the start at once.
_AT_ONCE = 1e-6  # relative to the duration; where an undamped contact touches N = 0, N changes its sign twice within it


def at_corner(path: Record, other: Record, case: Case) -> bool:
    """Whether two motions differ only where they may; the reference need not be asked then.

    They may differ by events at once after a start on θ′ = 0; with R = 0 by events at the corner θ′ = 0, Q = 0, where
    all events before the first that differs have the same times; and without damping by touches, which come back in
    every turn. The final states agree.
    """
    if same_after_an_instant(path, other, case):
        return True
    undamped = case.drive.support_damping == 0 == case.drive.translation_damping
    if undamped and case_judge.agree(*(without_touches(x, case, TOUCHES) for x in (path, other)), case):
        return True
    pairs = zip(path.kinds, other.kinds, strict=False)
    same = next((k for k, (one, two) in enumerate(pairs) if one != two), min(len(path.kinds), len(other.kinds)))
    cornered = case.drive.axial_force == 0 and same_first(path, other, same, case)
    return bool(cornered and case_judge.agree_but_corners(path, other, case))


def ends_alike(path: Record, exact: Record, case: Case) -> bool:
    """Whether motions agree once modes that are left at once, for the mode that they came from, are left out of both.

    An undamped body that was released from rest comes back to rest once in each turn, for no time. Or whether a slip
    dies away.
    """
    back = [_without_pairs(x, case, lambda kinds, kind: kinds[-2:-1] == [kind]) for x in (path, exact)]
    return case_judge.agree(*back, case) or _dies_away(path, exact, case)


def _dies_away(path: Record, exact: Record, case: Case) -> bool:
    """Whether motions end alike and the engine has all events of the reference, and rests where a slip has died away.

    A slip whose damping takes it below the last place of its terms is rest to the engine, until both begin to slip.
    """
    late, ahead = case_judge.TOLERANCE * case.duration, 0
    for kind, time in zip(path.kinds, path.times, strict=True):
        if ahead < len(exact.kinds) and kind == exact.kinds[ahead] and abs(time - exact.times[ahead]) <= late:
            ahead += 1
        elif not kind.startswith("rest"):
            return False
    return ahead == len(exact.kinds) and case_judge.same_end(path, exact)


def same_after_an_instant(path: Record, other: Record, case: Case) -> bool:
    """Whether motions start on θ′ = 0 and agree but for events at once, where rounding makes the torque."""
    if case.start[1] != -case.drive.input_speed:
        return False
    later = []
    for one in (path, other):
        late = one.times > _INSTANT * case.duration
        kinds = [kind for kind, counts in zip(one.kinds, late, strict=True) if counts]
        later.append(replace(one, kinds=kinds, times=one.times[late]))
    return case_judge.agree(*later, case)


def same_first(path: Record, other: Record, count: int, case: Case) -> bool:
    """Whether the first events of two motions are the same, at the same times."""
    late = np.abs(path.times[:count] - other.times[:count]).max(initial=0.0)
    return path.kinds[:count] == other.kinds[:count] and late <= case_judge.TOLERANCE * case.duration


def without_touches(path: Record, case: Case, touches: Container[tuple[str, str]]) -> Record:
    """Leave out pairs of events that follow each other at once and only touch a surface."""
    return _without_pairs(path, case, lambda kinds, kind: (kinds[-1], kind) in touches)


def _without_pairs(path: Record, case: Case, undoes: Callable[[list[str], str], bool]) -> Record:
    """Leave out pairs of events at once, of which the second ``undoes`` the first: asked of all kinds before and it."""
    kept: list[int] = []
    for k, kind in enumerate(path.kinds):
        at_once = kept and path.times[k] - path.times[kept[-1]] <= _AT_ONCE * case.duration
        if at_once and undoes([path.kinds[j] for j in kept], kind):
            kept.pop()
        else:
            kept.append(k)
    return replace(path, kinds=[path.kinds[k] for k in kept], times=path.times[kept])
