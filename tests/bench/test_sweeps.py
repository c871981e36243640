"""The sweeps to the edge of the domain: their judges, and the faults of the engine that they found."""

import numpy as np
import pytest
from references.figure_checks import assert_drawn_from_file, set_to
from references.rigid_digits import simulate

from benchmarks.figures.stability_sweeps import dataset as stability_sweeps
from benchmarks.record import Record, Verdict
from benchmarks.sweeps import case_judge, taylor
from benchmarks.sweeps.case_judge import Judge, judge
from benchmarks.sweeps.cases import THRESHOLDS, cases
from benchmarks.sweeps.families import Case, CaseFamily, CaseGroup
from benchmarks.sweeps.taylor import KINDS
from benchmarks.sweeps.threshold_sides import attractor_is_right, long_run
from lsvib.drives.parameters import RigidParameters, ThreadsParameters

EXACT = 1e-12  # of the size of the motion, as the project demands of a rigid drive


def case(start, duration, **drive) -> Case:
    return Case(CaseFamily.RANDOM, CaseGroup.ONLY, 0.0, RigidParameters.of(drive), start, duration)


FAULTS = {  # what the sweeps found in the engine, now mended
    # Q = 0 was met by moving u, at 2e11 times the rounding of w; the engine of that time was wrong by 2e-2.
    "overdamped": case(
        (0.033612718822704085, 30.32829454941607), 0.01575295575320704,
        support_damping=168972636275.62024, friction_coefficient=0.15659832944365906, input_speed=-62.26338631957315,
        mass=3.5596022920178694, translation_damping=491.9937961493653, axial_force=-36.0220075148122,
    ),
    # Along a growing exponential, C = e^{r₁t} (1 − r₁h) lost its digits; wrong by 2e-5.
    "growing": case(
        (-0.023732276235453525, -24.67997012347249), 0.029883030468583816,
        support_damping=7.959756555856115e-05, friction_coefficient=0.47047981873012806, input_speed=5.745172781413486,
        mass=3.3436031383415434, translation_damping=943.8717009138239, axial_force=169.5496730492857,
    ),
    # Next to the critical mass Q on the slow eigenvector is 1e-12 of its terms: one contact reversal too many.
    "critical": case(
        (0.17361205574470076, -214.86518439546774), 0.05427607517296477,
        support_damping=0.0010147581845978528, friction_coefficient=0.23593325987488772, input_speed=-72.84408272817747,
        mass=8.81251902284079, translation_damping=1592.3153617477658, axial_force=1.3357555018339318,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_faults_that_the_sweeps_found(name):
    outcome = judge(FAULTS[name], np.random.default_rng(0), thorough=True)
    assert (outcome.verdict, outcome.judge) == (Verdict.RIGHT, Judge.REFERENCE)
    assert outcome.state_error <= EXACT


def test_nothing_is_zero_by_a_coordinate_that_hardly_moves_it():
    """N = 0 was met by moving v, which moves N 1e5 times less than e does: 2e-9 of v after ten reversals, now 3e-11."""
    drive = ThreadsParameters.of(
        mass=10.2, axial_force=10.0, contact_stiffness=33292493092958.695, contact_damping=1225.490850333786
    )
    start = (0.028173126284128852, -113.38366059359736, 0.0, 0.0)
    stiff = Case(CaseFamily.CONTACT, CaseGroup.ONLY, 13.5, drive, start, 1.0124174539161732e-05)
    outcome = judge(stiff, np.random.default_rng(0))
    assert (outcome.verdict, outcome.events) == (Verdict.RIGHT, 10)
    assert max(outcome.state_error, outcome.time_error) <= 2e-10


SLOW_TO_JUDGE = (CaseFamily.DOUBLE_RATE_OF_THREADS, CaseFamily.SUPPORT, CaseFamily.NUT)


@pytest.mark.parametrize("family", [f for f in CaseFamily if f is not CaseFamily.CONTACT])
def test_families(family):
    """Seeded, so that it is the same everywhere; ten times this many and more are in the dataset."""
    rng = np.random.default_rng([1, family])
    count, asked = (3, 1) if family in SLOW_TO_JUDGE else (12, 2)
    outcomes = [judge(c, rng, thorough=k < asked) for k, c in enumerate(cases(family, count, rng))]
    assert {o.verdict for o in outcomes} <= {Verdict.RIGHT, Verdict.CORNER}
    assert Judge.REFERENCE in {o.judge for o in outcomes}


def test_the_judges_notice_a_wrong_event(monkeypatch):
    rng = np.random.default_rng(0)
    this = case((0.05, 0.0), 0.05, mass=1.0, translation_damping=1e3, axial_force=40.0)
    assert judge(this, rng).verdict is Verdict.RIGHT
    honest = case_judge.engine_path

    def forgetful(motion, of):
        path = honest(motion, of)
        return Record(path.kinds[:-1], path.times[:-1], path.end, path.size, path.complete)

    monkeypatch.setattr(case_judge, "engine_path", forgetful)
    assert judge(this, rng).verdict is Verdict.WRONG

    def shifted(motion, of):
        path = honest(motion, of)
        return Record(path.kinds, path.times, path.end * (1 + 1e-8), path.size, path.complete)

    monkeypatch.setattr(case_judge, "engine_path", shifted)
    assert judge(this, rng).verdict is Verdict.INACCURATE


def test_stepper_against_the_reference():
    """Taylor steps have ten digits and more; 1e-11 leaves room for 100 events of rounding."""
    rng = np.random.default_rng(5)
    times, kinds = np.empty(60), np.empty(60, dtype=np.int64)
    for c in cases(CaseFamily.INPUT_SPEED, 20, rng):
        constants = taylor.constants(dict(c.drive))
        complete, count, u, w = taylor.run(constants, *c.start, c.duration, times, kinds)
        expected = simulate(dict(c.drive), *c.start, c.duration)
        assert complete
        assert [KINDS[kind] for kind in kinds[:count]] == [event.kind for event in expected.events]
        size = np.abs([[float(s.u), float(s.w)] for s in expected.segments]).max(axis=0)
        assert np.all(np.abs([u - float(expected.u), w - float(expected.w)]) <= 1e-11 * size)


@pytest.mark.parametrize("group", THRESHOLDS)
@pytest.mark.parametrize("side", [-1, 1])
def test_attractors_beside_a_threshold(group, side):
    assert attractor_is_right(group, side, 1e-10)


@pytest.mark.parametrize(
    "changes", [{"translation_damping": 1e3, "axial_force": 40.0}, {"mass": 15.0, "axial_force": 100.0}]
)
def test_a_thousand_periods(changes):
    run = long_run(RigidParameters.of(changes), 1000)
    assert run.events > 2000
    assert run.clock_error <= EXACT
    assert run.state_error <= EXACT


SMALL = {
    "seed": 1, "counts": {"contact": 1, "axial_force": 6, "nut": 1}, "thorough": 1, "evaluations": 1,
    "distances": [1e-2], "periods": 100,
}  # fmt: skip
SPOILERS = {
    "No wrong verdict": set_to("case_verdict", Verdict.WRONG, 0),
    "does not pass": set_to("case_verdict", Verdict.REFUSED, slice(0, 4)),
    "Rigid drive": set_to("case_verdict", Verdict.INACCURATE, 1),
    "Drives with four states": set_to("time_error", 2e-8, 0),
    "Energy balances": set_to("energy_residual", 1e-3, 2),
    "A search": set_to("worst_verdict", Verdict.UNBALANCED, 0),
    "Attractors on both sides": set_to("attractor_is_right", 0, 0, 0, 0),
    "Cycles over many periods": set_to("clock_error", 1e-11, 0),
}


def test_each_check_of_a_small_sweep_passes_and_fails_on_spoiled_data(tmp_path):
    dataset = stability_sweeps.build(SMALL)
    checks = stability_sweeps.checks(dataset)
    assert [check.sentence() for check in checks if not check.passed] == []
    assert len(checks) == len(SPOILERS)
    for words, spoil in SPOILERS.items():
        assert [check.passed for check in stability_sweeps.checks(spoil(dataset)) if words in check.claim] == [False]
    assert_drawn_from_file("stability_sweeps", dataset, tmp_path / "a.nc")
