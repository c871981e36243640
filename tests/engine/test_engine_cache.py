"""Where the compiled engine is kept: in the cache of the user, else in a folder for temporary files, else nowhere."""

import logging
import os
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
