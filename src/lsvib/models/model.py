"""What the layers above ask of a model: its :class:`Model`, found by the name of the model's file.

To add a model, write one file ``lsvib/models/NAME.py`` and nothing else. Its docstring has the equations with their
numbers in the chapter. Then come, as in :mod:`lsvib.models.rigid` (two states: the flow of a mode is an ``oscillator``)
or :mod:`lsvib.models.threads` (more: it is a ``linear_mode``, and ``assemble`` takes ``stack`` and ``forms``),

* the class of its drives, a :class:`lsvib.models.drive.Drive` with ``model = "NAME"`` and its own parameters, each a
  ``quantity`` with symbol, unit, name and range;
* codes of its modes and kinds of its events, two ``IntEnum``;
* a function that makes its automaton: surfaces, modes, guards and transitions, from ``drive.exact()`` and
  ``coefficients(drive)``, for :func:`lsvib.engine.automaton.assemble`;
* its characteristic polynomial from :class:`lsvib.models.mechanics.LinearParts`, and its :class:`Powers`;
* last, ``MODEL = Model(...)`` at the beginning of a line, by which it is found.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.friction import depends_on_speed
from lsvib.models.mechanics import LinearParts, Polynomial
from lsvib.numbers import shown

if TYPE_CHECKING:  # a scene can be read and refused without the engine
    from lsvib.engine.automaton import Automaton

Resume = Literal["contact_sign", "at_once"]  # how motion goes on after a seizure: see lsvib.models.rigid
RULES: tuple[Resume, ...] = get_args(Resume)  # the limit of a compliant contact, and the chapter's reading
DIRECTIONS = {1: "forward", -1: "backward"}  # of slip, in the names of modes
SIGNS = {1: "positive", -1: "negative"}  # of the contact force
_SECTION = re.compile(r'^    section="([\d.]+)"', re.MULTILINE)


def rule(given: Any) -> Resume:
    """Return a rule of resuming after a seizure; raises ``InputError`` for anything else."""
    for known in RULES:
        if isinstance(given, str) and given == known:
            return known
    raise InputError(f"resume = {shown(given)} is not one of {', '.join(RULES)}.")


class Powers:
    """The powers of a drive as quadratic forms of (x, 1), mode by mode; a model overrides what is different.

    A row is an affine function of the state: coefficients over x, then the constant. The product of two rows is a
    symmetric form over (x, 1), whose integral along a motion :mod:`lsvib.dynamics.energy` knows in closed form. Rows:
    ``screw``, θ′ [rad/s]; ``nut``, x′ [m/s]; ``slip``, the speed of the threads [rad/s]. Under a friction law,
    ``by_speed``, what friction takes out is a pair of forms, the second of which counts η times.
    """

    def __init__(self, drive: Drive, automaton: "Automaton") -> None:
        self.drive, self.automaton = drive, automaton
        n = len(automaton.states)
        self.one, self.unit = np.eye(n + 1)[-1], np.eye(n + 1)
        self.screw = self.unit[1] + drive.input_speed * self.one
        self.reach = drive.pitch_radius * math.tan(drive.lead_angle)
        self.slip, self.nut = self.screw, self.reach * self.screw
        self.by_speed = depends_on_speed(drive)
        self.sine, self.cosine = math.sin(drive.lead_angle), math.cos(drive.lead_angle)

    def rows(self, mode: int) -> dict[str, np.ndarray]:
        """Return the rows of the observables in a mode, by name."""
        return {name: table[mode] for name, table in self.automaton.observables.items()}

    def rests(self, mode: int) -> bool:
        """Return whether the threads do not slip in a mode."""
        return bool(self.automaton.codes[mode] in self.automaton.rest_codes)

    def motor(self, mode: int) -> np.ndarray:
        """Return the power [W] that the motor puts in."""
        return self.drive.input_speed * product(self.rows(mode)["coupling_torque"], self.one)

    def load(self) -> np.ndarray:
        """Return the power [W] that the axial force puts in."""
        return self.drive.axial_force * product(self.nut, self.one)

    def damping(self) -> np.ndarray:
        """Return the power [W] that all dampers take out."""
        total = self.drive.support_damping * product(self.screw, self.screw)
        total = total + self.drive.translation_damping * product(self.nut, self.nut)
        for damper, speed in self.dampers():
            total = total + damper * product(speed, speed)
        return total

    def dampers(self) -> Iterator[tuple[float, np.ndarray]]:
        """Yield the dampers that a model adds, each with its coefficient and the row of its speed."""
        yield from ()

    def signed_friction(self, mode: int) -> np.ndarray:
        """Return the power [W] that friction takes out and whose sign changes within a mode; none in most models."""
        return np.zeros_like(self.unit)

    def friction(self, mode: int) -> Iterator[np.ndarray]:
        """Yield powers [W] of friction that keep their sign in a mode; their size is what friction takes out."""
        if not self.rests(mode):
            yield self.rubbed(
                self.drive.pitch_radius / self.cosine * product(self.rows(mode)["normal_force"], self.slip)
            )

    def rubbed(self, form: np.ndarray) -> np.ndarray:
        """Return the power of sliding friction from that of the contact force, under a law of that without friction."""
        return np.stack([0 * form, form]) if self.by_speed else self.drive.friction_coefficient * form

    def second_energy(self, x: np.ndarray) -> float:
        """Return twice the kinetic energy [J] of the second body at (x, 1); none without one."""
        return 0.0

    def kinetic(self, state: np.ndarray) -> float:
        """Return the kinetic energy [J] at a state."""
        x, d = np.append(state, 1.0), self.drive
        bodies = d.screw_inertia * (self.screw @ x) ** 2 + d.mass * (self.nut @ x) ** 2
        return float(0.5 * (bodies + self.second_energy(x)))


def product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the product of two rows as a symmetric form."""
    return 0.5 * (np.outer(left, right) + np.outer(right, left))


@dataclass(frozen=True)
class Model:
    """A model of the drive; the file of each has one as ``MODEL``. How to write one: see the text of the module.

    *Motion.* ``build(drive, physics, resume)`` makes the automaton, and its attribute ``many(d, resume)``, where it has
    one, those of many drives at once, from arrays of parameters; ``start(drive, values)`` makes the state of a start
    from the keys ``required`` and ``optional``, one for each of the coordinates ``states``. ``modes`` and ``events``
    name the codes of datasets. A model that knows only one rule of resuming refuses the other in ``build``
    (:func:`seizures_only_by_contact`). ``terms`` are the parameters that a scene may leave out (then they must be
    zero), ``options`` the other words that its ``physics`` may hold, ``outputs`` its observables, and ``quantities``
    long name, unit and symbol of those coordinates and observables that no other model has.
    ``powers(drive, automaton)`` gives the powers of its cycles.

    *Linear stability.* ``characteristic(parameters, parts)`` is the characteristic polynomial of steady sliding in the
    arithmetic of the parameters; ``excess(parts)`` the positive factor by which it exceeds det(M s² + C s + K). The
    class ``drive`` names the damper that the model adds to the rigid drive, ``own_damping``. The kinematic constraint
    is where the leading coefficient of ``constrained(parameters, parts)`` vanishes, by default of the characteristic
    polynomial; ``constraint`` is its equation in words. ``thresholds`` are the names of those that can be solved for a
    parameter (the default is for more than two states: of two there is no flutter), ``curves`` those of the exact
    curves in its charts; a model without any has no charts.

    ``section`` is the section of the book that derives the model, by which models are listed, and ``equations`` are the
    numbers of its equations.
    """

    drive: type[Drive]
    build: Callable[[Any, tuple[str, ...], str], "Automaton"]
    start: Callable[[Any, Mapping[str, float]], np.ndarray]
    modes: type[IntEnum]
    events: type[IntEnum]
    states: tuple[str, ...]
    terms: tuple[str, ...]
    equations: str
    characteristic: Callable[[Mapping[str, Any], LinearParts], Polynomial]
    powers: type[Powers]
    required: tuple[str, ...] = ("u", "w")
    optional: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ("normal_force", "coupling_torque", "coupling_deflection", "screw_speed")
    excess: Callable[[LinearParts], Any] = lambda parts: parts.g * parts.times
    constrained: Callable[[Mapping[str, Any], LinearParts], Polynomial] | None = None
    constraint: str = "det M = 0"
    thresholds: tuple[str, ...] = ("onset", "kinematic_constraint", "flutter")
    curves: tuple[str, ...] = ()
    quantities: Mapping[str, tuple[str, str, str]] = field(default_factory=dict)
    section: str = ""

    def physics_of(self, drive: Drive) -> tuple[str, ...]:
        """Return the words of all that a drive has: its terms that are not zero, and the options."""
        return (*(term for term in self.terms if getattr(drive, term) != 0), *self.options)

    def initial_state(self, drive: Drive, values: Mapping[str, float]) -> np.ndarray:
        """Return the state of a start; ``InputError`` if a required key is missing or a key is not known."""
        known = (*self.required, *self.optional)
        if not set(self.required) <= set(values) <= set(known):
            optional = f", and may have {' and '.join(self.optional)}" if self.optional else ""
            raise InputError(
                f"start has the keys {', '.join(values) or 'none'}; it needs {' and '.join(self.required)}{optional}."
            )
        return self.start(drive, values)


def seizures_only_by_contact(model: str, resume: str) -> None:
    """Refuse a rule of resuming that only the rigid drive has; raises ``InputError``."""
    if resume != "contact_sign":
        raise InputError(f"resume = {resume!r} is not known to the model {model}; it knows contact_sign.")


def find_model(name: str) -> Model:
    """Return a model by name; ``InputError`` if there is none of that name, or if its drives bear another one.

    >>> find_model("threads").states
    ('angle_deviation', 'velocity_deviation', 'thread_mismatch', 'mismatch_rate')
    """
    model: Model = import_module(model_module(name)).MODEL
    if (own := getattr(model.drive, "model", "")) != name:  # a copied file, which would answer as the one it is from
        raise InputError(f"lsvib/models/{name}.py has drives with model = {own!r}; their class needs model = {name!r}.")
    return model


def all_models() -> dict[str, Model]:
    """Return all models by name, in the order of :func:`model_names`."""
    return {name: find_model(name) for name in model_names()}


@cache  # one motion asks for its model some thirty times
def model_names() -> tuple[str, ...]:
    """Return the names of all models: by the sections that derive them, then those without a section by name."""
    texts = {file.stem: file.read_text("utf-8") for file in Path(__file__).parent.glob("*.py")}
    sections = {name: _SECTION.search(text) for name, text in texts.items() if "\nMODEL = " in text}
    return tuple(sorted(sections, key=lambda name: (not (found := sections[name]), found[1] if found else "", name)))


def model_module(name: str) -> str:
    """Return the name of the module of a model; ``InputError`` if there is no model of that name."""
    if not isinstance(name, str) or name not in model_names():
        raise InputError(f"model = {shown(name)} is not one of {', '.join(model_names())}.")
    return f"{__package__}.{name}"
