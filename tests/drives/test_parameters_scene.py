"""Parameters and scenes: every unacceptable value gets one sentence with key, value and range; nothing else gets in."""

import math

import pytest
from pydantic import ValidationError
from references.command_line import complaint

from lsvib import Drive
from lsvib.drives import chapter, friction
from lsvib.drives.complaints import allowed_range
from lsvib.drives.drive import DRY, PART_OF, may_vanish, zero_if_close
from lsvib.drives.scene import Scene, read_yaml
from lsvib.systems.exact.arithmetic import many_digits

RANGES = {  # of the drive of the chapter
    "pitch_radius": "1e-06 <= pitch_radius <= 1", "lead_angle": "1e-06 <= lead_angle < 1.5708",
    "screw_inertia": "1e-30 <= screw_inertia <= 1e+06", "coupling_stiffness": "1e-21 <= coupling_stiffness <= 1e+15",
    "support_damping": "0 or 1e-30 <= support_damping <= 1e+15",
    "friction_coefficient": "0 or 1e-18 <= friction_coefficient < cot(lead_angle)",
    "input_speed": "1e-12 <= |input_speed| <= 1e+09", "mass": "1e-18 <= mass <= 1e+09",
    "translation_damping": "0 or 1e-18 <= translation_damping <= 1e+15",
    "axial_force": "0 or 1e-18 <= |axial_force| <= 1e+12",
}  # fmt: skip
SCENE = {"drive": {"mass": 11.0}, "start": {"u": 0.1, "w": 0.0}, "duration": 0.5}


def test_defaults_are_table_8_1():
    assert dict(Drive()) == {
        "pitch_radius": 5.18e-3,
        "lead_angle": math.radians(5.57),
        "screw_inertia": 3.12e-6,
        "coupling_stiffness": 1.0,
        "support_damping": 2e-4,
        "friction_coefficient": 0.218,
        "input_speed": 40.0,
        "mass": 1.0,
        "translation_damping": 0.0,
        "axial_force": 50.0,
    }
    assert set(RANGES) == set(Drive.model_fields) - {
        *friction.NAMES,
        *DRY,
        "collar_radius",
        "coupling_damping",
        *PART_OF,
    }
    assert all(getattr(Drive(), name) is None for name in PART_OF)
    law = {"static_friction_coefficient": 0, "stribeck_rise": 0, "stribeck_speed": 0, "friction_slope": 0}
    assert {name: getattr(Drive(), name) for name in friction.NAMES} == law | {"stribeck_exponent": 1}


@pytest.mark.parametrize("key", RANGES)
def test_value_out_of_range(key):
    most = RANGES[key].rsplit("< ")[-1].rsplit("<= ")[-1]
    beyond = 10.3 if most.startswith("cot") else 1.1 * float(most)
    for value in (beyond, -beyond):
        sentence = complaint(Drive.of, {key: value})
        assert sentence.startswith((f"{key} = {value!r} is outside", f"{key} = {value:g} is outside"))
        assert RANGES[key] in sentence
        complaint(Drive().replace, **{key: value})


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, "5mm", "", None, [1.0], {"a": 1}, True, "nan", 1j])
@pytest.mark.parametrize("key", RANGES)
def test_value_that_is_no_number(key, value):
    sentence = complaint(Drive.of, {key: value})
    assert sentence.startswith(f"{key} = {value!r} ")
    assert RANGES[key] in sentence


def test_nothing_is_next_to_zero():
    """The least value of a parameter is accepted, a smaller one is not; what is computed there becomes zero."""
    parts = Drive(**{name: value for part in chapter.PARTS.values() for name, value in part.items()})
    collar = Drive(collar_friction=0.1, collar_radius=0.01)
    for key in Drive.model_fields.keys() - friction.NAMES:  # those bound each other: test_friction
        whole = collar if "collar" in key else parts
        text = allowed_range(Drive, key)
        least = float(text.removeprefix("0 or ").split(" <= ")[0])
        for sign in (-1, 1) if "|" in text else (1,):
            assert getattr(whole.replace(**{key: sign * least}), key) == sign * least
            assert text in complaint(whole.replace, **{key: sign * math.nextafter(least, 0)})
            assert text in complaint(whole.replace, **{key: sign * 5e-324})
        assert may_vanish(key) == (text.startswith("0 or ") and key != "input_speed")
        if text.startswith("0 or "):
            assert key == "collar_radius" or getattr(whole.replace(**{key: 0}), key) == 0
            assert zero_if_close(key, math.nextafter(least, 0)) == 0
            assert zero_if_close(key, least) == least
        else:
            assert text in complaint(whole.replace, **{key: 0})
            assert zero_if_close(key, 5e-324) == 5e-324


def test_text_that_is_a_number_is_read():
    assert Drive.of(mass="11", axial_force="-1e1") == Drive.of(mass=11.0, axial_force=-10.0)


def test_friction_is_limited_by_the_lead_angle():
    assert "cot(lead_angle) = 10.2541" in complaint(Drive.of, friction_coefficient=10.26)
    assert Drive.of(friction_coefficient=10.25).friction_coefficient == 10.25
    assert "friction_coefficient = 2" in complaint(Drive.of, friction_coefficient=2.0, lead_angle=0.5)


def test_lead_angle_in_degrees():
    assert Drive.of(lead_angle_deg=5.57) == Drive()
    assert Drive.of(lead_angle_deg="4").lead_angle == math.radians(4)
    assert Drive().replace(lead_angle_deg=4).lead_angle == math.radians(4)
    assert "both given" in complaint(Drive.of, lead_angle=0.1, lead_angle_deg=5.0)
    for value in ("steep", None, True, "nan"):
        said = complaint(Drive.of, lead_angle_deg=value)
        assert f"lead_angle_deg = {value!r} is not a number; the allowed range is 5.72958e-05 <= " in said
    for value in (0, 90, 90.0):
        said = complaint(Drive.of, lead_angle_deg=value)
        assert f"lead_angle_deg = {value} is outside the allowed range 5.72958e-05 <= " in said


def test_drives_and_scenes_are_immutable():
    drive, scene = Drive(), Scene.of(SCENE)
    assert "a drive cannot be changed" in complaint(setattr, drive, "mass", 2.0)
    with pytest.raises(ValidationError):
        scene.duration = 2.0
    assert drive.replace(mass=2.0).mass == 2.0
    assert drive.mass == 1.0
    assert hash(drive) == hash(Drive())


def test_exact_values_are_the_doubles():
    exact = Drive().exact()
    assert float(exact.tan_lead) == math.tan(Drive().lead_angle)
    with many_digits():
        rest = exact.sin_lead**2 + exact.cos_lead**2 - 1
        assert rest.contains(0)
        assert abs(rest) < 1e-140
        assert (exact.translation_damping * exact.tan_lead).is_zero()  # a term that is not there leaves no rounding


def test_physics_of_a_scene():
    """A scene carries only the terms that it lists; by default those that are not zero, and rest."""
    scene = Scene.of({**SCENE, "drive": {"support_damping": 0.0, "axial_force": 10.0}})
    assert scene.terms == ("axial_force", "rest")
    assert "support_damping" not in scene.parameters()
    assert "translation_damping" not in scene.parameters()
    assert scene.parameters()["axial_force"] == 10.0
    listed = Scene.of({**SCENE, "physics": ["support_damping", "axial_force"]})
    assert "rest" not in listed.terms


def test_scene_from_yaml(tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(
        "drive:\n  mass: 11\n  lead_angle_deg: 5.57\n  support_damping: 1.0e-3\n"
        "start: {u: 0.1, w: 0}\nduration: 0.5\nsamples: 11\n",
        encoding="utf-8",
    )
    scene = Scene.of(read_yaml(path))
    assert scene.drive == Drive.of(mass=11.0, support_damping=1e-3)
    assert (scene.duration, scene.samples, scene.resume) == (0.5, 11, "contact_sign")
    path.write_text("drive: {mass: 1e-3}\nstart: {u: 0.1, w: 0}\nduration: 1\n")  # YAML 1.1 reads 1e-3 as text
    assert Scene.of(read_yaml(path)).drive.mass == 1e-3


def test_a_collar_needs_its_radius_and_rigid_parts():
    assert complaint(Drive, collar_friction=0.1) == "collar_friction = 0.1 needs collar_radius > 0."
    said = complaint(Drive, collar_friction=0.1, collar_radius=0.01, contact_stiffness=1e8)
    assert said.startswith("collar_friction = 0.1 cannot be combined with compliant threads: the")
