"""The examples of the README and of the page of the commands run as they stand: the shell, the scene, the Python."""

import math
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

import lsvib
from lsvib.answers.io import read_dataset

ROOT = Path(__file__).parents[2]
PAGES = ("README.md", "docs/command.md", "docs/python.md")
README = "".join((ROOT / name).read_text(encoding="utf-8") for name in PAGES)


def blocks(part: str, language: str) -> list[str]:
    """Code of a language between two markers of these pages."""
    (text,) = re.findall(rf"<!-- {part} -->(.*?)<!-- /{part} -->", README, re.DOTALL)
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


(SHELL,), (SCENE,), (PYTHON,) = blocks("cli", "bash"), blocks("cli", "yaml"), blocks("python", "python")
COMMANDS = re.sub(r"\\\n\s*", "", SHELL).splitlines()  # a command may go on in the next line


@pytest.fixture
def shell(run, tmp_path):
    """Run a command as a reader would type it, in a folder with what a clone has that the examples read."""
    shutil.copytree(ROOT / "config", tmp_path / "config")
    (tmp_path / "scene.yaml").write_text(SCENE, encoding="utf-8")

    def call(line: str) -> str:
        """What it prints; what it says it writes is there, and can be read."""
        program, *arguments = line.split()
        assert program == "lsvib"
        code, out, error = run(*arguments)
        assert code == 0, error
        assert out
        for name in re.findall(r"--out (\S+)", line):
            assert (tmp_path / name).exists()
            if name.endswith(".nc"):
                assert read_dataset(tmp_path / name).sizes
        return out

    return call


@pytest.mark.parametrize("line", COMMANDS, ids=lambda line: line.split()[1])
def test_command(line, shell):
    assert shell(line)


def test_the_scene_is_the_command_with_other_outputs(shell, tmp_path):
    """``lsvib simulate --scene`` as in the text; the same drive, start and duration as in the line of the shell."""
    (line,) = re.findall(r"`(lsvib simulate --scene scene\.yaml [^`]*)`", README)
    shell(line)
    (tmp_path / "motion.nc").rename(tmp_path / "scene.nc")
    shell(next(command for command in COMMANDS if command.startswith("lsvib simulate")))
    scene, motion = read_dataset(tmp_path / "scene.nc"), read_dataset(tmp_path / "motion.nc")
    assert {*yaml.safe_load(SCENE)["outputs"]} <= set(scene.data_vars)
    for name in ("u", "w", "event_time"):
        assert (scene[name].values == motion[name].values).all()


def test_the_frequency_of_a_noise_is_that_of_an_eigenvalue(shell):
    """The line of the recipe, whose text says 600 Hz."""
    text = (ROOT / "docs" / "recipes.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"`(lsvib stability [^`]*)`", text)
    rate, hertz = re.search(r"\+([\d.]+)i 1/s, ([\d.]+) Hz", shell(line)).groups()
    assert float(hertz) == pytest.approx(float(rate) / (2 * math.pi), rel=1e-5) == pytest.approx(600, rel=1e-3)


def test_python(tmp_path):
    done = subprocess.run([sys.executable, "-c", PYTHON], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    motion, thresholds = done.stdout.splitlines()
    deviation, events = motion.split()
    assert float(deviation) >= 0.1
    assert int(events) > 0
    mass, force = map(float, thresholds.split())
    assert mass == pytest.approx(10.10, rel=0.02)
    assert force == pytest.approx(34.5, rel=0.02)


def test_the_first_result_is_what_the_readme_says(shell):
    """The line of the first screen, its answer in the words that are quoted below it, and the mass that it names."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"^\.venv/bin/(lsvib stability .*)$", text, re.MULTILINE)
    (below,) = re.findall(r"^This answers (.*?)\n\n", text, re.DOTALL | re.MULTILINE)
    answer = shell(line).splitlines()
    first, last = re.findall(r"`([^`]*)`", " ".join(below.split()))[:2]
    assert (answer[0], answer[-1].strip()) == (first, last)
    (named, unstable) = re.findall(r"([\d.]+) kg", below)
    critical = lsvib.Drive().threshold("kinematic_constraint").value
    assert f"{critical:.1f}" == named
    assert critical < float(unstable) == float(line.rpartition("mass=")[2])


def test_the_front_page_of_the_site_begins_as_the_readme():
    """The same first sentences, and the same lines to install it and to get a first result."""
    text, site = ((ROOT / name).read_text(encoding="utf-8") for name in ("README.md", "docs/site/index.rst"))
    first = text.split("\n\n")[1]
    assert " ".join(first.split()) in " ".join(site.split())
    install = re.search(r"```bash\n(.*?)```", text, re.DOTALL)[1].splitlines()
    assert [line for line in install if f"   {line}\n" not in site] == []


def test_the_readme_names_what_is_declared(shell):
    """The Python that it asks for, its extras, its licence; and the page of the shell has every command."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    assert f"Python {project['requires-python'].replace('>=', '≥ ')} with pip" in text
    assert "Operating System :: POSIX :: Linux" in project["classifiers"]
    assert "tested on Linux" in text
    extras = set(re.findall(r"pip install '\.\[(\w+)\]'", text))
    assert extras == {"explore", "assess"} <= set(project["optional-dependencies"])
    assert all((ROOT / name).is_file() for name in re.findall(r"examples/\w+\.yaml", text))
    assert project["license"] == (ROOT / "LICENSE").read_text(encoding="utf-8").split()[0] == "MIT"
    page = (ROOT / "docs" / "command.md").read_text(encoding="utf-8")
    shown = shell("lsvib --help")
    commands = re.findall(r"^│ (\w+) ", shown, re.MULTILINE)
    assert {"assess", "explore", "simulate", "stability"} <= set(commands)
    assert [command for command in commands if f"lsvib {command}" not in page] == []
