"""How an automaton is laid out as plain tables of numbers, and the numbers by which kernels answer.

:mod:`lsvib.systems.automaton` fills the tables; nothing here loads numba. Kernels never raise: they return a number of
one of the enumerations below.

A row that describes an oscillator  u″ + a₁ u′ + a₀ u = b  has the columns A0 to TIME_SCALE. Such rows are the flow
table of modes with two states and, without b, the pairs of modes with more states.
"""

from enum import IntEnum
from typing import Annotated, Any, NamedTuple, get_type_hints

import numpy as np

A0, A1, B = 0, 1, 2  # coefficients a₀ [1/s²], a₁ [1/s] and b
ALPHA, BETA, DELTA = 3, 4, 5  # rates −α ± iβ, or −α ± δ [1/s]; of β and δ one is zero
R1, R2 = 6, 7  # the real rates r₁ ≥ r₂ [1/s]; zero where the rates are complex
EQUILIBRIUM = 8  # b / a₀; zero where a₀ is
TIME_SCALE = 9  # 1 / √|a₀| [s]; zero where a₀ is
COUNT = 10  # of all columns


class Status(IntEnum):
    """How a run ended."""

    TIME_REACHED = 0  # the requested end time
    STOP_EVENT = 1  # the event that the caller asked for
    SETTLED = 2  # no guard can ever fire again: the motion stays in its mode for ever
    EVENTS_FULL = 3  # the caller's event list is full; the run can go on from its last state
    DIVERGED = 4  # the state left the range of numbers
    ACCUMULATED = 5  # infinitely many events in finite time, and the model names no mode beyond them
    NO_BRANCH = 6  # a transition whose conditions exclude each other: the model is incomplete
    UNDECIDED = 7  # the search for the next event did not come to an end
    WORK_SPENT = 8  # the search for the next event took all steps that it was allowed


class Found(IntEnum):
    """What the search for a root of one guard found."""

    NONE = 0
    CROSSING = 1
    GRAZE = 2
    UNDECIDED = 3  # the search did not come to an end


NONE, CROSSING, GRAZE, LOST = map(int, Found)  # the same as plain numbers, as kernels return them


class Decision(IntEnum):
    """What is proved of a guard on one step of the search; of several guards the largest number counts."""

    POSITIVE = 0  # no root
    TOUCHES = 1  # zero to rounding
    ROOT = 2  # one root
    UNDECIDED = 3


class Test(IntEnum):
    """Sign test of an affine function of the state; 'zero' means zero to rounding."""

    POSITIVE = 0
    NOT_NEGATIVE = 1
    ZERO = 2
    LEADS = 3  # positive, or zero where the next condition holds, which does not count otherwise


# Event kinds. The engine itself writes the first two; models number theirs from FIRST_MODEL_KIND on.
GRAZE_KIND = 0  # a guard is touched, not crossed
ACCUMULATION_KIND = 1  # infinitely many events in finite time end here
FIRST_MODEL_KIND = 2


class Planar(NamedTuple):
    """Stands for planar flows, where kernels choose by kind; it holds nothing."""


class Modal(NamedTuple):
    """Stands for flows of the kind :class:`ModalFlow`."""


class Taylor(NamedTuple):
    """Stands for flows of the kind :class:`TaylorFlow`."""


class Events(NamedTuple):
    """The events of a motion with n states, filled from the first one on."""

    time: np.ndarray  # (k,) [s]
    kind: np.ndarray  # (k,)
    sign: np.ndarray  # (k,)
    mode: np.ndarray  # (k,) after the event
    before: np.ndarray  # (k, n) the state
    after: np.ndarray  # (k, n)


class Now(NamedTuple):
    """Where a motion is, replaced as it goes on."""

    state: np.ndarray  # (n,)
    scale: np.ndarray  # (n,) magnitudes that the state was computed from
    clock: np.ndarray  # (4,) TIME, CARRY, SHORT_STAYS, STEPS


# Places in a clock: time [s] and its compensation, the number of stays below ``shortest_stay`` in a row, and of the
# steps that searches for events may still take.
TIME, CARRY, SHORT_STAYS, STEPS = range(4)


class Until(NamedTuple):
    """Where a run ends: at a time [s], which may be infinite, or after an event of a kind that enters a mode."""

    time: float
    kind: int  # −1: never
    mode: int  # −1: any


class Begin(NamedTuple):
    """Where a stay or a motion begins."""

    time: float  # [s]
    mode: int
    state: np.ndarray  # (n,)


class Tables(NamedTuple):
    """A piecewise-linear automaton with n states as plain arrays (m modes, g guards, t transitions, b branches).

    Those with a number beside their type hold a system's own numbers, in so many dimensions, the others its structure.

    An affine function of the state is a row of n + 1 numbers, the constant last. Guards of mode i are
    ``guard_start[i]:guard_start[i + 1]``; the other ``*_start`` arrays work alike. Transition 0 is the entry: it puts a
    start into its mode.
    """

    flow: Any  # (m, columns) coefficients of the linear flow of each mode; a ModalFlow; or a TaylorFlow
    surfaces: Annotated[np.ndarray, 2]  # (s, n + 1) affine functions whose zero sets bound the modes
    snap: np.ndarray  # (s,) the coordinate that is set so that the surface is met to the last bit
    guard_start: np.ndarray  # (m + 1,)
    guard_surface: np.ndarray  # (g,)
    guard_sign: np.ndarray  # (g,) sign of the surface function inside the mode, ±1
    guard_transition: np.ndarray  # (g,)
    guard_parts: Annotated[np.ndarray, 2]  # (g, 3) of planar flows, see ``crossing._shape``; modal (g, q + 1), or none
    transition_reset: np.ndarray  # (t,) index of the reset, −1 for none
    resets: Annotated[np.ndarray, 3]  # (r, n, n + 1) affine maps of the state
    branch_start: np.ndarray  # (t + 1,)
    branch_mode: np.ndarray  # (b,)
    branch_kind: np.ndarray  # (b,) event kind
    branch_sign: np.ndarray  # (b,) sign that the event carries (impulse), 0 for none
    condition_start: np.ndarray  # (b + 1,)
    condition_row: Annotated[np.ndarray, 2]  # (c, n + 1)
    condition_test: np.ndarray  # (c,) lsvib.systems.kernels.layout.Test
    beyond_accumulation: np.ndarray  # (m,) mode that continues after infinitely many events in finite time, −1 for none
    shortest_stay: Annotated[float, 0]  # stays shorter than this [s], many in a row, are an accumulation


class ModalFlow(NamedTuple):
    """Flow tables of m modes with n states, up to p pairs and s singles; what a mode does not use is zero.

    The modal coordinates of a mode are those of its own pairs, two each, and then those of its singles: q in all.
    """

    pairs: Annotated[np.ndarray, 1, int]  # (m,) pairs of each mode
    singles: Annotated[np.ndarray, 1, int]  # (m,) singles of each mode
    oscillators: Annotated[np.ndarray, 3]  # (m, p, planar columns)
    rates: Annotated[np.ndarray, 2]  # (m, s) r [1/s]
    pushes: Annotated[np.ndarray, 2]  # (m, s) f, zero where the single is carried about its equilibrium
    to_modal: Annotated[np.ndarray, 3]  # (m, q, n + 1)
    from_modal: Annotated[np.ndarray, 3]  # (m, n, q + 1)
    field: Annotated[np.ndarray, 3]  # (m, n, n + 1), A and b


ORDER = 20  # of the power series of a step, which an error of a rounding asks for (Jorba and Zou 2005)


class TaylorFlow(NamedTuple):
    """Flow tables of m modes with n states whose friction depends on the sliding speed σ [m/s].

        x′ = P(x) + η d q(x),      η = μ(σ) / (1 + B μ(σ)),

    where P is the motion without friction, and q and σ are affine functions of the state. The law μ has pieces
    (:mod:`lsvib.systems.kernels.law`), of which a mode without friction has none. A motion with yᵀ S y ≤ L in a mode,
    y = x − x₀, stays there for ever.
    """

    field: Annotated[np.ndarray, 3]  # (m, n, n + 1) P
    push: Annotated[np.ndarray, 2]  # (m, n) d
    contact: Annotated[np.ndarray, 2]  # (m, n + 1) q
    speed: Annotated[np.ndarray, 2]  # (m, n + 1) σ, positive in the mode
    feedback: Annotated[np.ndarray, 1]  # (m,) B
    piece_start: Annotated[np.ndarray, 1, int]  # (m + 1,)
    pieces: Annotated[np.ndarray, 2]  # (p, PIECE)
    settled_place: Annotated[np.ndarray, 2]  # (m, n) x₀
    settled_form: Annotated[np.ndarray, 3]  # (m, n, n) S
    settled_level: Annotated[np.ndarray, 1]  # (m,) L, negative where no motion stays


def annotated(tables: type) -> dict[str, tuple]:
    """Return what stands beside the types of fields: dimensions, and the type of numbers if they are not floats."""
    hints = get_type_hints(tables, include_extras=True)
    return {name: hint.__metadata__ for name, hint in hints.items() if hasattr(hint, "__metadata__")}


# Dimensions of the tables of one system that hold its own numbers; those of many have one more axis, the first. Flow
# tables of planar flows are the first of them, those of the other kinds are below.
DIMENSIONS = {"flow": 2, **{name: own[0] for name, own in annotated(Tables).items()}}
MODAL_DIMENSIONS, TAYLOR_DIMENSIONS = (
    tuple(own[0] for own in annotated(flow).values()) for flow in (ModalFlow, TaylorFlow)
)
