"""Shares of the variance, worst cases, what a perturbation starts; the start from rest, and advice."""

import numpy as np
import pytest
from references.random_sheets import sheet
from references.sizes import sizes

from lsvib import Drive
from lsvib.sheets.assessment import assess
from lsvib.sheets.changes import changeable
from lsvib.sheets.draw import Operation
from lsvib.sheets.from_rest import KINDS, Starter, charts
from lsvib.sheets.output import as_json
from lsvib.sheets.report import brief, report
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.uncertainty import evaluated, study
from lsvib.sheets.window import OperatingWindow
from lsvib.stability.force_thresholds import threshold_force
from lsvib.stability.starting import runs_evenly

KINEMATIC = {
    "load": {"mass": {"low": "6 kg", "mode": "9 kg", "high": "16 kg"}, "force": "-50 N"},
    "friction": {"coefficient": {"mean": 0.218, "std": 0.015}},
}


def test_sobol_indices_of_a_reserve_that_two_entries_share():
    """Only mass and friction vary, nearly without interaction: their shares sum to about one."""
    total = study(sheet(**KINEMATIC), 4096, 2).sobol["kinematic_constraint"]
    assert set(total) == {"load.mass", "friction.coefficient"}
    assert sum(total.values()) == pytest.approx(1.0, abs=0.05)


def test_the_worst_case_is_at_least_as_bad_as_every_sample():
    """The search ends below all samples, at the heaviest load with the highest friction."""
    given = sheet(**KINEMATIC)
    found = assess(given, samples=1024)
    reserve = found.worst.there.reserves["kinematic_constraint"]
    shares = np.random.default_rng(8).random((2, 4000))
    assert reserve <= evaluated(given, shares)["kinematic_constraint"].min() + 1e-12
    assert found.worst.there.draw.entries["load.mass"] == pytest.approx(16, rel=1e-3)
    assert found.worst.vibration.attractor == "sprag slip cycle"


HEAVY = {
    "thread": {"lead": "4 mm", "pitch_diameter": "18 mm"}, "screw": {"length": "500 mm", "material": "steel"},
    "load": {"mass": "1300 kg", "orientation": "-90 deg"}, "operation": {"speed": "10 mm/s", "direction": "back"},
    "friction": {"coefficient": 0.12}, "damping": {"rotational": "1e-3 N*m*s/rad", "translational": "100 N*s/m"},
}  # fmt: skip


@pytest.mark.slow
def test_a_drive_whose_basin_is_the_whole_plane_is_steady_however_narrow_its_range():
    """Γ₊ < 0 alone starts nothing: the same is said with one stiffness and with a range of it."""
    stiffness = "60 N*m/rad"
    for given in (stiffness, [stiffness, "60.01 N*m/rad"]):
        found = assess(sheet(**HEAVY, coupling={"stiffness": given}), samples=256)
        assert found.perturbed.reserve < 0
        assert found.verdict == "steady"
        perturbed = as_json(found)["after_perturbation"]
        assert (perturbed["possible"], perturbed["probability"]) == (False, 0)
        assert perturbed["interval"][1] == 0 if given == stiffness else 0 < perturbed["interval"][1] < 0.04
        page = report(found, charts(found.draw))
        assert "can start vibration" not in page


GENTLE = {"damping": {"rotational": "1e-3 N*m*s/rad"}}


def test_how_often_a_perturbation_starts_vibration_is_how_often_the_force_is_below_its_threshold():
    """Forces that resist (11 kg, Fig. 8.14), of which the exact threshold of global stability says which are upset."""
    force = {"low": "10 N", "mode": "49 N", "high": "100 N"}
    given = sheet(load={"mass": "11 kg", "force": force}, **GENTLE)
    found = assess(given, samples=512)
    edge = -threshold_force(OperatingWindow(found.draw).corners[0].rigid, "global_stability")
    share = (edge - 10) ** 2 / (90 * 39)  # of a triangle, on its rising side
    chance = found.perturbed
    assert chance.interval[0] < share < chance.interval[1] < chance.interval[0] + 0.25
    assert chance.probability == pytest.approx(share, abs=0.02)
    assert found.verdict == "may jerk"  # a start from rest is such a perturbation
    assert found.worst.tolerated[0] < found.draw.values["speed_low"]
    chart = charts(found.draw)[0]
    wanted = [KINDS.index(kind) for kind in ("steady_until_perturbed", "jerks_from_rest")]  # a start is a perturbation
    upset = np.isin(chart.kind[:, -1], wanted)
    step, stretch = chart.force[1] - chart.force[0], 1.5  # of the highest speed in the chart
    assert chart.force[upset].max() == pytest.approx(stretch * edge, abs=step + 0.01 * edge)


def test_what_the_basin_does_not_cover_is_not_known():
    """With compliant threads it is that of another drive: neither possible nor impossible, and no probability."""
    contact = {"stiffness": "1e7 N/m", "damping": "1e4 N*s/m"}
    given = sheet(load={"mass": ["10.9 kg", "11 kg"], "force": "50 N"}, contact=contact, **GENTLE)
    found = assess(given, samples=64)
    assert as_json(found)["after_perturbation"] == {"possible": None, "probability": None, "interval": None}
    drawn = charts(found.draw)
    assert "Whether a perturbation can start vibration is not known; none of those tried did." in report(found, drawn)
    assert {KINDS[k] for k in np.unique(drawn[0].kind)} >= {"steady_once_started"}


# T-RO 2021, drive 1 (docs/friction.md), with the stiffness that its own record shows: it jerks at 2 rpm, not at 10.
JERKING = {
    "name": "drive 1", "thread": {"lead": "2 mm", "pitch_diameter": "11 mm", "half_angle": "15 deg"},
    "screw": {"inertia": "2.186e-6 kg*m^2"}, "coupling": {"stiffness": "0.0224 N*m/rad"},
    "load": {"mass": "0.276 kg", "force": "0.9414 N", "orientation": "horizontal"},
    "operation": {"speed": ["2 rpm", "20 rpm"], "direction": "both"}, "friction": {"coefficient": 0.58, "static": 0.88},
    "damping": {"rotational": "2e-4 N*m*s/rad"},
}  # fmt: skip


def test_the_first_line_says_that_it_jerks_up_to_which_speed_and_how_often():
    found = assess(Sheet.of(JERKING), samples=64)
    started = found.from_rest
    assert (found.verdict, started.cause) == ("jerks", "threads")
    assert started.there.corner == (1, pytest.approx(2 * np.pi / 30), 0.9414)
    drive = Drive.of(started.there.rigid)
    assert started.even_speed == pytest.approx(drive.threshold("even_speed").value, rel=1e-3)
    cycle = drive.steady_state("rest")
    assert started.motion.frequency == pytest.approx(1 / cycle.period, rel=1e-9)
    assert started.motion is found.nominal.vibration
    assert "it jerks 2.04 times a second, 30.2 µm each time; at 8.8 rpm" in brief(found)[0]
    assert "Any one of these changes ends the jerks" in " ".join(brief(found))


def test_the_other_direction_is_that_of_the_record():
    """Back, where the force helps, it jerks as the issue of the record says: 2.525 times a second, up to 6.2 rpm."""
    found = assess(Sheet.of({**JERKING, "operation": {"speed": ["2 rpm", "20 rpm"], "direction": "back"}}), samples=64)
    assert found.from_rest.motion.frequency == pytest.approx(2.525, abs=5e-3)
    assert found.from_rest.even_speed * 30 / np.pi == pytest.approx(6.2, abs=0.05)


def test_above_the_even_speed_it_is_steady():
    found = assess(Sheet.of({**JERKING, "operation": {"speed": "9.5 rpm", "direction": "both"}}), samples=64)
    assert (found.verdict, found.from_rest.jerks) == ("steady", False)
    assert "Started from rest without a ramp, it runs steadily at 8.79 rpm" in brief(found)[0]


def drawn(seed: int) -> dict:
    """A slow drive with static friction, of the size of the measured one or ten times larger."""
    rng = np.random.default_rng([seed, 46])
    size = 10 ** rng.uniform(0, 1)
    coefficient = rng.uniform(0.15, 0.5)
    return {
        **JERKING,
        "screw": {"inertia": f"{2e-6 * size**2} kg*m^2"},
        "coupling": {"stiffness": f"{0.02 * size**2} N*m/rad"},
        "load": {"mass": f"{0.3 * size} kg", "force": f"{rng.choice([-1, 1]) * size} N"},
        "friction": {"coefficient": coefficient, "static": coefficient * rng.uniform(1.3, 1.7)},
        "damping": {"rotational": f"{1e-4 * size**2 * rng.uniform(0.5, 2)} N*m*s/rad"},
        "operation": {"speed": ["1 rpm", "60 rpm"], "direction": str(rng.choice(["out", "back", "both"]))},
    }


def changes_that_help(seeds) -> int:
    """Apply each change that is advised: the drive runs evenly then, and not with an eighth less of it."""
    count = 0
    for seed in seeds:
        found = assess(Sheet.of(drawn(seed)), samples=64)
        if not found.from_rest.jerks:
            continue
        assert found.changes, seed
        for row in found.changes:
            keys = changeable(found.draw.values)[row.quantity]
            for factor, quiet in ((row.factor, True), (1 + 0.87 * (row.factor - 1), False)):
                own = found.draw.scaled(keys, factor)
                speeds, force = [own.values["speed_low"], own.values["speed_high"]], own.values["force_low"]
                places = [Operation(own, way, at, force) for way in own.sheet.directions for at in speeds]
                assert all(map(Starter(own.sheet).evenly, places)) == quiet
            count += 1
    return count


@pytest.mark.parametrize("seeds", sizes([range(3)], [range(100, 102)], [range(102, 150)]), ids=len)
def test_advice_does_what_it_says(seeds):
    assert changes_that_help(seeds) > len(seeds)


def test_the_chart_is_from_rest():
    """On both sides of the edge of the jerks, at some forces of either direction, the motion from rest decides."""
    sheet = Sheet.of(JERKING)
    found = assess(sheet, samples=64)
    for chart in charts(found.draw):
        jerks = chart.kind == KINDS.index("jerks_from_rest")
        assert jerks[:, 0].mean() > 0.9
        assert not jerks[:, -1].any()
        for row in (5, 60, 120, 155):
            last = np.flatnonzero(jerks[row])[-1] if jerks[row].any() else 0
            for k, even in ((last - 1, False), (last + 2, True)):
                speed = chart.speed[max(k, 0)] * 2 * np.pi / found.draw.values["lead"]
                there = Operation(found.draw, chart.direction, speed, chart.force[row])
                assert k < 0 or runs_evenly(there.rigid) == even
