"""Inputs that users get wrong, each with words of the sentence that refuses it: commands, files, Python."""

import numpy as np

import lsvib
from lsvib.basins.grid import Grid
from lsvib.datasets.io import read_dataset
from lsvib.figures.configuration import DEFAULT, check
from lsvib.models.scene import read_yaml
from references.drives import NEAR_FOLD, threads_drive

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
    ("thresholds --set masss=1", "masss is not a known key; the known keys are pitch_radius, "),
    ("thresholds --set mass=1 --set mass=2", "mass is given twice"),
    ("config --set mass=1,5", "mass = '1,5' is not a number; the allowed range is 1e-18 <= mass <= 1e+09"),
    ("config --set mass=5kg", "mass = '5kg' is not a number"),
    ("config --set mass=nan", "mass = 'nan' is not a number"),
    ("config --set mass=-1", f"mass = -1.0 {RANGE} 1e-18 <= mass <= 1e+09"),
    ("config --set lead_angle_deg=95", f"{RANGE} 5.72958e-05 <= "),
    ("config --set lead_angle=0.1 --set lead_angle_deg=5", "both given"),
    ("config --set input_speed=0", "1e-12 <= |input_speed| <= 1e+09"),
    ("stability --set friction_coefficient=10.3", f"friction_coefficient = 10.3 {RANGE}"),
    ("stability --set axial_force=0", "axial_force"),
    (
        "stability --set contact_damping=1",
        "contact_damping is a parameter of compliant threads, which need contact_stiff",
    ),
    (
        "stability --set screw_mass=1",
        "screw_mass is a parameter of a compliant axial support, which needs support_stiff",
    ),
    # Thresholds.
    ("thresholds --solve stuck", "threshold = 'stuck' is not one of those of this drive: even_speed, on"),
    ("thresholds --solve stick --for weight", "unknown = 'weight' is not a parameter of this drive"),
    ("thresholds --for weight", "unknown = 'weight' is not a parameter of this drive"),
    # Motions.
    ("simulate --start u=0.1 --duration 1 --out x.nc", "it needs u and w"),
    ("simulate --start u=0 w=0 --out x.nc", "duration is missing"),
    ("simulate --start u=x w=0 --duration 1 --out x.nc", "u=x has a part that is not a number"),
    ("simulate --start u=0 w=0 --duration -1 --out x.nc", "duration = -1"),
    (f"{MOTION} --samples 1", "samples = 1"),
    (f"{MOTION} --samples 10.5", "Invalid value for --samples: '10.5' is not a whole number."),
    (f"{MOTION} --samples many", "Invalid value for --samples: 'many' is not a number."),
    ("simulate --scene none.yaml --out x.nc", "none.yaml"),
    ("simulate --scene /dev/zero --out x.nc", "Cannot read /dev/zero: it is not a regular file"),
    ("figure 8.8 --config pipe", "Cannot read pipe: it is not a regular file"),
    ("config --scene folder", "Cannot read folder: it is not a regular file"),
    # Maps, charts, sweeps and what else has axes.
    ("attraction --grid u=-0.1:0.1:4 --out x.nc", "grid spans 1 coordinates"),
    ("attraction --grid u=1:0:4 w=0:1:4 --out x.nc", "start < stop"),
    ("attraction --grid u=0:1:0 w=0:1:4 --out x.nc", "count = 0"),
    ("attraction --grid u=0:1 w=0:1:4 --out x.nc", "KEY=START:STOP:COUNT"),
    ("attraction --grid u=0:1:4 q=0:1:4 --out x.nc", "'q'"),
    (f"{MAP} --quantities colour", 'Invalid value "colour" for --quantities'),
    (f"{MAP} --workers 0", "workers = 0"),
    (f"{MAP} --figure map.pdf", ".png"),
    ("sweep --over axial_force=1:60 --out x.nc", "KEY=START:STOP:COUNT"),
    ("sweep --over mass=-1:1:3 --out x.nc", "mass = -1"),
    ("sweep --over mass=1:2:3 --set mass=4 --out x.nc", "mass is varied and given by --set"),
    ("sweep --over lead_angle=0.1:0.2:3 --set lead_angle_deg=4", "lead_angle is varied and given by --set"),
    ("chart --x mass=1:20:2 --y axial_force=1:2:2 --set mass=4", "mass is varied and given by --set"),
    ("resilience --over mass=1:2:3 --set mass=4 --out x.nc", "mass is varied and given by --set"),
    ("attraction --grid u=0:1:20 w=0:1:1000000000 --out x.nc", "1 <= count <= 10000000"),
    ("attraction --grid u=0:1:10000 w=0:1:10001 --out x.nc", "grid has 100010000 cells; the allowed range is up to"),
    ("sweep --over mass=1:2:10000000 --over axial_force=1:2:10000000", "over has 100000000000000 points"),
    ("chart --x mass=1:20:2 --y mass=1:20:2 --out x.nc", "both mass"),
    ("follow --set mass=11 --over axial_force=-18 --out x.nc", "KEY=LOW:HIGH"),
    ("resilience --window u=-0.3", "Invalid value for --window: 'u=-0.3' is not of the form KEY=LOW:HIGH"),
    ("resilience --over mass=1:2:3", "over and out belong together"),
    # Figures.
    ("figure 8.99", "figure 8.99 is not one of 8.1, 8.2, "),
    ("figure 8.8 --config none.yaml", "none.yaml"),
    ("figure 8.8 --set mass=9", "does not depend on mass"),
    ("figure 8.6 --set mass=2", "mass = 2, none of mass_readings: 1 and 8"),
    ("figure 8.8 --out text", "is not a folder"),
    # Files.
    (MOTION.replace("x.nc", "none/x.nc"), "none does not exist"),
    (MOTION.replace("x.nc", "folder"), "it is a folder"),
    (MOTION.replace("x.nc", "text"), "is no netCDF file"),
    (MOTION.replace("x.nc", "pipe"), "pipe"),
    ("simulate --scene scene.yaml --out to_scene", "reads"),
]
# Files of scenes.
SCENES = [
    ("drive: {mass: [1\n", "not valid YAML"),
    ("- 1\n", "names and values"),
    ("drive: {mass: 1, mass: 2}\n", "mass is given twice"),
    ("drive: {mass: 11, weight: 2}\nstart: {u: 0.1, w: 0}\nduration: 1\n", f"weight {UNKNOWN}"),
    ("drive: {mass: '11 kg'}\nstart: {u: 0.1, w: 0}\nduration: 1\n", "mass = '11 kg' is not a number"),
    ("start: {u: left, w: 0}\nduration: 1\n", "start.u = 'left'"),
    ("start: {u: 0.1, w: 0}\nduration: 1\nphysics: [gravity]\n", "gravity"),
    ("start: {u: 0.1, w: 0}\nduration: 1\noutputs: [temperature]\n", "temperature"),
]
REPEATED = "".join(f"{b}: &{b} [{', '.join([f'*{a}'] * 9)}]\n" for a, b in zip("abcdefg", "bcdefgh", strict=True))
SCENES += [
    (f"a: &a [1]\n{REPEATED}start: *h\nduration: 1\n", "more than 1000000 values, with aliases written out"),
    ("start: &a [*a]\nduration: 1\n", "an alias stands inside of what it names"),
    ("#" * 10_000_001, "it has more than 10 MB"),
    ("drive: {mass: " + "9" * 5000 + "}\n", "mass = inf is outside the allowed range"),
    ("duration: " + "9" * 5000 + "\n", "duration = inf is outside the allowed range"),
]
# Changes of the settings of a figure: place, value, words.
SECTIONS = [
    (("mass", "count"), 1, f"fig8_08.mass.count = 1 {RANGE} 2 <= count"),
    (("mass", "start"), "1e-3", "write it with a point"),
    (("mass", "cuont"), 5, f"fig8_08.mass.cuont {UNKNOWN}"),
    (("dampings",), [], "at least 1"),
    (("drive",), {"mass": -1}, RANGE),
]
GRID = {"u": (0, 1, 4), "w": (0, 1, 4)}
U, W = lsvib.Axis("u", -0.1, 0.1, 4), lsvib.Axis("w", -5, 5, 4)
MASKED = np.ma.masked_array([1.0, 2.0], [False, True])
SPAN = {"start": -1.0, "stop": 1.0, "count": 3}
PYTHON = [
    (lambda: lsvib.simulate("none.yaml"), "none.yaml"),
    (lambda: lsvib.simulate({"start": {"u": 0}, "duration": 1}), "start"),
    (lambda: lsvib.Drive(mass=None), "is not a number"),
    (lambda: lsvib.Drive(mas=1), UNKNOWN),
    (lambda: threads_drive(screw_mass=1), "needs support_stiffness as well"),
    (lambda: lsvib.Drive().simulate({"u": 0, "w": 0}, 1, outputs=["nut_speed"]), "outputs"),
    (lambda: threads_drive().basin(), "rigid drives only"),
    (lambda: lsvib.Drive().attraction({"u": (0, 1), "w": (0, 1, 4)}), "axis u has 2 numbers"),
    (lambda: lsvib.Drive().attraction(GRID, workers="many"), "workers = 'many'"),
    (lambda: lsvib.Drive().sweep(mass=3), "is not a list"),
    (lambda: lsvib.Drive().chart("mass=1:20", "axial_force=0:1:2"), "KEY=START:STOP:COUNT"),
    (lambda: lsvib.Drive().chart(("mass", 1, 2, 3), ("mass", 1, 2, 3)), "both mass"),
    (lambda: lsvib.Drive().chart(("mass", 0, 2, 3), ("axial_force", 1, 2, 3)), "mass = 0"),
    (lambda: lsvib.Drive().chart(("mass", 2, 1, 3), ("axial_force", 1, 2, 3)), "start < stop"),
    (lambda: lsvib.Drive().chart(("mass", 1, 2, 20_000), ("axial_force", 1, 2, 20_000)), "more than"),
    (lambda: read_dataset("text"), "not a readable netCDF file"),
    (lambda: check({**SETTINGS, "colour": 1}), UNKNOWN),
    (lambda: NEAR_FOLD.follow(NEAR_FOLD.cycles(), "axial_force", (-18.5, -18.35)), "what is followed is one cycle"),
    (lambda: NEAR_FOLD.follow(None, "axial_force", (-18.5, -18.35)), "what is followed is one cycle"),
    (lambda: NEAR_FOLD.sweep(mass=np.array(1.0)), "mass = array(1.) is not a list of numbers"),
    (lambda: NEAR_FOLD.sweep(mass=np.ones((2, 2))), "is not a list of numbers"),
    (lambda: NEAR_FOLD.sweep(mass=MASKED), "mass holds a value that is not a number"),
    (lambda: lsvib.Drive(mass=np.ma.masked), "mass = masked is not a number"),
    (lambda: NEAR_FOLD.simulate({"u": MASKED[1], "w": 0}, 0.1), "start.u = masked is not a number"),
    (lambda: setattr(NEAR_FOLD, "mass", 5), "drive.replace(mass=...) makes another one"),
    (lambda: delattr(NEAR_FOLD, "mass"), "a drive does not change"),
    (lambda: lsvib.Drive().replace(contact_damping=1.0), "of compliant threads, which need contact_stiffness"),
    (lambda: lsvib.Drive().replace(screw_mass=1.0), "of a compliant axial support, which needs support_stiffness"),
    (lambda: lsvib.Drive(nut_stiffness=1.0), "is a parameter of a nut that may turn, which needs nut_inertia"),
    (lambda: lsvib.Drive().replace(nut_stiffness=1.0), "of a nut that may turn, which needs nut_inertia"),
    (lambda: lsvib.Axis("u", 0, float("nan"), 3), "stop = nan is not a number"),
    (lambda: lsvib.Axis("u", 0, float("inf"), 3), "stop = inf is outside"),
    (lambda: lsvib.Axis("u", 1, 0, 3), "it needs start < stop"),
    *((lambda count=count: lsvib.Axis("u", 0, 1, count), "range is 1 <= count") for count in (0, -3, True, "x", 2.5)),
    (lambda: lsvib.Grid(U, 3), "a grid needs two axes"),
    (lambda: lsvib.Grid(U, U), "a coordinate twice"),
    (lambda: lsvib.Grid(U, lsvib.Axis("mass", 0, 1, 3)), "coordinate 'mass'"),
    (lambda: lsvib.Grid(U, W, {"e": float("nan")}), "grid: e = nan is not a number"),
    (lambda: Grid.of({"u": SPAN, "x": SPAN}), "coordinate 'x', which is not one of u, w"),
    (lambda: Grid.of({"u": SPAN, "w": 1.0}), "spans 1 coordinates"),
    (lambda: Grid.of({"u": SPAN, "w": {"start": 0.0, "stop": 1.0}}), "axis w has the keys start, stop; it needs"),
    (lambda: Grid.of({"u": SPAN, "w": {**SPAN, "stop": -2.0}}), "it needs start < stop"),
    (lambda: NEAR_FOLD.basin().area(lsvib.Window(0.1, -0.1, -5, 5)), "window u = 0.1 to -0.1"),
    (lambda: NEAR_FOLD.basin().fraction({"u": (0, 1)}), "does not give the ends of u and of w"),
    (lambda: NEAR_FOLD.basin().line((0.1, 0.2, -5, 5)), "does not give the ends of u and of w"),
    (lambda: NEAR_FOLD.resilience({"u": (1, 0), "w": (0, 1)}), "window u = 1 to 0 is outside the allowed range"),
    (lambda: NEAR_FOLD.resilience({"u": (0, 1)}), "window = {'u': (0, 1)} does not give the ends of u and of w."),
    (lambda: NEAR_FOLD.resilience({"u": ("a", 1), "w": (0, 1)}), "window u = "),
]
