"""What drives, motors and oscilloscopes log of a shaft that is known, T = J dω/dt + C sgn ω + B ω with noise."""

import math

import numpy as np
import pytest
import yaml
from references.command_line import refused
from references.sizes import sizes

from lsvib.sheets.fit_output import as_json, blocks
from lsvib.sheets.fit_sheet import fit_sheet

LAW = {"inertia": 1.15e-4, "coulomb": 0.05, "viscous": 2.8e-4}
RPM, NOISE = math.pi / 30, 3e-3
SPEEDS = {  # over time [s], its samples, and what is between them
    "trapezoid": (700, 1e-3, lambda t: np.interp(t, [0.05, 0.25, 0.45, 0.65], [0, 190, 190, 0])),
    "triangle": (700, 1e-3, lambda t: np.interp(t, [0.05, 0.35, 0.65], [0, 190, 0])),
    "sine": (2000, 1e-3, lambda t: 120 * np.sin(8 * t)),
    "sweep": (2000, 1e-2, lambda t: np.interp(t, [1, 5, 9, 11, 15, 19], [0, 100, 0, 0, -100, 0])),
}
FORMS = {  # of columns of time [s], speed, position and torque: motion, cells, and the sheet
    "trapezoid": ("trapezoid", lambda t, w, q, m: (1e3 * t, w, m), {}),
    "triangle": ("triangle", lambda t, w, q, m: (1e3 * t, w, m), {}),
    "percent": ("sweep", lambda t, w, q, m: (1e3 * t, w / RPM, m / 0.32e-2),
             {"speed": {"column": 2, "unit": "rpm"}, "torque": {"column": 3, "unit": "%", "rated_torque": "0.32 N*m"}}),
    "degrees": ("sine", lambda t, w, q, m: (1e3 * t, np.degrees(q) % 360, m / 0.052),
                {"position": {"column": 2, "unit": "deg"},
                 "current": {"column": 3, "unit": "A", "torque_constant": "52 mN*m/A"}}),
    "counts": ("sine", lambda t, w, q, m: (1e3 * t, np.floor(q * 4096 / math.tau), m / 0.32e-3),
               {"position": {"column": 2, "unit": "counts", "counts_per_turn": 4096},
                "torque": {"column": 3, "unit": "permille", "rated_torque": "0.32 N*m"}}),
    "jitter": ("sweep", lambda t, w, q, m: (np.floor(1e3 * t + 3 * np.sin(1e4 * t)), w, m), {}),
}  # fmt: skip


def logged(folder, form, seed, factor=1.0):
    """Write a table with a header, semicolons and decimal commas, and its sheet; its path."""
    motion, cells, more = FORMS[form]
    count, step, course = SPEEDS[motion]
    at, fine = step * np.arange(count), step * np.arange(-1, 20 * count) / 20
    speed, angle = course(at), np.interp(at, fine, np.cumsum(course(fine)) * step / 20)
    rate = (course(at + 1e-6) - course(at - 1e-6)) / 2e-6
    torque = LAW["inertia"] * rate + LAW["coulomb"] * np.sign(speed) + LAW["viscous"] * speed
    torque = factor * (torque + NOISE * np.random.default_rng(seed).standard_normal(count))
    rows = zip(*cells(at, speed, angle, torque), strict=True)
    text = "".join(";".join(f"{cell:.9g}" for cell in row).replace(".", ",") + "\n" for row in rows)
    (folder / "trace.csv").write_text(f"Trace 1\n\nZeit [ms];Istwert;Moment\n{text}", encoding="utf-8-sig")
    block = {"files": "trace.csv", "separator": ";", "decimal": ",", "time": {"column": 1, "unit": "ms"}}
    usual = {"speed": {"column": 2, "unit": "rad/s"}, "torque": {"column": 3, "unit": "N*m"}}
    (folder / "sheet.yaml").write_text(yaml.safe_dump({"measurements": block | (more or usual)}))
    return folder / "sheet.yaml"


@pytest.mark.parametrize("seeds", sizes([range(5)], [], [range(100)]), ids=len)
@pytest.mark.parametrize("form", FORMS)
def test_one_log_tells_inertia_and_friction_within_its_errors(form, seeds, tmp_path):
    """Within two standard errors in 95 %, less four deviations of the count, and known to a tenth."""
    off = []
    for seed in seeds:
        found = fit_sheet(logged(tmp_path, form, seed))
        main, (inertia, unsure) = found.fit.main, found.inertia
        value, error = main.values | {"inertia": inertia}, main.errors | {"inertia": unsure}
        off.append([abs(value[name] - LAW[name]) / error[name] for name in LAW])
        assert all(error[name] < 0.1 * LAW[name] for name in LAW)
    assert (np.mean(np.array(off) < 2, axis=0) >= 0.95 - 4 * math.sqrt(0.95 * 0.05 / len(seeds))).all()
    assert set(yaml.safe_load(blocks(as_json(found)))) == {"bearing", "screw", "drive"}


def test_a_torque_of_the_other_sign_is_told_from_friction(tmp_path, run):
    path = logged(tmp_path, "trapezoid", 1, factor=-1)
    assert "write factor: -1 in measurements.torque." in refused(run, "fit", str(path))
    path.write_text(path.read_text().replace("torque:\n", "torque:\n    factor: -1\n"))
    assert fit_sheet(path).inertia[0] == pytest.approx(LAW["inertia"], rel=0.01)


def test_a_sweep_one_way_says_that_acceleration_counts_as_friction(tmp_path, run):
    path = logged(tmp_path, "percent", 0)
    (tmp_path / "trace.csv").write_text("\n".join((tmp_path / "trace.csv").read_text().splitlines()[:503]))
    assert "and torque for acceleration, of up to 2" in run("fit", str(path))[1]
    path.write_text(path.read_text() + "screw: {inertia: 1.15e-4 kg*m^2}\n")
    main = fit_sheet(path).fit.main
    assert abs(main.values["coulomb"] - LAW["coulomb"]) < 2 * main.errors["coulomb"]
