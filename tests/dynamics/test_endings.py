"""Tables and endings of many drives at once are those of each one alone: 1e-12 of each number of the tables."""

import numpy as np
import pytest
from references.wide_drives import wide_drive

from lsvib.dynamics.sweep import Endings, _block_endings, all_endings, ending
from lsvib.models.drive import RigidDrive
from lsvib.models.many import ManyDrives, groups
from lsvib.models.rigid import rigid_automaton

RULES = ("contact_sign", "at_once")


def many_of(drives) -> ManyDrives:
    return ManyDrives({name: [getattr(drive, name) for drive in drives] for name in RigidDrive.model_fields})


@pytest.mark.parametrize("resume", RULES)
def test_tables_are_those_of_one_drive(resume):
    """Random drives over decades: every double of every table, and every integer."""
    drives = [wide_drive("rigid", 11, k, 0).drive for k in range(150)]
    done = np.zeros(len(drives), dtype=bool)
    for group in groups(many_of(drives), resume, np.arange(len(drives))):
        for place, member in enumerate(group.members):
            if not group.safe[place]:
                continue
            done[member], one = True, rigid_automaton(drives[member], resume=resume)
            for name, table in one.tables._asdict().items():
                other = np.asarray(getattr(group.automaton.tables, name))
                other = other[place] if other.ndim > np.ndim(table) else other
                np.testing.assert_allclose(other, table, rtol=1e-12, atol=0, err_msg=f"{name} of drive {member}")
            for name, table in one.observables.items():
                np.testing.assert_allclose(group.automaton.observables[name][place], table, rtol=1e-12, atol=0)
            assert (group.automaton.codes == one.codes).all()
            assert group.automaton.contracts == one.contracts
    assert done.mean() > 0.9


@pytest.mark.parametrize("resume", RULES)
def test_endings_are_those_of_one_motion(resume):
    """Wide drives and starts, and drives of the chapter's size around its thresholds: all numbers."""
    cases = [wide_drive("rigid", 12, k, 1) for k in range(60)]
    drives, starts = [case.drive for case in cases], [case.starts[0] for case in cases]
    rng = np.random.default_rng(2)
    for _ in range(60):
        drives.append(
            RigidDrive(
                mass=rng.uniform(1, 20),
                axial_force=rng.uniform(-60, 60),
                support_damping=rng.uniform(0, 2e-3),
                translation_damping=rng.choice([0.0, 1000.0]),
            )
        )
        starts.append([rng.uniform(-0.2, 0.2), rng.uniform(-80, 80)])
    many, starts, found = many_of(drives), np.array(starts), Endings.unknown(len(drives))
    is_open = _block_endings(many, np.arange(len(drives)), starts, resume, found)
    assert is_open.mean() < 0.25
    assert len(set(found.attractor[~is_open].tolist())) >= 3
    for k in np.flatnonzero(~is_open):
        one = ending(drives[k], starts[k], resume)
        np.testing.assert_allclose([column[k] for column in found], one, rtol=1e-9, atol=1e-9, err_msg=repr(drives[k]))


def test_threads_change_nothing():
    rng = np.random.default_rng(4)
    drives = [RigidDrive(mass=rng.uniform(1, 20), axial_force=rng.uniform(-60, 60)) for _ in range(200)]
    starts = np.tile([0.1, 0.0], (200, 1))
    alone = all_endings(many_of(drives), starts, "contact_sign")
    for workers in (2, 3):
        for mine, other in zip(alone, all_endings(many_of(drives), starts, "contact_sign", workers), strict=True):
            np.testing.assert_array_equal(mine, other)
