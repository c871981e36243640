"""Repelling cycles of drives with four states: on the edges of basins, and on branches past their folds."""

import numpy as np
import pytest
from references.parts import nut_drive, support_drive, threads_drive

from lsvib.dynamics.attractor import Attractor, steady_state

SLIP = {"mass": 9.9, "translation_damping": 1e3, "axial_force": 10.0}
THREADS = threads_drive(**SLIP, contact_stiffness=1e8, contact_damping=1e5)
SUPPORT = support_drive(**SLIP, support_stiffness=1e8, axial_support_damping=1e4)
NUT = nut_drive(**SLIP, nut_inertia=1e-2, nut_stiffness=1e4, nut_damping=1.0)
NEAR_FOLD = threads_drive(mass=11, support_damping=2e-3, axial_force=-18.37, contact_stiffness=1e8, contact_damping=1e8)


def across(cycle):
    """States beside a cycle on both sides, along the direction in which it repels."""
    values, vectors = np.linalg.eig(cycle.section.derivative(cycle.orbit).matrix)
    direction = vectors[:, np.argmax(np.abs(values))].real
    place = cycle.section.place(cycle.state)
    return [cycle.section.state(place + step * direction) for step in (-1e-6, 1e-6)]


@pytest.mark.parametrize("drive", [THREADS, SUPPORT, NUT, NEAR_FOLD], ids=["threads", "support", "nut", "near a fold"])
def test_the_cycle_on_the_edge_parts_the_basins(drive):
    """It repels along one direction; on one side of it motions end in steady sliding, on the other in the cycle."""
    found = drive.cycles()
    attracting, repelling = found.cycles
    assert attracting.attracting
    assert repelling.repelling
    assert repelling.found_by == "edge of a basin"
    assert repelling.residual < 1e-12
    assert np.sum(np.abs(repelling.multipliers) > 1) == 1
    assert "the edge between their two basins, with a cycle on it" in found.searched
    mode = repelling.section.key[1]
    ends = [steady_state(drive.automaton(), state, mode=mode) for state in across(repelling)]
    assert {end.label for end in ends} == {Attractor.STEADY_SLIDING, attracting.label}
    assert abs(repelling.work.balance) < 1e-10


@pytest.mark.slow
def test_branch_turns_at_a_fold():
    """The attracting cycle of a drive with four states is followed through the fold to cycles that repel."""
    attracting = NEAR_FOLD.cycles().cycles[0]
    branch = NEAR_FOLD.follow(attracting, "axial_force", (-18.5, -18.3699), points=5)
    (fold,) = branch.folds
    assert fold == pytest.approx(-18.371145255, abs=1e-9)
    points = branch.points
    assert {point.cycle.attracting for point in points} == {True, False}
    assert all(point.cycle.attracting != point.cycle.repelling for point in points)
    assert all(point.cycle.residual < 1e-12 for point in points)
    assert all(point.value > fold for point in points)
