"""The comparison under a friction law: every method follows the motion that the reference follows."""

import pytest

from benchmarks.friction_law import compared


@pytest.mark.slow
def test_every_method_has_the_period():
    pytest.importorskip("heyoka", reason="heyoka is not installed; the extra accuracy has it")
    pytest.importorskip("sksundae", reason="scikit-sundae is not installed; the extra accuracy has it")
    errors = {name: error for name, (error, _) in compared(repeats=1).items()}
    limits = {"lsvib": 1e-15, "heyoka 1e-08": 1e-9, "heyoka 1e-12": 1e-12, "heyoka 2e-16": 1e-13, "CVODE 1e-08": 1e-6,
              "CVODE 1e-12": 1e-10}  # fmt: skip
    assert all(error <= limits.pop(name) for name, error in errors.items())
    assert not limits
