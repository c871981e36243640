"""The region of attraction in tiles: the map is the same for any tiling, and made anew if its drive changes."""

import shutil

import pytest
from conftest import ROOT, copy_of_sources

from lsvib.datasets.io import read_dataset

pytestmark = pytest.mark.workflow

MAP = "results/attraction/map.nc"


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
def test_a_map_in_tiles_is_the_map(mapped):
    """With three tiles the jobs are three, and the labels and times those of one tile; a changed drive maps anew."""
    one = read_dataset(mapped.folder / MAP)
    (mapped.folder / "change.yaml").write_text("attraction: {drive: {mass: 10.9}}")
    jobs = {"Compiling the mapper", "Mapping tile 1-of-1", "Gathering the tiles"}
    assert mapped.plan(MAP, "--configfile", "change.yaml") == jobs
    (mapped.folder / MAP).unlink()
    run = mapped(MAP, "--set-scatter", "attraction=3")
    assert run.returncode == 0, run.stdout
    assert run.stdout.count("Mapping tile") == 3
    assert read_dataset(mapped.folder / MAP).drop_attrs().identical(one.drop_attrs())
