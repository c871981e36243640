"""Oscillators with every kind of characteristic roots, for the tests of the flow and of the search for roots."""

from decimal import Decimal, localcontext

import numpy as np

from lsvib.engine.kernels import flow_planar, layout

EPS = float(np.finfo(float).eps)
STARTS = [(1.0, 0.0), (0.0, 1.0), (1.0, -2.0), (-0.3, 5.0), (1e-3, 1e-3), (0.0, 0.0)]


def roots(first, second, force="0"):
    """Coefficients (inertia, damping, stiffness, force) of an oscillator with two given real roots, as text."""
    first, second = Decimal(first), Decimal(second)
    with localcontext(prec=60):
        return "1", str(-(first + second)), str(first * second), str(force)


def split(distance: str, side: int):
    """Roots −3 and −3 (1 ± distance), or a complex pair that far apart (side 0)."""
    with localcontext(prec=60):
        if side == 0:
            return "1", "6", str(9 * (1 + Decimal(distance))), "1"
        return roots(-3, -3 * (1 + side * Decimal(distance)), 1)


CASES = {
    "underdamped": ("1", "0.3", "9", "2"), "overdamped": roots(-1, -30, 2), "critically damped": roots(-3, -3, "1.7"),
    "zero stiffness": ("1", "2", "0", "3"), "zero damping": ("1", "0", "4", "3"),
    "zero damping, no force": ("1", "0", "4", "0"), "both zero": ("1", "0", "0", "3"),
    "nothing at all": ("1", "0", "0", "0"), "negative damping": ("1", "-0.4", "9", "1"),
    "negative damping, real roots": roots(2, 3, 1), "negative damping, no stiffness": ("1", "-2", "0", "3"),
    "negative stiffness": roots(2, -3, 1), "stiff": roots("-1e-2", "-1e6", 3), "stiff and fast": roots(-1, "-1e8", 3),
    "soft spring, far equilibrium": ("1", "0", "1e-12", "1"),
    "soft damped spring, far equilibrium": ("1", "1e-3", "1e-12", "1"),
    "a trace of damping": ("1", "1e-25", "4", "3"), "the chapter's drive": ("3.12e-6", "2e-4", "1", "0"),
    "negative inertia": ("-3.12e-7", "2e-4", "1", "0.1"),
}  # fmt: skip
CASES |= {f"roots 1e-{n} apart, side {side}": split(f"1e-{n}", side) for n in range(3, 16) for side in (1, -1, 0)}


def rate_of(row) -> float:
    return float(abs(row[layout.ALPHA]) + row[layout.BETA] + row[layout.DELTA]) or 1.0


def advanced(row, state, t) -> np.ndarray:
    out = np.empty(2)
    flow_planar.advance(np.array([row]), 0, np.array(state, dtype=float), t, out)
    return out
