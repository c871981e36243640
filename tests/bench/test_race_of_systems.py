"""The race of systems of one's own: what is timed is the same motion, and the truth is one."""

import numpy as np
import pytest

from benchmarks import own_systems


@pytest.mark.slow
def test_lsvib_and_scipy_end_where_the_march_ends(monkeypatch):
    monkeypatch.setattr(own_systems, "END", 12.0)
    for system, true in own_systems.true_states().items():
        for method, error in (("lsvib", 1e-13), ("scipy", 1e-9)):  # of scipy by its tolerance, 1e-12 a step
            state = getattr(own_systems, f"{system}_{method}")()()
            assert np.asarray(state) == pytest.approx(true, abs=error * np.abs(true).max())
