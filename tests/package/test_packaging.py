"""What the README promises about set-up: two lines, complete pins, nothing but pip."""

import re
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest

import lsvib

ROOT = Path(__file__).parents[2]


def pins(name: str) -> dict[str, str]:
    lines = (ROOT / name).read_text(encoding="utf-8").splitlines()
    return dict(line.split("==") for line in lines if "==" in line)


@pytest.mark.parametrize(
    ("requirements", "program"), [("requirements.txt", "snakemake -j2"), ("requirements-dev.txt", "pytest")]
)
def test_readme_has_the_line(requirements, program):
    line = f"python3 -m venv .venv && .venv/bin/pip install -r {requirements} && .venv/bin/{program}"
    assert (ROOT / "README.md").read_text(encoding="utf-8").splitlines().count(line) == 1
    assert program.split()[0] in pins(requirements)


def test_requirements_pin_what_the_project_declares():
    with (ROOT / "pyproject.toml").open("rb") as file:
        project = tomllib.load(file)["project"]
    extras = project["optional-dependencies"]
    names = [re.split("[>=]", text)[0] for text in project["dependencies"] + extras["workflow"] + extras["assess"]]
    tools = [re.split("[>=]", text)[0] for text in extras["dev"]]
    assert set(pins("requirements.txt")) == set(names)
    assert set(pins("requirements-dev.txt")) == set(tools)
    for extra in ("solvers", "accuracy", "docs"):
        assert set(pins(f"requirements-{extra}.txt")) == {re.split("[>=]", text)[0] for text in extras[extra]}
    browser = {"playwright"}  # of the tests alone
    assert set(pins("requirements-explore.txt")) - browser == {re.split("[>=]", text)[0] for text in extras["explore"]}
    assert (ROOT / "requirements.txt").read_text(encoding="utf-8").splitlines()[-1] == "-e ."
    for name, base in (("solvers", ""), ("accuracy", "-solvers"), ("dev", "-solvers"), ("explore", ""), ("docs", "")):
        lines = (ROOT / f"requirements-{name}.txt").read_text(encoding="utf-8").splitlines()
        assert f"-r requirements{base}.txt" in lines


def test_installed_versions_are_the_pinned_ones():
    wanted = pins("requirements.txt") | pins("requirements-solvers.txt") | pins("requirements-dev.txt")
    assert {name: version(name) for name in wanted} == wanted


def test_the_version_is_in_one_place_and_the_others_agree():
    with (ROOT / "pyproject.toml").open("rb") as file:
        declared = tomllib.load(file)
    assert declared["project"]["dynamic"] == ["version"]
    assert declared["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "lsvib.__version__"}
    assert version("lsvib") == lsvib.__version__
    assert f"\nversion: {lsvib.__version__}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"## {lsvib.__version__} " in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_the_package_brings_types_settings_and_links():
    with (ROOT / "pyproject.toml").open("rb") as file:
        declared = tomllib.load(file)
    assert declared["project"]["urls"]
    package = Path(lsvib.__file__).parent
    for folder, patterns in declared["tool"]["setuptools"]["package-data"].items():
        root = package.parent / folder.replace(".", "/")
        assert all(list(root.glob(pattern)) for pattern in patterns)
    manifest = (ROOT / "MANIFEST.in").read_text(encoding="utf-8")
    for folder in ("config", "docs", "profiles", "tests", "workflow"):
        assert f"graft {folder}\n" in manifest
