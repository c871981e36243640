"""What a model tells the layers above: its parameters, automaton, start, and the names of its modes and events."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np

from lsvib.drives.parameters import RigidParameters
from lsvib.errors import InputError
from lsvib.numbers import shown

if TYPE_CHECKING:  # a scene can be read and refused without the engine
    from lsvib.engine.automaton import Automaton

MODELS = {
    "rigid": "lsvib.drives.rigid",
    "threads": "lsvib.drives.threads",
    "support": "lsvib.drives.second_body.support",
    "nut": "lsvib.drives.second_body.nut",
}


@dataclass(frozen=True)
class Model:
    """A model of the drive; each module of ``MODELS`` has one as ``MODEL``.

    ``build(drive, physics, resume)`` makes the automaton; ``start(drive, values)`` the initial state from the keys
    ``required`` and ``optional``; ``terms`` are the parameters that a scene may leave out (then they must be zero);
    ``options`` are the other words that its ``physics`` may hold; ``outputs`` are its observables.
    """

    drive: type[RigidParameters]
    build: Callable[[RigidParameters, tuple[str, ...], str], "Automaton"]
    start: Callable[[RigidParameters, Mapping[str, float]], np.ndarray]
    modes: type[IntEnum]
    events: type[IntEnum]
    required: tuple[str, ...]
    optional: tuple[str, ...]
    terms: tuple[str, ...]
    options: tuple[str, ...]
    outputs: tuple[str, ...]
    equations: str

    def initial_state(self, drive: RigidParameters, values: Mapping[str, float]) -> np.ndarray:
        """Return the initial state; ``InputError`` if a required key is missing or a key is not known."""
        known = (*self.required, *self.optional)
        if not set(self.required) <= set(values) <= set(known):
            optional = f", and may have {' and '.join(self.optional)}" if self.optional else ""
            raise InputError(
                f"initial has the keys {', '.join(values) or 'none'}; it needs {' and '.join(self.required)}{optional}."
            )
        return self.start(drive, values)


def seizures_only_by_contact(model: str, resume: str) -> None:
    """Refuse a reading of what follows a seizure that only the rigid drive has; raises ``InputError``."""
    if resume != "contact_sign":
        raise InputError(f"resume = {resume!r} is not known to the model {model}; it knows contact_sign.")


def find_model(name: str) -> Model:
    """Return a model by name; ``InputError`` if there is none of that name."""
    if not isinstance(name, str) or name not in MODELS:
        raise InputError(f"model = {shown(name)} is not one of {', '.join(MODELS)}.")
    return import_module(MODELS[name]).MODEL
