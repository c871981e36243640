"""What the page sends and says, without a browser."""

import json

import numpy as np
import pytest

from lsvib.explore.view import View

pytest.importorskip("bokeh", reason="The explorer needs bokeh, which is not installed.")

from bokeh.document import Document

from lsvib.explore.packet import pack
from lsvib.explore.page import LOOK, Page


def test_a_packet_holds_what_it_was_filled_with():
    """Numbers and words in its text, lines as places among all numbers, images whole."""
    rng = np.random.default_rng(3)
    lines, image = [rng.normal(size=k) for k in (5, 0, 2)], rng.integers(0, 99, (3, 4), dtype=np.uint32)
    text, numbers, *images = pack({"a": {"x": lines, "y": [1.5, "now", [2.0]]}, "b": {"image": [image]}})
    held = json.loads(text)
    for line, place in zip(lines, held["a"]["x"], strict=True):
        assert (numbers[place["begin"] : place["begin"] + place["size"]] == line).all()
        assert place["piece"] == 0
    assert held["a"]["y"] == [1.5, "now", [2.0]]
    assert images[held["b"]["image"][0]["piece"] - 1] is image


def test_a_model_whose_engine_is_not_compiled_yet_is_shown_later():
    class Compiling:
        done = False

        def ready(self, model: str) -> bool:
            return self.done or model == "rigid"

    ahead, document = Compiling(), Document()
    page = Page(document, View.of({"model": "threads"}), {}, ahead)
    (alert,) = (model for model in document.models if model.name == "alert")
    assert (page.view.drive.model, "is being compiled" in alert.text) == ("rigid", True)
    ahead.done = True
    for waiting in document.session_callbacks:
        if waiting.timeout == LOOK:
            waiting.callback()
    assert (page.view.drive.model, alert.text) == ("threads", "")
