"""Verdicts, run times at equal error, the dataset of error against run time, its tables and picture."""

import math

import numpy as np
import pytest

from benchmarks.figures.work_precision import dataset as work_precision
from benchmarks.figures.work_precision.settings import SCENES
from benchmarks.record import Record, Verdict, errors
from benchmarks.rivals.hybrid import Hybrid, _affine
from benchmarks.rivals.markdown_tables import markdown
from benchmarks.rivals.method_list import MethodFamily
from benchmarks.rivals.padded_tables import NEVER, even_tables
from benchmarks.rivals.race import fastest, time_at_error
from benchmarks.rivals.race_scenes import scene
from lsvib.data.writer import read_dataset, write_dataset

TRUTH = Record(
    end=np.array([0.1, -4.0]),
    times=np.array([0.2, 0.3]),
    kinds=["stick", "release"],
    stops=1,
    extremes=(-0.5, 0.5),
    size=np.array([0.5, 40.0]),
)
SETTINGS = {
    "scenes": ["stick_slip", "sprag_graze"],
    "shorten": 0.3,
    "methods": {"exact": [0], "rk4_refined": [1e-4, 1e-5], "rk45": []},
    "repeats": 2,
    "seconds": 0.0,
    "limit": 5.0,
    "error_levels": [1e-3, 1e-9],
    "ratio_floor": 1.0,
    "compiled_floor": 1.0,
}


def run(**changes) -> Record:
    """The true motion, with changes."""
    same = {"end": TRUTH.end, "times": TRUTH.times, "kinds": TRUTH.kinds, "extremes": TRUTH.extremes}
    return Record(**{**same, **changes})


def test_the_true_motion_has_no_error():
    assert errors(run(), TRUTH) == errors(run(), TRUTH).__class__(0.0, 0.0, 0.0, Verdict.RIGHT)


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [
        ({"times": np.array([0.2]), "kinds": ["stick"]}, Verdict.OTHER_EVENTS),
        ({"extremes": (-0.6, 0.6)}, Verdict.OTHER_MOTION),
        ({"extremes": (math.nan, math.nan)}, Verdict.OTHER_MOTION),
        ({"failure": "over 1 s"}, Verdict.GAVE_UP),
        ({"end": np.array([math.inf, 0.0])}, Verdict.GAVE_UP),
        ({"kinds": None, "stops": 1}, Verdict.RIGHT),
        ({"kinds": None, "stops": 2}, Verdict.OTHER_EVENTS),
    ],
)
def test_verdicts(changes, verdict):
    assert errors(run(**changes), TRUTH).verdict == verdict


def test_errors_are_in_sizes_of_the_motion():
    found = errors(run(end=np.array([0.1, -3.6]), times=np.array([0.2, 0.31]), extremes=(-0.5, 0.51)), TRUTH)
    assert found.state == pytest.approx(0.01)
    assert found.times == pytest.approx(0.01)
    assert found.amplitude == pytest.approx(0.01)


def test_time_at_error_interpolates_in_logarithms():
    points = [(1e-2, 1.0), (1e-4, 4.0)]
    assert time_at_error(points, 1e-3) == pytest.approx(2.0)
    assert time_at_error(points, 1e-1) == 1.0
    assert time_at_error(points, 1e-4) == 4.0
    assert math.isnan(time_at_error(points, 1e-5))


def test_a_run_that_is_worse_and_slower_does_not_count():
    assert time_at_error([(1e-2, 9.0), (1e-4, 4.0)], 1e-3) == 4.0
    assert fastest([[(1e-2, 9.0)], [(1e-4, 4.0)], [(1.0, 0.1)]], 1e-2) == 4.0


@pytest.mark.parametrize("n", [2, 4])
def test_an_affine_function_and_the_size_of_its_terms(n):
    rng = np.random.default_rng(n)
    for row, state in zip(rng.normal(size=(20, n + 1)), rng.normal(size=(20, n)), strict=True):
        terms = row * np.append(state, 1.0)
        assert _affine(row.tolist(), state.tolist()) == pytest.approx((terms.sum(), np.abs(terms).sum()), rel=1e-12)


@pytest.mark.parametrize("name", SCENES)
def test_a_guard_is_due_where_it_falls_from_zero(name):
    """On a guard the rate decides, beyond it the value: against the definition, with numpy."""
    hybrid, rng = Hybrid(scene(name)), np.random.default_rng(1)
    seen = set()
    for k, mode in enumerate(hybrid.modes):
        for i, row in enumerate(mode.guards):
            for on_guard in (True, False):
                state = hybrid.scene.scales * rng.normal(size=hybrid.scene.scales.size)
                if on_guard:
                    j = int(np.argmax(np.abs(row[:-1]) * hybrid.scene.scales))
                    state[j] -= (row[:-1] @ state + row[-1]) / row[j]
                values, rates = (
                    mode.guards[:, :-1] @ state + mode.guards[:, -1],
                    mode.guards[:, :-1] @ (mode.matrix @ state + mode.constant),
                )
                if on_guard:
                    values[i] = 0.0  # which it is but for rounding
                due = (values < 0) | ((values == 0) & (rates < 0))
                seen.add(bool(due.any()))
                assert hybrid.due(k, state.tolist()) == (int(np.argmax(due)) if due.any() else None)
    assert seen == {True, False}


@pytest.mark.parametrize("name", SCENES)
def test_even_tables_hold_the_scene_and_nothing_that_acts(name):
    hybrid = Hybrid(scene(name))
    tables, original = even_tables(hybrid), hybrid.tables
    for k, mode in enumerate(hybrid.modes):
        count = len(mode.guards)
        assert np.array_equal(tables.guards[k, :count], mode.guards)
        assert (tables.guards[k, count:, :-1] == 0).all()
        assert (tables.guards[k, count:, -1] > 0).all()  # never falls through zero
    for k, count in enumerate(np.diff(original.branch_start)):
        assert (tables.tests[k, :count] != NEVER).all()
        assert (tables.tests[k, count:, 0] == NEVER).all()
        own = slice(original.branch_start[k], original.branch_start[k + 1])
        assert np.array_equal(tables.mode[k, :count], original.branch_mode[own])
    assert np.count_nonzero(tables.tests >= 0) == original.condition_test.size


def test_dataset_tables_and_picture(tmp_path):
    from benchmarks.figures.work_precision.picture import draw
    from lsvib.figures.drawing.style import save

    dataset = work_precision.build(SETTINGS)
    assert dict(dataset.sizes) == {"scene": 2, "method": 2, "setting": 2, "rival": 5, "error_level": 2}
    engine = dataset.isel(method=0, setting=0)
    assert (engine.motion_verdict == int(Verdict.RIGHT)).all()
    assert (engine.run_time <= engine.run_time_median).all()
    assert (dataset.motion_verdict.isel(method=0, setting=1) == int(Verdict.NOT_RUN)).all()
    assert dataset.ratio.sel(scene=0, rival=int(MethodFamily.FIXED_STEP), error_level=1e-3) > 1
    assert (dataset.first_run_time > 0).all()
    assert dataset.attrs["processor_cores"] >= 1
    write_dataset(dataset, tmp_path / "a.nc")
    read = read_dataset(tmp_path / "a.nc")
    assert "| stick_slip | RK4, refined events | 1e-05 |" in markdown(read)
    save(draw(read), tmp_path / "a.png", tmp_path / "a.pdf")
    assert (tmp_path / "a.png").stat().st_size > 10_000
    checks = {check.claim: check.passed for check in work_precision.checks(read)}
    assert checks["The engine shows the true motion on every scene"]
    assert not checks["General solvers show a wrong motion, or none, in some runs"]  # none was run


def test_a_scene_in_which_no_rival_is_right_has_a_claim_of_its_own():
    """It passes as long as the engine reaches all levels; one that reaches none fails it."""
    dataset = work_precision.build(SETTINGS)
    rivals = dataset.method_family.values == int(MethodFamily.FIXED_STEP)

    def verdicts(family, spoiled):
        return {c.claim: c.passed for c in work_precision._ratio_checks(spoiled, family, "a rival", 0.0)}

    assert all(verdicts(MethodFamily.FIXED_STEP, dataset).values())
    wrong = dataset.copy(deep=True)
    wrong.motion_verdict[0, rivals] = int(Verdict.OTHER_EVENTS)
    never = "stick_slip: to none of the errors asked for does a rival show the true motion, to all the engine does"
    assert never not in verdicts(MethodFamily.FIXED_STEP, dataset)
    assert verdicts(MethodFamily.FIXED_STEP, wrong)[never]
    wrong.state_error[0, 0, 0] = 1e-2
    assert not verdicts(MethodFamily.FIXED_STEP, wrong)[never]
    assert not verdicts(MethodFamily.GENERAL, dataset)  # none was run
