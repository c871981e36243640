"""Times that are surely quiet, by the parts of a mode, against the events of the engine and against long runs."""

import math

import numpy as np
import pytest
from judge.long_run import constants_of, fate
from references.wide_drives import wide_drive
from references.wide_scenes import assert_slides_steadily, scene

from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.cycles.quiet import parts_of, quiet_until
from lsvib.drives.parameters import SupportParameters
from lsvib.drives.registry import find_model
from lsvib.engine.kernels import dispatch
from lsvib.engine.kernels.status import Status
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.engine.motion import Budget, enter, follow
from lsvib.errors import EngineError

PLACES = (0.0, 0.1, 0.5, 0.9, 0.999)  # parts of an arc at which the rest of it is asked about
ALIKE = 1e-9  # of the size of a motion: parts of modes whose conditions are below 1e6


@pytest.mark.parametrize("model", ["threads", "support", "nut"])
def test_no_event_comes_before_a_quiet_time_ends(model):
    """On every arc of random motions, from several places of it; and a time without end means that none comes."""
    asked = told = 0
    for index in range(5):
        automaton, state = scene(model, 61, index, 0)
        try:
            motion = follow(automaton, state, math.inf, max_events=12, budget=Budget(20_000))
        except EngineError:
            continue
        modes, starts, _, durations = motion.arcs()
        settled = motion.status == Status.SETTLED
        for arc, (mode, start, duration) in enumerate(zip(modes, starts, durations, strict=True)):
            last = arc == durations.size - 1
            if (last and not settled) or (duration == 0 and not last):
                continue
            there = np.empty_like(start)
            for place in PLACES:
                dispatch.advance(automaton.tables.flow, mode, start, place * duration, there)
                quiet, asked = quiet_until(automaton, mode, there, Budget(math.inf)), asked + 1
                assert last or quiet <= duration * (1 - place) * (1 + 1e-12)
                told += quiet > 0.1 * duration
    assert asked > 50
    assert told > 0.05 * asked


@pytest.mark.parametrize(
    ("model", "seed", "index", "in_blocks"),
    [
        ("threads", 71, 16, False),
        ("support", 71, 6, False),
        ("nut", 71, 11, True),
        ("nut", 71, 27, True),
        ("threads", 83, 36, True),
    ],
)
def test_parts_add_up_to_the_motion(model, seed, index, in_blocks):
    """In slip and at rest, in modal form and in blocks; the last one winds up and swings in one and the same block."""
    automaton, state = scene(model, seed, index, 0, in_blocks)
    flow = automaton.tables.flow
    for mode in range(len(automaton.codes)):
        found = parts_of(flow, mode, state)
        fastest = np.abs(found.rates).max()
        for time in (0.0, 0.3 / fastest, 5 / fastest):
            there = np.empty_like(state)
            dispatch.advance(flow, mode, state, time, there)
            terms = found.along * np.exp(found.rates * time)
            sizes = np.abs(terms).sum(axis=1) + np.abs(found.drift).sum(axis=1) + np.abs(there)
            ours = terms.real.sum(axis=1) + found.drift @ [1.0, time, time**2]
            assert (np.abs(ours - there) <= ALIKE * sizes).all()


@pytest.mark.parametrize("in_blocks", [False, True])
@pytest.mark.parametrize(("index", "period"), [(11, 413.27256499013), (27, 20261470.7945)])
def test_a_cycle_with_a_long_rest_is_told(index, period, in_blocks):
    """The rest ends when the coupling has turned far enough; till then the nut vibrates at 1e4 to 1e5 1/s."""
    automaton, state = scene("nut", 71, index, 0, in_blocks)
    found = steady_state(automaton, state, max_events=700_000)
    assert found.label == Attractor.SPRAG_SLIP_CYCLE
    assert found.period == pytest.approx(period, rel=1e-10)
    assert abs(found.multiplier) < 1e-6


@pytest.mark.parametrize("start", [0, 3])
def test_a_rest_that_winds_up_is_left_out(start):
    """The coupling is wound up for 53 s while the nut swings; where slip begins, its fast rate needs short searches."""
    automaton, state = scene("threads", 83, 36, start)
    found = steady_state(automaton, state, max_events=700_000)
    assert found.label == Attractor.STEADY_SLIDING
    wide = wide_drive("threads", 83, 36, 4)
    assert fate(wide, start, *constants_of(wide)).name == "steady_sliding"


def test_an_oscillation_that_has_just_touched_is_left_to_die_away():
    """After each release the screw comes to within 1e-6 of standstill again; the search took a million steps."""
    automaton, state = scene("support", 71, 6, 0)
    assert_slides_steadily(automaton, state, 1000, 300_000)


def test_a_cycle_whose_slowest_multiplier_is_almost_one():
    """Its distance from one, 4e-9, is the slow rate of the support times the period."""
    automaton, state = scene("support", 71, 11, 2)
    found = steady_state(automaton, state)
    assert found.label == Attractor.STICK_SLIP_CYCLE
    flow = automaton.tables.flow
    slow = flow.rates[2, : flow.singles[2]].max()
    assert 1 - found.multiplier == pytest.approx(-slow * found.period, rel=0.01)
    wide = wide_drive("support", 71, 11, 4)
    assert fate(wide, 2, *constants_of(wide)).name in ("stick_slip_cycle", "unknown")


def test_walks_of_quiet_times_cost_little():
    """This support comes to its cycle after two hundred walks of a hundred steps; the work was once beyond 700 000."""
    automaton, state = scene("support", 71, 56, 0)
    found = steady_state(automaton, state, max_events=300_000)
    assert found.label == Attractor.OTHER_CYCLE
    assert found.residual < 1e-9


def test_a_rate_of_zero_beside_what_winds_up_is_told_by_no_parts():
    """With a support that creeps at 10⁻⁵ 1/s a block has no inverse beside what winds up: once a traceback."""
    block = np.array([[0.0, 0.0, 0.0], [1.0, -1.0, 1.0], [0.0, 1.0, -1.0]])
    unused = np.zeros((1, 3, 3))
    flow = BlockFlow(
        block[None],
        unused,
        unused,
        unused[:, 0],
        np.array([[0, 3, 3, 3]]),
        unused[:, 0],
        np.eye(3)[None],
        np.eye(2, 4)[None],
        unused,
    )
    assert parts_of(flow, 0, np.ones(2)) is None


def test_a_rest_without_any_rate_is_left_out():
    """The slide is held, so nothing but the coupling moves; its guards are polynomials of time, one is zero for ever.

    Once a division by zero.
    """
    drive = SupportParameters.of(
        mass=1388694.6563156238, axial_support_damping=737573862.7686116, slide_friction=177901468.5338863,
        bearing_friction=5937.127289529576, friction_coefficient=0.017751527231213718, input_speed=-1e-9,
        axial_force=-1e-18,
    )  # fmt: skip
    model = find_model("support")
    automaton = model.build(drive, model.physics_of(drive), "contact_sign")
    state = np.array([-3.23890441e-10, 1e-9, 0.0, 0.0])  # of rest; it lasts until u is zero
    mode, _ = enter(automaton, state)
    assert parts_of(automaton.tables.flow, mode, state).rates.size == 0
    assert quiet_until(automaton, mode, state, Budget(1e5)) == pytest.approx(-state[0] / state[1], rel=1e-3)
    assert steady_state(automaton, state, max_events=100_000).label == Attractor.STEADY_SLIDING
