"""Motions with four states that hardly move from turn to turn: leaps end where the motion itself goes.

The drives are those of ``judge.wide_drives``, far from the chapter's; each was once left open, or wrong.
"""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from judge.judges import BAD, stages
from judge.long_run import constants_of, fate
from references.wide_drives import wide_drive
from references.wide_scenes import assert_slides_steadily, scene

import lsvib
from lsvib.basins.mapper import mapper
from lsvib.cycles import drift_more_states
from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.cycles.cones import Dwindling, keeps_proportion, shrinking
from lsvib.cycles.return_map import ReturnSection
from lsvib.cycles.trends import trend_of
from lsvib.drives.registry import find_model
from lsvib.engine.kernels.status import Status
from lsvib.engine.motion import Budget, follow

CYCLES = (Attractor.STICK_SLIP_CYCLE, Attractor.SPRAG_SLIP_CYCLE, Attractor.OTHER_CYCLE)


def followed(automaton, state, events: int):
    """Follow a motion event by event; its last part."""
    mode = None
    for _ in range(events // 20_000):
        motion = follow(automaton, state, math.inf, mode=mode, max_events=20_000)
        if motion.status == Status.SETTLED:
            break
        state, mode = motion.end_state, motion.end_mode
    return motion


@pytest.mark.parametrize(("model", "index", "start"), [("support", 1, 1), ("support", 59, 1), ("nut", 22, 0)])
def test_what_settles_after_many_events_is_told_by_fewer(model, index, start):
    automaton, state = scene(model, 7, index, start)
    assert followed(automaton, state, 1_000_000).status == Status.SETTLED
    assert steady_state(automaton, state, max_events=120_000).label == Attractor.STEADY_SLIDING


def test_a_cycle_with_a_multiplier_of_nearly_one():
    """A fast cycle of slip whose coupling relaxes in 10⁷ of its turns: 1 − λ is the slow rate times the period."""
    automaton, state = scene("support", 7, 16, 0)
    cycle = steady_state(automaton, state)
    assert cycle.label == Attractor.OTHER_CYCLE
    flow, mode = automaton.tables.flow, cycle.orbit.arcs()[0][0]
    slow = flow.rates[mode, : flow.singles[mode]].max()
    assert 1 - cycle.multiplier == pytest.approx(-slow * cycle.period, rel=0.01, abs=0)


def test_a_cycle_is_looked_for_between_leaps():
    """A second slow oscillation moves the motion with every leap, and Newton's method would reach the cycle at once."""
    automaton, state = scene("support", 71, 17, 0)
    motion = follow(automaton, state, math.inf, max_events=1024)
    found = steady_state(automaton, motion.end_state, mode=motion.end_mode, max_events=700_000)
    assert found.label == Attractor.SPRAG_SLIP_CYCLE
    assert 1 - found.multiplier == pytest.approx(3.0939e-6, rel=1e-3)


def test_a_decay_without_end_is_no_cycle():
    """With R = 0 nothing has a size: contact reversals go on for ever, and the motion shrinks by 1.4e-4 in a turn."""
    automaton, state = scene("support", 7, 33, 1)
    assert steady_state(automaton, state, max_events=60_000).label not in CYCLES
    sizes = [np.abs(followed(automaton, state, events).after[-1000:]).max(axis=0) for events in (20_000, 200_000)]
    assert (sizes[1] < 0.9 * sizes[0]).all()


def test_what_rounding_leaves_of_a_motion_is_no_cycle():
    """With R = 0 the motion shrinks by a third in a return, down to numbers that repeat; the map has no derivative."""
    automaton, state = scene("threads", 72, 26, 3, in_blocks=True)
    assert steady_state(automaton, state, max_events=700_000).label not in CYCLES


def test_steady_sliding_on_the_surface_of_no_force():
    """Axial force and friction of the slide balance, so that N = 0 in steady sliding; the motion starts there."""
    automaton, state = scene("support", 7, 46, 2)
    assert not state.any()
    assert steady_state(automaton, state).label == Attractor.STEADY_SLIDING


@pytest.mark.parametrize(("model", "seed", "index"), [("nut", 81, 28), ("support", 555, 29)])
def test_steady_sliding_is_an_equilibrium_to_the_last_bit(model, seed, index):
    """Forces over a small inertia cancel in steps: 10⁻⁴⁰ that rounding left of them pushed the motion off."""
    wide = wide_drive(model, seed, index, 1)
    automaton = find_model(model).build(wide.drive, wide.physics, "contact_sign")
    motion = follow(automaton, np.zeros(4), 1e3, max_events=10)
    assert not motion.time.size
    assert not motion.end_state.any()
    assert steady_state(automaton, np.zeros(4)).label == Attractor.STEADY_SLIDING


def test_a_motion_that_shrinks_turn_by_turn_ends_in_steady_sliding():
    """R = 0: each return is its image made smaller by 6e-12, and nothing else is ever met."""
    automaton, state = scene("nut", 81, 38, 1)
    motion = follow(automaton, state, math.inf, max_events=5000)
    assert shrinking(motion, Budget(1e5)).label == Attractor.STEADY_SLIDING
    assert steady_state(automaton, state, max_events=20_000).label == Attractor.STEADY_SLIDING
    speeds = np.abs(motion.after[1000::1000, 1])
    shrinks = np.diff(np.log(speeds)) / 500
    assert shrinks == pytest.approx(np.full(shrinks.size, -6.277e-12), rel=1e-2, abs=0)
    wide = wide_drive("nut", 81, 38, 4)
    mapped = mapper(wide.drive, wide.model, wide.physics)
    # What comes from rest touches θ′ = 0 at first: that attracts from outside only, and is no cycle.
    assert [mapped.destiny(wide.starts[k]).label for k in (2, 3)] == [Attractor.STEADY_SLIDING] * 2
    loaded, start = scene("nut", 7, 22, 0)
    assert shrinking(follow(loaded, start, math.inf, max_events=5000), Budget(1e5)) is None


@pytest.mark.parametrize("start", [1, 3])
def test_a_motion_that_dwindles_ends_in_steady_sliding(start):
    """R = 0, and the contact creeps at 0.95 in a return: its direction is attracted, but not fast enough for a proof.

    Followed for 20 000 events the motion has become a copy of itself, made smaller by the same factor again and again.
    Leaps along it came to numbers below the range of doubles, and the label was unresolved.
    """
    automaton, state = scene("threads", 83, 16, start)
    motion = follow(automaton, state, math.inf, max_events=28_000)
    later = follow(automaton, motion.end_state, math.inf, mode=motion.end_mode, max_events=4000)
    assert keeps_proportion(later)
    assert not keeps_proportion(motion)
    assert shrinking(later, Budget(1e5)) is None
    sizes = np.array([np.abs(part).max(axis=0) for part in np.array_split(later.after, 4)])
    factors = sizes[1:] / sizes[:-1]
    assert factors == pytest.approx(np.full(factors.shape, factors[0, 0]), rel=1e-3)
    assert factors[0, 0] < 0.9
    assert steady_state(automaton, state, max_events=60_000).label == Attractor.STEADY_SLIDING


def test_what_dwindles_has_shrunk_by_thirty_decades_and_shrinks_still():
    automaton, _ = scene("threads", 83, 16, 1)
    motion = follow(automaton, [0.0, 1e-4, 0.0, 1e-9], math.inf, max_events=1000)
    assert keeps_proportion(motion)
    dwindling = Dwindling(automaton)
    assert not dwindling.done(motion)
    small = replace(motion, after=motion.after * 1e-29)
    assert not dwindling.done(small)
    assert dwindling.done(replace(motion, after=motion.after * 1e-31))
    assert not dwindling.done(replace(motion, after=motion.after[::-1] * 1e-31))  # it grows
    loaded, start = scene("nut", 7, 22, 0)
    assert not Dwindling(loaded).done(follow(loaded, start, math.inf, max_events=100))


def test_what_grows_is_no_copy_of_itself():
    """R = 0: a motion that has shrunk a thousandfold seems to go on, but its direction is left by 44 in a return."""
    drive = wide_drive("support", 5, 1034, 1).drive.replace(axial_force=0.0, translation_damping=0.0)
    automaton = find_model("support").build(drive, ("bearing_friction",), "contact_sign")
    start = [3.8011315827719875e-14, 1.8512638896267501e-06, -1.5790459488004357e-12, 1.5899499569956694e-10]
    motion = follow(automaton, start, math.inf, max_events=64)
    assert shrinking(motion, Budget(1e5)) is None
    assert steady_state(automaton, start).label == Attractor.STICK_SLIP_CYCLE


def test_little_damping_is_damping():
    """A damping of less than a double's digits of the rate: other than none, it ends every oscillation."""
    automaton, state = scene("nut", 21, 25, 1)
    assert steady_state(automaton, state).label == Attractor.STEADY_SLIDING


def test_steady_sliding_under_law_plus_is_no_motion_in_the_painleve_region():
    wide = wide_drive("support", 41, 15, 2)
    assert not wide.starts[1].any()
    assert fate(wide, 1, *constants_of(wide)).name != "steady_sliding"
    automaton, state = scene("support", 41, 15, 1)
    assert steady_state(automaton, state, max_events=20_000).label != Attractor.STEADY_SLIDING


def test_the_largest_of_a_neutral_family_is_no_cycle_of_its_own():
    """Nothing damps; rests take from a motion until it only touches θ′ = 0, as the largest of undamped oscillations.

    A motion beside it rests for a while, and then keeps its own amplitudes.
    """
    automaton, state = scene("support", 7, 38, 1)
    found = steady_state(automaton, state, max_events=700_000)
    assert found.label == Attractor.NEUTRAL_FAMILY
    beside = found.orbit.start_state * [1, 1, 1, 1.01]
    motion = follow(automaton, beside, math.inf, mode=found.orbit.start_mode, max_events=40_000)
    resting = np.isin(automaton.codes[motion.mode], automaton.rest_codes)
    assert resting[:20_000].any()
    assert not resting[20_000:].any()
    sizes = [np.abs(part).max(axis=0) for part in np.array_split(motion.after, 4)[2:]]
    assert sizes[1] == pytest.approx(sizes[0], rel=1e-6)
    assert abs(sizes[1][0] / found.state[0] - 1) > 1e-5


@pytest.mark.parametrize(("index", "start"), [(27, 0), (46, 1), (51, 0)])
def test_a_motion_in_blocks_settles_by_its_rates(index, start):
    """Each block of the mode is bounded by an exponential that grows, so that the search itself finds no end."""
    automaton, state = scene("threads", 71, index, start, in_blocks=True)
    budget = Budget(300_000)
    assert follow(automaton, state, math.inf, max_events=1000, budget=budget).status == Status.WORK_SPENT
    assert budget.left == 0
    assert steady_state(automaton, state).label == Attractor.STEADY_SLIDING
    wide = wide_drive("threads", 71, index, 4)
    assert fate(wide, start, *constants_of(wide)).name in ("steady_sliding", "unknown")


@pytest.mark.parametrize(("index", "start"), [(13, 2), (17, 0)])
def test_each_event_in_blocks_has_work_of_its_own(index, start):
    wide = wide_drive("threads", 74, index, 4)
    found = mapper(wide.drive, wide.model, wide.physics).destiny(wide.starts[start])[0]
    assert found.name.lower() == fate(wide, start, *constants_of(wide)).name


def test_threads_may_grow_without_bound():
    """Friction acts against θ′, not against the sliding of the threads, and may feed the contact; 32 digits agree."""
    automaton, state = scene("threads", 71, 1, 0)
    assert steady_state(automaton, state).label == Attractor.UNBOUNDED
    wide = wide_drive("threads", 71, 1, 4)
    assert fate(wide, 0, *constants_of(wide)).name == "unbounded"


@pytest.mark.parametrize(("model", "index"), [("support", 24), ("nut", 28)])
def test_attractors_and_labels_against_long_runs(model, index):
    wide = wide_drive(model, 7, index, 2)
    found = []
    for _, ask in stages(wide, ("attractor", "label")):
        findings = ask()
        found += findings() if callable(findings) else findings
    assert len(found) == 4
    assert not [finding for finding in found if finding.verdict in BAD]
    assert [finding for finding in found if finding.verdict == "right"]


def test_a_leap_beyond_the_numbers_is_refused_without_a_warning():
    """Near a cycle with the multiplier 336 a leap over 128 returns would be 336¹²⁷ times as long as a return."""
    drive = lsvib.ThreadsDrive(
        mass=11, support_damping=2e-3, axial_force=-18.3309, contact_stiffness=1e8, contact_damping=1e8
    )
    repelling = drive.cycles().cycles[1]
    assert repelling.leading == pytest.approx(336, abs=1)
    section = ReturnSection(
        repelling.section.automaton, repelling.section.key, repelling.state, repelling.section.size, 1, repelling.period
    )
    slopes, _ = section.slopes(np.zeros(section.dimension))
    values, left = np.linalg.eig(slopes.T)
    away = np.sign(left[:, np.argmax(np.abs(values))].real)  # of all directions along it no two take from each other
    before = section.state(-np.linalg.solve(slopes, 1e-9 * away))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        leap = drift_more_states._Linear.at(section, [before, repelling.state])
        assert leap.most(7) < 6
        assert not leap.foresaw([before, repelling.state], 7)


def test_events_that_cost_more_than_was_foreseen_are_found_with_more_work():
    """A search for some events in blocks had spent its part of the budget, which was taken for all of it."""
    automaton, state = scene("threads", 72, 26, 0, in_blocks=True)
    assert steady_state(automaton, state, max_events=700_000).label == Attractor.STEADY_SLIDING


def test_a_state_on_a_surface_stays_there_where_no_time_is_quiet():
    """A quiet time of 0 s once moved the state off θ′ = 0 by rounding, and stick and release followed without end."""
    automaton, state = scene("threads", 72, 7, 0)
    assert_slides_steadily(automaton, state, 2000, 700_000)


def test_a_motion_in_blocks_is_followed_further_than_leaps_have_work():
    """The contact rattles two thousand times before it rests on one side; looking for cycles had taken all work."""
    automaton, state = scene("threads", 72, 33, 2, in_blocks=True)
    assert steady_state(automaton, state, max_events=700_000).label == Attractor.STEADY_SLIDING


def test_a_cycle_to_which_leaps_converge_is_told():
    """A contact creeps at k_c / c_c, so that the cycle attracts by 7e-9 in a return: leaps come to it alone."""
    automaton, state = scene("threads", 74, 16, 0)
    cycle = steady_state(automaton, state, max_events=700_000)
    assert cycle.label == Attractor.SPRAG_SLIP_CYCLE
    assert cycle.residual < 1e-10
    slow = np.abs(np.linalg.eigvals(automaton.tables.flow.field[0][:, :-1])).min()
    assert 1 - cycle.multiplier == pytest.approx(slow * cycle.period, rel=1e-5)


def test_leaps_that_shrink_with_the_motion_come_to_no_cycle():
    """The contact rattles ever less, by 1e-9 in a return, until N keeps its sign; its steps are below rounding then."""
    automaton, state = scene("threads", 72, 20, 2)
    assert steady_state(automaton, state, max_events=700_000).label not in CYCLES


def test_winding_up_is_a_trend():
    """The contact rattles while the screw sticks and the motor winds the coupling up: no amplitude has a trend, u has.

    The motion was once called recurrent; three other starts of the drive come to steady sliding.
    """
    automaton, start = scene("threads", 82, 50, 3)
    rattling = [2.5264e8, start[1], 8.8483e-3, -2.0991e5]
    motion = follow(automaton, rattling, math.inf, max_events=2000)
    rests = np.isin(automaton.codes[motion.mode], automaton.rest_codes)
    assert rests.any()
    assert (np.diff(motion.after[:, 0]) >= 0).all()
    assert not trend_of(motion).none


def test_a_cycle_of_thousands_of_events_is_told():
    """The screw sticks while the contact rattles 500 times, then slips: all kinds of events are frequent.

    The motion comes back to one state after each period, for good, and so does one from beside it.
    """
    automaton, state = scene("threads", 82, 3, 0)
    found = steady_state(automaton, state, max_events=700_000)
    assert found.label == Attractor.SPRAG_SLIP_CYCLE
    assert found.orbit.time.size == 3386
    assert found.residual < 1e-10
    beside, mode = found.state * [1 + 1e-3, 1, 1, 1], found.orbit.start_mode
    later = follow(automaton, beside, math.inf, mode=mode, max_events=40_000)
    key = (found.orbit.kind[-1], found.orbit.mode[-1])
    same = later.after[(later.kind == key[0]) & (later.mode == key[1])]
    gap = np.abs((same - found.state) / np.abs(found.orbit.after).max(axis=0)).max(axis=1)
    assert gap[-2 * found.returns :].min() < 1e-9


def test_a_motion_of_which_most_is_spent_in_a_mode_that_does_not_turn():
    """Under law +1 all four rates are real; the amplitudes are those of the mode that turns, and they decay as one."""
    automaton, state = scene("threads", 82, 7, 2)
    motion = follow(automaton, state, math.inf, max_events=20_000)
    shares = np.bincount(motion.mode[:-1], weights=np.diff(motion.time))
    trend = trend_of(follow(automaton, motion.end_state, math.inf, mode=motion.end_mode, max_events=8000))
    pairs = automaton.tables.flow.pairs
    assert pairs[np.argmax(shares)] == 0
    assert trend.step.size == pairs[trend.mode] == 2
    assert trend.consistent
    assert (trend.step < 0).all()


def test_parts_that_have_died_away_are_put_to_rest_after_a_leap():
    """The coupling rings by 1e-4 after each leap and hid the drift of the contact, by 1e-7 in a turn, for 5000 leaps.

    At the cycle the contact rattles without a rest, in two events, and attracts by some 1e-8 in a turn.
    """
    automaton, state = scene("threads", 82, 16, 1)
    found = steady_state(automaton, state, max_events=300_000)
    assert found.label == Attractor.OTHER_CYCLE
    assert found.orbit.time.size == 2
    assert 1e-8 < 1 - found.multiplier < 1e-7
    assert found.residual < 1e-9


def test_leaps_in_blocks_have_as_much_time_as_elsewhere():
    """The contact creeps at 80e6 1/s beside a swing that decays by 1e-8 in a turn; it settles after some leaps."""
    automaton, state = scene("threads", 81, 24, 3, in_blocks=True)
    assert steady_state(automaton, state, max_events=700_000).label == Attractor.STEADY_SLIDING


@pytest.mark.slow
def test_a_cycle_of_many_rattles_and_long_rests_is_told_at_last():
    """The motor winds the coupling up for hours while the contact rattles and comes to rest; leaps go around in it."""
    automaton, state = scene("threads", 83, 90, 0)
    found = steady_state(automaton, state, max_events=700_000)
    assert found.label == Attractor.SPRAG_SLIP_CYCLE
    assert found.orbit.time.size == 48_628
    assert found.period == pytest.approx(43130.7203, rel=1e-8)
    assert found.multiplier < 1e-6


@pytest.mark.parametrize(("index", "start"), [(71, 0), (71, 2)])
def test_hammering_beside_a_slow_swing_is_told_by_its_trend_over_whole_turns(index, start):
    """A fast vibration decays while the slide swings slowly, and hardly damped: at 1735 and 0.8 1/s, and alike."""
    automaton, state = scene("support", 83, index, start)
    assert steady_state(automaton, state, max_events=700_000).label == Attractor.STEADY_SLIDING


def small_net_force(model, translation_damping, net_force, **values):
    """Drive of Table 8.1 with a second body, whose axial force and translation damping nearly balance."""
    table = find_model("rigid").drive.of()
    nut_speed = table.pitch_radius * math.tan(table.lead_angle) * table.input_speed
    drive = find_model(model).drive.of(
        mass=1.0,
        translation_damping=translation_damping,
        axial_force=translation_damping * nut_speed + net_force,
        **values,
    )
    return find_model(model).build(drive, find_model(model).options, "contact_sign")


@pytest.mark.parametrize(
    ("model", "values"),
    [
        ("support", {"translation_damping": 300, "net_force": 1e-6, "support_damping": 6e-5}),
        ("nut", {"translation_damping": 100, "net_force": 1e-7, "support_damping": 2e-5}),
    ],
)
def test_a_cycle_that_is_small_beside_its_start_is_not_steady_sliding(model, values):
    """Steady sliding is unstable here, and in the inside of its mode; the cycle is as small as the net force."""
    second = {"screw_mass": 1.0, "support_stiffness": 1e6, "axial_support_damping": 100.0}
    second = second if model == "support" else {"nut_inertia": 1e-5, "nut_stiffness": 1e4, "nut_damping": 1e-2}
    automaton = small_net_force(model, **values, **second)
    from_afar, near = (steady_state(automaton, np.array([u, 0, 0, 0])) for u in (1e-2, 1e-9))
    assert from_afar.label is near.label is Attractor.OTHER_CYCLE
    assert from_afar.amplitude == pytest.approx(near.amplitude, rel=1e-6)


@pytest.mark.parametrize(
    ("translation_damping", "support_damping"), [(6000, 0.0018614882427863708), (10000, 0.0030938669500318004)]
)
@pytest.mark.parametrize("net_force", [1e-9, 1e-12])
def test_what_has_shrunk_by_ten_decades_does_not_repeat(translation_damping, support_damping, net_force):
    """Steady sliding is stable by a millionth; motions fall so far in a few events that they seem to stand."""
    second = {"screw_mass": 1.0, "support_stiffness": 1e8, "axial_support_damping": 3e3}
    automaton = small_net_force("support", translation_damping, net_force, support_damping=support_damping, **second)
    assert steady_state(automaton, np.array([1e-2, 0, 0, 0])).label is Attractor.STEADY_SLIDING


@pytest.mark.parametrize(("seed", "index", "start"), [(83, 4, 0), (86, 30, 1)])
def test_what_has_died_away_to_the_smallest_doubles_slides_steadily(seed, index, start):
    """A quiet time ends at 1e-321, or at zero, where N = 0 for good: searches took the label's work, or NaN seconds."""
    wide = wide_drive("threads", seed, index, 4)
    found = mapper(wide.drive, wide.model, wide.physics).destiny(wide.starts[start])
    assert found.label is Attractor.STEADY_SLIDING
