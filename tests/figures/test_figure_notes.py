"""The line of values under a picture, and where arrows of time and words beside a line stand."""

import matplotlib
import numpy as np
import pytest
import xarray as xr
from references.figure_checks import assert_states_what_is_assumed, dataset_of, draft, number_in

from lsvib.contact import existence
from lsvib.data import phase_plane
from lsvib.drives.parameters import RigidParameters
from lsvib.figures.draw import caption_of
from lsvib.figures.drawing import arrows, style
from lsvib.figures.drawing import phase_planes as drawn
from lsvib.figures.fig8_07 import picture as fig8_07


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


def test_the_line_states_what_is_printed_and_what_is_assumed():
    figure = style.new_figure(style.DOUBLE)
    style.state_values(figure, parameters())
    assert figure.get_supxlabel() == (
        "As printed: $m$ = 10 kg, $R$ = −50 N. Assumed: $m$ = 11 kg, $k_c$ = $10^{8}$ N m⁻¹. Otherwise Table 8.1."
    )


def test_a_caption_says_the_same_values_in_plain_words():
    figure = style.new_figure()
    style.state_values(figure, parameters(), rest="Varied: $\\Omega$ from $2 \\times 10^{-4}$.")
    words, values = caption_of("fig8_03", figure).rstrip().split("\n\n")
    assert words.startswith("Stability of the steady sliding")
    assert values.replace("\\_", "_") == (
        "Values: As printed: m = 10 kg, R = −50 N. Assumed: m = 11 kg, k_c = 10⁸ N m⁻¹. Varied: Ω from 2 × 10⁻⁴."
    )
    assert "Values" not in caption_of("fig8_03", style.new_figure())


@pytest.mark.parametrize("width", [1.6, 2.5, style.SINGLE])
def test_the_line_is_broken_where_it_would_leave_the_figure(width):
    figure = style.new_figure(width)
    style.state_values(figure, parameters())
    text = figure.get_supxlabel()
    assert "\n" in text
    assert figure._supxlabel.get_window_extent().width <= 0.98 * figure.bbox.width


def test_many_values_of_a_parameter_become_their_range():
    variable = xr.DataArray(np.linspace(1, 7, 7), attrs={"symbol": "$k$", "units": "N m-1", "long_name": "stiffness"})
    assert style.amount(variable) == "$k$ = 1 to 7 N m⁻¹"
    assert style.amount(variable[:5]) == "$k$ = 1, 2, 3, 4, 5 N m⁻¹"


def panel():
    axes = style.new_figure().add_subplot()
    axes.set(xlim=(0, 10), ylim=(0, 1))
    return axes


def test_an_arrow_points_along_its_line_where_no_other_line_is_near():
    axes = panel()
    x = np.linspace(1, 9, 400)
    crossing = np.where(x < 6, 0.5, 0.9)  # lies on the first line but for the last third
    arrows.draw_arrows(axes, [(x[::-1], np.full(x.size, 0.5), "red"), (x, crossing, None)])
    (arrow,) = axes.texts
    (head, tail) = arrow.xy, arrow.xyann
    assert head[0] < tail[0]
    assert head[0] > 6
    assert matplotlib.colors.same_color(arrow.arrow_patch.get_facecolor(), "red")


def test_a_line_out_of_view_and_one_without_length_get_no_arrow():
    axes = panel()
    away = np.linspace(20, 30, 50)
    arrows.draw_arrows(axes, [(away, away, "red"), (np.full(5, 3.0), np.full(5, 0.5), "red")])
    assert not axes.texts


def test_no_arrow_stands_on_a_jump():
    axes = panel()
    x = np.array([1.0, 1.6, np.nan, 1.6, 2.2])
    y = np.array([0.1, 0.1, np.nan, 0.9, 0.9])
    arrows.draw_arrows(axes, [(x, y, "red")])
    (arrow,) = axes.texts
    assert arrow.xy[1] == arrow.xyann[1]
    assert arrow.xy[0] > arrow.xyann[0]


def test_words_stand_on_their_sides_of_a_line_and_clear_of_others():
    axes = panel()
    x = np.linspace(0, 5, 300)
    other = (x, x / 10 + 0.5 * np.sin(40 * x), None)  # covers the panel around the first half of the line
    arrows.name_sides(axes, np.array([[0.0, 0.0], [10.0, 1.0]]), ("below", "above"), [other])
    places = {text.get_text(): text.get_position() for text in axes.texts}
    assert places["below"][1] < places["below"][0] / 10
    assert places["above"][1] > places["above"][0] / 10
    assert min(place[0] for place in places.values()) > 5


@pytest.mark.parametrize("spoiled", ["value", "symbol", "all"])
def test_the_rule_that_figures_state_what_is_assumed_can_fail(spoiled):
    figure, dataset = style.new_figure(style.DOUBLE), parameters()
    style.state_values(figure, dataset)
    assert_states_what_is_assumed(figure, dataset)
    text = figure.get_supxlabel()
    replaced = {"value": ("11 kg", "12 kg"), "symbol": ("$k_c$", "$k$"), "all": (text, "")}
    figure.supxlabel(text.replace(*replaced[spoiled]))
    with pytest.raises(AssertionError):
        assert_states_what_is_assumed(figure, dataset)


@pytest.mark.parametrize(("word", "value"), [("$2*10^{-4}$", 2e-4), ("$10^{8}$", 1e8), ("−50", -50.0), ("0.5.", 0.5)])
def test_numbers_of_a_text_are_read(word, value):
    assert number_in(word) == pytest.approx(value)
    assert np.isnan(number_in("kg"))


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
    drive = RigidParameters.of(SIDES[words])
    case = xr.Dataset(phase_plane.portraits([drive], [{"u": 0.01, "w": 0.0}], 0.01, 200)).isel(case=0)
    axes = style.new_figure().add_subplot()
    axes.set(xlim=(-0.15, 0.15), ylim=(-120, 120))
    drawn.guide(axes, case)
    named = {text.get_text(): text.get_position() for text in axes.texts if text.get_text()}
    assert set(named) == {"$N > 0$", "$N < 0$"}
    for text, (u, w) in named.items():
        forces = existence.contact_forces(drive, u, w)
        direction = np.sign(drive.input_speed + w)
        solving = [force for law, force in zip((-1, 1), forces[::-1], strict=True) if np.sign(force) * direction == law]
        assert (solving[0] > 0) == (">" in text)


def test_the_sectors_of_figure_8_7_have_the_signs_of_the_contact_force():
    figure, settings = dataset_of("fig8_07"), draft("fig8_07")
    drive = RigidParameters.of(settings["drive"])
    axes = fig8_07.draw(figure).axes[0]
    sectors = [text for text in axes.texts if text.get_text().startswith(r"$\dot\theta")]
    assert len(sectors) == 4
    for text in sectors:
        u, w = axes.transLimits.inverted().transform(np.round(text.get_position()))
        forces = existence.contact_forces(drive, u, w)
        direction = np.sign(drive.input_speed + w)
        relation = {True: ">", False: "<"}
        expected = rf"$\dot\theta {relation[direction > 0]} 0$: "
        if np.sign(forces[0]) * direction == 1:
            first, second = (relation[bool(force > 0)] for force in forces[::-1])
            expected += f"$N {first} 0$ by law −\n($N {second} 0$ by law +)"
        else:
            expected += "no $N$"
        assert text.get_text() == expected
