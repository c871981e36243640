"""The documentation: links lead somewhere, examples run, and the site builds without a warning and opens from disk."""

import doctest
import importlib.util
import json
import math
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from references import chromium

import lsvib
from lsvib.chapter.configuration import FIGURES

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), ROOT / "config" / "README.md", *ROOT.glob("profiles/**/*.md")]
)
# Those of docs/python.md run in tests/api/test_api.py.
EXAMPLES = [path for path in PAGES if ">>> " in path.read_text(encoding="utf-8") and path.name != "python.md"]
PICTURES = ROOT / "results" / "figures"


def critical_mass(inertia: float, radius: float, tan_lead: float, friction: float) -> float:
    """(8.20)."""
    return inertia * (1 + friction * tan_lead) / ((friction - tan_lead) * tan_lead * radius**2)


def trapezoidal(radius: float, lead: float) -> float:
    """The critical mass of the page of a maker: 600 mm of steel, with 0.15 on flanks of 15 degrees."""
    tan_lead = lead / (2 * math.pi * radius)
    friction = 0.15 * math.hypot(1, math.cos(math.atan(tan_lead)) * math.tan(math.radians(15)))
    return critical_mass(math.pi / 2 * 7850 * 0.6 * radius**4, radius, tan_lead, friction)


PRINTED = {  # by each script of examples: where it says a number, and what that is by the chapter or in 40 digits
    "basin_sweep": [("below (.*) N", -32.7708492344, 1e-5), ("or (.*) kg", 10.1, 0.0083)],
    "falling_friction": [("unstable from (.*) N", 88.934, 1e-5), ("chatters from (.*) N", 73, 0.03)],
    "limit_process": [("the power (.*)", -0.9, 0.1)],
    "stribeck_rise": [("0.065: vibration from (.*?) N", 20, 0.027), ("0.000: .* sticking from (.*) N", 34.5, 0.035)],
    "makers_page": [
        ("TR12x3: vibrates,.* to (.*) kg", trapezoidal(5.25e-3, 3e-3), 1e-5),
        ("TR16x4: steady,.* held, up to (.*) kg", trapezoidal(7e-3, 4e-3), 1e-5),
    ],
    "chapter_figure": [
        ("mass (.*) kg", critical_mass(3.12e-6, 5.18e-3, math.tan(math.radians(5.57)), 0.25), 1e-11),
        ("SPRAG_SLIP_CYCLE.*rad, (.*) Hz", 309.91, 1e-5),
    ],
    # of others, as the scripts cite them, and beside one of few digits what its equations give in 25
    "block_on_a_belt": [
        ("up to V = (.*?),", 1 / math.sqrt(0.04 * math.pi), 0.03),
        ("V = (.*?),", 2.739240416788, 1e-10),
    ],
    "bouncing_ball": [("over at (.*) s", (15 + 9 * math.sqrt(15**2 + 20 * 9.81)) / 9.81, 1e-14)],
    "buck_converter": [("doubling at (.*) V", 24.516, 3e-5)],
    "chua_circuit": [("exponents (.*?),", 0.23, 0.05), (", (-[.0-9]*)\n", -1.78, 0.03)],
    "coulomb_oscillator": [
        ("amplitude (.*) at", math.sqrt(0.8**2 - 0.2**2 * 4 / 3), 1e-12),
        ("0 to (.*) stops", 14, 0),
    ],
    "impact_oscillator": [("speed (.*) after", -1.36, 0.003), ("speed (.*) after", -1.3565863500759056, 1e-13)],
    "piecewise_oscillator": [("grazing at beta = (.*)", math.hypot(1 - 0.8**2, 2 * 0.05 * 0.8), 1e-14)],
    "relay": [("period (.*?),", 3.66190466725448922, 1e-14), ("amplitude (.*?),", 2 / (3 * math.pi), 0.015)],
    "two_switches": [
        ("from (.*) s on", 1 / 7, 1e-14),
        ("x.1 s. = (.*?),", 31 / 34, 1e-14),
        ("y.1 s. = (.*)", 31 / 34, 1e-14),
    ],
}
SCRIPTS = sorted((ROOT / "examples").rglob("*.py"))
SLOW = {
    *("basin_sweep", "chapter_figure", "coulomb_oscillator", "falling_friction", "limit_process", "makers_page"),
    *("piecewise_oscillator", "stribeck_rise"),
}
needs_sphinx = pytest.mark.skipif(importlib.util.find_spec("sphinx") is None, reason="Sphinx is not installed.")


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def anchors(path: Path) -> set[str]:
    """The anchors of the headings of a page, as GitHub makes them."""
    text = re.sub(r"^```.*?^```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    plain = [re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings]
    return set(plain)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_link_within_the_repository_leads_somewhere(page):
    text = page.read_text(encoding="utf-8")
    for path, anchor in re.findall(r"\]\((?!https?:|mailto:)([^)#\s]*)(?:#([^)\s]*))?\)", text):
        target = page.parent / path if path else page
        assert target.exists(), path
        assert not anchor or anchor in anchors(target), f"{path}#{anchor}"


@pytest.mark.parametrize("page", EXAMPLES, ids=name)
def test_the_examples_of_a_page_run(page):
    result = doctest.testfile(str(page), module_relative=False)
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.parametrize(
    "script", [pytest.param(x, id=x.stem, marks=pytest.mark.slow if x.stem in SLOW else ()) for x in SCRIPTS]
)
def test_a_script_runs_and_prints_what_is_known(script, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(script), run_name="__main__")
    printed = capsys.readouterr().out
    for words, value, tolerance in PRINTED[script.stem]:
        assert float(re.search(words, printed)[1]) == pytest.approx(value, rel=tolerance)
    assert (tmp_path / f"{script.stem}.png").is_file()
    assert len(script.read_text(encoding="utf-8").splitlines()) <= 40


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The pages of the site, with the pictures of a run of the workflow if there has been one, as in ``.ci/run``."""
    out = tmp_path_factory.mktemp("docs")
    drawn = all((PICTURES / f"{figure}.png").is_file() for figure in FIGURES)
    shown = ["--pictures", str(PICTURES)] if drawn else ["--without-pictures"]
    command = [sys.executable, str(ROOT / "docs" / "build_site.py"), str(out), *shown]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "PYTHONWARNINGS": "ignore"})
    assert done.returncode == 0, done.stdout + done.stderr
    assert (out / "lsvib-docs.zip").is_file()
    return out / "html"


@needs_sphinx
@pytest.mark.slow
def test_the_site_has_every_page_every_figure_and_every_public_name(site):
    pages = {path.relative_to(site).with_suffix("").as_posix() for path in site.rglob("*.html")}
    assert {path.stem for path in (ROOT / "docs").glob("*.md")} <= pages
    assert {"index", "settings", "contributing", "changelog", "parameters"} <= pages
    assert {Path(page).name for page in pages if page.startswith("gallery/")} >= {*FIGURES, *PRINTED}
    for script in SCRIPTS:  # each as a notebook, of the code that runs above
        (notebook,) = site.rglob(f"{script.stem}.ipynb")
        cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
        code, text = (
            ["".join(x["source"]) for x in cells if x["cell_type"] == "code"],
            script.read_text(encoding="utf-8"),
        )
        assert len(code) == max(1, text.count("\n# %%\n"))
        assert all(part in text for part in code)
    reference = (site / "api.html").read_text(encoding="utf-8")
    for public in lsvib.__all__:
        assert f'id="lsvib.{public}"' in reference
    for method in ("simulate", "attraction", "follow", "thresholds", "replace"):
        assert f'id="lsvib.Drive.{method}"' in reference


@needs_sphinx
@chromium.needs_chromium
@pytest.mark.slow
@pytest.mark.parametrize("width", [1300, 390])
def test_the_site_opens_from_disk_and_needs_nothing_from_elsewhere(site, browser, width):
    """The front page, a page of theory by its link, an anchor on another page, and the search."""
    with chromium.opened(browser, (site / "index.html").as_uri(), width) as page:
        page.get_by_role("link", name="validation", exact=True).click()
        page.get_by_role("heading", name="Validation: what was compared with what, and what was found").wait_for()
        assert chromium.wider_than_the_screen(page) <= 0
        page.goto((site / "command.html").as_uri())
        page.locator("a[href='lemmas.html#boundaries-of-stability-of-a-damped-drive']").first.click()
        page.get_by_role("heading", name="Boundaries of stability of a damped drive").wait_for()
        assert chromium.wider_than_the_screen(page) <= 0
        page.goto((site / "search.html").as_uri() + "?q=Painlev%C3%A9")
        page.locator("#search-results li a").first.wait_for()
