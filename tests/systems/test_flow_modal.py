"""Modes with many states: the modal flow against mpmath's matrix exponential, bounds of guards and the certain walk.

The flow may be off by ``64 eps (1 + rate t)`` of the size of the state at either end and of its equilibrium, times the
condition of the mode and the growth of its fastest part; how near two rates of a pair lie must not appear in it. Guards
are looked at on sums of pairs that are decoupled, so that every one is a sum with known parts.
"""

import math
from itertools import combinations, pairwise

import numpy as np
import pytest
from flint import arb, ctx
from hypothesis import assume, given, reject, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from lsvib.systems.exact.field import Field
from lsvib.systems.exact.modal_form import guard_forms, modal_flow, modal_mode
from lsvib.systems.kernels import flow_modal, guard_sums, search_modal
from lsvib.systems.kernels.layout import A0, ALPHA, BETA, R1, R2, Found

DIGITS = 60


def as_decimals(rows):
    return [[mp.nstr(x, DIGITS) for x in row] for row in rows]


def rate_of(flow, mode=0):
    rows = flow.oscillators[mode]
    pairs = [np.abs(rows[:, R1]), np.abs(rows[:, R2]), np.abs(rows[:, ALPHA]) + rows[:, BETA]]
    return float(np.concatenate([*pairs, np.abs(flow.rates[mode])]).max()) or 1.0


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


def decoupled(factors):
    """Flow tables of blocks without coupling and force, and the number of states.

    Refuses nearly equal rates of two blocks: without coupling they are no pair, and the modal form does not carry them.
    """
    rates = [np.roots([1.0, -f[0]] if len(f) == 1 else [1.0, f[1], f[0]]) for f in factors]
    if any(np.abs(np.subtract.outer(a, b)).min() <= 1e-3 * np.abs(a).max() + 1e-6 for a, b in combinations(rates, 2)):
        raise ArithmeticError("rates coincide")
    n = sum(1 if len(factor) == 1 else 2 for factor in factors)
    rows = [[0.0] * (n + 1) for _ in range(n)]
    i = 0
    for factor in factors:
        if len(factor) == 1:
            rows[i][i] = factor[0]
            i += 1
        else:
            rows[i][i + 1], rows[i + 1][i], rows[i + 1][i + 1] = 1.0, -factor[0], -factor[1]
            i += 2
    return modal_flow([modal_mode(Field.of(rows, [1.0] * n))]), n


def drawn(factors):
    """As :func:`decoupled`, for factors that hypothesis has drawn: those whose rates lie too close are passed over."""
    try:
        return decoupled(factors)
    except ArithmeticError:
        reject()


PARTS = st.floats(-2, 2).map(lambda x: round(x, 6))
FACTORS = st.one_of(
    st.tuples(st.floats(-1e4, 50).map(lambda r: round(r, 6))),
    st.tuples(st.floats(0.1, 1e6), st.floats(0.0, 100.0)),
    st.floats(0.5, 100).map(lambda r: (r * r, 2 * r)),
)


def rounding_of(row, factors, k):
    """What forming the k-th derivative of a pair's part may lose: its P_k is a sum of terms ρ^k |P|, ρ^{k−1} |Q|."""
    rate = max(np.abs(row[[R1, R2]]).max(), np.sqrt(row[A0]))
    return 8 * EPS * rate**k * (factors[2] + factors[3] / rate)


@settings(max_examples=60)
@given(st.lists(FACTORS, min_size=1, max_size=3), st.lists(PARTS, min_size=12, max_size=12), st.floats(0, 5))
def test_bounds_bound_the_derivatives(factors, numbers, angle):
    flow, n = drawn(factors)
    rows = flow.oscillators[0]
    state, guard = np.array(numbers[:n]), np.array([*numbers[6 : 6 + n], 0.5])
    room = guard_sums.room_for(flow, 1)
    guard_sums.prepare(flow, 0, state, guard[None], room)
    left = angle / rate_of(flow) / 3
    right = left + angle / rate_of(flow)
    for node, t in ((0, left), (1, right)):
        guard_sums.go_to(flow, 0, room, t, node)
        guard_sums.evaluate(flow, 0, room, 0, node)
    eighth = (right - left) ** 2 / 8
    lowest = [guard_sums.least_between(flow, 0, room, 0, 0, 1, k, 1.0, eighth)[0] for k in range(3)]
    highest = [-guard_sums.least_between(flow, 0, room, 0, 0, 1, k, -1.0, eighth)[0] for k in range(3)]
    decays = room.pair_nodes[:2, :, 3:].max(axis=0)
    A, b = flow.field[0][:, :-1], flow.field[0][:, -1]
    for t in np.linspace(left, right, 41):
        x, terms = np.empty(n), np.empty(n)
        flow_modal.advance(flow, 0, state, t, x)
        flow_modal.travel(flow, 0, state.copy(), t, terms, room)
        derivative, weights = A @ x + b, guard[:-1]
        for k in range(guard_sums.ORDERS):
            sizes = np.abs(weights) @ np.linalg.matrix_power(np.abs(A), k) @ (np.abs(x) + np.abs(state) + terms)
            noise = sum(rounding_of(row, room.pair_bounds[0, pair, 0], k) for pair, row in enumerate(rows))
            noise += 256 * EPS * (1 + angle) * (sizes + (k == 0)) + 1e-50
            value = guard @ [*x, 1.0] if k == 0 else weights @ derivative
            if k < 3:
                assert lowest[k] - noise <= value <= highest[k] + noise
            if k:
                most = sum(guard_sums.bound(room.pair_bounds[0, pair, k], *decays[pair]) for pair in range(len(rows)))
                growth_of = room.single_nodes[:2, :, 0].max(axis=0)
                most += float(np.abs(room.singles[0, :, k]) @ growth_of)
                assert abs(value) <= most * (1 + 1e-12) + noise
                derivative = A @ derivative


def search(flow, state, guard, on_surface=False, limit=10.0):
    guards = np.array(guard, dtype=float).reshape(-1, len(state) + 1)
    found, index, t = search_modal.search(
        flow,
        0,
        np.array(state, dtype=float),
        guards,
        np.atleast_1d(on_surface),
        limit,
        guard_sums.room_for(flow, len(guards)),
    )
    return Found(found), index, t


@settings(max_examples=60)
@given(st.lists(FACTORS, min_size=1, max_size=3), st.lists(PARTS, min_size=12, max_size=12), st.floats(1, 60))
def test_first_crossing_against_dense_evaluation(factors, numbers, angle):
    """Positive on a dense grid up to the time found, and zero there; or positive all the way."""
    flow, n = drawn(factors)
    state, weights = np.array(numbers[:n]), np.array(numbers[6 : 6 + n])
    guard = [*weights, abs(numbers[5]) + 0.05 - weights @ state]
    limit = angle / rate_of(flow)
    found, _, t = search(flow, state, guard, limit=limit)
    out = np.empty(n)
    values, terms = [], 0.0
    for time in np.linspace(0, t, 400):
        flow_modal.advance(flow, 0, state, time, out)
        values.append(out @ weights + guard[-1])
        terms = max(terms, np.abs(weights) @ np.abs(out) + abs(guard[-1]))
    rounding = 64 * EPS * (1 + angle) * terms
    assert min(values[:-1]) >= -rounding
    if found == Found.NONE:
        assert t == limit
        assert values[-1] >= -rounding
    else:
        flow_modal.advance(flow, 0, state, t, out)
        rate = abs(weights @ (flow.field[0] @ [*out, 1.0]))
        assert abs(values[-1]) <= rounding + 8 * EPS * t * rate


def with_roots(roots, rates):
    """Weights a_j of Σ a_j e^{r_j t} + a_0 (a_0 = −1 scaled) that vanishes at as many times; a double root twice."""
    with mp.workdps(DIGITS):
        count = len(rates)
        equations, right = mp.matrix(count), mp.matrix(count, 1)
        for i, t in enumerate(roots):
            again = roots[:i].count(t)
            for j, r in enumerate(rates):
                equations[i, j] = mpf(r) ** again * mp.exp(mpf(r) * mpf(t))
            right[i] = mpf(0) if again else mpf(-1)
        return [float(x) for x in mp.lu_solve(equations, right)]


@pytest.mark.parametrize("rates", [(-1.0, -2.5, -7.0), (-0.5, 0.3, -30.0), (1.0, 2.0, -1.0)])
@pytest.mark.parametrize("roots", [(0.3, 0.9, 1.4), (0.2, 0.2001, 1.0), (0.7, 1.5, 1.6)])
def test_constructed_roots(rates, roots):
    """An exponential sum with three real rates and a constant has at most these three roots."""
    flow, _ = decoupled([(r,) for r in rates])
    weights = np.array(with_roots(roots, rates))
    sign = 1.0 if weights.sum() + 1 > 0 else -1.0
    now, state, found_at = 0.0, np.ones(3), []
    for k in range(3):
        found, _, t = search(flow, state, sign * np.array([*weights, 1.0]), on_surface=k > 0)
        assert found == Found.CROSSING
        flow_modal.advance(flow, 0, state, t, state)
        now += t
        found_at.append(now)
        sign = -sign
    gap = min(b - a for a, b in pairwise(roots))
    # Rounding of the weights moves a root by eps × terms / slope, and the slope is of the order of the gaps.
    terms = np.abs(weights).sum() * math.exp(2 * max(0.0, *rates)) + 1
    assert found_at == pytest.approx(roots, abs=1e4 * EPS * terms / gap)
    assert search(flow, state, sign * np.array([*weights, 1.0]), on_surface=True)[0] == Found.NONE


def test_two_roots_a_nanosecond_apart():
    """A fast oscillation that falls below zero for 1e-9 s, 1e-4 of its time scale 1/ω, beside a slow decay."""
    flow, _ = decoupled([(1e10, 0.0), (-1.0,)])
    omega = 1e5
    # The decay has no part in the guard; the dip is (ω d/2)²/2 deep for a duration d.
    for duration, expected in ((1e-9, True), (0.0, False)):
        depth = (omega * duration / 2) ** 2 / 2
        level = 1 - depth + (0.0 if expected else 1e-9)
        found, _, t = search(flow, [1.0, 0.0, 1.0], [1.0, 0.0, 0.0, level], limit=5e-5)
        assert found == (Found.CROSSING if expected else Found.NONE)
        if expected:
            assert t == pytest.approx(math.pi / omega - duration / 2, abs=1e-10)


@pytest.mark.parametrize("margin", [0.0, 1e-13, -1e-13])
def test_double_root_is_a_graze(margin):
    """A sum constructed with a double root at t = 1; moved by 1e-13 it crosses, or does not touch."""
    rates = (-1.0, -3.0)
    flow, _ = decoupled([(r,) for r in rates])
    weights = np.array(with_roots((1.0, 1.0), rates))
    sign = 1.0 if weights.sum() + 1 > 0 else -1.0
    found, _, t = search(flow, np.ones(2), sign * np.array([*weights, 1.0]) + np.array([0, 0, margin]))
    if margin == 0.0:  # the weights are rounded: within rounding it touches, or just crosses
        assert found in (Found.GRAZE, Found.CROSSING)
    else:
        assert found == (Found.NONE if margin > 0 else Found.CROSSING)
    if found != Found.NONE:
        assert t == pytest.approx(1.0, abs=1e-6)


def test_what_crosses_zero_after_it_has_died_away_does_not_touch():
    """Next to its root the guard falls below zero by 1e-18 of its start, but by a hundredth of what is left of it."""
    flow, _ = decoupled([(145.0, 24.0), (-1.0,)])
    found, _, t = search(flow, [1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0])
    assert found == Found.CROSSING
    assert t == pytest.approx(math.pi - math.atan(1 / 12), rel=1e-12)


def test_the_guard_that_falls_first_is_reported():
    """Two guards fall within one step of the walk; by the time found the later one is still positive."""
    flow, _ = decoupled([(1.0, 0.2), (-1.0,)])
    state = [1.0, 0.0, 1.0]
    early, late = [1.0, 0.0, 0.0, -0.5], [1.0, 0.0, 0.0, -0.499]
    for guards, first in (([early, late], 0), ([late, early], 1)):
        found, index, t = search(flow, state, guards, [False, False])
        assert (found, index) == (Found.CROSSING, first)
        assert t == search(flow, state, early)[2]


@pytest.mark.parametrize("touching", [0, 1])
def test_a_guard_that_falls_where_another_one_touches_is_not_passed_over(touching):
    """One guard touches zero at t = π, where it is flat over 1e-8; the other falls through zero 1e-9 before that."""
    flow, _ = decoupled([(1.0, 0.0), (-1.0,)])
    state, touches = [1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]
    falls = [0.0, 0.0, 1.0, -math.exp(1e-9 - math.pi)]
    assert search(flow, state, touches)[0] == Found.GRAZE
    guards = [touches, falls] if touching == 0 else [falls, touches]
    found, index, t = search(flow, state, guards, [False, False])
    assert (found, index) == (Found.CROSSING, 1 - touching)
    assert t == pytest.approx(math.pi - 1e-9, abs=1e-14)
