"""The verdict on a data sheet against closed forms, many digits, and the motions of drives."""

import math

import numpy as np
import pytest
from references.drives import drive_with_law
from references.random_sheets import sheet

from lsvib import Drive
from lsvib.drives import friction
from lsvib.drives.automata import automaton_of
from lsvib.drives.mechanics import coefficients, damping_by_slope
from lsvib.drives.model import standing_state
from lsvib.sheets.assessment import assess
from lsvib.sheets.changes import margins
from lsvib.sheets.draw import Draw, Operation
from lsvib.sheets.reserves import NAMES
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.window import OperatingWindow, worst
from lsvib.stability.boundaries import stable_set
from lsvib.stability.conditions import stability
from lsvib.stability.force_thresholds import threshold_force
from lsvib.systems.attractor import Attractor, steady_state

DAMPED = {"rotational": "2e-4 N*m*s/rad", "translational": "1000 N*s/m"}


def test_the_chapters_drive_has_the_thresholds_of_the_figures():
    """m_cr and the onset, by margins."""
    given = sheet(load={"mass": "1 kg", "force": "-40 N"}, damping=DAMPED)
    found = margins(Draw.of(given))
    of = {name: {row.quantity: row for row in table} for name, table in found.items()}
    screw = Drive.of({"mass": 1.0, "translation_damping": 1e3, "axial_force": 40.0})
    critical = screw.threshold("kinematic_constraint").value
    assert of["kinematic_constraint"]["mass"].value == pytest.approx(critical, rel=1e-9)
    assert of["negative_damping"]["force"].value == pytest.approx(-threshold_force(screw, "onset"), rel=1e-12)


@pytest.mark.parametrize(
    ("mass", "translational", "force", "occurring"),
    [(1, 1000, -40, {"negative_damping"}), (1, 1000, -18, set()), (10, 0, -50, set()),
     (11, 0, -50, {"kinematic_constraint"}), (11, 0, 50, set())],
)  # fmt: skip
def test_the_chapters_drive_has_the_verdicts_of_the_figures(mass, translational, force, occurring):
    """Figs 8.6, 8.9 and 8.14, by both ways of deciding."""
    damping = DAMPED | {"translational": f"{translational} N*s/m"}
    given = sheet(load={"mass": f"{mass} kg", "force": f"{force} N"}, damping=damping)
    window = OperatingWindow(Draw.of(given))
    found = window.worst
    assert {name for name, one in found.items() if one.reserve[0] < 0 and name != "after_perturbation"} == occurring
    for corner in window.corners:
        assert unstable(corner.rigid) == bool(occurring)
    fed = (translational, force) == (1000, -18)  # the drag makes the load resist; under law + it would feed a swing
    assert (found["after_perturbation"].reserve[0] < 0) == (fed or (mass == 11 and force > 0))


def unstable(drive) -> bool:
    """Whether steady sliding is unstable, by exact signs."""
    report = stability(drive)
    return not report.stable and report.kind not in ("neutral", "centre")


def random_sheet(seed: int, support: bool = False, contact: bool = False) -> Sheet:
    rng = np.random.default_rng(seed)

    def log(low: float, high: float) -> float:
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    angle = log(0.5, 45)
    springs = [name for name, there in (("support", support), ("contact", contact)) if there]
    more = {name: {"stiffness": f"{log(1e3, 1e8)} N/m", "damping": f"{log(1e-2, 1e5)} N*s/m"} for name in springs}
    return Sheet.of({
        "name": "random", "thread": {"lead_angle": f"{angle} deg", "pitch_diameter": f"{log(2, 100)} mm"},
        "screw": {"inertia": f"{log(1e-9, 10)} kg*m^2", "mass": f"{log(1e-2, 1e3)} kg"},
        "coupling": {"stiffness": f"{log(1e-3, 1e6)} N*m/rad"},
        "load": {"mass": f"{log(1e-2, 1e4)} kg", "force": f"{rng.choice((-1, 1)) * log(1e-3, 1e6)} N"},
        "operation": {"speed": f"{log(1e-2, 1e4)} rad/s"},
        "friction": {"coefficient": min(log(0.02, 0.9), 0.99 / math.tan(math.radians(angle)))},
        "damping": {"rotational": f"{log(1e-9, 100)} N*m*s/rad", "translational": f"{log(1e-4, 1e6)} N*s/m"},
        **more,
    })  # fmt: skip


@pytest.mark.parametrize("parts", [(), ("support",), ("threads",), ("support", "threads")])
def test_a_mechanism_occurs_exactly_where_the_drive_is_unstable(parts):
    """Reserves in double precision against exact classes, for random drives; but where the reserve is rounding."""
    seen = {True: 0, False: 0}
    for seed in range(60):
        given = random_sheet(seed, support="support" in parts, contact="threads" in parts)
        for corner in OperatingWindow(Draw.of(given)).corners:
            own = [one for name, one in corner.reserves.items() if name in NAMES]
            if abs(min(own)) > 1e-9:
                found = unstable(corner.drive)
                assert found == (min(own) < 0), (seed, corner)
                seen[found] += 1
    assert min(seen.values()) > 1


def test_margins_of_a_supported_drive_are_the_certain_boundaries():
    """The margin in mass and damping of mode coupling against the isolated roots of :func:`stable_set`."""
    seen = 0
    for seed in range(6):
        given = slide(seed)
        draw = Draw.of(given)
        corner = OperatingWindow(draw).corners[0]
        assert corner.reserves["law"] > 0
        table = {row.quantity: row for row in margins(draw)["mode_coupling"]}
        for quantity in ("mass", "axial_support_damping"):
            value = table[quantity].value
            if value is None:
                continue
            if abs(worst(draw.changed(**{quantity: value}))["negative_damping"].reserve[0]) < 1e-9:
                continue  # there the cause changes its name, not the stability
            ends = [float(x) for pair in stable_set(corner.drive, quantity).intervals for x in pair]
            assert min(abs(value / end - 1) for end in ends if end > 0) < 1e-9, (seed, quantity)
            seen += 1
    assert seen > 4


def slide(seed: int) -> Sheet:
    """A drive near the machine slide of the examples, which mode coupling can reach."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.6, 1.6, 7)
    return Sheet.of({
        "name": "slide", "thread": {"size": "Tr 20x4"}, "screw": {"length": f"{0.6 * size[0]} m", "diameter": "18 mm"},
        "coupling": {"stiffness": f"{140 * size[1]} N*m/rad"}, "operation": {"speed": "10 mm/s", "direction": "out"},
        "load": {"mass": f"{120 * size[2]} kg", "force": "-500 N"}, "friction": {"coefficient": 0.15 * size[3]},
        "damping": {"rotational": f"{1e-3 * size[4]} N*m*s/rad"},
        "support": {"stiffness": f"{5e7 * size[5]} N/m", "damping": f"{2000 * size[6]} N*s/m"},
    })  # fmt: skip


@pytest.mark.parametrize(
    "more",
    [{}, *({"friction": {"coefficient": 0.218, "slope": f"{slope} s/m"}} for slope in (-0.05, 0.05)),
     {"support": {"stiffness": "1e5 N/m", "damping": "3 N*s/m"}},
     {"contact": {"stiffness": "1e6 N/m", "damping": "30 N*s/m"}}],
)  # fmt: skip
def test_no_point_of_the_window_is_worse_than_its_corners(more):
    """Against random points of the window, for random masses and dampings."""
    rng = np.random.default_rng(4)
    for _ in range(8):
        given = sheet(
            load={"mass": f"{rng.uniform(0.5, 14)} kg", "orientation": f"{rng.uniform(-90, 90)} deg",
                  "force": [f"{rng.uniform(-80, -1)} N", f"{rng.uniform(1, 80)} N"]},
            operation={"speed": [f"{rng.uniform(1, 20)} rad/s", f"{rng.uniform(25, 90)} rad/s"]},
            damping=DAMPED | {"translational": f"{rng.uniform(0, 1500)} N*s/m"},
            screw={"inertia": "3.12e-6 kg*m^2", "mass": "2 kg"}, **more,
        )  # fmt: skip
        draw = Draw.of(given)
        found = worst(draw)
        speed = rng.uniform(draw.values["speed_low"], draw.values["speed_high"], 3000)
        force = rng.uniform(draw.values["force_low"], draw.values["force_high"], 3000)
        for direction in (1, -1):
            inside = Operation(draw, direction, speed, force).reserves
            for name, one in found.items():
                assert one.reserve[0] <= inside[name].min() + 1e-9, name


def test_under_one_force_the_speed_at_which_the_drag_balances_it_is_looked_at():
    """Friction that rises with speed damps the less, the smaller |R̃|: enough at 10 and 150 rad/s, not at 98."""
    given = sheet(
        load={"mass": "1 kg", "force": "-50 N"}, operation={"speed": ["10 rad/s", "150 rad/s"], "direction": "out"},
        friction={"coefficient": 0.218, "slope": "0.3 s/m"}, damping=DAMPED,
    )  # fmt: skip
    draw = Draw.of(given)
    found = worst(draw)["negative_damping"]
    ends = [Operation(draw, 1, end, -50.0).reserves["negative_damping"] for end in (10.0, 150.0)]
    assert found.reserve[0] < 0 < min(ends)
    drive = OperatingWindow(draw).critical("negative_damping").rigid
    c = coefficients(drive)
    assert float(c.damping[1]) < 0  # and the slope of friction adds next to nothing
    assert abs(float(c.net_force)) < 1e-6 < float(coefficients(drive.replace(input_speed=10.0)).net_force)
    assert assess(given, samples=64).verdict == "vibrates"


@pytest.mark.parametrize(("force", "verdict"), [(50, "steady"), (10, "jerks")])
def test_a_perturbation_starts_vibration_in_fig_8_14b_and_not_in_a(force, verdict):
    """R = −50 N attracts globally, R = −10 N does not: a tolerated perturbation leads back, a larger one not."""
    given = sheet(load={"mass": "11 kg", "force": f"{force} N"}, damping={"rotational": "1e-3 N*m*s/rad"})
    found = assess(given, samples=64)
    assert found.verdict == verdict
    if verdict == "steady":
        return
    corner = found.perturbed.there
    size, _ = corner.tolerated
    drive = corner.rigid
    assert steady_state(automaton_of(drive), standing_state(drive)).label == Attractor.SPRAG_SLIP_CYCLE
    ends = {w: steady_state(automaton_of(drive), [0.0, w * size]).label for w in (0.999, -0.999, 1.001, -1.001)}
    assert ends[0.999] == ends[-0.999] == Attractor.STEADY_SLIDING
    assert Attractor.SPRAG_SLIP_CYCLE in (ends[1.001], ends[-1.001])


def test_slope_damping_is_that_of_newtons_laws():
    """Γ_0 s² + (C_0 + S) s + k is the polynomial of the report, which they hold in test_friction_law.py."""
    rng = np.random.default_rng(5)
    for drive in (drive_with_law("rigid", rng) for _ in range(25)):
        c, (first, second, _) = coefficients(drive), stability(drive).characteristic_polynomial
        lead, size = (math.cos(drive.lead_angle), math.tan(drive.lead_angle)), abs(float(c.net_force))
        mu, slope = friction.unbounded(drive, drive.pitch_radius * abs(drive.input_speed) / lead[0])
        more = damping_by_slope(slope, size, mu, drive.pitch_radius, *lead, c.steady_law)
        damping, inertia = float(c.damping[c.steady_law]) + more, float(c.gamma[c.steady_law])
        assert damping / inertia == pytest.approx(second / first, rel=1e-9)


def test_friction_that_falls_with_speed_sets_in_where_its_damping_is_spent():
    """At the margin of the slope the sum of the dampings vanishes, on lifting as well."""
    given = sheet(load={"mass": "1 kg", "force": "60 N"}, friction={"coefficient": 0.218, "slope": "-0.01 s/m"})
    draw = Draw.of(given)
    table = {row.quantity: row for row in margins(draw)["falling_friction"]}
    drive = OperatingWindow(draw).corners[0].rigid
    lead = math.cos(drive.lead_angle), math.tan(drive.lead_angle)
    critical = -drive.support_damping / damping_by_slope(1.0, 60.0, 0.218, drive.pitch_radius, *lead, -1)
    assert table["friction_slope"].value == pytest.approx(critical, rel=1e-10)
