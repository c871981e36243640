"""The whole verdict on one data sheet, as values ready for the report, the dataset and JSON."""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lsvib.assess import mechanisms
from lsvib.assess import vibration as motions
from lsvib.assess.drive import Corner, Values, efficiencies, nominal_draw, quantities
from lsvib.assess.margins import ANY, Margin, margins, sensitivities
from lsvib.assess.mechanisms import corners, worst
from lsvib.assess.sheet import Sheet
from lsvib.assess.starting import Starting, starting
from lsvib.assess.statics import Statics, statics
from lsvib.assess.uncertainty import Uncertainty, WorstCase, entries_of, study, worst_cases
from lsvib.errors import InputError


@dataclass(frozen=True)
class Mechanism:
    """What is said of one mechanism, see :mod:`lsvib.assess.mechanisms`.

    ``occurs`` at the middle values somewhere in the window; ``reserve`` [1] there, at ``corner`` (direction, speed of
    the screw [rad/s], force [N]); ``probability`` with ``interval``; ``margins``, nearest first; ``sensitivities``.
    None is what is not known.
    """

    name: str
    occurs: bool | None
    reserve: float
    corner: Corner
    probability: float | None
    interval: tuple[float, float] | None
    margins: list[Margin]
    sensitivities: dict[str, float]


@dataclass(frozen=True)
class AssessedMotion:
    """A motion to show: of which mechanism, with which values, where in the window, and what came of it."""

    mechanism: str
    entries: dict[str, float]
    values: Values
    corner: Corner
    vibration: motions.Vibration
    tolerated: tuple[float | None, str]


@dataclass(frozen=True)
class Assessment:
    """A data sheet with all that is said of it.

    ``values``: :data:`lsvib.assess.drive.QUANTITIES` at the middle values; ``verdict``: a key of
    :data:`lsvib.assess.words.VERDICTS`; ``efficiency`` [1] ``lifting``, ``lowering`` (None if self-locking);
    ``margins``: those of all mechanisms together, nearest first; ``nominal``, ``worst``: the motion at the middle
    values and in the worst case, each where the reserve is lowest; ``starting``: what it does when it is switched on.
    """

    sheet: Sheet
    seed: int
    values: Values
    verdict: str
    efficiency: dict[str, Any]
    self_locking: bool
    mechanisms: dict[str, Mechanism]
    margins: list[Margin]
    uncertainty: Uncertainty
    nominal: AssessedMotion
    worst: AssessedMotion
    statics: Statics
    starting: Starting


def assess(sheet: Sheet, samples: int = 4096, seed: int = 1) -> Assessment:
    """Assess a data sheet; arguments as :func:`lsvib.assess.uncertainty.study`. Raises ``InputError``."""
    entries = nominal_draw(sheet)
    values = _values(sheet, entries)
    _require_a_drive(sheet, values)
    spread = study(sheet, samples, seed)
    edges = margins(sheet, values)
    found = _mechanisms(sheet, values, spread, edges)
    lifting, lowering = map(float, efficiencies(sheet, values))
    cases = worst_cases(sheet, spread.lowest)
    nominal = _motion(sheet, _critical(found), entries)
    if not any(one.occurs for one in found.values()) and _upset(nominal):
        sure: dict[str, Any] = {"probability": 1.0, "interval": (1.0, 1.0)} if spread.samples == 1 else {}
        perturbed = replace(found["after_perturbation"], occurs=True, corner=nominal.corner, **sure)
        found["after_perturbation"] = perturbed  # as the motion shows it, whatever its reserve says
    draws = (_values(sheet, entries_of(sheet, spread.points[:, k, None])) for k in range(spread.points.shape[1]))
    middle = min(one.reserve for one in found.values())
    lowest = min(middle, *(case for case, _ in cases.values()), 1.0)
    unstable = any(one.occurs for name, one in found.items() if name != "after_perturbation")
    if sheet.stiff and not sheet.friction.law and lowest > 0:  # then slip shrinks every area, whatever the start
        started = Starting(False, nominal.corner, 0.0)
    elif not sheet.friction.law and (unstable or middle == 0):
        # A start from rest tells nothing new: it cannot become steady, as nothing damps it, or worse.
        started = Starting(None, nominal.corner, None)
    else:
        started = starting(sheet, values, draws if spread.samples > 1 else (), advise=not unstable)
    worst_motion = _worst_motion(sheet, found, cases, spread.upset) if cases else nominal
    verdict = _verdict(found, spread, cases, worst_motion, started)
    if verdict == "jerks" and started.motion is not None:
        shown = AssessedMotion("from_rest", entries, values, started.corner, started.motion, (None, ""))
        nominal = worst_motion = shown
    return Assessment(
        sheet=sheet,
        seed=seed,
        values=values,
        verdict=verdict,
        efficiency={"lifting": lifting, "lowering": lowering if lowering > 0 else None},
        self_locking=lowering <= 0,
        mechanisms=found,
        margins=edges[ANY],
        uncertainty=spread,
        nominal=nominal,
        worst=worst_motion,
        statics=statics(sheet),
        starting=started,
    )


def _values(sheet: Sheet, entries: Values) -> dict[str, float]:
    return {key: float(value) for key, value in quantities(sheet, entries).items()}


def _require_a_drive(sheet: Sheet, values: Values) -> None:
    """Refuse what the package has no drive for, in the words of the sheet."""
    if sheet.of_statics:
        raise InputError(f"Whether it vibrates cannot be asked: {sheet.of_statics}.")
    for corner in corners(sheet, values):
        for parts in dict.fromkeys(((), sheet.parts)):
            try:
                mechanisms.drive_of(sheet, values, *corner, parts)
            except InputError as error:
                if "friction_coefficient" in str(error):
                    raise InputError(
                        "friction is so strong that the threads jam whatever the torque, coefficient >= cot(lead "
                        "angle); lower friction or the lead of the thread."
                    ) from None
                raise InputError(f"The data sheet makes a drive that is out of range: {error}") from None


def _mechanisms(
    sheet: Sheet, values: Values, spread: Uncertainty, edges: dict[str, list[Margin]]
) -> dict[str, Mechanism]:
    places, lowest, slopes = corners(sheet, values), worst(sheet, values), sensitivities(sheet, values)
    found = {}
    for name, one in lowest.items():
        corner, reserve, often = one.place(places), float(one.reserve[0]), spread.probability[name]
        occurs: bool | None = reserve < 0
        if name == "after_perturbation":
            occurs, _, first = motions.most_perturbed(sheet, values) if sheet.stiff else (None, None, None)
            corner = first or corner
        found[name] = Mechanism(name, occurs, reserve, corner, often.value, often.interval, edges[name], slopes[name])
    return found


def _upset(motion: AssessedMotion) -> bool:
    """Whether a perturbation is known to start vibration: by where the motion ends, or by what it tolerates.

    A drive that nothing damps tolerates none, yet none starts more than a swing of its size: there only a
    perturbation above zero decides.
    """
    size, end = motion.tolerated[0], motion.vibration.attractor
    fatal = size is not None and math.isfinite(size)
    if end in motions.UNDECIDED:
        return fatal and size > 0
    return fatal or end != "steady sliding"


def _verdict(
    found: dict[str, Mechanism],
    spread: Uncertainty,
    cases: dict[str, WorstCase],
    worst_motion: AssessedMotion,
    started: Starting,
) -> str:
    """The verdict, a key of :data:`lsvib.assess.words.VERDICTS`."""
    steady = [one for name, one in found.items() if name != "after_perturbation"]
    if any(one.occurs for one in steady):
        return "vibrates"
    if started.jerks:
        return "jerks"
    if spread.any.value > 0:
        return "may vibrate"
    if started.share > 0:
        return "may jerk"
    if found["after_perturbation"].occurs or (found["after_perturbation"].probability or 0) > 0:
        return "steady until perturbed"
    if any(reserve < 0 for name, (reserve, _) in cases.items() if name in mechanisms.NAMES) or _upset(worst_motion):
        return "steady but for rare values"
    return "steady without reserve" if min(one.reserve for one in steady) == 0 else "steady"


def _critical(found: dict[str, Mechanism]) -> str:
    """The mechanism with the lowest reserve; vibration after a perturbation counts only where nothing else occurs."""
    own = {name: one for name, one in found.items() if name != "after_perturbation"}
    name = min(own, key=lambda key: own[key].reserve)
    perturbed = found["after_perturbation"]
    possible = perturbed.occurs or (perturbed.occurs is None and perturbed.reserve < 0)
    return "after_perturbation" if own[name].reserve > 0 and possible else name


def _motion(sheet: Sheet, name: str, entries: dict[str, float]) -> AssessedMotion:
    values = _values(sheet, entries)
    places, lowest = corners(sheet, values), worst(sheet, values)
    corner = lowest[name].place(places)
    if name == "after_perturbation" and sheet.support is None:
        corner = motions.most_perturbed(sheet, values)[2] or corner
    if name == "falling_friction" and lowest[name].reserve[0] < 0 and not sheet.friction.law:
        reason = "friction that falls with speed makes steady running unstable there; the motion beyond that onset is "
        beyond = motions.Vibration((), "unknown", reason=reason + "not computed, only the onset.")
        return AssessedMotion(name, entries, values, corner, beyond, (0.0, "Steady running is unstable."))
    strong = {"perturbation": -motions.STRONG} if name == "after_perturbation" else {}
    moved = motions.vibration(sheet, values, corner, sheet.parts, **strong)
    if moved.attractor in ("unknown", "unresolved") and sheet.parts:  # the simpler drive says more than nothing
        moved = motions.vibration(sheet, values, corner, (), **strong)
    tolerated = (None, "") if sheet.support is not None else motions.tolerated_perturbation(sheet, values, corner)
    if sheet.support is None and not sheet.closed:
        tolerated = motions.tolerated_by_trial(sheet, values, corner, tolerated[0], sheet.parts)
    return AssessedMotion(name, entries, values, corner, moved, tolerated)


def _worst_motion(
    sheet: Sheet, found: dict[str, Mechanism], cases: dict[str, WorstCase], upset: NDArray[np.float64] | None
) -> AssessedMotion:
    """The motion at the worst values within the uncertainties, of the mechanism that is most likely or nearest."""
    own = {name: reserve for name, (reserve, _) in cases.items() if name != "after_perturbation"}
    name = min(own, key=lambda key: (-(found[key].probability or 0), own[key]))
    if own[name] > 0 > cases["after_perturbation"][0]:
        name = "after_perturbation"
    shares = cases[name][1] if name != "after_perturbation" or upset is None else upset
    return _motion(sheet, name, entries_of(sheet, shares[:, None]))
