"""The search for worst cases: draws that make cases again, and hypothesis as a second searcher."""

import math

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, target
from hypothesis import strategies as st
from mpmath import mp, mpf
from references.threads_digits import ThreadsTrueDrive

from benchmarks.record import Verdict
from benchmarks.sweeps.case_judge import TOLERANCE
from benchmarks.sweeps.cases import cases
from benchmarks.sweeps.cases_threads import coinciding
from benchmarks.sweeps.families import CaseFamily, CaseGroup
from benchmarks.sweeps.worst_case import GENES, Draws, attempt, search
from lsvib.drives.parameters import ThreadsParameters

GENOMES = st.lists(st.floats(0.0, 1.0, exclude_max=True), min_size=GENES, max_size=GENES)
GOOD = {Verdict.RIGHT, Verdict.CORNER, Verdict.BEYOND_INPUT}


@pytest.mark.parametrize("family", CaseFamily)
def test_draws_make_a_case_again(family):
    genes = np.random.default_rng(family).random(GENES)
    first, again = (next(cases(family, 1, Draws(genes))) for _ in range(2))
    assert first == again
    assert first.family == family


def test_draws_are_those_of_a_generator():
    draws = Draws([0.0, 0.999, 0.5, 0.25])
    assert [draws.integers(3), draws.integers(8, 14), draws.uniform(-1, 1), draws.choice("abcd")] == [0, 13, 0.0, "b"]
    assert draws.used == 4
    assert 0 <= draws.random() < 1


def test_search_keeps_the_worst():
    """It never loses the worst case that it was given."""
    rng = np.random.default_rng(3)
    begin = [attempt(CaseFamily.TIME_SPAN, rng.random(GENES), rng, by_reference=True) for _ in range(8)]
    found = search(CaseFamily.TIME_SPAN, begin, 6, rng)
    assert found.error >= max(tried.error for tried in begin)
    assert found.case == next(cases(CaseFamily.TIME_SPAN, 1, Draws(found.genes)))
    assert found.outcome.verdict in GOOD


def judged(family: CaseFamily, genes: list[float]) -> float:
    tried = attempt(family, genes, np.random.default_rng(0), by_reference=True)
    assert tried.outcome.verdict in GOOD, (tried.case, tried.outcome)
    if tried.error > 0:
        target(math.log10(tried.error), label="error")
    return tried.error


@settings(max_examples=12, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(GENOMES)
def test_hypothesis_finds_no_wrong_translation_damping(genes):
    assert judged(CaseFamily.TRANSLATION_DAMPING, genes) <= TOLERANCE


@pytest.mark.parametrize(
    "examples", [pytest.param(25, marks=pytest.mark.long), pytest.param(150, marks=pytest.mark.long)]
)
@pytest.mark.parametrize("family", CaseFamily)
def test_hypothesis_finds_no_wrong_case(family, examples):
    @settings(max_examples=examples, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
    @given(GENOMES)
    def run(genes):
        assert judged(family, genes) <= TOLERANCE

    run()


@pytest.mark.parametrize(
    ("group", "count"), [(CaseGroup.DOUBLE_BY_DAMPING, 2), (CaseGroup.DOUBLE_BY_STIFFNESS, 2), (CaseGroup.TRIPLE, 3)]
)
@pytest.mark.parametrize("law", [1, -1])
def test_rates_coincide(law, group, count):
    """n rates that coincide but for the rounding of a parameter, 1e-16, lie within about its n-th root: 1e-7, 1e-4."""
    for damping in (2e-4, 5e-3):
        drive = ThreadsParameters.of(mass=3.0, support_damping=damping, translation_damping=300.0, axial_force=50.0)
        found = coinciding(drive, law, group, 1e5)
        assert found or damping == 2e-4  # too little of it for three
        for stiffness, rate in found:
            rates = rates_of(drive.replace(contact_stiffness=stiffness, contact_damping=rate), law)
            gaps = [sorted(abs(a - b) / abs(a) for b in rates) for a in rates]
            assert min(gap[count - 1] for gap in gaps) < (1e-6 if count == 2 else 1e-3)


def rates_of(drive, law):
    """Roots of the characteristic polynomial of slip, from Newton's laws in 40 digits."""
    with mp.workdps(40):
        reference = ThreadsTrueDrive({key: mpf(value) for key, value in drive})
        return list(reference.fields[law][0])
