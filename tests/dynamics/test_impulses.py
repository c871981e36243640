"""Impulses of seizures in all models: momentum, the closed forms of the models, and Coulomb's cone."""

import math

import numpy as np
import pytest
from references.drives import DRIVES

import lsvib
from lsvib.answers.motion import Simulation, as_scene
from lsvib.dynamics.impulses import event_impulses, seizure_impulse

SPRAG = {"mass": 40.0, "support_damping": 1e-3, "duration": 0.05}
STARTS = {
    "rigid": {"u": 0.01, "w": 30.0},
    "support": {"u": 0.01, "w": 30.0, "screw_shift": 1e-6, "shift_rate": 0.01},
    "nut": {"u": 0.01, "w": 30.0, "nut_angle": 0.01, "nut_rate": -3.0},
}


def scene_of(model: str, force: float):
    drive = {key: value for key, value in SPRAG.items() if key != "duration"} | {"axial_force": force}
    if model == "support":  # the reduced mass, 22 kg, is beyond the critical mass
        drive["screw_mass"] = 50.0
    return as_scene({"drive": DRIVES[model](drive), "start": STARTS[model], "duration": SPRAG["duration"]}, {}, {})


@pytest.mark.parametrize("force", [50.0, -10.0])
@pytest.mark.parametrize("model", STARTS)
def test_impulses_of_a_motion(model, force):
    """And in its dataset, with their peak in the summary."""
    scene = scene_of(model, force)
    motion, drive = Simulation.of(scene).motion, scene.drive
    seized = motion.automaton.marked(motion.kind, "impact")
    assert seized.any()
    impulses = event_impulses(drive, motion)
    for part in (impulses.normal, impulses.axial, impulses.torque):
        assert (part[~seized] == 0).all()
        assert (np.sign(part[seized]) == motion.sign[seized]).all()
    # The tangential impulse F of the threads from the other balance; Coulomb's law allows no more than mu times J_N.
    cosine, sine = math.cos(drive.lead_angle), math.sin(drive.lead_angle)
    tangential = impulses.torque / drive.pitch_radius * cosine + impulses.axial * sine
    assert impulses.normal * cosine + tangential * sine == pytest.approx(impulses.axial, rel=1e-12)
    assert (np.abs(tangential) <= drive.friction_coefficient * np.abs(impulses.normal) * (1 + 1e-12)).all()
    lead = drive.pitch_radius * math.tan(drive.lead_angle)
    before = motion.before[seized]
    if model == "rigid":
        speed = drive.input_speed + before[:, 1]
        assert impulses.normal[seized] == pytest.approx(seizure_impulse(drive, speed), rel=1e-12)
        axial = drive.mass * lead * speed
        assert impulses.torque[seized] == pytest.approx(drive.screw_inertia * speed, rel=1e-12)
        assert (motion.after[seized] == np.stack([before[:, 0], 0 * speed - drive.input_speed], 1)).all()
    elif model == "support":
        axial = drive.mass * drive.screw_mass / (drive.mass + drive.screw_mass) * lead * (40.0 + before[:, 1])
    else:
        axial = drive.mass * lead * (40.0 + before[:, 1] - before[:, 3])
        # The moment on the screw is that on the nut.
        shift = (motion.after - motion.before)[seized, 3]
        assert impulses.torque[seized] == pytest.approx(drive.nut_inertia * shift, rel=1e-9)
    assert impulses.axial[seized] == pytest.approx(axial, rel=1e-9)
    dataset = lsvib.simulate(scene)
    found = dataset.event_normal_impulse
    assert found.dims == ("event",)
    assert found.attrs["units"] == "N s"
    assert (found.values == impulses.normal).all()
    assert Simulation(scene, motion).to_json()["peak_normal_impulse"] == float(np.abs(found).max()) > 0
    assert "event_normal_impulse" in dataset.normal_force.attrs["comment"]


def test_compliant_threads_have_forces_and_no_impulses():
    scene = as_scene({"drive": DRIVES["threads"](mass=11.0), "start": {"u": 0.01, "w": 0.0}, "duration": 0.01}, {}, {})
    motion = Simulation.of(scene).motion
    assert not event_impulses(scene.drive, motion).normal.any()
    assert "event_normal_impulse" not in lsvib.simulate(scene)
    assert "peak_normal_impulse" not in Simulation(scene, motion).to_json()
