"""Malformed inputs of all commands, files and the Python interface: one sentence, exit code 2, nothing written."""

import copy
import os
import sys
from pathlib import Path

import pytest
import yaml
from references.malformed import COMMANDS, PYTHON, SCENES, SECTIONS, SETTINGS

import lsvib
from lsvib.cli.app import main


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder of files, links, a pipe: nothing in it may change."""
    path = tmp_path_factory.mktemp("inputs")
    (path / "folder").mkdir()
    (path / "scene.yaml").write_text("start: {u: 0.1, w: 0}\nduration: 1\n")
    (path / "text").write_text("my thesis")
    (path / "to_scene").symlink_to("scene.yaml")
    os.mkfifo(path / "pipe")
    return path


@pytest.fixture
def refused(folder, monkeypatch, capsys):
    """Run a command that must be refused: code 2, one sentence, empty output, no file changed; the sentence."""
    monkeypatch.chdir(folder)

    def call(*arguments: str) -> str:
        before = state_of(folder)
        monkeypatch.setattr(sys, "argv", ["lsvib", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        out, error = capsys.readouterr()
        assert (end.value.code, out) == (2, "")
        assert error.startswith("lsvib: ")
        assert error.endswith(".\n")
        assert error.count("\n") == 1
        assert state_of(folder) == before
        return error

    return call


def state_of(folder: Path) -> dict[str, tuple]:
    states = {path: path.lstat() for path in folder.rglob("*") if path.suffix != ".in"}
    return {str(path): (s.st_ino, s.st_mode, s.st_size, s.st_mtime_ns) for path, s in states.items()}


@pytest.mark.parametrize(("line", "words"), COMMANDS)
def test_command(refused, line, words):
    assert words in refused(*line.split())


@pytest.mark.parametrize(("text", "words"), SCENES)
def test_scene(refused, text, words):
    Path("scene.in").write_text(text)
    assert words in refused("simulate", "--scene", "scene.in", "--out", "x.nc")


@pytest.mark.parametrize(("place", "value", "words"), SECTIONS)
def test_settings_of_a_figure(refused, place, value, words):
    """The sentence is that of the whole configuration, with which the workflow refuses it."""
    settings = copy.deepcopy(SETTINGS)
    inner = settings["fig8_08"]
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    Path("settings.in").write_text(yaml.safe_dump(settings))
    assert words in refused("figure", "8.8", "--config", "settings.in")


@pytest.mark.parametrize(("call", "words"), PYTHON)
def test_python(folder, monkeypatch, call, words):
    monkeypatch.chdir(folder)
    before = state_of(folder)
    with pytest.raises(lsvib.InputError) as error:
        call()
    sentence = str(error.value)
    assert words in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence
    assert state_of(folder) == before
