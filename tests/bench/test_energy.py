"""The energy balance of motions: that it closes to rounding, and that it notices what it is there for."""

from dataclasses import replace

import numpy as np
import pytest
from references.wide_drives import wide_drive

from benchmarks.sweeps.energy_balance import balance, terms
from benchmarks.sweeps.energy_quadrature import residual
from lsvib.drives.parameters import NutParameters, RigidParameters, SupportParameters, ThreadsParameters
from lsvib.drives.registry import find_model
from lsvib.drives.rigid import rigid_automaton
from lsvib.drives.threads import threads_automaton
from lsvib.engine.automaton import oscillator
from lsvib.engine.kernels import columns
from lsvib.engine.motion import follow

LOADED = {"mass": 1.0, "translation_damping": 1000.0, "axial_force": 40.0}
PARADOX = {"mass": 15.0, "axial_force": 100.0}
SOFT = {"contact_stiffness": 1e7, "contact_damping": 1e4}
START = (0.1, 0.0, 0.0, 0.0)
SCENES = {
    "stick-slip": (RigidParameters, LOADED, ()),
    "sprag-slip": (RigidParameters, PARADOX, ()),
    "compliant threads": (ThreadsParameters, {**PARADOX, **SOFT}, ()),
    "support": (SupportParameters, {**LOADED, "screw_mass": 3.0, "axial_support_damping": 30.0}, ()),
    "support, rubbing": (
        SupportParameters,
        {**LOADED, "screw_mass": 3.0, "slide_friction": 8.0, "bearing_friction": 0.02},
        ("slide_friction", "bearing_friction"),
    ),
    "support, seizing": (SupportParameters, {**PARADOX, "screw_mass": 50.0}, ()),
    "nut, rubbing": (
        NutParameters,
        {**LOADED, "slide_friction": 8.0, "bearing_friction": 0.02},
        ("slide_friction", "bearing_friction"),
    ),
    "nut, seizing": (NutParameters, {**PARADOX, "mass": 11.0}, ()),
}


def motion_of(name, **changes):
    kind, parameters, physics = SCENES[name]
    drive = kind.of({**parameters, **changes})
    model = find_model(drive.model)
    automaton = model.build(drive, (*model.options, *physics), "contact_sign")
    return follow(automaton, START[: len(automaton.states)], 0.05), drive, physics


@pytest.mark.parametrize("name", SCENES)
def test_balance_closes(name):
    """1e-13: a few hundred panels and tens of events, each good to 1e-16."""
    motion, drive, physics = motion_of(name)
    assert motion.time.size >= 2
    found = balance(motion, drive, physics)
    assert found.residual <= 1e-13 + 4 * found.rounding
    assert found.rounding <= 1e-10


@pytest.mark.parametrize("name", SCENES)
def test_wrong_parameter_is_seen(name):
    """Powers with a friction coefficient that is off by 1e-6, as from a wrong law: far above the tolerance of 1e-10."""
    motion, drive, physics = motion_of(name)
    wrong = drive.replace(friction_coefficient=drive.friction_coefficient * (1 + 1e-6))
    assert balance(motion, wrong, physics).residual > 1e-8


@pytest.mark.parametrize("column", [columns.A0, columns.A1, columns.B])
def test_wrong_field_is_seen(column):
    """The flow of a mode with a coefficient that is off by 1e-6; those of its closed form are tied to A0 and A1."""
    drive = RigidParameters.of(LOADED)
    automaton = rigid_automaton(drive)
    flow = automaton.tables.flow.copy()
    row = flow[1]
    a0, a1, b = row[columns.A0], row[columns.A1], row[columns.B]
    values = {columns.A0: a0, columns.A1: a1, columns.B: b}
    values[column] *= 1 + 1e-6
    row[:] = oscillator(1.0, values[columns.A1], values[columns.A0], values[columns.B])
    motion = follow(replace(automaton, tables=automaton.tables._replace(flow=flow)), (0.1, 0.0), 0.05)
    assert 1 in motion.mode
    assert balance(motion, drive).residual > 1e-9


@pytest.mark.parametrize("name", ["sprag-slip", "support, seizing", "nut, seizing"])
def test_loss_in_seizures_is_counted(name):
    """Without it the balance is open by a good part of the energy."""
    motion, drive, physics = motion_of(name)
    assert np.isin(motion.kind, motion.automaton.sprag_kinds).any()
    lossless = terms(motion.automaton, drive, physics)._replace(seized=np.zeros(motion.start_state.size + 1))
    assert residual(motion, lossless)[0] > 1e-3


@pytest.mark.parametrize(("index", "start"), [(395, 87), (538, 41)])
def test_friction_has_its_sign_where_slip_begins(index, start):
    """Next to a release θ′ is below the last place of w = θ′ − Ω; friction takes energy there all the same."""
    wide = wide_drive("threads", 9901, index, start + 1)
    motion = follow(threads_automaton(wide.drive), wide.starts[start], 1.0)
    assert motion.time.size >= 1
    assert balance(motion, wide.drive).residual < 1e-13


def test_missed_reversal_is_seen():
    """A motion that stays under the old law after N = 0 has friction that drives it."""
    drive = RigidParameters.of(LOADED)
    automaton = rigid_automaton(drive)
    motion = follow(automaton, (0.1, 0.0), 0.05)
    guards = automaton.tables.guard_start
    signs = automaton.tables.guard_sign.copy()
    signs[guards[0]] = 0.0  # of N = 0 in the first mode
    deaf = follow(replace(automaton, tables=automaton.tables._replace(guard_sign=signs)), (-0.1, 0.0), 0.05)
    assert balance(motion, drive).residual <= 1e-13
    assert balance(deaf, drive).residual > 1e-6
