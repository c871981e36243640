"""The values in a caption, where arrows and words stand; cycles of compliant threads, and their impacts."""

import math

import numpy as np
import pytest
import xarray as xr
from references.drives import PARADOX
from references.figure_checks import assert_drawn_from_file, coarse, dataset_of
from references.sizes import sizes

from lsvib import Drive
from lsvib.answers import phase_plane
from lsvib.answers.io import write_dataset
from lsvib.chapter import contact_force, fig8_07, impacts
from lsvib.chapter.build import caption_of
from lsvib.chapter.build import drawn as picture
from lsvib.drives.automata import automaton_of
from lsvib.drives.mechanics import coefficients
from lsvib.drives.model import seated_state
from lsvib.drives.names import RULES, Event, MotionMode
from lsvib.dynamics.impulses import seizure_impulse
from lsvib.pictures import drawing as drawn
from lsvib.pictures import style
from lsvib.systems.motion import follow


def parameters() -> xr.Dataset:
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
    assert words.startswith("Stability of steady sliding")
    assert values.replace("\\_", "_") == (
        "Values: As printed: m = 10 kg, R = −50 N. Assumed: m = 11 kg, k_c = 10⁸ N m⁻¹. Otherwise Table 8.1."
    )
    assert "Values" not in caption_of("fig8_03", xr.Dataset())


@pytest.mark.slow
def test_maps_and_charts_fit_the_page(tmp_path):
    drive = PARADOX
    starts = drive.attraction({"u": (-0.3, 0.3, 20), "w": (-150, 150, 20)})
    chart = drive.sweep(mass=np.linspace(1, 20, 9), axial_force=np.linspace(-40, 60, 9))
    for figure, dataset in {"attraction": starts, "chart": chart}.items():
        write_dataset(dataset, tmp_path / f"{figure}.nc")
        assert_drawn_from_file(figure, tmp_path / f"{figure}.nc")


SIDES = {
    "contact force along the motion": {"mass": 1.0, "translation_damping": 1000.0, "axial_force": 30.0},
    "contact force against the motion": {"mass": 1.0, "translation_damping": 1000.0, "axial_force": 15.0},
    "backwards": {"mass": 1.0, "translation_damping": 1000.0, "axial_force": -30.0, "input_speed": -40.0},
    "beyond the critical mass": {"mass": 11.0, "axial_force": 50.0},
    "beyond the critical mass, backwards": {"mass": 11.0, "axial_force": -50.0, "input_speed": -40.0},
}


def solving(drive: Drive, u: float, w: float) -> list[str]:
    """The signs of the contact forces (8.17) that solve at a state, that of law − first, which a motion takes."""
    forces, direction = contact_force.contact_forces(drive, u, w)[::-1], np.sign(drive.input_speed + w)
    return ["<>"[int(x > 0)] for law, x in zip((-1, 1), forces, strict=True) if np.sign(x) * direction == law]


@pytest.mark.parametrize("words", SIDES)
def test_the_sides_of_the_line_have_the_sign_of_the_contact_force(words):
    drive = Drive.of(SIDES[words])
    settings = {"starts": [{"u": 0.01, "w": 0.0}], "duration": 0.01, "samples": 200}
    case = phase_plane.portraits(settings, [drive]).isel(case=0)
    axes = (figure := style.new_figure()).add_subplot()
    axes.set(xlim=(-0.15, 0.15), ylim=(-120, 120))
    drawn.guide(figure, [axes], [case])
    named = [(text.get_text(), solving(drive, *text.get_position())) for text in axes.texts if text.get_text()]
    assert {"$N > 0$", "$N < 0$"} <= set(dict(named))
    assert all(text == (f"$N {found[0]} 0$" if found else "no solution") for text, found in named)


@pytest.mark.parametrize("figure", sizes(["fig8_04"], ["fig8_05", "fig8_06"]))
def test_both_sides_of_the_line_have_a_name_in_every_phase_plane(figure):
    panels = [axes for axes in picture(figure, dataset_of(figure)).axes if "dot u" in axes.get_ylabel()]
    assert panels
    for axes in panels:
        assert [text.get_text() for text in axes.texts if text.get_text()] == ["$N > 0$", "$N < 0$"]


def test_the_sectors_of_figure_8_7_have_the_signs_of_the_contact_force():
    figure, settings = dataset_of("fig8_07"), coarse("fig8_07")
    drive = Drive.of(settings["drive"])
    axes = style.styled(fig8_07.draw)(figure).axes[0]
    sectors = [text for text in axes.texts if text.get_text().startswith(r"$\dot\theta")]
    assert len(sectors) == 4
    for text in sectors:
        u, w = axes.transLimits.inverted().transform(np.round(text.get_position()))
        words = "$N {} 0$ by law −\n($N {} 0$ by law +)".format(*found) if (found := solving(drive, u, w)) else "no $N$"
        expected = rf"$\dot\theta {'<>'[int(drive.input_speed + w > 0)]} 0$: {words}"
        assert text.get_text() == expected


def test_after_a_stop_left_of_the_corner_the_contact_force_is_negative():
    """In Fig. 8.14d Q falls by m r_m tan λ c (u′ + Ω) in the stop, and the screw goes on forwards."""
    drive = Drive(mass=11.0, support_damping=1e-3, axial_force=-10.0)
    before, after = (np.array(coefficients(drive).q_row, dtype=float) @ [0.03, w, 1.0] for w in (20.0, -40.0))
    lever = drive.mass * drive.pitch_radius * math.tan(drive.lead_angle)
    assert before > 0 > after == pytest.approx(before - lever * drive.support_damping * 60.0, rel=1e-9)
    for motion in (phase_plane.followed(drive, {"u": 0.03, "w": 20.0}, 1e-3, rule) for rule in RULES):
        assert (motion.kind[0], motion.time[0]) == (Event.SEIZURE, 0.0)
        assert motion.automaton.codes[motion.mode[0]] == MotionMode.SLIP_FORWARD_NEGATIVE


def test_impulse_is_the_integral_of_the_contact_force():
    base = Drive.of(mass=15.0, axial_force=60.0, support_damping=2e-3)
    drive = base.replace(contact_stiffness=1e8, contact_damping=1e8)
    _, *state = next(impacts.impacts(base, 80.0))
    automaton = automaton_of(drive)
    motion = follow(automaton, seated_state(drive, *state), 1e-3)
    release = motion.time[np.flatnonzero(motion.kind == Event.RELEASE)[0]]
    times = np.linspace(0.0, release, 2_000_001)
    force = automaton.observe("normal_force", *motion.at(times))
    integral = float(np.sum(0.5 * (force[1:] + force[:-1])) * times[1])
    assert integral == pytest.approx(float(seizure_impulse(base, 80.0)), rel=1e-3)


@pytest.mark.parametrize(("stiffness", "axial_force"), [(1e12, 25.0), (1e13, 40.0), (1e14, 60.0)])
def test_rebound_force_of_an_overdamped_contact(stiffness, axial_force):
    """How far N of the standing screw falls below its static value after a forward impact, by the formula (ζ = 20).

    The static value is that of the balance at rest, N = R cos λ − T_r sin λ / r_m; R keeps the contact closed. What an
    axial force gives to N is cos λ of it. 3 %: the formula leaves out that law + makes the contact stiffer than rest
    does, by cos λ (cos λ + μ sin λ) = 1.012, and that the slow part loses 3 ln(4ζ²) / (4ζ²) = 1.4 % until the fast one,
    4ζ² times as fast, is gone.
    """
    base = Drive.of(mass=15.0, axial_force=axial_force, support_damping=2e-3)
    damping, speed = 40 * math.sqrt(stiffness * base.mass), 80.0
    drive = base.replace(contact_stiffness=stiffness, contact_damping=damping)
    state = [(u, w) for sign, u, w in impacts.impacts(base, speed) if sign > 0][2]  # in the band, Q > 0
    automaton = automaton_of(drive)
    motion = follow(automaton, seated_state(drive, *state), 7e-4)
    (stop,) = np.flatnonzero(motion.kind == Event.STICK)
    assert stop == motion.kind.size - 1  # it stands until the end
    times = motion.time[stop] + np.geomspace(1e-12, motion.end_time - motion.time[stop], 20_001)[:-1]
    states, modes = motion.at(times)
    force = automaton.observe("normal_force", states, modes)
    torque = automaton.observe("coupling_torque", states, modes)
    static = axial_force * math.cos(drive.lead_angle) - torque * math.sin(drive.lead_angle) / drive.pitch_radius
    fall = (static - force) / math.cos(drive.lead_angle)
    assert abs(fall[-1]) < 0.02 * fall.max() < 0.02 * axial_force
    nut = drive.pitch_radius * math.tan(drive.lead_angle) * speed
    assert fall.max() == pytest.approx(drive.mass**2 * nut * stiffness**2 / damping**3, rel=0.03)
