"""The engine's kernels as plain Python: the same motion to rounding.

Each way runs in a process of its own. Without compilation an index out of range raises. LLVM may contract and reorder,
so the results agree to rounding: 1e-12 of the motion, as in the comparison with mpmath.
"""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

PROGRAM = """
import json
from lsvib.dynamics.attractor import steady_state
from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.rigid import rigid_automaton

results = []
for mass, force, c_x, rule in (
    (1.0, 40.0, 1e3, "contact_sign"), (11.0, 50.0, 0.0, "contact_sign"), (15.0, -20.0, 0.0, "at_once")
):
    automaton = rigid_automaton(Drive.of(mass=mass, axial_force=force, translation_damping=c_x), resume=rule)
    motion = follow(automaton, (0.05, 10.0), 0.05)
    states, modes = motion.at([0.0, 0.01, 0.02, 0.05])
    results.append([motion.time.tolist(), motion.kind.tolist(), states.tolist(), modes.tolist()])
cycle = steady_state(rigid_automaton(Drive.of(axial_force=25.0, translation_damping=1e3)), (0.05, 5.0))
results.append([[cycle.period, cycle.amplitude, float(cycle.multiplier)], [int(cycle.label)], [], []])
print(json.dumps(results))
"""


def results(**environment):
    environment = {**os.environ, **environment}
    run = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, env=environment)
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


@pytest.mark.slow
def test_same_motion_without_compilation(tmp_path):
    compiled, plain = results(), results(NUMBA_CACHE_DIR=str(tmp_path), NUMBA_DISABLE_JIT="1")
    for (times, kinds, states, modes), expected in zip(plain, compiled, strict=True):
        assert kinds == expected[1]
        assert modes == expected[3]
        # The multiplier is a difference quotient of step 1e-5: rounding over the step.
        np.testing.assert_allclose(times, expected[0], rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(states, expected[2], rtol=1e-12, atol=1e-12)
