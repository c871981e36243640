"""A model is one new file: in a copy of the room of the drives, with nothing else changed, all layers know it."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import lsvib
from lsvib.models import threads
from lsvib.models.drive import RigidDrive
from lsvib.models.model import find_model, model_names

PACKAGE = Path(lsvib.__file__).parent
# Compliant threads on a slope, along which a part of the weight adds to the axial force.
SLOPE = '''"""The drive with compliant threads on a slope: the weight of the load adds to the axial force."""

from dataclasses import replace

from lsvib.models import threads
from lsvib.models.drive import Drive, ThreadsDrive, Value, quantity


class SlopeParameters(Drive):
    """A drive with compliant threads on a slope."""

    model, own_damping = "slope", "contact_damping"

    contact_stiffness: Value = quantity(1e8, "k_c", "N m-1", "stiffness of the thread contact", gt=0, le=1e15)
    contact_damping: Value = quantity(1e8, "c_c", "N s m-1", "damping of the thread contact", ge=0, le=1e15)
    weight: Value = quantity(0.0, "G", "N", "weight of the load along the axis", ge=-1e12, le=1e12)


def _on_the_level(drive):
    values = drive.model_dump()
    return ThreadsDrive.of(values | {"axial_force": drive.axial_force + values.pop("weight")})


def _automaton(drive, physics, resume):
    return replace(threads.MODEL.build(_on_the_level(drive), physics, resume), states=STATES)


def _start(drive, values):
    renamed = {"e" if key == "slope_e" else key: value for key, value in values.items()}
    return threads.MODEL.start(_on_the_level(drive), renamed)


def _powers(drive, automaton):
    return threads.MODEL.powers(_on_the_level(drive), automaton)


STATES = ("angle_deviation", "velocity_deviation", "slope_mismatch", "mismatch_rate")
MODEL = replace(
    threads.MODEL,
    drive=SlopeParameters,
    build=_automaton,
    start=_start,
    states=STATES,
    quantities={"slope_mismatch": ("mismatch of nut and screw along the slope", "m", "$e$")},
    optional=("slope_e", "v"),
    powers=_powers,
    section="",
)
'''
LINEAR = ("--set", "mass=9", "--set", "contact_damping=5e4", "--json")
CYCLE = ("--set", "mass=11", "--set", "support_damping=1e-3")
GRID = ("--grid", "u=-0.05:0.05:2", "w=-15:15:2", "--json")
MOTION = ("--set", "mass=11", "--set", "support_damping=1e-3", "--duration", "0.01", "--json")
COMMANDS = {
    "config": ("config", "--model", "slope", "--set", "weight=7", "--json"),
    "stability": ("stability", "--model", "slope", *LINEAR),
    "stability of threads": ("stability", "--model", "threads", *LINEAR),
    "thresholds": ("thresholds", "--model", "slope", *LINEAR),
    "thresholds of threads": ("thresholds", "--model", "threads", *LINEAR),
    "cycles": ("cycles", "--model", "slope", "--set", "axial_force=-10", *CYCLE, "--json"),  # the search asks for R
    "cycles of threads": ("cycles", "--model", "threads", "--set", "axial_force=-10", *CYCLE, "--json"),
    "map": (
        *("attraction", "--model", "slope", "--set", "axial_force=-4", "--set", "weight=-6", *CYCLE, *GRID),
        *("--out", "slope_map.nc"),
    ),
    "map of threads": (
        *("attraction", "--model", "threads", "--set", "axial_force=-10", *CYCLE, *GRID, "--out", "threads_map.nc"),
    ),
    "sweep": (
        *("sweep", "--model", "slope", "--over", "axial_force=-4:-3:2", "--set", "weight=-6", *CYCLE),
        *("--start", "u=0.05", "w=0", "--out", "slope_sweep.nc", "--json"),
    ),
    "sweep of threads": (
        *("sweep", "--model", "threads", "--over", "axial_force=-10:-9:2", *CYCLE),
        *("--start", "u=0.05", "w=0", "--out", "sweep.nc", "--json"),
    ),
    "motion": (
        *("simulate", "--model", "slope", "--set", "axial_force=-4", "--set", "weight=-6", *MOTION),
        *("--start", "u=0.05", "w=0", "slope_e=0", "--out", "slope.nc"),
    ),
    "motion of threads": (
        *("simulate", "--model", "threads", "--set", "axial_force=-10", *MOTION),
        *("--start", "u=0.05", "w=0", "e=0", "--out", "threads.nc"),
    ),
}
# The rest of the package, and with it the compiled engine, is that of the tests.
CODE = """
import contextlib, io, json, sys
import lsvib
import xarray as xr

lsvib.__path__.append(sys.argv[1])
from lsvib.api import drive_class
from lsvib.basins.grid import coordinates
from lsvib.cli.app import main
from lsvib.models.model import find_model

found = {}
for name, arguments in json.loads(sys.argv[2]).items():
    sys.argv = ["lsvib", *arguments]
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        main()
    found[name] = json.loads(printed.getvalue())
with xr.open_dataset("slope.nc") as motion:
    found["unit"] = motion.slope_mismatch.units
drive = drive_class("slope")(weight=3)
found["drive"] = [repr(drive), drive.stability().kind]
drives = [drive_class(model)(contact_damping=5e4) for model in ("slope", "threads")]
for name in ("flutter", "kinematic_constraint"):
    found[name] = [drive.threshold(name).value for drive in drives]
for name in ("slope_sweep", "sweep"):
    with xr.open_dataset(f"{name}.nc") as sweep:
        found[name] = [sweep[key].values.tolist() for key in ("attractor", "period", "peak_normal_force")]
found["coordinates"] = dict(coordinates())
try:
    find_model("wood")
except lsvib.InputError as error:
    found["refusal"] = str(error)
print(json.dumps(found))
"""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return what the commands print, and what Python says, where the file of the new model is."""
    folder = tmp_path_factory.mktemp("copy")
    shutil.copytree(PACKAGE / "models", folder / "lsvib" / "models", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("__init__.py", "__init__.pyi"):
        shutil.copy(PACKAGE / name, folder / "lsvib")
    (folder / "lsvib" / "models" / "slope.py").write_text(SLOPE, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", CODE, str(PACKAGE), json.dumps(COMMANDS)],
        env={**os.environ, "PYTHONPATH": f"{folder}:{PACKAGE.parents[1]}"},
        cwd=folder,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_its_parameters_are_shown(found):
    expected = {"value": 7.0, "unit": "N", "symbol": "G", "allowed": "-1e+12 <= weight <= 1e+12"}
    assert found["config"]["weight"] == expected


def test_its_stability_is_decided_by_its_polynomial_and_damper(found):
    slope, threads = found["stability"], found["stability of threads"]
    for key in ("kind", "eigenvalues", "characteristic_polynomial"):
        assert slope[key] == threads[key]
    assert slope["conditions"] == {key: threads["conditions"][key] for key in ("divergence", "flutter")}
    for name, threads in found["thresholds of threads"].items():
        assert found["thresholds"][name]["value"] == threads["value"]
    assert found["flutter"][0] == found["flutter"][1] > 0
    assert found["kinematic_constraint"][0] == found["kinematic_constraint"][1] > 0


def test_its_motion_is_that_of_the_equations_in_its_file(found):
    slope, threads = found["motion"], found["motion of threads"]
    assert slope["events"] == threads["events"]
    assert threads["events"]
    assert list(slope["final_state"].values()) == list(threads["final_state"].values())
    assert slope["peak_normal_force"] == threads["peak_normal_force"]
    assert found["unit"] == "m"


def test_its_cycles_and_its_map_are_those_of_the_equations_in_its_file(found):
    slope, threads = (
        [(cycle["label"], cycle["period"]) for cycle in found[name]["cycles"]]
        for name in ("cycles", "cycles of threads")
    )
    assert slope == threads
    assert threads[0][0].endswith("_cycle")
    assert found["map"]["cells"] == 4
    assert found["map"]["unresolved"] == 0
    assert found["map"]["fractions"] == found["map of threads"]["fractions"]


def test_its_sweep_takes_no_tables_of_another_model(found):
    """The tables of many drives with compliant threads are made at once; those of this one know its weight."""
    assert found["slope_sweep"][0] == found["sweep"][0] == [int(lsvib.Attractor.SPRAG_SLIP_CYCLE)] * 2
    for mine, theirs in zip(found["slope_sweep"][1:], found["sweep"][1:], strict=True):
        assert mine == pytest.approx(theirs, rel=1e-9)


def test_grids_and_drives_know_it(found):
    assert found["drive"] == ["SlopeParameters(weight=3.0)", "stable"]
    assert found["coordinates"]["slope_e"] == "slope_mismatch"


def test_a_name_without_a_file_is_refused_with_the_names_that_have_one(found):
    assert found["refusal"] == f"model = 'wood' is not one of {', '.join(model_names())}, slope."


def test_a_copied_file_whose_drives_still_bear_the_old_name_is_refused(monkeypatch):
    monkeypatch.setattr(threads, "MODEL", replace(threads.MODEL, drive=RigidDrive))
    with pytest.raises(lsvib.InputError, match="has drives with model = 'rigid'; their class needs model = 'threads'"):
        find_model("threads")
