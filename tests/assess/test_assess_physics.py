"""The verdict on a data sheet against closed forms, published tables, many digits, and simulated drives."""

import math

import mpmath
import numpy as np
import pytest

pytest.importorskip("pint")
pytest.importorskip("scipy")

from lsvib.assess import drive as sheets
from lsvib.assess.assessment import assess
from lsvib.assess.catalogue import thread_size
from lsvib.assess.chart import charts
from lsvib.assess.friction import (
    coefficient_from_efficiency,
    damping_by_slope,
    lifting_efficiency,
    lowering_efficiency,
    square_coefficient,
)
from lsvib.assess.margins import margins, sensitivities
from lsvib.assess.mechanisms import certain, drive_of, reserves
from lsvib.assess.sheet import Sheet
from lsvib.assess.uncertainty import draw_of, evaluated, study
from lsvib.assess.window import corners, worst
from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.drives.coefficients import coefficients
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import rigid_automaton
from lsvib.steady_sliding.boundaries import stable_set
from lsvib.steady_sliding.conditions import critical_mass
from lsvib.steady_sliding.eigenvalues_rigid import eigenvalues
from lsvib.steady_sliding.thresholds import detach_force, onset_force, stick_force

# PBC Linear, white paper "Lead Screw Efficiency": per cent by lead [mm]; diameters 6, 10, 12, 16 mm.
COATED = {
    1: (39, 28, 24, 19), 2: (60, 45, 40, 33), 4: (71, 61, 56, 49), 5: (76, 66, 62, 55), 6: (77, 69, 65, 58),
    8: (81, 74, 71, 65), 10: (84, 78, 75, 69), 12: (84, 80, 77, 72), 16: (None, 84, 81, 77), 25: (None, 86, 85, 83),
}  # fmt: skip
UNCOATED = {
    1: (30, 21, 18, 14), 2: (51, 36, 31, 25), 4: (62, 52, 47, 40), 5: (68, 57, 53, 45), 6: (70, 61, 56, 49),
    8: (75, 66, 62, 56), 10: (78, 71, 67, 61), 12: (81, 74, 70, 64), 16: (None, 78, 75, 70), 25: (None, 83, 81, 77),
}  # fmt: skip
# Trapezoidal screws, transdev.co.uk: thread, lead angle [degree, minute], efficiency at friction 0.1 and 0.2.
TRAPEZOIDAL = [
    ("Tr 10x2", (4, 2), 0.41, 0.26), ("Tr 10x4 P2", (8, 3), 0.58, 0.40), ("Tr 12x3", (5, 12), 0.47, 0.31),
    ("Tr 12x6 P3", (10, 19), 0.63, 0.46), ("Tr 14x4", (6, 3), 0.51, 0.34), ("Tr 16x4", (5, 12), 0.47, 0.31),
    ("Tr 18x4", (4, 33), 0.44, 0.28), ("Tr 20x4", (4, 3), 0.41, 0.26), ("Tr 20x8 P4", (8, 3), 0.58, 0.40),
    ("Tr 22x5", (4, 40), 0.45, 0.28), ("Tr 24x5", (4, 14), 0.42, 0.27),
]  # fmt: skip

CHAPTER = {
    "name": "Table 8.1",
    "thread": {"lead_angle": "5.57 deg", "pitch_diameter": "10.36 mm"},
    "screw": {"inertia": "3.12e-6 kg*m^2"},
    "coupling": {"stiffness": "1 N*m/rad"},
    "load": {"mass": "1 kg", "force": "-50 N"},
    "operation": {"speed": "40 rad/s", "direction": "out"},
    "friction": {"coefficient": 0.218},
    "damping": {"rotational": "2e-4 N*m*s/rad"},
}


def sheet(**changes) -> Sheet:
    """The chapter's drive with parts replaced."""
    return Sheet.of({**CHAPTER, **changes})


def values_of(given: Sheet) -> dict:
    """Its quantities at the middle values."""
    return {key: float(value) for key, value in sheets.quantities(given, sheets.nominal_draw(given)).items()}


def rows(table: dict):
    """Lead and diameter [mm] and efficiency [per cent] of a table."""
    for lead, row in table.items():
        yield from ((lead, d, eta) for d, eta in zip((6, 10, 12, 16), row, strict=True) if eta is not None)


@pytest.mark.parametrize(("table", "low", "high"), [(COATED, 0.069, 0.085), (UNCOATED, 0.092, 0.123)])
def test_friction_follows_from_published_efficiencies(table, low, high):
    """μ from each entry of PBC's table, up to the rounding of the entry to whole per cent, and back to the entry."""
    for lead, diameter, eta in rows(table):
        angle = math.atan(lead / (math.pi * diameter))
        found = coefficient_from_efficiency(eta / 100, angle)
        ends = [coefficient_from_efficiency((eta + part) / 100, angle) for part in (0.5, -0.5)]
        if (lead, diameter) in [(2, 10), (1, 16), (10, 6)]:
            assert low - 0.0005 <= found <= high + 0.0005
        assert ends[0] < high + 0.01
        assert ends[1] > low - 0.02
        assert round(100 * lifting_efficiency(found, angle)) == eta


def test_published_efficiencies_follow_from_friction():
    """One coefficient for each coating gives each row of the three screws within the spread of the table's friction."""
    for table, low, high in ((COATED, 0.069, 0.085), (UNCOATED, 0.092, 0.123)):
        for lead, diameter in ((2, 10), (1, 16), (10, 6)):
            eta = dict(((lead, d), e) for lead, d, e in rows(table))[lead, diameter]
            angle = math.atan(lead / (math.pi * diameter))
            best, least = (100 * lifting_efficiency(mu, angle) for mu in (low, high))
            assert least - 0.5 <= eta <= best + 0.5


@pytest.mark.parametrize(("name", "angle", "at_01", "at_02"), TRAPEZOIDAL)
def test_trapezoidal_threads_have_the_published_lead_angle_and_efficiency(name, angle, at_01, at_02):
    """The published efficiencies leave the flank angle out; the lead angle is printed to a minute."""
    size = thread_size(name)
    lead_angle = math.atan(size.lead / (math.pi * size.pitch_diameter))
    assert math.degrees(lead_angle) == pytest.approx(angle[0] + angle[1] / 60, abs=1 / 60)  # some are cut off
    for coefficient, eta in ((0.1, at_01), (0.2, at_02)):
        assert lifting_efficiency(coefficient, lead_angle) == pytest.approx(eta, abs=0.0051)


def test_the_rule_of_a_third_is_a_friction_of_0106():
    """Lead < diameter / 3 is self-locking exactly for μ > 1 / (3 π)."""
    angle = math.atan(1 / (3 * math.pi))
    assert lowering_efficiency(0.1062, angle) < 0 < lowering_efficiency(0.1060, angle)


def test_a_flank_angle_raises_friction_as_in_the_force_balance():
    """Against the balance of forces on a flank, with its normal vector from a cross product."""
    lead_angle, half_angle, mu = 0.12, math.radians(15), 0.17
    along = np.array([0.0, math.cos(lead_angle), math.sin(lead_angle)])  # radial, around, axial
    radial = np.array([math.cos(half_angle), 0.0, math.sin(half_angle)])
    normal = np.cross(along, radial)
    normal *= math.copysign(1, normal[2]) / np.linalg.norm(normal)
    force = normal - mu * along  # of the screw on the nut's flank when lifting
    eta = math.tan(lead_angle) * force[2] / -force[1]
    assert lifting_efficiency(square_coefficient(mu, lead_angle, half_angle), lead_angle) == pytest.approx(
        eta, rel=1e-14
    )


def test_the_chapters_drive_has_the_thresholds_of_the_figures():
    """m_cr and the onset, by margins; stick and detach force, as lines of the chart."""
    given = sheet(
        load={"mass": "1 kg", "force": "-40 N"}, damping={"rotational": "2e-4 N*m*s/rad", "translational": "1000 N*s/m"}
    )
    found = margins(given, values_of(given))
    of = {name: {row.quantity: row for row in table} for name, table in found.items()}
    screw = RigidParameters.of({"mass": 1.0, "translation_damping": 1e3, "axial_force": 40.0})
    assert of["kinematic_constraint"]["mass"].value == pytest.approx(critical_mass(screw), rel=1e-12)
    assert of["negative_damping"]["force"].value == pytest.approx(-onset_force(screw), rel=1e-12)
    chart = charts(given, values_of(given))[0]
    for label, force in (("standstill", stick_force(screw)), ("lose contact", detach_force(screw))):
        line = next(line for name, line in chart.boundaries.items() if label in name)
        lead = float(given.thread.lead_angle.nominal)
        turning = chart.speed / (0.5 * 0.01036 * math.tan(lead))
        assert np.allclose(line, -force * turning / 40.0, rtol=1e-12)


@pytest.mark.parametrize(
    ("mass", "translational", "force", "occurring"),
    [
        (1, 1000, -40, {"negative_damping"}),
        (1, 1000, -18, set()),
        (10, 0, -50, set()),
        (11, 0, -50, {"kinematic_constraint"}),
        (11, 0, 50, set()),
    ],
)
def test_the_chapters_drive_has_the_verdicts_of_the_figures(mass, translational, force, occurring):
    """Figs 8.6, 8.9 and 8.14, by both ways of deciding."""
    given = sheet(
        load={"mass": f"{mass} kg", "force": f"{force} N"},
        damping={"rotational": "2e-4 N*m*s/rad", "translational": f"{translational} N*s/m"},
    )
    values = values_of(given)
    found = worst(given, values)
    assert {name for name, one in found.items() if one.reserve[0] < 0 and name != "push_needed"} == occurring
    for corner in corners(given, values):
        assert {name for name, occurs in certain(given, values, *corner).items() if occurs} == occurring
    assert (found["push_needed"].reserve[0] < 0) == (mass == 11 and force > 0)


def random_sheet(seed: int, support: bool = False, contact: bool = False) -> Sheet:
    """A drive drawn from wide ranges."""
    rng = np.random.default_rng(seed)

    def log(low: float, high: float) -> float:
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    angle = log(0.5, 45)
    more = {}
    if support:
        more["support"] = {"stiffness": f"{log(1e3, 1e8)} N/m", "damping": f"{log(1e-2, 1e5)} N*s/m"}
    if contact:
        more["contact"] = {"stiffness": f"{log(1e3, 1e8)} N/m", "damping": f"{log(1e-2, 1e5)} N*s/m"}
    return Sheet.of(
        {
            "name": "random",
            "thread": {"lead_angle": f"{angle} deg", "pitch_diameter": f"{log(2, 100)} mm"},
            "screw": {"inertia": f"{log(1e-9, 10)} kg*m^2", "mass": f"{log(1e-2, 1e3)} kg"},
            "coupling": {"stiffness": f"{log(1e-3, 1e6)} N*m/rad"},
            "load": {"mass": f"{log(1e-2, 1e4)} kg", "force": f"{rng.choice((-1, 1)) * log(1e-3, 1e6)} N"},
            "operation": {"speed": f"{log(1e-2, 1e4)} rad/s"},
            "friction": {"coefficient": min(log(0.02, 0.9), 0.99 / math.tan(math.radians(angle)))},
            "damping": {"rotational": f"{log(1e-9, 100)} N*m*s/rad", "translational": f"{log(1e-4, 1e6)} N*s/m"},
            **more,
        }
    )


@pytest.mark.parametrize("part", ["rigid", "support", "contact", "support and contact"])
def test_fast_verdicts_agree_with_certain_ones(part):
    """Reserves in double precision against exact signs, for random drives; but where the reserve is rounding."""
    occurring = 0
    for seed in range(30 if "and" in part else 100):
        given = random_sheet(seed, support="support" in part, contact="contact" in part)
        values = values_of(given)
        for corner in corners(given, values):
            exact, found = certain(given, values, *corner), reserves(given, values, *corner)
            for name, occurs in exact.items():
                if abs(found[name]) > 1e-9:
                    assert occurs == (found[name] < 0), (seed, corner, name)
                    occurring += occurs
    assert occurring > 3


def test_margins_of_a_supported_drive_are_the_certain_boundaries():
    """The margin in mass and damping of mode coupling against the isolated roots of :func:`stable_set`."""
    seen = 0
    for seed in range(12):
        given = slide(seed)
        values = values_of(given)
        corner = corners(given, values)[0]
        assert reserves(given, values, *corner)["law"] > 0
        table = {row.quantity: row for row in margins(given, values)["mode_coupling"]}
        drive = drive_of(given, values, *corner, "support")
        for key, quantity in (("mass", "mass"), ("axial_support_damping", "support_damping")):
            value = table[quantity].value
            if value is None:
                continue
            at = sheets.quantities(given, sheets.nominal_draw(given)) | {quantity: value}
            if abs(worst(given, at)["negative_damping"].reserve[0]) < 1e-9:
                continue  # there the cause changes its name, not the stability
            ends = [float(x) for pair in stable_set(drive, key).intervals for x in pair]
            assert min(abs(value / end - 1) for end in ends if end > 0) < 1e-9, (seed, quantity)
            seen += 1
    assert seen > 8


def slide(seed: int) -> Sheet:
    """A drive near the machine slide of the examples, which mode coupling can reach."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(0.6, 1.6, 7)
    return Sheet.of(
        {
            "name": "slide",
            "thread": {"size": "Tr 20x4"},
            "screw": {"length": f"{0.6 * size[0]} m", "diameter": "18 mm"},
            "coupling": {"stiffness": f"{140 * size[1]} N*m/rad"},
            "load": {"mass": f"{120 * size[2]} kg", "force": "-500 N"},
            "operation": {"speed": "10 mm/s", "direction": "out"},
            "friction": {"coefficient": 0.15 * size[3]},
            "damping": {"rotational": f"{1e-3 * size[4]} N*m*s/rad"},
            "support": {"stiffness": f"{5e7 * size[5]} N/m", "damping": f"{2000 * size[6]} N*s/m"},
        }
    )


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"friction": {"coefficient": 0.218, "slope": "-0.05 s/m"}},
        {"friction": {"coefficient": 0.218, "slope": "0.05 s/m"}},
        {"support": {"stiffness": "1e5 N/m", "damping": "3 N*s/m"}},
        {"contact": {"stiffness": "1e6 N/m", "damping": "30 N*s/m"}},
    ],
)
def test_no_point_of_the_window_is_worse_than_its_corners(more):
    """Against random points of the window, for random masses and dampings."""
    rng = np.random.default_rng(4)
    for _ in range(15):
        given = sheet(
            load={
                "mass": f"{rng.uniform(0.5, 14)} kg",
                "force": [f"{rng.uniform(-80, -1)} N", f"{rng.uniform(1, 80)} N"],
                "orientation": f"{rng.uniform(-90, 90)} deg",
            },
            operation={"speed": [f"{rng.uniform(1, 20)} rad/s", f"{rng.uniform(25, 90)} rad/s"]},
            damping={"rotational": "2e-4 N*m*s/rad", "translational": f"{rng.uniform(0, 1500)} N*s/m"},
            screw={"inertia": "3.12e-6 kg*m^2", "mass": "2 kg"},
            **more,
        )
        values = values_of(given)
        found = worst(given, values)
        speed = rng.uniform(values["speed_low"], values["speed_high"], 3000)
        force = rng.uniform(values["force_low"], values["force_high"], 3000)
        for direction in (1, -1):
            inside = reserves(given, values, direction, speed, force)
            for name, one in found.items():
                assert one.reserve[0] <= inside[name].min() + 1e-9, name


@pytest.mark.parametrize(("force", "verdict"), [(50, "steady"), (10, "steady until pushed")])
def test_a_push_starts_vibration_in_fig_8_14b_and_not_in_a(force, verdict):
    """R = −50 N is globally attracting, R = −10 N is not: the push that is survived leads back, a larger one not."""
    given = sheet(load={"mass": "11 kg", "force": f"{force} N"}, damping={"rotational": "1e-3 N*m*s/rad"})
    found = assess(given, samples=64)
    assert found.verdict == verdict
    if verdict == "steady":
        return
    values = values_of(given)
    corner = found.mechanisms["push_needed"].corner
    push, _ = found.nominal.push
    drive = drive_of(given, values, *corner)
    ends = {
        (sign, part): steady_state(rigid_automaton(drive), [0.0, sign * part * push]).label
        for sign in (1, -1)
        for part in (0.999, 1.001)
    }
    assert ends[1, 0.999] == ends[-1, 0.999] == Attractor.STEADY_SLIDING
    assert {ends[1, 1.001], ends[-1, 1.001]} & {Attractor.SPRAG_SLIP_CYCLE}


def test_derivatives_are_those_of_the_closed_forms():
    """Complex steps against the closed derivatives of the kinematic reserve, and all others against differences."""
    given = sheet(
        load={"mass": "6 kg", "force": "-40 N"}, damping={"rotational": "2e-4 N*m*s/rad", "translational": "800 N*s/m"}
    )
    values = values_of(given)
    found = sensitivities(given, values)
    c = coefficients(drive_of(given, values, *corners(given, values)[0]))
    inertia = 3.12e-6
    turned = inertia - float(c.gamma[1])
    assert found["kinematic_constraint"]["mass"] == pytest.approx(
        -2 * inertia * turned / (inertia + turned) ** 2, rel=1e-12
    )
    assert found["kinematic_constraint"]["inertia"] == pytest.approx(
        2 * inertia * turned / (inertia + turned) ** 2, rel=1e-12
    )
    supported = random_sheet(7, support=True)
    for one in (given, supported):
        base = values_of(one)
        table = sensitivities(one, base)
        for quantity in ("mass", "friction", "lead", "pitch_diameter", "rotational_damping"):
            step = 1e-6
            ends = [worst(one, {**base, quantity: base[quantity] * (1 + sign * step)}) for sign in (1, -1)]
            for name, row in table.items():
                difference = float((ends[0][name].reserve[0] - ends[1][name].reserve[0]) / (2 * step))
                assert row[quantity] == pytest.approx(difference, rel=1e-4, abs=1e-7), (name, quantity)


def test_slope_damping_against_eigenvalues_with_forty_digits():
    """Newton's laws with μ(v), linearised by differentiation in 40 digits, against Γ_0, C_0 + S and k."""
    rng = np.random.default_rng(5)
    for _ in range(25):
        drive = RigidParameters(
            pitch_radius=rng.uniform(2e-3, 3e-2), lead_angle=rng.uniform(0.02, 0.5),
            screw_inertia=10 ** rng.uniform(-7, -3),
            coupling_stiffness=10 ** rng.uniform(-1, 3), support_damping=10 ** rng.uniform(-5, -1),
            friction_coefficient=rng.uniform(0.02, 0.6), input_speed=rng.choice((-1, 1)) * rng.uniform(1, 100),
            mass=rng.uniform(0.1, 50), translation_damping=10 ** rng.uniform(-1, 3),
            axial_force=rng.choice((-1, 1)) * rng.uniform(1, 500),
        )  # fmt: skip
        slope = rng.choice((-1, 1)) * 10 ** rng.uniform(-2, 1)
        c = coefficients(drive)
        law, carried = c.steady_law, abs(float(c.net_force))
        more = damping_by_slope(slope, carried, drive.friction_coefficient, drive.pitch_radius, drive.lead_angle, law)
        found = eigenvalues(float(c.gamma[law]), float(c.damping[law]) + more, drive.coupling_stiffness)
        expected = _eigenvalues_in_many_digits(drive, slope, law)
        size = max(abs(z) for z in expected)
        for a, b in zip(sorted(found, key=lambda z: (z.real, z.imag)), expected, strict=True):
            assert abs(a - b) < 1e-9 * size


def _eigenvalues_in_many_digits(drive: RigidParameters, slope: float, law: int) -> list[complex]:
    """Eigenvalues of the screw's motion about steady sliding, from the accelerations that Newton's laws give."""
    with mpmath.workdps(40):
        r, lam, inertia, k, c, mu, omega, m, c_x, push = (
            mpmath.mpf(float(getattr(drive, key)))
            for key in (
                "pitch_radius", "lead_angle", "screw_inertia", "coupling_stiffness", "support_damping",
                "friction_coefficient", "input_speed", "mass", "translation_damping", "axial_force",
            )
        )  # fmt: skip
        tan, sin, cos = mpmath.tan(lam), mpmath.sin(lam), mpmath.cos(lam)

        def acceleration(z, rate):
            friction = law * (mu + slope * r * (abs(rate) - abs(omega)) / cos)
            torque = -k * z - c * rate
            # I a = T − r N (μ_s cos λ − sin λ),   m r tan λ a = R − c_x r tan λ θ′ − N (cos λ + μ_s sin λ)
            matrix = mpmath.matrix([[inertia, r * (friction * cos - sin)], [m * r * tan, cos + friction * sin]])
            return mpmath.lu_solve(matrix, mpmath.matrix([torque, push - c_x * r * tan * rate]))[0]

        steady = mpmath.findroot(lambda z: acceleration(z, omega), mpmath.mpf(0))
        by_angle = mpmath.diff(lambda z: acceleration(z, omega), steady)
        by_rate = mpmath.diff(lambda w: acceleration(steady, w), omega)
        root = mpmath.sqrt(by_rate**2 / 4 + by_angle)
        pair = [complex(by_rate / 2 - root), complex(by_rate / 2 + root)]
    return sorted(pair, key=lambda z: (z.real, z.imag))


def test_friction_that_falls_with_speed_sets_in_where_its_damping_is_spent():
    """At the margin of the slope the sum of the dampings vanishes, on lifting as well."""
    given = sheet(load={"mass": "1 kg", "force": "60 N"}, friction={"coefficient": 0.218, "slope": "-0.01 s/m"})
    values = values_of(given)
    table = {row.quantity: row for row in margins(given, values)["falling_friction"]}
    drive = drive_of(given, values, *corners(given, values)[0])
    angle = drive.lead_angle
    critical = -drive.support_damping / damping_by_slope(1.0, 60.0, 0.218, drive.pitch_radius, angle, -1)
    assert table["friction_slope"].value == pytest.approx(critical, rel=1e-10)


def test_a_curve_counts_by_its_value_and_slope_at_the_running_speed():
    """A curve of two points is the same as the coefficient and slope at the speed of the operating point."""
    angle = math.radians(5.57)
    sliding = 5.18e-3 * 40 / math.cos(angle)
    slope = (0.15 - 0.25) / 0.5
    curved = sheet(friction={"curve": [["0 m/s", 0.25], ["0.5 m/s", 0.15]]})
    plain = sheet(friction={"coefficient": 0.25 + slope * sliding, "slope": f"{slope} s/m"})
    one, other = (worst(given, values_of(given)) for given in (curved, plain))
    for name in one:
        assert one[name].reserve[0] == pytest.approx(other[name].reserve[0], rel=1e-12)


KINEMATIC = {
    "load": {"mass": {"low": "6 kg", "mode": "9 kg", "high": "16 kg"}, "force": "-50 N"},
    "friction": {"coefficient": {"mean": 0.218, "std": 0.015}},
}
FED = {
    "load": {"mass": "1 kg", "force": ["-40 N", "10 N"]},
    "damping": {
        "rotational": {"median": "2e-4 N*m*s/rad", "factor": 1.5},
        "translational": {"median": "600 N*s/m", "factor": 1.4},
    },
}


def simulated_share(given: Sheet, count: int, seed: int) -> float:
    """Share of independently drawn drives that, simulated from near steady sliding, end in anything else."""
    rng = np.random.default_rng(seed)
    draw = draw_of(given, rng.random((len(sheets.random_entries(given)), count)))
    hits = 0
    for k in range(count):
        one = {key: float(np.ravel(value)[k] if np.size(value) > 1 else value) for key, value in draw.items()}
        values = {key: float(value) for key, value in sheets.quantities(given, one).items()}
        ends = []
        for corner in corners(given, values):
            drive = drive_of(given, values, *corner)
            ends.append(steady_state(rigid_automaton(drive), [0.0, 1e-6 * drive.input_speed]).label)
        hits += any(end != Attractor.STEADY_SLIDING for end in ends)
    return hits / count


def shares(changes: dict, name: str, count: int) -> tuple[float, tuple[float, float]]:
    """Share of simulated drives that vibrate, and the interval of the samples, widened by the scatter of few drives."""
    given = sheet(**changes)
    found = study(given, 8192, 3).probability[name]
    share = simulated_share(given, count, 11)
    scatter = 3 * math.sqrt(max(share * (1 - share), 1 / count) / count) if count < 100_000 else 0.0
    assert 0.05 < found.value < 0.95
    return share, (found.interval[0] - scatter, found.interval[1] + scatter)


@pytest.mark.parametrize(("changes", "name"), [(KINEMATIC, "kinematic_constraint"), (FED, "negative_damping")])
def test_probabilities_against_simulated_drives(changes, name):
    """A few hundred drives, each simulated by the engine."""
    share, (low, high) = shares(changes, name, 300)
    assert low <= share <= high


@pytest.mark.long
@pytest.mark.parametrize(("changes", "name"), [(KINEMATIC, "kinematic_constraint"), (FED, "negative_damping")])
def test_probabilities_against_a_hundred_thousand_simulated_drives(changes, name):
    """10⁵ drives: their share lies within the confidence interval itself."""
    share, (low, high) = shares(changes, name, 100_000)
    assert low <= share <= high


def test_samples_do_not_depend_on_threads_and_are_taken_up_again(tmp_path):
    """The same counts with one thread, with two, and from blocks that were kept."""
    given = sheet(**KINEMATIC)
    plain = study(given, 16384, 5)
    kept = study(given, 16384, 5, workers=2, folder=tmp_path)
    blocks = sorted(tmp_path.glob("*.json"))
    assert len(blocks) == 4
    blocks[1].write_text("{", encoding="utf-8")  # cut off
    again = study(given, 16384, 5, folder=tmp_path)
    for name, one in plain.probability.items():
        for other in (kept, again):
            assert one.value == other.probability[name].value
            assert (one.counts == other.probability[name].counts).all()
    assert plain.total == kept.total == again.total


def test_sobol_indices_of_a_reserve_that_two_entries_share():
    """Only mass and friction vary, nearly without interaction: first orders sum to about one."""
    found = study(sheet(**KINEMATIC), 4096, 2)
    first, total = found.first_order["kinematic_constraint"], found.total["kinematic_constraint"]
    assert set(first) == {"load.mass", "friction.coefficient"}
    assert sum(first.values()) == pytest.approx(1.0, abs=0.05)
    assert all(total[key] >= first[key] - 0.03 for key in first)


def test_the_worst_case_is_at_least_as_bad_as_every_sample():
    """The search ends below all samples, at the heaviest load with the highest friction."""
    given = sheet(**KINEMATIC)
    found = assess(given, samples=1024)
    reserve = reserves(given, found.worst.values, *found.worst.corner)["kinematic_constraint"]
    rng = np.random.default_rng(8)
    shares = rng.random((2, 4000))
    assert reserve <= evaluated(given, shares)["kinematic_constraint"].reserve.min() + 1e-12
    assert found.worst.entries["load.mass"] == pytest.approx(16, rel=1e-3)
    assert found.worst.vibration.attractor == "sprag slip cycle"
