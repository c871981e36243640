"""Quantities, threads, nuts as makers print them: what they are, and what is refused (spellings.yaml); US units."""

import math
import re
from pathlib import Path

import pytest
import yaml

import lsvib
from lsvib.errors import InputError
from lsvib.sheets.fields import NotQuantity, Spread, quantity
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import statics
from lsvib.sheets.threads import thread_size

TABLE = yaml.safe_load(Path(__file__).with_name("spellings.yaml").read_text(encoding="utf-8"))
ANY_SIZE = (-math.inf, math.inf)
GATE = {
    "name": "a gate", "thread": {"size": "Tr 30x6"}, "nut": {"length": '2"', "material": "POM"},
    "screw": {"length": "0.5 m", "ends": "fixed-free"}, "load": {"force": "500 lb"}, "operation": {"speed": "5 ipm"},
    "friction": {"coefficient": 0.1},
}  # fmt: skip


@pytest.mark.parametrize("kind", TABLE["quantities"])
def test_quantities_are_read_as_they_are_printed(kind):
    for text, value in TABLE["quantities"][kind].items():
        low, high = (
            eval(str(one), {}, TABLE["definitions"]) for one in (value if isinstance(value, list) else [value, value])
        )
        found = Spread.of(text, dict.fromkeys((kind, kind.removesuffix("/turn")), ANY_SIZE))
        assert [found.low, found.high] == pytest.approx([low, high], rel=1e-12), text
        assert found.unit == kind.removesuffix("/turn")


@pytest.mark.parametrize(("text", "kind", "words"), TABLE["refused"])
def test_what_has_two_meanings_or_another_is_refused_and_what_is_offered_is_taken(text, kind, words):
    with pytest.raises(NotQuantity, match=re.escape(words)) as error:
        Spread.of(text, dict.fromkeys((kind, kind.removesuffix("/turn")), ANY_SIZE))
    for offer in str(error.value).partition("; write ")[2].split(" or "):
        assert not offer[:1].isdigit() or quantity(offer, kind)


@pytest.mark.parametrize("name", TABLE["threads"])
def test_threads_are_known_by_the_names_that_are_printed_and_a_lead_is_never_guessed(name):
    if isinstance(words := TABLE["threads"][name], str):
        with pytest.raises(NotQuantity, match=re.escape(words)) as error:
            thread_size(name)
        for offer in re.findall(r"Tr [\dx.]+(?: P[\d.]+)?|Acme [^ ]+L", str(error.value).partition("rite ")[2]):
            thread_size(offer)
        return
    size, (unit, rounded) = thread_size(name), (25.4e-3, 6e-5) if words[-1] == "in" else (1e-3, 5.5e-4)
    found = [one / unit for one in (size.lead, size.pitch_diameter, size.root_diameter)]
    assert found == pytest.approx(words[:3], abs=rounded)


def test_us_units_stand_beside_si_and_limits_that_are_not_known_are_said(tmp_path):
    (tmp_path / "gate.yaml").write_text(yaml.safe_dump(GATE), encoding="utf-8")
    found, us = (lsvib.assess(tmp_path / "gate.yaml", units=units) for units in ("si", "us"))
    torque = found["statics"]["lifting_torque"]["middle"]
    assert f"needs {torque:.3g} N m ({torque / 4.4482216152605 / 0.0254:.3g} lbf·in) and" in " ".join(us["brief"])
    assert {**us, "brief": 0} == {**found, "brief": 0}
    assert "No PV limit is known for acetal, so none is checked; give nut.pv_limit." in " ".join(found["brief"])
    with pytest.raises(InputError, match="may be acetal_dry or acetal_wet or acetal_oil"):
        Sheet.of({key: value for key, value in GATE.items() if key != "friction"})
    own = {"density": "7.85 g/cc", "modulus": "200 GPa", "yield_strength": "250 MPa"}
    steel, same = (statics(Sheet.of({**GATE, "screw": GATE["screw"] | more})).rows for more in ({}, own))
    assert same == steel
