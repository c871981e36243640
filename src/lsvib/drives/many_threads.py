"""The automata of many drives with compliant threads at once, to the last bit those of each one alone."""

import numpy as np

from lsvib.drives.coefficients import coefficients_of
from lsvib.drives.many import ManyDrives
from lsvib.drives.threads import automaton_of, seat
from lsvib.engine.automaton import Automaton, one_of_many
from lsvib.engine.exact.pair_arrays import in_groups


def threads_automata(drives: ManyDrives) -> list[tuple[Automaton, float] | None]:
    """Return of each drive its automaton and the mismatch e [m] of steady sliding; None where it needs 60 digits."""
    found: list[tuple[Automaton, float] | None] = [None] * drives.size

    def make(group: np.ndarray) -> tuple[Automaton, np.ndarray, np.ndarray]:
        unsafe = np.zeros(group.size, dtype=bool)
        d = drives.exact(group, unsafe)
        c = coefficients_of(d)
        automaton, mismatch = automaton_of(c, d), seat(c, d)
        return automaton, mismatch, ~unsafe

    for group, (automaton, mismatch, safe) in in_groups(drives.size, make):
        for place, member in enumerate(group.tolist()):
            if safe[place] and automaton.tables.flow[place] is not None:
                found[member] = one_of_many(automaton, place), float(mismatch[place])
    return found
