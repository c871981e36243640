"""The motion of one drive: what the vibration is, and how large a perturbation it takes."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from lsvib.drives import friction
from lsvib.drives.automata import automaton_of
from lsvib.drives.drive import Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.model import Model, model_of
from lsvib.errors import EngineError, InputError
from lsvib.sheets.words import TOLERATED, shown
from lsvib.systems.automaton import Automaton
from lsvib.words import plain

if TYPE_CHECKING:  # the engine is loaded by what follows a motion
    from lsvib.systems.attractor import SteadyState
    from lsvib.systems.motion import Motion

UNDECIDED = ("neutral family", "unresolved", "unknown")  # ends of motions that neither settle nor certainly vibrate
_WITHOUT_CYCLE = UNDECIDED[:2]
NUDGE = 1e-3  # of the speed: how far from steady sliding a motion starts that shows whether it is stable
STRONG = 5.0  # times the speed: a perturbation that counts as strong, and the largest that has to be tried
Tolerated = tuple[float | None, str]  # a sudden change of the screw's speed [rad/s], None if not known; a sentence
_SAMPLES = 1200  # even ones of the motion shown: 200 a period
# Work after which a motion counts as unresolved, a second or two: events with two states, units of one with more. Of
# many motions that are only asked where they end each gets less.
_WORK_OF_RIGID, _WORK_OF_PARTS = 4_000, 1_000_000
_WORK_OF_LAW = 40_000
_WORK_OF_MANY = 12_000


@dataclass(frozen=True)
class Vibration:
    """Where a motion ends that starts next to steady sliding.

    ``parts``: what complies; ``attractor``: its name in words; for a cycle ``frequency`` [Hz], ``amplitude`` of the
    load [m] (half of peak to peak, about steady travel), ``load_speed`` lowest and highest [m/s], ``screw_speed``
    likewise [rad/s], ``peak_contact_force`` between impacts [N], ``peak_impulse`` of an impact [N s] (0 without),
    ``motor_torque``: the largest that the motor gives, either way, at the screw [N m].
    ``scene``: names and values of a scene that shows it; ``time`` [s], ``deviation`` of the load [m]: samples (n) of
    the motion. ``reason``: why nothing is known, if so.
    """

    parts: tuple[str, ...]
    attractor: str
    frequency: float | None = None
    amplitude: float | None = None
    load_speed: tuple[float, float] | None = None
    screw_speed: tuple[float, float] | None = None
    peak_contact_force: float | None = None
    peak_impulse: float | None = None
    motor_torque: float | None = None
    scene: dict[str, Any] = field(default_factory=dict)
    time: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    deviation: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0))
    reason: str | None = None

    @property
    def vibrates(self) -> bool:
        """Whether the motion ends in a cycle, shown or not."""
        return self.attractor.endswith("cycle")

    @property
    def audible(self) -> bool:
        """Whether its frequency lies within what a young ear hears; a lower one may be heard as knocks."""
        return self.frequency is not None and 20.0 <= self.frequency <= 20e3


def vibration(drive: Drive, perturbation: float | None, state: tuple[float, ...] = ()) -> Vibration:
    """Follow the motion of a drive from near steady sliding, u = 0, w = ``perturbation`` Ω, or from rest, to its end.

    ``perturbation``: None for a start from rest, or from a ``state``. Raises ``InputError`` or ``EngineError`` where
    it is not known what the motion ends in.
    """
    parts, law = drive.parts, friction.depends_on_speed(drive) or drive.static_friction_coefficient
    most = _WORK_OF_LAW if law else _WORK_OF_PARTS if parts else _WORK_OF_RIGID
    definition, automaton, start, end = _ended(drive, perturbation, most // max(1, len(parts) ** 2), state)
    words = plain(end.label)
    try:
        start, span, times, states = _shown(drive, definition, automaton, start, end)
    except EngineError as error:
        return Vibration(parts, words, reason=str(error))
    row = automaton.observables["load_place"][0]  # from that of steady travel, the same in all modes
    return Vibration(
        parts,
        words,
        scene={"drive": dict(drive), "start": start, "duration": span, "samples": _SAMPLES + 1},
        time=times,
        deviation=states @ row[:-1] + row[-1],
        **({} if end.orbit is None or words in _WITHOUT_CYCLE else _of_cycle(drive, end.orbit, row)),
    )


def after_knock(drive: Drive) -> str:
    """Return what a motion of a drive after a strong perturbation ends in, in words."""
    work = _WORK_OF_MANY // len(drive.parts) ** 2 if drive.parts else _WORK_OF_RIGID
    return plain(_ended(drive, -STRONG, work)[-1].label)


def _ended(
    drive: Drive, perturbation: float | None, most_work: int, state: tuple[float, ...] = ()
) -> "tuple[Model, Automaton, dict[str, float], SteadyState]":
    """Model and automaton of a drive, the start of a motion, at rest without a perturbation, and its end."""
    from lsvib.systems.attractor import steady_state

    definition = model_of(drive)
    start = dict(zip(definition.states, state, strict=True)) if state else definition.from_rest(drive)
    if perturbation is not None:
        start = {"u": 0.0, "w": perturbation * drive.input_speed}
    automaton, first = automaton_of(drive), definition.initial_state(drive, start)
    return definition, automaton, start, steady_state(automaton, first, max_events=most_work)


def _shown(
    drive: Drive, definition: Model, automaton: Automaton, start: dict[str, float], end: "SteadyState"
) -> tuple[dict[str, float], float, NDArray[np.float64], NDArray[np.float64]]:
    """Start, duration [s], times and states of a motion to be looked at.

    A motion that ends in a cycle is shown for six periods, from a part of its speed, so that its growth takes little
    time, from as late as it takes to come near the cycle, or, if that is long after, as behind a slow control, on the
    cycle; any other starts as given and goes on for some swings.
    """
    from lsvib.systems.attractor import orbit_extremes
    from lsvib.systems.motion import follow

    swing = 2 * math.pi * math.sqrt(drive.screw_inertia / drive.coupling_stiffness)
    orbit = None if plain(end.label) in _WITHOUT_CYCLE else end.orbit
    span, ends = 12 * swing, np.zeros((2, 2))
    if orbit is not None:
        span = 6 * end.period
        ends = np.array([orbit_extremes(orbit, row) for row in np.eye(2, len(automaton.states) + 1)])  # of u, w
        start = {**start, "w": math.copysign(max(abs(start["w"]), 0.3 * np.abs(ends[1]).max()), start["w"])}
    names, later = definition.states, start
    for _ in range(64):
        start = later
        motion = follow(automaton, definition.initial_state(drive, start), span)
        late, _ = motion.at(np.linspace(0.5 * span, span, _SAMPLES // 4 + 1))
        off = np.abs([late[:, :2].min(axis=0), late[:, :2].max(axis=0)] - ends.T)
        if orbit is None or (off <= 0.05 * np.ptp(ends, axis=1)).all():
            break
        later = dict(zip(names, late[-1].tolist(), strict=True))
    else:
        assert orbit is not None
        start = dict(zip(names, orbit.at([0.5 * end.period])[0][0].tolist(), strict=True))
        motion = follow(automaton, definition.initial_state(drive, start), span)
    times = np.linspace(0.0, span, _SAMPLES + 1)
    states, _ = motion.at(times)
    return start, span, times, states


def _of_cycle(drive: Drive, orbit: "Motion", row: NDArray[np.float64]) -> dict[str, Any]:
    from lsvib.dynamics.impulses import event_impulses
    from lsvib.systems.attractor import orbit_extremes

    low, high = orbit_extremes(orbit, row)
    impulses, automaton = np.abs(event_impulses(drive, orbit).normal), orbit.automaton
    torque = np.array(automaton.observables["coupling_torque"][0])  # of the motor too, unless it complies
    if "motor" in drive.parts:
        gains = {"motor_angle": drive.integral_gain, "motor_rate": drive.speed_gain}
        torque[:-1] = [-gains.get(name, 0.0) for name in automaton.states]
    return {
        "frequency": 1 / orbit.end_time,
        "amplitude": 0.5 * (high - low),
        "load_speed": _extremes(orbit, "load_speed"),
        "screw_speed": _extremes(orbit, "screw_speed"),
        "peak_contact_force": max(map(abs, _extremes(orbit, "normal_force"))),
        "peak_impulse": float(impulses.max(initial=0.0)),
        "motor_torque": max(map(abs, orbit_extremes(orbit, torque))),
    }


def _extremes(orbit: "Motion", name: str) -> tuple[float, float]:
    """Lowest and highest value of an observable on a cycle; what rounding leaves of standstill is zero."""
    from lsvib.systems.attractor import orbit_extremes

    ends = orbit_extremes(orbit, orbit.automaton.functional(name))
    rounding = 1e-12 * max(map(abs, ends))
    low, high = (0.0 if abs(end) < rounding else end for end in ends)
    return low, high


def tolerated(drive: Drive) -> Tolerated:
    """Return the sudden change of the screw's speed [rad/s] that the rigid drive tolerates, and a sentence.

    Infinite if motion comes back from any, zero if steady sliding is unstable, None if it is not known.
    """
    from lsvib.dynamics.resilience import resilience

    if not drive.rigid:
        return None, TOLERATED["not_computed"]
    try:
        c = coefficients(drive)
        ratio = 0.5 * float(c.damping[-1]) / math.sqrt(drive.coupling_stiffness * float(c.gamma[-1]))
        if not (c.paradox or automaton_of(drive).contracts) and 0 < ratio < 2e-4:
            return None, TOLERATED["hardly_damped"]  # the boundary winds through more than 10⁴ turns
        found = resilience(drive).speed
    except (InputError, EngineError) as error:
        return None, str(error)
    if found > 1e4 * abs(drive.input_speed):  # more than a drive meets; under a law no motion is followed for ever
        words = "any" if found == math.inf and not friction.depends_on_speed(drive) else "any_sudden"
        return math.inf, TOLERATED[words]
    return found, TOLERATED["some" if found else "none"]


def tolerated_by_trial(drive: Drive, stiff: float | None) -> Tolerated:
    """Return the same of any drive, by motions after perturbations of either sign, without proof.

    ``stiff``: what the drive with stiff threads tolerates [rad/s], around which others are tried.
    """
    threads = TOLERATED["threads"] if "threads" in drive.parts else ""

    def ends(speed: float) -> str:
        return plain(_ended(drive, speed / drive.input_speed, _WORK_OF_MANY // 3)[-1].label)

    known = stiff if stiff is not None and 0 < stiff < math.inf else None
    scale = known or abs(drive.input_speed)
    tried = TOLERATED["tried_threads" if threads else "tried"]
    if known is not None and drive.parts == ("threads",):  # which are all that the other drive does not have
        tried = f"{tried} {TOLERATED['beside'].format(size=shown(stiff, 'rad/s'))}"
    low = 0.0
    try:
        slightest = ends(NUDGE**2 * scale)
        if slightest != "steady sliding":  # without damping it neither comes back nor vibrates more and more
            known = 0.0 if slightest not in ("neutral family", "unresolved") else None
            return known, "" if known is None else TOLERATED["unstable"].format(threads=threads)
        sizes = [scale * part for part in (0.1, 0.25, 0.5, 0.75, 0.95, 1.2, 2.0, 5.0)]
        while sizes[-1] < STRONG * abs(drive.input_speed):
            sizes.append(2 * sizes[-1])
        for size in sizes:
            found = {sign: ends(sign * size) for sign in (1, -1)}
            lost = [sign for sign, end in found.items() if end != "steady sliding"]
            if "unresolved" in found.values():
                return None, TOLERATED["unresolved"].format(threads=threads)
            if lost:
                high = size
                for _ in range(6):  # until the ends of the bracket are some 1 % apart
                    middle = 0.5 * (low + high)
                    calm = all(ends(sign * middle) == "steady sliding" for sign in lost)
                    low, high = (middle, high) if calm else (low, middle)
                return low, tried
            low = size
    except (InputError, EngineError) as error:
        return None, str(error)
    return math.inf, TOLERATED["all_tried"].format(size=shown(low, "rad/s"), threads=threads)
