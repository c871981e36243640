"""Other methods on the cases of the sweeps: how they are judged, and that the judge is generous where it says so."""

import math

import numpy as np
import pytest

from benchmarks.figures.rival_verdicts import dataset as rival_verdicts
from benchmarks.record import Record, Verdict
from benchmarks.rivals.answer_errors import compare
from benchmarks.rivals.hybrid import GaveUp
from benchmarks.rivals.on_sweeps import Effort, Question, ask, confirm, pose
from benchmarks.rivals.race import quiet
from benchmarks.sweeps import case_judge
from benchmarks.sweeps.cases import Case, CaseFamily, CaseGroup, cases, threshold
from lsvib.data.writer import read_dataset, write_dataset
from lsvib.drives.parameters import RigidParameters

TRUTH = Record(
    kinds=["contact_reversal", "stick", "release", "contact_reversal"],
    times=np.array([0.2, 0.5, 0.6, 0.9999]),
    end=np.array([0.1, -4.0]),
    size=np.array([0.5, 40.0]),
    complete=True,
)
SETTINGS = {
    "seed": 3,
    "counts": {"axial_force": 3, "time_span": 2},
    "more": {"time_span": 4},
    "methods": {"rk4_refined": [1e-6], "exact": [1e-9]},
}


def run(**changes) -> Record:
    """The true motion, with changes."""
    return Record(**{"end": TRUTH.end, "times": TRUTH.times, "kinds": TRUTH.kinds} | changes)


def question(**changes):
    """The stick–slip motion of the chapter, 0.05 s long."""
    drive = RigidParameters.of({"mass": 1.0, "translation_damping": 1e3, "axial_force": 40.0} | changes)
    verdict, found = pose(
        Case(CaseFamily.RANDOM, CaseGroup.ONLY, 0.0, drive, (0.05, 0.0), 0.05), np.random.default_rng(0)
    )
    assert verdict is Verdict.RIGHT
    return found


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({}, Verdict.RIGHT),
        ({"times": TRUTH.times - 5e-4}, Verdict.RIGHT),
        ({"times": TRUTH.times - 5e-3}, Verdict.INACCURATE),
        ({"end": np.array([0.1, -4.1])}, Verdict.INACCURATE),
        # The last event is so near to the end that it may be missing; one at the very start may be invented.
        ({"times": TRUTH.times[:3], "kinds": TRUTH.kinds[:3]}, Verdict.RIGHT),
        ({"times": np.append(1e-9, TRUTH.times), "kinds": ["reversal", *TRUTH.kinds]}, Verdict.RIGHT),
        ({"times": TRUTH.times[[0, 3]], "kinds": ["contact_reversal"] * 2}, Verdict.OTHER_EVENTS),
        (
            {"times": TRUTH.times[[0, 3]], "kinds": ["contact_reversal"] * 2, "end": np.zeros(2)},
            Verdict.OTHER_MOTION,
        ),
    ],
)  # fmt: skip
def test_verdicts(changes, verdict):
    """A thousandth is allowed, of the duration and of the motion."""
    assert compare(1.0, TRUTH, run(**changes), 1e-3).verdict is verdict


def test_events_within_the_tolerance_may_come_in_any_order():
    times = np.array([0.2, 0.5, 0.5005, 0.8])
    truth = Record(TRUTH.kinds, times, TRUTH.end, TRUTH.size, True)
    swapped = run(times=times, kinds=["contact_reversal", "release", "stick", "contact_reversal"])
    assert compare(1.0, truth, swapped, 1e-3).verdict is Verdict.RIGHT
    assert compare(1.0, truth, swapped, 1e-4).verdict is Verdict.OTHER_EVENTS


def test_the_error_is_the_largest_of_state_and_times():
    answer = compare(2.0, TRUTH, run(times=TRUTH.times + 1e-4, end=np.array([0.1, -3.6])), 1.0)
    assert answer.error == pytest.approx(0.01)
    assert compare(2.0, TRUTH, run(times=TRUTH.times + 1e-1), 1.0).error == pytest.approx(0.05)


@pytest.mark.parametrize("family", [f for f in CaseFamily if f is not CaseFamily.CONTACT])
def test_the_engine_is_right_as_the_others_are_asked(family):
    """It is driven through the scene that the others get, and compared as they are: 1e-9 for the order of sums."""
    rng = np.random.default_rng([2, family])
    found = [pose(case, rng)[1] for case in cases(family, 4, rng)]
    asked = [q for q in found if q is not None]
    assert asked
    assert {ask(q, "exact", 1e-12).verdict for q in asked} == {Verdict.RIGHT}


def test_a_fixed_step_computes_what_is_well_conditioned():
    assert ask(question(), "rk4_refined", 1e-6).error < 1e-6


def test_a_stiff_drive_is_given_up_before_it_is_run():
    stiff = question(translation_damping=1e12)
    assert stiff.stiffness > 1e6
    assert ask(stiff, "rk4", 1e-6) == (Verdict.GAVE_UP, pytest.approx(math.nan, nan_ok=True), "too stiff")


def test_a_motion_with_too_many_events_is_cut():
    drive = RigidParameters.of(mass=1.0, translation_damping=1e3, axial_force=40.0)
    long = Case(CaseFamily.RANDOM, CaseGroup.ONLY, 0.0, drive, (0.05, 0.0), 1.0)
    _, found = pose(long, np.random.default_rng(0))
    assert found.case.duration < 1.0
    assert found.path.complete
    assert len(found.path.kinds) == case_judge.MOST_EVENTS - 1


def dip() -> Question:
    """One part in 10⁸ inside the threshold of global stability N reverses for an instant, and the screw seizes."""
    force, drive = threshold(CaseGroup.GLOBAL_STABILITY_FORCE)
    drive = drive.replace(axial_force=force * (1 - 1e-8))
    start = (0.06, -drive.input_speed)
    case = Case(CaseFamily.AXIAL_FORCE, CaseGroup.GLOBAL_STABILITY_FORCE, -8.0, drive, start, 0.1)
    return pose(case, np.random.default_rng(0))[1]


def test_a_dip_below_a_guard_is_missed_by_a_general_solver():
    pytest.importorskip("scipy")
    dipping = dip()
    assert dipping.path.kinds.count("seizure") > 2
    with quiet():
        assert ask(dipping, "dop853", 1e-6).verdict is Verdict.OTHER_MOTION
        assert ask(question(), "dop853", 1e-6).verdict is Verdict.RIGHT
    assert confirm(dipping, np.random.default_rng(0))


def test_heyoka_does_not_miss_the_dip():
    """It looks for roots on the whole of each polynomial: what it then needs is the digits, not a short step."""
    pytest.importorskip("heyoka", reason="heyoka is not installed; requirements-accuracy.txt has it")
    assert ask(dip(), "heyoka", 1e-12).verdict is Verdict.RIGHT
    assert ask(question(), "heyoka", 1e-6).verdict is Verdict.RIGHT


def test_effort_is_counted():
    effort = Effort(2)
    effort.start()
    effort.check()
    effort.check()
    with pytest.raises(GaveUp, match="over 2 evaluations"):
        effort.check()
    effort.start()
    effort.spend(2)
    with pytest.raises(GaveUp, match="over 2 steps"):
        effort.spend(1)


def test_interval_of_a_share():
    """Wilson's interval of 0 and 10 of 100, from its formula with z = 1.96; none of none is unknown."""
    low, high = rival_verdicts.wilson(np.array([0, 10, 0]), np.array([100, 100, 0]))
    assert low[:2] == pytest.approx([0.0, 0.0552], abs=1e-4)
    assert high[:2] == pytest.approx([0.0370, 0.1744], abs=1e-4)
    assert np.isnan(low[2])


def test_dataset_checks_and_picture(tmp_path):
    from benchmarks.figures.rival_verdicts.picture import draw
    from lsvib.figures.drawing.style import save

    dataset = rival_verdicts.build(SETTINGS)
    assert dataset.sizes["case"] == 9
    assert dataset["count"].isel(method=0).sum("method_outcome").values.tolist() == [3, 6]
    assert dataset["count"].isel(method=1).sum("method_outcome").values.tolist() == [3, 2]
    assert (dataset.method_verdict.isel(method=1)[dataset.shared == 0] == rival_verdicts.NOT_ASKED).all()
    assert dataset.shared_count.sum("method_outcome").values.tolist() == [5, 5]
    write_dataset(dataset, tmp_path / "a.nc")
    read = read_dataset(tmp_path / "a.nc")
    engine, disputed, others = rival_verdicts.checks(read)
    assert engine.passed
    assert disputed.passed
    assert not others.passed  # the engine itself, asked as one of the others, is never wrong
    for fault in (Verdict.WRONG, Verdict.INACCURATE, Verdict.UNBALANCED):
        spoiled = read.copy(deep=True)
        spoiled.engine_count.loc[{"engine_outcome": int(fault)}] = 1
        assert not rival_verdicts.checks(spoiled)[0].passed
    save(draw(read), tmp_path / "a.png", tmp_path / "a.pdf")
    assert (tmp_path / "a.png").stat().st_size > 10_000
