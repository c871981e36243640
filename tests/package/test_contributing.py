"""The recipes name what is there; the catalogue of workflows is told what is true."""

import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
RECIPES = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "path", sorted(set(re.findall(r"`((?:src|tests|config|workflow|docs|\.ci)/[\w./]+)`", RECIPES)))
)
def test_what_the_recipes_name_is_there(path):
    assert (ROOT / path).exists()


def test_the_recipes_lead_to_what_they_promise():
    assert re.findall("^## (.*)$", RECIPES, re.MULTILINE)[:4] == ["A figure", "A model", "A parameter", "A check"]
    assert "## One figure, one folder" in (ROOT / "docs" / "design.md").read_text(encoding="utf-8")
    assert "## Tests" in (ROOT / "README.md").read_text(encoding="utf-8")
    assert re.search(r"^ENGINE = ", (ROOT / "workflow" / "rules" / "common.smk").read_text("utf-8"), re.MULTILINE)
    assert max(map(len, RECIPES.splitlines())) <= 120


def test_the_catalogue_is_told_that_no_rule_makes_its_own_environment():
    told = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text(encoding="utf-8"))["usage"]
    rules = "\n".join(path.read_text(encoding="utf-8") for path in (ROOT / "workflow" / "rules").glob("*.smk"))
    assert told["software-stack-deployment"]["conda"] is bool(re.search(r"^    conda:", rules, re.MULTILINE))
    assert told["software-stack-deployment"]["apptainer"] is bool(re.search(r"^    container:", rules, re.MULTILINE))
    assert told["report"] is ("report(" in rules)
