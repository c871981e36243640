"""The region of attraction in tiles: the map is the same for any tiling, and made anew if its drive changes."""

import shutil

import pytest
import yaml
from conftest import ROOT, copy_of_sources

from lsvib.answers.io import read_dataset
from lsvib.answers.map import gather_map, map_tile
from lsvib.chapter.configuration import given

pytestmark = pytest.mark.workflow

MAP = "results/datasets/attraction.nc"
THREE = ("--set-scatter", "attraction=3")


@pytest.mark.slow
def test_a_map_in_tiles_is_the_map(tmp_path):
    """With three tiles the jobs are three, and the labels and times those of one tile; a changed drive maps anew.

    60 x 40 cells, in a project that shares the sources of this checkout, and with them its compiled kernels.
    """
    project = copy_of_sources(tmp_path / "project")
    shutil.rmtree(project.folder / "src")
    (project.folder / "src").symlink_to(ROOT / "src")
    project.environment["PYTHONPATH"] = str(ROOT / "src")
    project.edit("config/config.yaml", "stop: 0.3, count: 400", "stop: 0.3, count: 60")
    project.edit("config/config.yaml", "stop: 150.0, count: 400", "stop: 150.0, count: 40")
    run = project(MAP, *THREE)
    assert run.returncode == 0, run.stdout
    assert run.stdout.count("Mapping tile") == 3
    config = yaml.safe_load((project.folder / "config/config.yaml").read_text(encoding="utf-8"))
    settings = {key: value for key, value in given(config, "attraction").items() if key != "tiles"}
    map_tile(settings, "1-of-1", tmp_path / "tile.nc", 1)
    gather_map(settings, [tmp_path / "tile.nc"], tmp_path / "one.nc")
    one, three = (read_dataset(path).drop_attrs() for path in (tmp_path / "one.nc", project.folder / MAP))
    assert three.identical(one)
    (project.folder / "change.yaml").write_text("attraction: {drive: {mass: 10.9}}")
    jobs = {*(f"Mapping tile {k}-of-3" for k in (1, 2, 3)), "Gathering the tiles"}
    assert project.plan(MAP, *THREE, "--configfile", "change.yaml") == jobs
