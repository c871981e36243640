"""Chromium, driven by playwright, for tests of what a person sees; skipped where one of them is missing.

Debian calls it ``chromium``, other distributions by another name. ``.ci/run`` installs it, and
says at its end if it could not.
"""

import importlib.util
import shutil
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
needs_chromium = pytest.mark.skipif(
    CHROMIUM is None or importlib.util.find_spec("playwright") is None,
    reason="There is no Chromium on this machine, or no playwright, which drives it.",
)
FLAGS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
)


@contextmanager
def started() -> Iterator:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS.split())
        yield chromium
        chromium.close()


@contextmanager
def opened(browser, address: str, width: int = 1500, height: int = 1000, known: str | None = None) -> Iterator:
    """A page at an address; whatever its console says, or asks of another machine, is an error at the end.

    ``known``: the beginning of what may be said all the same.
    """
    # One tab for all, one after the other: it keeps the scripts that they share, and is empty in between.
    page = next((page for context in browser.contexts for page in context.pages), None) or browser.new_page()
    page.set_viewport_size({"width": width, "height": height})
    said: list[str] = []
    heard = {
        "console": lambda message: said.append(message.text) if message.type in ("error", "warning") else None,
        "pageerror": lambda error: said.append(str(error)),
        "requestfailed": lambda request: said.append(f"{request.url}: {request.failure}"),
    }
    for event, hear in heard.items():
        page.on(event, hear)
    page.goto(address)
    yield page
    page.evaluate("0")  # all that it has said until here is heard before the answer
    for event, hear in heard.items():
        page.remove_listener(event, hear)
    page.goto("about:blank")
    assert [words for words in said if known is None or not words.startswith(known)] == []


def wider_than_the_screen(page) -> int:
    """By how many pixels a page has to be scrolled sideways."""
    return page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
