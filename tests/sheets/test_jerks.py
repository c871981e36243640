"""What jerks tell of a drive: records of drives that are known, the measured screw, and what is not told."""

import json
import math

import numpy as np
import pytest
import yaml
from references.starts import STEP, commanded, motion, recorded

import lsvib
from lsvib.errors import InputError
from lsvib.sheets.fit_output import as_json, blocks, sentences, text_of
from lsvib.sheets.fit_sheet import fit_sheet
from lsvib.sheets.torque.stick_slip import combined, slowest

RPM = math.pi / 30
KNOWN = lsvib.Drive(
    pitch_radius=5.5e-3, lead_angle=math.atan(2 / (11 * math.pi)), screw_inertia=2.2e-6, mass=0.3, axial_force=-2.0,
    coupling_stiffness=0.03, support_damping=2.5e-4, friction_coefficient=0.3, static_friction_coefficient=0.5,
)  # fmt: skip
SPEEDS = (2.0, 10.0, 20.0, 40.0, 80.0)  # rpm; below 7 rpm it jerks
SHEET = {
    "thread": {"lead": "2 mm", "pitch_diameter": "11 mm"}, "screw": {"inertia": "2.2e-6 kg*m^2"},
    "load": {"force": "2 N", "mass": "0.3 kg", "orientation": "horizontal"},
    "friction": {"stribeck_rise": 0, "slope": "0 s/m"},
    "bearing": {"coulomb": "0 mN*m", "viscous": "0 mN*m*s/rad"},
    "measurements": {
        "files": "*.csv", "averaging": "10 ms", "time": {"column": 1, "unit": "s"},
        "speed": {"column": 2, "unit": "rad/s"}, "torque": {"column": 3, "unit": "N*m"},
    },
}  # fmt: skip


def record(folder, drive, rpm, interval=0.03, averaging=0.01, count=700):
    """Write what a recorder shows of a drive from rest, each sample a mean over some time, with noise."""
    own = drive.replace(input_speed=rpm * RPM)
    fine = 10
    motion = own.simulate("rest", interval * count, samples=round(interval / averaging) * fine * count + 1)
    speed = own.input_speed + motion.w.values
    motor = motion.coupling_torque.values - own.support_damping * speed  # k (Ω t − θ) + c (Ω − θ′) but for a constant
    kept = slice(round(0.1 * count), count)
    rows = []
    for values in (speed, motor):
        means = values[1:].reshape(-1, round(interval / averaging), fine)[:, -1].mean(axis=1)
        rows.append(means[kept])
    noise = np.random.default_rng(int(abs(rpm))).standard_normal(rows[1].size) * 0.01 * abs(rows[1]).mean()
    times = interval * np.arange(rows[0].size)
    lines = (f"{t:.6g},{w:.6g},{torque:.8g}" for t, w, torque in zip(times, rows[0], rows[1] + noise, strict=True))
    (folder / f"{rpm:+.0f}.csv").write_text("s,rad/s,N m\n" + "\n".join(lines) + "\n")


def sheet(folder, **more):
    """Write a sheet with changed entries; its path."""
    path = folder / "sheet.yaml"
    path.write_text(yaml.safe_dump({**SHEET, **more}))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    found = tmp_path_factory.mktemp("records")
    for rpm in SPEEDS:
        for sense in (1, -1):
            record(found, KNOWN, sense * rpm)
    return found


def test_a_drive_is_found_again_by_its_records(folder):
    """Friction by the files that are even, static friction and stiffness by those that jerk, damping within bounds."""
    found = fit_sheet(sheet(folder))
    told, main = found.stick_slip, found.fit.main
    kinds = {table.record.file: table.record.kind for table in found.tables}
    assert {name for name, kind in kinds.items() if kind == "jerks"} == {"+2.csv", "-2.csv"}
    assert main.values["friction_coefficient"] == pytest.approx(0.3, abs=3e-3)
    assert main.static["static_friction_coefficient"][0] == pytest.approx(0.5, abs=0.02)
    assert told.stiffness[0] == pytest.approx(0.03, abs=max(3 * told.stiffness[1], 3e-4))
    assert told.damping[0] <= KNOWN.support_damping <= told.damping[1]
    exact = [abs(KNOWN.replace(input_speed=s).threshold("even_speed").solutions[0].value) for s in (1.0, -1.0)]
    assert 2 * RPM < told.even_speed < 10 * RPM
    assert 2 * RPM < max(exact) < 10 * RPM
    assert len(told.periods) == 2
    assert told.by_periods == pytest.approx(KNOWN.support_damping, rel=0.25)
    assert told.uneven[0] < 2 * told.uneven[1]
    for seen, model in told.periods:
        assert seen == pytest.approx(model, rel=0.04)
    assert found.too_lively is None


def test_what_is_not_told_has_a_reason(folder, tmp_path):
    alone = fit_sheet(sheet(folder, screw=None))
    assert alone.stick_slip.damping is None
    assert "not known: they need screw.inertia, too" in " ".join(sentences(alone))
    assert "coupling" not in yaml.safe_load(blocks(as_json(alone)))
    rough = fit_sheet(sheet(folder, friction={**SHEET["friction"], "coefficient": 0.9}))
    assert "breaks loose is not above that of slow sliding" in rough.stick_slip.doubt
    pressed = fit_sheet(sheet(folder, nut={"preload": "1 N"}))
    assert "preloaded nut cannot be computed" in pressed.stick_slip.doubt
    only = tmp_path / "only"
    only.mkdir()
    for name in ("+2.csv", "-2.csv"):
        (only / name).write_text((folder / name).read_text())
    with pytest.raises(InputError, match="jerks in all files"):
        fit_sheet(sheet(only))
    rows = {**SHEET["measurements"], "point": "row"}
    with pytest.raises(InputError, match="point: row makes each row a point"):
        fit_sheet(sheet(folder, measurements=rows))
    slow = fit_sheet(sheet(folder, measurements={**SHEET["measurements"], "averaging": "2 s"}))
    assert "no file surely shows steady running" in slow.stick_slip.doubt
    both = {**SHEET["measurements"], "sampling": "30 ms"}
    with pytest.raises(InputError, match=r"measurements.time and measurements.sampling are both given"):
        fit_sheet(sheet(folder, measurements=both))


def test_starts_give_the_inertia_that_a_sheet_lacks(folder, tmp_path):
    """As measured it holds the load, m r_m tan λ ∂T/∂W; what is left bounds the damping as a given inertia does."""
    for path in folder.glob("*.csv"):
        (tmp_path / path.name).write_text(path.read_text())
    slope, radius = math.tan(KNOWN.lead_angle), KNOWN.pitch_radius
    for k, sense in enumerate((1, -1, 1, -1)):
        arm = sense * radius * (0.3 + sense * slope) / (1 - sense * 0.3 * slope)
        whole, kinetic = KNOWN.screw_inertia + 0.3 * radius * slope * arm, 2.0 * sense * arm
        command = commanded(100, 20.0, (sense,))
        rows, _ = motion(command, whole, kinetic, 1.6 * kinetic, 3e-5, 0.1)
        speed, torque = recorded(rows, np.random.default_rng(k), 0.25, (0.01, 5e-6), (0.01, 1e-6))
        lines = (f"{STEP * i:.6g},{w:.6g},{t:.8g}" for i, (w, t) in enumerate(zip(speed, torque, strict=True)))
        (tmp_path / f"start{k}.csv").write_text("\n".join(lines) + "\n")
    found = fit_sheet(sheet(tmp_path, screw=None))
    value, error = found.inertia
    assert abs(value - KNOWN.screw_inertia) < 1.96 * error < 0.2e-6
    assert found.stick_slip.damping[0] <= KNOWN.support_damping <= found.stick_slip.damping[1]
    result = as_json(found)
    json.dumps(result, allow_nan=False)
    starts = [record for record in result["records"] if record["file"].startswith("start")]
    assert all({"inertia", "standard_errors"} <= set(record) for record in starts)
    assert yaml.safe_load(blocks(result))["screw"]["inertia"]["mean"] == f"{value:.6g} kg*m^2"
    said = " ".join(result["said"])
    assert f"give an inertia of {value:.4g}" in said
    assert "Left out of start0.csv: start0.csv: " not in said
    assert "start0.csv inertia " in text_of(result)
    starts = fit_sheet(sheet(tmp_path, measurements={**SHEET["measurements"], "files": "start*.csv"})).fit.main
    assert abs(starts.values["friction_coefficient"] - 0.3) < 2.6 * starts.errors["friction_coefficient"] < 0.03


def test_one_record_of_jerks_is_enough(folder):
    """One torque has no scatter; its own error stands for that of the static coefficient."""
    found = fit_sheet(sheet(folder, measurements={**SHEET["measurements"], "files": "+*.csv"}))
    low, high = found.stick_slip.damping
    assert low <= KNOWN.support_damping <= high
    json.dumps(as_json(found), allow_nan=False)
    light = fit_sheet(sheet(folder, screw={"inertia": "1e-15 kg*m^2"}))
    assert "check screw.inertia" in light.stick_slip.doubt


def test_without_a_time_a_file_is_a_point_as_it_was(folder):
    untimed = {key: value for key, value in SHEET["measurements"].items() if key not in ("time", "averaging")}
    plain = fit_sheet(sheet(folder, measurements={**untimed, "files": "*0.csv"}))
    assert len(plain.points) == 8
    assert {table.record for table in plain.tables} == {None}
    with pytest.raises(InputError, match="does not run at one speed"):
        fit_sheet(sheet(folder, measurements=untimed))
    sampled = fit_sheet(sheet(folder, measurements={**untimed, "sampling": "30 ms"}))
    assert sampled.stick_slip is not None


def test_estimates_are_weighed_and_the_slowest_files_are_kept():
    assert combined([(1.0, 0.1), (1.0, 0.1)]) == pytest.approx((1.0, math.hypot(0.1 / math.sqrt(2), 0.02)))
    mean, error = combined([(1.0, 0.01), (2.0, 0.01)])
    assert (mean, error) == pytest.approx((1.5, math.hypot(0.5, 0.03)))  # they differ by more than their errors say
    files = [(1.0, 5.0, 0.1), (-3.0, 5.0, 0.1), (2.0, 5.0, 0.1), (4.0, -5.0, 0.1)]
    assert sorted(slowest(files)) == [(-3.0, 5.0, 0.1), (1.0, 5.0, 0.1), (4.0, -5.0, 0.1)]
