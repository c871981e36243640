"""The numbers that the chapter prints, each within its tolerance of the print, and thresholds by name.

One test marked ``threshold`` for each printed number. Tolerances of the print are those of its claim in
``config/chapter.yaml``, half a unit of the last digit where two digits are printed. The reference values are those of
``references/threshold_digits.py``, with 40 digits and without the library: closed forms for m_cr (eq. 8.20), μ_kc (eqs
8.27, 8.28), onset (eqs 8.15, 8.19) and detachment; for the first touch of rest the fixed point of the return map of
slip without rest.
"""

import json
import math
from functools import partial

import pytest
from mpmath import mp, mpf
from references.drives import NEGATIVE_DAMPING, nut_drive, support_drive, threads_drive
from references.rigid_digits import GUARD_DIGITS, RigidTrueDrive
from references.sizes import sizes
from references.threshold_digits import gap, jam, root

import lsvib
from lsvib import Drive
from lsvib.drives import chapter
from lsvib.drives.automata import automaton_of
from lsvib.drives.mechanics import coefficients
from lsvib.drives.model import seated_state
from lsvib.dynamics.boundary import Boundary, basin
from lsvib.stability.force_thresholds import threshold_force
from lsvib.stability.threshold import solve_threshold
from lsvib.systems.attractor import Attractor, orbit_extremes, steady_state

DIGITS = 40


@pytest.fixture(autouse=True)
def _forty_digits():
    with mp.workdps(DIGITS + GUARD_DIGITS):
        yield


def exact(drive: Drive, **changes) -> RigidTrueDrive:
    return RigidTrueDrive({**dict(drive), **changes}, DIGITS)


# As printed; and what vanishes there, with a rate [rad/s] or a time [s] near which the root of its motion lies.
PRINTED = {
    "critical_mass": (10.10, partial(gap, "kinematic_constraint")),  # kg, Sect. 8.6.1
    "critical_friction": (0.285, partial(jam, "support")),  # Fig. 8.15
    "onset_force": (20.0, partial(gap, "onset")),  # N, Fig. 8.6, as the next two
    "stick_force": (34.5, partial(gap, "stick", hint=(2.0,))),
    "detach_force": (46.5, partial(gap, "detach", hint=(4e-3,))),
}
ASKED = {
    "critical_mass": (Drive(), "kinematic_constraint", "mass"),
    "critical_friction": (support_drive(mass=15.0), "kinematic_constraint", "friction_coefficient"),
}
# Sect. 8.5.1, by the law: value, unit of its last digit.
DAMPINGS = {-1: (1.0e-3, 1e-4), 1: (-1.1e-4, 1e-5)}  # N m s/rad
INERTIAS = {-1: (9.9e-6, 1e-7), 1: (6.5e-7, 1e-8)}  # kg m²
PEAK_FORCE = 320e3  # N, Fig. 8.10b


@pytest.mark.threshold
@pytest.mark.parametrize("name", PRINTED)
def test_threshold_is_the_chapters_and_exact(name):
    """m_cr ≈ 10.10 kg (Sect. 8.6.1), μ_kc ≈ 0.285 (Fig. 8.15), R = 20, 34.5 and 46.5 N (Sect. 8.5.1, Fig. 8.6)."""
    printed, vanishes = PRINTED[name]
    drive, threshold, unknown = ASKED.get(name, (NEGATIVE_DAMPING, name.removesuffix("_force"), "axial_force"))
    found = solve_threshold(drive, threshold, unknown)
    assert abs(found.value - printed) <= chapter.claims()[chapter.THRESHOLDS[name]].tolerance * printed
    low, high = found.enclosure
    assert high <= math.nextafter(low, math.inf)
    assert low <= root(lambda x: vanishes({**dict(drive), unknown: x}), printed) <= high


def test_what_the_checks_take_for_printed_is_what_stands_here():
    claims = chapter.claims()
    assert {k: claims[id].value for k, id in chapter.THRESHOLDS.items()} == {k: v for k, (v, _) in PRINTED.items()}
    assert claims["fig8_10.peak_force"].value == PEAK_FORCE
    for kind, table in (("damping", DAMPINGS), ("inertia", INERTIAS)):
        for law, (value, digit) in table.items():
            claim = claims[f"fig8_06.{kind}_{'plus' if law > 0 else 'minus'}"]
            assert claim.value == value
            assert claim.tolerance == pytest.approx(0.5 * digit / abs(value), rel=1e-12)


@pytest.mark.threshold
@pytest.mark.parametrize("law", [1, -1])
def test_effective_damping_and_inertia(law):
    """Sect. 8.5.1: C and Γ of both laws, Γ those of m = 8 kg; the stated m = 1 kg has others."""
    heavy = NEGATIVE_DAMPING.replace(mass=8.0)
    (printed, digit), (of_mass, last) = DAMPINGS[law], INERTIAS[law]
    found = coefficients(heavy).damping[law]
    gamma, stated = (coefficients(d).gamma[law] for d in (heavy, NEGATIVE_DAMPING))
    assert abs(float(found) - printed) <= 0.5 * digit
    assert abs(float(gamma) - of_mass) <= 0.5 * last < abs(float(stated) - of_mass)
    assert abs(mpf(float(found)) / exact(heavy).C(law) - 1) <= 1e-15
    assert abs(mpf(float(gamma)) / exact(heavy).Gamma(law) - 1) <= 1e-15


@pytest.mark.threshold
@pytest.mark.parametrize("force", [10.0, 50.0, 200.0])
def test_peak_of_the_contact_force(force):
    """Fig. 8.10b, m = 11 kg, k_c = c_c = 1e8: 320 kN, read from an axis; R, which is not stated, hardly matters."""
    drive = threads_drive(mass=11.0, axial_force=force)
    automaton = automaton_of(drive)
    cycle = steady_state(automaton, seated_state(drive, 0.003, 0.0))
    assert cycle.label == Attractor.SPRAG_SLIP_CYCLE
    assert orbit_extremes(cycle.orbit, automaton.observables["normal_force"])[1] == pytest.approx(PEAK_FORCE, rel=0.02)


RESISTED = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18)


@pytest.mark.parametrize("sense", [1, -1])
def test_forces_are_those_of_the_functions(sense):
    for drive, names in ((NEGATIVE_DAMPING, ("onset", "stick", "detach")), (RESISTED, ("global_stability",))):
        drive = drive.replace(input_speed=40.0 * sense, axial_force=sense * drive.axial_force)
        for name in names:
            found = drive.threshold(name)
            assert (found.unknown, found.unit, len(found.solutions)) == ("axial_force", "N", 1)
            expected = threshold_force(drive, name)
            assert abs(found.value - expected) <= math.ulp(expected)
            low, high = found.enclosure
            assert low <= found.value <= high <= math.nextafter(low, math.inf)


def test_solving_for_a_parameter_gives_back_the_drive():
    """At the force of the threshold every parameter on which it depends is the solution for that parameter."""
    for drive, name, unknowns in (
        (NEGATIVE_DAMPING, "detach", ("mass", "lead_angle")),
        (RESISTED, "global_stability", ("coupling_stiffness", "support_damping")),
    ):
        force = drive.threshold(name)
        there = drive.replace(axial_force=force.value)
        for unknown in unknowns:
            own, back = getattr(drive, unknown), there.threshold(name, unknown)
            nearest = min(back.solutions, key=lambda solution: abs(solution.value - own))
            slope = nearest.derivatives["axial_force"].value
            assert abs(nearest.value - own) <= 2 * abs(slope) * math.ulp(force.value) + math.ulp(own)
            assert slope * force.derivatives[unknown].value == pytest.approx(1, rel=1e-9)


def test_both_sides_of_the_fold_and_the_birth_of_the_repelling_cycle():
    """Between fold and birth a cycle bounds the basin, before the fold nothing does, beyond the birth slip does."""
    fold, birth = RESISTED.threshold("global_stability").value, -18.336055945331047  # where its slip touches Q = 0
    gap = birth - fold
    # Next to the fold motions linger, next to the birth they do not.
    forces = fold - 0.2 * gap, fold + 0.2 * gap, birth - 1e-6 * gap, birth + 1e-6 * gap
    kinds = [basin(RESISTED.replace(axial_force=force)).boundary for force in forces]
    assert kinds[:3] == [Boundary.NONE, Boundary.CYCLE, Boundary.CYCLE]
    assert kinds[3] in (Boundary.TOUCHING_SLIP, Boundary.TOUCHING_MOTION)


TOUCHING = nut_drive(
    support_damping=0, nut_damping=0, translation_damping=100, axial_force=50, screw_inertia=3e-6, nut_inertia=2e-6,
    nut_stiffness=0.5, friction_coefficient=0.05,
)  # fmt: skip


@pytest.mark.parametrize("force", [50, -50])
@pytest.mark.parametrize("drive", [TOUCHING, support_drive(support_damping=0, translation_damping=100)])
def test_what_only_touches_the_axis_is_no_threshold(drive, force):
    """At k / I = k_2 / I_2 (k_1 / m_1) an undamped pair stands on the axis, and it decays on both sides."""
    drive = drive.replace(axial_force=force, friction_coefficient=0.05)
    second = ("nut_stiffness", "nut_inertia") if drive.parts == ("nut",) else ("support_stiffness", "screw_mass")
    place = drive.coupling_stiffness * getattr(drive, second[1]) / getattr(drive, second[0])
    for inertia in (0.99 * place, 1.01 * place):
        assert drive.replace(screw_inertia=inertia).stability().kind == "stable"
    for unknown in ("screw_inertia", *second):
        with pytest.raises(lsvib.NoThreshold, match="in the allowed range"):
            drive.threshold("flutter", unknown)


def test_two_pairs_that_cross_at_once_are_no_flutter():
    """At ξ_0 = 0 both pairs of the nut's drive without dampings of their own stand on the axis; it is an onset."""
    with pytest.raises(lsvib.NoThreshold, match="in the allowed range"):
        TOUCHING.threshold("flutter", "friction_coefficient")
    assert TOUCHING.threshold("onset", "friction_coefficient").value == math.tan(TOUCHING.lead_angle)


FADING = {"stribeck_rise": 0.05, "stribeck_speed": 0.02, "mass": 0.5, "axial_force": 80, "translation_damping": 100}
UNDAMPED = lsvib.Drive(**FADING, support_damping=0, nut_inertia=1e-6, nut_stiffness=2, nut_damping=0)
ALL = lsvib.Drive(**FADING, **{name: x for part in chapter.PARTS.values() for name, x in part.items()})


@pytest.mark.parametrize("case", sizes([(UNDAMPED, "lead_angle"), (UNDAMPED, "input_speed")], [(ALL, "input_speed")]))
def test_onset_where_determinants_have_double_roots_and_of_ten_states(case):
    """Under a law: a nut whose odd coefficients vanish together, and the determinants of all parts at once."""
    drive, unknown = case
    for solution in drive.threshold("onset", unknown).solutions:
        sides = [drive.replace(**{unknown: solution.value * factor}) for factor in (1 - 1e-9, 1 + 1e-9)]
        assert {side.stability().stable for side in sides} == {True, False}


def test_a_result_is_plain_numbers():
    found = lsvib.Drive(mass=11).threshold("kinematic_constraint", "lead_angle")
    values = json.loads(json.dumps(found.to_json(), allow_nan=False))["solutions"]
    assert values[0]["value"] < values[1]["value"]
    assert values[0]["derivatives"]["mass"]["unit"] == "rad kg-1"
