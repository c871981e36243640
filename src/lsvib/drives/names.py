"""What the parts of a drive, its modes and its events are called, in automata, datasets and starts."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from functools import cache
from itertools import product
from typing import Literal, get_args

from lsvib.systems.kernels.layout import ACCUMULATION_KIND, FIRST_MODEL_KIND, GRAZE_KIND

COORDINATES = {  # of each part: the names of its displacement and of the rate of that
    "screw": ("u", "w"),
    "motor": ("motor_angle", "motor_rate"),
    "support": ("screw_shift", "shift_rate"),
    "nut": ("nut_angle", "nut_rate"),
    "threads": ("thread_mismatch", "mismatch_rate"),
}
WORDS = {  # long name, unit and symbol of each coordinate, and of the speed that a command gives
    "u": ("deviation of the coupling deflection from steady sliding", "rad", "$u$"),
    "w": ("rate of the deviation from steady sliding", "rad s-1", r"$\dot u$"),
    "motor_angle": ("angle of the motor from the commanded motion, minus that of steady sliding", "rad", r"$\theta_m$"),
    "motor_rate": ("angular speed of the motor minus input_speed", "rad s-1", r"$\dot\theta_m$"),
    "screw_shift": ("axial shift of the screw from steady sliding", "m", "$y$"),
    "shift_rate": ("rate of the axial shift of the screw", "m s-1", r"$\dot y$"),
    "nut_angle": ("angle of the nut from steady sliding", "rad", r"$\varphi$"),
    "nut_rate": ("angular speed of the nut", "rad s-1", r"$\dot\varphi$"),
    "thread_mismatch": ("axial mismatch of nut and screw", "m", "$e$"),
    "mismatch_rate": ("rate of the mismatch of nut and screw", "m s-1", r"$\dot e$"),
    "commanded_speed": ("commanded angular speed", "rad s-1", r"$\Omega(t)$"),
}
CLOCK = "clock"  # the coordinate that is time, of a drive whose commanded speed changes


@dataclass(frozen=True)
class Body:
    """A body that a part adds to the drive, with an inertia, on a spring and a damper.

    ``symbol`` of its coordinate; ``pushed``, the force of the threads that acts on it: n (``contact``), τ (``torque``)
    or none; ``on``, what carries spring and damper: the ground, the ``screw``, with which the body then turns, or the
    ``command``, the motion Ω t that the motor is to follow; the coordinate is then the distance from it.
    """

    symbol: str
    pushed: str = ""
    on: str = ""


BODIES = {"motor": Body("θ_m", on="command"), "support": Body("x_1", "contact"), "nut": Body("θ_2", "torque")}
DIRECTIONS = {1: "forward", -1: "backward"}  # of slip, in the names of modes
SIGNS = {1: "positive", -1: "negative"}  # of the contact force
HOW = {**DIRECTIONS, 0: "held"}
HOLDS = {"slide": "nut", "bearing": "screw"}  # what a dry friction holds, in the names of modes
Resume = Literal["contact_sign", "at_once"]  # how motion goes on after a seizure: see lsvib.drives.modes
RULES: tuple[Resume, ...] = get_args(Resume)  # the limit of a compliant contact, and the chapter's reading
Ways = tuple[int, ...]  # of the bodies that slide on their own, see Mechanism.own: 1, −1, or 0 for one that is held
Key = tuple[int, int, Ways]  # of a mode: direction of slip (0: rest), sign of n (0 where it does not matter), ways


class MotionMode(IntEnum):
    """Modes of a drive without parts; the second word of a slip mode is the sign of the contact force."""

    SLIP_FORWARD_POSITIVE = 0
    SLIP_FORWARD_NEGATIVE = 1
    SLIP_BACKWARD_POSITIVE = 2
    SLIP_BACKWARD_NEGATIVE = 3
    REST = 4


class Event(IntEnum):
    """What happens at an event of any drive."""

    GRAZE = GRAZE_KIND  # a guard is touched, not crossed
    ACCUMULATION = ACCUMULATION_KIND  # infinitely many events end here
    CONTACT_REVERSAL = FIRST_MODEL_KIND  # the contact force changes sign
    STICK = FIRST_MODEL_KIND + 1  # the threads stop, and static friction holds
    REVERSAL = FIRST_MODEL_KIND + 2  # they stop and slip the other way
    RELEASE = FIRST_MODEL_KIND + 3  # static friction gives way
    SEIZURE = FIRST_MODEL_KIND + 4  # the speed of the slip jumps to zero by an impact
    PASSAGE = FIRST_MODEL_KIND + 5  # a speed passes one at which a friction law divides a mode, Ω as a rule
    SLIDE_STICK = FIRST_MODEL_KIND + 6  # the nut stops on its slide
    SLIDE_REVERSAL = FIRST_MODEL_KIND + 7
    SLIDE_RELEASE = FIRST_MODEL_KIND + 8
    BEARING_STICK = FIRST_MODEL_KIND + 9  # the screw stops in its bearing
    BEARING_REVERSAL = FIRST_MODEL_KIND + 10
    BEARING_RELEASE = FIRST_MODEL_KIND + 11
    COMMAND = FIRST_MODEL_KIND + 12  # the commanded speed begins to change otherwise


def sides_of_rest(parts: Iterable[str]) -> tuple[int, ...]:
    """Return the signs that n may have at rest, 0 alone where it is constant there: the load stands."""
    return (1, -1) if {"support", "threads"} & set(parts) else (0,)


def own_frictions(parts: Iterable[str], dry: Iterable[str]) -> tuple[str, ...]:
    """Return the dry frictions whose body may slide or be held by itself while the threads slip."""
    free = {"bearing": {"nut"}, "slide": {"support", "threads"}}
    rubs = {name for name in free if {f"{name}_friction", f"{name}_static_friction"} & set(dry)}
    return tuple(name for name, needs in free.items() if name in rubs and needs & set(parts))


@cache
def codes_of(own: tuple[str, ...], sides: tuple[int, ...]) -> dict[str, int]:
    """Return the codes of modes by name; arguments: see :class:`Mechanism`.

    With compliant threads each way of the bodies has six modes, in one order.
    """
    plain = [(d, q) for d in DIRECTIONS for q in SIGNS] + [(0, side) for side in sides]
    every: list[Ways] = [(), *(product(HOW, repeat=len(own)) if own else ())]
    names = (mode_name((*mode, ways), own if ways else ()) for ways in every for mode in plain)
    return {name: code for code, name in enumerate(names)}


@cache
def mode_name(key: Key, own: tuple[str, ...]) -> str:
    """Return the name of a mode."""
    d, q, ways = key
    name = f"slip_{DIRECTIONS[d]}_{SIGNS[q]}" if d else f"rest{'_' + SIGNS[q] if q else ''}"
    return "_".join([name, *(f"{HOLDS[body]}_{HOW[way]}" for body, way in zip(own, ways, strict=True))])
