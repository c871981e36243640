"""The public interface: drives are values, methods do what the commands and functions do, nothing heavy is loaded.

Parameters of parts and frictions against the ground are varied from a drive that does not have them.
"""

import copy
import doctest
import importlib
import json
import multiprocessing
import pickle
import pydoc
import re
import subprocess
import sys
from dataclasses import fields
from inspect import signature
from operator import methodcaller
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from references.drives import DRIVES, MODELS, NEAR_FOLD, PARADOX, threads_drive, wide_drive

import lsvib
from lsvib import Drive, api
from lsvib.drives.automata import automaton_of
from lsvib.dynamics.boundary import basin
from lsvib.systems import System
from lsvib.systems.attractor import steady_state
from lsvib.systems.motion import follow

ROOT = Path(__file__).parents[2]
START = {"u": 0.1, "w": 0.0}


def random_drives(count: int):
    """Drives of every model, the values over many decades; half of them have a law."""
    laws = np.random.default_rng(1)
    for k in range(count):
        drive, law = wide_drive(MODELS[k % len(MODELS)], 1, k, 0).drive, {}
        if laws.random() < 0.5:
            law |= {"friction_slope": -(10 ** laws.uniform(-4, 0))}
        if laws.random() < 0.5:
            law |= {"stribeck_rise": 0.02, "stribeck_speed": 10 ** laws.uniform(-3, 1)}
            law |= {"stribeck_exponent": 1 + laws.integers(2)}
        if laws.random() < 0.3:
            law |= {"static_friction_coefficient": drive.friction_coefficient + 0.03}
        yield drive.replace(**law)


def test_every_public_name_is_there():
    for name in lsvib.__all__:
        assert getattr(lsvib, name).__doc__
    with pytest.raises(AttributeError, match="No lsvib attribute LeadDrive"):
        _ = lsvib.LeadDrive


def test_what_a_drive_shows_is_its_own():
    """Parameters and what can be asked: nothing of the library that checks them, nor of how the package is built."""
    drive = lsvib.Drive()
    names = {name for kind in (lsvib.Drive, api.drive.Drive) for name in vars(kind)}
    own = {name for name in names if name[0] != "_" and not name.startswith("model_")}
    assert {name for name in dir(lsvib.Drive) if name[0] != "_"} == own
    assert {name for name in dir(drive) if name[0] != "_"} == own | {*lsvib.Drive.model_fields}
    page = pydoc.plain(pydoc.render_doc(lsvib.Drive))
    assert re.findall(r"(?<!^ \|      )pydantic|Annotated|__\w+__", page) == ["pydantic"]  # among its bases
    assert [*signature(lsvib.Drive).parameters] == [*lsvib.Drive.model_fields]
    assert {name for name in dir(lsvib) if name[0] != "_"} == {*lsvib.__all__}


def test_a_name_whose_packages_are_missing_says_so_and_hides_no_other():
    program = """
import sys
sys.modules["pint"] = None
import inspect, lsvib
names = [name for name, _ in inspect.getmembers(lsvib)]
assert "Drive" in names and "assess" not in names
try:
    lsvib.assess({})
except lsvib.LsvibError as error:
    print(error)"""
    said = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
    assert said == "lsvib.assess needs pint, which is not installed: pip install 'lsvib[assess]'.\n"


@pytest.mark.parametrize("kind", DRIVES)
def test_a_coordinate_has_one_name_in_starts_and_motions(kind):
    drive = DRIVES[kind](mass=9.0, contact_damping=1e4) if kind == "threads" else DRIVES[kind]()
    start = {name: 1e-6 * place for place, name in enumerate(drive.automaton().states, 1)}
    motion = drive.simulate(start, 1e-9, samples=2)
    assert {name: float(motion[name][0]) for name in start} == pytest.approx(start)
    assert [*start][:2] == ["u", "w"]
    assert (motion.u.attrs["symbol"], motion.w.attrs["units"]) == ("$u$", "rad s-1")


def test_results_say_their_units():
    for kind in (lsvib.StabilityReport, lsvib.Threshold, lsvib.Quantity, lsvib.Condition):
        assert kind.__dataclass_params__.frozen
        missing = [field.name for field in fields(kind) if f"``{field.name}``" not in kind.__doc__]
        assert missing in ([], ["name"])


def test_drives_are_values():
    for drive in random_drives(200):
        same = type(drive)(**drive.model_dump())
        again = [same, pickle.loads(pickle.dumps(drive)), copy.deepcopy(drive), drive.replace()]
        assert {*again} == {drive}
        assert {type(one) for one in again} == {type(drive)}
        text = str(drive)
        assert eval(text, vars(api)) == drive
        shown = dict(re.findall(r"(\w+)=([^,)]+)", text))
        default = type(drive)()
        assert set(shown) == {key for key, value in drive if value != getattr(default, key)}
        changed = drive.replace(mass=2 * drive.mass)
        assert changed != drive
        assert drive not in {changed}
    assert {lsvib.Drive(mass=9)} == {Drive(mass=9.0)}
    assert lsvib.Drive() not in (threads_drive(), {})
    assert repr(lsvib.Drive(axial_force=-0.0)) == "Drive(axial_force=0.0)"


def test_a_pickled_drive_answers_in_a_process_that_has_loaded_nothing():
    drive = lsvib.Drive(mass=11)
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        assert pool.map(methodcaller("stability"), [drive]) == [drive.stability()]


def test_reports_and_thresholds_of_random_drives_are_plain_numbers():
    seen = set()
    for drive in random_drives(80):
        try:
            report = drive.stability()
        except lsvib.InputError:  # the contact carries no force
            continue
        seen.add((report.parts, report.stable))
        json.dumps(report.to_json(), allow_nan=False)
        assert report == drive.stability()
    assert {parts for parts, _ in seen} == {(), ("threads",), ("support",), ("nut",)}
    assert {stable for _, stable in seen} == {True, False}


@pytest.mark.parametrize("kind", DRIVES)
def test_thresholds_are_those_by_name(kind):
    drive = DRIVES[kind](mass=9.0, translation_damping=10.0)
    for name, found in drive.thresholds().items():
        assert (found.name, found.parts) == (name, drive.parts)
        json.dumps(found.to_json(), allow_nan=False)
        if found.value is None:
            with pytest.raises(lsvib.NoThreshold, match=re.escape(found.reason)):
                drive.threshold(name)
        else:
            assert found == drive.threshold(name)


@pytest.mark.parametrize("kind", DRIVES)
def test_simulate_is_that_of_the_function(kind):
    drive = DRIVES[kind](mass=9.0, contact_damping=1e4) if kind == "threads" else DRIVES[kind]()
    motion = drive.simulate(START, 0.02, samples=11, outputs=["screw_speed"])
    scene = {"start": START, "duration": 0.02, "samples": 11, "outputs": ["screw_speed"]}
    for given in (drive, drive.model_dump()):
        xr.testing.assert_identical(motion, lsvib.simulate({**scene, "drive": given}))
    xr.testing.assert_identical(motion, lsvib.simulate(lsvib.Scene(**scene, drive=drive)))
    begin = lsvib.Scene(**scene, drive=drive).definition.initial_state(drive, START)
    assert drive.steady_state(START).label == steady_state(drive.automaton(), begin).label


def test_examples_of_docstrings_and_documentation():
    failed = doctest.testmod(api, extraglobs={"lsvib": lsvib}).failed
    page = ROOT / "docs" / "python.md"
    result = doctest.testfile(str(page), module_relative=False)
    assert (failed, result.failed) == (0, 0)
    text, own = page.read_text(encoding="utf-8"), vars(lsvib.Drive).keys() - vars(api.drive.Drive).keys()
    assert result.attempted > 0
    assert [name for name in (*lsvib.__all__, *own) if name[0] != "_" and name not in text] == []


QUICK = (
    "answers.cycles drives.description drives.drive drives.mechanics drives.scene dynamics.boundary dynamics.curves "
    "dynamics.cycles dynamics.resilience errors results sheets.inverse sheets.output systems.attractor "
    "systems.automaton systems.continuation systems.cycles systems.ends systems.grid systems.motion systems.system"
)
LONG = [pytest.param(of, marks=pytest.mark.slow) for of in ("pictures.answers", "sheets.fit_output")]


@pytest.mark.parametrize("of", [*QUICK.split(), *LONG])
def test_examples_of_what_users_call(of, monkeypatch, tmp_path):
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    given = {"lsvib": lsvib}
    exec(doctest.script_from_examples(System.__doc__), given)  # the system that examples use
    result = doctest.testmod(importlib.import_module(f"lsvib.{of}"), extraglobs=given)
    assert result.attempted > 0
    assert result.failed == 0


@pytest.mark.slow
def test_a_type_checker_sees_the_types(tmp_path):
    """Right uses pass in strict mode and have the types they should, wrong ones are found."""
    pytest.importorskip("mypy")
    (tmp_path / "right.py").write_text(
        "import lsvib\n"
        "drive = lsvib.Drive(mass=11, axial_force=-10.0)\n"
        "reveal_type(drive.replace(mass=3))\n"
        "reveal_type(drive.stability().eigenvalues)\n"
        "reveal_type(drive.basin().area())\n"
        "reveal_type(drive.thresholds()['onset'].value)\n"
    )
    (tmp_path / "wrong.py").write_text(
        "import lsvib\nlsvib.Drive(mas=1)\nlsvib.Drive(mass='1 kg')\nlsvib.Drive().simulate(3)\n"
    )
    command = [sys.executable, "-m", "mypy", "--config-file=", "--strict", "--follow-imports=silent"]
    command += ["--cache-dir", str(ROOT / ".mypy_cache")]
    done = subprocess.run([*command, "right.py", "wrong.py"], cwd=tmp_path, capture_output=True, text=True)
    revealed = re.findall(r'right\.py:\d+: note: Revealed type is "(.*)"', done.stdout)
    assert [x.replace("builtins.", "") for x in revealed] == [
        "lsvib.api.Drive", "tuple[complex, ...]", "float", "float | None",
    ]  # fmt: skip
    assert not re.findall(r"right\.py:\d+: error", done.stdout)
    assert set(re.findall(r"wrong\.py:(\d+): error", done.stdout)) == {"2", "3", "4"}


FAR = [0.5, -40.0]
ANSWERS = {
    "Automaton": lambda: automaton_of(PARADOX),
    "Motion": lambda: follow(automaton_of(PARADOX), FAR, 1.0),
    "SteadyState": lambda: steady_state(automaton_of(PARADOX), FAR),
    "Cycle": lambda: PARADOX.cycles().cycles[0],
    "CycleBranch": lambda: PARADOX.follow(PARADOX.cycles().cycles[0], "mass", (10.99, 11.01)),
    "Basin": lambda: basin(PARADOX),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_an_answer_is_printed_in_a_few_lines(name):
    answer = ANSWERS[name]()
    assert getattr(answer, "orbit", answer) is not None
    assert repr(answer).startswith(f"{name}(")
    assert len(repr(answer)) < 400, repr(answer)
    assert ("period=0.0109438169, amplitude=0.05599717" in repr(answer)) == (name in ("SteadyState", "Cycle"))


@pytest.mark.slow
def test_a_chart_over_the_contact_is_that_of_compliant_threads():
    over = {"contact_stiffness": [1e5, 1e7, 1e9], "contact_damping": [1e2, 1e5, 1e8]}
    found = lsvib.Drive(mass=9).sweep(**over)
    right = lsvib.Drive(mass=9, contact_stiffness=1e6, contact_damping=1e6).sweep(**over)
    np.testing.assert_array_equal(found.behaviour.values, right.behaviour.values)
    np.testing.assert_array_equal(found.boundary_name.values, right.boundary_name.values)
    assert found.attrs["parts"] == "threads"


def test_a_sweep_says_the_parts_that_it_varies():
    found = lsvib.Drive().sweep(start={"u": 0.0, "w": 1.0, "thread_mismatch": 0.0}, contact_stiffness=[1e6, 1e7])
    assert found.attrs["parts"] == "threads"
    assert json.loads(found.attrs["parameters"])["contact_damping"] == 0.0


@pytest.mark.slow
def test_a_cycle_is_followed_from_a_rigid_drive_to_friction_of_its_slide():
    """The tables of both are of different kinds; the end is what the cycle of that drive is by itself."""
    drive = NEAR_FOLD.replace(axial_force=-10)
    cycle = next(cycle for cycle in drive.cycles().cycles if cycle.attracting)
    branch = drive.follow(cycle, "slide_friction", (0.0, 0.3), points=60)
    last = max(branch.points, key=lambda point: point.value)
    own = drive.replace(slide_friction=last.value).cycles().cycles
    assert last.value == 0.3
    assert min(abs(one.period / last.cycle.period - 1) for one in own) < 1e-9


def test_what_a_drive_does_not_have_is_no_reason():
    found = lsvib.Drive().thresholds("slide_friction")
    assert "computed only without friction of slide, bearing and collar" in found["stick"].reason
    assert "does not depend on" in found["negative_damping"].reason
