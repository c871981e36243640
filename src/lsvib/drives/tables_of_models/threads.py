"""The automata of many drives with compliant threads at once.

They are those of each one alone, to rounding: the two oscillators of a mode may stand in another order, and guards have
the digits of the tables, where those of one drive have forms of their own (:func:`guard_forms_of
<lsvib.engine.exact.linear_mode.guard_forms_of>`).
"""

from collections.abc import Sequence

import numpy as np

from lsvib.drives.coefficients import coefficients_of
from lsvib.drives.many import ManyDrives
from lsvib.drives.parameters import ThreadsParameters
from lsvib.drives.registry import seizures_only_by_contact
from lsvib.drives.threads import automaton_of, seat, threads_automaton
from lsvib.engine.automaton import Automaton, one_of_many
from lsvib.engine.exact.pair_arrays import in_groups

Made = tuple[Automaton, dict[str, float]]
"""An automaton, and the values by name of what a start may leave out."""


def automata(drives: ManyDrives, resume: str) -> list[Made | None]:
    """Return of each drive its automaton, and a seated contact: e [m], v [m/s]; None where it needs 60 digits.

    Raises ``InputError`` for a rule of resuming that the model does not know.
    """
    seizures_only_by_contact(drives.drive_class.model, resume)
    found: list[Made | None] = [None] * drives.size

    def make(group: np.ndarray) -> tuple[Automaton, np.ndarray, np.ndarray]:
        """Return the automata of some drives, the mismatch of each, and whether it is safe."""
        unsafe = np.zeros(group.size, dtype=bool)
        d = drives.exact(group, unsafe)
        c = coefficients_of(d)
        automaton, mismatch = automaton_of(c, d), seat(c, d)
        return automaton, mismatch, ~unsafe

    for group, (automaton, mismatch, safe) in in_groups(drives.size, make):
        for place, member in enumerate(group.tolist()):
            if safe[place] and automaton.tables.flow[place] is not None:
                found[member] = one_of_many(automaton, place), {"e": float(mismatch[place]), "v": 0.0}
    return found


def automata_of(drives: Sequence[ThreadsParameters]) -> list[Automaton]:
    """Return the automata of drives, to rounding those of :func:`threads_automaton`; ``EngineError`` as it raises."""
    columns = {name: np.array([getattr(drive, name) for drive in drives]) for name in ThreadsParameters.model_fields}
    made = automata(ManyDrives(columns, ThreadsParameters), "contact_sign")
    return [threads_automaton(drive) if one is None else one[0] for drive, one in zip(drives, made, strict=True)]
