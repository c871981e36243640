"""The workflow as a newcomer meets it: a run, a second run, an edit, a failed check, a wrong key, a kill."""

import io
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time

import docutils.core
import pytest
import yaml
from conftest import ROOT, TINY
from tools.rule_graph import rule_graph

from benchmarks.rivals.method_list import METHODS
from lsvib.datasets.io import read_dataset
from lsvib.figures.configuration import accuracy_figures, default_figures, given, load, settings_of
from lsvib.models import chapter
from lsvib.models.drive import Drive

pytestmark = pytest.mark.workflow

ALL_FIGURES = (*default_figures(), *accuracy_figures(), "attraction", "chart")
CONFIG = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
FIGURES = ("fig8_03", "fig8_08")
ANEW = {  # what a change of figure 8.8 makes anew
    *("Analysing the drives of fig8_08", "Computing fig8_08", "Drawing fig8_08"),
    *("Collecting the checks", "Judging the checks"),
}
NEW_FIGURE = '''"""A new figure."""

import xarray as xr
from pydantic import Field

from lsvib.datasets.checks import Check
from lsvib.figures import style
from lsvib.figures.settings import DriveChanges, FigureSettings
from lsvib.models.drive import Drive

CAPTION = "The drive.\\n"


class Settings(FigureSettings):
    drive: DriveChanges = DriveChanges()
    points: int = Field(default=5, ge=2, description="Number of points.")


def build(settings):
    mass = Drive.of(settings["drive"]).mass
    words = {"units": "kg", "long_name": "mass"}
    about = {"title": "New figure", "source": "lsvib", "references": "none"}
    return xr.Dataset({"moved": ("point", [mass] * settings["points"], words)}, attrs=about)


def checks(dataset):
    return [Check.holds("The mass is positive", "a test", "all points", bool((dataset.moved > 0).all()))]


@style.styled
def draw(dataset):
    figure = style.new_figure()
    figure.add_subplot().plot(dataset.moved)
    return figure
'''


def test_a_run_makes_everything_and_says_where(finished):
    project, printed = finished
    results = project.folder / "results"
    for figure in FIGURES:
        assert (results / "figures" / f"{figure}.png").read_bytes().startswith(b"\x89PNG")
        assert (results / "figures" / f"{figure}.pdf").read_bytes().startswith(b"%PDF")
        assert read_dataset(results / "datasets" / f"{figure}.nc").attrs["Conventions"] == "CF-1.11"
    claims = re.findall("^- pass: .+$", (results / "checks.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert len(claims) > 9
    (mass,) = [line for line in printed.splitlines() if line.startswith("critical mass")]
    assert mass.split()[2:8] == ["printed", "10.1", "kg", "computed", "10.107", "kg"]
    (passed,) = re.findall(r"Passed: (.*?)\.\n", printed, re.DOTALL)
    parts = [part.split() for part in passed.split(",")]
    assert {figure for figure, _ in parts} == set(FIGURES)
    assert sum(int(count.split("/")[0]) for _, count in parts) == len(claims)
    assert "Figures: results/figures" in printed
    assert "Computing fig8_03" in printed
    assert "(100%) done" in printed
    assert f"All {len(claims)} checks passed." in printed.splitlines()[-4:]
    checks = json.loads((results / "checks.json").read_text(encoding="utf-8"))
    assert {check["figure"] for check in checks} == set(FIGURES)
    assert all(check["passed"] for check in checks)
    assert len(claims) == len(checks)


@pytest.mark.parametrize(
    ("files", "jobs"),
    [
        # Neither figure reaches the engine.
        (("figures/style", "engine/kernels/event_loop"), {"Drawing fig8_03", "Drawing fig8_08"}),
        (("stability/conditions",), ANEW),  # imported by figure 8.8 only
        (("models/mechanics",), ANEW | {"Computing fig8_03", "Drawing fig8_03"}),
    ],
)
def test_an_edit_reruns_what_depends_on_it_and_nothing_else(built, files, jobs):
    for file in files:
        built.edit(f"src/lsvib/{file}.py", '"""\n', '"""\n# an edit\n')
    assert built.plan() == jobs


def test_a_changed_claim_reruns_the_figure_that_names_it(built):
    built.edit("src/lsvib/models/chapter.yaml", "Below m_cr both eigenvalues", "Below m_cr the two eigenvalues")
    assert built.plan() == ANEW - {"Analysing the drives of fig8_08"}


@pytest.mark.slow
def test_a_draft_of_all_figures_is_a_few_processes(fresh):
    """Each with several figures; the target ``accuracy`` of a draft has its own jobs."""
    names = ", ".join(default_figures())
    fresh.edit("config/config.yaml", "figures: [fig8_03, fig8_08]", f"figures: [{names}]")
    jobs = [job for job in fresh.plan("--configfile", "config/draft.yaml") if "omputing" in job or "Drawing" in job]
    assert len(jobs) == 4
    assert sorted(", ".join(job.removeprefix("Computing and drawing ") for job in jobs).split(", ")) == sorted(
        default_figures()
    )


def test_engine_is_compiled_first_for_the_figures_that_need_it(fresh):
    """A figure waits for the parts of the engine that its model needs; those of eigenvalues wait for none."""
    figures = default_figures()
    assert {f"fig8_{n:02}" for n in range(1, 16)} <= set(figures)
    run = fresh("-n", *(f"results/datasets/{figure}.nc" for figure in figures))
    reasons = dict(re.findall(r"^Job \d+: Computing (\w+)\nReason: (.*)$", run.stdout, re.MULTILINE))
    assert set(reasons) == set(figures)
    waiting = {
        part: {figure for figure, reason in reasons.items() if f"results/engine/{part}.txt" in reason}
        for part in ("planar", "modal", "mapper")
    }
    of_eigenvalues = {"nut_stability", "contact_stability", *(f"fig8_{n}" for n in ("03", "08", "15"))}
    of_two_states = {f"fig8_{n}" for n in ("01", "02", "04", "05", "06", "07", "09", "11", "12", "14")}
    of_more_states = {"fig8_10", "fig8_13"}
    assert waiting["planar"] >= of_two_states | of_more_states
    assert waiting["modal"] >= of_more_states
    assert waiting["mapper"] == {"fig8_14"}
    assert waiting["planar"].isdisjoint(of_eigenvalues)
    assert waiting["modal"].isdisjoint(of_eigenvalues | of_two_states)


@pytest.mark.slow
def test_a_figure_that_is_built_alone_fails_with_its_checks(built):
    change = "--config", "table_8_1={friction_coefficient: 0.23}"
    for _ in range(2):  # and again when it is asked for again
        run = built("results/figures/fig8_08.png", *change)
        assert run.returncode == 1, run.stdout
    assert "1 check failed; the pictures lie in results/failed.\nfig8_08: Critical mass" in run.stdout
    assert "Done." not in run.stdout
    folder = built.folder / "results"
    assert (folder / "failed" / "fig8_08.png").is_file()
    assert not (folder / "figures" / "fig8_08.png").exists()


@pytest.mark.parametrize(
    ("change", "jobs"),
    [
        pytest.param("fig8_08={dampings: [1.0e-4, 1.0e-3]}", {"fig8_08"}, marks=pytest.mark.slow),
        ("table_8_1={pitch_radius: 5.2e-3}", {"fig8_03", "fig8_08"}),
    ],
)
def test_the_command_line_changes_a_figure_and_the_drive_of_all(built, change, jobs):
    assert {job for job in built.plan("--config", change) if job.startswith("Computing ")} == {
        f"Computing {figure}" for figure in jobs
    }


def test_the_table_of_the_configuration_is_the_default_drive():
    assert Drive.of(CONFIG["table_8_1"]) == Drive()
    assert set(CONFIG["table_8_1"]) == {*chapter.STATED["Table 8.1"]} - {"lead_angle"} | {"lead_angle_deg"}


@pytest.mark.slow
def test_the_rules_are_those_that_the_picture_shows():
    dataset = {"figure", "check", "all"}  # for what waits for a dataset
    assert rule_graph(ROOT) == {
        "core": {"map", "dataset"}, "analyse": {"dataset"}, "map": {"dataset"}, "dataset": dataset,
        "figure": {"all"}, "check": {"verdict", "all"}, "verdict": {"all"}, "all": set(),
    }  # fmt: skip


@pytest.mark.slow
def test_both_snakefiles_are_one_workflow(built):
    assert built.plan("-s", "workflow/Snakefile") == set()
    assert "Nothing to be done" in built().stdout


@pytest.mark.slow
def test_a_failed_check_fails_the_run_with_the_reason(built):
    """Also where all checks have passed before; the old verdict is gone."""
    built.edit("src/lsvib/models/chapter.yaml", "value: 10.10", "value: 20.0")
    run = built()
    assert run.returncode == 1
    results = built.folder / "results"
    failed = f"1 of {len(json.loads((results / 'checks.json').read_text()))} checks"
    assert f"{failed} failed:\nfig8_08: Critical mass" in run.stdout
    assert "is NOT <= 0.008" in run.stdout
    assert f"1 job FAILED: verdict. {failed} FAILED: fig8_08." in run.stdout.splitlines()[-8:]
    assert "- FAIL: Critical mass" in (results / "checks.md").read_text(encoding="utf-8")
    assert [c["figure"] for c in json.loads((results / "checks.json").read_text()) if not c["passed"]] == ["fig8_08"]
    assert not (results / "verdict.txt").exists()


def test_what_was_deleted_comes_back(built):
    """Two files neither of which comes back because of the other."""
    for name in ("datasets/fig8_08.nc", "figures/fig8_03.pdf"):
        (built.folder / "results" / name).unlink()
    assert built.plan() >= {"Computing fig8_08", "Drawing fig8_03"}


@pytest.mark.slow
def test_a_killed_run_is_completed_by_the_next(fresh, finished):
    """SIGKILL to Snakemake and all its jobs as soon as a dataset is there; whatever is there then is whole."""
    process = fresh.start()
    try:
        deadline = time.monotonic() + 120
        while not list((fresh.folder / "results").rglob("fig8_0?.nc")) and time.monotonic() < deadline:
            time.sleep(0.01)
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    results, reference = fresh.folder / "results", finished[0].folder / "results"
    assert not (results / "verdict.txt").exists()
    run = fresh()
    assert run.returncode == 0, run.stdout
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
    assert not list((fresh.folder / "results").rglob("*.*"))


@pytest.mark.slow
def test_accuracy_is_a_target_of_its_own(fresh):
    """It needs packages that the others do not need."""
    jobs = fresh.plan("accuracy")
    assert jobs >= {"Compiling the engine: planar", "Computing work_precision for accuracy"}
    assert not any("fig8" in job or job == "Computing work_precision" for job in jobs)
    assert not any("accuracy" in job for job in fresh.plan())


@pytest.mark.slow
def test_all_has_the_figures_of_accuracy_at_its_own_size(fresh):
    """With nothing but what requirements.txt installs, and other settings than the target ``accuracy``."""
    fresh.edit("config/config.yaml", TINY, "")
    jobs = fresh.plan()
    both = ("work_precision", "stability_sweeps", "ablation")
    assert jobs >= {f"{verb} {figure}" for verb in ("Computing", "Drawing") for figure in both}
    for figure in both:
        assert given(CONFIG, figure) != given(CONFIG, figure, accuracy=True)
    own = given(CONFIG, "work_precision")
    assert {METHODS[name].needs for name, values in own["methods"].items() if values} == {None, "scipy"}


@pytest.mark.slow
def test_a_new_figure_is_one_new_file(built):
    """A figure with settings of its own and their defaults: the command builds it and the workflow finds it."""
    file = built.folder / "src" / "lsvib" / "figures" / "new_figure.py"
    file.write_text(NEW_FIGURE, encoding="utf-8")
    listed = "figures: [fig8_03, fig8_08, new_figure]\n"
    built.edit("config/config.yaml", TINY, listed)
    assert built.plan() == {f"{verb} new_figure" for verb in ("Computing", "Drawing")} | {
        "Collecting the checks",
        "Judging the checks",
    }
    built.edit("config/config.yaml", listed, "")
    words = [sys.executable, "-m", "lsvib", "figure", "new_figure", "--set", "mass=3"]
    subprocess.run(words, cwd=built.folder, env=built.environment, check=True, stdout=subprocess.DEVNULL)
    dataset = read_dataset(built.folder / "figures" / "new_figure.nc")
    assert json.loads(dataset.attrs["settings"]) == {
        "drive": {**CONFIG["table_8_1"], "mass": 3.0}, "points": 5
    }  # fmt: skip
    assert built.plan() >= {"Computing new_figure", "Drawing new_figure"}
    run = built("results/figures/new_figure.png")
    assert run.returncode == 0, run.stdout
    dataset = read_dataset(built.folder / "results" / "datasets" / "new_figure.nc")
    assert json.loads(dataset.attrs["settings"]) == {"drive": CONFIG["table_8_1"], "points": 5}
    with (built.folder / "config" / "config.yaml").open("a") as config:
        config.write("new_figure: {point: 6}\n")
    assert "new_figure.point is not a known key; the known keys are drive, points." in built("-n").stdout


@pytest.mark.slow
def test_lint_asks_for_nothing(fresh):
    run = fresh("--lint")
    assert run.returncode == 0, run.stdout
    assert "Congratulations, your workflow is in a good condition!" in run.stdout
    assert "Lints for" not in run.stdout


def test_every_figure_has_a_caption_and_a_section_unless_its_settings_have_defaults():
    assert all(load(figure).CAPTION.endswith("\n") for figure in ALL_FIGURES)
    sections = {name for name, section in CONFIG.items() if isinstance(section, dict)}
    assert sections <= {"table_8_1", "accuracy", *ALL_FIGURES}
    for name in set(ALL_FIGURES) - sections:
        settings_of(name)()


@pytest.mark.parametrize("figure", ALL_FIGURES)
def test_captions_are_restructured_text_without_a_complaint(figure):
    complaints = io.StringIO()
    settings = {"warning_stream": complaints, "report_level": 1}
    docutils.core.publish_doctree(load(figure).CAPTION, settings_overrides=settings)
    assert complaints.getvalue() == ""


@pytest.mark.slow
def test_results_that_were_not_made_here_do_not_pass(built):
    """Without a record, results of another configuration or a damaged one that are new enough are good to Snakemake."""
    shutil.rmtree(built.folder / ".snakemake")
    config, damaged = built.folder / "config" / "config.yaml", built.folder / "results" / "datasets" / "fig8_03.nc"
    whole = {path: (path.read_bytes(), path.stat()) for path in (config, damaged)}

    def write(path, content):
        path.write_bytes(content)
        os.utime(path, ns=(whole[path][1].st_atime_ns, whole[path][1].st_mtime_ns))

    small = next(one for one in read_dataset(damaged).variables.values() if one.ndim and one.size < 1024)
    content = bytearray(damaged.read_bytes())
    content[content.index(small.values.tobytes())] ^= 1
    write(damaged, content)
    built.edit("config/config.yaml", "  dampings: [1.0e-5, 2.0e-4, 1.0e-3, 1.0e-2]\n", "  dampings: [1.0e-5]\n")
    write(config, config.read_bytes())
    assert built.plan() == {"Judging the checks"}
    run = built()
    assert run.returncode != 0
    assert "results/datasets/fig8_08.nc was made with another configuration" in run.stdout
    assert "results/datasets/fig8_03.nc is not a readable netCDF file" in run.stdout
    for path, (content, _) in whole.items():
        write(path, content)
    assert built().returncode == 0
