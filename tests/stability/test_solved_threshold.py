"""Thresholds by name: the same as the functions of single thresholds, as motions say, and refused in one sentence."""

import json
import math

import pytest
from references.command_line import complaint
from references.parts import nut_drive, support_drive, threads_drive

import lsvib
from lsvib.basins.boundary import Boundary, basin
from lsvib.models.rigid import MotionMode
from lsvib.stability import boundaries
from lsvib.stability.conditions import critical_value
from lsvib.stability.force_thresholds import threshold_force

NEGATIVE = lsvib.Drive(mass=1, translation_damping=1e3)
PARADOX = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18)


@pytest.mark.parametrize("sense", [1, -1])
def test_forces_are_those_of_the_functions(sense):
    for drive, names in ((NEGATIVE, ("onset", "stick", "detach")), (PARADOX, ("global_stability",))):
        drive = drive.replace(input_speed=40.0 * sense, axial_force=sense * drive.axial_force)
        for name in names:
            found = drive.threshold(name)
            assert found.unknown == "axial_force"
            assert found.unit == "N"
            assert not found.several
            expected = threshold_force(drive, name)
            assert abs(found.value - expected) <= math.ulp(expected)
            assert (
                found.enclosure[0] <= found.value <= found.enclosure[1] <= math.nextafter(found.enclosure[0], math.inf)
            )


def test_critical_values_are_those_of_the_closed_forms():
    drive, unknown = lsvib.Drive(mass=15), "friction_coefficient"
    assert drive.threshold("kinematic_constraint").value == critical_value(drive, "mass")
    assert drive.threshold("kinematic_constraint", unknown).value == critical_value(drive, unknown)
    assert drive.thresholds(unknown)["kinematic_constraint"].value == critical_value(drive, unknown)
    support = support_drive(mass=15)
    assert support.threshold("kinematic_constraint", unknown).value == critical_value(support, unknown)


@pytest.mark.parametrize(
    ("drive", "unknown"),
    [
        (threads_drive(contact_damping=5e4), "mass"),
        (threads_drive(mass=9), "contact_damping"),
        (support_drive(mass=15, axial_support_damping=10), "friction_coefficient"),
        (support_drive(mass=15, axial_support_damping=10), "mass"),
        (nut_drive(translation_damping=100), "mass"),
        (nut_drive(translation_damping=100), "nut_damping"),
    ],
)
def test_onsets_are_the_ends_of_the_stable_intervals(drive, unknown):
    found = boundaries.stable_set(drive, unknown)
    ends = sorted({float(x) for pair in found.intervals for x in pair if 0 < x < found.limit})
    try:
        values = [solution.value for solution in drive.threshold("onset", unknown).solutions]
    except lsvib.NoThreshold:
        values = []
    assert ends == values


def test_solving_for_a_parameter_gives_back_the_drive():
    """At the force of the threshold every parameter on which it depends is the solution for that parameter."""
    for drive, name, unknowns in (
        (NEGATIVE, "detach", ("mass", "lead_angle")),
        (PARADOX, "fold", ("coupling_stiffness",)),
        (PARADOX, "global_stability", ("support_damping",)),
    ):
        force = drive.threshold(name)
        there = drive.replace(axial_force=force.value)
        for unknown in unknowns:
            own, back = getattr(drive, unknown), there.threshold(name, unknown)
            nearest = min(back.solutions, key=lambda solution: abs(solution.value - own))
            slope = nearest.derivatives["axial_force"].value
            assert abs(nearest.value - own) <= 2 * abs(slope) * math.ulp(force.value) + math.ulp(own)
            assert slope * force.derivatives[unknown].value == pytest.approx(1, rel=1e-9)


def test_both_sides_of_the_birth_and_the_fold_of_the_repelling_cycle():
    """Between fold and birth a cycle bounds the basin, before the fold nothing does, beyond the birth slip does."""
    fold, birth = PARADOX.threshold("fold").value, PARADOX.threshold("cycle_birth").value
    assert fold < birth
    gap = birth - fold
    # Next to the fold motions linger, next to the birth they do not.
    forces = fold - 0.2 * gap, fold + 0.2 * gap, birth - 1e-6 * gap, birth + 1e-6 * gap
    kinds = [basin(PARADOX.replace(axial_force=force)).boundary for force in forces]
    assert kinds[:3] == [Boundary.NONE, Boundary.CYCLE, Boundary.CYCLE]
    assert kinds[3] in (Boundary.TOUCHING_SLIP, Boundary.TOUCHING_MOTION)


def test_both_sides_of_the_loss_of_rest():
    """R = 100 N, m = 15 kg: with a little less damping the sprag–slip cycle rests, with a little more it does not."""
    drive = lsvib.Drive(mass=15, axial_force=100)
    damping = drive.threshold("rest_loss").value
    assert damping == pytest.approx(2.5264368463e-4, rel=1e-9)
    rests = []
    for factor in (1 - 1e-3, 1 + 1e-3):
        found = drive.replace(support_damping=factor * damping).steady_state({"u": 0.0, "w": -40.0})
        assert found.label == lsvib.Attractor.SPRAG_SLIP_CYCLE
        rests.append(MotionMode.REST in found.orbit.automaton.codes[found.orbit.arcs()[0]])
    assert rests == [True, False]


@pytest.mark.parametrize(
    ("drive", "arguments", "sentence"),
    [
        (NEGATIVE, ("sticking",), "threshold = 'sticking' is not one of those of this drive: even_speed, onset, "),
        (NEGATIVE, ("stick", "masss"), "unknown = 'masss' is not a parameter of this drive: "),
        (NEGATIVE, ("stick", 3), "unknown = 3 is not a parameter"),
        (
            NEGATIVE,
            ("kinematic_constraint", "axial_force"),
            "the threshold kinematic_constraint of this drive does not depend on",
        ),
        (
            NEGATIVE,
            ("kinematic_constraint", "lead_angle"),
            "no lead_angle in the allowed range 1e-06 <= lead_angle < 1.5708 is the",
        ),
        (NEGATIVE, ("fold",), "the drive is not in the Painlevé region"),
        (NEGATIVE, ("flutter",), "threshold = 'flutter' is not one of those of this drive"),
        (PARADOX.replace(support_damping=1e-3), ("fold",), "no axial_force is the threshold fold: next to -26.04"),
        (PARADOX.replace(support_damping=1e-3), ("cycle_birth",), "the cycle without rest would begin where"),
        (PARADOX, ("detach", "mass"), "no mass within 6 decades on both sides of the drive's own value is the"),
    ],
)
def test_refused_in_one_sentence(drive, arguments, sentence):
    assert complaint(drive.threshold, *arguments).startswith(sentence)


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


def test_a_result_is_plain_numbers():
    found = lsvib.Drive(mass=11).threshold("kinematic_constraint", "lead_angle")
    assert found.several
    values = json.loads(json.dumps(found.to_json(), allow_nan=False))["solutions"]
    assert values[0]["value"] < values[1]["value"]
    assert values[0]["derivatives"]["mass"]["unit"] == "rad kg-1"
    assert found.solutions[0].change({"mass": 2.0}) == {"mass": 2 * found.derivatives["mass"].value}
