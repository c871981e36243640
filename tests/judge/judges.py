"""Judge what the program says about one random drive against computations that share nothing with it.

Every question is a *stage*, a function without arguments that returns findings, or a function that does: then the
program has answered, and only judging is left. Who runs them may stop a stage that takes too long and go on with the
next.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from mpmath import mp

from judge import boundary_judge, excuses, linear_judge, long_run, second_paths, threshold_judge
from judge.fate import Fate, fate
from judge.second_opinions import watch
from judge.second_opinions.stride_constants import Ladders
from judge.wide_drives import WideDrive, wide_drive
from lsvib.basins.mapper import mapper
from lsvib.basins.slice_mapper import Destiny
from lsvib.bench.record import Record, Verdict
from lsvib.bench.reference.rigid_digits import RigidTrueDrive
from lsvib.bench.sweeps import case_judge, paths
from lsvib.bench.sweeps.energy_balance import balance, terms
from lsvib.bench.sweeps.energy_quadrature import Terms
from lsvib.bench.sweeps.families import MOST_TURNS, Case, CaseFamily, CaseGroup
from lsvib.cycles.attractors import Attractor, SteadyState, steady_state
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.registry import find_model
from lsvib.drives.rigid import rigid_automaton
from lsvib.engine.automaton import Automaton
from lsvib.engine.motion import Motion, follow
from lsvib.errors import InputError, LsvibError
from lsvib.steady_sliding.stability_table import stability_table

GOOD = RIGHT, CORNER, BEYOND_INPUT = tuple(v.words for v in (Verdict.RIGHT, Verdict.CORNER, Verdict.BEYOND_INPUT))
# Crashed: an error that is not one of the library's sentences, or a process that died. Late: more processor time than
# is allowed. Unresolved: the program says that it does not know. Undecided: the judge does not know.
BAD = WRONG, CRASHED, LATE = Verdict.WRONG.words, "crashed", "late"
REFUSED, UNRESOLVED, UNDECIDED = Verdict.REFUSED.words, "unresolved", "undecided"
UNNOTED = *GOOD, Verdict.NOT_RUN.words  # findings that are only counted
QUESTIONS = ("stability", "motion", "attractor", "threshold", "label")
_EDGE = ("neutral_family", "stick_slip_cycle", "other_cycle")  # all right for the orbit that touches θ′ = 0
_EIGENVALUES = 1e-12  # relative error of an eigenvalue that is right
_SHORTEST = 0.3  # motion, in turns of the slow oscillation
_FAMILIES = {"threads": CaseFamily.CONTACT, "support": CaseFamily.SUPPORT, "nut": CaseFamily.NUT}
# Seed and indices of drives for which kernels are compiled ahead that a harmless drive does not need: leaps along a
# return map and the Taylor stepper (rigid), modes in blocks (the others).
_COMPILED_FOR = {"rigid": (9001, 2, 4, 10), "threads": (11, 3), "support": (11, 49)}
_CONFIRMING = 12  # leading events that the reference must confirm
_BESIDE = (1 - 1e-10, 1 + 1e-10)  # factors for starts beside a start; the motions themselves agree to 7e-11


class Finding(NamedTuple):
    """Verdict on one question; ``start``: index of the start, or None; ``said``, ``truth``: in words."""

    verdict: str
    start: int | None = None
    said: str = ""
    truth: str = ""


Stage = tuple[str, Callable[[], list[Finding] | Callable[[], list[Finding]]]]


def stages(wide: WideDrive, questions: Iterable[str] = QUESTIONS) -> Iterator[Stage]:
    """Yield the questions that are asked about a drive."""
    wanted = set(questions)
    return (stage for stage in _stages(wide, wanted) if stage[0] in wanted)


def _stages(wide: WideDrive, wanted: set[str]) -> Iterator[Stage]:
    yield "stability", lambda: [_stability(wide)]
    if wide.model != "rigid":
        cases = lru_cache(lambda: four_cases(wide))
        constants = lru_cache(lambda: second_paths.case_ladders(cases()[0], max(case.duration for case in cases())))
        model = lru_cache(lambda: paths.automaton(cases()[0]))
        energies = lru_cache(lambda: terms(model(), wide.drive, wide.physics))
        for k in range(len(wide.starts)):
            yield "motion", lambda k=k: _four_motion(wide, k, cases()[k], constants(), model(), energies())
        long = lru_cache(lambda: long_run.constants_of(wide))
        truth = lru_cache(lambda k: long_run.fate(wide, k, *long()))
        mapped = lru_cache(lambda: mapper(wide.drive, wide.model, wide.physics))
        yield "threshold", lambda: _thresholds(wide)
        asked = (
            ("attractor", lambda state: steady_state(model(), state)),
            ("label", lambda state: mapped().destiny(state)),
        )
        for question, answer in asked:
            for k in range(len(wide.starts)):
                yield question, lambda k=k, answer=answer: _four_label(wide, k, answer, truth, long)
        return
    constants = watch.constants(dict(wide.drive))
    automaton = lru_cache(lambda: rigid_automaton(wide.drive))  # its first use counts its construction
    energies = lru_cache(lambda: terms(automaton(), wide.drive))
    for k in range(len(wide.starts)):
        yield "motion", lambda k=k: [_motion(wide, k, constants, automaton(), energies())]
    truths = [fate(constants, *start) for start in wide.starts] if wanted & {"attractor", "label"} else []
    for k, truth in enumerate(truths):
        yield "attractor", lambda k=k, truth=truth: [_attractor(wide, k, truth, automaton())]
    yield "threshold", lambda: _thresholds(wide)
    yield "label", lambda: _labels(wide, truths)


def warm_up(model: str, questions: Iterable[str] = QUESTIONS) -> None:
    """Ask everything about a harmless drive, so that compiling is no part of the time of any other."""
    kind = find_model(model)
    drive = kind.drive.of({"mass": 5.0, "support_damping": 1e-3})
    start = kind.initial_state(drive, {key: 0.1 for key in kind.required})
    seed, *indices = _COMPILED_FOR.get(model, (0,))
    others = [wide_drive(model, seed, index, 4 if model == "rigid" else 1) for index in indices]
    for wide in (WideDrive(model, 0, 0, drive, (), np.array([start])), *others):
        for _, ask in stages(wide, questions):
            ask()


def _motion(
    wide: WideDrive, k: int, constants: watch.WatchConstants, automaton: Automaton, energies: Terms | None = None
) -> Finding:
    """Follow a motion for some turns; the closed form judges, and where it disagrees all others do."""
    case = motion_case(wide, k)
    try:
        motion = follow(automaton, case.start, case.duration, max_events=paths.MOST_EVENTS)
    except LsvibError as error:
        return Finding(REFUSED, k, str(error))
    path = paths.engine_path(motion, case)
    if case.start == (0.0, 0.0) and fate(constants, 0.0, 0.0).name == "steady_sliding":  # on Q = 0 if R̃ = 0
        return Finding(WRONG if path.kinds or path.end.any() else RIGHT, k, "leaves the equilibrium")
    other = second_paths.watched_path(case, constants, path.size)
    if other is not None:
        same = excuses.agree(path, other, case)
        if (same or excuses.at_corner(path, other, case)) and _balanced(motion, wide, energies):
            return Finding(RIGHT if same else CORNER, k)
    exact = paths.exact_path(case, wide.drive, case.start)
    if exact is None:
        return Finding(UNDECIDED, k, "the reference does not decide")
    if excuses.same_after_an_instant(path, exact, case):
        return Finding(CORNER, k)
    # Touches of θ′ = 0, which are left out, fill the list of events that ends a motion.
    count = min(len(path.kinds), len(exact.kinds))
    full = not (path.complete or exact.complete) and count >= paths.MOST_EVENTS // 2
    if full and excuses.same_first(path, exact, count, case):
        return Finding(RIGHT, k)
    if full and excuses.same_but_touches(path, exact, case):
        return Finding(CORNER, k)
    # Without a net force rest ends on Q = 0: a corner on every such orbit.
    if constants.net_force == 0 and case_judge.same_end(path, exact) and _balanced(motion, wide, energies):
        return Finding(CORNER, k)
    return _by_reference(wide, k, case)


def _balanced(motion: Motion, wide: WideDrive, energies: Terms | None) -> bool:
    """Whether the energy of a motion balances."""
    drawn = balance(motion, wide.drive, wide.physics, energies)
    return not drawn.residual > case_judge.allowed_residual(drawn.rounding)


def _four_motion(
    wide: WideDrive, k: int, case: Case, constants: Ladders, automaton: Automaton, energies: Terms | None = None
) -> list[Finding] | Callable[[], list[Finding]]:
    """Follow a motion of a drive with four states; strides judge, and where they disagree the reference does."""
    try:
        motion = follow(automaton, case.start, case.duration, max_events=paths.MOST_EVENTS)
    except LsvibError as error:
        return [Finding(REFUSED, k, str(error))]
    path = paths.engine_path(motion, case)
    if not any(case.start) and linear_judge.carries_no_force(wide):  # the equilibrium, on N = 0
        return [Finding(WRONG if path.kinds or path.end.any() else RIGHT, k)]
    other = second_paths.strides_path(case, constants)
    if other is not None and excuses.agree(path, other, case) and _balanced(motion, wide, energies):
        return [Finding(RIGHT, k)]

    def judged() -> list[Finding]:
        """Ask the strides and the reference once more, and excuse what both sides may tell differently."""
        finding = _by_strides(wide, k, case, path, other, _balanced(motion, wide, energies))
        exact = paths.exact_path(case, case.drive, case.start) if finding.verdict == WRONG else None
        if exact is None or not _balanced(motion, wide, energies):
            return [finding]
        if any(alike(path, exact, case) for alike in (excuses.touches_only, excuses.dies_away, excuses.same_corners)):
            return [Finding(CORNER, k)]
        rng = np.random.default_rng([wide.seed, wide.index, k])
        return [Finding(BEYOND_INPUT, k) if excuses.beyond_input(path, exact, case, rng) else finding]

    return judged


def _four_label(
    wide: WideDrive,
    k: int,
    answer: Callable[[np.ndarray], SteadyState | Destiny],
    truth: Callable[[int], long_run.Fate],
    long: Callable[[], tuple[Ladders, float]],
) -> Callable[[], list[Finding]]:
    """Name where a motion of a drive with four states ends; a long run by strides judges, as far as it decides."""
    found = answer(wide.starts[k])
    name = found.label.name.lower()

    def beside() -> str:
        """Verdict on another name than that of the long run: a corner if both change from start to start beside it."""
        starts = np.array([wide.starts[k] * part for part in _BESIDE])
        if truth(k).name not in {answer(start).label.name.lower() for start in starts}:
            return WRONG
        fates = {long_run.fate(wide._replace(starts=starts), j, *long()).name for j in range(len(starts))}
        return CORNER if name in fates else UNDECIDED if "unknown" in fates else WRONG

    # The long run takes no part of the program's time.
    return lambda: [compared(wide, k, truth(k), name, found.doubt or "", beside)]


def _by_strides(wide: WideDrive, k: int, case: Case, path: Record, other: Record | None, balanced: bool) -> Finding:
    """Whether strides excuse a difference, by touches or by the digits of the input; else the reference decides."""
    if other is not None:
        if excuses.touches_only(path, other, case) and balanced:
            return Finding(CORNER, k)
        finding = _by_reference(wide, k, case, second_paths.quick_path)
        if finding.verdict in (CORNER, BEYOND_INPUT):
            return finding
    return _by_reference(wide, k, case)


def four_case(wide: WideDrive, k: int, fastest: float) -> Case:
    """Motion ``k`` of a drive with four states: up to three turns of the slow oscillation, or six of the fastest.

    ``fastest`` [rad/s]: imaginary part of a rate near steady sliding.
    """
    turn = 2 * math.pi * math.sqrt(wide.drive.screw_inertia / wide.drive.coupling_stiffness)
    return _case(wide, k, _FAMILIES[wide.model], turn, 3.0, MOST_TURNS * 2 * math.pi / (fastest or 1e-9))


def four_cases(wide: WideDrive) -> list[Case]:
    """Return the motions of a drive with four states that are judged."""
    fastest = max(abs(float(mp.im(x))) for x in linear_judge.rates(wide))
    return [four_case(wide, k, fastest) for k in range(len(wide.starts))]


def _by_reference(wide: WideDrive, k: int, case: Case, truth: case_judge.Truth = paths.exact_path) -> Finding:
    outcome = case_judge.judge(case, np.random.default_rng([wide.seed, wide.index, k]), by_reference=True, truth=truth)
    verdict = outcome.verdict.words if outcome.verdict.words in (*GOOD, REFUSED) else WRONG
    if verdict == WRONG and math.isnan(outcome.state_error) and paths.exact_path(case, case.drive, case.start) is None:
        verdict = UNDECIDED
    detail = f"{outcome.verdict.name.lower()}, state {outcome.state_error:.1e}, time {outcome.time_error:.1e}"
    return Finding(verdict, k, detail)


def motion_case(wide: WideDrive, k: int) -> Case:
    """Motion ``k`` of a rigid drive: its start, and up to four turns of the slow oscillation."""
    return _case(wide, k, CaseFamily.RANDOM, _slow_turn(wide.drive), 4.0)


def _case(wide: WideDrive, k: int, family: CaseFamily, turn: float, turns: float, longest: float = math.inf) -> Case:
    """Motion ``k`` of a drive for up to so many ``turns`` [s], but not longer than ``longest`` [s]."""
    rng = np.random.default_rng([wide.seed, wide.index, k])
    duration = min(turn * rng.uniform(_SHORTEST, turns), longest)
    return Case(family, CaseGroup.ONLY, 0.0, wide.drive, tuple(map(float, wide.starts[k])), duration, wide.physics)


@lru_cache(maxsize=2)  # one drive is asked after the other
def _slow_turn(drive: RigidParameters) -> float:
    """Duration [s] of a turn of the slow oscillation of a rigid drive."""
    return 2 * math.pi * float(RigidTrueDrive(dict(drive), 20).u_scale) / abs(drive.input_speed)


def _attractor(wide: WideDrive, k: int, truth: Fate, automaton: Automaton) -> Finding:
    found = steady_state(automaton, wide.starts[k])
    return compared(wide, k, truth, found.label.name.lower(), found.doubt or "")


def _labels(wide: WideDrive, truths: list[Fate]) -> list[Finding]:
    labels = mapper(wide.drive).labels_of(wide.starts[:, 0], wide.starts[:, 1])
    names = [Attractor(label).name.lower() for label in labels]
    return [compared(wide, k, truth, name) for k, (truth, name) in enumerate(zip(truths, names, strict=True))]


def _thresholds(wide: WideDrive) -> list[Finding]:
    rng, rigid = np.random.default_rng([wide.seed, wide.index]), wide.model == "rigid"
    found = threshold_judge.objections(wide.drive, rng) if rigid else boundary_judge.objections(wide, rng)
    return [Finding(verdict, None, f"{name}: {said}", truth) for name, verdict, said, truth in found]


def compared(
    wide: WideDrive, k: int, truth: Fate, name: str, doubt: str = "", otherwise: Callable[[], str] | None = None
) -> Finding:
    """Verdict on the name of an attractor, by the fate of the motion; ``doubt``: why it is unresolved.

    ``otherwise``: called for the verdict on another name than the judge's, if the reference need not confirm the judge.
    """
    told = f"{truth.name} ({truth.reason})"
    if name == "unbounded" and wide.model != "threads":  # see judge.fate
        return Finding(WRONG, k, name, told)
    if name == "unresolved":
        return Finding(UNRESOLVED, k, doubt or name, told)
    if name == truth.name or (truth.edge and name in _EDGE):
        return Finding(RIGHT, k)
    if truth.name == "unknown":
        return Finding(UNDECIDED, k, name, told)
    verdict = otherwise() if otherwise else WRONG if _confirmed(wide, k) else UNDECIDED
    return Finding(verdict, k, name, told)


def _confirmed(wide: WideDrive, k: int) -> bool:
    """Whether the reference has the first events that the watcher has, at the same times."""
    case = motion_case(wide, k)
    exact = paths.exact_path(case, wide.drive, case.start)
    watched = None if exact is None else second_paths.watched_path(case, watch.constants(dict(wide.drive)), exact.size)
    if watched is None:
        return False
    count = min(len(exact.kinds), len(watched.kinds), _CONFIRMING)
    if count < _CONFIRMING and len(exact.kinds) != len(watched.kinds):
        return False
    return excuses.same_first(watched, exact, count, case)


def _stability(wide: WideDrive) -> Finding:
    """The table's verdict and eigenvalues against those of Newton's laws with 120 digits."""
    try:
        table = stability_table(dict(wide.drive), wide.model)
    except InputError as error:
        return Finding(RIGHT if linear_judge.carries_no_force(wide) else REFUSED, None, str(error))
    exact = linear_judge.rates(wide)
    stable = linear_judge.stable(exact)
    found = [mp.mpc(x["real"], x["imaginary"]) for x in table["eigenvalues"]]
    gap = max(float(min(abs(x - y) for y in found) / abs(x)) for x in exact)
    if table["stable"] != stable or gap > _EIGENVALUES:
        said = f"stable {table['stable']}, {table['class']}, eigenvalues off by {gap:.1e}"
        return Finding(WRONG, None, said, f"stable {stable}, {[mp.nstr(x, 8) for x in exact]}")
    return Finding(RIGHT)
