"""The methods that the engine is compared with, on short scenes, against 40 digits; and how their runs are judged."""

import math

import numpy as np
import pytest

from benchmarks import cost_of_certainty
from benchmarks.figures.work_precision import SCENES
from benchmarks.judge import asked, raced
from benchmarks.record import Record, Verdict
from benchmarks.rivals import friction_law, method_list
from benchmarks.rivals.hybrid import Clock, Hybrid
from benchmarks.rivals.on_sweeps import ask, pose
from benchmarks.rivals.race import RaceBudget, contest, fastest, quiet, time_at_error
from benchmarks.rivals.race_scenes import scene
from benchmarks.sweeps.cases import Case, CaseFamily
from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.stability.force_thresholds import threshold_force

ONCE = RaceBudget(repeats=1, seconds=0.0, limit=20.0)
SHORT = {"long_run": 0.015, "stick_slip": 0.4, "graze_above": 0.4, "graze_below": 0.4, "stiff_contact": 0.2}
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
    return contest(name, {method: [setting]}, ONCE, shorten)[2][0]


@pytest.mark.parametrize("name", SCENES)
def test_the_engine_agrees_with_40_digits_on_every_scene(name):
    """1e-11: rounding (1e-16) times the worst condition of a scene, 1e4, of the seizure that is just reached."""
    found = entry(name, SHORT.get(name, 0.1), "exact", 0).errors
    assert found.verdict == Verdict.RIGHT
    assert max(found.state, found.amplitude) < 1e-11
    assert found.times < 1e-13


def slow(*case):
    return pytest.param(*case, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("method", "setting", "name", "worst"),
    [
        ("dop853", 1e-8, "stick_slip", 1e-6), ("lsoda", 1e-8, "sprag_slip", 1e-4),
        ("cvode_bdf", 1e-8, "stick_slip", 1e-4), ("cvode_bdf", 1e-7, "stiff_contact", 1e-3),
        slow("diffrax_tsit5", 1e-8, "stick_slip", 1e-6), slow("diffrax_dopri8_capped", 1e-8, "sprag_slip", 1e-9),
        slow("diffrax_kvaerno5", 1e-7, "stiff_contact", 1e-3), ("heyoka", 2.2e-16, "stick_slip", 1e-11),
        ("heyoka", 2.2e-16, "sprag_graze", 1e-11), ("rk4", 1e-5, "stick_slip", 1e-4),
        ("rk4_refined", 1e-5, "stick_slip", 1e-8), ("smoothed", 0.01, "stick_slip", 1e-2),
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
    assert "over 0 s" in contest("stick_slip", {"rk45": [1e-9]}, RaceBudget(1, 0.0, 0.0), 0.2)[2][0].failure
    endless = Hybrid(scene("stick_slip")).run(lambda mode, now, state, end: (now, state, 0), Clock(10.0), 20)
    assert endless().failure == "over 20 events"


def test_a_stiff_scene_has_no_explicit_method():
    assert [e.method for e in contest("stiff_contact", {"exact": [0], "rk4": [1e-5]}, ONCE, 0.02)[2]] == ["exact"]


def test_a_missing_package_is_one_sentence(monkeypatch):
    monkeypatch.setattr(method_list, "find_spec", lambda package: None)
    with pytest.raises(InputError, match="The package heyoka, which heyoka needs, is not installed; run pip"):
        contest("stick_slip", {"heyoka": [1e-3]}, ONCE)


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


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, Verdict.RIGHT),
        ({"times": TRUTH.times - 5e-4}, Verdict.RIGHT),
        ({"times": TRUTH.times - 5e-3}, Verdict.INACCURATE),
        ({"end": np.array([0.1, -4.1])}, Verdict.INACCURATE),
        # The last event is so near to the end that it may be missing.
        ({"times": TRUTH.times[:3], "kinds": TRUTH.kinds[:3]}, Verdict.RIGHT),
        ({"times": TRUTH.times[[0, 3]], "kinds": ["contact_reversal"] * 2}, Verdict.OTHER_EVENTS),
        ({"times": TRUTH.times[:1], "kinds": ["stick"], "end": np.zeros(2)}, Verdict.OTHER_MOTION),
    ],
)
def test_verdicts_on_a_case(changes, verdict):
    """A thousandth is allowed, of the duration and of the motion."""
    run = Record(**{"end": TRUTH.end, "times": TRUTH.times, "kinds": TRUTH.kinds} | changes)
    assert asked(1.0, TRUTH, run, 1e-3).verdict is verdict


def test_time_at_error_interpolates_in_logarithms():
    points = [(1e-2, 1.0), (1e-4, 4.0)]
    assert time_at_error(points, 1e-3) == pytest.approx(2.0)
    assert math.isnan(time_at_error(points, 1e-5))
    assert fastest([[(1e-2, 9.0)], [(1e-4, 4.0)], [(1.0, 0.1)]], 1e-2) == 4.0


def test_a_dip_below_a_guard_is_missed_by_a_general_solver_and_not_by_taylor_series():
    """One part in 10⁸ inside the threshold of global stability N reverses for an instant, and the screw seizes."""
    drive = Drive.of(mass=11.0, support_damping=1e-3)
    drive = drive.replace(axial_force=threshold_force(drive, "global_stability") * (1 - 1e-8))
    start = (0.06, -drive.input_speed)
    case = Case(CaseFamily.AXIAL_FORCE, -8.0, drive, start, 0.1)
    verdict, dip = pose(case, np.random.default_rng(0))
    assert verdict is Verdict.RIGHT
    assert dip.path.kinds.count("seizure") > 2
    with quiet():
        assert ask(dip, "dop853", 1e-6).verdict is Verdict.OTHER_MOTION
        assert ask(dip, "exact", 1e-12).verdict is Verdict.RIGHT
        pytest.importorskip("heyoka", reason="heyoka is not installed; the extra accuracy has it")
        assert ask(dip, "heyoka", 1e-12).verdict is Verdict.RIGHT


@pytest.mark.search
def test_certainty_costs_less_than_twice_a_plain_search():
    """The price of the certain search beside the cheapest possible one, which finds the same roots."""
    certain, plain = cost_of_certainty.compared(repeats=200)
    assert certain < 2 * plain


@pytest.mark.slow
def test_every_method_has_the_period_under_a_friction_law():
    pytest.importorskip("heyoka", reason="heyoka is not installed; the extra accuracy has it")
    pytest.importorskip("sksundae", reason="scikit-sundae is not installed; the extra accuracy has it")
    errors = {name: error for name, (error, _) in friction_law.compared(repeats=1).items()}
    limits = {"lsvib": 1e-15, "heyoka 1e-08": 1e-9, "heyoka 1e-12": 1e-12, "heyoka 2e-16": 1e-13, "CVODE 1e-08": 1e-6,
              "CVODE 1e-12": 1e-10}  # fmt: skip
    assert all(error <= limits.pop(name) for name, error in errors.items())
    assert not limits
