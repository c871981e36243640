"""The region of attraction in tiles: any tiling, a kill on the way, a change of the map."""

import os
import shutil
import signal
import time

import pytest
from conftest import ROOT, copy_of_sources

from lsvib.data.writer import read_dataset

pytestmark = pytest.mark.workflow

MAP = "results/attraction/map.nc"
TILES = 6


@pytest.fixture(scope="module")
def mapped(tmp_path_factory):
    """Return a project in which a map of 60 x 40 cells has been made in one tile.

    It shares its sources with this checkout, so that the kernels that the other tests compiled serve here too.
    """
    project = copy_of_sources(tmp_path_factory.mktemp("mapped") / "project")
    shutil.rmtree(project.folder / "src")
    (project.folder / "src").symlink_to(ROOT / "src")
    project.environment["PYTHONPATH"] = str(ROOT / "src")
    project.edit("config/config.yaml", "stop: 0.3, count: 400", "stop: 0.3, count: 60")
    project.edit("config/config.yaml", "stop: 150.0, count: 400", "stop: 150.0, count: 40")
    project.edit("config/config.yaml", "tiles: 4", "tiles: 1")
    run = project(MAP)
    assert run.returncode == 0, run.stdout
    return project


@pytest.mark.slow
def test_a_changed_map_is_computed_again(mapped):
    assert mapped.plan(MAP) == set()
    for change in ("grid: {u: {count: 61}}", "drive: {mass: 10.9}"):
        (mapped.folder / "change.yaml").write_text(f"attraction: {{{change}}}")
        assert mapped.plan(MAP, "--configfile", "change.yaml") == {
            "Compiling the mapper",
            "Mapping tile 1-of-1",
            "Gathering the tiles",
        }


def finished_tiles(project):
    """Return the tiles that are complete, with what tells a file from one that was written anew."""
    tiles = (project.folder / "results" / "attraction" / "tiles").glob("[0-9]*-of-6.nc")
    return {tile.name: (tile.stat().st_ino, tile.stat().st_mtime_ns) for tile in tiles}


@pytest.mark.long
def test_a_killed_run_goes_on_with_the_tiles_that_are_missing(mapped):
    """SIGKILL to Snakemake and all its jobs when some tiles are there; the map is that of the run in one tile."""
    reference = read_dataset(mapped.folder / MAP)
    in_six = (MAP, "--set-scatter", f"attraction={TILES}", "--notemp")
    process = mapped.start(*in_six)
    try:
        deadline = time.monotonic() + 120
        while len(finished_tiles(mapped)) < 4 and time.monotonic() < deadline:
            time.sleep(0.02)
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    before = finished_tiles(mapped)
    assert 4 <= len(before) < TILES
    run = mapped(*in_six)
    assert run.returncode == 0, run.stdout
    after = finished_tiles(mapped)
    assert len(after) == TILES
    kept = {name for name in before if after[name] == before[name]}
    # What ended in the last moment, two jobs at most, Snakemake had not yet noted as complete.
    assert len(kept) >= len(before) - 2
    assert run.stdout.count("Mapping tile") == TILES - len(kept)
    again = read_dataset(mapped.folder / MAP)
    assert again.identical(reference)
