"""The tables of many drives at once, in plain arrays, from the formulas that make those of one.

Drives whose tables differ in structure – in a sign, say – are divided into groups. A drive is *safe* if its tables hold
to 1e-12; the others are made exactly, one by one.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from lsvib.drives import friction
from lsvib.drives.automata import modes_of
from lsvib.drives.drive import DRY, Drive
from lsvib.drives.model import seated, standing
from lsvib.errors import EngineError
from lsvib.systems.automaton import Automaton
from lsvib.systems.exact.arithmetic import Divided, double
from lsvib.systems.kernels.layout import DIMENSIONS


class ManyDrives:
    """Drives with the same parts that are given by arrays of their parameters.

    ``values``: one value [SI unit] or an array (k) of each parameter that they have, within its range.
    """

    def __init__(self, values: Mapping[str, np.ndarray | float]) -> None:
        self.size = max(np.size(value) for value in values.values())
        self.values = {  # -0.0 and 0.0 are one drive
            name: np.broadcast_to(np.asarray(x, dtype=float) + 0.0, (self.size,)) for name, x in values.items()
        }

    def some(self, entries: np.ndarray) -> "ManyDrives":
        """Return some of the drives, by their indices (j)."""
        return ManyDrives({name: column[entries] for name, column in self.values.items()})

    def one(self, entry: int) -> Drive:
        """Return one of the drives."""
        return Drive(**{name: float(column[entry]) for name, column in self.values.items()})

    def doubles(self, entries: np.ndarray, kind: type = float) -> SimpleNamespace:
        """Return some of the drives (j) with attributes as those of ``Drive.exact()``, arrays (j) of a ``kind``."""
        d = SimpleNamespace(
            **{name: Drive.model_fields[name].default for name in (*friction.NAMES, *DRY, "coupling_damping")}
        )
        vars(d).update({name: column[entries].astype(kind) for name, column in self.values.items()})
        d.sin_lead, d.cos_lead, d.tan_lead = (f(d.lead_angle) for f in (np.sin, np.cos, np.tan))
        vars(d).update(friction.levels(d))
        return d


@dataclass(frozen=True)
class Group:
    """Drives whose automata differ in doubles only.

    ``members`` (j) are their indices, and ``safe`` (j) says for which of them all holds to 1e-12; the others must be
    made exactly. ``automaton``: its tables of doubles have an axis for the drives, the first; ``steady_force`` (j) [N],
    |N_0| of steady sliding; ``seated`` and ``standing`` (j, n), the states of steady sliding, and of rest with the
    coupling relaxed.
    """

    members: np.ndarray
    safe: np.ndarray
    automaton: Automaton
    steady_force: np.ndarray
    seated: np.ndarray
    standing: np.ndarray


def groups(drives: ManyDrives, entries: np.ndarray) -> Iterator[Group]:
    """Yield some drives, ``entries`` (j, indices), in groups.

    Drives that are in no group must be made exactly, too. Raises ``InputError`` as the model does.
    """
    parts, waiting = drives.one(0).parts, [entries] if entries.size else []
    while waiting:
        members = waiting.pop()
        try:
            with np.errstate(all="ignore"):  # what overflows or divides by zero is not safe
                modes = modes_of(drives.doubles(members, np.longdouble), parts)
                automaton, m = _layered(modes.automaton(), members.size), modes.m
                safe, force = _finite(automaton, members.size), abs(double(m.steady_normal_force))
                shape = members.size, len(m.states)
                states = (np.broadcast_to(state(m), shape) for state in (seated, standing))
                made = Group(members, safe, automaton, force, *states)
        except Divided as apart:
            waiting += [members[apart.signs == value] for value in np.unique(apart.signs) if not np.isnan(value)]
        except EngineError:
            continue  # each is made exactly, and says so itself
        else:
            yield made


def _layered(automaton: Automaton, size: int) -> Automaton:
    """Give the tables that are the same for all drives of a group, being numbers, the axis for the drives, too."""

    def layers(table: np.ndarray, dimensions: int) -> Any:
        if np.ndim(table) > dimensions:
            return np.ascontiguousarray(table)
        # a copy, so that kernels see the same type of array for every group
        return np.array(np.broadcast_to(table, (size, *np.shape(table))), order="C")

    tables = {name: layers(getattr(automaton.tables, name), n) for name, n in DIMENSIONS.items() if name != "flow"}
    tables["flow"] = automaton.flow.each(layers)
    observables = {name: layers(table, 2) for name, table in automaton.observables.items()}
    parts = {name: layers(table, 2) for name, table in automaton.parts.items()}
    return replace(automaton, tables=automaton.tables._replace(**tables), observables=observables, parts=parts)


def _finite(automaton: Automaton, size: int) -> np.ndarray:
    """Whether all tables of drives (j) hold: the formulas leave what does not as no finite number."""
    held = [getattr(automaton.tables, name) for name in DIMENSIONS if name != "flow"]
    held += [*automaton.flow.numbers, *automaton.observables.values(), *automaton.parts.values()]
    held.append(np.broadcast_to(automaton.condition, (size,)))
    return np.asarray(np.all([np.isfinite(table).reshape(size, -1).all(axis=1) for table in held], axis=0))
