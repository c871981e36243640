"""The closed-form flow of one mode against mpmath, with every kind of characteristic roots.

Tolerance: ``4 eps (1 + rate t)`` of the natural magnitude; the largest error seen was 1.4 of these units. The natural
magnitude of u is |u| + |w| T + f min(t, T)², that of w is |w| + f min(t, T), f = |b| + |a₀ u|, both times the growth of
the mode, where T = 1/√|a₀| (or t without stiffness) is its time scale: sizes of the terms that the state is summed
from. An equilibrium up to 16 times as far away as the state is one of these terms, too: u is then its distance from
it; from farther on the flow does without it. The factor 1 + rate t is the rounding of the argument of sine, cosine and
exponential.
"""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from references.cases import CASES, EPS, STARTS, advanced, rate_of
from references.oscillator import flow, number

from lsvib.engine.automaton import oscillator
from lsvib.engine.kernels import flow_planar, layout, search_planar

ANGLES = [1e-6, 1e-3, 0.1, 1.0, 3.0, 10.0, 40.0]  # rate · t


def growth(row, t) -> float:
    """How much the mode grows in a time."""
    return math.exp(max(0.0, -row[layout.ALPHA] if row[layout.BETA] > 0 else row[layout.R1]) * t)


def magnitude(row, state, t) -> np.ndarray:
    """The natural magnitude, see the module docstring."""
    u, w = state
    scale = row[layout.TIME_SCALE] if row[layout.A0] != 0 else t
    push = (abs(row[layout.B]) + abs(row[layout.A0] * u)) * min(t, scale)
    return growth(row, t) * np.array([abs(u) + abs(w) * scale + push * min(t, scale), abs(w) + push])


def error(row, coefficients, state, t) -> float:
    """Largest error of the flow in units of eps (1 + rate t) times the natural magnitude."""
    exact = flow(*coefficients, *state, t)
    gap = np.array([abs(float(number(float(x)) - y)) for x, y in zip(advanced(row, state, t), exact, strict=True)])
    sizes = magnitude(row, state, t)
    if not flow_planar.far(row, *state):
        sizes[0] += growth(row, t) * abs(row[layout.EQUILIBRIUM])
    unit = EPS * (1 + rate_of(row) * t) * sizes
    return float(np.max(np.divide(gap, unit, out=np.where(gap > 0, np.inf, 0.0), where=unit > 0)))


@pytest.mark.parametrize("name", CASES)
def test_flow_is_exact_to_rounding(name):
    row = oscillator(*CASES[name])
    for state in STARTS:
        for angle in ANGLES:
            assert error(row, CASES[name], state, angle / rate_of(row)) <= 4.0


SIZES = st.floats(1e-6, 1e6) | st.floats(-1e6, -1e-6) | st.just(0.0)


@settings(max_examples=500)
@given(
    st.floats(1e-8, 1e3) | st.floats(-1e3, -1e-8), SIZES, SIZES.filter(lambda k: k >= 0), SIZES, SIZES, SIZES,
    st.floats(1e-6, 30.0),
)  # fmt: skip
def test_flow_of_any_oscillator(inertia, damping, stiffness, force, u, w, angle):
    """A dozen operations of half a unit each; 30 000 examples that hypothesis chose to be bad came to 2.6."""
    row = oscillator(inertia, damping, stiffness, force)
    t = angle / rate_of(row)
    assume(1e-100 < t < 1e100)
    assert error(row, (inertia, damping, stiffness, force), (u, w), t) <= 4.0


@settings(max_examples=300)
@given(st.sampled_from(sorted(CASES)), st.sampled_from(STARTS), st.floats(1e-3, 3.0), st.floats(1e-3, 3.0))
def test_flows_compose(name, state, first, second):
    """φ(t + s) = φ(t) φ(s); the error of the first step may grow with the mode, as its magnitude does."""
    row = oscillator(*CASES[name])
    t, s = first / rate_of(row), second / rate_of(row)
    middle = advanced(row, state, t)
    gap = np.abs(advanced(row, middle, s) - advanced(row, state, t + s))
    # Three flows of 4 units each, the first one carried on by the second: an error of w moves u, and one of u moves w.
    own = magnitude(row, state, t + s) + magnitude(row, middle, s)
    carried = magnitude(row, magnitude(row, state, t), s) + np.abs(row[layout.B]) * np.array([s * s, s])
    assert (gap <= 4 * EPS * (1 + rate_of(row) * (t + s)) * (own + carried)).all()


@settings(max_examples=300)
@given(
    st.sampled_from(sorted(CASES)), st.sampled_from(STARTS), st.floats(0.0, 30.0), st.floats(-1, 1), st.floats(-1, 1)
)
def test_extremes_against_dense_evaluation(name, state, angle, part_u, part_w):
    row = oscillator(*CASES[name])
    duration = angle / rate_of(row)
    functional = np.array([part_u, part_w, 0.25])
    low, high = search_planar.extremes(np.array([row]), 0, np.array(state), functional, duration)
    points = np.array([advanced(row, state, t) for t in np.linspace(0, duration, 400)])
    values = points @ functional[:2] + functional[2]
    terms = np.abs(functional) @ [*magnitude(row, state, duration), 1.0]
    rounding = 16 * EPS * (1 + angle) * terms
    assert low <= values.min() + rounding
    assert high >= values.max() - rounding
    # Between two of the 400 points the functional bends by no more than (30/400)²/8 of its swing, or is monotone.
    assert values.min() - low <= 1e-2 * terms
    assert high - values.max() <= 1e-2 * terms


@pytest.mark.parametrize(
    "coefficients", [("1", "-0.2", "1", "0.5"), ("1", "-3", "1", "0.5"), ("1", "0.2", "-1", "0.5")]
)
def test_magnitudes_grow_with_the_motion(coefficients):
    """From 1e-9 off the equilibrium, a millionfold: the terms are as large as the motion has become."""
    row = oscillator(*coefficients)
    state = np.array([row[layout.EQUILIBRIUM] + 1e-9, 0.0])
    rate = -row[layout.ALPHA] if row[layout.BETA] > 0 else row[layout.R1]
    stay = math.log(1e6) / rate
    scale = np.zeros(2)
    flow_planar.magnitudes(np.array([row]), 0, state, stay, scale)
    size = 1e-9 * 1e6 * max(1.0, rate)
    assert 1e-3 * 0.99 <= scale[0] - abs(row[layout.EQUILIBRIUM]) <= 4 * size
    assert 1e-3 * 0.99 <= scale[1] <= 4 * size
