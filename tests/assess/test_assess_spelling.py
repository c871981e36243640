"""Quantities and threads as people write them: read, or refused with what to write instead."""

import math

import pytest

from lsvib.assess.fields import NotQuantity, quantity
from lsvib.assess.sheet import Load
from lsvib.assess.threads import thread_size


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10 mm / s", "m/s", 0.01),
        ("1e-6 kg * m^2", "kg m^2", 1e-6),
        ("5 N/mm2", "Pa", 5e6),
        ("7850 kg/m3", "kg/m^3", 7850.0),
        ("1/2 inch", "m", 0.0127),
        ("2 tpi", "m", 0.0127),
        ("14TPI", "m", 0.0254 / 14),
        ("−5 N", "N", -5.0),
        ("1e3 N*s/m", "N s/m", 1e3),
        ("2e2 mm^2/mm", "m", 0.2),
        *((f"2{text}", "kg m^2", 2.0) for text in (" kg*m^2", " kg*m**2", " kg*m^(2)", "000 g*m^2", " kg/m^-2")),
    ],
)
def test_a_quantity_is_read(text, unit, value):
    assert quantity(text, unit)[0] == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        ("0,15", "", "a comma where 0.15 has a point"),
        ("5,5 kg", "kg", "a comma where 5.5 kg has a point"),
        ("1_0 N", "N", "not known"),
        ("٣ N", "N", "is not a force"),
        ("1 m2", "m", "is not a length"),
        ("1/0 inch", "m", "not known"),
        ("0 tpi", "m", "not known"),
        ("2 tpi", "N", "is not a force"),
        # Pint counts no radian, so that N m deg would pass for 0.017 N m/rad.
        ("30 N*m*deg", "N m/rad", "is not"),
        ("1 deg*deg/s", "rad/s", "is not"),
        ("1 deg^2", "rad", "is not"),
    ],
)
def test_what_is_no_quantity_is_refused(text, unit, words):
    with pytest.raises(NotQuantity, match=words):
        quantity(text, unit)


def test_the_orientation_may_begin_with_a_capital():
    load = Load.model_validate({"mass": "1 kg", "orientation": "Vertical"})
    assert load.orientation.nominal == pytest.approx(math.pi / 2)


def test_threads_of_catalogues_are_known():
    assert thread_size("M20") == thread_size("M20x2.5")
    assert thread_size("Tr 12x4").pitch_diameter == pytest.approx(10e-3)
    assert thread_size("Tr 100x12").root_diameter == pytest.approx(87e-3)  # ISO 2904: d_3
    with pytest.raises(NotQuantity, match="written with its pitch, such as Tr 8x8 P2"):
        thread_size("Tr 8x8")
    with pytest.raises(NotQuantity, match="diameters go from Tr 8 to Tr 300"):
        thread_size("Tr 400x8")
