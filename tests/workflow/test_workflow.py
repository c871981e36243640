"""The workflow as a newcomer meets it: a run, a second run, an edit, a failed check, a wrong key, a kill, a module."""

import json
import os
import re
import shutil
import signal
import time

import docutils.core
import pytest
import yaml
from conftest import ROOT, TINY, Project
from tools.rule_graph import rule_graph

from benchmarks.rivals.method_list import METHODS
from lsvib import Drive
from lsvib.answers.io import read_dataset
from lsvib.chapter.configuration import BENCHMARKS, FIGURES, given, load
from lsvib.drives import chapter

pytestmark = pytest.mark.workflow

ALL_FIGURES = (*FIGURES, *BENCHMARKS, "attraction", "chart")
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
BUILT = ("fig8_03", "fig8_08")
OF_8 = {"Analysing the drives of fig8_08", "Computing fig8_08", "Drawing fig8_08", "Collecting the checks"}
ANEW = OF_8 | {"Computing fig8_03", "Drawing fig8_03"}
MODULE = """
configfile: "config/config.yaml"

module lsvib:
    snakefile: "{snakefile}"
    config: config

use rule * from lsvib
"""


def test_a_run_makes_everything_and_says_what_it_found(finished):
    project, printed = finished
    results = project.folder / "results"
    for figure in BUILT:
        assert (results / "figures" / f"{figure}.png").read_bytes().startswith(b"\x89PNG")
        assert (results / "figures" / f"{figure}.pdf").read_bytes().startswith(b"%PDF")
    page = (results / "checks.md").read_text(encoding="utf-8").partition("## Numbers")[2]
    claims = re.findall("^- pass, .+$", page, re.MULTILINE)
    assert len(claims) > 9
    (mass,) = [line for line in printed.splitlines() if line.startswith("critical mass")]
    assert mass.split()[2:8] == ["printed", "10.10", "kg", "computed", "10.107", "kg"]
    (passed,) = re.findall(r"Passed: (.*?)\.\n", printed, re.DOTALL)
    parts = [part.split() for part in passed.split(",")]
    assert {figure for figure, _ in parts} == set(BUILT)
    assert sum(int(count.split("/")[0]) for _, count in parts) == len(claims)
    assert f"All {len(claims)} checks passed." in printed
    assert "(100%) done" in printed
    checks = json.loads((results / "checks.json").read_text(encoding="utf-8"))
    assert [check["passed"] for check in checks] == [True] * len(claims)


def test_an_edit_of_the_package_makes_everything_anew(built):
    assert built.plan() == set()
    built.edit("src/lsvib/systems/kernels/event_loop.py", '"""\n', '"""\n# an edit\n')
    assert built.plan() == ANEW


@pytest.mark.parametrize(
    ("change", "jobs"),
    [
        pytest.param("fig8_08={dampings: [1.0e-4, 1.0e-3]}", OF_8, marks=pytest.mark.slow),
        ("table_8_1={pitch_radius: 5.2e-3}", ANEW),
    ],
)
def test_the_command_line_changes_a_figure_and_the_drive_of_all(built, change, jobs):
    """And to ask what would be done leaves all files as they are."""
    before = built.files()
    assert built.plan("--config", change) == jobs
    assert built.files() == before


def test_the_table_of_the_configuration_is_the_default_drive():
    assert Drive.of(CONFIG["table_8_1"]) == Drive()
    assert set(CONFIG["table_8_1"]) == {*chapter.STATED["Table 8.1"]} - {"lead_angle"} | {"lead_angle_deg"}


@pytest.mark.slow
def test_the_rules_are_those_that_the_picture_shows():
    assert rule_graph(ROOT) == {
        "core": {"map", "dataset"}, "analyse": {"dataset"}, "map": {"dataset"},
        "dataset": {"figure", "check", "verdict"}, "figure": {"verdict"}, "check": {"verdict"}, "verdict": set(),
    }  # fmt: skip


@pytest.mark.slow
def test_a_failed_check_fails_the_run_with_the_reason(built):
    """Also where all checks have passed before, and again in the next run; a figure built alone says it, too."""
    built.edit("src/lsvib/drives/chapter.yaml", "value: 10.10", "value: 20.0")
    assert "A check failed. fig8_08: Critical mass" in built("results/figures/fig8_08.png").stdout
    for _ in range(2):
        run = built()
        assert run.returncode == 1
        assert re.search(r"1 of \d+ checks FAILED: fig8_08\.", run.stdout)
        assert re.search(r"fig8_08: Critical mass.* is NOT <= 0\.008", run.stdout)
    results = built.folder / "results"
    assert "- FAIL, `fig8_08.critical_mass`: Critical mass" in (results / "checks.md").read_text(encoding="utf-8")
    assert [c["figure"] for c in json.loads((results / "checks.json").read_text()) if not c["passed"]] == ["fig8_08"]


def test_what_was_deleted_comes_back(built):
    """Two files neither of which comes back because of the other."""
    for name in ("datasets/fig8_08.nc", "figures/fig8_03.pdf"):
        (built.folder / "results" / name).unlink()
    assert built.plan() >= {"Computing fig8_08", "Drawing fig8_03"}


def wait_for_a_dataset(project: Project) -> None:
    deadline = time.monotonic() + 120
    while not list((project.folder / "results").rglob("datasets/fig8_0?.nc")) and time.monotonic() < deadline:
        time.sleep(0.01)


@pytest.mark.slow
def test_a_killed_run_is_completed_by_the_next(fresh, finished):
    """SIGKILL to Snakemake and all its jobs as soon as a dataset is there; whatever is there then is whole."""
    process = fresh.start()
    wait_for_a_dataset(fresh)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    run = fresh()
    assert run.returncode == 0, run.stdout
    results, reference = fresh.folder / "results", finished[0].folder / "results"
    files, made = (
        {path.relative_to(root) for path in root.rglob("*") if path.is_file() and path.suffix != ".tsv"}
        for root in (reference, results)
    )  # but for the times that jobs took
    assert made == files
    for name in files:
        if name.suffix == ".nc":
            assert read_dataset(results / name).identical(read_dataset(reference / name))
        else:
            assert (results / name).read_bytes() == (reference / name).read_bytes()


@pytest.mark.slow
def test_an_interrupted_run_says_so(fresh):
    process = fresh.start()
    wait_for_a_dataset(fresh)
    os.killpg(process.pid, signal.SIGINT)
    said, _ = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "interrupted" in said
    assert "FAILED" not in said


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("fig8_08:\n", "fig8_08:\n  typo: 1\n", "fig8_08.typo is not a known key; the known keys are drive, mass, "),
        ("mass: {start: 0.5", "mass: {start: 20.5", "it needs start < stop."),
    ],
)
def test_a_wrong_configuration_is_refused(fresh, old, new, words):
    fresh.edit("config/config.yaml", old, new)
    run = fresh()
    assert run.returncode == 1
    assert words in run.stdout
    assert "Traceback" not in run.stdout
    assert not (fresh.folder / "results").exists()


@pytest.mark.slow
def test_a_wrong_drive_is_one_sentence_and_leaves_no_file(fresh):
    fresh.edit("config/config.yaml", "fig8_08:\n  drive: {", "fig8_08:\n  drive: {friction_coefficient: 11.0")
    run = fresh("results/figures/fig8_08.png")
    assert run.returncode == 1
    assert "\nfig8_08: friction_coefficient = 11 is outside the allowed range" in run.stdout
    assert "Traceback" not in (fresh.folder / "logs" / "analyse" / "fig8_08.log").read_text()
    assert not fresh.files()


@pytest.mark.slow
def test_accuracy_is_the_same_workflow_with_other_settings(fresh):
    """Of full size, with results of its own; at the size of `all` it needs what requirements.txt installs."""
    fresh.edit("config/config.yaml", TINY, "")
    assert fresh.plan() >= {f"{verb} {figure}" for verb in ("Computing", "Drawing") for figure in BENCHMARKS}
    run = fresh("-n", "--configfile", "config/accuracy.yaml")
    assert set(re.findall(r": Computing (\w+)$", run.stdout, re.MULTILINE)) == set(BENCHMARKS) - {"measured_drive"}
    assert "results/accuracy/datasets/work_precision.nc" in run.stdout
    own = given(CONFIG, "work_precision")
    assert {METHODS[name].needs for name, values in own["methods"].items() if values} == {None, "scipy"}


@pytest.mark.slow
def test_the_workflow_is_a_module_of_another(fresh, tmp_path):
    """In another folder, with a copy of the configuration, and with results elsewhere."""
    other = Project(tmp_path / "other")
    fresh.edit("config/config.yaml", TINY, "figures: [fig8_08]\n")
    shutil.copytree(fresh.folder / "config", other.folder / "config")
    (other.folder / "Snakefile").write_text(MODULE.format(snakefile=fresh.folder / "workflow" / "Snakefile"))
    other.environment = fresh.environment
    run = other("--config", "pathvars={results: made/here}")
    assert run.returncode == 0, run.stdout
    assert re.search(r"All \d+ checks passed\.", run.stdout)
    assert (other.folder / "made" / "here" / "figures" / "fig8_08.pdf").is_file()
    assert not (other.folder / "results").exists()


@pytest.mark.slow
def test_lint_asks_for_nothing_but_conda(fresh):
    """Or a container: the environment is one of pip, by requirements.txt."""
    asked = re.findall(r"^    \* (.+)$", fresh("--lint").stdout, re.MULTILINE)
    assert set(asked) == {"Specify a conda environment or container for each rule.:"}


def test_every_figure_has_a_caption_and_a_section():
    assert all(load(figure).CAPTION.endswith("\n") for figure in ALL_FIGURES)
    sections = {name for name, section in CONFIG.items() if isinstance(section, dict)}
    assert sections == {"table_8_1", *ALL_FIGURES}


@pytest.mark.parametrize("figure", ALL_FIGURES)
def test_captions_are_restructured_text_without_a_complaint(figure):
    read = docutils.core.publish_doctree(
        load(figure).CAPTION, settings_overrides={"report_level": 1, "warning_stream": ""}
    )
    assert [*read.findall(docutils.nodes.system_message)] == []


@pytest.mark.slow
def test_results_that_were_not_made_here_do_not_pass(built):
    """Snakemake, without its records, takes them for good, also those with other settings, or sources, or damaged."""
    shutil.rmtree(built.folder / ".snakemake")
    config = ("config/config.yaml", "  dampings: [1.0e-5, 2.0e-4, 1.0e-3, 1.0e-2]\n", "  dampings: [1.0e-5]\n")
    source = ("src/lsvib/systems/kernels/event_loop.py", '"""\n', '"""\n# an edit\n')
    for (file, old, new), words in ((config, "another configuration"), (source, "other sources")):
        built.edit(file, old, new)
        run = built()
        assert run.returncode == 1
        assert re.findall(r"^Job \d+: (.+)$", run.stdout, re.MULTILINE) == ["Judging the checks"]
        assert f"results/datasets/fig8_08.nc was made {'with' if 'config' in file else 'by'} {words}" in run.stdout
        built.edit(file, new, old)
    assert built().returncode == 0
    damaged = built.folder / "results" / "datasets" / "fig8_03.nc"
    small = next(one for one in read_dataset(damaged).variables.values() if one.ndim and one.size < 1024)
    content = bytearray(damaged.read_bytes())
    content[content.index(small.values.tobytes())] ^= 1
    whole = damaged.stat()
    damaged.write_bytes(content)
    os.utime(damaged, ns=(whole.st_atime_ns, whole.st_mtime_ns))
    assert "results/datasets/fig8_03.nc is not a readable netCDF file" in built().stdout
