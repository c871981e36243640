"""Branches of cycles: folds and kinks where the library knows the threshold from a formula with 50 digits."""

import json

import pytest
from references.command_line import complaint

import lsvib
from lsvib.datasets.cycles import branch_dataset, branch_json
from lsvib.stability.force_thresholds import threshold_force

NEAR_FOLD = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18.37)
SLIP = lsvib.Drive(mass=1, translation_damping=1e3, axial_force=25)


@pytest.mark.parametrize("damping", [2e-3, 5e-3])
def test_fold_is_the_threshold_of_global_stability(damping):
    """The attracting branch turns into the repelling one at the force that the closed form gives, to rounding."""
    drive = NEAR_FOLD.replace(support_damping=damping)
    threshold = threshold_force(drive, "global_stability")
    drive = drive.replace(axial_force=threshold * (1 - 3e-4))
    attracting, repelling = drive.cycles().cycles
    branch = drive.follow(attracting, "axial_force", (threshold * 1.01, threshold * (1 - 4e-4)))
    assert branch.folds == [pytest.approx(threshold, rel=1e-14)]
    sides = [point.cycle.attracting for point in branch.points]
    assert sides == sorted(sides)  # repelling ones, then attracting ones, one change between
    assert {True, False} == set(sides)
    assert max(point.cycle.residual for point in branch.points) < 1e-13
    back = drive.follow(repelling, "axial_force", (threshold * 1.01, threshold * (1 - 4e-4)))
    assert back.folds == [pytest.approx(branch.folds[0], rel=1e-14)]


@pytest.mark.slow
def test_amplitude_over_force_has_the_thresholds_of_figure_8_6():
    """From onset, where the cycle vanishes, over the first rest to the last contact reversal."""
    (cycle,) = SLIP.cycles().cycles
    branch = SLIP.follow(cycle, "axial_force", (20.0, 50.0))
    known = {name: threshold.value for name, threshold in SLIP.thresholds().items()}
    first, *changes, last = branch.changes
    assert (first.kind, first.what) == ("end", "it shrinks to nothing")
    assert first.value == pytest.approx(known["onset"], abs=1e-4)
    assert [change.kind for change in changes] == ["itinerary", "itinerary"]
    assert changes[0].value == pytest.approx(known["stick"], rel=1e-9)
    assert "stick into rest" in changes[0].what
    assert changes[1].value == pytest.approx(known["detach"], rel=1e-9)
    assert changes[1].what.startswith("loses contact reversal")
    assert (last.kind, last.value) == ("end", 50.0)
    assert not branch.folds


PULLED = {  # by a spring, as a drive with hardly any lead
    "pitch_radius": 1, "lead_angle": 1e-6, "mass": 1e-18, "axial_force": 1, "screw_inertia": 1, "coupling_stiffness": 2,
    "support_damping": 0.4, "friction_coefficient": 1.000002000002, "static_friction_coefficient": 1.500003250004875,
    "input_speed": 0.1,
}  # fmt: skip
STRIBECK = {  # a block whose friction is 2 + 4 exp(−10 v) + 0.2 v N, published
    "pitch_radius": 1, "lead_angle": 1e-6, "mass": 1e-18, "axial_force": 1000, "screw_inertia": 0.538,
    "friction_coefficient": 0.002, "stribeck_rise": 0.004, "stribeck_speed": 0.1, "friction_slope": 0.0002,
    "input_speed": 0.22, "coupling_stiffness": 6957, "support_damping": 5.746,
}  # fmt: skip
SEAT = {"friction": "powered_seat", "axial_force": 95}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "parameter", "spans", "end", "tolerance"),
    [
        (PULLED, "input_speed", [(0.02, 0.4), (0.09, 0.19)], 0.181127006942085, 1e-12),
        (STRIBECK, "input_speed", [(0.1, 0.4)], 0.27178904290785, 1e-8),  # the lead changes it by 3e-9
        (SEAT, "axial_force", [(60, 200)], 72.575, 1e-5),  # of three digits
    ],
)
def test_stick_slip_ends_where_its_slip_just_comes_to_rest(values, parameter, spans, end, tolerance):
    """w = −Ω with w′ = 0 after release, in 16 digits by another program; the same for every range that is asked for."""
    drive = lsvib.Drive.of(values)
    (cycle,) = (cycle for cycle in drive.cycles().cycles if cycle.label.name == "STICK_SLIP_CYCLE")
    ends = []
    for span in spans:
        change = next(c for c in drive.follow(cycle, parameter, span).changes if c.what.startswith("its slip"))
        assert (change.kind, change.what) == ("end", "its slip no longer comes to rest")
        ends.append(change.value)
    assert ends == [pytest.approx(end, rel=tolerance)] * len(ends)
    assert max(ends) - min(ends) <= 1e-14 * abs(end)


@pytest.mark.slow
def test_a_branch_does_not_depend_on_the_range():
    drive = lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10)
    cycle = drive.cycles().cycles[0]
    for parameter, spans in (("mass", [(10, 12), (10, 1e5), (10, 1e9)]), ("axial_force", [(-1e5, -1), (-1e3, -1)])):
        branches = [drive.follow(cycle, parameter, span) for span in spans]
        lowest = [branch.points[0].value for branch in branches]
        assert lowest == [pytest.approx(lowest[0], rel=1e-12)] * len(spans)
        assert all(branch.changes[0].what == branches[0].changes[0].what for branch in branches)


def test_branch_is_written():
    branch = NEAR_FOLD.follow(NEAR_FOLD.cycles().cycles[0], "axial_force", (-18.38, -18.36), points=30)
    data = branch_dataset(NEAR_FOLD, branch)
    assert data.sizes["point"] == len(branch.points)
    assert data.axial_force.units == "N"
    assert json.loads(json.dumps(branch_json(branch)))["changes"][0]["kind"] == "end"


@pytest.mark.parametrize(
    ("parameter", "span", "says"),
    [
        ("colour", (1, 2), "colour"),
        ("axial_force", (-10, -5), "holds the drive's own axial_force"),
        ("axial_force", (1,), "span"),
        ("mass", (-1, 20), "mass"),
    ],
)
def test_bad_input_is_named(parameter, span, says):
    cycle = NEAR_FOLD.cycles().cycles[0]
    assert says in complaint(NEAR_FOLD.follow, cycle, parameter, span)
    assert "another drive" in complaint(SLIP.follow, cycle, "mass", (0.5, 2))
