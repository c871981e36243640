"""Modes with many states: the modal flow against mpmath's matrix exponential.

The flow may be off by ``64 eps (1 + rate t)`` of the size of the state at either end and of its equilibrium, times the
condition of the mode and the growth of its fastest part; how near two rates of a pair lie must not appear in it.
"""

import math

import numpy as np
import pytest
from flint import arb, ctx
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from references.modal_fields import DIGITS, as_decimals, rate_of

from lsvib.engine.exact.field import Field
from lsvib.engine.exact.modal_form import guard_forms, modal_flow, modal_mode
from lsvib.engine.kernels import flow_modal
from lsvib.engine.kernels.layout import ALPHA, BETA, R1

EPS = float(np.finfo(float).eps)


def companion(rates):
    """A field of chained oscillators and single rates with the given real factors; strings are taken exactly.

    A factor is (r,) or a pair (a0, a1) of s² + a₁ s + a₀. Neighbouring blocks push each other one way, so the rates are
    exactly those of the blocks while the vectors are mixed.
    """
    sizes = [1 if len(factor) == 1 else 2 for factor in rates]
    n = sum(sizes)
    rows = [[mpf(0)] * (n + 1) for _ in range(n)]
    i = 0
    for factor, size in zip(rates, sizes, strict=True):
        if size == 1:
            rows[i][i] = mpf(factor[0])
        else:
            rows[i][i + 1] = mpf(1)
            rows[i + 1][i], rows[i + 1][i + 1] = -mpf(factor[0]), -mpf(factor[1])
        if i:
            rows[i + size - 1][i - 1] = mpf("0.3")
        rows[i + size - 1][n] = mpf("0.7")
        i += size
    return rows


def exact(rows, state, t):
    """State after t by the matrix exponential, with so many digits that fast rates lose none that matter."""
    n = len(rows)
    with mp.workdps(DIGITS + 40):
        extended = mp.matrix(n + 1)
        for i, row in enumerate(rows):
            for j, x in enumerate(row):
                extended[i, j] = x * mpf(t)
        return (mp.expm(extended) * mp.matrix([*map(mpf, state), 1]))[:n]


def growth(flow, t):
    """Largest factor by which a part of the state grows."""
    rows = flow.oscillators[0]
    rates = [*np.where(rows[:, BETA] > 0.0, -rows[:, ALPHA], rows[:, R1]), *flow.rates[0]]
    return math.exp(max(0.0, *rates) * t)


def flow_error(rows, state, t, mode=None):
    """Error of every coordinate in units of eps (1 + rate t) × condition × size × growth."""
    mode = mode or modal_mode(Field.of(as_decimals(rows), [1.0] * len(rows)))
    flow = modal_flow([mode])
    out = np.empty(len(rows))
    flow_modal.advance(flow, 0, np.array(state, dtype=float), t, out)
    size = max(np.abs(state).max(), np.abs(mode.from_modal[:, -1]).max(), np.abs(mode.to_modal[:, -1]).max() * t)
    expected = exact(rows, state, t)
    size = max(size, *(abs(float(x)) for x in expected))
    unit = EPS * (1 + rate_of(flow) * t) * max(mode.condition, 1.0) * size * growth(flow, t)
    return max(abs(float(mpf(float(x)) - y)) for x, y in zip(out, expected, strict=True)) / unit


FIELDS = {
    "two complex pairs": [("9", "0.3"), ("1e4", "20")],
    "undamped pair beside a decay": [("4", "0"), ("-3",)],
    "exactly critical": [("9", "6"), ("-40",)],
    "two critical pairs": [("9", "6"), ("1e4", "200")],
    "zero rate": [("9", "0.3"), ("0",)],
    "zero rate beside critical": [("0",), ("9", "6"), ("-1",)],
    "growing": [("-4", "1"), ("-7",)],
    "stiff": [("1e16", "1e8"), ("1", "0.1")],
    "stiff real": [("-1e8",), ("-1",), ("4", "0.1")],
    "slow": [("-1e-2",), ("1e5", "20"), ("-1e7",)],
    "six states": [("1", "0.1"), ("100", "25"), ("1e12", "1e3")],
    "five states": [("-1",), ("-50",), ("2000",), ("1e4", "1e3")],
}
FIELDS |= {f"real rates 1e-{k} apart": [(str(mpf(-3)),), (f"-3.{'0' * (k - 1)}1",), ("100", "1")] for k in range(3, 17)}
FIELDS |= {
    f"nearly critical, 1e-{k} {side}": [(f"9.{'0' * (k - 1)}1" if side == "complex" else f"8.{'9' * k}", "6"), ("-70",)]
    for k in range(3, 17)
    for side in ("complex", "real")
}


@pytest.mark.parametrize("name", FIELDS)
def test_flow_against_the_matrix_exponential(name):
    with mp.workdps(DIGITS):
        rows = companion(FIELDS[name])
        n = len(rows)
        mode = modal_mode(Field.of(as_decimals(rows), [1.0] * n))
        assert mode.condition < 1e4
        fastest = rate_of(modal_flow([mode]))
        for state in (np.ones(n), np.linspace(-1, 2, n), np.eye(n)[-1]):
            for angle in (1e-3, 0.1, 1.0, 10.0):
                assert flow_error(rows, state, angle / fastest, mode) <= 64.0


@settings(max_examples=60)
@given(
    st.integers(2, 6).flatmap(
        lambda n: st.tuples(
            st.lists(st.integers(-999, 999), min_size=n * (n + 1), max_size=n * (n + 1)),
            st.lists(st.floats(-2, 2), min_size=n, max_size=n),
            st.lists(st.floats(0, 3), min_size=n, max_size=n),
        )
    ),
    st.floats(1e-3, 5.0),
)
def test_flow_of_random_fields(numbers, angle):
    entries, state, powers = numbers
    n = len(state)
    rows = [[mpf(entries[i * (n + 1) + j]) * mpf(10.0 ** powers[i]) / 100 for j in range(n + 1)] for i in range(n)]
    try:
        mode = modal_mode(Field.of([[float(x) for x in row] for row in rows], [1.0] * n))
    except ArithmeticError:
        assume(False)
    rows = [[mpf(float(x)) for x in row] for row in rows]
    assume(np.abs(state).max() > 1e-3)
    assert flow_error(rows, np.array(state), angle / rate_of(modal_flow([mode])), mode) <= 64.0


def test_frozen_coordinate_keeps_its_value():
    """x₀′ = x₁ with x₁ frozen at −40: x₀ runs away evenly while an oscillator beside it is pushed by it."""
    rows = [[0, 1, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 1, 0], [50, 0, -900, -4, 7]]
    mode = modal_mode(Field.of(rows, [1.0] * 4, {1: -40}))
    out = np.empty(4)
    state = np.array([0.3, -40.0, 0.1, 2.0])
    flow_modal.advance(modal_flow([mode]), 0, state, 0.05, out)
    expected = exact([[mpf(x) for x in row] for row in rows], state, 0.05)
    assert out == pytest.approx([float(x) for x in expected], rel=1e-13)


@pytest.mark.parametrize(
    "factors",
    [
        [("-7713.714101",), ("803.5588913535906", "56.69422867818525"), ("-6170.815344",)],
        [("-1",), ("4", "0.1"), ("-1.5",)],
        [("4", "0.1"), ("-2",), ("-2.5",), ("0",)],
    ],
)
def test_uncoupled_parts_are_carried_to_and_fro(factors):
    """Without coupling most rows of a projector are zero, but for rounding: none of these may be built upon."""
    with mp.workdps(DIGITS):
        field = [[mpf(0) if abs(x) in (mpf("0.3"), mpf("0.7")) else x for x in row] for row in companion(factors)]
        mode = modal_mode(Field.of(as_decimals(field), [1.0] * len(field)))
    identity = mode.from_modal[:, :-1] @ mode.to_modal[:, :-1]
    assert identity == pytest.approx(np.eye(len(field)), abs=64 * EPS * mode.condition)


@pytest.mark.parametrize("push", [3.0, 3e5])
def test_a_slow_rate_is_carried_about_an_equilibrium_nearby(push):
    """From a start 1e9 times as far away nothing is left after 300 time constants; far equilibria are carried without.

    With the latter, the rounding of the start stayed, 1e-7 of the equilibrium.
    """
    mode = modal_mode(Field.of([[-5, 0, 0, push], [0, 0, 1, 0], [20, -1e4, -20, 0]], [1.0] * 3))
    flow, out = modal_flow([mode]), np.empty(3)
    assert (flow.pushes[0, 0] == 0.0) == (push == 3.0)
    flow_modal.advance(flow, 0, np.array([1e9, 0.0, 0.0]), 60.0, out)
    if push == 3.0:
        assert out == pytest.approx([0.6, 0.6 * 20 / 1e4, 0.0], rel=4 * EPS, abs=4 * EPS)


def test_a_guard_has_no_part_that_is_rounding_of_its_coefficients():
    """x₁ rests at −Ω, so that r (x₁ + Ω) is zero, however r Ω has been rounded to 50 digits."""
    with ctx.workdps(50):
        radius, speed = (arb(1) / 3).mid(), (arb(30) / 7).mid()
        rows = [[0, 1, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 1, 0], [0, 0, -7000, -800, 0]]
        mode = modal_mode(Field.of(rows, [1.0] * 4, {1: -speed}))
        row = (0, radius, 0, 1, (radius * speed).mid())
    with ctx.workdps(150):
        assert 0 < abs(row[4] - radius * speed) < 1e-49
    (form,) = guard_forms([mode], [[row]])
    assert form[-1] == 0.0
    assert np.count_nonzero(form) == 2  # both rates of x₂


def test_chain_of_zeros_is_refused():
    with pytest.raises(ArithmeticError, match="with a chain"):
        modal_mode(Field.of([[0, 1, 0, 0], [0, 0, 0, 1], [0, 0, -1, 0]], [1.0] * 3))


def test_growing_part_keeps_its_relative_accuracy_beside_a_slow_one():
    """A trace of a mode that grows by e⁴⁰ at 1e8 1/s beside rates of ±2000 1/s, as in a seizure of the stiff drive."""
    with mp.workdps(DIGITS):
        rows = [[mpf(x) for x in row] for row in (["1e8", 0, 0, 0], [0, 2000, 0, 0], [0, 0, -2000, 0])]
        # Mixed coordinates x = M y with M of small whole numbers, so that no coordinate is a mode by itself.
        mix = mp.matrix([[1, 1, 1], [1, 2, 0], [1, 0, 1]])
        field = mix * mp.matrix([row[:3] for row in rows]) * mix**-1
        rows = [[*field[i, :], mpf(0)] for i in range(3)]
        mode = modal_mode(Field.of(as_decimals(rows), [1.0] * 3))
        state = np.array([2.0, 2.0, 1.0])
        t = 40 / 1e8
        out = np.empty(3)
        flow_modal.advance(modal_flow([mode]), 0, state, t, out)
        # The state is M (0, 1, 1): no trace of the fast part, so none may appear.
        trace = (mix**-1 * mp.matrix([mpf(x) for x in state]))[0]
        expected = exact(rows, state, t)
        noise = EPS * 1e-4 * math.exp(40)  # the slow rates over the fast one times eps, grown
        assert trace == 0
        assert max(abs(float(mpf(float(x)) - y)) for x, y in zip(out, expected, strict=True)) <= 64 * noise + 64 * EPS
