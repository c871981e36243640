"""Motions of random drives over the full ranges: the watcher, strides and the engine against the reference."""

from dataclasses import replace

import numpy as np
import pytest
from judge import command, excuses, judges
from judge.linear_judge import rates
from judge.second_opinions import watch
from judge.second_paths import case_ladders, quick_path, strides_path, watched_path
from judge.wide_drives import wide_drive

from benchmarks.record import Record
from references import rigid_digits
from benchmarks.sweeps import case_judge
from benchmarks.sweeps.paths import MOST_EVENTS, engine_path, exact_path
from benchmarks.sweeps.paths import automaton as built
from lsvib.drives.parameters import RigidParameters
from lsvib.drives.rigid import EventKind, rigid_automaton
from lsvib.engine.motion import follow

SEED = 7


def test_the_watcher_has_the_events_of_the_reference():
    """The compiled closed forms agree with 40 digits over the full ranges, or say that they cannot tell."""
    compared = 0
    for index in range(40):
        wide = wide_drive("rigid", SEED, index, 1)
        case = judges.motion_case(wide, 0)
        exact = exact_path(case, wide.drive, case.start)
        watched = exact and watched_path(case, watch.constants(dict(wide.drive)), exact.size)
        if watched is None:
            continue
        compared += 1
        alike = excuses.agree(watched, exact, case) or case_judge.agree_but_corners(watched, exact, case)
        assert alike, (index, watched, exact)
    assert compared >= 36


@pytest.mark.parametrize("model", [pytest.param("threads", marks=pytest.mark.long), "support", "nut"])
def test_strides_have_the_events_of_the_reference(model):
    """Strides by propagators agree with 40 digits over the full ranges, or say that they cannot tell."""
    compared = 0
    for index in range(4):
        case = judges.four_cases(wide_drive(model, SEED, index, 1))[0]
        exact = exact_path(case, case.drive, case.start)
        strides = exact and quick_path(case, case.drive, case.start)
        if strides is None:
            continue
        compared += 1
        assert excuses.agree(strides, exact, case), (index, strides, exact)
    assert compared >= 3


def test_rates_of_rigid_threads_near_those_of_the_rigid_drive():
    """Very stiff and hardly damped threads have the two rates of the rigid drive among their four."""
    drive = {"mass": 5.0, "translation_damping": 100.0, "support_damping": 1e-3}
    rigid = wide_drive("rigid", SEED, 0, 1)._replace(drive=RigidParameters.of(drive))
    threads = wide_drive("threads", SEED, 0, 1)
    stiff = type(threads.drive).of({**drive, "contact_stiffness": 1e15, "contact_damping": 0.0})
    slow = sorted(rates(threads._replace(drive=stiff)), key=abs)[:2]
    for rate in rates(rigid):
        assert min(abs(rate - x) for x in slow) < 1e-6 * abs(rate)


def test_events_at_the_corner_need_no_reference(monkeypatch):
    """With R = 0 seizures accumulate at θ′ = 0, Q = 0 and their number is free; other events and the end are not."""
    wide = wide_drive("rigid", 1, 335, 16)
    constants, case = watch.constants(dict(wide.drive)), judges.motion_case(wide, 10)
    monkeypatch.setattr(judges.paths, "exact_path", None)  # not called
    assert judges._motion(wide, 10, constants, rigid_automaton(wide.drive)).verdict == judges.CORNER
    path = engine_path(follow(rigid_automaton(wide.drive), case.start, case.duration), case)
    other = watched_path(case, constants, path.size)
    assert path.kinds != other.kinds
    assert excuses.at_corner(path, other, case)
    fewer = replace(path, kinds=path.kinds[:-2] + path.kinds[-1:], times=np.delete(path.times, -2))
    first = replace(path, times=path.times + np.eye(path.times.size)[0] * 1e-6 * case.duration)
    elsewhere = replace(path, end=path.end + 1e-8 * path.size)
    for spoilt in (fewer, first, elsewhere):
        assert not excuses.at_corner(spoilt, other, case)
    loaded = case._replace(drive=RigidParameters.of({**dict(case.drive), "axial_force": 1.0}))
    assert not excuses.at_corner(path, other, loaded)


# Drive and start of seed 9601 with R = 0 and Γ₊ < 0: motions that come to the corner θ′ = 0, Q = 0.
CORNERED = [
    (17192, 20), (17671, 4), (19127, 7), (21395, 6), (27130, 14), (27130, 8), (3421, 0), (3421, 3), (3421, 7)
]  # fmt: skip


@pytest.mark.parametrize(("index", "start"), CORNERED)
def test_seizures_accumulate_at_the_corner_and_motion_leaves_it(index, start):
    """Few events, then a release in the very corner, and the next event only much later, where the watcher has it."""
    wide = wide_drive("rigid", 9601, index, 32)
    automaton, case = rigid_automaton(wide.drive), judges.motion_case(wide, start)
    assert judges._motion(wide, start, watch.constants(dict(wide.drive)), automaton).verdict in judges.GOOD
    motion = follow(automaton, case.start, case.duration)
    release = motion.kind.tolist().index(EventKind.RELEASE)
    assert release < 6
    corner = watch.constants(dict(wide.drive)).released, -wide.drive.input_speed
    assert motion.after[release] == pytest.approx(corner, rel=1e-15)
    assert motion.time[release + 1] - motion.time[release] > 1e-2 * case.duration


def test_distances_from_the_corner_are_squared():
    """z → (c − I c_x / m) z² / (2 Γ₋ |Ω|) from seizure to seizure: infinitely many in finite time, by 40 digits."""
    wide = wide_drive("rigid", 9601, 17192, 32)
    case, drive = judges.motion_case(wide, 20), wide.drive
    truth = rigid_digits.simulate(dict(drive), *case.start, case.duration, max_events=4)
    first, *further = (float(event.u_before + truth.drive.z0) for event in truth.events[1:])
    damping = drive.support_damping - drive.screw_inertia * drive.translation_damping / drive.mass
    factor = damping / (2 * float(truth.drive.Gamma(-1)) * drive.input_speed)
    for z in further:
        assert z == pytest.approx(factor * first**2, rel=1e-6)
        first = z


@pytest.mark.parametrize("force", [1e-18, -1e-17, 1e-15])
def test_a_band_narrower_than_rounding_is_a_corner(force):
    """With R below rounding the end of the band is one place with Q = 0, and motions leave it as without R."""
    wide = wide_drive("rigid", 9601, 27130, 32)
    case = judges.motion_case(wide, 8)
    without = follow(rigid_automaton(wide.drive), case.start, case.duration)
    drive = RigidParameters.of({**dict(wide.drive), "axial_force": force})
    motion = follow(rigid_automaton(drive), case.start, case.duration)
    assert motion.time.size < 40
    assert motion.end_state == pytest.approx(without.end_state, rel=1e-9)


@pytest.mark.parametrize(
    ("seed", "index", "start"),
    [(9501, 8279, 17), (9501, 11789, 6), (9911, 6857, 47), (9951, 3890, 85), (9951, 4272, 82)],
)
def test_a_start_on_zero_to_rounding_is_excused(seed, index, start):
    """Q is zero to rounding, and passes zero by less: digits decide whether and when, which not all moves show."""
    wide = wide_drive("rigid", seed, index, start + 1)
    found = judges._motion(wide, start, watch.constants(dict(wide.drive)), rigid_automaton(wide.drive))
    assert found.verdict in (judges.BEYOND_INPUT, judges.CORNER)


def test_a_start_on_zero_excuses_nothing_that_follows():
    wide = wide_drive("rigid", 9951, 3890, 86)
    case = judges.motion_case(wide, 85)
    path = engine_path(follow(built(case), case.start, case.duration), case)
    exact = exact_path(case, wide.drive, case.start)
    assert path.kinds[1:] == exact.kinds
    assert excuses.same_after_an_instant(path, exact, case)
    assert not excuses.same_after_an_instant(path, replace(exact, kinds=["seizure", *exact.kinds[1:]]), case)
    assert not excuses.same_after_an_instant(path, replace(exact, times=exact.times + 1e-6 * case.duration), case)
    beside = case._replace(start=(case.start[0] * (1 + 1e-13), case.start[1]))
    assert not excuses.same_after_an_instant(path, exact, beside)


def test_touches_in_every_turn_may_be_told_or_not_where_they_fill_the_list():
    """Without damping this motion comes back to θ′ = 0 in every turn; 40 digits tell more of these touches."""
    wide = wide_drive("rigid", 9951, 282, 11)
    case = judges.motion_case(wide, 10)
    path = engine_path(follow(built(case), case.start, case.duration, max_events=MOST_EVENTS), case)
    exact = exact_path(case, wide.drive, case.start)
    assert len(path.kinds) > len(exact.kinds) > MOST_EVENTS // 2
    assert excuses.same_but_touches(path, exact, case)
    assert not excuses.same_but_touches(path, replace(exact, kinds=["seizure", *exact.kinds[1:]]), case)
    assert not excuses.same_but_touches(path, replace(exact, times=exact.times + 1e-6 * case.duration), case)
    damped = case._replace(drive=wide.drive.replace(support_damping=1e-9))
    assert not excuses.same_but_touches(path, exact, damped)


def test_touches_of_an_undamped_contact_may_be_told_or_not():
    """From u = w = e = v = 0 N comes back to zero after each turn, also where the motion ends; 32 digits tell it."""
    wide = wide_drive("threads", 9961, 277, 13)
    case = judges.four_cases(wide)[12]
    assert not any(case.start)
    path = engine_path(follow(built(case), case.start, case.duration, max_events=MOST_EVENTS), case)
    other = strides_path(case, case_ladders(case, case.duration))
    assert len(other.kinds) > len(path.kinds)
    assert excuses.touches_only(path, other, case)
    assert not excuses.touches_only(path, replace(other, kinds=["stick", *other.kinds[1:]]), case)
    assert not excuses.touches_only(path, replace(other, end=other.end + 1e-6 * other.size), case)
    damped = case._replace(drive=wide.drive.replace(contact_damping=1e-9))
    assert not excuses.touches_only(path, other, damped)


@pytest.mark.parametrize(("model", "index"), [("threads", 25), ("nut", 58), ("nut", 63)])
def test_a_surface_is_met_by_the_coordinate_that_moves_it_most(model, index):
    """The rounding of a large contact force is many digits of the angle where the coupling is soft: 1e-7 of it."""
    wide = wide_drive(model, 11, index, command.STARTS)
    for k, (_, ask) in enumerate(judges.stages(wide, ["motion"])):
        assert ask() == [judges.Finding(judges.RIGHT, k)]


@pytest.mark.parametrize(
    ("drive", "start"),
    [(("threads", 9802, 0), 0), (("nut", 9802, 1), 12), (("threads", 9901, 48), 11), (("nut", 9901, 163), 33)],
)
def test_strides_decide_without_the_reference(drive, start):
    """N = 0 where N is one coordinate, up to its own last digits; events within the last stretch; θ′ = 0 is touched."""
    wide = wide_drive(*drive, start + 1)
    _, ask = list(judges.stages(wide, ["motion"]))[start]
    assert ask() == [judges.Finding(judges.RIGHT, start)]


@pytest.mark.parametrize(
    ("model", "index", "start"),
    [
        ("support", 72, 13),  # x′ is 1e-10 of r_m tan λ Ω, and a heavy nut hardly changes it
        ("support", 291, 125),  # k_1 y + c_1 v is 1e-16 of its terms as the support creeps back
        ("support", 725, 119),  # both
        ("nut", 102, 110),  # the nut gets the speed of the screw, 1e-9 Ω, where slip begins
        ("nut", 112, 12),
        ("threads", 432, 83),  # slip ends soon after N has changed its sign
        ("nut", 163, 122),  # the screw gets the speed of the nut, 1e-9 Ω, where slip ends
        ("support", 678, 87),  # the nut has crept to within e⁻³³ of its place, and falls from there by its bend alone
        ("support", 678, 119),
        ("nut", 198, 80),  # what dies away is 1e11 times what N is where it falls through zero
        ("nut", 180, 110),  # slip ends 4e-20 s before the screw stops; both speeds are rounding of their parts
    ],
)
def test_speeds_that_a_state_does_not_hold_are_carried(model, index, start):
    """w = θ′ − Ω holds few digits of a small θ′, and events were late by 1e-9 to 4e-8 of the duration."""
    wide = wide_drive(model, 9901, index, start + 1)
    _, ask = list(judges.stages(wide, ["motion"]))[start]
    assert ask() == [judges.Finding(judges.RIGHT, start)]


def test_corners_have_the_times_of_their_events():
    """Events at once may be told in many ways, but all others are told when they are."""
    case = judges.motion_case(wide_drive("rigid", SEED, 0, 1), 0)
    times = np.array([0.2, 0.4, 0.4 + 1e-8, 0.7]) * case.duration
    path = Record(["stick", "release", "stick", "release"], times, np.ones(2), np.ones(2))
    other = replace(path, kinds=["stick", "reversal", "release"], times=times[[0, 2, 3]])
    assert case_judge.agree_but_corners(path, other, case)
    for place in range(3):
        late = replace(other, times=other.times + np.eye(3)[place] * 2e-6 * case.duration)
        assert not case_judge.agree_but_corners(path, late, case)
    late = replace(other, times=other.times + np.eye(3)[0] * 2e-9 * case.duration)
    assert not case_judge.agree_but_corners(path, late, case)


def test_a_sensitive_event_excuses_nothing_after_it(monkeypatch):
    """The last places decide on the first event (9501/8279); what follows must be that of such an input."""
    wide = wide_drive("rigid", 9501, 8279, 32)
    case, honest = judges.motion_case(wide, 17), case_judge.engine_path

    def verdict(spoil) -> case_judge.Verdict:
        monkeypatch.setattr(case_judge, "engine_path", lambda motion, of: spoil(honest(motion, of)))
        return case_judge.judge(case, np.random.default_rng(0), by_reference=True).verdict

    assert verdict(lambda path: path) is case_judge.Verdict.BEYOND_INPUT
    assert verdict(lambda path: replace(path, kinds=[*path.kinds[:-1], "seizure"])) is case_judge.Verdict.WRONG
    late = verdict(lambda path: replace(path, times=path.times + 1e-5 * case.duration * (path.times == path.times[-1])))
    assert late in (case_judge.Verdict.WRONG, case_judge.Verdict.INACCURATE)


def test_a_slip_that_died_away_is_a_corner():
    """A slip of 1e-25 may be told as rest if both sides end alike; the engine has it as slip."""
    wide = wide_drive("nut", 9901, 46, 73)
    _, ask = list(judges.stages(wide, ["motion"]))[72]
    assert ask() == [judges.Finding(judges.RIGHT, 72)]
    case = judges.four_cases(wide)[72]
    exact = exact_path(case, wide.drive, case.start)
    middle = (exact.times[1] + exact.times[2]) / 2
    times = np.insert(exact.times, 2, middle)

    def resting(kind: str) -> Record:
        return replace(exact, kinds=[*exact.kinds[:2], kind, "rest_screw_backward", *exact.kinds[3:]], times=times)

    assert excuses.dies_away(resting("rest_screw_held"), exact, case)
    assert not excuses.dies_away(resting("slip_forward_negative_screw_held"), exact, case)
    late = replace(resting("rest_screw_held"), times=times + 2e-9 * case.duration * (times == times[1]))
    assert not excuses.dies_away(late, exact, case)


@pytest.mark.parametrize(("index", "start"), [(22, 1), (38, 3)])
def test_an_equilibrium_without_contact_force_lasts(index, start):
    """R = 0 without drag: the equilibrium lies on N = 0, where infinitely many events seemed to accumulate."""
    wide = wide_drive("support", 11, index, command.STARTS)
    assert not wide.starts[start].any()
    _, ask = list(judges.stages(wide, ["motion"]))[start]
    assert ask() == [judges.Finding(judges.RIGHT, start)]


@pytest.mark.parametrize(
    ("model", "index", "start"),
    [
        ("nut", 497, 2),  # without a load: seizures accumulate at the corner where N and the speed of slip are zero
        ("nut", 753, 9),
        ("nut", 637, 47),  # a slip that dies away, at 2e6 1/s for a minute
        ("nut", 646, 14),  # a screw that was released from rest stops for no time once in each turn
        ("nut", 421, 30),
        ("support", 737, 29),  # a nut that comes to rest below the last digit
        ("support", 748, 72),
        ("support", 678, 28),  # a nut that creeps to its place by e⁻¹⁰⁸ before slip begins
        ("support", 678, 88),
        ("support", 737, 36),  # a nut that creeps for ever to the place where its friction just suffices
        ("support", 737, 45),
        ("support", 737, 61),  # the same before slip begins
        ("support", 737, 75),
        ("support", 747, 53),
        ("support", 395, 119),
        ("support", 472, 4),  # steady sliding that repels
    ],
)
def test_motions_that_were_undecided_or_called_wrong(model, index, start):
    """The reference decides at corners, at touches and where a slip dies away, and the program is right there."""
    wide = wide_drive(model, 9901, index, 128)
    case = judges.four_cases(wide)[start]
    exact = exact_path(case, wide.drive, case.start)
    assert exact is not None
    automaton = built(case)
    path = engine_path(follow(automaton, case.start, case.duration, max_events=MOST_EVENTS), case)
    corners = (case_judge.agree_but_corners, excuses.same_corners, excuses.touches_only, excuses.dies_away)
    assert any(alike(path, exact, case) for alike in (excuses.agree, *corners)), (path, exact)
