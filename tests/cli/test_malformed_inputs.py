"""Malformed inputs of all commands, files and the Python interface: one sentence, exit code 2, nothing written."""

import copy
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from references.command_line import complaint, refused, state_of_the_folder
from references.drives import JERKING, NEAR_FOLD, NEGATIVE_DAMPING, PARADOX, nut_drive, support_drive, threads_drive

import lsvib
from lsvib.answers.io import read_dataset
from lsvib.chapter.configuration import DEFAULT, checked
from lsvib.drives.scene import read_yaml
from lsvib.systems.grid import Grid

SETTINGS = read_yaml(DEFAULT)
RANGE = "is outside the allowed range"
UNKNOWN = "is not a known key"
MOTION = "simulate --start u=0.1 w=0 --duration 0.1 --out x.nc"
MAP = "attraction --grid u=-0.1:0.1:4 w=-8:8:4 --out x.nc"

# In the folder there are a file "text", a pipe, a folder, links, and "scene.yaml".
COMMANDS = [
    ("nonsense", "nonsense"),
    ("thresholds --nonsense", "--nonsense"),
    ("simulate", "--out"),
    # Parameters.
    ("thresholds --set mass", "'mass' is not of the form KEY=VALUE"),
    ("thresholds --set masss=1", "masss is not a known key; perhaps mass is meant."),
    ("thresholds --set z=1", "z is not a known key; the known keys are pitch_radius, "),
    ("thresholds --set m=11", "m is not a known key; m is the symbol of mass."),
    ("thresholds --set lambda=0.1", "lambda is not a known key; lambda is the symbol of lead_angle."),
    ("sweep --over R=1:2:2", "'R' is not a known key; R is the symbol of axial_force."),
    ("thresholds --for k", "unknown = 'k' is not a parameter of this drive; k is the symbol of coupling_stiffness."),
    ("thresholds --for contact_stiffness", "'contact_stiffness' is not a parameter of this drive; the known keys are "),
    ("thresholds --set mass=1 --set mass=2", "mass is given twice"),
    ("config --set mass=1,5", "mass = '1,5' is not a number; the allowed range is 1e-18 <= mass <= 1e+09"),
    ("config --set mass=nan", "mass = 'nan' is not a number"),
    ("config --set mass=-1", f"mass = -1.0 {RANGE} 1e-18 <= mass <= 1e+09"),
    ("config --set lead_angle_deg=95", f"{RANGE} 5.72958e-05 <= "),
    ("config --set lead_angle=0.1 --set lead_angle_deg=5", "both given"),
    ("config --set input_speed=1e-13", "0 or 1e-12 <= |input_speed| <= 1e+09"),
    ("stability --set input_speed=0", "input_speed = 0 holds the motor still"),
    ("thresholds --set input_speed=0", "input_speed = 0 holds the motor still"),
    ("config --set slide_friction=3 --set slide_static_friction=2",
     f"slide_static_friction = 2 {RANGE} 0 or slide_friction = 3 <= slide_static_friction <= 1e+12"),
    ("config --set bearing_friction=3 --set bearing_static_friction=2", "0 or bearing_friction = 3 <= bearing_static"),
    ("stability --set friction_coefficient=10.3", f"friction_coefficient = 10.3 {RANGE}"),
    ("stability --set axial_force=0", "axial_force"),
    ("stability --set contact_damping=1", "contact_damping is a parameter of compliant threads, which need contact_st"),
    ("stability --set screw_mass=1", "screw_mass is a parameter of a compliant axial support, which needs support_st"),
    # Thresholds.
    ("thresholds --solve stuck", "threshold = 'stuck' is not a threshold of this drive; those are even_speed, on"),
    ("thresholds --solve stick --for weight", "unknown = 'weight' is not a parameter of this drive"),
    ("thresholds --for weight", "unknown = 'weight' is not a parameter of this drive"),
    # Motions.
    ("simulate --start u=0.1 --duration 1 --out x.nc", "it needs u and w"),
    ("simulate --start u=0 w=0 --out x.nc", "duration is missing"),
    ("simulate --start u=x w=0 --duration 1 --out x.nc", "u=x has a part that is not a number"),
    ("simulate --start u=0 w=0 --duration -1 --out x.nc", "duration = -1"),
    (f"{MOTION} --samples 1", "samples = 1"),
    (f"{MOTION} --samples 10.5", "Invalid value for --samples: '10.5' is not a whole number."),
    ("figure 8.8 --config folder", "Cannot read folder: Is a directory"),
    # Maps, charts, sweeps and what else has axes.
    ("attraction --grid u=-0.1:0.1:4 --out x.nc", "of two coordinates; 1 given"),
    ("attraction --grid u=1:0:4 w=0:1:4 --out x.nc", "start < stop"),
    ("attraction --grid u=0:1 w=0:1:4 --out x.nc", "KEY=START:STOP:COUNT"),
    ("attraction --grid u=0:1:4 q=0:1:4 --out x.nc", "keys u, q; it needs u and w"),
    (f"{MAP} --quantities colour", 'Invalid value "colour" for --quantities'),
    (f"{MAP} --workers 0", "workers = 0"),
    (f"{MAP} --figure map.pdf", ".png"),
    ("sweep --over axial_force=1:60 --out x.nc", "KEY=START:STOP:COUNT"),
    ("sweep --over mass=-1:1:3 --out x.nc", "mass = -1"),
    ("sweep --over mass=1:2:3 --set mass=4 --out x.nc", "mass is both varied and set; give it once."),
    ("sweep --over lead_angle=0.1:0.2:3 --set lead_angle_deg=4", "lead_angle is both varied and set; give it once."),
    ("attraction --grid u=0:1:20 w=0:1:1000000000 --out x.nc", "1 <= count <= 10000000"),
    ("attraction --grid u=0:1:10000 w=0:1:10001 --out x.nc", "grid has 100010000 cells; the allowed range is up to"),
    ("sweep --over mass=1:2:10000000 --over axial_force=1:2:10000000", "over has 100000000000000 points"),
    ("sweep --over contact_damping=0:1e6:3", "its values have equal ratios, so both must be > 0"),
    ("sweep --over input_speed=-5:5:3", "from a start (simulate, sweep, attraction)"),
    ("follow --set mass=11 --over axial_force=-18 --out x.nc", "KEY=LOW:HIGH"),
    ("resilience --window u=-0.3", "Invalid value for --window: 'u=-0.3' is not of the form KEY=LOW:HIGH"),
    # Figures.
    ("figure 8.99", "figure 8.99 is not one of 8.1, 8.2, "),
    ("figure 8.8 --config none.yaml", "none.yaml"),
    ("figure 8.8 --set mass=9", "does not depend on mass of its drive, so --set mass would change nothing; what it "),
    ("figure 8.6 --set mass=2", "mass = 2, none of mass_readings: 1 and 8"),
    ("figure 8.8 --out text", "is not a folder"),
    # Files.
    (MOTION.replace("x.nc", "folder"), "it is a folder"),
    (MOTION.replace("x.nc", "text/x.nc"), "text is not a folder"),
    (MOTION.replace("x.nc", "long" * 99), "File name too long"),
    (MOTION.replace("x.nc", "pipe"), "pipe"),
    ("simulate --scene scene.yaml --out to_scene", "reads"),
    (MOTION.replace("x.nc", "x.xlsx"), "out = x.xlsx must end in .nc or .csv."),
    (f"{MOTION} --outputs heat", "outputs cannot have 'heat'; of this drive it can have normal_force, "),
    ("fit sheet.yaml --out x.csv", "out = x.csv names a file, but this command writes fit.nc, "),
    ("figure 8.8 --out x.csv", "out = x.csv names a file, but this command writes dataset, checks, "),
    *((words, "belongs to the workflow") for words in (
        "figure 8.3 --out results/datasets", "figure 8.3 --out results/figures", "figure 8.3 --out results/checks",
        MOTION.replace("x.nc", "results/datasets/file.nc"), MAP.replace("x.nc", "results/datasets/attraction.nc"),
        "sweep --over mass=1:20:2 --out results/datasets/file.nc",
        f"{MAP} --figure results/figures/attraction.png",
        "follow --over mass=10.2:14 --set mass=11 --out results/datasets/file.nc",
        "assess sheet.yaml --out results/assessments/sheet",
    )),
]  # fmt: skip
# Files of scenes.
SCENES = [
    ("drive: {mass: [1\n", "not valid YAML"),
    ("- 1\n", "names and values"),
    ("drive: {mass: 1, mass: 2}\n", "mass is given twice"),
    ("drive: {mass: 0x1F}\n", "not valid YAML: invalid literal for int"),
    ("drive: {mass: 01e-30}\n", "mass"),
    ("drive: {mass: 11, weight: 2}\nstart: {u: 0.1, w: 0}\nduration: 1\n", f"weight {UNKNOWN}"),
    ("drive: {k_c: 1e8}\nstart: {u: 0.1, w: 0}\nduration: 1\n", "k_c is the symbol of contact_stiffness."),
    ("drive: {mass: '11 kg'}\nstart: {u: 0.1, w: 0}\nduration: 1\n", "mass = '11 kg' is not a number"),
    ("start: {u: left, w: 0}\nduration: 1\n", "start.u = 'left'"),
    ("start: {u: 0.1, w: 0}\nduration: 1\nphysics: [gravity]\n", "gravity"),
    ("start: {u: 0.1, w: 0}\nduration: 1\noutputs: [temperature]\n", "temperature"),
]
# Changes of the settings of a figure: place, value, words.
SECTIONS = [
    (("mass", "count"), 1, f"fig8_08.mass.count = 1 {RANGE} 2 <= count"),
    (("mass", "start"), "1e-3", "such as 5 or 1.0e-3"),
    (("mass", "cuont"), 5, f"fig8_08.mass.cuont {UNKNOWN}"),
    (("dampings",), [], "fig8_08.dampings = [] is not long enough; it needs at least 1."),
    (("dampings",), [1e-4, -1], f"fig8_08.dampings.1 = -1 {RANGE} 0 <= "),
    (("gain",), 5, f"fig8_08.gain {UNKNOWN}; the known keys are drive, "),
    (("drive",), {"mass": -1}, RANGE),
]
GRID = {"u": (0, 1, 4), "w": (0, 1, 4)}
U, W = lsvib.Axis("u", -0.1, 0.1, 4), lsvib.Axis("w", -5, 5, 4)
MASKED = np.ma.masked_array([1.0, 2.0], [False, True])
SPAN = {"start": -1.0, "stop": 1.0, "count": 3}
DRIVE, LIGHT = lsvib.Drive, NEGATIVE_DAMPING
SLIDES = {"stribeck_rise": 0.05, "stribeck_speed": 0.1}  # under a law
FALLING = DRIVE(friction="powered_seat", translation_damping=1000, axial_force=35)
ROUGH = LIGHT.replace(static_friction_coefficient=0.3, axial_force=35)
RUBS = DRIVE(slide_friction=2, support_damping=0)
LET_GO = DRIVE(input_speed=0)
RESISTED, CUT_OFF = NEAR_FOLD.replace(axial_force=-18), DRIVE(friction_slope=-2, support_damping=0, input_speed=30)
OF_CONSTANT = "the threshold {} is computed only for friction that does not depend on speed."
OF_LEVEL = "is computed only for static friction that does not exceed sliding friction."
FAST_NUT = {"mass": 24, "support_damping": 1.15e-3, "translation_damping": 2820, "friction_coefficient": 0.1974}
CLOSED = ("detach", "global_stability")


def branch(parameter, span, of=NEAR_FOLD):
    """Of a drive, from a cycle of the one near the fold."""
    return of.follow(NEAR_FOLD.cycles().cycles[0], parameter, span)


REFUSED_BASINS = [
    ({"mass": 11, "axial_force": 10}, "attracts no motion"),
    ({"mass": 1, "translation_damping": 1000, "axial_force": 25}, "attracts no motion"),
    ({"mass": 11, "axial_force": 0}, "balances the translation damping"),
    ({"mass": 11, "support_damping": 0, "axial_force": -10}, "attracts no motion"),
    ({"mass": 11, "support_damping": 1e-3, "translation_damping": 5000, "axial_force": -1000}, "cannot be computed"),
    ({"mass": 5, "support_damping": 4.7e-5, "translation_damping": 10600, "axial_force": -0.16}, "turning back"),
    ({**FAST_NUT, "axial_force": 40.56}, "rest does not settle"),
    ({"friction": "powered_seat", "axial_force": 100}, "attracts no motion"),
    ({"friction": "powered_seat", "mass": 11, "axial_force": -20}, "this friction law enters the Painlevé region"),
    ({"static_friction_coefficient": 0.3}, "the boundary of the basin is computed only for static friction"),
    ({"friction": "powered_seat", "static_friction_coefficient": 0.3}, "only for static friction that does not exceed"),
]
REFUSED_THRESHOLDS = [
    (LIGHT, ("stick", 3), "unknown = 3 is not a parameter"),
    (LIGHT, ("kinematic_constraint", "axial_force"), "the threshold kinematic_constraint of this drive does not"),
    (LIGHT.replace(friction_coefficient=0.05), ("kinematic_constraint",), "no mass in the allowed range"),
    (support_drive(mass=1e-6), ("kinematic_constraint", "friction_coefficient"), "no friction_coefficient in the"),
    (LIGHT, ("kinematic_constraint", "lead_angle"), "no lead_angle in the allowed range 1e-06 <= lead_angle < 1.5708"),
    (LIGHT, ("flutter",), "threshold = 'flutter' is not a threshold of this drive"),
    (RUBS, ("flutter",), "'flutter' is not a threshold of this drive; those are even_speed, onset, kinematic_const"),
    (LIGHT, ("stick", "friction_slope"), "is computed only for a single friction coefficient."),
    (RESISTED, ("detach", "mass"), "no mass within 6 decades of the drive's own value makes"),
    (PARADOX.replace(mass=10.0), ("global_stability",), "not in the Painlevé region"),
    (PARADOX.replace(support_damping=0.0), ("global_stability",), "attracts no motion"),
    (PARADOX.replace(translation_damping=2000.0, support_damping=0.1), ("global_stability",), "and every one with"),
    (FALLING, ("onset", "stribeck_exponent"), "stribeck_exponent is either 1 or 2"),
    (DRIVE(), ("onset", "stribeck_rise"), "no threshold is solved for stribeck_rise without stribeck_speed > 0."),
    (DRIVE(mass=11), ("onset", "input_speed"), "for all input speeds below zero and for none on the other side"),
    (RUBS.replace(mass=11, slide_static_friction=20), ("onset", "slide_friction"), "stable for any slide friction"),
    (ROUGH, ("stick", "static_friction_coefficient"), "stick does not depend on static_friction_coefficient."),
    (JERKING.replace(static_friction_coefficient=0), ("even_speed",), "ends in steady sliding at every input_speed"),
    (JERKING.replace(support_damping=0), ("even_speed",), "the motion from rest does not end in steady sliding at any"),
    *((FALLING, (name, key), OF_CONSTANT.format(name)) for name in ("stick", *CLOSED) for key in (None, "mass")),
    *((ROUGH, (name,), OF_LEVEL) for name in CLOSED),
    # Beyond the cut a condition vanishes throughout, which is no root.
    *((CUT_OFF, ("onset", key), "stable for any ") for key in ("pitch_radius", "input_speed", "lead_angle")),
]
PYTHON = [
    (lambda: lsvib.simulate("none.yaml"), "none.yaml"),
    (lambda: lsvib.simulate({"start": {"u": 0}, "duration": 1}), "start"),
    (lambda: lsvib.Drive(mass=None), "is not a number"),
    (lambda: lsvib.Drive(mas=1), UNKNOWN),
    (lambda: threads_drive(screw_mass=1), "needs support_stiffness as well"),
    (lambda: lsvib.Drive().simulate({"u": 0, "w": 0}, 1, outputs=["axial_contact_force"]), "outputs"),
    (lambda: threads_drive().basin(), "rigid drives without friction"),
    (lambda: lsvib.Drive().attraction({"u": (0, 1), "w": (0, 1, 4)}), "axis u has 2 numbers"),
    (lambda: lsvib.Drive().attraction(GRID, workers="many"), "workers = 'many'"),
    (lambda: read_dataset("text"), "not a readable netCDF file"),
    *((lambda name=name: read_dataset(name), f"{name} is not a regular file.") for name in ("folder", "pipe")),
    (lambda: lsvib.Drive().simulate("rset", 1), "= 'rset' is not a set of names and values, such as u: 0.1 and w:"),
    (lambda: lsvib.Drive().simulate("rest", 1, outputs=5), "outputs = 5 is not a list."),
    (lambda: checked({**SETTINGS, "colour": 1}), UNKNOWN),
    (lambda: NEAR_FOLD.follow(NEAR_FOLD.cycles(), "axial_force", (-18.5, -18.35)), "follow takes one cycle"),
    (lambda: NEAR_FOLD.sweep(mass=np.array(1.0)), "mass = array(1.) is not a list of numbers"),
    (lambda: NEAR_FOLD.sweep(mass=np.ones((2, 2))), "is not a list of numbers"),
    (lambda: NEAR_FOLD.sweep(mass=MASKED), "mass has a value that is not a number"),
    (lambda: lsvib.Drive(mass=np.ma.masked), "mass = masked is not a number"),
    (lambda: NEAR_FOLD.simulate({"u": MASKED[1], "w": 0}, 0.1), "start.u = masked is not a number"),
    (lambda: setattr(NEAR_FOLD, "mass", 5), "drive.replace(mass=...) makes another one"),
    (lambda: lsvib.Drive(nut_stiffness=1.0), "is a parameter of a nut that may turn, which needs nut_inertia"),
    (lambda: lsvib.Axis("u", 0, float("nan"), 3), "stop = nan is not a number"),
    (lambda: lsvib.Axis("u", 0, float("inf"), 3), "stop = inf is outside"),
    *((lambda count=count: lsvib.Axis("u", 0, 1, count), " 1 <= count <= ") for count in (0, -3, True, "x", 2.5)),
    (lambda: lsvib.Grid(U, 3), "a grid needs two axes"),
    (lambda: lsvib.Grid(U, U), "a coordinate twice"),
    (lambda: lsvib.Grid(U, W, {"e": float("nan")}), "grid: e = nan is not a number"),
    (lambda: Grid.of({"u": SPAN, "w": 1.0}, ()), "of two coordinates; 1 given"),
    (lambda: Grid.of({"u": SPAN, "w": {"start": 0.0, "stop": 1.0}}, ()), "axis w has the keys start, stop; it needs"),
    (lambda: NEAR_FOLD.basin().area(lsvib.Window(0.1, -0.1, -5, 5)), "window u = 0.1 to -0.1"),
    (lambda: NEAR_FOLD.basin().fraction({"u": (0, 1)}), "is not a range of u and one of w"),
    (lambda: NEAR_FOLD.basin().line((0.1, 0.2, -5, 5)), "is not a range of u and one of w"),
    (lambda: NEAR_FOLD.resilience({"u": (1, 0), "w": (0, 1)}), "window u = 1 to 0 is outside the allowed range"),
    (lambda: NEAR_FOLD.resilience({"u": (0, 1)}), "window = {'u': (0, 1)} is not a range of u and one of w."),
    (lambda: NEAR_FOLD.resilience({"u": ("a", 1), "w": (0, 1)}), "window u = "),
    *((lambda changes=changes: DRIVE(**changes).basin(), words) for changes, words in REFUSED_BASINS),
    *((lambda of=of, asked=asked: of.threshold(*asked), words) for of, asked, words in REFUSED_THRESHOLDS),
    (lambda: branch("colour", (1, 2)), "colour"),
    (lambda: branch("axial_force", (-10, -5)), "contain the drive's own axial_force"),
    (lambda: branch("axial_force", (1,)), "span"),
    (lambda: branch("mass", (-1, 20)), "mass"),
    (lambda: branch("mass", (0.5, 2), LIGHT), "another drive"),
    (lambda: branch("contact_stiffness", (1e6, 1e8)), "is a parameter of compliant threads, which this drive"),
    (lambda: RUBS.simulate({"u": 0, "w": 0}, 0.1, physics=["axial_force", "slide_friction"]), "list rest"),
    # With so much inertia the friction of the second body has several solutions.
    (lambda: support_drive(slide_friction=1, screw_mass=11.6).automaton(), "screw_mass < 10.1"),
    (lambda: nut_drive(bearing_friction=0.01, mass=15).automaton(), "outside the Painlevé region"),
    (lambda: support_drive(slide_friction=1, **SLIDES).automaton(), "slide_friction = 1 cannot be combined with"),
    (lambda: nut_drive(bearing_friction=1, **SLIDES).automaton(), "bearing_friction = 1 cannot be combined with"),
    (lambda: nut_drive(bearing_static_friction=1, **SLIDES).automaton(), "static_friction = 1 cannot be combined with"),
    *((call, "input_speed = 0 holds the motor still") for call in (LET_GO.cycles, LET_GO.basin, LET_GO.resilience)),
]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Put files, links and a pipe into the folder in which all is run: nothing in it may change."""
    (tmp_path / "folder").mkdir()
    (tmp_path / "Snakefile").touch()
    (tmp_path / "scene.yaml").write_text("start: {u: 0.1, w: 0}\nduration: 1\n")
    (tmp_path / "text").write_text("my thesis")
    (tmp_path / "to_scene").symlink_to("scene.yaml")
    os.mkfifo(tmp_path / "pipe")
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(("line", "words"), COMMANDS)
def test_command(run, line, words):
    assert words in refused(run, *line.split())


@pytest.mark.parametrize(("text", "words"), SCENES)
def test_scene(run, text, words):
    Path("scene.in").write_text(text)
    assert words in refused(run, "simulate", "--scene", "scene.in", "--out", "x.nc")


@pytest.mark.parametrize(("place", "value", "words"), SECTIONS)
def test_settings_of_a_figure(run, place, value, words):
    """The sentence is that of the whole configuration, with which the workflow refuses it."""
    settings = copy.deepcopy(SETTINGS)
    inner = settings["fig8_08"]
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = value
    Path("settings.in").write_text(yaml.safe_dump(settings))
    assert words in refused(run, "figure", "8.8", "--config", "settings.in")


@pytest.mark.parametrize(("call", "words"), PYTHON)
def test_python(call, words):
    before = state_of_the_folder()
    assert words in complaint(call)
    assert state_of_the_folder() == before
