"""Malformed inputs of all commands, files and the Python interface: one sentence, exit code 2, nothing written."""

import copy
import os
from pathlib import Path

import pytest
import yaml
from references.command_line import complaint, refused, state_of_the_folder
from references.malformed import COMMANDS, PYTHON, SCENES, SECTIONS, SETTINGS


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Put files, links and a pipe into the folder in which all is run: nothing in it may change."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "scene.yaml").write_text("start: {u: 0.1, w: 0}\nduration: 1\n")
    (tmp_path / "text").write_text("my thesis")
    (tmp_path / "to_scene").symlink_to("scene.yaml")
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(("line", "words"), COMMANDS)
def test_command(run, line, words):
    assert words in refused(run, *line.split())


@pytest.mark.parametrize(("text", "words"), SCENES)
def test_scene(run, text, words):
    Path("scene.in").write_text(text)
    assert words in refused(run, "simulate", "--scene", "scene.in", "--out", "x.nc")


@pytest.mark.parametrize(("place", "value", "words"), SECTIONS)
def test_settings_of_a_figure(run, place, value, words):
    """The sentence is that of the whole configuration, with which the workflow refuses it."""
    settings = copy.deepcopy(SETTINGS)
    inner = settings["fig8_08"]
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    Path("settings.in").write_text(yaml.safe_dump(settings))
    assert words in refused(run, "figure", "8.8", "--config", "settings.in")


@pytest.mark.parametrize(("call", "words"), PYTHON)
def test_python(call, words):
    before = state_of_the_folder()
    assert words in complaint(call)
    assert state_of_the_folder() == before
