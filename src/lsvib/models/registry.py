"""What a model tells the layers above: all that they need to know of it, so that none of them asks which one it is."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any

import numpy as np

from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.mechanics import LinearParts, Polynomial
from lsvib.models.model import model_module, model_names

if TYPE_CHECKING:  # a scene can be read and refused without the engine
    from lsvib.engine.automaton import Automaton
    from lsvib.models.model import Powers


@dataclass(frozen=True)
class Model:
    """A model of the drive; the file of each has one as ``MODEL``.

    The simulation needs of it ``build(drive, physics, resume)``, which makes the automaton; ``start(drive, values)``,
    which makes the state of a start from the keys ``required`` and ``optional``, one for each of the coordinates
    ``states``; ``terms``, the parameters that a scene may leave out (then they must be zero); ``options``, the other
    words that its ``physics`` may hold; ``outputs``, its observables, and ``quantities``, long name, unit and symbol of
    those coordinates and observables that no other model has.

    Its linear stability needs ``characteristic(parameters, parts)``, the characteristic polynomial of steady sliding in
    the arithmetic of the parameters, as :class:`~lsvib.models.mechanics.LinearParts` helps to make it;
    ``excess(parts)``, the positive factor by which it exceeds det(M s² + C s + K); and of the class ``drive`` the name
    of the damper that the model adds to the rigid drive, ``own_damping``. The kinematic constraint is where the leading
    coefficient of ``constrained(parameters, parts)`` vanishes, by default of the characteristic polynomial;
    ``constraint`` is its equation in words. ``thresholds`` are the names of those that can be solved for a parameter,
    and ``curves`` those of the exact curves in its charts; a model without any has no charts. ``powers(drive,
    automaton)`` gives the powers of its cycles. ``section`` is the section of the book that derives the model, by which
    models are listed.
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
    powers: "type[Powers]"
    required: tuple[str, ...] = ("u", "w")
    optional: tuple[str, ...] = ()
    options: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ("normal_force", "coupling_torque", "coupling_deflection", "screw_speed")
    excess: Callable[[LinearParts], Any] = lambda parts: parts.g
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
    """Return a model by name; ``InputError`` if there is none of that name."""
    model: Model = import_module(model_module(name)).MODEL
    return model


def all_models() -> dict[str, Model]:
    """Return all models by name, in the order of :func:`lsvib.models.model.model_names`."""
    return {name: find_model(name) for name in model_names()}
