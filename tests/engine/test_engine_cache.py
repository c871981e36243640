"""Where the compiled engine is kept: in the cache of the user, else in a folder for temporary files, else nowhere."""

import os
import subprocess
import sys

import pytest

from lsvib.engine.kernels import jit

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


@pytest.mark.slow
def test_without_any_folder_the_engine_is_compiled_in_memory_and_says_so_once(tmp_path):
    program = (
        "import sys, tempfile\n"
        f"tempfile.gettempdir = lambda: {NOWHERE!r}\n"
        "sys.argv = 'lsvib simulate --initial u=0.1 w=0 --t-end 0.1 --out motion.nc'.split()\n"
        "from lsvib.command.app import main; main()\n"
    )
    environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    run = subprocess.run(
        [sys.executable, "-c", program],
        env=environment | {"XDG_CACHE_HOME": NOWHERE},
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    assert run.stderr.startswith("lsvib: No folder for the compiled engine can be written")
    assert run.stderr.count("\n") == 1
    assert (tmp_path / "motion.nc").is_file()
