"""Attractors of all models, slow cycles above all: what the return map finds is where the motion itself goes.

Tolerances. Fixed points repeat to 1e-12 of the size of the motion: rounding of one period, a few events long. The rate
at which the motion comes closer must be that of the largest multiplier to 10 %: the distance is not in proportion to
its power where others still count, and a complex pair makes it oscillate.

Labels of drives such as catalogues offer are held against where the motion itself has come much later: near the
equilibrium, or the orbit. A motion that attracts slowly still has most of its first distance left, so that a tenth of
it must be gone; and 1e-3 of the size of the motion is where the points of an orbit lie.
"""

import math

import numpy as np
import pytest
from references.catalogue import MODELS, catalogue_drive
from references.parts import DRIVES

from lsvib.dynamics.attractor import Attractor, Doubt, SteadyState, steady_state
from lsvib.engine.motion import Budget, Motion, follow
from lsvib.errors import WorkSpentError
from lsvib.models.model import automaton_of, model_of

SUPPORT = {
    "mass": 1.6, "friction_coefficient": 0.304, "axial_force": -156.0, "input_speed": -56.5,
    "support_damping": 8.64e-5, "screw_mass": 13.4, "support_stiffness": 3.38e6, "bearing_friction": 1.08e-3,
}  # fmt: skip
NUT = {
    "mass": 17.1, "friction_coefficient": 0.223, "axial_force": 155.0, "input_speed": 8.17,
    "support_damping": 6.93e-4, "translation_damping": 66.7, "nut_inertia": 1.66e-5, "nut_stiffness": 0.0739,
}  # fmt: skip
SPRAG = {
    "mass": 21.1, "friction_coefficient": 0.347, "axial_force": 1.04, "input_speed": 37.7,
    "support_damping": 1.86e-5, "screw_mass": 7.48, "support_stiffness": 1.37e4, "bearing_friction": 2.47e-3,
}  # fmt: skip
THREADS = {"mass": 11.0, "axial_force": 50.0}
ELASTIC = {
    "mass": 15.0, "axial_force": 60.0, "support_damping": 1e-4, "contact_stiffness": 1e7, "contact_damping": 0.0,
}  # fmt: skip


def build(model: str, parameters: dict, u: float, w: float):
    """Automaton and start of a scene."""
    drive = DRIVES[model](parameters)
    return automaton_of(drive), model_of(drive).initial_state(drive, {"u": u, "w": w})


@pytest.mark.parametrize(
    ("model", "parameters", "start", "label", "window"),
    [
        ("support", SUPPORT, (-0.0193, 0.138), Attractor.STICK_SLIP_CYCLE, (6000, 12000)),  # real, 0.9987
        ("support", SPRAG, (-0.148, 20.8), Attractor.SPRAG_SLIP_CYCLE, (100_000, 160_000)),  # complex, |.| = 0.99996
        ("threads", THREADS, (0.003, 0.0), Attractor.SPRAG_SLIP_CYCLE, (100, 300)),  # the creep of the contact
    ],
)
def test_motion_approaches_the_cycle_at_the_rate_of_its_multiplier(model, parameters, start, label, window):
    automaton, state = build(model, parameters, *start)
    cycle = steady_state(automaton, state)
    assert cycle.label == label
    assert cycle.residual <= 1e-12
    assert 0.9 < cycle.multiplier < 1
    events = (window[1] + 1) * max(cycle.orbit.time.size, 1) * 2
    motion = follow(automaton, state, math.inf, max_events=events)
    points = motion.after[(motion.kind == cycle.orbit.kind[-1]) & (motion.mode == cycle.orbit.mode[-1])]
    far = np.abs((points - cycle.state) / np.abs(motion.after).max(axis=0)).max(axis=1)
    count = 30  # returns over which a complex pair turns at least once
    first, last = (np.log(far[n : n + count]).mean() for n in window)
    assert (last - first) / (window[1] - window[0]) == pytest.approx(math.log(cycle.multiplier), rel=0.1)


@pytest.mark.parametrize(
    ("model", "parameters", "start", "returns"),
    [("threads", ELASTIC, (0.1, -20.0), 3), ("nut", NUT, (0.0289, 16.2), 21)],
)
def test_the_cycle_is_that_of_the_motion_though_others_attract(model, parameters, start, returns):
    """Cycles of fewer (nut) or more returns (elastic contact) attract, too; a hundred periods later it is this one."""
    automaton, state = build(model, parameters, *start)
    cycle = steady_state(automaton, state)
    assert cycle.returns == returns
    motion = follow(automaton, state, 100 * cycle.period)
    points = motion.after[(motion.kind == cycle.orbit.kind[-1]) & (motion.mode == cycle.orbit.mode[-1])]
    far = np.abs(points[-returns:] - cycle.state).max(axis=1)
    assert far.min() <= 1e-9 * np.abs(cycle.state).max()


def test_the_period_is_the_shortest():
    """A complex pair near the third roots of one: three returns come nearest, but one is the period."""
    parameters = {
        "support_damping": 0.0, "nut_damping": 0.0,
        "mass": 2.316488574, "friction_coefficient": 0.3730940239, "axial_force": 139.5779178,
        "input_speed": 21.1421218, "translation_damping": 133.2130792, "nut_inertia": 1.289840457e-05,
        "nut_stiffness": 4.943884351,
    }  # fmt: skip
    cycle = steady_state(*build("nut", parameters, -0.0783490385, 43.85294688))
    assert cycle.label == Attractor.STICK_SLIP_CYCLE
    assert (cycle.returns, cycle.orbit.time.size) == (1, 2)


def test_chaos_is_unresolved():
    """Two motions that start 1e-9 apart are far apart after 1000 events, and there is no cycle to find."""
    parameters = {
        "mass": 9.98, "friction_coefficient": 0.393, "axial_force": 6.3, "input_speed": -19.3,
        "screw_mass": 6.02, "support_stiffness": 2.4e7, "translation_damping": 215.0,
    }  # fmt: skip
    automaton, state = build("support", parameters, 0.108, -46.9)
    ends = [follow(automaton, state * (1 + h), math.inf, max_events=1000).end_state for h in (0.0, 1e-9)]
    apart = np.abs(ends[1] - ends[0]).max() / np.abs(ends[0]).max()
    assert apart > 1e-3
    assert steady_state(automaton, state, max_events=5000).label == Attractor.UNRESOLVED


def test_undamped_oscillation_that_settles_is_not_steady_sliding():
    undamped = {"mass": 5.0, "axial_force": 100.0, "screw_mass": 5.0, "support_damping": 0.0}
    automaton, state = build("support", undamped, 1e-4, 0.0)
    assert steady_state(automaton, state).label == Attractor.NEUTRAL_FAMILY  # of two frequencies
    damped, state = build("support", undamped | {"support_damping": 1e-3, "axial_support_damping": 500.0}, 1e-4, 0.0)
    assert steady_state(damped, state).label == Attractor.STEADY_SLIDING


def test_amplitude_is_half_the_width_of_the_cycle_in_every_model():
    """Of samples, taken again beside the extrema, since u turns there at once: 1e-9 s at 10 rad/s are 1e-6 of it."""
    for model, parameters, start in (("threads", THREADS, (0.003, 0.0)), ("nut", NUT, (0.0289, 16.2))):
        cycle = steady_state(*build(model, parameters, *start))
        times, step = np.linspace(0, cycle.period, 20_001, retstep=True)
        angles = cycle.orbit.at(times)[0][:, 0]
        ends = []
        for place in (angles.argmin(), angles.argmax()):
            near = np.clip(times[place] + np.linspace(-step, step, 20_001), 0, cycle.period)
            ends.append(cycle.orbit.at(near)[0][:, 0])
        assert cycle.amplitude == pytest.approx(0.5 * (ends[1].max() - ends[0].min()), rel=1e-6)


CYCLES = (Attractor.STICK_SLIP_CYCLE, Attractor.SPRAG_SLIP_CYCLE, Attractor.OTHER_CYCLE)


def distances(found: SteadyState, motion: Motion, size: np.ndarray) -> tuple[float, float]:
    """Largest distance from an attractor, in sizes of the motion, over the motion's first and last hundredth."""
    points = found.state[None]
    if found.orbit is not None:
        points = np.vstack([found.orbit.after, found.orbit.at(np.linspace(0, found.period, 2000))[0]])
    times = motion.end_time * np.array([np.linspace(0, 0.01, 100), np.linspace(0.99, 1, 100)])
    first, last = (
        max(np.abs((points - state) / size).max(axis=1).min() for state in motion.at(part)[0]) for part in times
    )
    return float(first), float(last)


@pytest.mark.parametrize("model", MODELS)
def test_motions_of_catalogue_drives_end_where_their_labels_say(model):
    unresolved, held = 0, 0
    for index in range(5):
        drive, starts = catalogue_drive(model, 32, index)
        automaton = automaton_of(drive)
        horizon = 20_000 * math.sqrt(drive.screw_inertia / drive.coupling_stiffness)
        for start in starts:
            found = steady_state(automaton, start)
            if found.label == Attractor.UNRESOLVED:
                unresolved += 1
                assert found.doubt in (Doubt.EVENT_BUDGET, Doubt.RECURRENT, Doubt.WORK_BUDGET)
                continue
            assert found.label in (Attractor.STEADY_SLIDING, *CYCLES)
            if found.orbit is not None:
                assert found.residual <= 1e-9
                assert abs(found.multiplier) < 1
            try:
                motion = follow(automaton, start, horizon, budget=Budget(2e5))
            except WorkSpentError:
                continue
            size = np.abs(np.vstack([start, motion.end_state, motion.after[:1000]])).max(axis=0)
            first, last = distances(found, motion, size)
            assert last <= max(0.9 * first, 1e-3)
            held += 1
    assert unresolved <= 2
    assert held >= 10
