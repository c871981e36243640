"""What a scene leaves out is absent; what is left gives the same motion."""

import numpy as np
import pytest

from benchmarks.ablation import leaving_out
from lsvib.drives.parameters import RigidParameters, SupportParameters, ThreadsParameters
from lsvib.drives.rigid import EventKind, rigid_automaton
from lsvib.drives.second_body.support import MODEL
from lsvib.drives.threads import threads_automaton

SCENES = leaving_out.scenes(0.3)


@pytest.mark.parametrize("name", SCENES)
def test_the_general_model_has_the_same_motion(name):
    pared, general = leaving_out.measure(SCENES[name], 1)
    same, gap = leaving_out.difference(pared.motion, general.motion)
    assert same
    assert gap <= 1e-12  # of the size, the engine's own accuracy
    assert pared.table_bytes < general.table_bytes
    assert pared.motion.time.size > 20


def test_a_difference_is_noticed():
    (first, _), (other, _) = (leaving_out.measure(SCENES[name], 1) for name in ("stick_slip", "slip_cycle"))
    assert leaving_out.difference(first.motion, other.motion)[0] is False


def test_a_rigid_scene_carries_no_contact_state():
    rigid, threads = rigid_automaton(RigidParameters()), threads_automaton(ThreadsParameters())
    assert rigid.states == ("angle_deviation", "velocity_deviation")
    assert isinstance(rigid.tables.flow, np.ndarray)  # planar: no modal form, none of its kernels
    assert set(threads.states) - set(rigid.states) == {"thread_mismatch", "mismatch_rate"}


def test_without_rest_there_is_no_rest_in_the_tables():
    drive = RigidParameters.of(translation_damping=1e3, axial_force=25.0)
    tables = rigid_automaton(drive, rest=False).tables
    assert len(tables.surfaces) == 1  # Q = 0, no θ′ = 0
    assert set(tables.branch_kind) <= {EventKind.CONTACT_REVERSAL, EventKind.RELEASE}  # the entry's kind is not used
    assert len(tables.resets) == 0


def test_without_friction_of_the_slide_there_are_no_modes_of_it():
    drive = SupportParameters.of(screw_mass=1.0, slide_friction=0.0)
    pared = MODEL.build(drive, (), "contact_sign")
    loaded = MODEL.build(drive.replace(slide_friction=5.0), ("slide_friction",), "contact_sign")
    assert pared.codes.size == 6
    assert loaded.codes.size == 3 * 6
