"""Malformed inputs of all commands, files and the Python interface: one sentence, exit code 2, nothing written."""

import os
import sys
from pathlib import Path

import pytest
import yaml
from references.malformed import ARGUMENTS, FIGURES, PYTHON, SCENES, SECTIONS, SETTINGS, START

import lsvib
from lsvib.command.app import main


def test_the_list_is_long():
    assert len(ARGUMENTS) + len(SCENES) + len(SECTIONS) + len(FIGURES) + len(PYTHON) >= 300
    assert len({tuple(arguments) for arguments, _ in ARGUMENTS}) == len(ARGUMENTS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder of files, links, a pipe: nothing in it may change."""
    path = tmp_path_factory.mktemp("inputs")
    (path / "folder").mkdir()
    (path / "scene.yaml").write_text(START)
    for name in ("text", "text.png"):
        (path / name).write_text("my thesis")
    links = {
        "loop": "loop",
        "to_text": "text",
        "to_null": "/dev/null",
        "to_null.png": "/dev/null",
        "to_scene": "scene.yaml",
    }
    for name, target in links.items():
        (path / name).symlink_to(target)
    (path / "hard_scene").hardlink_to(path / "scene.yaml")
    os.mkfifo(path / "pipe")
    return path


@pytest.fixture
def refused(folder, monkeypatch, capsys):
    """Run a command that must be refused: code 2, one sentence, empty output, no file changed; the sentence."""
    monkeypatch.chdir(folder)

    def call(arguments: list[str]) -> str:
        before = state_of(folder)
        monkeypatch.setattr(sys, "argv", ["lsvib", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        out, error = capsys.readouterr()
        assert (end.value.code, out) == (2, "")
        assert error.startswith("lsvib: ")
        assert error.endswith(".\n")
        assert error.count("\n") == 1
        assert len(error) < 900
        assert state_of(folder) == before
        return error

    return call


def state_of(folder: Path) -> dict[str, tuple]:
    states = {path: path.lstat() for path in folder.rglob("*")}
    return {
        str(path): (s.st_ino, s.st_mode, s.st_size, s.st_mtime_ns) for path, s in states.items() if path.suffix != ".in"
    }


@pytest.mark.parametrize(("arguments", "word"), ARGUMENTS)
def test_command(refused, arguments, word):
    assert word in refused(arguments)


@pytest.mark.parametrize(("text", "word"), SCENES)
def test_scene(refused, text, word):
    """A key of the scene stands where the complete scene has it; the rest of it is right."""
    keys = {line.split(":")[0] for line in text.splitlines()}
    rest = "".join(line + "\n" for line in START.splitlines() if line.split(":")[0] not in keys)
    whole = (
        text + rest
        if text.startswith(("drive: {", "start:", "duration", "samples", "physics", "outputs", "resume"))
        else text
    )
    Path("scene.in").write_text(whole)
    assert word in refused(["simulate", "--scene", "scene.in", "--out", "x.nc"])


@pytest.mark.parametrize(("place", "value", "word"), SECTIONS)
def test_section_of_a_figure(refused, place, value, word):
    section = yaml.safe_load(yaml.safe_dump(SETTINGS["fig8_08"]))
    inner = section
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    Path("settings.in").write_text(yaml.safe_dump({"figures": ["fig8_08"], "fig8_08": section}))
    assert word in refused(["figure", "8.8", "--config", "settings.in"])


@pytest.mark.parametrize(("text", "word"), FIGURES)
def test_settings_of_figures(refused, text, word):
    Path("settings.in").write_text(text)
    assert word in refused(["figure", "8.8", "--config", "settings.in"])


@pytest.mark.parametrize(("call", "word"), PYTHON)
def test_python(folder, monkeypatch, call, word):
    monkeypatch.chdir(folder)
    before = state_of(folder)
    with pytest.raises(lsvib.LsvibError) as error:
        call()
    sentence = str(error.value)
    assert word in sentence
    assert sentence.endswith(".")
    assert "\n" not in sentence
    assert len(sentence) < 900
    assert state_of(folder) == before
