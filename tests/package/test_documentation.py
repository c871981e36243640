"""The documentation: links lead somewhere, examples run, and the site builds without a warning and opens from disk."""

import doctest
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from references import chromium

import lsvib
from lsvib.figures.folders import default_figures

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md"), ROOT / "config" / "README.md", *ROOT.glob("workflow/**/*.md")]
)
# Those of docs/python.md run in tests/api/test_api.py.
EXAMPLES = [path for path in PAGES if ">>> " in path.read_text(encoding="utf-8") and path.name != "python.md"]
PICTURES = ROOT / "results" / "figures"
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


def test_lines_are_as_long_as_those_of_the_code():
    """Tables and pictures excepted, whose lines cannot be broken; docstrings are ruff's matter (E501)."""
    pages = [*PAGES, *(ROOT / "src").rglob("*.rst"), *(ROOT / "docs").rglob("*.rst")]
    long = [
        f"{name(page)}:{number}"
        for page in pages
        for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1)
        if len(line) > 120 and not line.startswith(("|", "![", "  |"))
    ]
    assert not long, long


@pytest.mark.parametrize("page", EXAMPLES, ids=name)
def test_the_examples_of_a_page_run(page):
    result = doctest.testfile(str(page), module_relative=False)
    assert result.attempted > 0
    assert result.failed == 0


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The pages of the site, with the pictures of a run of the workflow if there has been one, as in ``.ci/run``."""
    out = tmp_path_factory.mktemp("docs")
    drawn = all((PICTURES / f"{figure}.png").is_file() for figure in default_figures())
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
    assert {Path(page).name for page in pages if page.startswith("gallery/")} >= set(default_figures())
    reference = (site / "api.html").read_text(encoding="utf-8")
    for public in lsvib.__all__:
        if not public.startswith("__"):
            assert f'id="lsvib.{public}"' in reference
    for method in ("simulate", "attraction", "follow", "thresholds", "replace"):
        assert f'id="lsvib.ThreadsDrive.{method}"' in reference


@needs_sphinx
@pytest.mark.slow
def test_the_gallery_shows_the_pictures_of_a_run(tmp_path):
    """A script with a picture from elsewhere; a folder without all of them is refused in one sentence."""
    command = [sys.executable, str(ROOT / "docs" / "build_site.py"), str(tmp_path), "--pictures", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (1, f"docs: {tmp_path} has no picture {default_figures()[0]}.png.\n")
    assert not (tmp_path / "html").exists()
    (tmp_path / "fig8_03.png").write_bytes(b"a picture")
    sys.path.insert(0, str(ROOT / "docs" / "site"))
    try:
        from gallery import script
    finally:
        sys.path.pop(0)
    text = script("fig8_03", tmp_path / "source", tmp_path)
    assert "# .. image:: /files/figures/fig8_03.png\n" in text
    assert (tmp_path / "source" / "files" / "figures" / "fig8_03.png").read_bytes() == b"a picture"


@needs_sphinx
@pytest.mark.slow
def test_a_link_that_leads_nowhere_ends_the_build(tmp_path):
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        from build_site import on_site
    finally:
        sys.path.pop(0)
    with pytest.raises(SystemExit, match=r"docs: docs/x\.md links to nowhere\.md, which is not there"):
        on_site("see [this](nowhere.md)", "docs/x.md", tmp_path, {})
    shown = on_site("[a](../README.md) [b](figures/one_drive.png#x)", "docs/x.md", tmp_path, {"README.md": "index.rst"})
    assert shown == "[a](index.rst) [b](files/docs/figures/one_drive.png)"
    assert (tmp_path / "files" / "docs" / "figures" / "one_drive.png").is_file()


@pytest.fixture(scope="module")
def browser():
    with chromium.started() as started:
        yield started


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
