"""Fields of the tests of the modal form: their rows as text, and how fast their flow is."""

import numpy as np
from mpmath import mp

from lsvib.engine.kernels.layout import ALPHA, BETA, R1, R2

DIGITS = 60


def as_decimals(rows):
    return [[mp.nstr(x, DIGITS) for x in row] for row in rows]


def rate_of(flow, mode=0):
    rows = flow.oscillators[mode]
    pairs = [np.abs(rows[:, R1]), np.abs(rows[:, R2]), np.abs(rows[:, ALPHA]) + rows[:, BETA]]
    return float(np.concatenate([*pairs, np.abs(flow.rates[mode])]).max()) or 1.0
