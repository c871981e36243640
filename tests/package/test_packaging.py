"""What the README and the metadata promise about set-up: two lines, complete pins, one version."""

import re
import tomllib
from importlib.metadata import version
from pathlib import Path

import pytest
import yaml

import lsvib

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


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
    extras = PROJECT["optional-dependencies"]

    def names(*groups: list[str]) -> set[str]:
        return {re.split("[>=]", text)[0] for group in groups for text in group}

    assert set(pins("requirements.txt")) == names(PROJECT["dependencies"], extras["workflow"], extras["assess"])
    for extra in ("dev", "solvers", "accuracy", "docs", "explore"):
        browser = {"playwright"} if extra == "explore" else set()  # of the tests alone
        assert set(pins(f"requirements-{extra}.txt")) - browser == names(extras[extra])


def test_the_version_is_in_one_place_and_the_others_agree():
    assert version("lsvib") == lsvib.__version__
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))["version"] == lsvib.__version__
    assert f"## {lsvib.__version__} " in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/design.md"])
def test_files_that_a_page_names_are_there(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    for path in set(re.findall(r"`((?:src|tests|config|workflow|docs|benchmarks|\.ci)/[\w./]+)`", text)):
        assert (ROOT / path).exists(), path
