"""Judge the thresholds of the axial force of any rigid drive: watched motions on both sides must do what they say.

With R̃ = R − r_m tan λ c_x Ω and all forces counted in the direction of the motion (times sgn Ω):

* onset: beyond it steady sliding is left from nearby, before it nearby motions come back;
* stick: the cycle of the motion that leaves steady sliding touches θ′ = 0 beyond it, and not before it;
* detach: the cycle from the end of rest reverses the contact before it, and not beyond it;
* global stability (Painlevé region), short of the onset: between the two some motion goes on for ever, on the other
  side all come to steady sliding.

Where there is said to be none, nothing is asked but this: steady sliding that is said to be globally stable under every
force against the motion must be.
"""

import math
from collections.abc import Iterator

import numpy as np

from judge.fate import Fate, fate
from judge.second_opinions import watch
from lsvib.bench.sweeps.taylor import KINDS
from lsvib.drives.parameters import RigidParameters
from lsvib.steady_sliding import thresholds

# The thresholds, and on which side of the onset each one lies: +1 beyond it, -1 short of it.
_SIDES = {"onset_force": 0, "stick_force": 1, "detach_force": 1, "global_stability_force": -1}
_NEAR = 1e-6  # distance from the equilibrium, relative to the motion, at which motions start that leave or reach it
_ASIDE = 1e-3  # distance from the threshold on both sides, relative to |R̃| or, at the onset, to |R|
_STARTS = 24  # starts that must all come to steady sliding where it is globally stable
_POINTS = 150  # starts on each side of the end of rest whose motions might go on for ever
_FAINT = 1e-10  # damping ratio below which a return moves by no more than a few thousand of its own roundings
_FORCES = np.logspace(-4, 4, 9)  # forces, relative to the scale of the force, at which every drive is asked


def objections(drive: RigidParameters, rng: np.random.Generator) -> Iterator[tuple[str, str, str, str]]:
    """Ask every threshold of a drive; yields its name, a verdict, what it says, and the truth.

    The verdict is right, wrong, undecided, or not run, where the program says that there is no such threshold.
    """
    for name in _SIDES:
        try:
            force = getattr(thresholds, name)(drive)
        except thresholds.NoThreshold as absent:
            yield name, *_absent(drive, name, str(absent), rng)
            continue
        if not math.isfinite(force):
            yield name, "wrong", f"{force} N", "a finite force"
            continue
        ahead = (force - _onset(drive)) * math.copysign(1.0, drive.input_speed)
        side = _SIDES[name]
        if side and not ahead * side > 0:
            yield name, "wrong", f"{force} N", f"{'beyond' if side > 0 else 'short of'} the onset, {_onset(drive)} N"
            continue
        size = abs(ahead) if side else abs(force) or 1.0
        beyond, before = (_at(drive, force, aside, size) for aside in (_ASIDE, -_ASIDE))
        yield name, *_JUDGES[name](beyond, before, f"{force} N", rng)


def _onset(drive: RigidParameters) -> float:
    d = watch.constants(dict(drive))
    return drive.axial_force - d.net_force


def _at(drive: RigidParameters, force: float, aside: float, size: float) -> watch.WatchConstants:
    """The drive with an axial force a little beyond (aside > 0) a threshold, or before it."""
    moved = force + math.copysign(1.0, drive.input_speed) * aside * size
    return watch.constants({**dict(drive), "axial_force": moved})


def _size_of(c: watch.WatchConstants) -> float:
    return abs(c.speed) / math.sqrt(c.flow[1, 1])


def _judge_onset(beyond: watch.WatchConstants, before: watch.WatchConstants, said: str, rng) -> tuple[str, str, str]:
    verdicts = []
    for c, stable in ((beyond, False), (before, True)):
        near = _NEAR * min(_size_of(c), abs(c.contact[2] / c.contact[0]))
        found = fate(c, near, 0.0)
        if found.name == "unknown":
            return "undecided", said, found.reason
        verdicts.append((found.name == "steady_sliding") == stable)
    return "right" if all(verdicts) else "wrong", said, f"beyond, before as it should be: {verdicts}"


def _judge_stick(beyond: watch.WatchConstants, before: watch.WatchConstants, said: str, rng) -> tuple[str, str, str]:
    for c, aside in ((beyond, _ASIDE), (before, -_ASIDE)):
        if np.all(np.abs(c.flow[:, 0]) < _FAINT * np.sqrt(c.flow[:, 1])):
            return "undecided", said, "a damping too faint for the return map of a watched motion"
        stops = aside > 0
        found = fate(c, _NEAR * abs(c.contact[2] / c.contact[0]), 0.0)
        if found.name == "unknown":
            return "undecided", said, found.reason
        if found.name not in ("stick_slip_cycle", "other_cycle") or found.stops != stops:
            told = f"{found.name}, which {'touches' if found.stops else 'does not touch'} it ({found.reason})"
            return "wrong", f"{said}: the cycle touches θ′ = 0 is {stops} at {aside:+g}", told
    return "right", "", ""


def _judge_detach(beyond: watch.WatchConstants, before: watch.WatchConstants, said: str, rng) -> tuple[str, str, str]:
    for c, aside in ((beyond, _ASIDE), (before, -_ASIDE)):
        reverses = aside < 0
        kinds = _first_slip(c)
        if kinds is None:
            return "undecided", said, "a guard that cannot be told in double precision"
        if (watch.CONTACT_REVERSAL in kinds) != reverses:
            return "wrong", f"{said}: reverses {reverses} at {aside:+g}", f"{[KINDS[k] for k in kinds[:4]]}"
    return "right", "", ""


def _first_slip(c: watch.WatchConstants) -> list[int] | None:
    """Kinds of the events from the end of rest until the next rest, or of some if there is none."""
    room = 64
    times, kinds, modes = np.empty(room), np.empty(room, dtype=np.int64), np.empty(room, dtype=np.int64)
    mode = watch.coded(int(math.copysign(1, c.speed)), c.force_sign, watch.RELEASE)
    end, count, *_ = watch.watch(
        c, c.released, -c.speed, mode, math.inf, True, times, kinds, modes, np.empty((room, 2))
    )
    if end == watch.AMBIGUOUS:
        return None
    found = kinds[:count].tolist()
    return found[: found.index(watch.STICK)] if watch.STICK in found else found


def _judge_global(beyond: watch.WatchConstants, before: watch.WatchConstants, said: str, rng) -> tuple[str, str, str]:
    """Some motion goes on beyond the threshold, where less force acts against it, and none does before it.

    Next to the threshold the starts of such motions may be few: they need not be among those that are drawn.
    """
    if all(found.name == "steady_sliding" for _, found in _fates(beyond, rng)):
        return "undecided", f"{said}: some motion goes on at {_ASIDE:+g}", "none of the starts does"
    return _all_come_to_rest(before, f"{said} at {-_ASIDE:+g}", rng)


def _fates(c: watch.WatchConstants, rng) -> Iterator[tuple[tuple[float, float], Fate]]:
    """Draw starts and tell the fates of those that do not settle at once, as most of them do.

    They are on θ′ = 0 the end of rest, and points on both sides of it over ten decades; others anywhere.
    """
    parts = np.logspace(-6, 4, _POINTS)
    widest = [(c.released + part * _size_of(c), -c.speed) for part in (0.0, *parts, *-parts)]
    size = _size_of(c) * 10 ** rng.uniform(-1, 2, _STARTS)
    angle = rng.uniform(0, 2 * math.pi, _STARTS)
    drawn = zip(size, angle, strict=True)
    anywhere = [(x * math.cos(a), x * math.sin(a) * abs(c.speed) / _size_of(c)) for x, a in drawn]
    starts = np.array([*widest, *anywhere])
    for start in map(tuple, starts[~watch.come_to_rest(c, starts)].tolist()):
        yield start, fate(c, *start)


def _all_come_to_rest(c: watch.WatchConstants, said: str, rng) -> tuple[str, str, str]:
    unknown = 0
    for (u, w), found in _fates(c, rng):
        unknown += found.name == "unknown"
        if found.name not in ("steady_sliding", "unknown"):
            return "wrong", said, f"{found.name} from u = {u!r}, w = {w!r} ({found.reason})"
    return ("undecided", said, "unknown") if unknown else ("right", "", "")


def _absent(drive: RigidParameters, name: str, reason: str, rng) -> tuple[str, str, str]:
    if name != "global_stability_force" or "globally stable" not in reason:
        return "not run", reason, ""
    onset = _onset(drive)
    scale = max(abs(onset), 1e-3)
    for part in _FORCES:
        force = -math.copysign(part * scale, drive.input_speed)
        there = watch.constants({**dict(drive), "axial_force": force})
        verdict = _all_come_to_rest(there, f"{reason} R = {force}", rng)
        if verdict[0] != "right":
            return verdict
    return "right", "", ""


_JUDGES = {
    "onset_force": _judge_onset,
    "stick_force": _judge_stick,
    "detach_force": _judge_detach,
    "global_stability_force": _judge_global,
}
