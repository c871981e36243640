"""The tables that describe an automaton to the engine; ``lsvib.engine.automaton`` fills them."""

from typing import NamedTuple

import numpy as np


class Tables(NamedTuple):
    """A piecewise-linear automaton with n states as plain arrays (m modes, g guards, t transitions, b branches).

    An affine function of the state is a row of n + 1 numbers, the constant last. Guards of mode i are
    ``guard_start[i]:guard_start[i + 1]``; the other ``*_start`` arrays work alike. Transition 0 is the entry: it puts a
    start into its mode.
    """

    flow: np.ndarray  # (m, columns) coefficients of the linear flow of each mode
    surfaces: np.ndarray  # (s, n + 1) affine functions whose zero sets bound the modes
    snap: np.ndarray  # (s,) the coordinate that is set so that the surface is met to the last bit
    guard_start: np.ndarray  # (m + 1,)
    guard_surface: np.ndarray  # (g,)
    guard_sign: np.ndarray  # (g,) sign of the surface function inside the mode, ±1
    guard_transition: np.ndarray  # (g,)
    guard_parts: np.ndarray  # (g, 3) of planar flows, see ``crossing._shape``; modal forms (g, q + 1), or none (g, 0)
    transition_reset: np.ndarray  # (t,) index of the reset, −1 for none
    resets: np.ndarray  # (r, n, n + 1) affine maps of the state
    branch_start: np.ndarray  # (t + 1,)
    branch_mode: np.ndarray  # (b,)
    branch_kind: np.ndarray  # (b,) event kind
    branch_sign: np.ndarray  # (b,) sign that the event carries (impulse), 0 for none
    condition_start: np.ndarray  # (b + 1,)
    condition_row: np.ndarray  # (c, n + 1)
    condition_test: np.ndarray  # (c,) lsvib.engine.kernels.layout.Test
    beyond_accumulation: np.ndarray  # (m,) mode that continues after infinitely many events in finite time, −1 for none
    shortest_stay: float  # stays shorter than this [s], many in a row, are an accumulation


class ModalFlow(NamedTuple):
    """Flow tables of m modes with n states, up to p pairs and s singles; what a mode does not use is zero.

    The modal coordinates of a mode are those of its own pairs, two each, and then those of its singles: q in all.
    """

    pairs: np.ndarray  # (m,) pairs of each mode
    singles: np.ndarray  # (m,) singles of each mode
    oscillators: np.ndarray  # (m, p, planar columns)
    rates: np.ndarray  # (m, s) r [1/s]
    pushes: np.ndarray  # (m, s) f, zero where the single is carried about its equilibrium
    to_modal: np.ndarray  # (m, q, n + 1)
    from_modal: np.ndarray  # (m, n, q + 1)
    field: np.ndarray  # (m, n, n + 1), A and b
