"""The largest tolerated perturbations: motions from just within settle, from just beyond do not."""

import json
import math

import numpy as np
import pytest

import lsvib

DRIVES = {
    "touching_motion": lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-10),
    "touching_slip": lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18.3),
    "cycle": lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18.35),
    "mirrored": lsvib.Drive(mass=11, support_damping=1e-3, axial_force=10, input_speed=-40),
}
WINDOW = {"u": (-0.3, 0.3), "w": (-150, 150)}
CLOSE = 1e-7  # relative distance from the boundary: far above rounding


def settles(drive, states):
    labels = np.array([drive.steady_state({"u": u, "w": w}).label for u, w in states])
    assert (labels != lsvib.Attractor.UNRESOLVED).all()
    return labels == lsvib.Attractor.STEADY_SLIDING


def energy_of(drive, u, w):
    inertia = drive.screw_inertia + drive.mass * (drive.pitch_radius * math.tan(drive.lead_angle)) ** 2
    return 0.5 * drive.coupling_stiffness * u**2 + 0.5 * inertia * w**2


@pytest.mark.parametrize("name", DRIVES)
def test_motions_on_both_sides_of_the_largest_tolerated_perturbations(name):
    drive = DRIVES[name]
    found = drive.resilience()
    assert found.boundary == (name if name != "mirrored" else "touching_motion")
    for size, unit in ((found.angle, (1, 0)), (found.speed, (0, 1))):
        within = [(sign * size * (1 - CLOSE) * unit[0], sign * size * (1 - CLOSE) * unit[1]) for sign in (1, -1)]
        beyond = [(sign * size * (1 + CLOSE) * unit[0], sign * size * (1 + CLOSE) * unit[1]) for sign in (1, -1)]
        assert settles(drive, within).all()
        assert not settles(drive, beyond).all()
    u, w = found.state
    assert found.energy == pytest.approx(energy_of(drive, u, w), rel=1e-14)
    assert settles(drive, [(u * (1 - CLOSE), w * (1 - CLOSE))]).all()
    assert not settles(drive, [(u * (1 + CLOSE), w * (1 + CLOSE))]).any()


@pytest.mark.parametrize("name", DRIVES)
def test_every_perturbation_of_less_energy_is_tolerated(name):
    drive = DRIVES[name]
    found = drive.resilience()
    angles = np.random.default_rng(3).uniform(0, 2 * math.pi, 2000)
    inertia = 2 * energy_of(drive, 0.0, 1.0)
    size = math.sqrt(2 * found.energy) * (1 - CLOSE)
    ring = size * np.stack(
        [np.cos(angles) / math.sqrt(drive.coupling_stiffness), np.sin(angles) / math.sqrt(inertia)], 1
    )
    assert settles(drive, ring).all()


def test_perturbations_are_in_proportion_to_the_force():
    """With c_x = 0 a basin within the touching motion is in proportion to R in each direction."""
    one = DRIVES["touching_motion"].resilience()
    two = DRIVES["touching_motion"].replace(axial_force=-20).resilience()
    assert two.angle == pytest.approx(2 * one.angle, rel=1e-12)
    assert two.speed == pytest.approx(2 * one.speed, rel=1e-12)
    assert two.energy == pytest.approx(4 * one.energy, rel=1e-12)


def test_nothing_and_everything_is_tolerated():
    unstable = lsvib.Drive(mass=11, axial_force=10).resilience(WINDOW)
    assert (unstable.angle, unstable.speed, unstable.energy, unstable.fraction) == (0, 0, 0, 0)
    for drive in (lsvib.Drive(), lsvib.Drive(mass=11, support_damping=1e-3, axial_force=-50)):
        stable = drive.resilience(WINDOW)
        assert (stable.angle, stable.speed, stable.energy, stable.fraction) == (math.inf,) * 3 + (1.0,)
        assert json.loads(json.dumps(stable.to_json(), allow_nan=False))["energy"] is None


def test_nothing_is_tolerated_where_steady_sliding_is_neutral():
    found = lsvib.Drive(support_damping=0, axial_force=-10).resilience(WINDOW)
    assert (found.boundary, found.energy, found.fraction) == ("neutral", 0, 0)
    assert lsvib.Drive(mass=11, axial_force=10).resilience().boundary == "unstable"
    assert lsvib.Drive(mass=11, support_damping=0, axial_force=10).resilience().boundary == "unstable"


def test_a_sweep_is_its_points():
    drive = DRIVES["touching_motion"]
    found = drive.resilience_sweep(WINDOW, axial_force=[-40, -10, 5])
    assert found.fatal_energy.dims == ("axial_force",)
    for force in (-40, -10, 5):
        one = drive.replace(axial_force=force).resilience(WINDOW)
        at = found.sel(axial_force=force)
        for name, value in (
            ("fatal_angle", one.angle),
            ("fatal_speed", one.speed),
            ("fatal_energy", one.energy),
            ("basin_fraction", one.fraction),
        ):
            assert at[name].item() == value
    assert "basin_fraction" not in drive.resilience_sweep(axial_force=[-10])
    refused = lsvib.Drive(mass=1, axial_force=10).resilience_sweep(translation_damping=[1e5])
    assert np.isnan(refused.fatal_energy).all()
    assert len(json.loads(refused.attrs["refused"])) == 1
