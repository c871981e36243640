"""The explorer in a real browser: drag, click, keyboard, link and exports, with nothing on its console."""

import re
import subprocess
import sys
from contextlib import contextmanager
from time import monotonic
from urllib.parse import parse_qsl, urlsplit
from urllib.request import urlopen

import pytest
from references import chromium

pytest.importorskip("bokeh", reason="The explorer needs bokeh, which is not installed.")
playwright = pytest.importorskip("playwright.sync_api", reason="The browser is driven by playwright, not installed.")
pytestmark = [pytest.mark.slow, chromium.needs_chromium]
VIEW = "mass=11.0&support_damping=0.001&axial_force=-10.0&u=0.1&low=-40&high=-0.5"
_PATIENCE = 60_000  # ms, on a machine with other work; what is waited for comes within a second


@contextmanager
def serving(port: str = "0"):
    """The address of a server that ends behind the block."""
    command = [sys.executable, "-m", "lsvib", "explore", "--no-show", "--port", port]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield re.search(r"http://localhost:\d+/", process.stdout.readline()).group()
        finally:
            process.terminate()


@pytest.fixture(scope="module")
def server():
    with serving() as address:
        yield address


@pytest.fixture
def page(browser, server):
    """A page with a view; whatever its console says at the end is an error."""
    with chromium.opened(browser, f"{server}?{VIEW}") as opened:
        words(opened, "sprag slip cycle of amplitude 0.056")
        yield opened


def words(page, text: str) -> None:
    playwright.expect(page.get_by_role("status")).to_contain_text(text, timeout=_PATIENCE)


def text_of(page) -> str:
    """What the page says in words; it stands in a tree of its own, into which ``inner_text`` does not look."""
    return page.get_by_role("status").evaluate(
        "e => [...e.shadowRoot.children].filter(c => c.tagName === 'DIV').map(c => c.innerText).join(' ')"
    )


def share(page) -> float:
    """Wait for the share of the window from which the drive slides steadily [%]; the words come and go."""
    said, end = re.compile(r"starts in the window:.* steady sliding (\d+\.\d) %"), monotonic() + 1e-3 * _PATIENCE
    while not (found := said.search(text_of(page))):
        assert monotonic() < end, "the page does not say it"
        page.wait_for_timeout(20)
    return float(found.group(1))


def query(page, key: str, value: str) -> None:
    page.wait_for_function(
        "([key, value]) => new URLSearchParams(location.search).get(key) === value", arg=[key, value], timeout=_PATIENCE
    )


def test_a_drag_of_a_slider_recomputes_the_region(page):
    before = share(page)
    handle = page.locator(".noUi-handle").nth(9)  # of the axial force, the last parameter
    box = handle.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    for k in range(1, 11):
        page.mouse.move(box["x"] + box["width"] / 2 - 3 * k, box["y"] + box["height"] / 2)
    page.mouse.up()
    page.wait_for_function("new URLSearchParams(location.search).get('axial_force') < -12", timeout=_PATIENCE)
    # The harder the drive is pushed, the larger a push it takes away from steady sliding (docs/basin.md).
    playwright.expect(page.get_by_role("status")).not_to_contain_text(f"steady sliding {before} %", timeout=_PATIENCE)
    assert share(page) > before


def test_a_click_in_the_plane_starts_a_motion(page):
    canvas = page.locator(".bk-Canvas, canvas").first
    box = canvas.bounding_box()
    page.mouse.click(box["x"] + 0.505 * box["width"], box["y"] + 0.40 * box["height"])
    words(page, "It ends on steady sliding")
    u = float(page.get_by_label("Start u [rad]").input_value())
    assert abs(u) < 0.03
    points = "Bokeh.documents[0].get_model_by_name('plane').renderers.find(r => r.glyph.type == 'Scatter').data_source"
    assert page.evaluate(f"{points}.data.x[1]") == pytest.approx(u, rel=5e-6)  # the field shows six digits


def test_the_keyboard_does_what_a_hand_does(page):
    field = page.get_by_label("Start u [rad]")
    field.focus()
    page.keyboard.press("Control+A")
    page.keyboard.type("0.001")
    page.keyboard.press("Tab")
    words(page, "It ends on steady sliding")
    page.locator(".noUi-handle").nth(7).focus()  # of the mass
    page.keyboard.press("ArrowRight")
    page.wait_for_function("new URLSearchParams(location.search).get('mass') != 11", timeout=_PATIENCE)
    assert float(dict(parse_qsl(urlsplit(page.url).query))["mass"]) > 11


def test_what_is_refused_is_said_and_changes_nothing(page):
    field = page.get_by_label("translating mass m [kg]").and_(page.locator("input"))
    field.fill("-3")
    field.press("Enter")
    playwright.expect(page.get_by_role("alert")).to_contain_text("outside the allowed range", timeout=_PATIENCE)
    playwright.expect(field).to_have_value("11", timeout=_PATIENCE)


def test_the_link_reproduces_the_view(page, browser, server):
    page.get_by_label("Start u' [rad/s]").or_(page.get_by_label("Start u′ [rad/s]")).fill("-7.25")
    page.keyboard.press("Enter")
    query(page, "w", "-7.25")
    link = page.get_by_role("link", name="link to this view").get_attribute("href")
    assert dict(parse_qsl(urlsplit(page.url).query)) == dict(parse_qsl(urlsplit(link).query))
    assert text_of(page).startswith("The motion of")
    other = browser.new_page()
    other.goto(server + link)
    words(other, text_of(page)[:60])
    assert other.get_by_label("Start u′ [rad/s]").input_value() == "-7.25"
    other.close()


def test_the_first_page_fits_a_telephone_and_shows_a_drive_that_vibrates(browser, server):
    with chromium.opened(browser, server, 320, 667) as opened:
        words(opened, "sprag slip cycle of amplitude 0.056")
        assert chromium.wider_than_the_screen(opened) <= 0
        slider = opened.get_by_role("slider", name="pitch radius of the screw")
        assert opened.get_by_role("status").bounding_box()["y"] < slider.bounding_box()["y"]


def test_a_page_without_its_server_takes_nothing(browser):
    """It would show the old answer beside what is moved. With a server again it is as before."""
    with serving() as first:
        page = browser.new_page()
        page.goto(f"{first}?{VIEW}")
        words(page, "sprag slip cycle of amplitude 0.056")
    page.locator("main[inert]").wait_for(timeout=_PATIENCE)
    with serving(str(urlsplit(first).port)):
        page.locator("main:not([inert])").wait_for(timeout=_PATIENCE)
        words(page, "sprag slip cycle of amplitude 0.056")
        page.close()


@pytest.mark.parametrize(("name", "start"), [("scene.yaml", b"drive:"), ("motion.nc", b"\x89HDF")])
def test_exports_are_files(name, start, server):
    with urlopen(f"{server}export/{name}?{VIEW}") as answer:
        assert answer.headers["Content-Disposition"] == f'attachment; filename="{name}"'
        assert answer.read().startswith(start)


def test_a_port_in_use_is_refused_in_one_sentence(server):
    port = str(urlsplit(server).port)
    command = [sys.executable, "-m", "lsvib", "explore", "--no-show", "--port", port]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")
    said = "cannot be used: another program uses it; choose another one with --port."
    assert done.stderr == f"lsvib: port = {port} {said}\n"
