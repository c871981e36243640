"""Flow in blocks, what the modal form cannot carry: against mpmath's matrix exponential, its bounds, and its walk.

The tolerances of the flow are those of the project, 1e-9 of the largest coordinate, and 1e-12 s for events; the field
is of rates near 1/s, so that the latter is 1e-12 of a time scale.
"""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf
from references.wide_scenes import scene

from lsvib.engine.exact.block_form import block_flow, block_mode
from lsvib.engine.exact.field import exact_field
from lsvib.engine.exact.flow_choice import flow_of, linear_mode
from lsvib.engine.kernels import dispatch, guard_blocks
from lsvib.engine.kernels.status import Found, Status
from lsvib.engine.kernels.tables import BlockFlow, ModalFlow
from lsvib.engine.motion import Budget, follow

DIGITS = 60
CHAIN = [[-3, 1, 0, 0, 0.1], [0, -3, 1, 0, 0], [0, 0, -3, 0, 0.7], [0, 0, 0, -50, 1]]
SEMISIMPLE = [[-0.5, 7, 0, 0, 0], [-7, -0.5, 0, 0, 0.3], [0, 0, -0.5, 7, 0], [0, 0, -7, -0.5, 0.7]]
JORDAN = [[-0.5, 7, 1, 0, 0], [-7, -0.5, 0, 1, 0.3], [0, 0, -0.5, 7, 0], [0, 0, -7, -0.5, 0.7]]
FIELDS = {
    "three real rates with a chain": CHAIN,
    "four real rates with a chain": [[-2, 1, 0, 0, 0], [0, -2, 1, 0, 0], [0, 0, -2, 1, 0], [0, 0, 0, -2, 1]],
    "two equal complex pairs with a chain": JORDAN,
    "undamped, with a chain": [[0, 7, 1, 0, 0], [-7, 0, 0, 1, 0.3], [0, 0, 0, 7, 0], [0, 0, -7, 0, 0.7]],
    "zero rates with a chain": [[0, 1, 0, 0, 0], [0, 0, 0.5, 0, 0], [0, 0, -5, 0, 1], [0, 0, 0, -9, 0.4]],
    "zero rates only": [[0, 1, 0, 0, 0.1], [0, 0, 1, 0, 0], [0, 0, 0, 1, 0], [0, 0, 0, 0, 0.5]],
    "three rates with a chain beside 1e8": [
        [-3, 1, 0, 0, 0],
        [0, -3, 1, 0, 0],
        [0, 0, -3, 1, 0.7],
        [0, 0, 0, -1e8, 1e8],
    ],
    "growing, with a chain": [[2, 1, 0, 0, 0], [0, 2, 1, 0, 0], [0, 0, 2, 0, 0.3], [0, 0, 0, -1, 0.1]],
    "condition 1e13": [[-1, 1, 0, 0, 0], [0, -1.0001, 1, 0, 0], [0, 0, -1.0002, 1, 0], [0, 0, 0, -1.0003, 1]],
}


def mixed(field):
    """The field in coordinates x = M y with M of small whole numbers, so that no coordinate is a mode by itself."""
    with mp.workdps(DIGITS):
        mix = mp.matrix([[1, 1, 1, 0], [1, 2, 0, 1], [1, 0, 1, -1], [0, 1, 1, 2]])
        rows = mp.matrix([[mpf(x) for x in row] for row in field])
        matrix, push = mix * rows[:, :4] * mix**-1, mix * rows[:, 4]
        return [[mp.nstr(x, DIGITS) for x in (*matrix[i, :], push[i])] for i in range(4)]


def homogeneous(rows):
    extended = mp.matrix(5)
    for i, row in enumerate(rows):
        for j, x in enumerate(row):
            extended[i, j] = mpf(x)
    return extended


def exact(rows, state, t):
    with mp.workdps(DIGITS + 40):
        return (mp.expm(homogeneous(rows) * mpf(t)) * mp.matrix([*map(mpf, state), 1]))[:4]


def in_blocks(rows):
    return block_flow([block_mode(exact_field(rows, [1.0] * 4))])


@cache
def chained(name):
    return in_blocks(mixed(FIELDS[name]))


@pytest.mark.parametrize("name", FIELDS)
def test_flow_against_the_matrix_exponential(name):
    rows = mixed(FIELDS[name])
    mode = linear_mode(rows, [1.0] * 4)
    assert mode.modal is None
    flow = flow_of([mode])
    assert isinstance(flow, BlockFlow)
    out = np.empty(4)
    for state in (np.ones(4), np.array([-1.0, 0.0, 1.0, 2.0])):
        for t in (1e-9, 1e-3, 0.1, 1.0, 10.0):
            dispatch.advance(flow, 0, state, t, out)
            expected = exact(rows, state, t)
            size = max(abs(float(x)) for x in expected)
            assert max(abs(float(mpf(float(x)) - y)) for x, y in zip(out, expected, strict=True)) <= 1e-13 * size


def test_equal_pairs_without_a_chain_are_modal():
    rows = mixed(SEMISIMPLE)
    flow = flow_of([linear_mode(rows, [1.0] * 4)])
    assert isinstance(flow, ModalFlow)
    out, state = np.empty(4), np.array([-1.0, 0.0, 1.0, 2.0])
    for t in (0.1, 1.0, 10.0):
        dispatch.advance(flow, 0, state, t, out)
        assert out == pytest.approx([float(x) for x in exact(rows, state, t)], abs=1e-13)


def test_one_refused_mode_puts_all_in_blocks():
    ordinary, refused = linear_mode(mixed(SEMISIMPLE), [1.0] * 4), linear_mode(mixed(JORDAN), [1.0] * 4)
    assert ordinary.modal is not None
    assert refused.modal is None
    flow = flow_of([ordinary, refused])
    assert isinstance(flow, BlockFlow)
    out, state = np.empty((2, 4)), np.ones(4)
    dispatch.advance(flow, 0, state, 0.7, out[0])
    dispatch.advance(flow_of([ordinary]), 0, state, 0.7, out[1])
    assert out[0] == pytest.approx(out[1], rel=1e-13, abs=1e-13)


def test_frozen_coordinate_keeps_its_value():
    rows = [[0, 1, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 1, 0], [50, 0, -900, -4, 7]]
    flow = block_flow([block_mode(exact_field(rows, [1.0] * 4, {1: -40}))])
    out, state = np.empty(4), np.array([0.3, -40.0, 0.1, 2.0])
    dispatch.advance(flow, 0, state, 0.05, out)
    assert out[1] == -40.0
    assert out == pytest.approx([float(x) for x in exact(rows, state, 0.05)], rel=1e-13)


def test_at_rest_an_angle_is_not_rounded_to_the_size_of_a_constant():
    """The angle of a nut that rests while its screw's support creeps: it has a block of its own with a zero rate."""
    speed, start, time = 0.017746, -4.025e-10, 3.577e-07
    rows = [[0, 1, 0, 0, 0], [0, 0, 0, 0, 0], [0, 0, 0, 1, 0], [0, 0, -9912.7, -411.43, -39.292]]
    flow = block_flow([block_mode(exact_field(rows, [0.41, speed, 0.004, 0.1], {1: speed}))])
    out = np.empty(4)
    dispatch.advance(flow, 0, np.array([start, speed, -21.0, 4.5e-07]), time, out)
    assert out[0] == pytest.approx(start + speed * time, rel=1e-14)


def bound_holds(flow, state, guard, left, step, share=1.0) -> bool:
    """Whether a share of the bounds of the derivatives 2 to 4 of a guard bounds them on [left, left + step]."""
    work = guard_blocks.room_for(flow, 1)
    guard_blocks.prepare(flow, 0, np.array(state), guard[None], work)
    guard_blocks.go_to(flow, 0, work, left, 1)
    assert guard_blocks.stand(flow, 0, work, 1, left)
    most = [guard_blocks.bound(flow, 0, work, 0, k, step) for k in range(guard_blocks.ORDERS)]
    for t in np.linspace(left, left + step, 41):
        guard_blocks.go_to(flow, 0, work, t, 2)
        for k in range(2, guard_blocks.ORDERS):
            if abs(work.weights[0, k] @ work.states[2]) > share * most[k] * (1 + 1e-9):
                return False
    return True


GUARD = np.array([1.0, -0.7, 0.4, 0.2, 0.3])


@pytest.mark.parametrize("name", FIELDS)
def test_bounds_bound_the_derivatives(name):
    flow = chained(name)
    for state in (*np.eye(4), np.array([-1.0, 0.0, 1.0, 2.0])):
        for left in (0.0, 0.3):
            for step in (1e-3, 0.1, 1.0):
                assert bound_holds(flow, state, GUARD, left, step)


def test_bounds_need_the_growth():
    """Broken on purpose: with σ = 0 the bounds do not hold where derivatives grow within a step."""
    flow = chained("growing, with a chain")
    broken = flow._replace(growth=np.minimum(flow.growth, 0.0))
    assert all(bound_holds(flow, state, GUARD, 0.0, 3.0) for state in np.eye(4))
    assert not any(bound_holds(broken, state, GUARD, 0.0, 3.0) for state in np.eye(4))


@pytest.mark.parametrize("name", FIELDS)
def test_bounds_are_not_wasteful(name):
    """A thirtieth of the bounds does not hold in every state: a missing factor in them would be seen."""
    flow = chained(name)
    assert not all(bound_holds(flow, state, GUARD, 0.0, 1e-9, share=1 / 30) for state in np.eye(4))


def search(flow, state, guard, limit=5.0, on_surface=False):
    found, index, t = dispatch.search(
        flow, 0, np.array(state), guard[None], np.array([on_surface]), limit, dispatch.workspace(flow, 1)
    )
    assert index == (0 if found in (Found.CROSSING, Found.GRAZE) else -1)
    return Found(found), t


def dense_first_fall(rows, state, guard, limit, steps=2000):
    """First time at which a guard falls through zero, by dense evaluation in many digits, or None."""
    with mp.workdps(40):
        field = homogeneous(rows)
        flow = mp.expm(field * (mpf(limit) / steps))
        weights, x = mp.matrix([list(map(mpf, guard))]), mp.matrix([*map(mpf, state), 1])
        for k in range(steps):
            ahead = flow * x
            if (weights * ahead)[0] <= 0:
                low, high = mpf(0), mpf(limit) / steps
                for _ in range(60):
                    middle = (low + high) / 2
                    below = (weights * (mp.expm(field * middle) * x))[0] <= 0
                    low, high = (low, middle) if below else (middle, high)
                return float(mpf(limit) * k / steps + high)
            x = ahead
    return None


@pytest.mark.parametrize("name", [name for name in FIELDS if "1e8" not in name])
def test_events_against_dense_evaluation(name):
    rows = mixed(FIELDS[name])
    flow, state, count = chained(name), np.array([-1.0, 0.0, 1.0, 2.0]), 0
    for sign in (1, -1):
        guard = np.array([1.0, -0.7, 0.4, 0.2, 0.0]) * sign
        guard[4] = 0.1 - guard[:4] @ state
        expected = dense_first_fall(rows, state, guard, 3.0, 300)
        found, t = search(flow, state, guard, 3.0)
        assert found == (Found.NONE if expected is None else Found.CROSSING)
        if expected is not None:
            count += 1
            assert t == pytest.approx(expected, abs=1e-12)
    assert count


ENTRIES = st.lists(st.integers(-400, 400).map(lambda x: x / 100), min_size=20, max_size=20)
NUMBERS = st.lists(st.integers(-200, 200).map(lambda x: x / 100), min_size=8, max_size=8)


@settings(max_examples=15, phases=[Phase.explicit, Phase.generate])  # a field takes 0.1 s: not shrunk
@given(ENTRIES, NUMBERS, st.floats(0.02, 1.0))
def test_agrees_with_the_modal_flow(entries, numbers, level):
    """An ordinary field carried both ways: the same event, at the same time, and the same extremes and states."""
    rows = [entries[5 * i : 5 * i + 5] for i in range(4)]
    mode = linear_mode(rows, [1.0] * 4)
    assume(mode.modal is not None and mode.modal.condition < 1e3)
    ours, theirs = in_blocks(rows), flow_of([mode])
    state, guard = np.array(numbers[:4]), np.array([*numbers[4:], 0.0])
    assume(np.abs(guard).max() > 0.1)
    guard[4] = level - guard[:4] @ state
    results = [search(flow, state, guard, 2.0) for flow in (ours, theirs)]
    out = np.empty((2, 4))
    for k, flow in enumerate((ours, theirs)):
        dispatch.advance(flow, 0, state, results[0][1], out[k])
    size = np.abs(out).max() + np.abs(state).max()
    assert out[0] == pytest.approx(out[1], abs=1e-11 * size)
    rate = abs(guard[:4] @ (np.array(rows) @ [*out[1], 1.0]))
    if rate > 1e-3 * size:  # not a graze
        assert results[0][0] == results[1][0]
        assert results[0][1] == pytest.approx(results[1][1], abs=1e-9)
    lows, highs = zip(*(dispatch.extremes(flow, 0, state, guard, 1.0) for flow in (ours, theirs)), strict=True)
    assert lows[0] == pytest.approx(lows[1], abs=1e-9 * (1 + size))
    assert highs[0] == pytest.approx(highs[1], abs=1e-9 * (1 + size))


def test_two_roots_close_together_are_not_passed_over():
    """A guard of an undamped chain that dips below zero for 1e-6 of its time scale."""
    flow = chained("undamped, with a chain")
    state, guard, out = np.array([-1.0, 0.0, 1.0, 2.0]), np.array([1.0, -0.7, 0.4, 0.2, 0.0]), np.empty(4)
    rate = np.append(guard[:4] @ flow.field[0][:, :4], guard[:4] @ flow.field[0][:, 4])
    sign = np.sign(rate[:4] @ state + rate[4])
    turns = [search(flow, state, sign * rate, 5.0)[1]]  # the first extremum; from there on, to the next one
    dispatch.advance(flow, 0, state, turns[0], out)
    turns.append(search(flow, out.copy(), -sign * rate, 5.0, on_surface=True)[1])
    lowest = turns[0] if sign < 0 else sum(turns)
    start = np.empty(4)
    dispatch.advance(flow, 0, state, lowest - 0.2, start)
    dispatch.advance(flow, 0, state, lowest, out)
    floor = guard[:4] @ out
    for depth, expected in ((1e-12, Found.CROSSING), (-1e-12, Found.NONE)):
        guard[4] = -floor - depth
        assert search(flow, start, guard, 0.4)[0] == expected


@pytest.mark.parametrize("carried", ["modal", "in blocks"])
def test_a_touch_is_no_crossing_and_a_dip_beyond_rounding_is_one(carried):
    """An undamped guard that starts at zero comes back to zero after a turn, where rounding alone would split it."""
    rows = mixed([[0, 3, 0, 0, 0], [-3, 0, 0, 0, 0], [0, 0, 0, 7, 0], [0, 0, -7, 0, 0]])
    flow = in_blocks(rows) if carried == "in blocks" else flow_of([linear_mode(rows, [1.0] * 4)])
    assert isinstance(flow, BlockFlow) == (carried == "in blocks")
    mix = np.array([[1.0, 1, 1, 0], [1, 2, 0, 1], [1, 0, 1, -1], [0, 1, 1, 2]])
    first, rng, start = np.linalg.inv(mix)[0], np.random.default_rng(5), np.empty(4)
    for _ in range(300):
        size, other = rng.uniform(0.1, 10.0), rng.uniform(-1.0, 1.0, 2)
        state = mix @ [size, 0.0, *other]
        touches = np.append(-first, first @ state)
        found, t = search(flow, state, touches, 3.0, on_surface=True)
        assert found in (Found.GRAZE, Found.NONE)
        assert found == Found.NONE or abs(t - 2 * np.pi / 3) < 1e-7
        touches[4] -= 1e-12 * size
        dispatch.advance(flow, 0, state, 2 * np.pi / 3 - 0.5, start)
        found, t = search(flow, start, touches, 1.0)
        assert found == Found.CROSSING
        assert 0.5 - 1e-6 < t < 0.5


def test_settles_where_every_block_dies_away():
    flow = in_blocks(mixed(CHAIN))
    rest = np.linalg.solve(flow.field[0][:, :4], -flow.field[0][:, 4])
    guard = np.array([1.0, -0.7, 0.4, 0.2, 0.0])
    guard[4] = 1.0 - guard[:4] @ rest
    assert search(flow, rest + np.array([0.1, 0.0, -0.1, 0.0]), guard, np.inf) == (Found.NONE, np.inf)
    guard[4] -= 1.0 + 1e-6
    assert search(flow, rest + np.array([0.1, 0.1, 0.0, 0.0]), guard, np.inf)[0] == Found.CROSSING


@pytest.mark.slow
def test_undecided_where_the_steps_run_out():
    """An undamped chain for 1e7 s, of which no bound shows that nothing happens: a status, not an answer."""
    flow = chained("undamped, with a chain")
    assert search(flow, np.zeros(4), np.array([1e-12, 0.0, 0.0, 0.0, 1.0]), 1e7)[0] == Found.UNDECIDED


def test_rounding_is_not_amplified():
    assert block_mode(exact_field(mixed(FIELDS["condition 1e13"]), [1.0] * 4)).condition < 1e3


def test_a_search_ends_where_a_guard_has_died_away_below_the_smallest_number():
    """Without a load the contact force falls to zero for ever; zero over zero then led the walk nowhere."""
    automaton, state = scene("threads", 83, 4, 3, in_blocks=True)
    budget = Budget(10_000.0)
    motion = follow(automaton, state, math.inf, max_events=20, budget=budget)
    assert motion.status == Status.SETTLED
    assert budget.left > 9000.0
