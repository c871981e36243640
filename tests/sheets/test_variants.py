"""A table of variants: each row is its own sheet, a refused one a sentence; what is no table is refused as a whole."""

import csv
import json
from pathlib import Path

import pytest
import yaml
from references.command_line import refused

import lsvib

JACK = {
    "name": "jack", "thread": {"size": "Tr 20x4"}, "load": {"force": "5 kN"}, "friction": {"coefficient": 0.15},
    "operation": {"speed": "60 rpm", "direction": "out"}, "nut": {"length": "30 mm", "pressure_limit": "5 MPa"},
    "sources": {"thread.size": "a drawing"},
}  # fmt: skip
SLIDE = {"screw": {"inertia": "1e-6 kg*m^2"}, "coupling": {"stiffness": "20 N*m/rad"}}  # by which it could vibrate
ROWS = {  # of a table, and what they change
    "as it is;;;;;;;": {},
    "heavier;;[6, 12];;;10 %;;": {"load": {"force": ["6 kN", "12 kN"]}, "friction": {"coefficient": "10 %"}},
    "free;null;;5;22.5;;;": {"thread": {"lead": "5 mm", "pitch_diameter": "22.5 mm"}},
    "moved;;;;;;50;": {"load": {"force": "5 kN", "mass": "50 kg"}},
    "damped;;;;;;50;1e5 N*s/m": {
        "load": {"force": "5 kN", "mass": "50 kg"}, "damping": {"translational": "1e5 N*s/m"}
    },
    "wrong;Tr 20x4;;5;;;;": "thread.size and thread.lead are both given; give one of them.",
}  # fmt: skip
HEADING = "name;thread.size;load.force [kN];thread.lead [mm];thread.pitch_diameter [mm];friction.coefficient;"


def test_each_row_is_answered_as_its_own_sheet(run):
    lines = [f"{HEADING}load.mass [kg];damping.translational", *ROWS, ""]
    Path("v.csv").write_text("\n".join(lines), encoding="utf-8-sig")
    Path("base.yaml").write_text(yaml.safe_dump(JACK | SLIDE))
    code, out, _ = run("assess", "v.csv", "--base", "base.yaml", "--out", "t.csv", "--json")
    with open("t.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert code == 0
    assert [{k: "" if x is None else str(x) for k, x in row.items()} for row in json.loads(out)["rows"]] == rows
    for row, (line, change) in zip(rows, ROWS.items(), strict=True):
        assert row["name"] == line.partition(";")[0]
        if isinstance(change, str):
            assert row["refused"] == change
            continue
        found = lsvib.assess({k: part for k, part in {**JACK, **SLIDE, **change}.items() if k != "sources"}, samples=64)
        statics, near = found["statics"], found.get("mechanisms", {}).get(row["mechanism"])
        assert (row["refused"], row["verdict"], row["sentence"]) == ("", found["verdict"] or "", found["sentence"])
        assert float(row["lifting_torque [N m]"]) == statics["lifting_torque"]["worst"]
        assert float(row["limit_used"]) == statics["nut_pressure"]["worst"] / 5e6
        assert row["exceeded"] == ("nut_pressure" if statics["nut_pressure"]["worst"] > 5e6 else "")
        assert row["reserve"] == (str(near["reserve"]) if near else "")
    assert {row["verdict"] for row in rows} == {"", "jerks", "steady"}
    text = run("assess", "v.csv", "--base", "base.yaml")[1].splitlines()
    assert (len(text), text[0].split()[0]) == (7, "name")
    assert text[2].split()[:2] == ["heavier", "2.8294"]  # 12 kN / (π 18 mm 30 mm / 2) over 5 MPa


@pytest.mark.parametrize(
    ("table", "more", "words"),
    [
        ("load.mas [kg]\n5\n", "", "All variants in v.csv are refused: load.mas is not a known key"),
        ("load.force\n5 lbz\n", "", "refused: load.force = '5 lbz' has the unit 'lbz'"),
        ("load.force [N]\n", "", "All variants in v.csv are refused: there are none"),
        ("", "", "v.csv is not a table: No columns to parse from file."),
        ("load.force [N]\n2,5\n", "", "v.csv is not a table: its rows have more cells"),
        ("load.force [N]\n5\n", "--out folder", "out = folder does not end in .csv"),
        ("load.force [N]\n5\n", "--out v.csv", "Cannot write v.csv: this command reads it"),
        ("load.force [N]\n5\n", "--samples 0", "samples = 0 is outside the allowed range"),
    ],
)
def test_what_is_no_table_of_variants_is_refused(run, table, more, words):
    Path("v.csv").write_text(table)
    Path("base.yaml").write_text(yaml.safe_dump(JACK))
    assert words in refused(run, "assess", "v.csv", "--base", "base.yaml", *more.split())
    assert "--base goes with a CSV file" in refused(run, "assess", "base.yaml", "--base", "base.yaml")
    assert "this command writes index.html" in refused(run, "assess", "base.yaml", "--out", "t.csv")
