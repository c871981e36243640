"""What the report says: friction at speed, rare cases, what a sheet leaves out, advice; verdicts once too good."""

import math

import numpy as np
import pytest
import yaml
from references.random_sheets import LAW, random_sheet, sheet
from references.sizes import sizes

from lsvib.drives.automata import automaton_of
from lsvib.drives.model import model_of
from lsvib.errors import InputError
from lsvib.sheets.assessment import assess
from lsvib.sheets.changes import ANY, margins
from lsvib.sheets.draw import Draw, Operation
from lsvib.sheets.formulas import lifting_efficiency, sliding_speed
from lsvib.sheets.output import as_json
from lsvib.sheets.report import brief, of_curve, report, said
from lsvib.sheets.reserves import NAMES
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.vibration import tolerated_by_trial
from lsvib.sheets.window import OperatingWindow, applicable, worst
from lsvib.sheets.words import ATTRACTORS, percent
from lsvib.stability.conditions import conditions
from lsvib.systems.attractor import Attractor, steady_state

TANGENT = math.tan(math.radians(5.57))


def rubs(given, v):
    """Friction coefficient of the part of a sheet that has a whole law, at a sliding speed [mm/s]."""
    level, rise, scale, slope = (getattr(given, key).nominal for key in LAW)
    return level + rise * math.exp(-((1e-3 * v / scale) ** given.stribeck_exponent)) + slope * 1e-3 * v


def test_the_efficiency_is_that_of_friction_at_the_running_speed():
    given = sheet(friction=LAW)
    sliding = sliding_speed(40.0, 5.18, math.radians(5.57))
    expected = lifting_efficiency(rubs(given.friction, sliding), math.radians(5.57))
    assert Draw.of(given).efficiencies[0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("law", "speeds"),
    [
        (LAW, [1.0, 5.0, 15.0, 40.0, 100.0]),
        (LAW | {"coefficient": 0.1, "slope": "0.2 s/m", "stribeck_exponent": 2}, [1.02**k for k in range(250)]),
        (LAW | {"slope": "0 s/m"}, [2.0, 9.0, 20.0, 60.0]),
        (LAW | {"stribeck_rise": 0.0}, [2.0, 9.0, 30.0, 60.0]),
    ],
)
def test_a_curve_of_a_law_is_that_law(law, speeds):
    """Of five points all of it, of four a rise or a slope."""
    expected = sheet(friction=law).friction
    read = sheet(friction={"curve": [[f"{v!r} mm/s", rubs(expected, v)] for v in speeds]}).friction
    for key in LAW if expected.stribeck_rise.nominal else ("coefficient", "stribeck_rise", "slope"):
        assert getattr(read, key).nominal == pytest.approx(getattr(expected, key).nominal, rel=2e-6, abs=1e-8), key
    assert read.law
    assert read.stribeck_exponent == expected.stribeck_exponent


@pytest.mark.parametrize(
    ("coefficients", "poor"), [([0.2, 0.18, 0.15, 0.12, 0.1, 0.11], False), ([0.05, 0.06, 0.08, 0.1, 0.12, 0.13], True)]
)
def test_how_far_a_law_is_off_its_curve_is_said(coefficients, poor):
    """No law rises fast and then slowly."""
    pairs = list(zip((5.0, 10.0, 20.0, 40.0, 100.0, 200.0), coefficients, strict=True))
    friction = {"curve": [[f"{v} mm/s", mu] for v, mu in pairs]}
    given = sheet(friction=friction, operation={"speed": "4 rad/s"})
    share, v = max((abs(rubs(given.friction, v) / mu - 1), v) for v, mu in pairs)
    text = said("curve", of_curve(Draw.of(given)))
    assert f"deviates by at most {percent(share)}, at {v:g} mm/s" in text
    assert ("may not hold for the curve" in text) == poor
    assert "The threads slide at" not in text
    given = sheet(friction=friction, operation={"speed": ["4 rad/s", "40 rad/s"]})
    text = said("curve", of_curve(Draw.of(given)))
    assert "slide at 20.8 mm/s to 208 mm/s, but the curve has only 5 mm/s to 200 mm/s" in text


def test_the_share_of_self_locking_threads_is_that_of_friction_above_the_tangent():
    """A uniform coefficient from 0.05 to 0.15 about tan λ = 0.0975."""
    found = as_json(assess(sheet(friction={"coefficient": [0.05, 0.15]}), samples=4096))
    assert found["self_locking_probability"] == pytest.approx((0.15 - TANGENT) / 0.1, abs=1e-3)
    ends = [lifting_efficiency(mu, math.radians(5.57)) for mu in (0.15, 0.05)]
    assert found["efficiency"]["lifting_range"] == pytest.approx(ends, rel=1e-3)


RARE = {
    "thread": {"lead_angle": "5.57 deg", "pitch_diameter": "10.36 mm"},
    "load": {"mass": {"low": "1 kg", "mode": "2 kg", "high": "10.4 kg"}, "force": "-50 N"},
    "friction": {"coefficient": {"low": 0.1, "mode": 0.15, "high": 0.218}},
}


def test_a_corner_that_no_sample_hits_is_not_passed_over():
    """At the heaviest load with the highest friction Γ₀ is negative, although no sample of 256 is there."""
    found = assess(sheet(**RARE), samples=256)
    assert found.uncertainty.any.value == 0
    assert found.verdict == "steady but for rare values"
    assert found.worst.mechanism == "kinematic_constraint"
    assert found.worst.vibration.attractor == "sprag slip cycle"
    lighter = {**RARE, "load": {**RARE["load"], "mass": {"low": "1 kg", "mode": "2 kg", "high": "10 kg"}}}
    assert assess(sheet(**lighter), samples=256).verdict == "steady"


def test_a_fall_of_friction_that_upsets_a_supported_drive_is_called_by_its_name():
    """Stable with friction as at the running speed, unstable with its slope, though C_0 + S is positive."""
    given = {
        "load": {"mass": "190 kg", "force": "200 N"}, "thread": {"lead_angle": "8.5 deg", "pitch_diameter": "10 mm"},
        "screw": {"inertia": "1.9e-5 kg*m^2", "mass": "6 kg"}, "coupling": {"stiffness": "40 N*m/rad"},
        "damping": {"rotational": "3e-4 N*m*s/rad", "translational": "1500 N*s/m"},
        "support": {"stiffness": "1e7 N/m", "damping": "100 N*s/m"},
    }  # fmt: skip
    level, falling = sheet(**given), sheet(**given, friction={"coefficient": 0.218, "slope": "-0.2 s/m"})
    assert all(worst(Draw.of(level))[name].reserve[0] > 0 for name in applicable(level))
    found = worst(Draw.of(falling))
    assert found["falling_friction"].reserve[0] < 0
    assert found["mode_coupling"].reserve[0] > 0


def test_a_damping_that_is_not_given_has_a_margin_in_its_own_unit():
    """Rotational damping ends negative damping where C_0 = 0; damping of the load starts it at C_0 = 0."""
    fed = sheet(load={"mass": "1 kg", "force": "-60 N"}, damping={"translational": "1000 N*s/m"})
    draw = Draw.of(fed)
    row = next(row for row in margins(draw)[ANY] if row.quantity == "support_damping")
    assert row.factor is None
    at = conditions(OperatingWindow(draw).corners[0].rigid)["negative_damping"].margins
    assert row.value == pytest.approx(at["negative_effective_damping"], rel=1e-12)
    calm = sheet(load={"mass": "1 kg", "force": "-60 N"})
    row = next(row for row in margins(Draw.of(calm))[ANY] if row.quantity == "translation_damping")
    xi = (0.218 - TANGENT) / (1 + 0.218 * TANGENT)
    # Beyond c_x = R / (r_m tan λ Ω) the load would resist; 60 N are enough for the damping at which C_0 vanishes.
    assert row.value == pytest.approx(2e-4 / (xi * TANGENT * 5.18e-3**2), rel=1e-9)


def test_advice_makes_the_drive_steady_as_a_whole():
    """Two causes at once: on the far side of each margin none of them occurs, on the near side one does."""
    given = sheet(load={"mass": "12 kg", "force": "-60 N"}, damping={"translational": "1000 N*s/m"})
    draw = Draw.of(given)
    found = worst(draw)
    assert max(found[name].reserve[0] for name in ("negative_damping", "kinematic_constraint")) < 0
    rows = [row for row in margins(draw)[ANY] if row.factor is not None]
    keys = {"force": ("force_low", "force_high"), "speed": ("speed_low", "speed_high")}
    assert len(rows) > 4
    for row in rows:
        for side, steady in ((1 + 1e-9, True), (1 - 1e-9, False)):
            factor = row.factor * (side if row.factor > 1 else 2 - side)
            found = worst(draw.scaled(keys.get(row.quantity, (row.quantity,)), factor))
            assert all(found[name].reserve[0] >= 0 for name in NAMES if name in found) == steady, row


def test_a_soft_contact_can_keep_a_drive_steady_that_stiff_threads_would_not():
    """Γ₀ < 0 makes the rigid drive unstable; with the given contact steady running returns, and the verdict says so."""
    load = {"mass": "14 kg", "force": "-100 N"}
    soft = {"stiffness": "1e5 N/m", "damping": "30 N*s/m"}
    damping = {"rotational": "2e-4 N*m*s/rad", "translational": "20 N*s/m"}
    stiff, given = sheet(load=load, damping=damping), sheet(load=load, damping=damping, contact=soft)
    assert assess(stiff, samples=64).mechanisms["kinematic_constraint"].occurs
    found = assess(given, samples=64)
    assert not any(one.occurs for one in found.mechanisms.values())
    assert found.nominal.vibration.parts == ("threads",)
    assert found.nominal.vibration.attractor == "steady sliding"


@pytest.mark.parametrize(
    ("stiffness", "damping", "share"), [("1e8 N/m", "1e8 N*s/m", 1.0), ("1e7 N/m", "1e3 N*s/m", 1.6)]
)
def test_what_compliant_threads_tolerate_is_decided_by_their_own_motions(stiffness, damping, share):
    """Below it motions with compliant threads come back, above it one does not; very stiff ones are as rigid ones."""
    given = sheet(
        load={"mass": "11 kg", "force": "10 N"},
        damping={"rotational": "1e-3 N*m*s/rad"},
        contact={"stiffness": stiffness, "damping": damping},
    )
    draw = Draw.of(given)
    corner = OperatingWindow(draw).corners[0]
    stiff, _ = corner.tolerated
    size, sentence = tolerated_by_trial(corner.drive, stiff)
    assert size == pytest.approx(share * stiff, rel=0.01 if share == 1 else 0.05)
    assert "With rigid threads" in sentence
    drive = corner.drive
    automaton = automaton_of(drive)

    def ends(part: float) -> set:
        starts = [model_of(drive).initial_state(drive, {"u": 0.0, "w": sign * part * size}) for sign in (1, -1)]
        return {steady_state(automaton, start).label for start in starts}

    assert ends(0.99) == {Attractor.STEADY_SLIDING}
    assert ends(1.02) != {Attractor.STEADY_SLIDING}


@pytest.mark.parametrize(
    ("changes", "survived"),
    [({"load": {"mass": "9.9 kg", "force": "-10 N"},
       "damping": {"rotational": "2e-4 N*m*s/rad", "translational": "1e3 N*s/m"}}, 23.65),
     ({"thread": {"lead_angle": "4.97611 deg", "pitch_diameter": "2.89556 mm"},
       "screw": {"inertia": "1.36909e-5 kg*m^2"}, "coupling": {"stiffness": "34530.4 N*m/rad"},
       "load": {"mass": "137.517 kg"}, "operation": {"speed": ["0.001 m/s", "3.80049 m/s"]},
       "friction": {"coefficient": 0.5}, "damping": {"translational": "0.360939 N*s/m"}}, None)],
)  # fmt: skip
def test_a_load_that_resists_by_its_drag_alone_does_not_hide_a_vibration(changes, survived):
    """C₊ < 0 < Γ₊ and R̃ Ω < 0: the basin ends at a cycle, so that a perturbation starts vibration."""
    found = assess(sheet(**changes), samples=64)
    assert not any(one.occurs for one in found.mechanisms.values())
    assert found.verdict == "jerks"  # a start from rest is such a perturbation
    assert as_json(found)["after_perturbation"] == {"possible": True, "probability": 1.0, "interval": [1.0, 1.0]}
    assert found.nominal.vibration.vibrates
    corner = found.perturbed.there
    size, _ = corner.tolerated
    assert size == (None if survived is None else pytest.approx(survived, abs=0.01))


def test_every_end_of_a_motion_has_plain_words():
    """Each attractor of the package, as the report names it."""
    assert {label.name.lower().replace("_", " ") for label in Attractor} <= set(ATTRACTORS)


@pytest.mark.parametrize("direction", ["out", "back"])
def test_both_directions_are_mirror_images(direction):
    """A drive that goes back under the opposite force is the drive that goes out."""
    sign = 1 if direction == "out" else -1
    given = sheet(
        load={"mass": "9 kg", "force": [f"{sign * -70 + 10} N", f"{sign * -70 + 30} N"]},
        operation={"speed": ["20 rad/s", "40 rad/s"], "direction": direction},
        damping={"rotational": "2e-4 N*m*s/rad", "translational": "300 N*s/m"},
    )
    draw = Draw.of(given)
    for corner in OperatingWindow(draw).corners:
        mirrored = Operation(draw, -corner.direction, corner.speed, -corner.force)
        one, other = corner.reserves, mirrored.reserves
        assert {name: float(x) for name, x in one.items()} == {name: float(x) for name, x in other.items()}


def sheet_of(text, **more):
    return Sheet.of({"name": "a drive", **yaml.safe_load(text), **more})


FALLS_BETWEEN = """
    thread: {lead: 4 mm, pitch_diameter: 12 mm}
    screw: {inertia: 4e-6 kg*m^2}
    coupling: {stiffness: 5 N*m/rad}
    load: {mass: 1 kg, force: 100 N}
    operation: {speed: [1 rpm, 3000 rpm], direction: out}
    friction: {coefficient: 0.1, stribeck_rise: 0.05, stribeck_speed: 12 mm/s, stribeck_exponent: 2}
    damping: {rotational: 6e-3 N*m*s/rad, translational: 10 N*s/m}
"""
RANGE = {"stiffness": ["40 N*m/rad", "60 N*m/rad"]}
UNDAMPED = """
    thread: {size: Tr 16x4}
    screw: {length: 400 mm, material: steel}
    coupling: {stiffness: 50 N*m/rad}
    load: {mass: 20 kg, force: 100 N, orientation: horizontal}
    friction: {coefficient: 0.15}
"""
LIFT = """
    thread: {lead: 5 mm, pitch_diameter: 20 mm}
    screw: {length: 1 m}
    coupling: {stiffness: 500 N*m/rad}
    load: {mass: 80 kg, orientation: vertical}
    operation: {speed: 100 mm/s}
    friction: {efficiency: 85 %}
"""
FROM_REST = """
    thread: {size: Tr 8x2}
    screw: {length: 200 mm, material: stainless steel}
    coupling: {stiffness: 1 N*m/rad}
    load: {mass: 5 kg, force: 100 N}
    operation: {speed: 100 rpm, direction: out}
    friction: {coefficient: 0.2, static: 0.35}
    damping: {rotational: 2e-4 N*m*s/rad, translational: 20 N*s/m}
"""


def lowest_of_dense(draw, name):
    """The lowest reserve over a dense grid of the window, as far as it is not where friction is at the cut."""
    speeds = np.geomspace(draw.values["speed_low"], draw.values["speed_high"], 4000)
    forces = np.linspace(draw.values["force_low"], draw.values["force_high"], 9)[:, None]
    return min(float(np.nanmin(Operation(draw, side, speeds, forces).reserves[name])) for side in draw.sheet.directions)


def test_a_fall_of_friction_between_two_speeds_is_seen():
    """Unstable from 3.8 to 26 rpm of 1 to 3000."""
    given = sheet_of(FALLS_BETWEEN)
    found = assess(given, samples=64)
    assert found.verdict == "vibrates"
    one = found.mechanisms["falling_friction"]
    assert one.reserve == pytest.approx(lowest_of_dense(found.draw, "falling_friction"), abs=1e-5)
    assert 3.8 < one.there.speed * 30 / np.pi < 26


def windows(seed, indices):
    """Assert that no dense look at a window finds a mechanism where none is found; how many windows were looked at."""
    looked = 0
    for index in indices:
        try:
            given = Sheet.of(random_sheet(seed, index))
        except InputError:
            continue
        draw = Draw.of(given)
        if draw.values["speed_low"] == draw.values["speed_high"]:
            low, high = 0.02 * draw.values["speed_low"], 50 * draw.values["speed_high"]
            speed = [f"{low!r} rad/s", f"{high!r} rad/s"]
            given = Sheet.of({**random_sheet(seed, index), "operation": {"speed": speed}})
            draw = Draw.of(given)
        found = worst(draw)
        own = {name: one.reserve[0] for name, one in found.items() if name != "after_perturbation"}
        if not np.isnan(list(own.values())).any() and min(own.values()) >= 0:
            dense = min(lowest_of_dense(draw, name) for name in own)
            assert dense >= -1e-6, (index, dense, own)
        looked += 1
    return looked


@pytest.mark.parametrize("sheets", sizes([(11, range(40))], [], [(12, range(1100))]))
def test_windows_are_seen_as_a_dense_look_sees_them(sheets):
    assert windows(*sheets) > (20 if len(sheets[1]) == 40 else 1000)


SPRING = {"stiffness": "1e7 N/m"}


@pytest.mark.parametrize("direction", ["out", "back", "both"])
@pytest.mark.parametrize(
    "parts",
    [{"support": SPRING}, {"contact": SPRING | {"damping": "0 N*s/m"}},
     {"support": SPRING, "contact": SPRING | {"damping": "0 N*s/m"}}],
)  # fmt: skip
def test_a_drive_that_nothing_damps_has_no_reserve(parts, direction):
    """Reserves of two undamped bodies say that no motion grows, not that one decays."""
    found = assess(sheet_of(UNDAMPED, operation={"speed": "10 mm/s", "direction": direction}, **parts), samples=64)
    assert found.verdict == "steady without reserve"
    assert found.mechanisms["negative_damping"].reserve == 0


@pytest.mark.parametrize("damping", ["1e-3", "4e-3", "5e-3"])
def test_no_guessed_damping_lessens_what_a_brake_must_hold(damping):
    given = sheet_of(LIFT, damping={"rotational": f"{damping} N*m*s/rad", "translational": "100 N*s/m"})
    found = assess(given, samples=64)
    for name in ("holding_torque", "braking_torque"):
        assert found.statics.rows[name].worst == pytest.approx(0.5144, abs=5e-5)
    assert any("514 mN m to hold at rest" in line for line in brief(found))


def test_a_lead_beside_a_nominal_diameter_needs_its_starts():
    """With one start the pitch diameter of 8 × 8 would be 4 mm; a Tr 8x8 P2 has four, and 7 mm."""
    thread = {"lead": "8 mm", "nominal_diameter": "8 mm", "starts": 4}
    assert Draw.of(sheet_of(LIFT, thread=thread)).values["pitch_diameter"] == pytest.approx(7e-3)


def test_vibration_that_starts_from_rest_alone_is_seen():
    """Motions from −5 Ω settle at every speed, those from rest vibrate up to 34.705 rad/s."""
    found = assess(sheet_of(FROM_REST), samples=64)
    assert found.from_rest.even_speed == pytest.approx(34.705, rel=1e-3)


def test_what_was_drawn_is_said_and_that_of_single_values_nothing_was():
    given = {"operation": {"speed": "10 mm/s"}, "damping": {"rotational": "1e-3 N*m*s/rad"}}
    single, drawn = (assess(sheet_of(UNDAMPED, **given, **more), 64) for more in ({}, {"coupling": RANGE}))
    assert "In 0 % of them steady" in report(drawn, [])
    assert "drives were drawn" not in report(single, [])
    assert "single values only, so nothing was varied" in brief(single)[1]


def test_changes_name_a_damping_that_the_sheet_does_not_give():
    """Negative damping, which rotational damping alone would end."""
    given = sheet_of(
        UNDAMPED,
        load={"mass": "0.1 kg", "force": "-100 N"},
        operation={"speed": "10 mm/s", "direction": "out"},
        damping={"translational": "500 N*s/m"},
    )
    (line,) = (line for line in brief(assess(given, samples=64)) if "one of these changes" in line)
    assert "rotational damping of the screw of at least" in line
    assert "which the sheet does not give" in line
