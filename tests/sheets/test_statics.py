"""The statics of a screw against printed tables of makers and standards, and against the work that goes in and out."""

import math
import re
import warnings
from itertools import pairwise

import pytest
import yaml

import lsvib
from lsvib.cli.app import run
from lsvib.cli.pages import app
from lsvib.sheets.assessment import assess
from lsvib.sheets.draw import Draw
from lsvib.sheets.drive_entries import Coupling
from lsvib.sheets.report import brief, report
from lsvib.sheets.sheet import Friction, Nut, Screw, Sheet, Thread
from lsvib.sheets.statics import ENDS, column_load, critical_speed, lets_go, nut_pressure, statics
from lsvib.sheets.threads import SCREW_MATERIALS, thread_size

INCH, POUND = 0.0254, 4.4482216152605
LOAD, WEIGHT = {"mass": "25 kg", "orientation": "vertical"}, 25 * 9.80665
BASE = {
    "name": "a lift", "thread": {"size": "Tr 16x4"}, "screw": {"length": "500 mm", "ends": "fixed-simple"},
    "nut": {"length": "30 mm", "material": "iglidur_b"}, "coupling": {"stiffness": "60 N*m/rad"},
    "load": {"mass": "10 kg", "orientation": "vertical"}, "operation": {"speed": "10 mm/s"},
    "friction": {"coefficient": 0.15},
}  # fmt: skip


def sheet(**changes) -> Sheet:
    return Sheet.of({**BASE, **changes})


@pytest.mark.parametrize(("coefficient", "efficiency"), [(0.1, 0.82), (0.15, 0.74), (0.2, 0.67)])
def test_change_nuts_have_the_efficiency_that_their_maker_prints(coefficient, efficiency):
    """THK, change nut, table 2: lead angle of 45°, printed with two digits."""
    thread = {"lead_angle": "45 deg", "pitch_diameter": "15 mm"}
    given = sheet(thread=thread, screw={"length": "500 mm"}, friction={"coefficient": coefficient})
    assert statics(given).rows["lifting_efficiency"].worst == pytest.approx(efficiency, abs=0.005)


def test_a_bolt_locks_from_the_friction_of_its_lead_angle_on():
    """M20 × 2.5: tan λ = 0.0433 without a flank angle; 30° of it lower that by cos αₙ."""
    size = thread_size("M20x2.5")
    assert size.pitch_diameter == pytest.approx(18.376e-3, abs=5e-7)  # ISO 724
    square = {"lead": "2.5 mm", "pitch_diameter": f"{size.pitch_diameter!r} m"}
    held = {}
    for friction in (0.0432, 0.0434):
        found = statics(sheet(thread=square, screw={"length": "1 m"}, friction={"coefficient": friction}))
        assert found.rows["holding_friction"].limit == pytest.approx(0.0433, abs=5e-5)
        held[friction] = found.back_drives
    assert held == {0.0432: "at the middle values", 0.0434: False}
    flanks = statics(sheet(thread={"size": "M20x2.5"})).rows["holding_friction"].limit
    assert flanks == pytest.approx(0.04331 * math.cos(math.radians(30)), rel=1e-3)


PAIRS = [("bronze_dry", 0.40), ("bronze_lubricated", 0.15), ("brass_dry", 0.35), ("brass_lubricated", 0.19)]


@pytest.mark.parametrize(("name", "coefficient"), PAIRS)
def test_pairs_of_a_makers_table_are_known_by_name(name, coefficient):
    """Roton, screw actions, table of friction."""
    named, written = sheet(friction={"pairing": f"steel_on_{name}"}), sheet(friction={"coefficient": coefficient})
    assert statics(named).rows == statics(written).rows


def test_a_pairing_brings_its_range_and_its_law():
    """A range stays a range; a law fades over its speed."""
    assert sheet(friction={"pairing": "iglidur_j"}).friction.coefficient.low == 0.06
    law = sheet(friction={"pairing": "powered_seat", "static": 0.3}).friction
    assert (law.slope.nominal, law.stribeck_speed.nominal) == (-0.08588598956673593, 0.013704)


@pytest.mark.parametrize(
    ("name", "root"),
    [("Tr 10x2", 7.5), ("Tr 12x3", 8.5), ("Tr 24x5", 18.5), ("Tr 22x5", 16.5), ("Acme 1/2-10", 0.38 * 25.4),
     ("Acme 1/4-16", 0.1775 * 25.4), ("M20x2.5", 16.933)],
)  # fmt: skip
def test_root_diameters_are_those_of_the_standards(name, root):
    """Largest minor diameters of DIN 103, ASME B1.5 and ISO 724 [mm]."""
    assert thread_size(name).root_diameter == pytest.approx(root * 1e-3, abs=6e-7)


@pytest.mark.parametrize(
    ("ends", "factor"), [("fixed-free", 0.25), ("supported-supported", 1), ("fixed-supported", 2), ("fixed-fixed", 4)]
)
def test_columns_bear_what_a_catalogue_says(ends, factor):
    """Berg: F = K C 10⁶ d⁴ / D², C = 13.4 for stainless steel, pounds and inches; 0.25 is misprinted .025 there."""
    steel = SCREW_MATERIALS["stainless steel"]
    for diameter, length in ((0.25, 20.0), (0.5, 48.0)):
        load = column_load(steel.modulus, steel.yield_strength, diameter * INCH, length * INCH, ENDS[ends][0]) / POUND
        assert load == pytest.approx(factor * 13.4e6 * diameter**4 / length**2, rel=0.02)


def test_short_columns_follow_johnson():
    """σ_y − (σ_y l / (2π k))² / (K E), k = d/4 (Johnson, as in Shigley); Euler's alone would be 40 % above it."""
    modulus, strength, diameter, length = 200e9, 250e6, 0.02, 0.4
    stress = strength - (strength * length / (2 * math.pi * diameter / 4)) ** 2 / modulus
    load = column_load(modulus, strength, diameter, length, 1.0)
    assert load == pytest.approx(stress * math.pi / 4 * diameter**2, rel=1e-12)
    assert load < 0.75 * column_load(modulus, 1e12, diameter, length, 1.0)


def test_shafts_whirl_at_the_speed_of_a_makers_formula():
    """Thomson: 4.76e6 d / L² rpm and inches for supported ends of steel, of a modulus of 207 instead of 200 GPa."""
    steel = SCREW_MATERIALS["steel"]
    speed = critical_speed(steel.modulus, steel.density, 0.5 * INCH, 30 * INCH, ENDS["supported-supported"][1])
    assert speed * 30 / math.pi == pytest.approx(4.76e6 * 0.5 / 30**2, rel=0.02)


def test_a_plastic_nut_is_refused_above_its_limit():
    """Iglidur B bears 0.15 MPa m/s: of 10 kg on Tr 16x4, two per cent less speed are right, two more are wrong."""
    pressure = nut_pressure(10 * 9.80665, 14e-3, 30e-3)
    limit = 0.15e6 / pressure / math.hypot(1, math.pi * 14 / 4)  # speed of the load [m/s]
    for share, exceeded in ((0.98, False), (1.02, True)):
        given = sheet(operation={"speed": f"{share * limit!r} m/s"})
        row = statics(given).rows["pv"]
        assert row.exceeded == exceeded
        assert row.worst == pytest.approx(share * 0.15e6, rel=1e-9)
    found = assess(given, samples=64)
    assert any("PV reaches 0.153 MPa m/s, the limit is 0.15 MPa m/s" in line for line in brief(found))
    near = assess(sheet(operation={"speed": f"{1.0002 * limit!r} m/s"}), samples=64)
    assert any("PV reaches 0.15 MPa m/s, 0.02 % above the limit" in line for line in brief(near))
    assert '<b class="over">0.153 MPa m/s</b><small>limit exceeded</small>' in report(found, [])


UP = {"mass": "10 kg", "orientation": "vertical"}


@pytest.mark.parametrize(
    ("friction", "load", "words"),
    [
        ({"coefficient": 0.05}, UP, "The load drops when the current is off"),
        ({"coefficient": [0.05, 0.15]}, UP, "The load can drop when the current is off"),
        ({"coefficient": 0.15}, UP, "The screw holds its load when the current is off"),
        ({"coefficient": 0.05, "static": 0.12}, UP, "Once it moves, it does not stop by itself."),
        ({"coefficient": 0.05}, {"mass": "10 kg", "orientation": "horizontal"}, "Nothing pushes the load"),
        ({"coefficient": 0.05}, UP | {"force": "-400 N"}, "The force on the load turns the screw"),
        ({"coefficient": 0.05}, UP | {"mass": "2 kg"}, "current is off, even without friction in its threads."),
        ({"coefficient": 0.05}, {"mass": "25 kg", "orientation": ["-5 deg", "5 deg"]}, "The load can drop"),
    ],
)
def test_the_line_before_the_torque_says_whether_the_load_stays(friction, load, words):
    """Static friction holds, not that of motion; within uncertainties it may not; what turns the screw has its name."""
    guide = {"guide": {"friction": "20 N"}} if load["mass"] == "2 kg" else {}
    lines = brief(assess(sheet(friction=friction, load=load, nut=None, **guide), samples=64))
    assert words in next(before for before, line in pairwise(lines) if line.startswith("The screw needs"))


def test_the_window_counts_with_its_ends():
    """From 50 to 200 N outward: lifting goes by 125 N in the middle and 200 N at worst, lowering likewise."""
    given = sheet(load={"mass": "10 kg", "force": ["50 N", "200 N"]}, operation={"speed": ["5 mm/s", "20 mm/s"]})
    found = statics(given).rows
    lift = 4e-3 / (2 * math.pi) / found["lifting_efficiency"].worst
    assert found["lifting_torque"].middle == pytest.approx(125 * lift, rel=1e-12)
    assert found["lifting_power"].worst == pytest.approx(200 * lift * 10 * math.pi, rel=1e-12)
    assert found["column_load"].worst == 200


def test_an_end_at_which_the_threads_jam_is_the_worst_one():
    """μ = 1.3 is above cot 40°: no torque lifts, though one does at the middle values and for the samples."""
    steep = {"lead_angle": "40 deg", "pitch_diameter": "9 mm"}
    friction = {"coefficient": {"low": 0.1, "mode": 0.2, "high": 1.3}}
    found = statics(sheet(thread=steep, screw={"length": "1 m"}, friction=friction)).rows
    assert (found["lifting_torque"].worst, found["lifting_efficiency"].worst) == (math.inf, 0)
    assert 0 < found["lifting_torque"].middle < 1


def test_inches_and_pounds_are_as_good_as_si():
    """The same drive in either units has the same statics."""
    inches = sheet(
        thread={"lead": "0.1 inch", "pitch_diameter": "0.45 inch"}, operation={"speed": "300 rpm"},
        screw={"length": "20 inch", "ends": "fixed-free", "root_diameter": "0.38 inch"},
        nut={"length": "1 inch", "pv_limit": "4000 psi*ft/min", "pressure_limit": "500 psi"},
        load={"mass": "2 lb", "force": "20 lbf"},
    )  # fmt: skip
    si = sheet(
        thread={"lead": "2.54 mm", "pitch_diameter": "11.43 mm"}, operation={"speed": "31.415927 rad/s"},
        screw={"length": "508 mm", "ends": "fixed-free", "root_diameter": "9.652 mm"},
        nut={"length": "25.4 mm", "pv_limit": "140.10148 kPa*m/s", "pressure_limit": "3.447379 MPa"},
        load={"mass": "0.90718474 kg", "force": "88.964432 N"},
    )  # fmt: skip
    for key, row in statics(inches).rows.items():
        other = statics(si).rows[key]
        assert row.worst == pytest.approx(other.worst, rel=1e-6)
        assert row.limit == (other.limit and pytest.approx(other.limit, rel=1e-6))


def test_the_template_is_a_sheet_that_can_be_assessed(tmp_path, capsys, monkeypatch):
    """From the shell: print it, assess it, and read the answer; nothing is written without a folder."""
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)  # which the command replaces

    def lsvib(*tokens: str) -> str:
        run(lambda: app(["assess", *tokens], exit_on_error=False, print_error=False, result_action="return_value"))
        return capsys.readouterr().out

    file = tmp_path / "drive.yaml"
    file.write_text(lsvib("--template"), encoding="utf-8")
    said = lsvib(str(file), "--samples", "64").splitlines()
    assert [line.partition(" ")[0] for line in said] == ["This", "Not", "The", "The", "All"]
    assert list(tmp_path.iterdir()) == [file]
    every = yaml.safe_load(re.sub("(?m)^  # ", "  ", file.read_text(encoding="utf-8")))
    parts = {"thread": Thread, "screw": Screw, "nut": Nut, "coupling": Coupling, "friction": Friction}
    assert all(set(every[name]) <= set(part.model_fields) for name, part in parts.items())


def test_a_change_that_lets_the_load_drop_is_known():
    """Tr 10x2 holds with 0.1 at tan λ = 0.0707; with half the diameter it is 0.141; a guide holds it still."""
    given = sheet(friction={"coefficient": 0.1}, thread={"size": "Tr 10x2"})
    draw = Draw.of(given)
    for key, factor, drops in (("pitch_diameter", 0.5, True), ("pitch_diameter", 0.9, False), ("mass", 2.0, False)):
        assert lets_go(draw, draw.scaled([key], factor)) == drops
    held = draw.changed(slide_friction=100.0)
    assert not lets_go(held, held.scaled(["pitch_diameter"], 0.5))


LEAD = math.atan(4 / (14 * math.pi))
DIP = {"coefficient": 0.03, "stribeck_rise": 0.1, "stribeck_speed": "20 mm/s", "slope": "0.1 s/m"}


def test_the_worst_friction_between_the_ends_of_the_window_counts():
    """The least is 0.03 + 0.002 (1 + ln 50), at 20 mm/s · ln 50 of sliding."""
    found = statics(sheet(load=LOAD, friction=DIP, operation={"speed": ["2 mm/s", "20 mm/s"]})).rows
    least = 0.03 + 0.002 * (1 + math.log(50))
    angle = LEAD - math.atan(least / math.cos(math.atan(math.cos(LEAD) * math.tan(math.radians(15)))))
    assert found["braking_torque"].worst == pytest.approx(7e-3 * WEIGHT * math.tan(angle), rel=1e-3)
    assert found["lowering_efficiency"].worst == pytest.approx(math.tan(angle) / math.tan(LEAD), rel=1e-3)


def test_what_may_stop_is_said():
    """Static friction holds what moves, too."""
    stops = {"coefficient": 0.1, "static": 0.3}
    assert "Once it moves, it may not stop" not in " ".join(brief(assess(sheet(load=LOAD, friction=stops), 64)))


def test_a_sizing_question_needs_no_dynamics(tmp_path):
    """A jack: thread, load, speed, friction and nut. Its statics are those of the same sheet with a drive."""
    given = {
        "name": "a jack", "thread": {"lead": "1/2 inch", "pitch": "2 tpi", "pitch_diameter": "1.75 inch"},
        "load": {"force": ["3 kN", "5 kN"]}, "operation": {"speed": "10 mm/s"},
        "friction": {"coefficient": [0.1, 0.12]}, "nut": {"length": "60 mm", "material": "iglidur_j"},
    }  # fmt: skip
    alone = Sheet.of(given)
    missing = "the inertia or length of the screw, coupling.stiffness and load.mass"
    assert alone.of_statics == f"the sheet does not give {missing}"
    load = {**given["load"], "mass": "1 kg"}
    whole = Sheet.of({**given, "load": load, "screw": {"length": "1 m"}, "coupling": {"stiffness": "100 N*m/rad"}})
    assert not whole.of_statics
    assert statics(alone) == statics(whole)
    (tmp_path / "a.yaml").write_text(yaml.safe_dump(given), encoding="utf-8")
    found = lsvib.assess(tmp_path / "a.yaml", None)
    assert found["verdict"] is None
    first = f"Vibration is not assessed: the sheet does not give {missing}. No weight is counted."
    assert found["brief"][-1] == found["sentence"] == first
    assert found["brief"][0].startswith("The screw holds its load")
