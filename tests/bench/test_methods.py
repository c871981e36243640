"""The methods that the engine is compared with: each computes the scenes, with the order that theory gives it."""

import math

import numpy as np
import pytest

from benchmarks.figures.work_precision.settings import SCENES
from benchmarks.record import Verdict
from benchmarks.rivals import method_list
from benchmarks.rivals.hybrid import Clock, GaveUp, Hybrid, HybridMode
from benchmarks.rivals.on_sweeps import Effort
from benchmarks.rivals.race import RaceBudget, contest
from benchmarks.rivals.race_scenes import scene
from lsvib.errors import InputError

ONCE = RaceBudget(repeats=1, seconds=0.0, limit=20.0)
SHORT = {"long_run": 0.015, "stick_slip": 0.4, "graze_above": 0.4, "graze_below": 0.4, "stiff_contact": 0.2}


def results(name, shorten, **settings):
    """Entries of a contest by (method, setting)."""
    _, _, entries = contest(name, settings, ONCE, shorten)
    return {(entry.method, entry.setting): entry for entry in entries}


def needed(method):
    """Skip a test without the package that a method needs."""
    package = method_list.METHODS[method].needs
    pytest.importorskip(package, reason=f"{package} is not installed; requirements-accuracy.txt has it")


@pytest.mark.parametrize("name", SCENES)
def test_the_engine_agrees_with_40_digits_on_every_scene(name):
    """1e-11: rounding (1e-16) times the worst condition of a scene, 1e4, of the seizure that is just reached."""
    entry = results(name, SHORT.get(name, 0.1), exact=[0])["exact", 0]
    assert entry.errors.verdict == Verdict.RIGHT
    assert entry.errors.state < 1e-11
    assert entry.errors.amplitude < 1e-11
    assert entry.errors.times < 1e-13


def test_runge_kutta_has_its_order():
    """Order four with refined events: the error falls by 10⁴ with a tenth of the step; by 10² with straight cuts."""
    found = results("stick_slip", 0.4, rk4=[1e-4, 1e-5], rk4_refined=[1e-4, 1e-5])
    order = {m: math.log10(found[m, 1e-4].errors.state / found[m, 1e-5].errors.state) for m in ("rk4", "rk4_refined")}
    assert 3.5 < order["rk4_refined"] < 5
    assert 1.3 < order["rk4"] < 3


@pytest.mark.parametrize(
    ("method", "worst"),
    [
        ("rk45", 1e-6),
        ("dop853", 1e-6),
        ("dop853_capped", 1e-10),  # the cap alone makes it that good
        ("radau", 1e-6),
        ("bdf", 1e-4),
        ("lsoda", 1e-4),
        ("lsoda_capped", 1e-4),
        ("cvode_adams", 1e-4),
        ("cvode_bdf", 1e-4),
        ("cvode_bdf_capped", 1e-4),
        ("diffrax_tsit5", 1e-6),
        ("diffrax_dopri8_capped", 1e-9),
        ("diffrax_kvaerno5", 1e-4),
        ("heyoka", 1e-7),
    ],
)
@pytest.mark.parametrize("name", ["stick_slip", "sprag_slip"])
def test_general_solvers_compute_what_is_well_conditioned(method, worst, name):
    """At a tolerance of 1e-8, over a few cycles with jumps, rests and reversals; multistep methods lose most."""
    needed(method)
    entry = results(name, SHORT.get(name, 0.1), **{method: [1e-8]})[method, 1e-8]
    assert entry.errors.verdict == Verdict.RIGHT
    assert entry.errors.state < worst


@pytest.mark.parametrize("method", ["radau", "lsoda", "cvode_bdf", "diffrax_kvaerno5", "heyoka"])
def test_stiff_solvers_compute_the_stiff_contact(method):
    needed(method)
    entry = results("stiff_contact", 0.2, **{method: [1e-7]})[method, 1e-7]
    assert entry.errors.verdict == Verdict.RIGHT
    assert entry.errors.state < 1e-3


def test_diffrax_makes_the_events_of_the_engine():
    """A tolerance of 1e-11 in each step, and some thousand steps: 1e-8 of the motion, 1e-11 s."""
    needed("diffrax_tsit5")
    hybrid = Hybrid(scene("stick_slip"))
    ours, theirs = (
        method_list.find_method(name).prepare(hybrid, 1e-11, Clock(20.0), 200)()()
        for name in ("exact", "diffrax_tsit5")
    )
    assert len(ours.kinds) == 152
    assert theirs.kinds == ours.kinds
    assert theirs.times == pytest.approx(ours.times, abs=1e-11)
    assert theirs.end == pytest.approx(ours.end, rel=1e-8)
    assert theirs.extremes == pytest.approx(ours.extremes, abs=1e-8)


def test_diffrax_keeps_the_limits_of_all():
    """Too many events, across the chunks of the compiled loop too, and the time."""
    needed("diffrax_tsit5")
    find = method_list.find_method("diffrax_tsit5").prepare
    assert find(Hybrid(scene("stick_slip")), 1e-6, Clock(20.0), 20)()().failure == "over 20 events"
    long = Hybrid(scene("long_run", 0.3))  # 1500 events
    assert find(long, 1e-6, Clock(20.0), 1100)()().failure == "over 1100 events"
    assert len(find(long, 1e-6, Clock(20.0), 1600)()().kinds) > 1100
    assert find(long, 1e-6, Clock(0.0), 1600)()().failure == "over 0 s"


def test_dopri8_of_diffrax_is_as_good_as_its_interpolation():
    """It finds events on a polynomial through a step; without a cap the steps are long, and it is the error of that."""
    needed("diffrax_tsit5")
    free, capped = (
        results("sprag_slip", 0.1, **{m: [1e-9]})[m, 1e-9] for m in ("diffrax_dopri8", "diffrax_dopri8_capped")
    )
    assert free.errors.verdict == capped.errors.verdict == Verdict.RIGHT
    assert free.errors.state > 100 * 1e-9 > 1e4 * capped.errors.state


@pytest.mark.parametrize("name", SCENES)
def test_heyoka_is_right_to_rounding_on_every_scene(name):
    """At its own tolerance, also at grazing and on the stiff contact: held to what the engine is held to."""
    needed("heyoka")
    entry = results(name, SHORT.get(name, 0.1), heyoka=[2.2e-16])["heyoka", 2.2e-16]
    assert entry.errors.verdict == Verdict.RIGHT
    assert entry.errors.state < 1e-11
    assert entry.errors.amplitude < 1e-11
    assert entry.errors.times < 1e-13


def test_heyoka_keeps_time_in_two_doubles():
    """1500 events: sums of the lengths of arcs in one double would be off by some 1e-13 s."""
    needed("heyoka")
    hybrid = Hybrid(scene("long_run", 0.3))
    ours, theirs = (
        method_list.find_method(name).prepare(hybrid, 2.2e-16, Clock(20.0), 2000)()() for name in ("exact", "heyoka")
    )
    assert len(ours.kinds) > 1400
    assert theirs.kinds == ours.kinds
    assert theirs.times == pytest.approx(ours.times, rel=0.0, abs=5e-15)


def test_heyoka_keeps_the_limits_of_all():
    """Too many events, the time, and too many steps where those are counted."""
    needed("heyoka")
    find = method_list.find_method("heyoka").prepare
    assert find(Hybrid(scene("stick_slip")), 1e-6, Clock(20.0), 20)()().failure == "over 20 events"
    stiff = Hybrid(scene("stiff_contact", 0.1))
    assert find(stiff, 1e-6, Clock(0.0), 100)()().failure == "over 0 s"
    assert find(stiff, 1e-6, Effort(3000), 100)()().failure == "over 3000 steps"


@pytest.mark.parametrize("offset", [0.0, 1.0, -0.7])
@pytest.mark.parametrize("speed", [1e-2, 1e-6])
def test_heyoka_sees_a_guard_that_rises_from_zero_and_falls_at_once(offset, speed):
    """x″ = −1, x = offset at the start and again after 2 speed; heyoka alone loses that root of its polynomial."""
    needed("heyoka")
    from benchmarks.rivals.methods import heyoka_events

    mode = HybridMode(np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([0.0, -1.0]), np.array([[1.0, 0.0, -offset]]), 0)
    arc = heyoka_events._integrator(mode, np.ones(2), 2.2e-16)
    arc.state[:] = offset, speed
    outcome, *_ = arc.propagate_until(1.0)
    assert int(outcome) == -1  # the first event, which ends the run
    assert arc.time == pytest.approx(
        2 * speed, rel=1e-3
    )  # the guard is known to 1e-16: 5e-5 of this root at the least speed


def test_smoothed_friction_is_of_first_order_in_its_width():
    pytest.importorskip("sksundae")
    found = results("stick_slip", 0.4, smoothed=[0.1, 0.01])
    assert 4 < found["smoothed", 0.1].errors.state / found["smoothed", 0.01].errors.state < 25


def test_a_stiff_scene_has_no_explicit_method():
    assert set(results("stiff_contact", 0.02, exact=[0], rk4=[1e-5])) == {("exact", 0)}


def test_a_run_over_its_time_gives_up():
    pytest.importorskip("scipy")
    _, _, (entry,) = contest("stick_slip", {"rk45": [1e-9]}, RaceBudget(1, 0.0, 0.01), 0.2)
    assert entry.errors.verdict == Verdict.GAVE_UP
    assert "over 0.01 s" in entry.failure


def test_an_endless_chain_of_events_gives_up():
    hybrid = Hybrid(scene("stick_slip"))
    record = hybrid.run(lambda mode, now, state, end: (now, state, 0), Clock(10.0), 20)
    assert record().failure == "over 20 events"


def test_the_clock_stops_a_run():
    clock = Clock(0.0)
    clock.start()
    clock.calls = 63
    with pytest.raises(GaveUp, match="over 0 s"):
        clock.check()


@pytest.mark.parametrize(
    ("method", "words"),
    [
        ("cvode_bdf", "The package scikit-sundae, which CVODE BDF needs"),
        ("diffrax_tsit5", "The package diffrax, which diffrax Tsit5 needs"),
        ("heyoka", "The package heyoka, which heyoka needs"),
    ],
)
def test_a_missing_package_is_one_sentence(monkeypatch, method, words):
    monkeypatch.setattr(method_list, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=rf"{words}, is not installed; run pip install -r requirements-accuracy"):
        contest("stick_slip", {method: [1e-3]}, ONCE, 0.01)


@pytest.mark.parametrize(("name", "method"), [("stick_slop", "exact"), ("stick_slip", "inexact")])
def test_a_wrong_name_is_one_sentence(name, method):
    with pytest.raises(InputError, match=r"= '(stick_slop|inexact)' is not one of"):
        contest(name, {method: [0]}, ONCE, 0.01)


def test_a_step_that_is_too_short_is_refused():
    with pytest.raises(InputError, match="time step of 1e-12 s is outside the allowed range >= "):
        results("stick_slip", 1.0, rk4=[1e-12])
