"""Attractors and maps of rigid drives far from the chapter's: each of them once crashed, hung or was labelled wrongly.

What becomes of them is told by the theory in docs/attraction.md, or by following them for long on the engine.
"""

import math

import numpy as np
import pytest
from judge.fate import fate
from judge.second_opinions import watch
from references.wide_drives import wide_drive

from lsvib.basins.mapper import mapper
from lsvib.basins.section_labels import Sections
from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import rigid_automaton
from lsvib.engine.kernels.status import Status
from lsvib.engine.motion import follow

UNDAMPED = RigidParameters.of(support_damping=0.0)
STRONG_NEGATIVE_DAMPING = RigidParameters.of(
    pitch_radius=0.025277447719872562, lead_angle=0.06068182414661292, friction_coefficient=0.8767876250636453,
    mass=0.010363976111208168, screw_inertia=3.1122226256607436e-06, coupling_stiffness=0.5772976146323651,
    support_damping=3.743652031421517e-07, translation_damping=69630.40377620011, input_speed=0.4514084201824602,
    axial_force=48.271688806499085,
)  # fmt: skip
NO_FORCE_NO_DAMPING = RigidParameters.of(
    pitch_radius=0.013383268413967779, lead_angle=0.3246916849796429, screw_inertia=3.1540557934364716e-08,
    coupling_stiffness=10115.4324215604, support_damping=0.0, friction_coefficient=0.3121744881845673,
    input_speed=-0.6086988519313125, mass=0.017259265280124902, axial_force=0.0,
)  # fmt: skip
SLOW_SPIRAL = RigidParameters.of(  # both laws change an oscillation by 1e-8 of itself in a turn, one enlarges it
    pitch_radius=0.0015375713158014127, lead_angle=0.23817068334213254, screw_inertia=1.5034256552156315e-07,
    coupling_stiffness=952.3260148012222, support_damping=0.0, friction_coefficient=0.5039129038342504,
    input_speed=19.144745701660646, mass=0.3888375485255668, translation_damping=0.0013753717408117418,
    axial_force=0.0,
)  # fmt: skip
MANY_SEIZURES = RigidParameters.of(  # overdamped: a seizure moves it by 1e-8 of the way to a cycle of seizures
    pitch_radius=0.00916201601142274, lead_angle=0.10102236505075994, screw_inertia=1.1554331776008608e-06,
    coupling_stiffness=0.0066264878061496725, support_damping=86.32442497660541,
    friction_coefficient=0.14722951108552843, input_speed=0.1759704536546235, mass=585.6016916091033,
    translation_damping=0.004399651580121414, axial_force=5.008e-07,
)  # fmt: skip


def test_motion_that_only_touches_is_one_of_a_neutral_family():
    """c = c_x = 0: every motion ends in an oscillation that does not pass θ′ = 0; the largest one touches it."""
    for start in ((0.1, 0.0), (1e-3, 0.0), (3.0, 200.0), (0.0, -40.0)):
        found = steady_state(rigid_automaton(UNDAMPED), start)
        assert found.label == Attractor.NEUTRAL_FAMILY
        assert found.multiplier == 1.0
        assert np.abs(found.orbit.end_state - found.state).max() <= 1e-9 * np.abs(found.orbit.after).max(initial=40.0)


def test_guard_that_falls_for_ever_is_not_asked_at_infinity():
    """The guard θ′ falls along two growing rates and has no minimum; the motion rests after 5 µs, then slides."""
    automaton = rigid_automaton(STRONG_NEGATIVE_DAMPING)
    start = (-0.002431625983179918, -0.010582909482192133)
    short, endless = (follow(automaton, start, t, max_events=3) for t in (10.0, math.inf))
    assert short.time.tolist() == endless.time.tolist()
    assert short.kind.tolist() == endless.kind.tolist()
    assert steady_state(automaton, start).label == Attractor.STEADY_SLIDING


def test_events_that_accumulate_in_the_corner_go_on():
    """R = c = c_x = 0: reversals shrink towards the corner of θ′ = 0 and Q = 0 by a constant factor, for ever."""
    automaton = rigid_automaton(NO_FORCE_NO_DAMPING)
    start = (-4.418904915675089e-05, -17.831033197192436)
    assert follow(automaton, start, 1e-2).status == Status.TIME_REACHED
    assert steady_state(automaton, start).label == Attractor.NEUTRAL_FAMILY


@pytest.mark.parametrize("start", [(-0.00029198944436617974, 191.38482947857693), (1e-4, -30.0), (1e-9, 18.0)])
def test_slow_spiral_is_leapt_over(start):
    assert steady_state(rigid_automaton(SLOW_SPIRAL), start).label == Attractor.STEADY_SLIDING


@pytest.mark.parametrize("place", [-1e2, -1e3, -1e6, -1e8])
def test_leaps_do_not_pass_over_a_cycle(place):
    """The drift comes from any distance to the same cycle of seizures, at u = −93 rad."""
    found = steady_state(rigid_automaton(MANY_SEIZURES), (place, -MANY_SEIZURES.input_speed))
    assert found.label == Attractor.SPRAG_SLIP_CYCLE
    assert found.state[0] == pytest.approx(-93.1, rel=2e-2)


@pytest.mark.parametrize(("index", "start"), [(115, 2), (357, 3), (545, 4)])
def test_a_cycle_that_attracts_by_less_than_rounding_shows(index, start):
    """Damping takes 1e-9 to 1e-12 of a motion in a turn: P(y) = y is lost in rounding, but both sides drift inwards."""
    wide = wide_drive("rigid", 9101, index, 16)
    automaton = rigid_automaton(wide.drive)
    found = steady_state(automaton, wide.starts[start])
    seen = fate(watch.constants(dict(wide.drive)), *wide.starts[start])
    assert found.label == Attractor.OTHER_CYCLE
    assert seen.name == "other_cycle"
    assert 0 <= found.multiplier < 1
    for part in (0.5, 0.9, 1.1):  # motions from both sides end on it
        other = steady_state(automaton, part * found.state)
        assert other.label == Attractor.OTHER_CYCLE
        assert other.amplitude == pytest.approx(found.amplitude, rel=1e-2)


@pytest.mark.parametrize(
    ("seed", "index", "start"),
    [
        (9901, 1221, 6),  # passes next to a corner, where a section seemed to be a point and any return a cycle
        (9901, 1410, 0),  # shrinks by 5e-15 in a turn, over ten decades
        (9901, 8711, 0),  # shrinks to a cycle of seizures that attracts by 1e-13 in a turn
        (9901, 750, 8),  # ends in few returns, of which the last one does not come back
        (9701, 657, 3),  # drifts past u = 0 to a cycle of seizures on the other side
        (9911, 2482, 39),  # beyond u = 0 the line is crossed the other way, where a return seemed to end a cycle
    ],
)
def test_slow_drifts_of_random_drives_are_followed_to_their_end(seed, index, start):
    """Each was told as a cycle that is none, or not told, or not within seconds; the judge of fates knows most ends."""
    wide = wide_drive("rigid", seed, index, start + 1)
    automaton = rigid_automaton(wide.drive)
    found = steady_state(automaton, wide.starts[start])
    assert found.label == (Attractor.SPRAG_SLIP_CYCLE if index in (657, 8711) else Attractor.STEADY_SLIDING)
    seen = fate(watch.constants(dict(wide.drive)), *wide.starts[start])
    assert seen.name in ("unknown" if index == 1410 else found.label.name.lower(), found.label.name.lower())


@pytest.mark.parametrize(
    ("size", "start"),
    [(1e11, (-61127695882523.484, -202243017875176.22)), (1e10, (2650849793819.319, 8958888571034.523))],
)
def test_a_drift_over_many_decades_ends_in_no_cycle(size, start):
    """A line that was laid through a place far nearer to zero lay beside its surface by the rounding of the way."""
    automaton = rigid_automaton(wide_drive("rigid", 1201, 62, 1).drive)
    found = steady_state(automaton, start)
    assert found.label in (Attractor.UNRESOLVED, Attractor.STEADY_SLIDING)
    near = steady_state(automaton, np.array(start) / size)
    assert near.label == Attractor.STEADY_SLIDING


def test_what_is_learned_beside_a_repelling_cycle_is_not_the_label_inside():
    """A piece ends at the cycle, and a billionth beside it motions drift away from it, to another end."""
    drive = wide_drive("rigid", 1202, 3727, 1).drive
    automaton = rigid_automaton(drive)
    sections = Sections(automaton, rounding=False)
    absorbed = list(zip(sections.courses.absorbing, sections.courses.absorbed, strict=False))
    assert len(absorbed) > 4
    for (mode, surface, low, high), label in absorbed:
        section = next(one for one in sections.courses.sections if (one.mode, one.surface) == (mode, surface))
        far = 1e3 * sections.size[section.free]
        middle = 0.5 * (max(low, -far) + min(high, far))
        found = steady_state(automaton, sections.courses.point(section, middle), mode=section.mode)
        assert found.label in (label, Attractor.UNRESOLVED)


def test_energy_is_bounded_where_rounding_hides_the_next_event():
    """Γ₊ is 5e-10 of Γ₋: the screw stops after 2e-11 s, from a start on Q = 0, in a rest that rounding ends at once."""
    drive = RigidParameters.of(
        pitch_radius=0.008578100478089172, lead_angle=0.25857224097106224, screw_inertia=2.1707834949889458e-06,
        coupling_stiffness=0.05803284858088003, support_damping=0.0, friction_coefficient=0.354988819988084,
        input_speed=2.9026515097964833, mass=1.3482396158919576, translation_damping=8969.719237505575,
        axial_force=8633.899125150927,
    )  # fmt: skip
    automaton, start = rigid_automaton(drive), (104.7931922251995, 421.0936424124801)
    assert automaton.passive
    for mode in (None, 1):
        assert steady_state(automaton, start, mode=mode).label in (Attractor.UNRESOLVED, Attractor.STICK_SLIP_CYCLE)


@pytest.mark.parametrize(("part", "start"), [(0.3, 1), (1e-3, 0), (1e-6, 2)])
def test_what_attracts_from_one_side_only_is_no_cycle(part, start):
    """Outside the largest orbit that touches θ′ = 0 motions shrink; inside, too, by less than 1e-15 in a turn."""
    wide = wide_drive("rigid", 9901, 1410, start + 1)
    drive = wide.drive.replace(translation_damping=part * wide.drive.translation_damping)
    found = steady_state(rigid_automaton(drive), wide.starts[start])
    assert found.label in (Attractor.UNRESOLVED, Attractor.STEADY_SLIDING)


@pytest.mark.parametrize("damping", [1e-14, 1e-11])
def test_a_damping_below_rounding_is_damping(damping):
    drive = UNDAMPED.replace(translation_damping=damping, axial_force=-10.0)
    assert steady_state(rigid_automaton(drive), (1e-3, 0.0)).label == Attractor.STEADY_SLIDING
    assert mapper(drive).labels_of([1e-3], [0.0]) == [Attractor.STEADY_SLIDING]


def test_a_table_of_slow_drifts_takes_little_work():
    """The returns shrink by 5e-15 in a turn: each of nine searches took three seconds, now a tenth."""
    wide = wide_drive("rigid", 9901, 1410, 16)
    mapped = mapper(wide.drive)
    assert mapped.sections.complete
    assert (mapped.labels_of(*np.array(wide.starts).T) == Attractor.STEADY_SLIDING).all()


@pytest.mark.slow
def test_starts_beyond_the_work_of_the_table_are_followed():
    """Crowds of narrow pieces take all work of the table of sections; rest or settling follows soon nevertheless."""
    wide = wide_drive("rigid", 9101, 32, 16)
    mapped = mapper(wide.drive)
    assert not mapped.sections.complete
    labels = mapped.labels_of(*np.array(wide.starts).T)
    assert (labels != Attractor.UNRESOLVED).all()
    assert [steady_state(mapped.automaton, start).label for start in wide.starts] == labels.tolist()


def test_motion_from_beside_a_cycle_settles():
    found = steady_state(rigid_automaton(MANY_SEIZURES), (-31.0, -MANY_SEIZURES.input_speed))
    assert found.label == Attractor.STEADY_SLIDING


@pytest.mark.parametrize("mass", [1.0, 8.0, 10.0])
def test_drive_that_enlarges_no_area_has_one_label(mass):
    """Γ₊ > 0 and C_s > 0: steady sliding is globally stable; the map knows it without a search."""
    drive = RigidParameters.of(mass=mass, support_damping=1e-9, axial_force=-3.0)
    automaton = rigid_automaton(drive)
    assert automaton.contracts
    u, w = np.random.default_rng(5).normal(size=(2, 50)) * np.array([[0.3], [150.0]])
    assert (mapper(drive).labels_of(u, w) == Attractor.STEADY_SLIDING).all()


@pytest.mark.parametrize(
    "values",
    [
        {"mass": 1e-18},  # Q hardly depends on the state: the square of its row underflowed
        {"mass": 1e-18, "friction_coefficient": 0.0975, "screw_inertia": 743.0},  # or on nothing at all
        {"lead_angle": 1e-6, "axial_force": -1e12, "mass": 7e-4},
        {"mass": 1e-18, "lead_angle": 1e-6, "coupling_stiffness": 1e-21, "axial_force": 3e-3},
        {"coupling_stiffness": 1e-21, "input_speed": 1e9, "axial_force": -1e-18},  # lengths beyond all numbers
        {"lead_angle": 1.5, "friction_coefficient": 0.07, "support_damping": 1e-30},  # a rate beyond 1e154 1/s
        {"lead_angle": 1e-6, "translation_damping": 1e15, "mass": 7e-4, "axial_force": -1e-6},
    ],
)
def test_values_near_the_ends_of_the_range_of_doubles(values):
    """Each ended in a warning of numpy, most of them with wrong lengths of the drive; one starts where all agree."""
    drive = RigidParameters.of(**values)
    automaton, speed = rigid_automaton(drive), drive.input_speed
    starts = [(0.01, 0.1 * speed), (-1.0, -speed), (-0.3, 0.5 * speed)]
    labels = mapper(drive).labels_of(*np.array(starts).T)
    for start, label in zip(starts, labels, strict=True):
        assert label in (steady_state(automaton, start).label, Attractor.UNRESOLVED)


def _judged(seed: int, drives: int) -> list[str]:
    """What attractors and labels of random drives say against what a watcher sees; the disagreements."""
    wrong = []
    for index in range(drives):
        case = wide_drive("rigid", seed, index, 4)
        mapped, constants = mapper(case.drive), watch.constants(dict(case.drive))
        labels = mapped.labels_of(*np.array(case.starts).T)
        for start, label in zip(case.starts, labels, strict=True):
            seen = fate(constants, *start).name
            found = steady_state(mapped.automaton, start).label
            if found != label or (seen != "unknown" and seen != found.name.lower()):
                wrong.append(f"{index} {start}: {found.name}, map {Attractor(int(label)).name}, seen {seen}")
    return wrong


@pytest.mark.slow
def test_labels_of_random_drives():
    """Over the full ranges; an undamped orbit that touches θ′ = 0 is steady to the watcher or not, by a digit."""
    assert _judged(31, 60) == []
