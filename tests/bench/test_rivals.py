"""The methods that the engine is compared with, on short scenes, against 40 digits; and how their runs are judged."""

import math

import numpy as np
import pytest

from benchmarks.figures.work_precision import SCENES
from benchmarks.judge import Record, Verdict, raced
from benchmarks.rivals import method_list
from benchmarks.rivals.hybrid import Clock, Hybrid
from benchmarks.rivals.race import contest, fastest, time_at_error
from benchmarks.rivals.race_scenes import scene
from lsvib.errors import InputError

ONCE = {"repeats": 1, "seconds": 0.0, "limit": 20.0}
SHORT = {"long_run": 0.015, "stick_slip": 0.4, "graze_above": 0.4, "graze_below": 0.4, "stiff_contact": 0.2,
         "friction_law": 0.1, "steep_law": 0.2, "law_graze": 0.2, "law_motor": 0.2}  # fmt: skip
TRUTH = Record(
    kinds=["contact_reversal", "stick", "release", "contact_reversal"],
    times=np.array([0.2, 0.5, 0.6, 0.9999]),
    end=np.array([0.1, -4.0]),
    size=np.array([0.5, 40.0]),
    stops=1,
    extremes=(-0.5, 0.5),
)


def entry(name, shorten, method, setting):
    package = method_list.METHODS[method].needs
    if package:
        pytest.importorskip(package, reason=f"{package} is not installed; the extra accuracy has it")
    return contest(name, {method: [setting]}, shorten=shorten, **ONCE)[2][0]


@pytest.mark.parametrize("name", SCENES)
def test_the_engine_agrees_with_40_digits_on_every_scene(name):
    """1e-11: rounding (1e-16) times the worst condition of a scene, 1e4, of the seizure that is just reached."""
    found = entry(name, SHORT.get(name, 0.1), "exact", 0).errors
    assert found.verdict == Verdict.RIGHT
    assert max(found.state, found.amplitude) < 1e-11
    assert found.times < 1e-13


@pytest.mark.parametrize(
    ("method", "setting", "name", "worst"),
    [
        ("dop853", 1e-8, "stick_slip", 1e-6), ("lsoda", 1e-8, "sprag_slip", 1e-4),
        ("cvode_bdf", 1e-8, "stick_slip", 1e-4), ("cvode_bdf", 1e-7, "stiff_contact", 1e-3),
        ("dop853", 1e-12, "friction_law", 1e-9), ("radau", 1e-7, "friction_law", 1e-5),
        ("cvode_bdf", 1e-12, "friction_law", 1e-7), ("heyoka", 2.2e-16, "friction_law", 1e-12),
        ("heyoka", 2.2e-16, "law_graze", 1e-12), ("dop853", 1e-12, "law_motor", 1e-9),
        ("heyoka", 2.2e-16, "stick_slip", 1e-11), ("heyoka", 2.2e-16, "sprag_graze", 1e-11),
        ("rk4", 1e-5, "stick_slip", 1e-4), ("rk4_refined", 1e-5, "stick_slip", 1e-8),
        ("smoothed", 0.01, "stick_slip", 1e-2),
        ("smoothed", 0.01, "sprag_slip", 0.1),  # in the Painlevé region, with a contact that complies
    ],
)  # fmt: skip
def test_a_rival_agrees_with_40_digits(method, setting, name, worst):
    """Over a few cycles with jumps, rests and reversals; multistep methods lose most."""
    found = entry(name, SHORT.get(name, 0.1), method, setting).errors
    assert found.verdict == Verdict.RIGHT
    assert found.state < worst


def test_a_run_that_takes_too_much_gives_up():
    """Too many events, endless chains of them, and the time; each says which."""
    assert "over 0 s" in contest("stick_slip", {"rk45": [1e-9]}, 1, 0.0, 0.0)[2][0].failure
    endless = Hybrid(scene("stick_slip")).run(lambda mode, now, state, end: (now, state, 0), Clock(10.0), 20)
    assert endless().failure == "over 20 events"


@pytest.mark.parametrize("name", ["stiff_contact", "friction_law"])
def test_a_scene_leaves_out_the_methods_that_cannot_do_it(name):
    assert [e.method for e in contest(name, {"exact": [0], "rk4": [1e-5]}, shorten=0.02, **ONCE)[2]] == ["exact"]


def test_a_missing_package_is_one_sentence(monkeypatch):
    monkeypatch.setattr(method_list, "find_spec", lambda package: None)
    with pytest.raises(InputError, match="The package heyoka, which heyoka needs, is not installed; run pip"):
        contest("stick_slip", {"heyoka": [1e-3]}, **ONCE)


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, Verdict.RIGHT),
        ({"times": TRUTH.times[:1], "kinds": TRUTH.kinds[:1]}, Verdict.OTHER_EVENTS),
        ({"extremes": (-0.6, 0.6)}, Verdict.OTHER_MOTION),
        ({"failure": "over 1 s"}, Verdict.GAVE_UP),
        ({"end": np.array([math.inf, 0.0])}, Verdict.GAVE_UP),
        ({"kinds": None, "stops": 2}, Verdict.OTHER_EVENTS),
    ],
)
def test_verdicts_on_a_race(changes, verdict):
    same = {"end": TRUTH.end, "times": TRUTH.times, "kinds": TRUTH.kinds, "extremes": TRUTH.extremes}
    assert raced(Record(**{**same, **changes}), TRUTH).verdict == verdict


def test_time_at_error_interpolates_in_logarithms():
    points = [(1e-2, 1.0), (1e-4, 4.0)]
    assert time_at_error(points, 1e-3) == pytest.approx(2.0)
    assert math.isnan(time_at_error(points, 1e-5))
    assert fastest([[(1e-2, 9.0)], [(1e-4, 4.0)], [(1.0, 0.1)]], 1e-2) == 4.0
