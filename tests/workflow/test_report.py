"""The report of a run, in its files and in a browser: first page, pictures, captions."""

import shutil
import zipfile

import pytest
from conftest import Project
from references import chromium

pytestmark = [pytest.mark.workflow, pytest.mark.slow]


@pytest.fixture(scope="module")
def report(finished, tmp_path_factory):
    """The folder of an unpacked report, of a copy of the finished project."""
    folder = tmp_path_factory.mktemp("report")
    shutil.copytree(finished[0].folder, folder / "project")
    run = Project(folder / "project")("--report", "report.zip")
    assert run.returncode == 0, run.stdout
    with zipfile.ZipFile(folder / "project" / "report.zip") as archive:
        archive.extractall(folder)
    return folder / "report"


@pytest.fixture(scope="module")
def page(report, browser):
    """The report; that Snakemake has its style from a script which advises against that is not ours to change."""
    with chromium.opened(browser, (report / "report.html").as_uri(), known="cdn.tailwindcss.com") as opened:
        yield opened


def test_the_report_has_figures_with_captions(report):
    names = [path.name for path in report.rglob("*")]
    page = (report / "report.html").read_text(encoding="utf-8")
    assert all(any(name.endswith(f"{figure}.png") for name in names) for figure in ("fig8_03", "fig8_08"))
    assert "nodes and foci meet on the black curve" in page


@chromium.needs_chromium
def test_the_first_page_has_the_printed_thresholds_and_a_guide(page):
    page.get_by_text("How to read this report").wait_for()
    page.set_viewport_size({"width": 1500, "height": 300})  # what is higher than the window begins at its top
    assert page.get_by_text("Friction-induced vibration of a lead-screw drive").bounding_box()["y"] >= 0
    row = page.get_by_role("row", name="Critical mass")
    cells = [cell.strip() for cell in row.inner_text().split("\t")]
    assert cells[1:] == ["10.10 kg", "10.107 kg", "0.069 %", "fig8_08"]
    page.locator("p").get_by_role("link", name="Checks", exact=True).click()
    page.get_by_role("row", name="every check").locator("a,button").first.click()
    checks = page.frame_locator("iframe")
    checks.get_by_role("cell", name="Critical mass, root of Γ₊(m) = 0").wait_for()
    assert checks.locator("html").get_attribute("lang") == "en"
    page.reload()


@chromium.needs_chromium
def test_a_picture_has_its_caption_with_values(page):
    page.get_by_role("link", name="Chapter 8").click()
    show, tell = page.get_by_role("row", name="fig8_08").locator("a,button").all()
    show.click()
    page.locator("img[src*='fig8_08'], img[src^='data:image/png']").first.wait_for()
    tell.click()
    page.get_by_text("Values: As printed: c_x = 0 N s m⁻¹. Otherwise Table 8.1.").wait_for()
