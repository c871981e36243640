"""Quantities and names of threads as makers print them: what they are, and what is refused (spellings.yaml)."""

from pathlib import Path

import pytest
import yaml

from lsvib.sheets.fields import NotQuantity, quantity, spread
from lsvib.sheets.threads import thread_size

TABLE = yaml.safe_load(Path(__file__).with_name("spellings.yaml").read_text(encoding="utf-8"))


def said(call, *given) -> str:
    with pytest.raises(NotQuantity) as error:
        call(*given)
    return str(error.value)


@pytest.mark.parametrize("kind", TABLE["quantities"])
def test_quantities_are_read_as_they_are_printed(kind):
    for text, value in TABLE["quantities"][kind].items():
        expected = eval(str(value), {}, TABLE["definitions"])
        assert quantity(text, kind) == (pytest.approx(expected, rel=1e-12), kind.removesuffix("/turn")), text


def test_tolerances_are_ranges():
    for text, (kind, low, high) in TABLE["tolerances"].items():
        found = spread(text, kind, check=lambda *_: None)
        assert (found.kind, found.text) == ("uniform", text)
        assert (found.low, found.high) == pytest.approx((low, high), rel=1e-12), text


@pytest.mark.parametrize(("text", "kind", "words"), TABLE["refused"])
def test_what_has_two_meanings_or_another_is_refused_and_what_is_offered_is_taken(text, kind, words):
    sentence = (
        said(quantity, text, kind) if "±" not in text else said(lambda: spread(text, kind, check=lambda *_: None))
    )
    assert words in sentence
    for offer in sentence.partition("; write ")[2].split(" or "):
        assert not offer[:1].isdigit() or quantity(offer, kind)


def test_threads_are_known_by_the_names_that_are_printed():
    for name, (lead, *diameters) in TABLE["threads"].items():
        size, unit = thread_size(name), 25.4e-3 if diameters[-1] == "in" else 1e-3
        assert size.lead == pytest.approx(lead * unit, rel=2e-5), name
        assert size.pitch_diameter == pytest.approx(
            diameters[0] * unit, abs=5.5e-4 * unit if unit == 1e-3 else 6e-5 * unit
        ), name
        assert size.root_diameter == pytest.approx(
            diameters[1] * unit, abs=5.5e-4 * unit if unit == 1e-3 else 6e-5 * unit
        ), name


@pytest.mark.parametrize("name", TABLE["no_threads"])
def test_a_lead_is_never_guessed_and_names_that_are_offered_are_taken(name):
    sentence = said(thread_size, name)
    assert TABLE["no_threads"][name] in sentence
    for offer in sentence.partition("write ")[2].partition(":")[0].replace(" or ", ", ").split(", "):
        assert not offer or thread_size(offer)
