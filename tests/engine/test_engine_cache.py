"""Where the compiled engine is kept: in the cache of the user, else in a folder for temporary files, else nowhere.

And what it does without compilation: the same to rounding, as LLVM may contract and reorder; 1e-12 of the motion, as in
the comparison with mpmath. An index out of range raises then.
"""

import json
import logging
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from lsvib.engine.kernels import event_loop, jit
from lsvib.engine.motion import bouncing

NOWHERE = "/dev/null/nowhere"  # cannot be made, not even by root


@pytest.fixture
def folders(monkeypatch, tmp_path):
    """Take away every folder of the user but one for temporary files."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", NOWHERE)
    monkeypatch.setattr(jit.tempfile, "gettempdir", lambda: str(tmp_path))
    return tmp_path


def test_the_folders_in_their_order(folders, monkeypatch):
    spare = folders / f"lsvib-{os.getuid()}" / jit.source_digest()
    assert jit.cache_folder() == spare
    assert spare.parent.stat().st_mode & 0o777 == 0o700
    monkeypatch.setenv("XDG_CACHE_HOME", str(folders / "cache"))
    assert jit.cache_folder() == folders / "cache" / "lsvib" / jit.source_digest()
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(folders / "chosen"))
    assert jit.cache_folder() == folders / "chosen"
    monkeypatch.setenv("NUMBA_CACHE_DIR", NOWHERE)
    assert jit.cache_folder() == folders / "cache" / "lsvib" / jit.source_digest()


def test_a_folder_in_which_others_can_write_is_not_used(folders):
    spare = folders / f"lsvib-{os.getuid()}"
    spare.mkdir()
    spare.chmod(0o777)
    assert jit.cache_folder() is None


def test_a_user_without_a_home(folders, monkeypatch):
    def no_home():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(jit.Path, "home", no_home)
    assert jit.cache_folder() == folders / f"lsvib-{os.getuid()}" / jit.source_digest()


def test_many_writers_of_one_cache_lose_nothing(tmp_path):
    """Each compiled version is read back as it was written, whoever else wrote at the time."""
    assert isinstance(event_loop.run_in._cache._cache_file, jit.OneWriter)

    def write(k: int) -> None:
        jit.OneWriter(str(tmp_path), "kernel", "stamp").save((k,), f"version {k}")

    with ThreadPoolExecutor(16) as pool:
        list(pool.map(write, range(200)))
    file = jit.OneWriter(str(tmp_path), "kernel", "stamp")
    assert [file.load((k,)) for k in range(200)] == [f"version {k}" for k in range(200)]


def test_compiling_is_said_once_for_each_part(caplog):
    caplog.set_level(logging.INFO, "lsvib")
    jit.notice.said -= {*jit.notice.said} - {None}  # by what this process has compiled before
    small = jit.numba.njit(lambda tables: tables.shortest_stay)
    other = jit.numba.njit(lambda tables: -tables.shortest_stay)
    for kernel in (small, other):
        kernel.py_func.__module__ = "lsvib.engine.kernels.small"
    for kernel in (small, small, other):
        for kind in ("planar", "modal"):
            kernel(bouncing(kind).tables)
    told = [record.getMessage() for record in caplog.records]
    assert [words for words in told if "rigid drives, once, about 10 s" in words] == told[:1]
    assert [words for words in told if "drives with parts, once, about 30 s" in words] == told[1:]
    assert len(told) == 2
    say = jit.sentence
    assert "mapper of rigid drives" in say("lsvib.basins.kernels.labels", "Tables(array(float64, 2d, C))")
    assert "the rule of what motions end in" in say(
        "lsvib.dynamics.kernels.sweep", "Tables(AnyFlow(array(float64, 2d, C)))"
    )
    assert say("lsvib.engine.kernels.flow_planar", "array(float64, 1d, C)") is None
    assert say("somebody.else", "Tables") is None


@pytest.mark.skipif(jit.numba.config.DISABLE_JIT, reason="nothing is compiled")
@pytest.mark.parametrize("kind", ["planar", "modal"])
def test_a_kernel_calls_the_kernel_of_the_kind_of_flow(kind):
    @jit.numba.njit
    def quarter(flow, state, out):
        event_loop.advance(flow, 0, state, 0.5 * np.pi, out)

    flow, out = bouncing(kind).tables.flow, np.empty(2)
    quarter(flow, np.array([1.0, 0.0]), out)
    np.testing.assert_allclose(out, [0.0, -1.0], atol=1e-15)


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
    """What the program prints, in a process of its own."""
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
