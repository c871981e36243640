"""Probabilities, shares of the variance and worst cases of uncertain sheets against simulated drives."""

import math

import numpy as np
import pytest
from references.chapter_sheet import sheet

from lsvib.assess import drive as sheets
from lsvib.assess.assessment import assess
from lsvib.assess.chart import KINDS, charts
from lsvib.assess.mechanisms import corners, drive_of, reserves
from lsvib.assess.output import as_json
from lsvib.assess.report import report
from lsvib.assess.sheet import Sheet
from lsvib.assess.uncertainty import draw_of, evaluated, study
from lsvib.dynamics.attractor import Attractor, steady_state
from lsvib.models.rigid import rigid_automaton
from lsvib.stability.force_thresholds import threshold_force

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
    assert reserve <= evaluated(given, shares)["kinematic_constraint"].min() + 1e-12
    assert found.worst.entries["load.mass"] == pytest.approx(16, rel=1e-3)
    assert found.worst.vibration.attractor == "sprag slip cycle"


HEAVY = {
    "thread": {"lead": "4 mm", "pitch_diameter": "18 mm"},
    "screw": {"length": "500 mm", "material": "steel"},
    "load": {"mass": "1300 kg", "orientation": "-90 deg"},
    "operation": {"speed": "10 mm/s", "direction": "back"},
    "friction": {"coefficient": 0.12},
    "damping": {"rotational": "1e-3 N*m*s/rad", "translational": "100 N*s/m"},
}


def test_a_drive_whose_basin_is_the_whole_plane_is_steady_however_narrow_its_range():
    """Γ₊ < 0 alone starts nothing: the same is said with one stiffness and with a range of it."""
    stiffness = "60 N*m/rad"
    for given in (stiffness, [stiffness, "60.01 N*m/rad"]):
        found = assess(sheet(**HEAVY, coupling={"stiffness": given}), samples=256)
        assert found.mechanisms["after_perturbation"].reserve < 0
        assert found.verdict == "steady"
        perturbed = as_json(found)["after_perturbation"]
        assert (perturbed["possible"], perturbed["probability"]) == (False, 0)
        assert perturbed["interval"][1] == 0 if given == stiffness else 0 < perturbed["interval"][1] < 0.04
        page = report(found, charts(found.sheet, found.values))
        assert "can start vibration" not in page


GENTLE = {"damping": {"rotational": "1e-3 N*m*s/rad"}}


def test_how_often_a_perturbation_starts_vibration_is_how_often_the_force_is_below_its_threshold():
    """Forces that resist (11 kg, Fig. 8.14), of which the exact threshold of global stability says which are upset."""
    force = {"low": "10 N", "mode": "49 N", "high": "100 N"}
    given = sheet(load={"mass": "11 kg", "force": force}, **GENTLE)
    found = assess(given, samples=512)
    values = found.values
    edge = -threshold_force(drive_of(given, values, *corners(given, values)[0]), "global_stability")
    share = (edge - 10) ** 2 / (90 * 39)  # of a triangle, on its rising side
    chance = found.mechanisms["after_perturbation"]
    assert chance.interval[0] < share < chance.interval[1] < chance.interval[0] + 0.25
    assert chance.probability == pytest.approx(share, abs=0.02)
    assert found.verdict == "steady until perturbed"
    assert found.worst.tolerated[0] < abs(values["speed_low"])
    chart = charts(given, values)[0]
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
    page = report(found, charts(given, found.values))
    assert "Whether a perturbation can start vibration is not known." in page
    assert {KINDS[k] for k in np.unique(charts(given, found.values)[0].kind)} >= {"steady_once_started"}
