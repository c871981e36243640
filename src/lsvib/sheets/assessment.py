"""The whole verdict on one data sheet, as values ready for the report, the dataset and JSON."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.errors import InputError
from lsvib.sheets import vibration as motions
from lsvib.sheets.changes import ANY, Change, advice, margins
from lsvib.sheets.draw import Draw
from lsvib.sheets.from_rest import FromRest, Starter, from_rest
from lsvib.sheets.operation import Operation
from lsvib.sheets.reserves import NAMES
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import Statics, statics
from lsvib.sheets.uncertainty import Uncertainty, WorstCase, ends, study, worst_cases
from lsvib.sheets.window import OperatingWindow
from lsvib.sheets.words import TOLERATED


@dataclass(frozen=True)
class Finding:
    """What is found of one mechanism, see :mod:`lsvib.sheets.reserves`.

    ``occurs`` at the middle values somewhere in the window; the lowest ``reserve`` [1], at ``there``; ``probability``
    with ``interval``; ``margins``, nearest first. None is what is not known.
    """

    name: str
    occurs: bool | None
    reserve: float
    there: Operation
    probability: float | None
    interval: tuple[float, float] | None
    margins: list[Change]


Findings = dict[str, Finding]
Cases = dict[str, WorstCase]


@dataclass(frozen=True)
class AssessedMotion:
    """A motion to show: of which mechanism, at which point of operation of which drive, and what came of it."""

    mechanism: str
    there: Operation
    vibration: motions.Vibration
    tolerated: motions.Tolerated


@dataclass(frozen=True)
class Assessment:
    """A data sheet with all that is said of it.

    ``draw``: the drive at the middle values; ``verdict``: a key of
    :data:`lsvib.sheets.words.VERDICTS`; ``efficiency`` [1] ``lifting``, ``lowering`` (None if self-locking);
    ``margins``: those of all mechanisms together, nearest first; ``nominal``, ``worst``: the motion at the middle
    values and in the worst case, each where the reserve is lowest; ``from_rest``: what it does when it is switched on;
    ``changes`` of one quantity that end vibration or jerks, those that end all of it first.
    """

    draw: Draw
    seed: int
    verdict: str
    efficiency: dict[str, Any]
    self_locking: bool
    mechanisms: dict[str, Finding]
    margins: list[Change]
    uncertainty: Uncertainty
    nominal: AssessedMotion
    worst: AssessedMotion
    statics: Statics
    from_rest: FromRest
    changes: list[Change]

    @property
    def names(self) -> list[str]:
        """The names of the mechanisms proper, those that occur or are nearest first."""
        own = [name for name in self.mechanisms if name != "after_perturbation"]
        return sorted(own, key=lambda name: self.mechanisms[name].reserve)

    @property
    def nearest(self) -> tuple[str, Change] | None:
        """The mechanism, and the change of one quantity, by which vibration sets in first; None if by none."""
        found = self.mechanisms
        near = [(name, row) for name in self.names for row in found[name].margins if row.factor is not None]
        return min(near, key=lambda one: abs(math.log(one[1].factor or 1.0)), default=None)


def assess(sheet: Sheet, samples: int = 4096, seed: int = 1) -> Assessment:
    """Assess a data sheet; arguments as :func:`lsvib.sheets.uncertainty.study`. Raises ``InputError``."""
    draw = Draw.of(sheet)
    window = OperatingWindow(draw)
    _require_a_drive(window)
    rows, spread, edges = statics(sheet), study(sheet, samples, seed), margins(draw)
    found = _mechanisms(window, spread, edges)
    lifting, lowering = map(float, draw.efficiencies)
    cases = worst_cases(sheet, spread.lowest)
    nominal = _motion(window, _critical(found))
    if not any(one.occurs for one in found.values()) and _upset(nominal):
        sure: dict[str, Any] = {"probability": 1.0, "interval": (1.0, 1.0)} if spread.samples == 1 else {}
        perturbed = replace(found["after_perturbation"], occurs=True, there=nominal.there, **sure)
        found["after_perturbation"] = perturbed  # as the motion shows it, whatever its reserve says
    starter = Starter(sheet)
    started = _started(draw, found, cases, spread, nominal, starter)
    worst_motion = _worst_motion(sheet, found, cases, spread.upset) if cases else nominal
    verdict = _verdict(found, spread, cases, worst_motion, started)
    if verdict == "jerks" and started.motion is not None:
        nominal = worst_motion = AssessedMotion("from_rest", started.there, started.motion, (None, ""))
    return Assessment(
        draw=draw,
        seed=seed,
        verdict=verdict,
        efficiency={"lifting": lifting, "lowering": lowering if lowering > 0 else None},
        self_locking=lowering <= 0,
        mechanisms=found,
        margins=edges[ANY],
        uncertainty=spread,
        nominal=nominal,
        worst=worst_motion,
        statics=rows,
        from_rest=started,
        changes=advice(draw, edges[ANY], verdict == "vibrates", starter) if verdict in ("vibrates", "jerks") else [],
    )


def _require_a_drive(window: OperatingWindow) -> None:
    """Refuse what the package has no drive for, in the words of the sheet."""
    if unasked := window.draw.sheet.of_statics:
        raise InputError(f"Whether it vibrates cannot be asked: {unasked}.")
    for there in window.corners:
        try:
            _ = there.rigid, there.drive
        except InputError as error:
            if "friction_coefficient" in str(error):
                raise InputError(
                    "friction is so strong that the threads jam whatever the torque, coefficient >= cot(lead "
                    "angle); lower friction or the lead of the thread."
                ) from None
            raise InputError(f"The data sheet makes a drive that is out of range: {error}") from None


def _mechanisms(window: OperatingWindow, spread: Uncertainty, edges: dict[str, list[Change]]) -> Findings:
    found = {}
    for name, one in window.worst.items():
        there, reserve, often = window.critical(name), float(one.reserve[0]), spread.probability[name]
        occurs: bool | None = reserve < 0
        if name == "after_perturbation":
            occurs, _, first = window.most_perturbed if window.draw.sheet.stiff else (None, None, None)
            there = first or there
        found[name] = Finding(name, occurs, reserve, there, often.value, often.interval, edges[name])
    return found


def _started(
    draw: Draw, found: Findings, cases: Cases, spread: Uncertainty, nominal: AssessedMotion, starter: Starter
) -> FromRest:
    """What becomes of a start from rest, which is followed where nothing else tells."""
    middle = min(one.reserve for one in found.values())
    lowest = min(middle, *(case for case, _ in cases.values()), 1.0)
    unstable = any(one.occurs for name, one in found.items() if name != "after_perturbation")
    if draw.sheet.stiff and not draw.sheet.followed and lowest > 0:  # then slip shrinks every area
        return FromRest(False, nominal.there, 0.0)
    if not draw.sheet.followed and (unstable or middle == 0):
        # A start from rest tells nothing new: it cannot become steady, as nothing damps it, or worse.
        return FromRest(None, nominal.there, None)
    shares = (spread.points[:, : starter.draws], ends(draw.sheet, starter.ends)) if draw.sheet.random else ()
    return from_rest(draw, starter, *((Draw.of(draw.sheet, one) for one in part.T) for part in shares))


def _upset(motion: AssessedMotion) -> bool:
    """Whether a perturbation is known to start vibration: by where the motion ends, or by what it tolerates.

    A drive that nothing damps tolerates none, yet none starts more than a swing of its size: there only a
    perturbation above zero decides.
    """
    size, end = motion.tolerated[0], motion.vibration.attractor
    if end in motions.UNDECIDED:
        return size is not None and 0 < size < math.inf
    return end != "steady sliding" or (size is not None and math.isfinite(size))


def _verdict(found: Findings, spread: Uncertainty, cases: Cases, worst: AssessedMotion, started: FromRest) -> str:
    """The verdict, a key of :data:`lsvib.sheets.words.VERDICTS`."""
    steady = [one for name, one in found.items() if name != "after_perturbation"]
    if any(one.occurs for one in steady):
        return "vibrates"
    if started.jerks:
        return "jerks"
    if spread.any.value > 0:
        return "may vibrate"
    if started.jerky:
        return "may jerk"
    if found["after_perturbation"].occurs or (found["after_perturbation"].probability or 0) > 0:
        return "steady until perturbed"
    if started.ends or any(cases[name][0] < 0 for name in cases if name in NAMES) or _upset(worst):
        return "steady but for rare values"
    if min(one.reserve for one in steady) == 0 and not started.there.draw.sheet.followed:
        return "steady without reserve"
    if started.jerks is None or started.unknown or started.ends is None:
        return "start not known"
    return "steady without reserve" if min(one.reserve for one in steady) == 0 else "steady"


def _critical(found: Findings) -> str:
    """The mechanism with the lowest reserve; vibration after a perturbation counts only where nothing else occurs."""
    own = {name: one for name, one in found.items() if name != "after_perturbation"}
    name = min(own, key=lambda key: own[key].reserve)
    perturbed = found["after_perturbation"]
    possible = perturbed.occurs or (perturbed.occurs is None and perturbed.reserve < 0)
    return "after_perturbation" if own[name].reserve > 0 and possible else name


def _motion(window: OperatingWindow, name: str) -> AssessedMotion:
    sheet, there = window.draw.sheet, window.critical(name)
    if name == "after_perturbation" and sheet.support is None:
        there = window.most_perturbed[2] or there
    if name == "falling_friction" and window.worst[name].reserve[0] < 0 and not sheet.friction.law:
        reason = "friction that falls with speed makes steady running unstable there; the motion beyond that onset is "
        beyond = motions.Vibration((), "unknown", reason=reason + "not computed, only the onset.")
        return AssessedMotion(name, there, beyond, (0.0, TOLERATED["unstable"].format(threads="")))
    strong = -motions.STRONG if name == "after_perturbation" else motions.NUDGE
    moved = there.motion(strong)
    if moved.attractor in ("unknown", "unresolved") and sheet.parts:  # the simpler drive says more than nothing
        moved = there.motion(strong, stiff=True)
    tolerated = (None, "") if sheet.support is not None else there.tolerated
    if sheet.support is None and not sheet.closed and (sheet.parts or tolerated[0] is None):
        tolerated = motions.tolerated_by_trial(there.drive, tolerated[0], sheet.parts)
    return AssessedMotion(name, there, moved, tolerated)


def _worst_motion(sheet: Sheet, found: Findings, cases: Cases, upset: NDArray[np.float64] | None) -> AssessedMotion:
    """The motion at the worst values within the uncertainties, of the mechanism that is most likely or nearest."""
    own = {name: reserve for name, (reserve, _) in cases.items() if name != "after_perturbation"}
    name = min(own, key=lambda key: (-(found[key].probability or 0), own[key]))
    if own[name] > 0 > cases["after_perturbation"][0]:
        name = "after_perturbation"
    shares = cases[name][1] if name != "after_perturbation" or upset is None else upset
    return _motion(OperatingWindow(Draw.of(sheet, shares)), name)
