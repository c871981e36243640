"""The whole verdict on one data sheet, as plain values ready for the report, the dataset and JSON."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lsvib.assess import mechanisms
from lsvib.assess.drive import QUANTITIES, nominal_draw, quantities, random_entries
from lsvib.assess.friction import lifting_efficiency, lowering_efficiency, square_coefficient
from lsvib.assess.margins import Margin, margins, sensitivities
from lsvib.assess.sheet import Sheet
from lsvib.assess.uncertainty import Uncertainty, draw_of, study, worst_shares
from lsvib.assess.vibration import Vibration, survived_push, vibration
from lsvib.assess.window import corners, worst
from lsvib.assess.words import VERDICTS
from lsvib.errors import InputError

_BEYOND = (
    "friction that falls with speed makes steady running unstable there; the motion beyond that onset is not computed "
    "yet, only the onset."
)
_PUSHED = 5.0  # times the speed: a start that shows what a strong push does


@dataclass(frozen=True)
class Mechanism:
    """What is said of one mechanism, see :mod:`lsvib.assess.mechanisms`.

    ``occurs`` at the middle values somewhere in the window; ``reserve`` [1] there, at ``corner`` (direction, speed of
    the screw [rad/s], force [N]); ``probability`` with ``interval``; ``margins``, nearest first; ``sensitivities``.
    """

    name: str
    occurs: bool
    reserve: float
    corner: tuple[int, float, float]
    probability: float
    interval: tuple[float, float]
    margins: list[Margin]
    sensitivities: dict[str, float]


@dataclass(frozen=True)
class Motion:
    """A motion to show: of which mechanism, with which values, where in the window, and what came of it."""

    mechanism: str
    entries: dict[str, float]
    values: dict[str, float]
    corner: tuple[int, float, float]
    vibration: Vibration
    push: tuple[float | None, str]


@dataclass(frozen=True)
class Assessment:
    """A data sheet with all that is said of it.

    ``values``: :data:`lsvib.assess.drive.QUANTITIES` at the middle values; ``verdict``: a key of
    :data:`lsvib.assess.words.VERDICTS`; ``efficiency`` [1] ``lifting``, ``lowering`` (None if self-locking);
    ``nominal``, ``worst``: the motion at the middle values and in the worst case, each where the reserve is lowest.
    """

    sheet: Sheet
    seed: int
    values: dict[str, float]
    verdict: str
    efficiency: dict[str, Any]
    self_locking: bool
    lead_angle: float
    square_friction: float
    mechanisms: dict[str, Mechanism]
    uncertainty: Uncertainty
    nominal: Motion
    worst: Motion


def assess(
    sheet: Sheet,
    samples: int = 4096,
    seed: int = 1,
    threads: int = 1,
    folder: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Assessment:
    """Assess a data sheet; arguments as :func:`lsvib.assess.uncertainty.study`.

    Raises ``InputError`` in one sentence.
    """
    entries = nominal_draw(sheet)
    values = {key: float(value) for key, value in quantities(sheet, entries).items()}
    _require_a_drive(sheet, values)
    spread = study(sheet, samples, seed, threads, folder, progress)
    found = _mechanisms(sheet, values, spread)
    angle, friction = _friction(sheet, values)
    verdict = _verdict(found, spread)
    lowering = float(lowering_efficiency(friction, angle))
    nominal = _motion(sheet, _critical(found), entries, found)
    return Assessment(
        sheet=sheet,
        seed=seed,
        values=values,
        verdict=verdict,
        efficiency={
            "lifting": float(lifting_efficiency(friction, angle)),
            "lowering": lowering if lowering > 0 else None,
        },
        self_locking=lowering <= 0,
        lead_angle=angle,
        square_friction=friction,
        mechanisms=found,
        uncertainty=spread,
        nominal=nominal,
        worst=_worst_motion(sheet, found, spread) if random_entries(sheet) else nominal,
    )


def _require_a_drive(sheet: Sheet, values: dict[str, float]) -> None:
    """Refuse what the package has no drive for, in the words of the sheet."""
    if not values["pitch_diameter"] > 0:
        raise InputError("thread.nominal_diameter is not above half the pitch, so there is no pitch diameter.")
    for corner in corners(sheet, values):
        for part in ("rigid", *(part for part in ("contact", "support") if getattr(sheet, part) is not None)):
            try:
                mechanisms.drive_of(sheet, values, *corner, part)
            except InputError as error:
                if "friction_coefficient" in str(error):
                    raise InputError(
                        "friction is so strong that the threads jam whatever the torque, coefficient >= cot(lead "
                        "angle); lower friction or the lead of the thread."
                    ) from None
                raise InputError(f"The data sheet makes a drive that is out of range: {error}") from None


def _friction(sheet: Sheet, values: dict[str, float]) -> tuple[float, float]:
    """Lead angle [rad] and coefficient of the square thread at the middle values."""
    angle = float(np.arctan(values["lead"] / (np.pi * values["pitch_diameter"])))
    return angle, float(square_coefficient(values["friction"], angle, values["half_angle"]))


def _mechanisms(sheet: Sheet, values: dict[str, float], spread: Uncertainty) -> dict[str, Mechanism]:
    places, lowest = corners(sheet, values), worst(sheet, values)
    edges, slopes = margins(sheet, values), sensitivities(sheet, values)
    found = {}
    for name, one in lowest.items():
        corner = tuple(float(x) for x in places[int(one.corner[0])])
        corner = (int(corner[0]), *corner[1:])
        share, interval = spread.probability[name].value, spread.probability[name].interval
        occurs = _occurs(sheet, values, name, places, float(one.reserve[0]))
        if name == "push_needed" and occurs and sheet.support is None:
            occurs, corner = _most_pushed(sheet, values, places, corner)
        if spread.samples == 1:  # nothing is uncertain
            share, interval = float(occurs), (float(occurs), float(occurs))
        found[name] = Mechanism(
            name, occurs, float(one.reserve[0]), corner,
            share, interval, edges[name], slopes[name],
        )  # fmt: skip
    return found


def _most_pushed(
    sheet: Sheet, values: dict[str, float], places: list, corner: tuple[int, float, float]
) -> tuple[bool, tuple[int, float, float]]:
    """Whether some push starts a vibration of the rigid drive at a corner, and the corner where the smallest does.

    Beyond a certain force against the motion none does (end of Sect. 8.7), although Γ₊ is negative.
    """
    pushes = {
        (int(place[0]), float(place[1]), float(place[2])): survived_push(sheet, values, place)[0]
        for place in places
        if mechanisms.reserves(sheet, values, *place)["push_needed"] < 0
    }
    known = {place: push for place, push in pushes.items() if push is not None}
    if not known:
        return True, corner
    first = min(known, key=known.__getitem__)
    return bool(np.isfinite(known[first])), first


def _occurs(sheet: Sheet, values: dict[str, float], name: str, places: list, reserve: float) -> bool:
    """Whether a mechanism occurs at the middle values; by exact signs where friction has no slope."""
    if name == "push_needed" or values["friction_slope"] != 0 or sheet.friction.curve is not None:
        return reserve < 0
    occurs = False
    for corner in places:
        try:
            occurs |= mechanisms.certain(sheet, values, *corner)[name]
        except InputError:  # the contact carries no force there, and so no friction
            continue
    return occurs


def _verdict(found: dict[str, Mechanism], spread: Uncertainty) -> str:
    steady = [one for name, one in found.items() if name != "push_needed"]
    if any(one.occurs for one in steady):
        name = "vibrates"
    elif spread.any.value > 0:
        name = "may vibrate"
    elif found["push_needed"].occurs or (spread.samples > 1 and found["push_needed"].probability > 0):
        name = "steady until pushed"
    elif min(one.reserve for one in steady) == 0:
        name = "steady without reserve"
    else:
        name = "steady"
    if name not in VERDICTS:
        raise KeyError(name)
    return name


def _critical(found: dict[str, Mechanism]) -> str:
    """The mechanism with the lowest reserve; vibration after a push counts only where nothing else occurs."""
    own = {name: one for name, one in found.items() if name != "push_needed"}
    name = min(own, key=lambda key: own[key].reserve)
    return "push_needed" if own[name].reserve > 0 and found["push_needed"].occurs else name


def _motion(sheet: Sheet, name: str, entries: dict[str, float], found: dict[str, Mechanism]) -> Motion:
    values = {key: float(value) for key, value in quantities(sheet, entries).items()}
    places, lowest = corners(sheet, values), worst(sheet, values)
    corner = tuple(float(x) for x in places[int(lowest[name].corner[0])])
    corner = (int(corner[0]), *corner[1:])
    if name == "push_needed" and sheet.support is None:
        corner = _most_pushed(sheet, values, places, corner)[1]
    part = "support" if sheet.support is not None else "contact" if sheet.contact is not None else "rigid"
    if name == "falling_friction" and lowest[name].reserve[0] < 0:
        beyond = Vibration("rigid", "unknown", reason=_BEYOND)
        return Motion(name, dict(entries), values, corner, beyond, (0.0, "Steady running is unstable."))
    strong = {"push": -_PUSHED} if name == "push_needed" else {}
    moved = vibration(sheet, values, corner, part, **strong)
    if moved.reason is not None and part != "rigid":  # the simpler drive says more than nothing
        moved = vibration(sheet, values, corner, "rigid", **strong)
    push = (None, "") if sheet.support is not None else survived_push(sheet, values, corner)
    return Motion(name, dict(entries), values, corner, moved, push)


def _worst_motion(sheet: Sheet, found: dict[str, Mechanism], spread: Uncertainty) -> Motion:
    """The motion at the worst values within the uncertainties, of the mechanism that is most likely or nearest."""
    name = _critical_of_samples(sheet, found, spread)
    shares = worst_shares(sheet, name, spread.lowest[name])
    draw = draw_of(sheet, shares[:, None])
    entries = {path: float(np.ravel(value)[0]) for path, value in draw.items()}
    return _motion(sheet, name, entries, found)


def _critical_of_samples(sheet: Sheet, found: dict[str, Mechanism], spread: Uncertainty) -> str:
    def lowest(name: str) -> float:
        draw = draw_of(sheet, spread.lowest[name][:, None])
        return float(worst(sheet, quantities(sheet, draw))[name].reserve[0])

    own = {name: lowest(name) for name in found if name != "push_needed"}
    name = min(own, key=lambda key: (-found[key].probability, own[key]))
    return "push_needed" if own[name] > 0 > lowest("push_needed") else name


def as_json(assessment: Assessment) -> dict[str, Any]:
    """Return the verdict as plain values for JSON: SI units, None for what does not exist or is infinite."""
    units = {key: unit for key, (_, unit) in QUANTITIES.items()} | {"force": "N", "speed": "rad s-1"}
    return {
        "name": assessment.sheet.name,
        "verdict": assessment.verdict,
        "sentence": VERDICTS[assessment.verdict],
        "self_locking": assessment.self_locking,
        "efficiency": assessment.efficiency,
        "mechanisms": {
            name: {
                "occurs": one.occurs,
                "probability": one.probability,
                "interval": list(one.interval),
                "reserve": one.reserve,
                "at": {"direction": one.corner[0], "screw_speed": one.corner[1], "force": one.corner[2]},
                "margin": {
                    row.quantity: {"factor": row.factor, "value": row.value, "unit": units[row.quantity]}
                    for row in one.margins
                },
                "sensitivity": one.sensitivities,
            }
            for name, one in assessment.mechanisms.items()
            if name != "push_needed"
        },
        "after_a_push": {
            "possible": assessment.mechanisms["push_needed"].occurs,
            "probability": assessment.mechanisms["push_needed"].probability,
            "interval": list(assessment.mechanisms["push_needed"].interval),
        },
        "quantities": {key: {"value": value, "unit": units[key]} for key, value in assessment.values.items()},
        "samples": assessment.uncertainty.samples,
        "seed": assessment.seed,
        "any_mechanism": {
            "probability": assessment.uncertainty.any.value,
            "interval": list(assessment.uncertainty.any.interval),
        },
        "sobol": {"first_order": assessment.uncertainty.first_order, "total": assessment.uncertainty.total},
        "nominal": _motion_json(assessment.nominal),
        "worst_case": _motion_json(assessment.worst),
        "assumptions": dict(assessment.sheet.assumptions),
        "sources": dict(assessment.sheet.sources),
    }


def _motion_json(motion: Motion) -> dict[str, Any]:
    moved, (push, sentence) = motion.vibration, motion.push
    return {
        "mechanism": motion.mechanism,
        "entries": motion.entries,
        "at": {"direction": motion.corner[0], "screw_speed": motion.corner[1], "force": motion.corner[2]},
        "model": moved.model,
        "attractor": moved.attractor,
        "vibrates": moved.vibrates,
        "frequency": moved.frequency,
        "audible": moved.audible,
        "amplitude": moved.amplitude,
        "load_speed": None if moved.load_speed is None else list(moved.load_speed),
        "peak_contact_force": moved.peak_force,
        "peak_impulse": moved.impulse,
        "reason": moved.reason,
        "scene": moved.scene,
        "survived_push": None if push is None or not np.isfinite(push) else push,
        "survived_push_sentence": sentence,
    }
