"""The values in a caption, and where arrows of time and words beside a line stand."""

import numpy as np
import pytest
import xarray as xr
from references.figure_checks import assert_drawn_from_file, dataset_of, draft

import lsvib
from lsvib.contact import contact_force
from lsvib.datasets import phase_plane
from lsvib.figures import drawing as drawn
from lsvib.figures import fig8_07, style
from lsvib.figures.build import caption_of
from lsvib.models.drive import Drive


def parameters() -> xr.Dataset:
    """Parameters of some drives, of each origin."""
    names = {
        "mass": ([10.0, 11.0], "m", "kg", "assumed: not stated in the text, except 10 (printed: Fig. 8.14)"),
        "axial_force": ([-50.0, -50.0], "R", "N", "printed: Fig. 8.14"),
        "contact_stiffness": ([1e8, 1e8], "k_c", "N m-1", "assumed: not stated in the text"),
        "support_damping": ([2e-4, 2e-4], "c", "N m s rad-1", "printed: Table 8.1"),
        "input_speed": ([40.0, 40.0], "\\Omega", "rad s-1", "varied: an axis of this file"),
    }
    return xr.Dataset(
        {
            name: ("case", values, {"symbol": f"${symbol}$", "units": unit, "long_name": name, "origin": origin})
            for name, (values, symbol, unit, origin) in names.items()
        }
    )


def test_a_caption_states_what_is_printed_and_what_is_assumed():
    words, values = caption_of("fig8_03", parameters()).rstrip().split("\n\n")
    assert words.startswith("Stability of the steady sliding")
    assert values.replace("\\_", "_") == (
        "Values: As printed: m = 10 kg, R = −50 N. Assumed: m = 11 kg, k_c = 10⁸ N m⁻¹. Otherwise Table 8.1."
    )
    assert "Values" not in caption_of("fig8_03", xr.Dataset())


def test_maps_and_charts_fit_the_page(tmp_path):
    drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
    starts = drive.attraction({"u": (-0.3, 0.3, 20), "w": (-150, 150, 20)})
    assert_drawn_from_file("attraction", starts, tmp_path / "map.nc")
    assert_drawn_from_file("chart", drive.chart("axial_force=-40:60:9", "mass=1:20:9"), tmp_path / "chart.nc")


SIDES = {
    "contact force along the motion": {"mass": 1.0, "translation_damping": 1000.0, "axial_force": 30.0},
    "contact force against the motion": {"mass": 1.0, "translation_damping": 1000.0, "axial_force": 15.0},
    "backwards": {"mass": 1.0, "translation_damping": 1000.0, "axial_force": -30.0, "input_speed": -40.0},
    "beyond the critical mass": {"mass": 11.0, "axial_force": 50.0},
    "beyond the critical mass, backwards": {"mass": 11.0, "axial_force": -50.0, "input_speed": -40.0},
}


@pytest.mark.parametrize("words", SIDES)
def test_the_sides_of_the_line_have_the_sign_of_the_contact_force(words):
    """Against the two forces of (8.17) themselves; where two solve, a motion takes law −."""
    drive = Drive.of(SIDES[words])
    case = phase_plane.portraits({"starts": [{"u": 0.01, "w": 0.0}], "duration": 0.01, "samples": 200}, [drive]).isel(
        case=0
    )
    axes = style.new_figure().add_subplot()
    axes.set(xlim=(-0.15, 0.15), ylim=(-120, 120))
    drawn.guide(axes, case)
    named = {text.get_text(): text.get_position() for text in axes.texts if text.get_text()}
    assert set(named) == {"$N > 0$", "$N < 0$"}
    for text, (u, w) in named.items():
        forces = contact_force.contact_forces(drive, u, w)
        direction = np.sign(drive.input_speed + w)
        solving = [force for law, force in zip((-1, 1), forces[::-1], strict=True) if np.sign(force) * direction == law]
        assert (solving[0] > 0) == (">" in text)


def test_the_sectors_of_figure_8_7_have_the_signs_of_the_contact_force():
    figure, settings = dataset_of("fig8_07"), draft("fig8_07")
    drive = Drive.of(settings["drive"])
    axes = fig8_07.draw(figure).axes[0]
    sectors = [text for text in axes.texts if text.get_text().startswith(r"$\dot\theta")]
    assert len(sectors) == 4
    for text in sectors:
        u, w = axes.transLimits.inverted().transform(np.round(text.get_position()))
        forces = contact_force.contact_forces(drive, u, w)
        direction = np.sign(drive.input_speed + w)
        relation = {True: ">", False: "<"}
        expected = rf"$\dot\theta {relation[direction > 0]} 0$: "
        if np.sign(forces[0]) * direction == 1:
            first, second = (relation[bool(force > 0)] for force in forces[::-1])
            expected += f"$N {first} 0$ by law −\n($N {second} 0$ by law +)"
        else:
            expected += "no $N$"
        assert text.get_text() == expected
