"""What can be asked of a system of one's own: datasets, their files and pictures, branches, and the shell."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from references.figure_checks import without_room

import lsvib
from lsvib.answers.io import read_dataset, write_dataset
from lsvib.errors import EngineError, InputError
from lsvib.systems import Label, System
from lsvib.systems.assembly import made
from lsvib.systems.ends import motion, start_of
from lsvib.variables import flag_names

KEYS = {
    "states": ["x", "v"], "parameters": {"A": "1.6", "w": "0.8", "r": "0.8"}, "harmonics": {"c, s": "w"},
    "modes": {"fly": {"x": "v", "v": "-x - 0.1*v + A*c"}},
    "events": [{"mode": "fly", "when": "x > 1", "reset": {"v": "-r*v"}},
               {"mode": "fly", "when": "x < -0.7", "reset": {"v": "-r*v"}}],
}  # fmt: skip
STOPS = System(**KEYS)
ONE = STOPS.replace(events=KEYS["events"][:1], A=1, w=1)
HOP = System(
    states=["x", "v"], parameters={"g": 1}, modes={"fly": {"x": "v", "v": "-g"}, "lie": {"x": 0, "v": 0}},
    events=[{"mode": "fly", "when": "x < 0", "reset": {"v": "-v/2"}, "beyond": "lie"}],
)  # fmt: skip
DRY = System(
    states=["x", "v"], parameters={"w": "0.9", "f": "0.2"}, harmonics={"c, s": "w"},
    modes={"back": {"x": "v", "v": "-x + f + c"}, "forth": {"x": "v", "v": "-x - f + c"}},
    surfaces=[{"between": ["back", "forth"], "at": "v"}],
)  # fmt: skip


FORCES = {f"{at}_{to}": f"-x - d*v {stop} {sign} f + A*c" for at, stop in (("free", ""), ("stop", "- 24*(x - gap)"))
          for to, sign in (("back", "+"), ("forth", "-"))}  # fmt: skip
GAP = System(
    ["x", "v"], {name: {"x": "v", "v": force} for name, force in FORCES.items()}, harmonics={"c, s": "w"},
    parameters={"A": "0.2368", "w": "0.8", "gap": "0.5", "f": "0.1", "d": "0.1"},
    surfaces=[{"between": [f"{at}_back", f"{at}_forth"], "at": "v"} for at in ("free", "stop")]
    + [{"between": [f"free_{to}", f"stop_{to}"], "at": "x - gap"} for to in ("back", "forth")],
)  # fmt: skip


def test_a_motion_is_a_dataset():
    found, run = (
        STOPS.simulate("fly", {"x": 0.1}, 20, samples=101),
        motion(made(STOPS), *start_of(STOPS, "fly", {"x": 0.1}), 20),
    )
    assert np.array_equal(found.x, run.at(found.time)[0][:, 0])
    assert np.array_equal(found.event_v_after, run.after[:, 1])
    kinds = flag_names(found.event_kind)
    assert {kinds[int(k)] for k in found.event_kind} == {"x > 1", "x < -0.7", "phase 0"}
    assert found.c.values == pytest.approx(np.cos(0.8 * found.time), abs=1e-14)
    assert System.of(json.loads(found.system)) == STOPS
    rests = HOP.simulate("fly", {"x": 2}, 10)
    assert flag_names(rests["mode"])[int(rests["mode"][-1])] == "lie"
    assert float(rests.event_time[-1]) == pytest.approx(6, rel=1e-14)  # 2 (1 + 2 (1/2 + 1/4 + ...))


def test_ends_of_starts_are_found_once_each():
    found = STOPS.cycles([("fly", {})], box={"x": (-0.5, 0.5), "v": (-1, 1)}, count=9, seed=3)
    assert sum(end.starts for end in found) == 10
    assert sorted(end.turns for end in found if end.cycle) == [1, 2]
    again = STOPS.cycles([("fly", {})], box={"x": (-0.5, 0.5), "v": (-1, 1)}, count=9, seed=3)
    assert [(end.starts, end.to_json()) for end in found] == [(end.starts, end.to_json()) for end in again]
    assert any("period 7.853981633974" in line for line in found[0].text())
    ends = HOP.cycles([("fly", {"x": 1}), ("lie", {"x": 3})])
    assert [(end.label, end.starts) for end in ends] == [(Label.EQUILIBRIUM, 2)]  # rests side by side are one


def test_a_change_has_one_name_from_either_side_and_a_branch_goes_on_from_a_point():
    """A motion touches a stop at the instant at which friction turns: two events become four."""
    up = GAP.follow(GAP.steady_state("free_forth"), "A", (0.2368, 0.23686))
    last = up.points[-1]
    down = GAP.replace(A=last.value).follow(last.cycle, "A", (0.2368, 0.23686))
    found = [[(x.name, round(x.value, 9)) for x in branch.changes if x.name] for branch in (up, down)]
    assert found == [[("grazing", 0.236837203)]] * 2


@pytest.mark.slow
def test_branches_name_what_happens_to_a_cycle():
    one = ONE.replace(A=0.11)
    branch = one.follow(one.steady_state("fly"), "A", (0.09, 0.12))
    assert [change.name for change in branch.changes if change.name] == ["grazing", "grazing", "fold"]
    assert branch.changes[1].value == pytest.approx(0.1, abs=1e-8)
    dry = DRY.replace(f="0.6", w="0.6")
    stops = dry.follow(dry.steady_state("back"), "w", (0.58, 0.66)).changes
    assert [(x.name, round(x.value, 6)) for x in stops if x.name] == [("crossing-sliding", 0.632971)]
    long = DRY.replace(f="0.5", w="0.185")
    stops = long.follow(long.steady_state("back"), "w", (0.178, 0.19)).changes
    assert [(x.name, round(x.value, 8)) for x in stops if x.name] == [("adding-sliding", 0.18047293)]
    gap = GAP.replace(A="0.8", w="0.835")
    slides = gap.follow(gap.steady_state("free_forth"), "w", (0.835, 0.848)).changes
    assert [x.name for x in slides if x.name] == ["switching-sliding", "grazing-sliding"]
    push = {mode: {"x": "v", "v": f"-x - 0.4*v {sign} 1"} for mode, sign in (("push", "+"), ("pull", "-"))}
    events = [{"mode": "push", "when": "t > T/2", "to": "pull"}, {"mode": "pull", "at_clock": "t", "to": "push"}]
    events += [{"mode": [*push], "when": "x > 0.8", "reset": {"v": "-v/2"}}]
    struck = System(["x", "v"], push, {"T": 4}, clocks={"t": "T"}, events=events)
    met = struck.follow(struck.steady_state("push"), "T", (3.9, 4)).changes  # an impact as the force turns
    assert [(x.name, round(x.value, 8)) for x in met if x.name] == [("border collision", 3.92786699)]
    events = [{"mode": "slip", "when": "v > V", "to": "stick"}, {"mode": "stick", "when": "x + V/50 > 1", "to": "slip"}]
    modes = {"slip": {"x": "v", "v": "-x - v/50"}, "stick": {"x": "V", "v": 0}}
    block = System(["x", "v"], modes, {"V": "2.73"}, events=events)
    slows = block.follow(block.steady_state("stick", {"v": 2.73}), "V", (2.72, 2.75)).changes
    assert [(x.name, round(x.value, 9)) for x in slows if x.name] == [("grazing", 2.739240417)]
    free = branch.points[0].cycle.multipliers
    assert free.size == 2


def test_a_pair_of_multipliers_leaves_the_circle_where_damping_does_what_impacts_undo():
    """One impact in a period T of x″ − c x′ + x = cos w t: the pair's product is r² exp(c T), 1 at −w ln r / π."""
    events = [{"mode": "fly", "when": "x > 0.5", "reset": {"v": "-r*v"}}]
    pushed = ONE.replace(modes={"fly": {"x": "v", "v": "-x + A*v + c"}}, events=events, A="0.1", w="1.5")
    changes = pushed.follow(pushed.steady_state("fly", {"x": 0.1}), "A", (0.1, 0.11)).changes
    assert [change.name for change in changes if change.kind != "end"] == ["Neimark–Sacker"]
    assert changes[1].value == pytest.approx(-1.5 * math.log(0.8) / math.pi, abs=1e-10)


def test_values_of_parameters_and_starts_are_mapped():
    found = STOPS.sweep("fly", {"x": 0.1}, A=[0.5, 1.2, 1.6], w=[0.8])
    one = STOPS.replace(A=1.2).steady_state("fly", {"x": 0.1})
    here = found.isel(A=1, w=0)
    assert (float(here.period), float(here.turns)) == (one.period, one.turns)
    assert float(here.multiplier) == pytest.approx(abs(one.multipliers[0]), rel=1e-12)
    assert (float(here.least_x), float(here.largest_x)) == pytest.approx((-0.7, 1))
    assert here.events.sum() == len(one.cycle.itinerary) - 1  # without the forcing's clock
    cells = STOPS.map({"x": (-0.5, 0.9, 6), "v": (-1, 1, 5)})
    assert float(cells.fraction.sum()) == pytest.approx(1)
    for i, j in ((0, 0), (4, 3), (2, 5)):
        end = STOPS.steady_state("fly", {"x": float(cells.x[j]), "v": float(cells.v[i])})
        assert float(cells.period[cells.behaviour.values[i, j]]) == pytest.approx(end.period)


def stops(w, f, periods=3):
    """Stops in a period of x″ + x + f sgn x′ = cos w t, from its solution by hand, with a scan for the zeros of x′."""
    t, x, found, end = 0.0, 0.0, [], periods * math.tau / w
    while t < end:
        way = math.copysign(1.0, math.cos(w * t) - x)
        if abs(math.cos(w * t) - x) <= f * (1 + 1e-13):  # it stands until the force is f beyond the spring's
            found.append(t)
            turns = round(t * w / math.tau)
            angles = ((k * math.tau + s * math.acos(x + way * f), way) for k in range(turns - 2, turns + 3)
                      for way in (1, -1) if abs(x + way * f) <= 1 for s in (1, -1))  # fmt: skip
            later = [(angle / w, way) for angle, way in angles if angle > w * t + 1e-9 and way * math.sin(angle) < 0]
            t, way = min(later)
        gain = 1 / (1 - w * w)
        c, d = x - gain * math.cos(w * t) + way * f, w * gain * math.sin(w * t)
        times = np.linspace(1e-3, 7 + math.pi / w, 1500)
        for _ in range(5):  # each scan a thousandfold finer
            speeds = -w * gain * np.sin(w * (t + times)) - c * np.sin(times) + d * np.cos(times)
            k = int(np.argmax(way * speeds < 0))
            times = np.linspace(times[k - 1], times[k], 1500)
        u = times[-1]
        t, x = t + u, gain * math.cos(w * (t + u)) - way * f + c * math.cos(u) + d * math.sin(u)
    return sum(1 for time in found if end - math.tau / w <= time + 1e-6 < end)


def test_a_chart_counts_the_stops_under_dry_friction():
    """0 to 14 in a cycle, as Hong and Liu (J. Sound Vib. 229:1171) have it."""
    rates, frictions = [1 / k for k in (1.5, 3, 9, 11, 15, 19, 23, 27)], [0.2, 0.35, 0.5, 0.65, 0.8]
    found = DRY.sweep("back", w=rates, f=frictions)
    kind = found.kind.flag_meanings.split().index("slides_along_v")
    counts = found.events[..., kind].values
    assert counts[:, 2].tolist() == [*range(0, 16, 2)]
    assert counts.tolist() == [[stops(w, f) for f in frictions] for w in rates]


def test_a_map_misses_no_end():
    """Of which the second has a twentieth of the cells."""
    pushes = {"p": "1 - x - v/3", "m": "-1 - x - v/3"}
    events = [{"mode": "p", "when": "x < 0", "to": "m"}, {"mode": "m", "when": "x > 0", "to": "p"}]
    own = System(["x", "v"], {mode: {"x": "v", "v": push} for mode, push in pushes.items()}, events=events)
    found = own.map({"x": (-2.2, -0.3, 19), "v": (-0.7, 1.3, 20)}, mode="m")
    assert found.end_x.values == pytest.approx([-1, 1])
    for i, j in ((19, 18), (19, 10), (12, 18), (0, 0)):
        end = own.steady_state("m", {"x": float(found.x[j]), "v": float(found.v[i])})
        assert float(found.end_x[found.behaviour.values[i, j]]) == pytest.approx(end.state["x"])


@pytest.mark.parametrize("kind", ["motion", "sweep", "chart", "map", "branch", "cycles"])
def test_each_answer_is_drawn_and_what_is_a_dataset_also_from_its_file(kind, tmp_path):
    answer = {
        "motion": lambda: STOPS.simulate("fly", {}, 9),
        "sweep": lambda: STOPS.sweep(A=[0.5, 1.0]),
        "chart": lambda: HOP.sweep("fly", {"x": 1}, g=[1, 2]),
        "map": lambda: STOPS.map({"x": (-0.5, 0.9, 3), "v": (-1, 1, 3)}),
        "branch": lambda: ONE.follow(ONE.steady_state("fly"), "A", (0.9, 1.1)),
        "cycles": lambda: STOPS.cycles([("fly", {})]),
    }[kind]()
    assert without_room(lsvib.draw(answer)) == []
    if kind in ("motion", "sweep", "chart", "map"):
        write_dataset(answer, tmp_path / "answer.nc")
        assert lsvib.draw(tmp_path / "answer.nc").axes


REFUSED = [
    (lambda: STOPS.simulate("fly", {}, -1), "duration = -1 is negative."),
    (lambda: STOPS.simulate("fly", [1, 2], 1), "state = [1, 2] is not a set of names and values."),
    (lambda: STOPS.simulate("fall", {}, 1), "'fall' is not a mode of the system; its modes are fly."),
    (lambda: STOPS.cycles(), "give starts, as"),
    (lambda: STOPS.cycles(box={"x": 1}), "starts = () are not pairs of mode and state, or box = {'x': 1} has"),
    (lambda: STOPS.cycles([3]), "starts = [3] are not pairs of mode and state"),
    (lambda: STOPS.cycles(box={"x": (1, 0)}), "axis x has start = 1 and stop = 0; it needs start < stop."),
    (lambda: STOPS.cycles(box={"x": (0, 1)}, seed=-1), "seed = -1 is outside"),
    (lambda: STOPS.steady_state(["fly"]), "['fly'] is not a mode of the system"),
    (lambda: STOPS.replace(w=-1), "harmonics = w of c and s is not positive."),
    (lambda: System(["x"], {"go": {"x": "x"}}).simulate("go", {"x": 1}, 1e5), "the motion grows without bound"),
    (lambda: STOPS.sweep(B=[1]), "'B' is not a parameter of the system; its parameters are A, w, r."),
    (lambda: STOPS.sweep(A=1), "over: A = 1 is not a list of numbers."),
    (lambda: STOPS.follow(HOP.steady_state("lie"), "A", (1, 2)), "follow takes one cycle"),
    (lambda: STOPS.follow(ONE.steady_state("fly"), "A", (1, 2)), "the cycle belongs to another system"),
    (lambda: ONE.follow(ONE.steady_state("fly"), "A", (2, 3)), "span = 2, 3 must ascend and contain the"),
    (lambda: ONE.follow(ONE.steady_state("fly"), "A", (2, 1)), "span = 2, 1 must ascend"),
    (lambda: STOPS.steady_state("fly").extremes("y"), "'y' is not a state of the system; its states are x, v"),
    (lambda: STOPS.simulate("fly", [0, 1], 1), "state = [0, 1] is not a set of names and values."),
    (lambda: HOP.map({"x": (0, 1, 5), "v": (0, 1, 5)}, mode=["fly"]), "['fly'] is not a mode of the system"),
    (lambda: STOPS.map({"x": (0, 1, 5)}), "grid needs start, stop and count of two coordinates; 1 given."),
    (lambda: System(["mode"], {"go": {"mode": 1}}).simulate("go", {}, 1), "mode is reserved in this result"),
]  # fmt: skip


@pytest.mark.parametrize(("ask", "sentence"), REFUSED)
def test_what_cannot_be_asked_is_refused_in_one_sentence(ask, sentence):
    with pytest.raises((InputError, EngineError)) as caught:
        ask()
    assert str(caught.value).startswith(sentence)
    assert "\n" not in str(caught.value)


FILE = """
states: [v, i]
parameters: {E: 24, R: 22, L: 20e-3, C: 47e-6, Vr: 11.3, a: 8.4, low: 3.8, high: 8.2, T: 400e-6}
clocks: {t: T}
modes:
  on: {v: (i - v/R)/C, i: (E - v)/L}
  off: {v: (i - v/R)/C, i: -v/L}
events:
  - {mode: on, when: a*(v - Vr) > low + (high - low)*t/T, to: off}
  - {mode: off, when: a*(v - Vr) < low + (high - low)*t/T, to: on}
"""
COMMANDS = [
    ("simulate --start on v=12 i=0.5 --duration 1e-3 --out m.nc --figure m.png", "0.0004"),
    ("cycles --box v=11:13 i=0:1 --count 3", "0.0004"),
    ("follow --start on v=12 --over E=23:25 --out b.nc", "period doubling"),
    ("sweep --start on v=12 --over E=24:25:2 --out s.csv", "period_2"),
    ("attraction --start on --grid v=11:13:3 i=0:1:2 --out a.nc", "cycle"),
]


@pytest.mark.parametrize(
    ("line", "said"), [COMMANDS[0], *(pytest.param(*command, marks=pytest.mark.slow) for command in COMMANDS[1:])]
)
def test_the_shell_reads_a_file(line, said, tmp_path):
    (tmp_path / "buck.yaml").write_text(FILE, encoding="utf-8")
    command, *more = line.split()
    run = [sys.executable, "-m", "lsvib", command, "--system", "buck.yaml", *more, "--json"]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert said in done.stdout
    assert json.loads(done.stdout)
    if command == "simulate":
        assert read_dataset(tmp_path / "m.nc").sizes["event"] > 3
        assert math.isclose(float(read_dataset(tmp_path / "m.nc").time[-1]), 1e-3)


def test_systems_load_nothing_of_drives():
    code = (
        "import sys; from lsvib.systems import System; s = System(['x'], {'go': {'x': '-x'}}); s.simulate('go', {}, 1)"
    )
    code += "; print([name for name in sys.modules if 'lsvib.drives' in name or 'lsvib.answers' in name])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout == "[]\n"
