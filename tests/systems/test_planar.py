"""One mode against mpmath, with every kind of characteristic roots: its flow, and the first root of a guard.

Tolerance of the flow: ``4 eps (1 + rate t)`` of the natural magnitude; the largest error seen was 1.4 of these units.
The natural magnitude of u is |u| + |w| T + f min(t, T)², that of w is |w| + f min(t, T), f = |b| + |a₀ u|, both times
the growth of the mode, where T = 1/√|a₀| (or t without stiffness) is its time scale: sizes of the terms that the state
is summed from. An equilibrium up to 16 times as far away as the state is one of these terms, too: u is then its
distance from it; from farther on the flow does without it. The factor 1 + rate t is the rounding of the argument of
sine, cosine and exponential.

Tolerance of a root: rounding of the guard's terms over the slope of the guard there, ``32 eps``, and 4 eps of the time.
"""

import math
from decimal import Decimal, localcontext

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from lsvib.errors import AccumulationError
from lsvib.systems.automaton import Branch, Guard, Mode, Surface, Transition, assemble
from lsvib.systems.exact.modal_form import PlanarMode
from lsvib.systems.kernels import flow_planar, layout, search_planar
from lsvib.systems.kernels.layout import Found, Status
from lsvib.systems.kernels.layout import Test as Sign
from lsvib.systems.motion import follow

EPS = float(np.finfo(float).eps)
STARTS = [(1.0, 0.0), (0.0, 1.0), (1.0, -2.0), (-0.3, 5.0), (1e-3, 1e-3), (0.0, 0.0)]


def number(x):
    """An int, float, string or Decimal as an mpmath number, exactly."""
    return mpf(x) if isinstance(x, (int, float)) else mpf(str(x))


def flow(inertia, damping, stiffness, force, u, w, t):
    """Return (u, w) at time t of  inertia·u″ + damping·u′ + stiffness·u = force, by the exponential of its matrix."""
    with mp.workdps(60):
        inertia, damping, stiffness, force, u, w, t = map(number, (inertia, damping, stiffness, force, u, w, t))
        rows = [[0, 1, 0], [-stiffness / inertia, -damping / inertia, force / inertia], [0, 0, 0]]
        return tuple(mp.expm(mp.matrix(rows) * t) * mp.matrix([u, w, 1]))[:2]


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


ANGLES = [1e-6, 1e-3, 0.1, 1.0, 3.0, 10.0, 40.0]  # rate · t


def growth(row, t) -> float:
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
    row = PlanarMode.of(*CASES[name]).row
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
    row = PlanarMode.of(inertia, damping, stiffness, force).row
    t = angle / rate_of(row)
    assume(1e-100 < t < 1e100)
    assert error(row, (inertia, damping, stiffness, force), (u, w), t) <= 4.0


@settings(max_examples=300)
@given(
    st.sampled_from(sorted(CASES)), st.sampled_from(STARTS), st.floats(0.0, 30.0), st.floats(-1, 1), st.floats(-1, 1)
)
def test_extremes_against_dense_evaluation(name, state, angle, part_u, part_w):
    row = PlanarMode.of(*CASES[name]).row
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
    row = PlanarMode.of(*coefficients).row
    state = np.array([row[layout.EQUILIBRIUM] + 1e-9, 0.0])
    rate = -row[layout.ALPHA] if row[layout.BETA] > 0 else row[layout.R1]
    stay = math.log(1e6) / rate
    scale = np.zeros(2)
    flow_planar.magnitudes(np.array([row]), 0, state, stay, scale)
    size = 1e-9 * 1e6 * max(1.0, rate)
    assert 1e-3 * 0.99 <= scale[0] - abs(row[layout.EQUILIBRIUM]) <= 4 * size
    assert 1e-3 * 0.99 <= scale[1] <= 4 * size


INF = math.inf


def search(row, state, guard, on_surface=False, limit=INF):
    found, t = search_planar.crossing(
        np.array([row]), 0, np.array(state, float), np.array(guard, float), on_surface, limit
    )
    return Found(found), t


def value(coefficients, state, guard, t):
    u, w = flow(*coefficients, *state, t)
    return guard[0] * u + guard[1] * w + mpf(guard[2])


@settings(max_examples=600)
@given(
    st.sampled_from(sorted(CASES)), st.sampled_from(STARTS), st.floats(-1, 1), st.floats(-1, 1), st.floats(1e-3, 2),
    st.floats(0.5, 30),
)  # fmt: skip
def test_first_root_against_mpmath(name, state, part_u, part_w, level, angle):
    """The guard is positive on a dense grid up to the time found, and has a root there; or positive all the way."""
    row = PlanarMode.of(*CASES[name]).row
    limit = angle / rate_of(row)
    guard = (part_u, part_w / rate_of(row), level - part_u * state[0] - part_w / rate_of(row) * state[1])
    assume(abs(part_u) + abs(part_w) > 1e-2)
    found, t = search(row, state, guard, limit=limit)
    times = np.linspace(0, t, 300)[:-1]
    points = np.array([advanced(row, state, time) for time in times])
    assert np.isfinite(points).all()
    values = points @ guard[:2] + guard[2]
    terms = np.abs(points[-1]) @ np.abs(guard[:2]) + abs(guard[2]) + abs(row[layout.EQUILIBRIUM] * part_u)
    rounding = 32 * EPS * (1 + angle) * max(terms, np.abs(values).max())
    assert values.min() >= -rounding
    if found == Found.CROSSING:
        step = (abs(t) + 1 / rate_of(row)) * 1e-9
        ahead, behind = (value(CASES[name], state, guard, t + way * step) for way in (1, -1))
        slope = float(ahead - behind) / (2 * step)
        residual = abs(float(value(CASES[name], state, guard, t)))
        assert residual <= rounding + 4 * EPS * t * abs(slope) + abs(slope) * step * 1e-6
    elif found == Found.NONE:
        assert t == limit


# A mode as in the drive, 300 rad/s, with a guard that the orbit of amplitude 1 passes at u = −1 + depth.
BETA = 300.0
CIRCLE = ("1", "0", str(BETA**2), "0")


@pytest.mark.parametrize(
    "name", ["underdamped", "the chapter's drive", "overdamped", "critically damped", "stiff", "zero damping, no force"]
)
def test_grazing_level_constructed_in_mpmath(name):
    """The level of the guard is minus the minimum of u along the orbit, found with 40 digits and rounded once."""
    coefficients, row = CASES[name], PlanarMode.of(*CASES[name]).row
    equilibrium = float(row[layout.EQUILIBRIUM])
    state = (equilibrium, -1.0)  # leaves the equilibrium downwards and turns once, whatever the damping
    with mp.workdps(40):
        guess = math.atan2(row[layout.BETA], row[layout.ALPHA]) / row[layout.BETA] if row[layout.BETA] > 0 else None
        if guess is None:
            slow, fast = float(-row[layout.R1]), float(-row[layout.R2])
            guess = math.log(fast / slow) / (fast - slow) if fast > slow else 1 / slow
        bottom = mp.findroot(lambda t: flow(*coefficients, *state, t)[1], (guess, guess * (1 + 1e-9)))
        level = float(-flow(*coefficients, *state, bottom)[0])
    found, t = search(row, state, (1.0, 0.0, level))
    assert found == Found.GRAZE
    # Where the guard is flat its minimum is known from the zero of its slope, to the rounding of the rates.
    assert t == pytest.approx(float(bottom), rel=16 * EPS)
    # 1e-12 of the swing to either side and it is a crossing, or none.
    swing = abs(level + equilibrium)
    assert search(row, state, (1.0, 0.0, level - 1e-12 * swing - 32 * EPS * abs(level)))[0] == Found.CROSSING
    assert search(row, state, (1.0, 0.0, level + 1e-12 * swing + 32 * EPS * abs(level)))[0] == Found.NONE


def test_parabola_touches_and_crosses():
    row = PlanarMode.of(1, 0, 0, 2).row  # u = (t − 1)² + u₀ − 1
    assert search(row, (1.0, -2.0), (1.0, 0.0, 0.0)) == (Found.GRAZE, 1.0)
    assert search(row, (1.0, -2.0), (1.0, 0.0, 1e-9)) == (Found.NONE, INF)
    found, t = search(row, (1.0, -2.0), (1.0, 0.0, -0.25))
    assert (found, t) == (Found.CROSSING, 0.5)
    assert search(row, (1.0, -2.0), (1.0, 0.0, -0.25), limit=0.49) == (Found.NONE, 0.49)


@pytest.mark.parametrize("turns", [0, 3])
def test_two_crossings_100_nanoseconds_apart(turns):
    """The dip is 1.1e-10 of the orbit deep and 1e-7 s of its 21 ms period long."""
    depth = 1 - math.cos(BETA * 0.5e-7)
    row = PlanarMode.of(*CIRCLE).row
    start = (math.cos(2.0), BETA * math.sin(-2.0) * -1.0)
    found, first = search(row, start, (1.0, 0.0, 1.0 - depth), limit=INF if turns == 0 else 1.0)
    assert found == Found.CROSSING
    bottom = advanced(row, start, first)
    again, later = search(row, bottom, (-1.0, 0.0, -(1.0 - depth)), on_surface=True)
    assert again == Found.CROSSING
    # The level is rounded to eps = 2e-16, which moves the ends of the dip by eps/(β² 0.5e-7 s) = 5e-14 s; a state
    # of that size, too, so that a few times 1e-13 s are sure.
    assert later == pytest.approx(1e-7, abs=5e-13)


@pytest.mark.parametrize("name", sorted(CASES))
def test_guard_that_starts_at_zero_does_not_fire_again(name):
    """On the surface, and rising: the next root is the one after the maximum, never the one at the start."""
    row = PlanarMode.of(*CASES[name]).row
    for state in ((0.0, 1.0), (0.0, 1e-9), (0.3, 2.0)):
        found, t = search(row, state, (1.0, 0.0, -state[0]), on_surface=True, limit=50 / rate_of(row))
        if found == Found.CROSSING:
            assert advanced(row, state, 0.5 * t)[0] > state[0]
            assert advanced(row, state, t * (1 - 1e-6))[1] <= 0 or t < 1e-6 / rate_of(row)


def bouncer(stiffness, force, restitution, beyond=None):
    """A point that falls (or hangs on a spring) onto a floor at u = 0; beyond an accumulation it may rest there."""
    flight = Mode(0, PlanarMode.of(1, 0, stiffness, force), (Guard("floor", 1, "bounce"),), beyond)
    modes = {"flight": flight, "rest": Mode(1, PlanarMode.of(1, 0, 0, 0), ())}
    transitions = {
        "entry": Transition((Branch("flight", 2),)),
        "bounce": Transition((Branch("flight", 2, (((0, 1, 0), Sign.POSITIVE),)), Branch("rest", 3)),
                             reset=((1, 0, 0), (0, -restitution, 0))),
    }  # fmt: skip
    return assemble(("u", "w"), {"floor": Surface((1, 0, 0), 0)}, modes, transitions, {}, 1e-13)


@pytest.mark.parametrize(("stiffness", "force"), [(0, -2.0), (4.0, 0.0), (4.0, -1.0), (4.0, 0.5)])
def test_a_thousand_bounces_none_twice_none_missed(stiffness, force):
    """Every bounce starts on the floor; the stays are equal, so a second firing or a missed one would show."""
    motion = follow(bouncer(stiffness, force, 1.0), (0.0, 1.0), INF, max_events=1000)
    assert motion.status == Status.EVENTS_FULL
    assert set(motion.kind) == {2}
    stay = 1.0 if stiffness == 0 else math.pi / 2 - math.atan2(force / 2, 1.0) * -1.0
    # Rounding of speed and stay adds up over 1000 bounces at most in proportion to their number.
    np.testing.assert_allclose(np.diff(motion.time), stay, rtol=1000 * 4 * EPS)


def test_infinitely_many_bounces_in_finite_time():
    """With restitution ½ all bounces are over after 1 + ½ + ¼ + … = 2 times the first stay of 1 s."""
    motion = follow(bouncer(0, -2.0, 0.5, "rest"), (0.0, 1.0), 3.0)
    assert motion.time[-1] == pytest.approx(2.0, abs=1e-12)
    assert motion.status == Status.TIME_REACHED
    assert (motion.end_mode, motion.kind[-1]) == (1, 1)
    assert abs(motion.end_state[0]) <= 1e-15
    endless = bouncer(0, -2.0, 0.5)
    with pytest.raises(AccumulationError, match="at t = 2 s"):
        follow(endless, (0.0, 1.0), 3.0)
    assert follow(endless, (0.0, 1.0), 3.0, max_events=motion.time.size - 1).time[-1] == pytest.approx(2.0, abs=1e-12)


@pytest.mark.parametrize("turns", [1, 10, 1000, 100_000])
def test_growing_oscillation_crosses_after_many_turns(turns):
    """u = e^{at} cos-like, growing by e² over the turns: the first minimum that is deep enough is found at once."""
    growth = 2.0 / (2 * math.pi * turns)
    coefficients = (1.0, -2 * growth, 1.0, 0.0)
    row = PlanarMode.of(*coefficients).row
    guard = (1.0, 0.0, 5.0)
    found, t = search(row, (1.0, 0.0), guard)
    assert found == Found.CROSSING
    assert math.log(5) / growth - 2 * math.pi <= t <= math.log(5) / growth + 2 * math.pi
    with mp.workdps(40):
        root = mp.findroot(lambda x: value(coefficients, (1.0, 0.0), guard, x), (t, t + 1e-6))
        assert abs(float(root - mpf(t))) <= 1e-4  # the same root, not a neighbour
        # The guard falls there at a rate that vanishes for the shallowest of dips: compare residuals, not times.
        assert abs(float(value(coefficients, (1.0, 0.0), guard, t))) <= 64 * EPS * (1 + t)
        # One minimum before, the guard was still positive.
        before = value(coefficients, (1.0, 0.0), guard, root - 2 * mp.pi)
        assert before > 0
    times = t - np.linspace(2 * math.pi, 1e-3, 500)
    assert min(float(advanced(row, (1.0, 0.0), max(x, 0.0))[0]) for x in times) > -5.0


@pytest.mark.parametrize("turns", [1, 3])
@pytest.mark.parametrize("miss", [-1e-9, -1e-12, 1e-12, 2e-10, 1e-9, 1e-6])
def test_growing_oscillation_that_just_misses_or_meets_its_nth_minimum(turns, miss):
    """A minimum that is missed by more than rounding is not the last: the oscillation grows and falls in the next."""
    coefficients = ("1", "-0.2", "1", "0")
    row, state = PlanarMode.of(*coefficients).row, (1.0, 0.0)
    half_turn = math.pi / row[layout.BETA]  # u has extrema at whole numbers of it
    lowest = float(flow(*coefficients, *state, mpf((2 * turns + 1) * half_turn))[0])
    guard = (1.0, 0.0, -lowest * (1.0 + miss))
    found, t = search(row, state, guard)
    assert found == Found.CROSSING
    nth = turns if miss < 0 else turns + 1
    assert 2 * nth * half_turn < t < (2 * nth + 1) * half_turn
    slope = float(flow(*coefficients, *state, mpf(t))[1])
    assert abs(float(value(coefficients, state, guard, t))) <= 64 * EPS * abs(lowest) + 4 * EPS * t * abs(slope)


def test_growth_beyond_the_largest_number_is_no_graze():
    """Half a turn multiplies the oscillation by e^1571, but it falls through the guard long before."""
    coefficients = ("1", "-1000", "250001", "0")
    guard = (1.0, 0.0, 2.0)
    found, t = search(PlanarMode.of(*coefficients).row, (1.0, 0.0), guard)
    assert found == Found.CROSSING
    slope = float(flow(*coefficients, 1.0, 0.0, mpf(t))[1])
    assert abs(float(value(coefficients, (1.0, 0.0), guard, t))) <= 64 * EPS + 4 * EPS * t * abs(slope)
