"""Sheets that ask for a size only: their answers, and the inverse, which solves them for one entry."""

import html
import json
import math
import re
import subprocess
import sys

import numpy as np
import pytest
import yaml

from lsvib.errors import InputError
from lsvib.sheets.inverse import solved
from lsvib.sheets.output import assess
from lsvib.sheets.report import compare
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import row_of, statics
from lsvib.sheets.words import percent, shown

JACK = {
    "thread": {"lead": "6 mm", "pitch_diameter": "29 mm", "half_angle": "15 deg"}, "friction": {"coefficient": 0.08},
    "bearing": {"collar": {"coefficient": 0.01, "mean_diameter": "32 mm"}}, "load": {"force": "10 kN"},
    "screw": {"root_diameter": "25 mm", "ends": "fixed-supported", "unsupported_length": "800 mm"},
    "nut": {"length": "28 mm", "pressure_limit": "5 MPa"}, "operation": {"speed": "60 rpm"},
}  # fmt: skip
MOVE = {"operation": {"move": {"distance": "1 m", "acceleration_time": "1 s"}}, "motor": {"rated_torque": "30 N*m"}}
STEEP, TORQUE = {"thread": {"lead": "20 mm", "pitch_diameter": "30 mm"}}, "lifting_torque=60 N*m"


@pytest.mark.parametrize("seed", range(710, 722))
def test_json_text_and_page_of_random_sizes_say_the_same(tmp_path, seed):
    """With and without a diameter, a speed, ends, a range of friction and a mass instead of a force."""
    draw = np.random.default_rng(seed).random(6).tolist()
    nut = {"nut": {"length": "9 mm"}, "thread": {"lead": f"{1 + draw[0]} cm", "pitch_diameter": "20 mm"}}
    sheet = {"load": {"force": "2 kN"}, "friction": {"efficiency": 0.3 + 0.7 * draw[0]}, **nut}
    flat = {"friction": {"efficiency": draw[0]}, "thread": {"lead": "9 mm"}, "operation": {"speed": "50 rpm"}}
    ends = {"screw": {"root_diameter": "14 mm", "unsupported_length": "2 m", "ends": "fixed-free"}}
    up = {"load": {"mass": "80 kg", "orientation": "vertical"}}
    for more in ({"friction": {"coefficient": [0.1, 0.1 + 0.1 * draw[0]]}}, flat, ends, up):
        sheet |= more if draw.pop() < 0.5 else {}
    (tmp_path / "lift.yaml").write_text(yaml.safe_dump(sheet))
    found = assess(tmp_path / "lift.yaml", tmp_path)
    page = " ".join(re.sub("<[^>]*>", " ", html.unescape((tmp_path / "index.html").read_text())).split())
    assert found == json.loads((tmp_path / "assessment.json").read_text())
    assert all(line in page for line in found["brief"])
    rows = {key: row for key, row in found["statics"].items() if key != "back_drives"}
    for key, row in rows.items():
        assert (percent(row["worst"]) if key.endswith("efficiency") else shown(row["worst"], row["unit"])) in page
    compare([tmp_path / "assessment.json"], tmp_path / "all.html", tmp_path / "all.json")
    (short,) = json.loads((tmp_path / "all.json").read_text())
    assert (short["name"], short["verdict"], short["torque"]) == ("lift", None, rows["lifting_torque"]["worst"])


@pytest.mark.parametrize("efficiency", [0.4, 0.9, 1.0])
def test_an_efficiency_needs_no_diameter(efficiency):
    """F l / (2 π η) against the load, and with it 2 − 1/η of the work, the limit of a small lead angle."""
    sheet = {"thread": {"lead": "10 mm"}, "load": {"force": "20 kN"}, "friction": {"efficiency": efficiency}}
    found = statics(Sheet.of(sheet))
    assert found.rows["lifting_torque"].worst == pytest.approx(20e3 * 0.01 / (2 * math.pi * efficiency), rel=1e-12)
    assert found.rows["lowering_efficiency"].worst == pytest.approx(2 - 1 / efficiency, rel=1e-12)
    assert bool(found.back_drives) == (efficiency > 0.5)


@pytest.mark.parametrize(
    ("entry", "goal", "more"),
    [("load.force", "motor.torque=60 N*m", {}), ("load.mass", TORQUE, {"load": {"orientation": "9 deg"}}),
     ("nut.length", "nut_pressure", {}), ("nut.preload", "holding_friction", STEEP), ("nut.length", "pv=1 MPa*m/s", {}),
     ("thread.pitch_diameter", TORQUE, {}), ("thread.lead", "lifting_efficiency=50 %", {}),
     ("friction.coefficient", "holding_friction", {}), ("screw.unsupported_length", "column_load", {}),
     ("screw.unsupported_length", "screw_speed", {}), ("operation.speed", "lifting_power=100 W", {}),
     ("friction.efficiency", TORQUE, {"friction": {}}), ("coupling.gear_ratio", "motor.torque=5 N*m", {}),
     ("load.force", "rms_torque", MOVE), ("load.force", "motor.torque", MOVE), ("nut.length", "nut.pressure", {}),
     ("operation.move.time", "load_speed=0.4 m/s", MOVE)],
)  # fmt: skip
def test_what_is_solved_for_gives_what_was_asked(entry, goal, more):
    found = solved({**JACK, **more}, entry, goal)
    row = row_of(found.sheet, found.row)
    assert row.worst == pytest.approx(row.limit if found.wanted is None else found.wanted, rel=1e-9)
    assert found.sheet.sources[entry] == f"solved for {found.row}"


def test_both_ends_of_the_uncertainties_and_all_solutions_are_said():
    found = solved({**JACK, "load": {}, "friction": {"coefficient": [0.08, 0.12]}}, "load.force", TORQUE)
    ends = [solved({**JACK, "friction": {"coefficient": mu}}, "load.force", TORQUE).values[0] for mu in (0.12, 0.08)]
    assert (found.worst, found.best) == pytest.approx(ends, rel=1e-8)  # corners are 1e-9 inside
    assert found.sentence.endswith("lifting_torque is 60 N m (20.42 kN in the worst case, 25.78 kN in the best case).")
    assert len(solved(JACK, "thread.lead", "lifting_efficiency=0.5").values) == 2  # on both sides of the best one


@pytest.mark.parametrize(
    ("entry", "goal", "words"),
    [("load.forse", TORQUE, "'load.forse' is not a quantity of the sheet; it could be load.mass, load.force"),
     ("load.force", "lifting_torque=60 N", "lifting_torque = '60 N' is not a torque"),
     ("load.mass", "vibration", "screw_speed; changes that end vibration are listed in the answer without --solve."),
     ("load.force", "lifting_torque", "The sheet has no limit of lifting_torque; give a value."),
     ("operation.speed", "sliding_speed", "The sheet has no limit of sliding_speed; give a value."),
     ("friction.efficiency", TORQUE, "friction.coefficient and friction.efficiency are both given"),
     ("nut.length", TORQUE, "No nut.length between 1 µm and 100 m makes lifting_torque 60 N m: it is 23.27 N m.")],
)  # fmt: skip
def test_what_has_no_solution_is_said_in_one_sentence(entry, goal, words):
    with pytest.raises(InputError, match=re.escape(words)):
        solved(JACK, entry, goal)


def test_a_size_loads_no_engine_and_no_pictures(tmp_path):
    (tmp_path / "jack.yaml").write_text(yaml.safe_dump({key: JACK[key] for key in ("thread", "load", "friction")}))
    code = (
        "import sys; from lsvib.cli.app import main; main(); print({'numba', 'matplotlib', 'xarray'} & {*sys.modules})"
    )
    given = [sys.executable, "-c", code, "assess", "jack.yaml", "--solve", "load.force", "--for", TORQUE]
    said = subprocess.run(given, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    assert said.startswith("load.force = 27.68 kN: lifting_torque is 60 N m. What follows is for this value.\n")
    assert said.endswith("set()\n")
