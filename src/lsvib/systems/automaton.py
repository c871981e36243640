"""From a model in words – surfaces, modes, transitions – to the tables that the engine runs.

Every number may be a ball (``flint.arb``); it is rounded to double once, here. It may also be an array of doubles, the
numbers of many systems; then all tables of doubles have one more axis, the first, for the systems.
"""

from collections.abc import Iterable, Mapping, Sequence, Sized
from dataclasses import dataclass, field
from functools import cached_property, reduce
from itertools import accumulate
from typing import Any, NamedTuple

import numpy as np

from lsvib.errors import EngineError
from lsvib.systems.exact.arithmetic import Number, Row, double, doubles, many_digits
from lsvib.systems.flow import Flow, Linear, Series
from lsvib.systems.kernels.layout import Tables, TaylorFlow, Test

# Part of a system's shortest time scale below which a stay counts as short: some hundred roundings of a time.
SHORT_STAY = 1e-13


@dataclass(frozen=True)
class Surface:
    """Zero set of an affine function of the state (constant last); ``snap`` is the coordinate that is set on it."""

    row: Row
    snap: int


@dataclass(frozen=True)
class Guard:
    """A side of a surface: the mode lies where ``sign`` × function is positive; leaving it makes the transition."""

    surface: str
    sign: int
    transition: str


@dataclass(frozen=True)
class Mode:
    """A flow and the guards around it; ``code`` names the mode in datasets.

    ``flow`` is a ``PlanarMode`` (two states), a ``ModalMode`` or, under a friction law, a ``TaylorMode``.
    """

    code: int
    flow: Any
    guards: tuple[Guard, ...]
    beyond_accumulation: str | None = None


class Branch(NamedTuple):
    """One outcome of a transition, taken if all ``conditions`` (row, test) hold and no earlier branch was."""

    mode: str
    kind: int
    conditions: tuple[tuple[Row, Test], ...] = ()
    sign: int = 0


@dataclass(frozen=True)
class Transition:
    """An affine reset (one row for each coordinate) or none, then the first branch whose conditions hold."""

    branches: tuple[Branch, ...]
    reset: tuple[Row, ...] | None = None


@dataclass(frozen=True)
class Automaton:
    """A model ready to run: the tables of the engine, the code of each mode and the observables.

    ``observables[name]`` has shape (modes, n + 1): the affine function of the state that gives the quantity in each
    mode; under a friction law ``parts[name]`` of it counts η times (:class:`lsvib.systems.kernels.layout.TaylorFlow`).
    ``condition`` is the largest amplification of rounding by the modal form of a mode, 1 without one.
    ``modes`` and ``events`` name the codes of modes and the kinds of events. ``marks`` classifies some of them for the
    labels of attractors: codes of modes at ``rest``, of others in which something is ``held``, and of those in which
    the threads ``jam``; kinds of events that are an ``impact``, and those that divide the tables but not the motion,
    ``passage``. ``stands``: an equilibrium is rest, whatever its mode. Two facts are given by the model: ``passive``,
    energy enters only as the work of constant forces, so that no motion grows faster than in proportion to time;
    ``contracts``, slip makes every area of the phase plane smaller, or leaves every one as it is, and coming to rest or
    passing it makes none larger (docs/attraction.md).

    >>> lsvib.Drive().automaton().observe("normal_force", np.zeros((1, 2)), np.array([0]))  # [N], in steady sliding
    array([49.19140026])
    """

    tables: Tables = field(repr=False)
    codes: np.ndarray
    states: tuple[str, ...]
    observables: dict[str, np.ndarray] = field(repr=False)
    parts: dict[str, np.ndarray] = field(repr=False, default_factory=dict)
    condition: float = 1.0
    modes: Mapping[int, str] = field(repr=False, default_factory=dict)
    events: Mapping[int, str] = field(repr=False, default_factory=dict)
    marks: Mapping[str, frozenset[int]] = field(default_factory=dict)
    stands: bool = False
    passive: bool = False
    contracts: bool = False
    engines: list[Any] = field(init=False, repr=False, compare=False, default_factory=list)  # left by runs

    @cached_property
    def flow(self) -> Flow:
        """The flow of all modes, with what follows from its tables."""
        return (Series if isinstance(self.tables.flow, TaylorFlow) else Linear)(self.tables.flow)

    def observe(self, name: str, states: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Return an observable [SI unit], by name, at ``states`` (k, n) in ``modes`` (k); shape (k)."""
        found = affine(self.observables[name][modes], states)
        if name in self.parts:
            found = found + self.flow.share(states, modes) * affine(self.parts[name][modes], states)
        return found

    def marked(self, numbers: np.ndarray, *marks: str) -> np.ndarray:
        """Return whether codes of modes, or kinds of events (k), have one of these marks; shape (k)."""
        wanted = (numbers == number for mark in marks for number in self.marks.get(mark, ()))
        return reduce(np.logical_or, wanted, np.zeros(np.shape(numbers), dtype=bool))

    def in_words(self, events: Iterable[tuple[int, int]]) -> tuple[tuple[str, str], ...]:
        """Return the names of events and of the modes that they enter, from kinds and codes."""
        return tuple((self.events.get(int(kind), str(kind)), self.modes[int(code)]) for kind, code in events)

    def functional(self, name: str) -> np.ndarray:
        """Return an observable for :func:`lsvib.systems.kernels.event_loop.extremes_of_arcs`, a row for each mode."""
        own = self.observables[name]
        return np.concatenate([own, self.parts[name]], axis=-1) if name in self.parts else own


def affine(rows: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Return affine functions (k, n + 1) at states (k, n)."""
    return np.asarray(np.einsum("ki,ki->k", rows[:, :-1], states) + rows[:, -1])


def product(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Return the product of two rows as a symmetric form."""
    return 0.5 * (np.outer(left, right) + np.outer(right, left))


def assemble(
    states: tuple[str, ...],
    surfaces: dict[str, Surface],
    modes: dict[str, Mode],
    transitions: dict[str, Transition],
    observables: Mapping[str, Mapping[str, Row]],
    shortest_stay: Any,
    parts: Mapping[str, Mapping[str, Row]] | None = None,
    **facts: Any,
) -> Automaton:
    """Lay a model out as tables.

    Arguments: names of the state's coordinates (n); surfaces, modes and transitions by name, the first transition being
    the entry; observables by name and mode; shortest stay [s] (see ``Tables``); ``parts``, observables' rows that count
    η times, as those are given; ``facts``, the other attributes of :class:`Automaton`. Branches into modes that the
    model does not have are an error.
    """
    mode_index: dict[str | None, int] = {name: i for i, name in enumerate(modes)}
    surface_index = {name: i for i, name in enumerate(surfaces)}
    transition_index = {name: i for i, name in enumerate(transitions)}
    guards = [guard for mode in modes.values() for guard in mode.guards]
    branches = [branch for transition in transitions.values() for branch in transition.branches]
    conditions = [condition for branch in branches for condition in branch.conditions]
    resets = [transition.reset for transition in transitions.values() if transition.reset is not None]
    reset_index = iter(range(len(resets)))
    n, flows = len(states), [mode.flow for mode in modes.values()]
    with many_digits():
        inward = [[scaled(surfaces[one.surface].row, one.sign) for one in own.guards] for own in modes.values()]
        flow, forms = flows[0].together(flows, inward)
    tables = Tables(
        flow=flow,
        surfaces=_rows([surface.row for surface in surfaces.values()], n),
        snap=_integers(surface.snap for surface in surfaces.values()),
        guard_start=_starts(mode.guards for mode in modes.values()),
        guard_surface=_integers(surface_index[guard.surface] for guard in guards),
        guard_sign=np.array([float(guard.sign) for guard in guards]),
        guard_transition=_integers(transition_index[guard.transition] for guard in guards),
        guard_parts=doubles([x for form in forms for x in form], (len(guards), len(forms[0]) if forms else 0)),
        transition_reset=_integers(-1 if t.reset is None else next(reset_index) for t in transitions.values()),
        resets=_rows([row for reset in resets for row in reset], n, (len(resets), n, n + 1)),
        branch_start=_starts(transition.branches for transition in transitions.values()),
        branch_mode=_integers(mode_index[branch.mode] for branch in branches),
        branch_kind=_integers(branch.kind for branch in branches),
        branch_sign=_integers(branch.sign for branch in branches),
        condition_start=_starts(branch.conditions for branch in branches),
        condition_row=_rows([row for row, _ in conditions], n),
        condition_test=_integers(test for _, test in conditions),
        beyond_accumulation=_integers(mode_index.get(mode.beyond_accumulation, -1) for mode in modes.values()),
        shortest_stay=double(shortest_stay),
    )
    seen = _rows(
        [rows[mode] for rows in observables.values() for mode in modes], n, (len(observables), len(modes), n + 1)
    )
    return Automaton(
        tables=tables,
        codes=np.array([mode.code for mode in modes.values()], dtype=np.int8),
        states=states,
        observables={name: seen[..., k, :, :] for k, name in enumerate(observables)},
        parts={name: _rows([rows[mode] for mode in modes], n) for name, rows in (parts or {}).items()},
        modes={mode.code: name for name, mode in reversed(modes.items())},  # a law may divide one
        condition=reduce(np.maximum, [own.condition for own in flows]),
        **facts,
    )


def scaled(row: Row, factor: Number) -> tuple[Any, ...]:
    """Return a row times a number; what is not there stays so."""
    if factor.__class__ is int and abs(factor) == 1:
        return tuple(row) if factor == 1 else tuple([-x for x in row])
    return tuple([factor * x if x.__class__ is not int or x else 0 for x in row])


def _rows(rows: Sequence[Row], n: int, shape: tuple[int, ...] | None = None) -> np.ndarray:
    table = doubles([x for row in rows for x in row], shape or (len(rows), n + 1))
    one = table.ndim == len(shape or (0, 0))  # what is unsafe among many is refused later
    if one and not np.isfinite(table).all():
        raise EngineError("a coefficient of the model is beyond 1e308; choose parameters closer in magnitude.")
    return table


def _integers(values: Iterable[int]) -> np.ndarray:
    return np.fromiter(values, dtype=np.int64)


def _starts(groups: Iterable[Sized]) -> np.ndarray:
    return _integers(accumulate(map(len, groups), initial=0))
