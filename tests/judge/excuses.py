"""What two tellings of one motion may differ by, so that neither of them is wrong."""

import math
from collections.abc import Callable, Container
from dataclasses import replace

import numpy as np

from lsvib.bench.record import Record, Verdict
from lsvib.bench.sweeps import case_judge
from lsvib.bench.sweeps.families import Case
from lsvib.bench.sweeps.paths import MOST_EVENTS, TOUCHES, exact_path, without_clusters
from lsvib.drives.coefficients import coefficients

_INSTANT = 1e-7  # Events before this part of the duration follow the start at once.
_AT_ONCE = 1e-6  # relative to the duration; where an undamped contact touches N = 0, N changes its sign twice within it


def agree(path: Record, other: Record, case: Case) -> bool:
    """Whether two motions have the same events, at the same times, and end in the same state."""
    outcome = case_judge.CaseOutcome(Verdict.WRONG, case_judge.Judge.NONE)
    return case_judge.compare(outcome, path, other, case) is Verdict.RIGHT


def at_corner(path: Record, other: Record, case: Case) -> bool:
    """Whether two motions differ only where they may; the reference need not be asked then.

    They may differ by events at once after a start on θ′ = 0 or Q = 0; with R = 0 by events at the corner θ′ = 0,
    Q = 0, where all events before the first that differs have the same times; and without damping by touches, which
    come back in every turn. The final states agree.
    """
    if same_after_an_instant(path, other, case):
        return True
    if _undamped(case) and agree(*(without_touches(x, case, TOUCHES) for x in (path, other)), case):
        return True
    pairs = zip(path.kinds, other.kinds, strict=False)
    same = next((k for k, (one, two) in enumerate(pairs) if one != two), min(len(path.kinds), len(other.kinds)))
    cornered = case.drive.axial_force == 0 and same_first(path, other, same, case)
    return bool(cornered and case_judge.agree_but_corners(path, other, case))


def touches_only(path: Record, exact: Record, case: Case) -> bool:
    """Whether motions agree once what is undone at once is left out of both.

    With a second body these are modes that are left again for the mode that they came from: an undamped body that was
    released from rest comes back to rest once in each turn, for no time. Of compliant threads these are two reversals
    of an undamped contact: one that was unloaded at first comes back to N = 0 once in each turn. Where touches fill the
    list of events that ends a motion, the events that both have are compared.
    """
    if case.drive.model == "threads":
        if case.drive.contact_damping != 0:
            return False
        one, two = (_without_contact_touches(x, case) for x in (path, exact))
    else:
        one, two = (_without_instants(x, case) for x in (path, exact))
    if path.complete or exact.complete:
        return agree(one, two, case)
    count = min(len(one.kinds), len(two.kinds)) - 1  # the last one may be the first half of a touch
    return count >= MOST_EVENTS // 4 and same_first(one, two, count, case)


def same_but_touches(path: Record, exact: Record, case: Case) -> bool:
    """Whether two full lists of events of a drive without damping agree as far as both go, touches left out.

    The last one may be the first half of a touch.
    """
    if not _undamped(case):
        return False
    one, two = (without_touches(x, case, TOUCHES) for x in (path, exact))
    count = min(len(one.kinds), len(two.kinds)) - 1
    return count >= MOST_EVENTS // 4 and same_first(one, two, count, case)


def same_corners(path: Record, exact: Record, case: Case) -> bool:
    """Whether two full lists of events agree as far as both go, with events at once as corners, told at their start.

    Without a load seizures accumulate at a corner; how many of them are counted depends on the digits.
    """
    if path.complete or exact.complete:
        return False
    count = min(len(without_clusters(x.kinds, x.times, _AT_ONCE * case.duration)) for x in (path, exact)) - 1
    # The last one may not be told to its end.
    return count >= MOST_EVENTS // 4 and case_judge.same_corners(path, exact, case, count)


def dies_away(path: Record, exact: Record, case: Case) -> bool:
    """Whether motions end alike and the engine has all events of the reference, and rests where a slip has died away.

    A slip whose damping takes it below the last place of its terms is rest to the engine, until both begin to slip:
    then one body may begin before the other, by no time. So events that follow each other at once count as their last.
    """
    late, ahead = case_judge.TOLERANCE * case.duration, 0
    awaited = _clusters(exact, case)
    for kind, time in _clusters(path, case):
        if ahead < len(awaited) and kind == awaited[ahead][0] and abs(time - awaited[ahead][1]) <= late:
            ahead += 1
        elif not kind.startswith("rest"):
            return False
    return ahead == len(awaited) and case_judge.same_end(path, exact)


def beyond_input(path: Record, exact: Record, case: Case, rng: np.random.Generator) -> bool:
    """Whether motions agree but for times and states that the last places of the input decide, touches left out of all.

    Next to a touch a speed passes zero with hardly any slope, and other inputs have it touch or not.
    """

    def truth(*of) -> Record | None:
        other = exact_path(*of)
        return other and _without_instants(other, case)

    one, two = (_without_instants(x, case) for x in (path, exact))
    return one.kinds == two.kinds and case_judge.weigh(one, two, case, rng, truth)[0]


def same_after_an_instant(path: Record, other: Record, case: Case) -> bool:
    """Whether motions start on θ′ = 0 or Q = 0 and agree but for events at once, where rounding makes torque or Q."""
    if case.start[1] != -case.drive.input_speed and not _on_contact_line(case):
        return False
    later = []
    for one in (path, other):
        late = one.times > _INSTANT * case.duration
        kinds = [kind for kind, counts in zip(one.kinds, late, strict=True) if counts]
        later.append(replace(one, kinds=kinds, times=one.times[late]))
    return agree(*later, case)


def _undamped(case: Case) -> bool:
    return case.drive.support_damping == 0 == case.drive.translation_damping


def _on_contact_line(case: Case) -> bool:
    """Whether a rigid drive starts on Q = 0 but for so many last places as the engine takes for zero."""
    if case.drive.model != "rigid":
        return False
    row = [float(x) for x in coefficients(case.drive).q_row]
    terms = [a * x for a, x in zip(row, (*case.start, 1.0), strict=True)]
    return abs(math.fsum(terms)) <= case_judge.LAST_PLACES * np.finfo(float).eps * max(map(abs, terms))


def same_first(path: Record, other: Record, count: int, case: Case) -> bool:
    """Whether the first events of two motions are the same, at the same times."""
    late = np.abs(path.times[:count] - other.times[:count]).max(initial=0.0)
    return path.kinds[:count] == other.kinds[:count] and late <= case_judge.TOLERANCE * case.duration


def without_touches(path: Record, case: Case, touches: Container[tuple[str, str]]) -> Record:
    """Leave out pairs of events that follow each other at once and only touch a surface."""
    return _without_pairs(path, case, lambda kinds, kind: (kinds[-1], kind) in touches)


def _without_contact_touches(path: Record, case: Case) -> Record:
    """Leave out touches of the contact, and the first half of one at which the motion ends."""
    left = without_touches(path, case, (("contact_reversal", "contact_reversal"),))
    if left.complete and left.kinds[-1:] == ["contact_reversal"] and left.times[-1] >= (1 - _AT_ONCE) * case.duration:
        return replace(left, kinds=left.kinds[:-1], times=left.times[:-1])
    return left


def _without_instants(path: Record, case: Case) -> Record:
    """Leave out pairs of events that follow each other at once and lead back to the same mode."""
    return _without_pairs(path, case, lambda kinds, kind: kinds[-2:-1] == [kind])


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


def _clusters(path: Record, case: Case) -> list[tuple[str, float]]:
    """Kind and time of the last event of each run of events that follow each other at once."""
    last = np.append(np.diff(path.times) > _AT_ONCE * case.duration, True)[: len(path.kinds)]
    return [(kind, time) for kind, time, ends in zip(path.kinds, path.times, last, strict=True) if ends]
