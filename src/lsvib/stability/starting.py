"""Whether a drive runs evenly once it is switched on, and at which value of a parameter that changes.

What the motion ends in that begins at rest (docs/thresholds.md), the one rule of all labels says
(:mod:`lsvib.systems.attractor`); where it changes along a parameter is closed in on by halves. Slip that only touches
θ′ = 0, followed backwards in time, is the response of the oscillator with the damping −C: from w′ = 0 it comes back to
its w when C(τ) = 1. So at the smallest even speed of a rigid drive

    T_r − T = −k S(τ) |Ω|,    C(τ) = 1,

    T_r = r_m (R − F_s) ξ(μ_s) + T_s,    T = r_m (R − F_0) ξ(μ) + T_0        (Ω > 0; ξ by the sign of the force)

which encloses what the search has found and gives its derivatives. That threads, guide and bearing of a rigid drive let
go together is taken, as their shares of static friction are not determined. Armstrong-Hélouvry (Stick-slip arising from
Stribeck friction, ICRA 1990) asked the same by dimensional analysis.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive, once
from lsvib.drives.model import standing_state
from lsvib.errors import EngineError, InputError, NoThreshold
from lsvib.results import Threshold, ThresholdSolution
from lsvib.stability.motion_equations import Start
from lsvib.stability.slip import Slip, SlipDrive
from lsvib.stability.solve import Singular, samples
from lsvib.stability.threshold import newton, result
from lsvib.systems.exact.arithmetic import many_digits

if TYPE_CHECKING:
    from lsvib.systems.attractor import SteadyState

DECADES, PER_DECADE = 3, 6  # of a search, on both sides of the drive's own value
_CLOSE = 1e-12  # of a value, to which the search for a threshold closes in
_NEAR = 1e-3  # the same, where a person asks from which speed on


@once
def runs_evenly(drive: Drive, work: int = 300_000, state: tuple[float, ...] = ()) -> bool | None:
    """Whether the motion from rest, or from a ``state``, ends in steady sliding; None where ``work`` does not suffice.

    A vibration that has kept its size over the last thousand events, and more, counts as one that goes on.

    >>> [runs_evenly(Drive(static_friction_coefficient=0.4, input_speed=speed)) for speed in (1.0, 40.0)]
    [False, True]
    """
    from lsvib.systems.attractor import Attractor, Doubt

    try:
        found = end_from_rest(drive, work, state)
    except (InputError, EngineError):
        return None
    known = found.label != Attractor.UNRESOLVED or found.doubt == Doubt.RECURRENT
    return found.label == Attractor.STEADY_SLIDING if known else None


def end_from_rest(drive: Drive, work: int = 300_000, state: tuple[float, ...] = ()) -> "SteadyState":
    """Return what the motion from rest or a ``state`` ends in; ``EngineError`` where events accumulate or it grows."""
    from lsvib.systems.attractor import steady_state  # the engine, which other thresholds do without

    return steady_state(automaton_of(drive), state or standing_state(drive), max_events=work)


def even_from(evenly: Callable[[float], bool | None], tried: Sequence[float], high: float) -> float | None:
    """Return the value, such as a speed, from which on a drive runs evenly; zero if at all lower ones that are tried.

    It is looked for from ``high``, one of the ascending values ``tried``, downwards if it runs evenly there, else
    upwards, and closed in on to a part in a thousand. Infinite where it does at none of these, None where it is not
    known.
    """
    k = tried.index(high)
    even = evenly(high)
    while even is not None:
        k += -1 if even else 1
        if not 0 <= k < len(tried):
            return 0.0 if even else math.inf
        other = evenly(tried[k])
        if other is not None and other != even:
            break
        even = other
    else:
        return None
    jerks, quiet = (tried[k], tried[k + 1]) if even else (tried[k - 1], tried[k])
    while quiet - jerks > _NEAR * quiet:
        middle = math.sqrt(jerks * quiet)
        if (there := evenly(middle)) is None:
            return quiet
        jerks, quiet = (jerks, middle) if there else (middle, quiet)
    return quiet


def changes(drive: Drive, unknown: str, known: list[tuple[float, bool]]) -> Iterator[tuple[float, float]]:
    """Yield values of a parameter between which the answer changes, to 1e-12 or as far as it is known, in order."""
    for (low, even), (high, other) in pairwise(known):
        while even != other and abs(high - low) > _CLOSE * max(abs(low), abs(high)):
            middle = math.copysign(math.sqrt(low * high), low) if low * high > 0 else 0.5 * (low + high)
            there = runs_evenly(drive.replace(**{unknown: middle}))
            if there is None or middle in (low, high):
                break
            low, high = (middle, high) if there == even else (low, middle)
        if even != other:
            yield low, high


def touching(drive: Drive) -> Start:
    """Return where Newton's method starts for the equations above; raises ``NoThreshold`` where they do not hold."""
    if drive.parts or drive.collar_friction:
        raise NoThreshold("the closed form of even_speed needs a rigid drive without a collar.")
    with many_digits():
        d = SlipDrive.of(drive)
        law, _ = d.braked(d.sliding)
        one_law = (d.net - d.sliding[1]) * law > 0 or not drive.friction_coefficient
        if not (d.inertia[law] > 0 and d.damping[law] > 0 and one_law):
            raise NoThreshold("slip from the end of rest is not a damped oscillation under one law.")
        back = Slip(d.inertia[law], -d.damping[law], d.stiffness)
        if not back.turns:
            raise NoThreshold("slip from the end of rest does not turn back.")
        return Start("even+" if law > 0 else "even-", d.force, (back.recurrence(),))


def even_speed(drive: Drive, unknown: str) -> Threshold:
    """Return the even speed of a drive, or any other parameter for its own speed, by motions from rest.

    Where these meet the equations of the module's text the solutions are theirs, with derivatives.
    """
    values = samples(drive, unknown, decades=DECADES, per_decade=PER_DECADE)
    if unknown == "input_speed":
        values = [value for value in values if value * drive.input_speed > 0]
    tried = [(value, runs_evenly(drive.replace(**{unknown: value}))) for value in values]
    found, known = [], [(value, even) for value, even in tried if even is not None]
    for low, high in changes(drive, unknown, known):
        middle = 0.5 * (low + high)
        solution = ThresholdSolution(middle, (low, high), {}, "the motion from rest, by its own events")
        near = drive.replace(**{unknown: middle})
        with suppress(Singular, NoThreshold):
            closed = newton(near, unknown, touching(near), middle)
            if not near.friction_coefficient:  # with some the law would turn over where n does
                known_by = {name: one for name, one in closed.derivatives.items() if name != "friction_coefficient"}
                closed = replace(closed, derivatives=known_by)
            solution = closed if abs(closed.value - middle) <= 1e-9 * abs(middle) else solution
        found.append(solution)
    span = f"within {DECADES} decades of the drive's own value"
    words = {True: "ends in steady sliding at every", False: "does not end in steady sliding at any"}
    always = words[known[0][1]] if known else "is not known at any"
    reason = f"the motion from rest {always} {unknown} tried {span}, with all other parameters fixed."
    how = f"All found by motions from rest at {len(known)} values {span}; there may be others."
    return result(drive, "even_speed", unknown, found, how, reason)
