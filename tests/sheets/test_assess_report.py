"""From file to report by the command: the files, what they hold, and pictures on which no words lie on others."""

import json
import math
import re
import shutil
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from references.random_sheets import sheet

import lsvib
from lsvib.errors import InputError
from lsvib.pictures import style
from lsvib.sheets import pictures
from lsvib.sheets.assessment import assess
from lsvib.sheets.draw import Operation
from lsvib.sheets.from_rest import KINDS, charts
from lsvib.sheets.report import compare
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.vibration import STRONG
from lsvib.sheets.words import ATTRACTORS, change, percent, shown

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="module")
def seat(tmp_path_factory):
    out = tmp_path_factory.mktemp("seat")
    return out, lsvib.assess(EXAMPLES / "powered_seat.yaml", out, samples=1024)


def test_the_json_file_has_the_verdict(seat):
    """The keys that other programs rely on."""
    out, result = seat
    stored = json.loads((out / "assessment.json").read_text(encoding="utf-8"))
    assert stored == json.loads(json.dumps(result))
    assert {"verdict", "mechanisms", "efficiency", "self_locking"} <= set(stored)
    assert stored["verdict"] == "vibrates"
    assert stored["self_locking"] is True
    for one in stored["mechanisms"].values():
        assert {"occurs", "margin", "probability", "interval"} <= set(one)
        assert one["interval"][0] <= one["probability"] <= one["interval"][1]


def test_the_page_needs_no_other_file(seat):
    """No script, no address that is fetched, every picture inside, all sections there."""
    page = (seat[0] / "index.html").read_text(encoding="utf-8")
    assert "<script" not in page
    assert not re.findall(r'(?:src|href)="(?!data:)', page)
    assert page.count("<img ") >= 4
    assert page.count('alt="') == page.count("<img ")
    for title in ("What can make it vibrate", "Where it vibrates", "What this model leaves out", "The data sheet"):
        assert title in page
    assert "assumed" in page
    assert "nan" not in re.sub(r"base64,[^\"]*", "", page).lower().replace("resonan", "")


def test_every_cause_has_its_plain_meaning_beside_it(seat):
    page = re.sub(r"base64,[^\"]*", "", (seat[0] / "index.html").read_text(encoding="utf-8"))
    for term, meaning in (("Kinematic constraint", "Wedging"), ("Negative damping", "instead of dying out")):
        assert page.index(meaning) - page.index(f">{term}") < 400
    for foreign in ("Painlevé", "eigenvalue", "Hurwitz", "Γ", "ξ"):
        assert foreign not in page


def test_the_dataset_holds_chart_and_motions(seat):
    with xr.open_dataset(seat[0] / "assessment.nc") as data:
        assert data.attrs["verdict"].startswith("vibrates")
        assert set(data["chart"].dims) == {"direction", "force", "speed"}
        assert data["worst_deviation"].attrs["units"] == "m"


@pytest.mark.slow
def test_drives_are_compared_in_one_table(seat, tmp_path):
    """The most likely to vibrate first, each with a link to its report; a damaged file is refused."""
    lsvib.assess(EXAMPLES / "linear_actuator.yaml", tmp_path / "linear_actuator", samples=64)
    shutil.copytree(seat[0], tmp_path / "seat")
    verdicts = [tmp_path / name / "assessment.json" for name in ("linear_actuator", "seat")]
    compare(verdicts, tmp_path / "index.html", tmp_path / "comparison.json")
    table = json.loads((tmp_path / "comparison.json").read_text(encoding="utf-8"))
    assert [row["report"] for row in table] == ["seat/index.html", "linear_actuator/index.html"]
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert page.index('href="seat/index.html"') < page.index('href="linear_actuator/index.html"')
    verdicts[0].write_text("{}", encoding="utf-8")
    with pytest.raises(InputError, match="not a readable assessment"):
        compare(verdicts, tmp_path / "index.html", tmp_path / "comparison.json")


def test_only_a_drive_that_settles_is_said_not_to_vibrate(seat, tmp_path):
    """Motions without a frequency: some go on for ever all the same, or are not known."""
    said = {}
    for attractor in ATTRACTORS:
        file = tmp_path / "a" / "assessment.json"
        file.parent.mkdir(exist_ok=True)
        worst_case = {**seat[1]["worst_case"], "attractor": attractor, "frequency": None}
        file.write_text(json.dumps({**seat[1], "worst_case": worst_case}), encoding="utf-8")
        compare([file], tmp_path / "index.html", tmp_path / "comparison.json")
        page = (tmp_path / "index.html").read_text(encoding="utf-8")
        said[attractor] = "does not vibrate" in page
    assert [name for name, still in said.items() if still] == ["steady sliding"]


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.yaml")), ids=lambda path: path.stem)
def test_every_entry_of_an_example_has_its_source_or_is_an_assumption(path):
    sheet = Sheet.read(path)
    known = {*sheet.sources, *sheet.assumptions}
    for entry in yaml.safe_load(path.read_text(encoding="utf-8")):
        if entry in ("name", "sources", "assumptions"):
            continue
        for name, _ in sheet.entries():
            if name.startswith(f"{entry}."):
                assert {name, entry} & known, name


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (shown(0.0, "N"), "0 N"), (shown(1234.5, "N"), "1.23 kN"), (shown(-0.0121, "m"), "−12.1 mm"),
        (shown(0.9999, "m"), "1 m"), (shown(2.3e-6, "kg m2"), "2.3 × 10⁻⁶ kg m²"), (shown(None, "N"), "–"),
        (shown(40.0, "rad s-1"), "382 rpm"), (percent(0.99951), "99.95 %"),
        (percent(0.99999), "99.999 %"), (percent(1 - 2.0**-30), "99.9999999 %"),  # not all of them
        (percent(1.0), "100 %"), (percent(0.123), "12.3 %"), (percent(1e-7), "1 × 10⁻⁵ %"),
        (change(0.8), "20 % smaller"), (change(1.25), "25 % larger"), (change(6.7), "6.7 times as large"),
    ],
)  # fmt: skip
def test_numbers_read_well(text, expected):
    assert text == expected


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
    return assess(Sheet.model_validate(yaml.safe_load(SPIKY)), samples=64)


@pytest.mark.parametrize("speed", [1e-3, 30e-3])
def test_a_motion_that_is_shown_is_resolved(spiky, speed):
    """Six cycles, at 1 mm/s with slips of a 50th of one; the last are those of the table, at 30 mm/s from late on."""
    shown = Operation(spiky.draw, -1, speed * 2 * math.pi / 2e-3, 0.0).motion(-STRONG)
    assert shown.time[-1] * shown.frequency == pytest.approx(6)
    late = shown.time > 0.5 * shown.time[-1]
    assert 0.5 * np.ptp(shown.deviation[late]) == pytest.approx(shown.amplitude, rel=0.05)


def test_the_worst_case_is_a_motion_that_can_be_run(spiky):
    worst = spiky.worst.vibration
    motion = lsvib.simulate(worst.scene)
    load = spiky.draw.travel * motion["u"].to_numpy()
    assert worst.vibrates
    assert np.allclose(load, worst.deviation, rtol=0, atol=1e-9 * np.ptp(load))
    assert np.ptp(load[-200:]) > 0.5 * np.ptp(load)


def test_with_friction_at_rest_nothing_is_called_steady_for_good():
    """The reserve after a perturbation knows the friction of running only; the drive has stick-slip all the same."""
    given = sheet(friction={"coefficient": 0.05, "static": 0.5})
    found = assess(given, samples=64)
    assert found.nominal.vibration.vibrates
    assert found.perturbed.reserve > 0
    kinds = {KINDS[flag] for chart in charts(found.draw) for flag in np.unique(chart.kind)}
    assert "steady_once_started" in kinds
    assert not kinds & {"steady", "steady_until_perturbed"}


def test_words_lie_inside_the_picture_and_not_on_others(spiky):
    found = assess(sheet(friction={"coefficient": [0.1, 0.3]}, load={"mass": ["1 kg", "20 kg"]}), samples=64)
    drawings = [(pictures.sobol_chart, found, "kinematic_constraint"), (pictures.load_chart, spiky.worst)]
    for draw, *arguments in drawings:
        figure = style.styled(lambda _, draw=draw, arguments=arguments: draw(*arguments))(None)
        figure.canvas.draw()
        drawn, (axis,) = figure.get_tightbbox(), figure.axes
        assert (np.array([drawn.min, figure.get_size_inches() - drawn.max]) >= 0).all(), (draw, drawn)
        boxes = {text: text.get_window_extent() for text in axis.texts}
        assert all(axis.bbox.x0 < boxes[text].x0 < boxes[text].x1 < axis.bbox.x1 for text in axis.texts), draw
        for one, other in combinations(boxes, 2):
            assert not boxes[one].overlaps(boxes[other]), (draw, one, other)
