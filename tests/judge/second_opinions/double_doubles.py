"""Sums and products of numbers that are pairs of doubles, about 32 digits; Dekker (1971) and Knuth.

An array of such numbers has them along its last axis of length 2: leading part and rest.
"""

import math

import numpy as np

from judge.second_opinions.jit import allocating_kernel, inlined_kernel, kernel

_SPLIT = 134217729.0  # 2^27 + 1 cuts a double into two halves of 26 digits


def pair(number) -> tuple[float, float]:
    """Round a number of many digits to a pair."""
    leading = float(number)
    return leading, float(number - leading)


@inlined_kernel
def add(a, b, c, d):
    """(a + b) + (c + d)."""
    s = a + c
    z = s - a
    e = (a - (s - z)) + (c - z)
    e += b + d
    t = s + e
    return t, e - (t - s)


@inlined_kernel
def multiply(a, b, c, d):
    """(a + b) (c + d); the halves of a and c are multiplied without error."""
    p = a * c
    t = _SPLIT * a
    a1 = t - (t - a)
    a2 = a - a1
    t = _SPLIT * c
    c1 = t - (t - c)
    c2 = c - c1
    e = ((a1 * c1 - p) + a1 * c2 + a2 * c1) + a2 * c2
    e += a * d + b * c
    s = p + e
    return s, e - (s - p)


@kernel
def affine(row, x):
    """Value of an affine function, row (5, 2) over the state x (4, 2) and 1."""
    h, e = row[4, 0], row[4, 1]
    for i in range(4):
        if row[i, 0] != 0.0:
            p, q = multiply(row[i, 0], row[i, 1], x[i, 0], x[i, 1])
            h, e = add(h, e, p, q)
    return h, e


@kernel
def moved(table, x, out):
    """x + E x + e for the table (4, 5, 2) of E and e; ``out`` (4, 2) is another array than ``x``."""
    for i in range(4):
        h, e = affine(table[i], x)
        out[i, 0], out[i, 1] = add(x[i, 0], x[i, 1], h, e)


@kernel
def composed(row, table, out):
    """The row (5, 2), without its own constant, over what a table (4, 5, 2) returns."""
    for j in range(5):
        h, e = 0.0, 0.0
        for i in range(4):
            p, q = multiply(row[i, 0], row[i, 1], table[i, j, 0], table[i, j, 1])
            h, e = add(h, e, p, q)
        out[j, 0], out[j, 1] = h, e


@allocating_kernel
def exponential(field, h, terms, table):
    """exp(h A) − 1, with the part of the constant, by its series: field (4, 5, 2) of A and b, table (4, 5, 2).

    ``h`` is a power of two, far below the fastest time.
    """
    power, following = np.empty((4, 5, 2)), np.empty((4, 5, 2))
    power[:] = h * field
    table[:] = power
    for k in range(2, terms):
        for i in range(4):
            composed(field[i], power, following[i])
        for i in range(4):
            for j in range(5):
                # 1/k as a pair: what its leading part leaves out, by the exact product with k
                c = 1.0 / k
                p, q = multiply(c, 0.0, float(k), 0.0)
                rest = ((1.0 - p) - q) / k
                a, b = multiply(following[i, j, 0] * h, following[i, j, 1] * h, c, rest)
                power[i, j, 0], power[i, j, 1] = a, b
                table[i, j, 0], table[i, j, 1] = add(table[i, j, 0], table[i, j, 1], a, b)


@allocating_kernel
def doubled(table, out):
    """exp(2 h A) − 1 = 2 E + E² from E = exp(h A) − 1; slow rates keep their digits beside fast ones."""
    square = np.empty((5, 2))
    for i in range(4):
        composed(table[i], table, square)
        for j in range(5):
            a, b = 2.0 * table[i, j, 0], 2.0 * table[i, j, 1]
            out[i, j, 0], out[i, j, 1] = add(a, b, square[j, 0], square[j, 1])


@kernel
def finite(x):
    """Whether all of x (4, 2) is in the range of numbers."""
    total = 0.0
    for i in range(4):
        total += abs(x[i, 0]) + abs(x[i, 1])
    return math.isfinite(total)
