"""The whole verdict on one data sheet, as values ready for the report, the dataset and JSON, with its resonances."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from lsvib.errors import InputError
from lsvib.sheets import motor
from lsvib.sheets import vibration as motions
from lsvib.sheets.catalogue import Purchase, purchases
from lsvib.sheets.changes import ANY, Change, advice, margins
from lsvib.sheets.draw import Draw, Operation
from lsvib.sheets.formulas import sliding_speed
from lsvib.sheets.from_rest import FromRest, Starter, from_rest
from lsvib.sheets.move import Ripple, ripple
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import Statics, statics
from lsvib.sheets.uncertainty import Uncertainty, ends, study
from lsvib.sheets.window import OperatingWindow, worst
from lsvib.sheets.words import TOLERATED
from lsvib.stability.spectrum import polynomial

PEAK = math.sqrt(0.5)  # the damping ratio from which on no frequency stands out
BESIDE = 1.25  # times beyond the window up to which a speed is said
ZERO = {"coupling.inertia": "kg m2", "damping.rotational": "N m s rad-1", "damping.translational": "N s m-1",
        "bearing.torque": "N m", "guide": "N", "friction.slope": "s m-1"}  # taken as zero if not given  # fmt: skip
DESIGNED = ("thread", "screw", "load", "operation", "motor")  # whose single values count as known
EVERY = (1, 2, 4)  # steps after which the torque of a stepper with N_r teeth repeats, at 4 N_r n, 2 N_r n and N_r n
Mode = tuple[float, float]  # frequency |s| / 2π [Hz] and damping ratio −Re s / |s| [1] of an eigenvalue s


class Resonance(NamedTuple):
    """A small oscillation about steady running, with the lowest and highest values in the window.

    ``met``: speeds of the screw [rad/s] in or beside it at which a stepper's torque has the frequency, by steps.
    """

    frequency: float
    damping_ratio: float
    frequencies: Mode
    damping_ratios: Mode
    met: dict[int, float]


def modes(there: Operation) -> list[Mode]:
    """Return the oscillations of the whole drive at a point of operation, lowest first; friction is on its tangent."""
    (level, slope), draw = there.friction, there.draw
    start = level - slope * sliding_speed(there.speed, draw.pitch_radius, draw.lead_angle)
    straight = {**there.parameters, "friction_coefficient": start, "friction_slope": slope}
    roots = np.roots(polynomial(straight, int(there.reserves["law"])))
    pairs = sorted((root for root in roots if root.imag > 0), key=abs)
    return [(float(abs(root)) / (2 * math.pi), float(-root.real / abs(root)) + 0.0) for root in pairs]


def resonances(there: Operation) -> list[Resonance]:
    """Return the oscillations at a point of the window, or the first that has more; with the nearest at all others."""
    points = [modes(there), *map(modes, OperatingWindow(there.draw).corners)]
    return [_resonance(there.draw, mode, [own for own in points if own]) for mode in max(points, key=len)]


def _resonance(draw: Draw, mode: Mode, points: list[list[Mode]]) -> Resonance:
    near = [min(own, key=lambda one: abs(math.log(one[0] / mode[0]))) for own in points]
    frequencies, ratios = ((min(ends), max(ends)) for ends in zip(*near, strict=True))
    met, own = dict[int, float](), draw.sheet.motor
    if own and own.holding_torque and mode[1] < PEAK:
        full = 2 * math.pi * mode[0] / own.steps_per_turn / draw.entries.get("coupling.gear_ratio", 1.0)
        low, high = draw.values["speed_low"] / BESIDE, draw.values["speed_high"] * BESIDE
        met = {steps: steps * full for steps in EVERY if low <= steps * full <= high}
    return Resonance(*mode, frequencies, ratios, met)


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

    ``draw``: the drive at the middle values; ``mechanisms``: what was found of each, ``perturbed`` of vibration after a
    perturbation; ``margins``: those of all mechanisms together, nearest first; ``nominal``, ``worst``: the motion at
    the middle values and in the worst case, each where the reserve is lowest; ``from_rest``: what it does when it is
    switched on; ``ripple``: what a ramp leaves, if there is one; ``changes`` of one quantity that end vibration or
    jerks, those that end all of it first; ``purchases``.
    """

    draw: Draw
    seed: int
    mechanisms: dict[str, Finding]
    perturbed: Finding
    margins: list[Change]
    uncertainty: Uncertainty
    nominal: AssessedMotion
    worst: AssessedMotion
    statics: Statics
    from_rest: FromRest
    ripple: Ripple | None = None
    changes: list[Change] = field(default_factory=list)
    purchases: list[Purchase] = field(default_factory=list)

    @property
    def verdict(self) -> str:
        """The verdict, a key of :data:`lsvib.sheets.words.VERDICTS`: that of a motor or brake goes before vibration."""
        return self.statics.verdict or self.vibration

    @cached_property
    def vibration(self) -> str:
        """The verdict on vibration alone."""
        started, without_reserve = self.from_rest, min(one.reserve for one in self.mechanisms.values()) == 0
        if any(one.occurs for one in self.mechanisms.values()):
            return "vibrates"
        if started.jerks:
            return "jerks"
        if self.uncertainty.any.value > 0:
            return "may vibrate"
        if started.jerky:
            return "may jerk"
        if self.perturbed.occurs or (self.perturbed.probability or 0) > 0:
            return "steady until perturbed"
        cases = [case for name, (case, _) in self.uncertainty.cases.items() if name in self.mechanisms]
        if started.ends or any(case < 0 for case in cases) or _upset(self.worst):
            return "steady but for rare values"
        if without_reserve and not self.draw.sheet.followed:
            return "steady without reserve"
        if started.jerks is None or started.unknown or started.ends is None:
            return "start not known"
        return "steady without reserve" if without_reserve else "steady"

    @cached_property
    def resonances(self) -> list[Resonance]:
        """The small oscillations at the middle values, where the reserve is lowest."""
        return resonances(self.nominal.there)

    @cached_property
    def unstable(self) -> list[int]:
        """The directions of travel in which steady running is unstable at the middle values."""
        ways = _by_direction(self.draw.sheet)
        return [way for way, sheet in ways.items() if _lowest(self.draw, sheet, self.mechanisms) < 0]

    @cached_property
    def omitted(self) -> dict[str, float | None]:
        """Entries taken as zero because not given, each with the value that alters whether steady running is stable."""
        given, law = self.draw.sheet.paths(), ["friction.slope"] * self.draw.sheet.friction.law
        found: dict[str, float | None] = {row.about.entry: row.value for row in self.margins if row.factor is None}
        inertia = next(row.value for row in self.margins if row.quantity == "screw_inertia") or 0.0
        found["coupling.inertia"] = max(inertia - self.draw.values["screw_inertia"], 0.0) or None
        return {path: found.get(path) for path in ZERO if path not in (*given, *law)}

    @cached_property
    def pull(self) -> tuple[str, float, float] | None:
        """Where a stepper is nearest to its limit, its largest torque and its limit there [N m]; None without one."""
        rows, entries = self.statics.rows, self.draw.entries
        if "motor" not in self.draw.sheet.parts or "motor.holding_torque" not in entries:
            return None
        steady = (("in steady running", "motor_torque"), ("in a ramp", "peak_torque"))
        found = [(words, rows[key].worst, rows[key].limit or 0.0) for words, key in steady if key in rows]
        for words, one in (("at the middle values", self.nominal), ("in the worst case", self.worst)):
            if torque := one.vibration.motor_torque:
                own, given = one.there.draw, motor.limit(one.there.draw, motor.RAMP, one.there.speed)
                found.append((f"in the vibration {words}", float(motor.before_gear(own, torque)), float(given)))
        return max(found, key=lambda one: one[1] / one[2] if one[2] else math.inf)

    @property
    def single(self) -> list[Change]:
        """The changes by less than half that alter it, of quantities given as a single value that none may know."""
        varied = {path.split(".")[0] for path in self.draw.sheet.random} | set(DESIGNED)
        near = [row for row in self.margins if row.is_near(1.5)]
        return [row for row in near if row.about.entry.split(".")[0] not in varied]

    @cached_property
    def efficiency(self) -> dict[str, float | None]:
        """Of the thread [1], ``lifting`` and ``lowering``; None if it is self-locking."""
        lifting, lowering = map(float, self.draw.efficiencies)
        return {"lifting": lifting, "lowering": lowering if lowering > 0 else None}

    @property
    def names(self) -> list[str]:
        """The names of the mechanisms, those that occur or are nearest first."""
        return sorted(self.mechanisms, key=lambda name: self.mechanisms[name].reserve)

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
    require_a_drive(window)
    rows, spread, edges = statics(sheet), study(sheet, samples, seed), margins(draw)
    mechanisms = {name: _finding(window, name, spread, edges[name]) for name in window.worst}
    perturbed = mechanisms.pop("after_perturbation")
    nominal = _motion(window, _critical(mechanisms, perturbed))
    if not any(one.occurs for one in (*mechanisms.values(), perturbed)) and _upset(nominal):
        sure: dict[str, Any] = {"probability": 1.0, "interval": (1.0, 1.0)} if spread.samples == 1 else {}
        # As the motion shows it, whatever its reserve says.
        perturbed = replace(perturbed, occurs=True, there=nominal.there, **sure)
    starter = Starter(sheet)
    started = _started(nominal.there, mechanisms, perturbed, spread, starter)
    if started.unstable and started.jerks and perturbed.occurs is None:  # for a start from rest is a perturbation
        perturbed = replace(perturbed, occurs=True, there=started.there)
    worst = _worst_motion(sheet, mechanisms, spread) if spread.cases else nominal
    after = _ripple(draw)
    found = Assessment(draw, seed, mechanisms, perturbed, edges[ANY], spread, nominal, worst, rows, started, after)
    if found.vibration == "jerks" and started.motion is not None:
        jerks = AssessedMotion("from_rest", started.there, started.motion, (None, ""))
        found = replace(found, nominal=jerks, worst=jerks)
    if found.vibration in ("vibrates", "jerks"):
        asked = draw, edges[ANY], found.vibration == "vibrates", starter
        found = replace(found, changes=advice(*asked), purchases=purchases(draw, starter))
    return found


def require_a_drive(window: OperatingWindow) -> None:
    """Refuse what the package has no drive for, in the words of the sheet."""
    if unasked := window.draw.sheet.of_statics:
        raise InputError(f"Vibration cannot be assessed: {unasked}.")
    for there in window.corners:
        try:
            _ = there.rigid, there.drive
        except InputError as error:
            if "friction_coefficient" in str(error):
                raise InputError(
                    "the friction coefficient is at least cot(lead angle), so the threads jam at any torque; lower "
                    "friction or the lead of the thread."
                ) from None
            raise InputError(f"The data sheet gives a drive that is out of range: {error}") from None


def _ripple(draw: Draw) -> Ripple | None:
    """What is left of a ramp at the middle values, as long as the load runs on, a second at most."""
    run = draw.run
    if run is None or run.time <= (2 + 1e-6) * run.ramp:
        return None
    force = 0.5 * (draw.values["force_low"] + draw.values["force_high"])
    there = Operation(draw, draw.sheet.directions[0], draw.values["speed_high"], force)
    return ripple(there.drive, draw.sheet.operation.move, run.ramp, min(run.time - 2 * run.ramp, 1.0))


def _finding(window: OperatingWindow, name: str, spread: Uncertainty, edges: list[Change]) -> Finding:
    there, reserve, often = window.critical(name), float(window.worst[name].reserve[0]), spread.probability[name]
    occurs: bool | None = reserve < 0
    if name == "after_perturbation":
        occurs, _, first = window.most_perturbed if window.draw.sheet.stiff else (None, None, None)
        there = first or there
    return Finding(name, occurs, reserve, there, often.value, often.interval, edges)


def _started(
    there: Operation, mechanisms: dict[str, Finding], perturbed: Finding, spread: Uncertainty, starter: Starter
) -> FromRest:
    """What becomes of a start from rest, which is followed where nothing else tells; ``there``: where it is if not."""
    draw, sheet = there.draw, there.draw.sheet
    middle = min(one.reserve for one in (*mechanisms.values(), perturbed))
    lowest = min(middle, *(case for case, _ in spread.cases.values()), 1.0)
    if sheet.stiff and not sheet.followed and lowest > 0:  # then slip shrinks every area
        return FromRest(False, there, 0.0)
    ways = _by_direction(sheet)
    unstable = () if sheet.followed else tuple(way for way in ways if _lowest(draw, ways[way], mechanisms) < 0)
    left = [way for way in ways if way not in unstable]
    if not left or (middle == 0 and not sheet.followed):  # it cannot become steady, as nothing damps it, or worse
        return FromRest(None, there, None, unstable=unstable)
    sheet = sheet if left[1:] else ways[left[0]]
    shares = (spread.points[:, : starter.draws], ends(sheet, starter.ends)) if sheet.random else ()
    own = from_rest(replace(draw, sheet=sheet), starter, *((Draw.of(sheet, one) for one in part.T) for part in shares))
    return replace(own, there=replace(own.there, draw=draw), unstable=unstable)


def _by_direction(sheet: Sheet) -> dict[int, Sheet]:
    """A sheet for each direction of travel alone."""
    runs = {way: {"direction": "out" if way > 0 else "back"} for way in sheet.directions}
    return {way: sheet.model_copy(update={"operation": sheet.operation.model_copy(update=runs[way])}) for way in runs}


def _lowest(draw: Draw, sheet: Sheet, mechanisms: Iterable[str]) -> float:
    """The lowest reserve of some mechanisms over the window of a sheet."""
    found = worst(replace(draw, sheet=sheet))
    return float(min(found[name].reserve[0] for name in mechanisms))


def _upset(motion: AssessedMotion) -> bool:
    """Whether a perturbation is known to start vibration: by where the motion ends, or by what it tolerates.

    A drive that nothing damps tolerates none, yet none starts more than a swing of its size: there only a
    perturbation above zero decides.
    """
    size, end = motion.tolerated[0], motion.vibration.attractor
    if end in motions.UNDECIDED:
        return size is not None and 0 < size < math.inf
    return end != "steady sliding" or (size is not None and math.isfinite(size))


def _critical(mechanisms: dict[str, Finding], perturbed: Finding) -> str:
    """The mechanism with the lowest reserve; vibration after a perturbation counts only where nothing else occurs."""
    lowest = min(mechanisms.values(), key=lambda one: one.reserve)
    possible = perturbed.occurs or (perturbed.occurs is None and perturbed.reserve < 0)
    return perturbed.name if lowest.reserve > 0 and possible else lowest.name


def _motion(window: OperatingWindow, name: str) -> AssessedMotion:
    sheet, there = window.draw.sheet, window.critical(name)
    if name == "after_perturbation" and sheet.support is None:
        there = window.most_perturbed[2] or there
    if name == "falling_friction" and window.worst[name].reserve[0] < 0 and not sheet.friction.law:
        reason = "friction that falls with speed makes steady running unstable there; the motion beyond that onset is "
        beyond = motions.Vibration((), "unknown", reason=reason + "not computed.")
        return AssessedMotion(name, there, beyond, (0.0, TOLERATED["unstable"].format(threads="")))
    strong = -motions.STRONG if name == "after_perturbation" else motions.NUDGE
    moved = there.motion(strong)
    if moved.attractor in ("unknown", "unresolved") and sheet.parts:  # the simpler drive says more than nothing
        moved = there.motion(strong, stiff=True)
    tolerated = (None, "") if sheet.support is not None else there.tolerated
    if sheet.support is None and not sheet.closed and (sheet.parts or tolerated[0] is None):
        tolerated = motions.tolerated_by_trial(there.drive, tolerated[0])
    return AssessedMotion(name, there, moved, tolerated)


def _worst_motion(sheet: Sheet, mechanisms: dict[str, Finding], spread: Uncertainty) -> AssessedMotion:
    """The motion at the worst values within the uncertainties, of the mechanism that is most likely or nearest."""
    cases = spread.cases
    name = min(mechanisms, key=lambda key: (-(mechanisms[key].probability or 0), cases[key][0]))
    if cases[name][0] > 0 > cases["after_perturbation"][0]:
        name = "after_perturbation"
    shares = cases[name][1] if name != "after_perturbation" or spread.upset is None else spread.upset
    return _motion(OperatingWindow(Draw.of(sheet, shares)), name)
