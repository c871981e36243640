"""Systems of one's own: numbers of others, random ones against an integrator of the tests, and what is refused."""

import math
import pickle
import re
from itertools import pairwise

import numpy as np
import pytest
from references.hybrid import drawn
from references.sizes import sizes

from lsvib.errors import EngineError, InputError, LsvibError
from lsvib.systems.assembly import made
from lsvib.systems.attractor import Doubt
from lsvib.systems.continuation import follow_cycle
from lsvib.systems.ends import Label, end_of, start_of
from lsvib.systems.ends import motion as follow
from lsvib.systems.kernels.layout import GRAZE_KIND
from lsvib.systems.system import System

IMPACT = System(
    states=["x", "v"], parameters={"A": 1, "w": 1, "r": "0.8"}, harmonics={"c, s": "w"},
    modes={"fly": {"x": "v", "v": "-x - 0.1*v + A*c"}},
    events=[{"mode": "fly", "when": "x > 1", "reset": {"v": "-r*v"}}],
)  # fmt: skip
BUCK = System(
    states=["v", "i"], clocks={"t": "T"},
    parameters={"E": 24, "R": 22, "L": 20e-3, "C": 47e-6, "Vr": 11.3, "a": 8.4, "low": 3.8, "high": 8.2, "T": 400e-6},
    modes={"on": {"v": "(i - v/R)/C", "i": "(E - v)/L"}, "off": {"v": "(i - v/R)/C", "i": "-v/L"}},
    events=[{"mode": "on", "when": "a*(v - Vr) > low + (high - low)*t/T", "to": "off"},
            {"mode": "off", "when": "a*(v - Vr) < low + (high - low)*t/T", "to": "on"}],
)  # fmt: skip
BOOST = System(
    states=["i", "v"], clocks={"t": "T"},
    parameters={"R": 30, "L": 2e-3, "C": 40e-6, "E": 12, "I": "8/5", "T": 200e-6},
    modes={"on": {"i": "E/L", "v": "-v/(R*C)"}, "off": {"i": "(E - v)/L", "v": "i/C - v/(R*C)"}},
    events=[{"mode": "on", "when": "i > I", "to": "off"}, {"mode": "off", "at_clock": "t", "to": "on"}],
)  # fmt: skip
STOPS = System(
    states=["x", "v"], parameters={"w": "1.5", "f": "0.2"}, harmonics={"c, s": "w"},
    modes={"back": {"x": "v", "v": "-x + f + c"}, "forth": {"x": "v", "v": "-x - f + c"}},
    surfaces=[{"between": ["back", "forth"], "at": "v"}],
)  # fmt: skip


SIGNS = {"m": 1, "p": -1}
TWO = System(
    states=["x", "y"], modes={a + b: {"x": SIGNS[a], "y": SIGNS[b]} for a in "mp" for b in "mp"},
    surfaces=[{"between": [f"m{b}", f"p{b}"], "at": "x"} for b in "mp"]
    + [{"between": [f"{a}m", f"{a}p"], "at": "y"} for a in "mp"],
)  # fmt: skip


def motion(system, mode, state, end):
    return follow(made(system), *start_of(system, mode, state), end)


def relay(plant, h=None):
    """A relay around a plant of three states in companion form, which switches at zero or, with hysteresis, at ±h."""
    modes = {name: {"x": "y", "y": "z", "z": f"{plant} {sign} 1"} for name, sign in (("low", "+"), ("high", "-"))}
    if h is None:
        return System(states=[*"xyz"], modes=modes, surfaces=[{"between": ["low", "high"], "at": "x"}])
    events = [{"mode": "low", "when": f"x > {h}", "to": "high"}, {"mode": "high", "when": f"x < -{h}", "to": "low"}]
    return System(states=["x", "y", "z"], modes=modes, events=events)


def chua(a, b, m0="-8/7", m1="-5/7"):
    slopes = {"left": "m1*x - m0 + m1", "middle": "m0*x", "right": "m1*x + m0 - m1"}
    modes = {name: {"x": f"a*(y - x - ({law}))", "y": "x - y + z", "z": "-b*y"} for name, law in slopes.items()}
    planes = [{"between": ["left", "middle"], "at": "x + 1"}, {"between": ["middle", "right"], "at": "x - 1"}]
    known = {"m0": m0, "m1": m1, "b": b, "a": a}
    return System(states=["x", "y", "z"], parameters=known, modes=modes, surfaces=planes)


SLIP = {"slip": {"x": "v", "v": "1 - x"}, "stick": {"x": "v", "v": 0}}  # friction of rest is larger by 2
BELT = [{"mode": "slip", "when": "v > 1", "to": "stick"}, {"mode": "stick", "when": "x > 3", "to": "slip"}]
TWO_STOPS = IMPACT.replace(
    parameters={"A": 1.2, "w": 0.8, "r": 0.8},
    events=[{"mode": "fly", "when": when, "reset": {"v": "-r*v"}} for when in ("x > 1", "x < -0.7")],
)
CHAIN = System(
    states=["x", "y", "z"],
    modes={name: {"x": "y - x", "y": "z - y", "z": f"{push} - z"} for name, push in (("low", 1), ("high", -1))},
    events=[{"mode": "low", "when": "x > 0.1", "to": "high"}, {"mode": "high", "when": "x < -0.1", "to": "low"}],
)
# Periods and multipliers as twelve lines of mpmath give them: 60 digits, Newton's method on products of matrix
# exponentials and saltation matrices. Beside them what others have published, and a unit of its last digit; the
# imaginary part of the first is ...492.47.
CYCLES = [
    (IMPACT, "fly", {}, 2 * math.pi, [-0.5842953143415295521540 + 0.0056003514924735575538j],
     [-0.584295314342 + 0.005600351491j], 2e-12),
    (BUCK, "on", {"v": 12, "i": 0.5}, 400e-6, [-0.8210864965389831580248 + 0.0707943241247098498883j],
     [-0.82109 + 0.07079j], 1e-5),
    (relay("-3*y - 2*z"), "low", {"x": -1}, 3.661904667254489224350706,
     [0.0703763555674764987180657, 0.0093730999106814032319800], [0.0703763556, 0.0093730999], 1e-10),
    (BOOST, "on", {"v": 20, "i": 0.5}, 200e-6, [-0.9335635970080467589963552, 0.6798955298206398811146634], None, 0),
    (TWO_STOPS, "fly", {"x": 0.1}, 2.5 * math.pi, [-0.3229847753164555864129026 + 0.2871116369058049181757403j],
     None, 0),
    (CHAIN, "low", {}, 4.787671942045406045540762, [0.0259274820187940171866641, 0.0000223080259736672355362], None, 0),
    (relay("-6*x - 11*y - 6*z", "0.1"), "low", {"x": -1}, 5.094919512650618128859605,
     [5.24804613370675115794970e-5, 1.0088573801780403617897e-9], None, 0),
    (chua("15.6", "40"), "middle", {"x": 0.1}, 1.201656071656671064476162,
     [-0.1405666446461662744307569 + 0.1336526438744302318577644j], None, 0),
    (chua("15.6", "35"), "middle", {"x": 0.1}, 2.660991132450868415075182,
     [0.2351092551101772993069321, 0.0045764950321519730928821], None, 0),
    (chua("9", "16"), "middle", {"x": 0.1}, 4.264372587524342176081090,
     [-0.0768460234594411278946521, -0.0026802467746878143114828], None, 0),
    (System(states=["x", "v"], modes=SLIP, events=BELT), "slip", {"x": 3}, math.pi + 2 * math.atan(0.5) + 4, [0],
     None, 0),
]  # fmt: skip


@pytest.mark.parametrize(("system", "mode", "start", "period", "multipliers", "published", "digit"), CYCLES)
def test_cycles_have_periods_and_multipliers_of_others(system, mode, start, period, multipliers, published, digit):
    end = end_of(system, mode, start)
    assert end.label == Label.CYCLE
    assert end.period == pytest.approx(period, rel=1e-14)
    assert end.turns == (1 if made(system).period else 0)
    known = sorted({x for one in multipliers for x in (one, np.conj(one))}, key=lambda x: (-abs(x), -np.imag(x)))
    assert end.multipliers == pytest.approx(known, rel=0, abs=1e-12 * max(map(abs, known)))
    if published:
        assert end.multipliers[: len(published)] == pytest.approx(published, rel=0, abs=digit)


def test_speed_after_the_impact_and_amplitude_under_dry_friction():
    orbit = end_of(IMPACT, "fly").orbit
    speeds = orbit.after[orbit.kind == made(IMPACT).automaton.tables.branch_kind[-1], 1]
    assert speeds.tolist() == pytest.approx([-1.3565863500759056], rel=1e-14)
    amplitude = end_of(STOPS, "back").cycle.amplitude
    assert amplitude == pytest.approx(math.sqrt(44 / 75), rel=1e-14)  # √(V² − f² S²) of Den Hartog
    assert amplitude == pytest.approx(0.765941686205, abs=5e-13)


def test_the_converter_doubles_its_period_and_the_oscillator_grazes():
    cycle = end_of(BUCK, "on", {"v": 12, "i": 0.5}).cycle
    branch = follow_cycle(cycle, lambda E: made(BUCK.replace(E=E)).automaton, "E", 24.0, (24.0, 25.0), 20, None)
    doubling = [change.value for change in branch.changes if change.kind == "stability"]
    assert doubling == pytest.approx([24.51657282856338], abs=1e-9)  # μ = −1, by mpmath; published: 24.51657
    lowest = end_of(IMPACT.replace(A="0.1 - 1e-9"), "fly", {"x": 0.9}), end_of(IMPACT.replace(A="0.101"), "fly")
    assert ["x > 1" in dict(end.cycle.itinerary) for end in lowest] == [False, True]


@pytest.mark.parametrize("wall", ["0", "1"])
@pytest.mark.parametrize("still", ["0", "v"])  # the flows of a mode at rest in two forms
def test_a_ball_comes_to_rest_when_its_bounces_add_up(wall, still):
    ball = System(
        states=["x", "v"], modes={"fly": {"x": "v", "v": -1}, "lie": {"x": still, "v": 0}},
        events=[{"mode": "fly", "when": f"x < {wall}", "reset": {"v": "-0.8*v"}, "beyond": "lie"}],
    )  # fmt: skip
    height = 1.5
    run, speed = motion(ball, "fly", {"x": float(wall) + height}, 100), math.sqrt(2 * height)
    assert run.time[-1] == pytest.approx(speed * (1 + 2 * 0.8 / 0.2), rel=2e-15)
    assert made(ball).automaton.modes[run.end_mode] == "lie"
    assert run.end_state == pytest.approx([float(wall), 0], abs=1e-14)
    end = end_of(ball, "fly", {"x": 3})
    assert (end.label, end.mode) == (Label.EQUILIBRIUM, "lie")
    without = ball.replace(
        events=[{"mode": "fly", "when": f"x < {wall}", "reset": {"v": "-0.8*v"}}], modes={"fly": ball.modes["fly"]}
    )
    with pytest.raises(EngineError, match=r"accumulate at t = .* in mode fly, and the system does not"):
        motion(without, "fly", {"x": 3}, 100)
    lost = end_of(without, "fly", {"x": 3})
    assert (lost.label, lost.doubt) == (Label.UNRESOLVED, Doubt.ACCUMULATION)
    assert "infinitely many events accumulate" in lost.reason


def test_no_ball_falls_through_a_floor_that_it_hardly_leaves():
    """The floor is anywhere, so that the rounding of a place is large beside the flight."""
    random = np.random.default_rng(1)
    for _ in range(30):
        push, share, floor = 10 ** random.uniform(-1, 2), random.uniform(0.01, 0.9), 10 ** random.uniform(-2, 3)
        ball = System(
            states=["x", "v"], modes={"fly": {"x": "v", "v": -push}, "lie": {"x": 0, "v": 0}},
            events=[{"mode": "fly", "when": f"x < {floor}", "reset": {"v": f"-{share}*v"}, "beyond": "lie"}],
        )  # fmt: skip
        for flight in 10 ** random.uniform(-16, 1, 8):
            run = motion(ball, "fly", {"x": floor, "v": flight * push / 2}, 1e3)
            assert run.time[0] == pytest.approx(flight, rel=1e-13, abs=0)
            assert run.time[-1] == pytest.approx(flight / (1 - share), rel=1e-13, abs=made(ball).brief)
            assert (made(ball).automaton.modes[run.end_mode], run.end_state[0]) == ("lie", floor)


def test_two_switches_slide():
    """OpenModelica#12190: from 1/7 s on."""
    modes = {"above": {"x": "2", "y": "-3"}, "below": {"x": "-2", "y": "1.5"}}
    two = System(states=["x", "y"], modes=modes, surfaces=[{"between": ["above", "below"], "at": "x - y"}])
    run = motion(two, "below", {"x": 1.5, "y": 1}, 1)
    assert run.time.tolist() == pytest.approx([1 / 7], rel=1e-15)
    assert run.end_state == pytest.approx([31 / 34, 31 / 34], rel=1e-15)


@pytest.mark.parametrize("numbers", [("-8/7", "-5/7"), (-8 / 7, -5 / 7)])
def test_the_circuit_of_chua_is_one_field_in_three_pieces(numbers):
    """Whose pieces agree on the planes between them, in doubles to rounding, so that nothing slides."""
    circuit = chua("15.6", "40", *numbers)
    assert [*made(circuit).modes] == ["left", "middle", "right"]
    assert end_of(circuit, "middle", {"x": 0.1}).period == pytest.approx(1.201656071656671, rel=1e-14)


def test_ends_without_a_cycle():
    chain = {"low": {"x": "y - x", "y": "z - y", "z": "1 - z"}}
    end = end_of(System(states=[*"xyz"], modes=chain), "low")
    assert (end.label, [*end.state.values()]) == (Label.EQUILIBRIUM, pytest.approx([1, 1, 1]))
    pushes = {name: chain["low"] | {"z": f"{push} - z"} for name, push in (("low", 2), ("high", -1))}
    slides = System(states=[*"xyz"], modes=pushes, surfaces=[{"between": ["low", "high"], "at": "x + z - 1"}])
    end = end_of(slides, "low")  # where a relay holds a chain of equal lags, which is followed in series
    assert (end.label, end.mode) == (Label.EQUILIBRIUM, "low|high")
    assert [*end.state.values()] == pytest.approx([0.5, 0.5, 0.5])
    lags = {f"x{k}": f"x{k + 1} - x{k} + 0.{k}3" if k < 4 else "1/3 - x4" for k in range(5)}
    five = System(states=[*lags], modes={"go": lags}, events=[{"mode": "go", "when": "x0 > 2", "reset": {"x0": 0}}])
    assert end_of(five, "go").state["x0"] == pytest.approx(0.03 + 0.13 + 0.23 + 0.33 + 1 / 3, rel=1e-14)
    drift = System(states=["x", "y"], modes={"go": {"x": "y", "y": "-y"}})
    assert end_of(drift, "go", {"x": 1, "y": 2}).state == pytest.approx({"x": 3, "y": 0})
    assert end_of(drift.replace(modes={"go": {"x": 1, "y": "-y"}}), "go").label == Label.UNBOUNDED
    assert end_of(drift.replace(modes={"go": {"x": "y", "y": "y - x"}}), "go", {"x": 1}).label == Label.UNBOUNDED
    saddle = drift.replace(modes={"go": {"x": "y", "y": "x + 1"}})
    assert [end_of(saddle, "go", {"x": x}).label for x in (1, -1)] == [Label.UNBOUNDED, Label.EQUILIBRIUM]
    fall = System(states=[*"xyz"], modes={"go": {"x": "y", "y": "z", "z": 1}},
                  events=[{"mode": "go", "when": "x < -1", "reset": {"y": "-y"}}])  # fmt: skip
    assert (end_of(fall, "go").label, end_of(fall, "go").doubt) == (Label.UNBOUNDED, None)
    flees = [{"x": "x", "y": "-y"}, {"x": 1, "y": "-y"}, {"x": "0.2*x - 0.1", "y": "x - 2*y"}, {"x": "y", "y": "x"}]
    for own in flees:  # along a guard that grows for ever
        away = drift.replace(modes={"go": own}, events=[{"mode": "go", "when": "x + y/2 < -1", "reset": {"x": 1}}])
        assert end_of(away, "go", {"x": 1}).label == Label.UNBOUNDED
    circle = end_of(drift.replace(modes={"go": {"x": "y", "y": "-4*x"}}), "go", {"x": 1})
    assert (circle.label, circle.period) == (Label.FAMILY, pytest.approx(math.pi))


def test_twelve_states_and_rates_eight_decades_apart():
    names = [f"x{i}" for i in range(12)]
    heat = {name: f"x{max(i - 1, 0)} - 2*{name} + x{i + 1}" if i < 11 else "1 - x11" for i, name in enumerate(names)}
    end = end_of(System(states=names, modes={"warm": heat}), "warm")
    assert end.state == pytest.approx(dict.fromkeys(names, 1.0), rel=1e-9)
    with pytest.raises(InputError, match="at most 12"):
        System(states=[*names, "y"], modes={"warm": heat | {"y": 0}})
    stiff = System(states=["x", "v", "y"], modes={"one": {"x": "v", "v": "-1e16*x - 1e8*v", "y": "-y"}},
                   events=[{"mode": "one", "when": "y < 0.5", "reset": {"y": 1, "x": 1}}])  # fmt: skip
    assert end_of(stiff, "one", {"x": 1, "y": 1}).period == pytest.approx(math.log(2), rel=1e-14)


def compare(seed, end=8.0):
    """Compare a random system with the integrator: events and states to 1e-8, and that its end repeats or stays."""
    known, start = drawn(seed)
    system, n = System(**known.keys()), known.n
    beyond = known.surfaces and known.surfaces[0][2] @ [*start, 1, 0, 1] > 0
    expected, last = known.motion(int(bool(beyond)), start, end)
    given, most = dict(zip(system.states, start.tolist(), strict=True)), len(expected)
    names = made(system).automaton.modes
    try:
        run = motion(system, "m0", given, end)
    except EngineError as error:
        said = re.search("endlessly and without delay|infinitely many events accumulate", str(error))
        return 0 if said and most == 60 else math.nan
    own = np.flatnonzero((run.kind != GRAZE_KIND) & ~run.automaton.marked(run.kind, "passage"))
    # of events at one instant the last counts, as some are taken together
    own = own[np.append(np.diff(run.time[own]) > 1e-10, True)] if own.size else own
    expected = [x for x, y in pairwise([*expected, (math.inf,)]) if y[0] - x[0] > 1e-10]
    for k, (time, state, mode) in zip(own, expected[: -1 if most == 60 else None], strict=False):
        assert run.time[k] == pytest.approx(time, abs=1e-8)
        assert run.after[k, :n] == pytest.approx(state, abs=1e-8 * max(1, np.abs(state).max()))
        assert names[run.mode[k]] == (f"m{mode}" if isinstance(mode, int) else f"m{mode[0]}|m{mode[1]}")
    if most < 60:
        assert len(own) == len(expected)
        assert run.end_state[:n] == pytest.approx(last, abs=1e-8 * max(1, np.abs(last).max()))
    return len(own) + repeats(known, system, given)


def repeats(known, system, given):
    end = end_of(system, "m0", given, 20_000)
    if end.label != Label.CYCLE or end.cycle.leading > 0.99:
        return 0
    orbit = end.orbit
    phase = np.flatnonzero(orbit.automaton.marked(orbit.kind, "passage"))
    k = phase[0] if phase.size else -1
    name = orbit.automaton.modes[orbit.mode[k]]
    pair = tuple(int(x) for x in re.findall(r"\d", name))
    state = orbit.after[k, : known.n]
    _, there = known.motion(pair if len(pair) > 1 else pair[0], state, orbit.end_time + 1e-10, 1000)
    assert there == pytest.approx(state, abs=1e-7 * max(1, np.abs(state).max()))
    return 1


@pytest.mark.parametrize("seeds", sizes([range(20)], [range(20, 40)], [range(k, k + 20) for k in range(40, 300, 20)]))
def test_random_systems_move_as_an_integrator_of_the_tests_says(seeds):
    assert sum(map(compare, seeds)) > len(seeds)


def test_a_system_is_a_value():
    again = System.of(BUCK.keys())
    assert (again, hash(again), pickle.loads(pickle.dumps(BUCK))) == (BUCK, hash(BUCK), BUCK)
    assert BUCK.replace(E=24.0) == BUCK != BUCK.replace(E=25)
    assert eval(repr(BOOST)) == BOOST
    with pytest.raises(InputError, match=r"system\.replace\(states=\.\.\.\) makes another"):
        BUCK.states = ("x",)
    matrix = {"on": {"matrix": np.array([[0, 1], [-1, -0.1]]), "vector": [0, "A*c"]}}
    assert end_of(IMPACT.replace(modes={"fly": matrix["on"]}), "fly").period == end_of(IMPACT, "fly").period
    third = System(states=["x"], parameters={"a": "0.333333333333333333333"}, modes={"go": {"x": "3e18*a - 1e18 - x"}})
    assert end_of(third, "go").state["x"] == pytest.approx(-0.001, rel=1e-9)  # of a double it would be -55
    tenth = System(states=["x"], parameters={"a": "0.1"}, modes={"go": {"x": "10*a - 1 - x"}})
    assert end_of(tenth, "go", {"x": 1}).state == {"x": 0.0}  # of the double 0.1 it would be 5.6e-17


FLY = {"fly": {"x": "v", "v": "-x"}}
BOTH = {"a": {"x": 1}, "b": {"x": -1}}
REFUSED = [
    (dict(modes=FLY, parameters={"x": 1}), "x is used twice, in states and in parameters"),
    (dict(modes=FLY, parameters={"pi": 1}), "'pi' cannot be a name"),
    (dict(modes=FLY, parameters={"a": "b", "b": "a"}), "parameters.a = 'b' depends on itself, by b."),
    (dict(modes=FLY, parameters={"a": "1/(2 - 2)"}), "parameters.a = '1/(2 - 2)' divides by zero."),
    (dict(modes=FLY, parameters={"a": "sqrt(-1)"}), "is not a real number"),
    (dict(modes=FLY, parameters={"a": math.nan}), "nan is neither an expression nor a number"),
    (dict(modes={"fly": {"x": "v", "v": "-x*v"}}), "'-x*v' is not affine in the states; '-x * v' is not."),
    (dict(modes={"fly": {"x": "v", "v": "sin(x)"}}), "in the states; 'sin(x)' is not"),
    (dict(modes={"fly": {"x": "v", "v": "k*x"}}), "has the unknown name k; known are x, v."),
    (dict(modes={"fly": {"x": "v", "v": "x if 1 else v"}}), "which is not allowed; use"),
    (dict(modes={"fly": {"x": "v", "v": "__import__('os')"}}), "which is not allowed; use"),
    (dict(modes={"fly": {"x": "v", "v": "(" * 900 + "x" + ")" * 900}}), "is not an expression"),
    (dict(modes={"fly": {"x": "v", "v": "+".join(["x"] * 900)}}), "is nested too deeply"),
    (dict(modes={"fly": {"x": "v", "v": "-" * 1900 + "x"}}), "is nested too deeply"),
    (dict(states=[], modes=FLY), "a system needs one state and one mode at least."),
    (dict(modes=FLY, events=[{"mode": [], "when": "x > 1", "reset": {"v": 0}}]), "events[0] names the mode None"),
    (dict(modes={"fly": {"x": "v", "v": "1e200*x"}}), "has a coefficient that is not a number below"),
    (dict(modes={"fly": {"x": "v"}}), "modes.fly needs v."),
    (dict(modes=FLY, events=[{"mode": "fly", "when": "1 > 0", "reset": {"v": 0}}]), "so it cannot be an event"),
    (dict(modes=FLY, events=[{"mode": "fly", "when": "x > 1"}]), "changes nothing: give a reset, or a mode to enter"),
    (dict(modes=FLY, events=[{"mode": "fly", "when": "x > 1", "reset": {"x": "x + 1"}}]), "happens again where"),
    (dict(modes=FLY, events=[{"mode": "fly", "when": "x", "to": "fly"}]), "is not a condition, such as x > 1"),
    (dict(modes=FLY, events=[{"mode": "fall", "when": "x > 1"}]), "names the mode 'fall'; modes are fly."),
    (dict(modes=FLY, events=[{"mode": "fly", "at_clock": "t", "to": "fly"}]), "is not a clock; clocks are none."),
    (dict(modes=FLY, events=[{"mode": "fly", "when": w, "reset": {"v": 0}} for w in ("x > 1", "2*x > 2")]), "at once"),
    (dict(modes=FLY | {"lie": {"x": 0, "v": 0}}), "modes.fly is linked with no other mode"),
    (dict(modes=FLY, harmonics={"c, s": "-1"}), "is not positive"),
]  # fmt: skip


@pytest.mark.parametrize(("keys", "sentence"), REFUSED)
def test_what_is_no_system_is_refused_in_one_sentence(keys, sentence):
    with pytest.raises(InputError, match=re.escape(sentence)) as caught:
        System(**{"states": ["x", "v"]} | keys)
    assert "\n" not in str(caught.value)


def test_motions_without_an_answer_end_in_one_sentence():
    loop = [{"mode": "a", "when": "x > 1", "to": "b"}, {"mode": "b", "when": "x > 0", "to": "a"}]
    cases = [
        (System(states=["x"], modes=BOTH, events=loop), "a", {}, r"follow each other at t = 1 s endlessly"),
        (System(states=["x", "y"], modes={"a": {"x": 1, "y": "y"}, "b": {"x": "-1 - y", "y": 0}},
                surfaces=[{"between": ["a", "b"], "at": "x"}]), "a", {"x": -1}, r"would slide along x at t = 1 s, but"),
        (System(states=["x"], modes=BOTH, surfaces=[{"between": ["b", "a"], "at": "x"}]), "a", {}, "on both sides"),
        (TWO, "mm", {"x": -0.5, "y": -1}, r"from mode mm\|pm meets two surfaces at once at t = 1 s"),
        (STOPS, "away", {}, "'away' is not a mode"), (STOPS, "back", {"c": 1}, "unknown name 'c'; known are x, v"),
        (STOPS, "back", {"x": math.inf}, "x = inf is outside"),
    ]  # fmt: skip
    for system, mode, start, sentence in cases:
        with pytest.raises(LsvibError, match=sentence):
            motion(system, mode, start, 10)
    two = STOPS.replace(harmonics={"c, s": "w", "d, e": "sqrt(2)"})
    assert np.isfinite(motion(two, "back", {}, 10).end_state).all()
    with pytest.raises(InputError, match="is a multiple of all others"):
        end_of(two, "back")
    again = STOPS.replace(harmonics={"c, s": "2", "d, e": "3"}, clocks={"t": "2*pi"})
    assert end_of(again, "back").period == pytest.approx(2 * math.pi)
