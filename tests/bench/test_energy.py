"""The energy balance of motions: that it closes to rounding, and that it notices what it is there for."""

from dataclasses import replace

import numpy as np
import pytest
from references.parts import nut_drive, support_drive, threads_drive

from benchmarks.sweeps.energy_balance import balance, residual, terms
from lsvib.engine.motion import follow
from lsvib.models.drive import Drive
from lsvib.models.model import model_of
from lsvib.models.rigid import rigid_automaton

LOADED = {"mass": 1.0, "translation_damping": 1000.0, "axial_force": 40.0}
PARADOX = {"mass": 15.0, "axial_force": 100.0}
RUBBING = {"slide_friction": 8.0, "bearing_friction": 0.02}
START = (0.1, 0.0, 0.0, 0.0)
SCENES = {
    "stick-slip": (Drive, LOADED),
    "sprag-slip": (Drive, PARADOX),
    "compliant threads": (threads_drive, {**PARADOX, "contact_stiffness": 1e7, "contact_damping": 1e4}),
    "support": (support_drive, LOADED),
    "support, rubbing": (support_drive, {**LOADED, **RUBBING, "screw_mass": 3.0, "axial_support_damping": 30.0}),
    "support, seizing": (support_drive, {**PARADOX, "screw_mass": 50.0}),
    "support, heavy, seizing": (support_drive, {"mass": 15.0, "screw_mass": 50.0, "support_damping": 1e-3}),
    "nut": (nut_drive, LOADED),
    "nut, rubbing": (nut_drive, {**LOADED, **RUBBING}),
    "nut, seizing": (nut_drive, {**PARADOX, "mass": 11.0}),
    "nut, pulled, seizing": (nut_drive, {"mass": 11.0, "support_damping": 1e-3, "axial_force": -20.0}),
}


def motion_of(name):
    kind, parameters = SCENES[name]
    drive, physics = kind.of(parameters), tuple(RUBBING) if "rubbing" in name else ()
    model = model_of(drive)
    automaton = model.build(drive, (*model.options, *physics), "contact_sign")
    return follow(automaton, START[: len(automaton.states)], 0.05), drive, physics


@pytest.mark.parametrize("name", SCENES)
def test_the_balance_closes_and_notices_a_wrong_parameter(name):
    """1e-13: a few hundred panels and tens of events, each good to 1e-16. A friction that is off by 1e-6 is seen."""
    motion, drive, physics = motion_of(name)
    assert motion.time.size >= 2
    found = balance(motion, drive, physics)
    assert found.residual <= 1e-13 + 4 * found.rounding
    assert found.rounding <= 1e-10
    wrong = drive.replace(friction_coefficient=drive.friction_coefficient * (1 + 1e-6))
    assert balance(motion, wrong, physics).residual > 1e-8


@pytest.mark.parametrize("name", ["sprag-slip", *(name for name in SCENES if "seizing" in name)])
def test_the_loss_in_seizures_is_counted(name):
    """Without it the balance is open by a good part of the energy."""
    motion, drive, physics = motion_of(name)
    assert np.isin(motion.kind, motion.automaton.sprag_kinds).any()
    lossless = terms(motion.automaton, drive, physics)._replace(seized=np.zeros(motion.start_state.size + 1))
    assert residual(motion, lossless).residual > 1e-3


def test_a_missed_reversal_is_seen():
    """A motion that stays under the old law after N = 0 has friction that drives it."""
    drive = Drive.of(LOADED)
    automaton = rigid_automaton(drive)
    signs = automaton.tables.guard_sign.copy()
    signs[automaton.tables.guard_start[0]] = 0.0  # of N = 0 in the first mode
    deaf = follow(replace(automaton, tables=automaton.tables._replace(guard_sign=signs)), (-0.1, 0.0), 0.05)
    assert balance(follow(automaton, (-0.1, 0.0), 0.05), drive).residual <= 1e-13
    assert balance(deaf, drive).residual > 1e-6
