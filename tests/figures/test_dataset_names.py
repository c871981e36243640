"""The datasets of all figures, read by a stranger: one name has one meaning, and every drive is stated."""

import json
from collections import defaultdict
from importlib import import_module

import numpy as np
import pytest
import xarray as xr
from references.figure_checks import dataset_of, draft
from scipy.integrate import solve_ivp

from lsvib.data.parameter_origins import (
    ASSUMED,
    FIELDS,
    NO_EFFECT,
    QUALIFIERS,
    VARIED,
    drive_parameters,
    origin_of,
)
from lsvib.data.writer import write_dataset
from lsvib.drives import chapter
from lsvib.drives.parameters import RigidParameters
from lsvib.figures.configuration import settings_of
from lsvib.figures.folders import dataset_module, default_figures

FIGURES = default_figures()
ORIGINS = ("printed: ", ASSUMED, VARIED, NO_EFFECT)
# Beside the qualifiers of parameters: of the rigid drive beside a compliant one, of a close-up, of a curve.
_ALSO = ("rigid", "close_up", "node_focus")
# Families of variables, one for each parameter that is swept.
_SWEPT = ("fraction", "boundary_kind")


def base(name: str) -> str:
    """The name without its qualifier, and without the parameter along which it lies."""
    for start in _SWEPT:
        if name.startswith(f"{start}_") and name.removeprefix(f"{start}_") in FIELDS:
            return start
    if name in FIELDS:
        return name
    return next((name.removeprefix(f"{word}_") for word in (*QUALIFIERS, *_ALSO) if name.startswith(f"{word}_")), name)


def meaning(variable: xr.Variable) -> tuple[str, str]:
    return variable.attrs["units"], variable.attrs["long_name"]


def test_a_name_has_one_meaning_in_all_files():
    found = defaultdict(set)
    for figure in FIGURES:
        for name, variable in dataset_of(figure).variables.items():
            found[name].add(meaning(variable))
    assert {name: meanings for name, meanings in found.items() if len(meanings) > 1} == {}


def test_a_meaning_has_one_name_but_for_its_qualifier():
    found = defaultdict(set)
    for figure in FIGURES:
        for name, variable in dataset_of(figure).variables.items():
            found[meaning(variable)].add(base(name))
    assert {words: names for words, names in found.items() if len(names) > 1} == {}


def test_a_qualified_parameter_has_its_units_and_a_symbol_has_one_parameter():
    symbols = defaultdict(set)
    for figure in FIGURES:
        for name, variable in dataset_of(figure).variables.items():
            if base(name) in FIELDS:
                assert variable.attrs["units"] == FIELDS[base(name)]["unit"], (figure, name)
                symbols[variable.attrs["symbol"]].add(base(name))
    assert {symbol: names for symbol, names in symbols.items() if len(names) > 1} == {}


@pytest.mark.parametrize("figure", FIGURES)
def test_every_parameter_is_stated_with_its_origin(figure):
    dataset = dataset_of(figure)
    missing = [name for name in RigidParameters.model_fields if name not in dataset.variables]
    assert missing == []
    for name in set(FIELDS) & set(dataset.variables):
        attributes = dataset[name].attrs
        assert attributes["origin"].startswith(ORIGINS), (name, attributes)
        assert attributes["symbol"], name
        if attributes["origin"] == VARIED:  # an axis, or along one
            assert dataset[name].ndim >= 1, name


@pytest.mark.parametrize("figure", [figure for figure in FIGURES if settings_of(figure).unused])
def test_what_a_figure_does_not_depend_on_is_not_called_assumed(figure):
    """A parameter that settings may not change has no effect, is an axis, lies along the cases, or is printed."""
    dataset = dataset_of(figure)
    for name in settings_of(figure).unused:
        origin = dataset[name].attrs["origin"]
        assert origin in (VARIED, NO_EFFECT) or dataset[name].ndim or origin.startswith("printed"), (name, origin)


@pytest.mark.parametrize("figure", FIGURES)
def test_what_is_of_no_effect_has_none(figure):
    """Rebuilt with other values of the same sign, every other variable of the file is the same to the last bit."""
    dataset = dataset_of(figure)
    idle = [name for name in FIELDS if name in dataset and dataset[name].attrs["origin"] == NO_EFFECT]
    if not idle:
        return
    settings = draft(figure)
    changed = {name: 1.7 * float(dataset[name]) + (not dataset[name].item()) for name in idle}
    other = import_module(dataset_module(figure)).build(settings | {"drive": settings["drive"] | changed})
    for name in idle:
        assert float(other[name]) == changed[name]
    xr.testing.assert_identical(other.drop_vars(idle), dataset.drop_vars(idle))


# Dimensions whose entries need no label: they count points, or the long name of what lies along them tells the order.
_COUNTED = ("start", "event", "seizure", "end", "edge", "bracket")


@pytest.mark.parametrize("figure", FIGURES)
def test_every_dimension_is_labelled_or_counts_points(figure):
    dataset = dataset_of(figure)
    counted = {name for name in dataset.sizes if name in _COUNTED or name.split("_")[-1] in ("sample", "point")}
    assert set(dataset.sizes) - counted <= set(dataset.coords)
    for name in set(dataset.sizes) - counted:
        assert "flag_meanings" in dataset[name].attrs or dataset[name].attrs["units"], name


def test_origin_says_which_values_are_printed():
    assert origin_of("support_damping", 2e-4) == "printed: Table 8.1"
    assert origin_of("support_damping", 1e-3) == ASSUMED
    assert origin_of("support_damping", 1e-3, ["Fig. 8.14"]) == "printed: Fig. 8.14"
    assert origin_of("mass", [10.0, 11.0], ["Fig. 8.14"]) == f"{ASSUMED}, except 10 (printed: Fig. 8.14)"
    assert origin_of("mass", [10.0, 11.0], ["Sect. 8.6.1"]) == "printed: Sect. 8.6.1"
    assert origin_of("mass", 1.0) == ASSUMED


def test_a_changed_drive_is_not_called_printed():
    changed = RigidParameters(friction_coefficient=0.3, mass=10.0)
    table = drive_parameters(changed, printed=["Sect. 8.6.1"])
    assert table["friction_coefficient"][2]["origin"] == ASSUMED
    assert table["mass"][2]["origin"] == "printed: Sect. 8.6.1"
    assert table["lead_angle"][2]["origin"] == "printed: Table 8.1"


def test_stated_values_belong_to_known_parameters():
    assert {name for place in chapter.STATED.values() for name in place} <= set(FIELDS)


def test_cases_are_labelled_by_what_they_differ_in():
    assert dataset_of("fig8_14").case.attrs["flag_meanings"].split() == [
        "mass_10.0_axial_force_-50.0",
        "mass_10.0_axial_force_-10.0",
        "mass_11.0_axial_force_-50.0",
        "mass_11.0_axial_force_-10.0",
    ]


def acceleration_and_force(p: dict[str, float], deflection: float, speed: float) -> tuple[float, float]:
    """Angular acceleration and normal force of the two equations of motion of Sect. 5.3, of the law that holds."""
    sine, cosine, lead = np.sin(p["lead_angle"]), np.cos(p["lead_angle"]), p["pitch_radius"] * np.tan(p["lead_angle"])
    torque = -p["coupling_stiffness"] * deflection - p["support_damping"] * speed
    push = p["axial_force"] - p["translation_damping"] * lead * speed
    for side in (1, -1):
        friction = p["friction_coefficient"] * np.sign(speed) * side
        matrix = [
            [p["screw_inertia"], p["pitch_radius"] * (friction * cosine - sine)],
            [p["mass"] * lead, cosine + friction * sine],
        ]
        turning, force = np.linalg.solve(matrix, [torque, push])
        if force * side >= 0:
            break
    return turning, force


@pytest.mark.parametrize(("figure", "case"), [("fig8_04", 0), ("fig8_05", 0), ("fig8_06", 1)])
def test_a_motion_is_repeated_from_its_file_alone(figure, case, tmp_path):
    """The stated drive, integrated from the stated start by somebody else's solver, gives the motions of the file."""
    write_dataset(dataset_of(figure), tmp_path / "figure.nc")
    file = xr.open_dataset(tmp_path / "figure.nc").isel(case=case)
    drive = {name: float(file[name]) for name in RigidParameters.model_fields}
    for start in range(file.sizes["start"]):
        motion = file.isel(start=start)
        time, deflection = motion.time.values, motion.coupling_deflection.values
        speed = motion.velocity_deviation.values + drive["input_speed"]

        def rate(_, state):
            return [state[1] - drive["input_speed"], acceleration_and_force(drive, *state)[0]]

        times, which = np.unique(time, return_inverse=True)
        first = [deflection[0], speed[0]]
        found = solve_ivp(rate, times[[0, -1]], first, "DOP853", times, rtol=1e-9, atol=1e-12).y[:, which]
        assert np.abs(found[0] - deflection).max() < 1e-6 * np.ptp(deflection)
        assert np.abs(found[1] - speed).max() < 1e-5 * np.ptp(speed)
        force = [acceleration_and_force(drive, *state)[1] for state in zip(deflection, speed, strict=True)]
        assert np.abs(force - motion.normal_force).max() < 1e-9 * np.abs(force).max()


def test_history_names_the_function_and_the_version(tmp_path):
    write_dataset(dataset_of("fig8_03"), tmp_path / "figure.nc", "lsvib.figures.fig8_03.dataset.build")
    attributes = xr.open_dataset(tmp_path / "figure.nc").attrs
    assert attributes["history"] == f"made by lsvib.figures.fig8_03.dataset.build, lsvib {attributes['lsvib_version']}"
    assert json.loads(attributes["package_versions"])
