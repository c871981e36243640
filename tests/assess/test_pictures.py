"""The pictures of the report: they show what the tables say, and no words lie outside of them or on others."""

import math
from itertools import combinations

import numpy as np
import pytest
import yaml
from references.chapter_sheet import sheet

from lsvib.assess import pictures
from lsvib.assess.assessment import assess
from lsvib.assess.chart import KINDS, charts
from lsvib.assess.report import shown_mechanisms
from lsvib.assess.sheet import Sheet
from lsvib.assess.vibration import STRONG, vibration
from lsvib.figures import style

SPIKY = """
name: a soft drive whose screw slips briefly
thread: {size: Tr 10x2}
screw: {length: 300 mm, material: steel}
coupling: {stiffness: {median: 0.5 N*m/rad, factor: 1.3}}
load: {mass: 10 kg, orientation: vertical}
operation: {speed: [1 mm/s, 30 mm/s], direction: back}
friction: {coefficient: 0.438, stribeck_rise: 0.155, stribeck_speed: 0.025 m/s, slope: 1.907 s/m}
damping: {rotational: 1e-3 N*m*s/rad, translational: 5 N*s/m}
"""


@pytest.fixture(scope="module")
def spiky():
    """Its assessment."""
    return assess(Sheet.model_validate(yaml.safe_load(SPIKY)), samples=64)


@pytest.mark.parametrize("speed", [1e-3, 30e-3])
def test_a_motion_that_is_shown_is_resolved(spiky, speed):
    """Six cycles, at 1 mm/s with slips of a 50th of one; the last are the cycle of the table, at 30 mm/s from late on.

    Twenty samples of an arc of a sine miss its extreme by less than 1 - cos(π/40) = 0.3 %.
    """
    corner = -1, speed * 2 * math.pi / 2e-3, 0.0
    shown = vibration(spiky.sheet, spiky.values, corner, perturbation=-STRONG)
    assert shown.time[-1] * shown.frequency == pytest.approx(6)
    late = shown.time > 0.5 * shown.time[-1]
    ends = shown.speed[late].min(), shown.speed[late].max()
    assert np.allclose(ends, shown.screw_speed, rtol=0, atol=0.05 * np.ptp(shown.screw_speed))
    if speed == 1e-3:
        assert min(ends) == pytest.approx(shown.screw_speed[0], rel=3e-3)
    assert 0.5 * np.ptp(shown.deviation[late]) == pytest.approx(shown.amplitude, rel=0.05)


def test_with_friction_at_rest_nothing_is_called_steady_for_good():
    """The reserve after a perturbation knows the friction of running only; the drive has stick-slip all the same."""
    given = sheet(friction={"coefficient": 0.05, "static": 0.5})
    found = assess(given, samples=64)
    assert found.nominal.vibration.vibrates
    assert found.mechanisms["after_perturbation"].reserve > 0
    kinds = {KINDS[flag] for chart in charts(given, found.values) for flag in np.unique(chart.kind)}
    assert "steady_once_started" in kinds
    assert not kinds & {"steady", "steady_until_perturbed"}


def test_words_lie_inside_the_picture_and_not_on_others(spiky):
    """Names of quantities are long, and factors stand at both ends of a decade."""
    drawings = [(draw, spiky, name) for draw in (pictures.margin_chart, pictures.sensitivity_chart)
                for name in shown_mechanisms(spiky)] + [(pictures.screw_chart, spiky.worst)]  # fmt: skip
    for draw, *arguments in drawings:
        figure = style.styled(lambda _, draw=draw, arguments=arguments: draw(*arguments))(None)
        figure.canvas.draw()
        drawn, (axis,) = figure.get_tightbbox(), figure.axes
        assert (np.array([drawn.min, figure.get_size_inches() - drawn.max]) >= 0).all(), (draw, drawn)
        factors = [text for text in axis.get_xticklabels() if "×" in text.get_text()]
        boxes = {text: text.get_window_extent() for text in (*axis.texts, *factors) if text.get_text()}
        assert all(axis.bbox.x0 < boxes[text].x0 < boxes[text].x1 < axis.bbox.x1 for text in axis.texts), draw
        for one, other in combinations(boxes, 2):
            assert not boxes[one].overlaps(boxes[other]), (draw, one, other)
