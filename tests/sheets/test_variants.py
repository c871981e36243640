"""A table of variants: each row is its own sheet, a refused one a sentence; what is no table is refused as a whole."""

import csv
import json
from pathlib import Path

import pytest
import yaml
from references.command_line import refused

import lsvib

BASE = {
    "name": "jack", "thread": {"size": "Tr 20x4"}, "load": {"force": "5 kN"}, "friction": {"coefficient": 0.15},
    "operation": {"speed": "60 rpm", "direction": "out"}, "nut": {"length": "30 mm", "pressure_limit": "5 MPa"},
    "screw": {"inertia": "1e-6 kg*m^2"}, "coupling": {"stiffness": "20 N*m/rad"},
}  # fmt: skip
HEADING = (
    "name;thread.size;load.force [kN];thread.lead [mm];thread.pitch_diameter (mm);friction.coefficient;load.mass [kg]"
)
ROWS = {  # of a table, and what they change
    "as it is;;;;;;": {},
    "heavier;;[6, 12];;;10 %;": {"load": {"force": ["6 kN", "12 kN"]}, "friction": {"coefficient": "10 %"}},
    "free;null;;5;22,5;;": {"thread": {"lead": "5 mm", "pitch_diameter": "22.5 mm"}},
    "jams;null;;30;22.5;3;": {"thread": {"lead": "30 mm", "pitch_diameter": "22.5 mm"}, "friction": {"coefficient": 3}},
    "moved;;;;;;5e1": {"load": {"force": "5 kN", "mass": "50 kg"}},
    "moved more;;[5e3 N, 6e3 N];;;;5,5e+1": {"load": {"force": ["5 kN", "6 kN"], "mass": "55 kg"}},
    "little;;5e-3;;;;": {"load": {"force": "5 N"}},
    "wrong;Tr 20x4;;5;;;": "thread.size and thread.lead are both given; give one of them.",
}


def test_each_row_is_answered_as_its_own_sheet(run):
    table = [f"{HEADING};brake.torque", *(f"{row};" for row in ROWS), ""]  # of parts without a cell there is none
    Path("v.csv").write_text("\n".join(table), encoding="utf-8-sig")
    Path("base.yaml").write_text(yaml.safe_dump(BASE | {"sources": {"thread.size": "a drawing"}}))
    _, out, _ = run("assess", "v.csv", "--base", "base.yaml", "--out", "t.csv", "--json")
    rows = list(csv.DictReader(Path("t.csv").read_text().splitlines()))
    assert [{k: "" if x is None else str(x) for k, x in row.items()} for row in json.loads(out)["rows"]] == rows
    for row, (line, change) in zip(rows[:-1], ROWS.items(), strict=False):
        found = lsvib.assess({**BASE, **change}, samples=64)
        statics, near = found["statics"], found.get("mechanisms", {}).get(row["mechanism"])
        assert (row["name"], row["refused"]) == (line.partition(";")[0], "")
        assert (row["verdict"], row["sentence"]) == (found["verdict"] or "", found["sentence"])
        assert row["lifting_torque [N m]"] == str(statics["lifting_torque"]["worst"] or "")
        assert float(row["limit_used"]) == statics["nut_pressure"]["worst"] / 5e6
        assert row["reserve"] == (str(near["reserve"]) if near else "")
    assert rows[-1]["refused"] == ROWS["wrong;Tr 20x4;;5;;;"]
    assert {row["verdict"] for row in rows} == {"", "jerks"}
    text = run("assess", "v.csv", "--base", "base.yaml")[1].splitlines()
    assert text[2].split()[:3] == ["heavier", "2.8294", "nut_pressure"]  # 12 kN / (π 18 mm 30 mm / 2) over 5 MPa


REFUSED = {  # a table and its options: words of the sentence
    "load.mas [kg]\n5\n|": "All variants in v.csv are refused: load.mas is not a known key",
    "load.force\n5 lbz\n|": "refused: load.force = '5 lbz' has the unit 'lbz'",
    "load.force [N]\n|": "All variants in v.csv are refused: it has no rows",
    "|": "Cannot read v.csv: No columns to parse from file.",
    "load.force [N]\n2,5\n|": "v.csv is not a table: a row has more cells",
    "load.force [N]\n5\n|--out folder": "out = folder must end in .csv",
    "load.force [N]\n5\n|--samples 0": "samples = 0 is outside the allowed range",
}


@pytest.mark.parametrize("table", REFUSED)
def test_what_is_no_table_of_variants_is_refused(run, table):
    text, _, more = table.partition("|")
    Path("v.csv").write_text(text)
    Path("base.yaml").write_text(yaml.safe_dump(BASE))
    assert REFUSED[table] in refused(run, "assess", "v.csv", "--base", "base.yaml", *more.split())
    assert "--base needs a CSV file" in refused(run, "assess", "base.yaml", "--base", "base.yaml")
    assert "this command writes index.html" in refused(run, "assess", "base.yaml", "--out", "t.csv")
