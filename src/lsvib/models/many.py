"""The tables of many drives at once, in plain arrays, from the formulas that make those of one.

Drives whose tables differ in structure – in a sign, say – are divided into groups. A drive is *safe* if no sum in its
formulas cancels by more than three decades, so that its tables hold to 1e-12; the others are made exactly, one by one,
and so are drives whose friction depends on speed.
"""

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, TypeVar

import numpy as np

from lsvib.engine.automaton import DIMENSIONS, Automaton, one_of_many
from lsvib.engine.exact.arithmetic import Divided
from lsvib.engine.kernels import layout
from lsvib.engine.kernels.layout import Tables
from lsvib.errors import EngineError
from lsvib.models import friction
from lsvib.models.drive import DRY, PART_OF, Drive
from lsvib.models.mechanics import Coefficients, coefficients_of, steady_force
from lsvib.models.mechanism import Mechanism
from lsvib.models.model import automaton_of
from lsvib.models.modes import Modes
from lsvib.models.rigid import RigidBuild

T = TypeVar("T")


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

    @property
    def rigid(self) -> np.ndarray:
        """Whether they are rigid drives (k), without parts and without friction against the ground."""
        dry = [self.values[name] != 0 for name in DRY if name in self.values]
        return ~np.any([*dry, np.full(self.size, not PART_OF.keys().isdisjoint(self.values))], axis=0)

    def constant_friction(self, entries: np.ndarray) -> np.ndarray:
        """Return those of some drives, by their indices (j), whose friction does not depend on speed.

        The tables of the others are made exactly, one by one.
        """
        laws = [self.values[name][entries] for name in friction.OF_SPEED if name in self.values]
        return entries[~np.any(laws, axis=0)] if laws else entries

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
    made exactly. ``automaton``: its tables of doubles have an axis for the drives, the first; ``coefficients`` are
    arrays (j); ``steady_force`` (j) [N], |N_0| of steady sliding.
    """

    members: np.ndarray
    safe: np.ndarray
    automaton: Automaton
    coefficients: Coefficients
    steady_force: np.ndarray


def groups(drives: ManyDrives, entries: np.ndarray) -> Iterator[Group]:
    """Yield some rigid drives, ``entries`` (j, indices), in groups, under a rule of resuming.

    Drives that are in no group must be made exactly, too.
    """

    def group(members: np.ndarray) -> Group:
        d = drives.doubles(members)
        c = coefficients_of(d)
        automaton = _layered(RigidBuild(c, d).automaton(True, "contact_sign"), members.size)
        return Group(members, _safe(c, d, automaton.tables), automaton, c, steady_force(c, d))

    yield from (found for _, found in _divided(drives.constant_friction(entries), group))


def _divided(entries: np.ndarray, make: Callable[[np.ndarray], T]) -> Iterator[tuple[np.ndarray, T]]:
    """Divide drives until what is made of them has one structure; yields the members (j) with it."""
    waiting = [entries] if entries.size else []
    while waiting:
        members = waiting.pop()
        try:
            with np.errstate(all="ignore"):  # what overflows or divides by zero is not safe
                made = make(members)
        except Divided as parts:
            waiting += [members[parts.signs == value] for value in np.unique(parts.signs)]
        else:
            yield members, made


def _safe(c: Coefficients, d: Any, tables: Tables) -> np.ndarray:
    """Whether no sum of the formulas cancels (j): the sizes of its terms over that of the sum."""
    lever, force, speed = d.pitch_radius * d.tan_lead, d.axial_force, d.input_speed
    steady = c.damping[c.steady_law] * speed
    sums = [
        (force, -lever * d.translation_damping * speed),
        (steady, d.pitch_radius * c.xi[c.steady_law] * force),
        (d.mass * d.support_damping, -d.screw_inertia * d.translation_damping),
        (force * d.cos_lead, d.coupling_stiffness * c.deflection * d.sin_lead / d.pitch_radius),
    ]
    for law, xi in c.xi.items():
        factor, turned = law * d.steady_friction, xi * lever * d.pitch_radius
        sums += [(factor, -d.tan_lead), (np.ones_like(lever), factor * d.tan_lead)]
        sums += [(d.screw_inertia, -turned * d.mass), (d.support_damping, -turned * d.translation_damping)]
        sums.append((c.damping[law] ** 2, -4 * c.gamma[law] * d.coupling_stiffness))
        if law != c.steady_law:
            sums += [(c.xi[c.steady_law], -xi), (steady, d.pitch_radius * c.slack(law) * force)]
    modes = np.repeat(np.arange(tables.flow.shape[1]), np.diff(tables.guard_start))
    flow, rows = tables.flow[:, modes], tables.surfaces[:, tables.guard_surface]
    real = flow[..., layout.DELTA] > 0
    for constant, at in ((2, layout.EQUILIBRIUM), (0, layout.R1), (0, layout.R2)):
        other = rows[..., 0 if constant else 1] * flow[..., at]
        sums += list(zip(np.where(real, rows[..., constant], 0.0).T, np.where(real, other, 0.0).T, strict=True))
    # Beyond three decades doubles do not hold 1e-12 of a sum.
    return np.logical_and.reduce([abs(a) + abs(b) <= 1e3 * abs(a + b) for a, b in sums])


def _layered(automaton: Automaton, size: int) -> Automaton:
    """Give the tables that are the same for all drives of a group, being numbers, the axis for the drives, too."""

    def layers(table: np.ndarray, dimensions: int) -> np.ndarray:
        # a copy, so that kernels see the same type of array for every group
        return table if np.ndim(table) > dimensions else np.repeat(np.asarray(table)[None], size, axis=0)

    tables = {name: layers(getattr(automaton.tables, name), n) for name, n in {"flow": 2, **DIMENSIONS}.items()}
    observables = {name: layers(table, 2) for name, table in automaton.observables.items()}
    return replace(automaton, tables=automaton.tables._replace(**tables), observables=observables)


def automata(drives: ManyDrives) -> Iterator[tuple[int, Drive, Automaton | None]]:
    """Yield drives with the same parts by their indices, with their automata, whose tables hold to 1e-12.

    Those with parts come in groups; what does not hold so many digits is made exactly.
    The automaton is None if the engine has none. Raises ``InputError`` as the model does.
    """
    parts = drives.one(0).parts

    def group(members: np.ndarray) -> Automaton:
        d = drives.doubles(members, np.longdouble)
        return Modes(Mechanism(d, parts, d.steady_friction)).automaton()

    made: dict[int, Automaton] = {}
    for members, found in _divided(drives.constant_friction(np.arange(drives.size if parts else 0)), group):
        for place in np.flatnonzero(_finite(found, members.size)).tolist():
            made[int(members[place])] = one_of_many(found, place)
    for k in range(drives.size):
        drive, automaton = drives.one(k), made.get(k)
        if automaton is None:
            with suppress(EngineError):  # rates that lie too far apart: nothing can be determined
                automaton = automaton_of(drive)
        yield k, drive, automaton


def _finite(automaton: Automaton, size: int) -> np.ndarray:
    """Whether all tables of drives (j) hold: the formulas leave what does not as no finite number."""
    found = np.isfinite(automaton.condition)
    tables = [(getattr(automaton.tables, name), n) for name, n in DIMENSIONS.items()]
    for table, dimensions in (*tables, *((rows, 2) for rows in automaton.observables.values())):
        if np.ndim(table) > dimensions:
            found &= np.isfinite(table).reshape(size, -1).all(axis=1)
    return found
