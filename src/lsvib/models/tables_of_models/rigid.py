"""The automata of many rigid drives at once, to the last bit those of each one alone."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lsvib.engine.automaton import DIMENSIONS, Automaton
from lsvib.engine.exact.pair_arrays import double, in_groups
from lsvib.models.many import ManyDrives
from lsvib.models.mechanics import Coefficients, coefficients_of
from lsvib.models.model import Resume
from lsvib.models.rigid import automaton_of


@dataclass(frozen=True)
class Group:
    """Drives whose automata differ in doubles only.

    ``members`` (j) are their indices, and ``safe`` (j) says for which of them all is right to the last bit; the others
    need 50 digits. ``automaton``: its tables of doubles have an axis for the drives, the first; ``coefficients`` are
    pairs (j); ``steady_force`` (j) [N], |N_0| of steady sliding.
    """

    members: np.ndarray
    safe: np.ndarray
    automaton: Automaton
    coefficients: Coefficients
    steady_force: np.ndarray


def groups(drives: ManyDrives, resume: Resume, entries: np.ndarray) -> Iterator[Group]:
    """Yield some rigid drives, ``entries`` (j, indices), in groups, under a rule of resuming.

    Drives that are in no group need 50 digits, too.
    """

    def make(group: np.ndarray) -> Group:
        """Form the automata of some drives at once."""
        unsafe, here = np.zeros(group.size, dtype=bool), entries[group]
        d = drives.exact(here, unsafe)
        c = coefficients_of(d)
        automaton = automaton_of(c, d, True, resume if c.paradox else "contact_sign")
        force = double(steady_force(c, d))
        return Group(here, ~unsafe, _layered(automaton, here.size), c, force)

    for _, group in in_groups(entries.size, make):
        yield group


def _layered(automaton: Automaton, size: int) -> Automaton:
    """Give the tables that are the same for all drives of a group, being numbers, the axis for the drives, too."""

    def layers(table: np.ndarray, dimensions: int) -> np.ndarray:
        """Return a table with a first axis for the drives, which it may have already."""
        table = np.asarray(table)
        if table.ndim > dimensions:
            return table
        # a copy, so that kernels see the same type of array for every group
        return np.array(np.broadcast_to(table, (size, *table.shape)), order="C")

    tables = automaton.tables
    dimensions = {"flow": 2, **DIMENSIONS}
    layered: dict[str, Any] = {name: layers(getattr(tables, name), n) for name, n in dimensions.items()}
    return replace(
        automaton,
        tables=tables._replace(**layered),
        observables={name: layers(table, 2) for name, table in automaton.observables.items()},
    )


def steady_force(c: Coefficients, d: Any) -> Any:
    """|N_0| of steady sliding (eq. 8.15): N_0 (cos λ + s_0 μ sin λ) = R − r_m tan λ c_x Ω."""
    return abs(c.net_force / (d.cos_lead + c.steady_law * d.friction_coefficient * d.sin_lead))
