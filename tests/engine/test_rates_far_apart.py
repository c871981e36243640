"""Drives of four states whose rates lie up to thirty decades apart: each was refused, or lost digits, once.

The motions are held against the references with 40 digits, in which nothing is far apart.
"""

import math

import numpy as np
import pytest
from judge.judges import four_case
from judge.linear_judge import rates
from judge.second_paths import quick_path
from references.wide_drives import wide_drive
from mpmath import mp

from benchmarks.record import Verdict
from benchmarks.sweeps.case_judge import judge
from benchmarks.sweeps.families import Case, CaseFamily, CaseGroup
from benchmarks.sweeps.paths import automaton
from lsvib.cycles.attractors import Attractor, steady_state
from lsvib.drives.parameters import NutParameters, RigidParameters, ThreadsParameters
from lsvib.drives.registry import find_model
from lsvib.drives.rigid import rigid_automaton
from lsvib.drives.threads import seated_state, threads_automaton
from lsvib.engine.exact.flow_choice import flow_of, linear_mode
from lsvib.engine.kernels import dispatch
from lsvib.engine.kernels.status import GRAZE_KIND, Status
from lsvib.engine.motion import follow

CASES = {
    "seated where a growing rate of 1e16 is": (
        ThreadsParameters,
        dict(
            pitch_radius=0.03580220412136874,
            lead_angle=0.016691827686857147,
            screw_inertia=1.771790855536558e-09,
            coupling_stiffness=0.19091615618388189,
            support_damping=1.3282687534785524e-08,
            friction_coefficient=0.8019265178324269,
            input_speed=395.8879787733986,
            mass=7602.243236234851,
            translation_damping=45.33324834610233,
            axial_force=0.0018066940724057092,
            contact_stiffness=5640955.099254641,
            contact_damping=1323268581723.0027,
        ),
        (0.007018712498912743, -298.7491772305621, -1.9274870108271627e-06, 0.0),
        0.0006911857357050064,
    ),
    "seated far beyond what the motion moves": (
        ThreadsParameters,
        dict(
            pitch_radius=0.0020530629142554977,
            lead_angle=0.313537999425142,
            screw_inertia=9.384885904607605e-07,
            coupling_stiffness=48725.60247226365,
            support_damping=4.563561823226057e-09,
            friction_coefficient=0.011721957852164192,
            input_speed=-16.722228137774838,
            mass=10.235452343230886,
            translation_damping=2843.0701709346904,
            axial_force=-18314.616465987896,
            contact_stiffness=26075.4297153462,
            contact_damping=4020803271847.8735,
        ),
        (2.6860832350466475e-05, 0.8227779054574539, -0.7719336513360673, 0.0),
        3.6639328698016375e-05,
    ),
    "fast pair beside 25 1/s": (
        ThreadsParameters,
        dict(
            pitch_radius=0.006755758541163216,
            lead_angle=0.1793890273708749,
            screw_inertia=7.138531890632822e-07,
            coupling_stiffness=202.05156006164407,
            support_damping=8.08342807036829,
            friction_coefficient=0.004302711918500923,
            input_speed=-330.8413241804521,
            mass=40.92583891715188,
            translation_damping=0.0,
            axial_force=0.0025618832289997775,
            contact_stiffness=20038852124987.434,
            contact_damping=0.0,
        ),
        (-0.0008383644488822559, 264.0728291008666, 6.61276992910818e-15, -0.04266155385138459),
        0.0011077110761301555,
    ),
    "rest with 1e-5 beside 1e6": (
        ThreadsParameters,
        dict(
            pitch_radius=0.020175060478720315,
            lead_angle=0.12175106635658306,
            screw_inertia=1.5284179989589013e-05,
            coupling_stiffness=3071.4716866056033,
            support_damping=1.4649361570370146e-08,
            friction_coefficient=0.7321149416510724,
            input_speed=-1472.9526424960375,
            mass=65.2852336040702,
            translation_damping=607486.8194860457,
            axial_force=5.63694609076885,
            contact_stiffness=1005.5062917743654,
            contact_damping=84980400.88018365,
        ),
        (-8.377992617073266, 7508.71476394492, 0.018466171983363904, 1.3739475191105417),
        0.000316101570191887,
    ),
    "rest with 1e-8 beside 1e9": (
        ThreadsParameters,
        dict(
            pitch_radius=0.010774486211286198,
            lead_angle=0.21500020528690122,
            screw_inertia=1.9917238229311532e-07,
            coupling_stiffness=5308.786735096591,
            support_damping=0.01883194198752303,
            friction_coefficient=0.001789918834992445,
            input_speed=-116.36562258336244,
            mass=155.9167222840723,
            translation_damping=0.6248294570741453,
            axial_force=0.0,
            contact_stiffness=24676.161031233296,
            contact_damping=448354691186.0067,
        ),
        (-0.032532265481088146, 5.8895294120471045, 1.1260143189288897e-07, 0.0005894724030192506),
        5.328346717439247e-05,
    ),
    "pairs beside 1e12": (
        ThreadsParameters,
        dict(
            pitch_radius=0.027670438096589877,
            lead_angle=0.750320948468801,
            screw_inertia=1.211411180884006e-09,
            coupling_stiffness=43062.72252663437,
            support_damping=0.0,
            friction_coefficient=0.667559249541335,
            input_speed=0.06528371605702331,
            mass=0.04911631852456285,
            translation_damping=5386.767996447659,
            axial_force=0.005911808189386846,
            contact_stiffness=3980546.315461225,
            contact_damping=12284388.83392562,
        ),
        (-1.2979970383460205e-10, 2.282100995511509, -1.1269019562507994e-05, 0.0),
        1.9129931143137816e-06,
    ),
    "impact at the corner without force": (
        NutParameters,
        dict(
            pitch_radius=0.01721148548790027,
            lead_angle=0.04432220658477507,
            screw_inertia=0.0014166872361878562,
            coupling_stiffness=162840.9891732696,
            support_damping=0.1980339060760073,
            friction_coefficient=0.38537182135032283,
            input_speed=3.281156490789627,
            mass=5508.637583717538,
            translation_damping=0.002178791940429286,
            axial_force=0.0,
            nut_inertia=5.18322998303675e-07,
            nut_stiffness=485.48240092650474,
            nut_damping=8.854351736893758e-06,
            slide_friction=0.0,
            bearing_friction=0.0,
        ),
        (-6.128417021289366e-05, 15.084416588294577, -0.0004972637787572805, 8.023588787061733),
        0.0013523338996411973,
    ),
}


def case_of(drive, values, start, duration) -> Case:
    family = CaseFamily.NUT if drive is NutParameters else CaseFamily.CONTACT
    return Case(family, CaseGroup.ONLY, 0.0, drive.of(values), start, duration)


@pytest.mark.parametrize("name", CASES)
def test_against_the_reference(name):
    outcome = judge(case_of(*CASES[name]), np.random.default_rng(0), by_reference=True)
    assert outcome.verdict in (Verdict.RIGHT, Verdict.CORNER)


def test_a_vibrating_contact_does_not_hold_the_search_down():
    """An undamped contact that turns 2e7 times after the last event; N stays positive."""
    values = dict(
        pitch_radius=0.002604657329060413,
        lead_angle=0.09556383129314026,
        screw_inertia=0.0008749261728421231,
        coupling_stiffness=0.0037729374503892125,
        support_damping=0.4456986401397607,
        friction_coefficient=0.1294841347974078,
        input_speed=-54.12059683646637,
        mass=0.022909281897790984,
        translation_damping=0.0,
        axial_force=15485.354338388395,
        contact_stiffness=4184792600355.4565,
        contact_damping=0.0,
    )
    start = (5.872565659757856, 74.07751731613516, 3.7813209539213355e-09, 0.0)
    case = case_of(ThreadsParameters, values, start, 9.206112381906635)
    motion = follow(automaton(case), case.start, case.duration)
    assert motion.status == Status.TIME_REACHED
    assert motion.time.size < 10
    states, modes = motion.at(np.sort(np.random.default_rng(1).uniform(motion.time[-1], case.duration, 50_000)))
    assert motion.automaton.observe("normal_force", states, modes).min() > 0.0


def test_growth_beyond_all_numbers_does_not_move_what_is_in_equilibrium():
    """Steady sliding that repels at 1.2e5 1/s: a motion from it stays there, for 0.2 s and whenever it is looked at."""
    drive = RigidParameters.of(
        pitch_radius=0.03806244679962706,
        lead_angle=0.12264428665884365,
        screw_inertia=1.2429230549627857e-06,
        coupling_stiffness=0.003946670052215552,
        support_damping=9.60114218189808e-07,
        friction_coefficient=0.1608478915598803,
        input_speed=0.1696369958396299,
        mass=0.09625457766977397,
        translation_damping=10800.043519753883,
        axial_force=632.0047383503252,
    )
    motion = follow(rigid_automaton(drive), (0.0, 0.0), 0.2)
    assert motion.time.size == 0
    assert motion.end_state.tolist() == [0.0, 0.0]
    assert not motion.at([0.001, 0.1, 0.2])[0].any()


@pytest.mark.parametrize("duration", [20.0, math.inf])
@pytest.mark.parametrize("index", [637, 28])
def test_steady_sliding_that_repels_is_stayed_in(index, duration):
    """With a rotating nut and rates up to 7e5 1/s, for 20 s or for ever: no search for an event that cannot come."""
    drive = wide_drive("nut", 9901 if index == 637 else 81, index, 1)
    kind = find_model("nut")
    motion = follow(kind.build(drive.drive, (*kind.options, *drive.physics), "contact_sign"), [0.0] * 4, duration)
    assert motion.status == (Status.SETTLED if duration == math.inf else Status.TIME_REACHED)
    assert motion.time.size == 0
    assert not motion.end_state.any()
    assert not motion.at([1e-3, 5.0, 20.0])[0].any()


def test_growth_beyond_all_numbers_does_not_move_a_pair_in_equilibrium():
    """The same of a growing pair of a field of four states, beside a pair that decays and swings."""
    rows = [[0, 1, 0, 0, 0], [-1e10, 3e5, 0, 0, 0], [0, 0, 0, 1, 0], [0, 0, -100, -1, 0]]
    flow = flow_of([linear_mode(rows, [1.0] * 4)])
    out, turning = np.empty(4), math.sqrt(99.75)
    dispatch.advance(flow, 0, np.array([0.0, 0.0, 1.0, 0.0]), 0.1, out)
    assert out[:2].tolist() == [0.0, 0.0]
    assert out[2] == pytest.approx(
        math.exp(-0.05) * (math.cos(0.1 * turning) + 0.5 / turning * math.sin(0.1 * turning)), rel=1e-12
    )


@pytest.mark.parametrize(
    ("model", "seed", "index", "starts"),
    [
        *(("threads", 9301, *case) for case in ((2, (2, 6)), (13, (10, 15)), (35, (9,)), (50, (7,)))),
        *(("nut", 9802, *case) for case in ((100, (12,)), (106, (13,)))),
    ],
)
def test_a_small_angle_keeps_its_digits_far_from_an_equilibrium(model, seed, index, starts):
    """Angles of 1e-10 to 1e-7 rad next to steady sliding; under the other law the equilibrium is up to 4e3 rad away."""
    wide = wide_drive(model, seed, index, 32)
    for start in starts:
        case = four_case(wide, start, max(abs(float(x.imag)) for x in rates(wide)))
        outcome = judge(case, np.random.default_rng(0), by_reference=True)
        assert outcome.verdict == Verdict.RIGHT
        assert outcome.state_error < 1e-12


@pytest.mark.parametrize(
    ("index", "start"),
    [
        *((0, 116), (556, 34)),  # θ′ and N are small beside their parts: the time of the event
        *((62, 8), (160, 65), (365, 44), (485, 32), (626, 15)),  # a coordinate is small beside its modal terms
        *((147, 2), (432, 104), (510, 8), (592, 42), (787, 7)),  # v instead of e was put on N = 0 after a whole turn
        *((12, 0), (217, 6), (305, 6), (755, 3)),  # e is small beside a seat far away
        *((21, 99), (70, 4), (681, 6)),  # the same, and N beside its parts
    ],
)
def test_what_is_small_beside_its_terms_keeps_its_digits(index, start):
    """Motions of compliant threads that were off by 1e-9 to 1e-5 in a small coordinate, or in the time of an event."""
    wide = wide_drive("threads", 9901, index, start + 1)
    case = four_case(wide, start, max(abs(float(x.imag)) for x in rates(wide)))
    outcome = judge(case, np.random.default_rng(0), by_reference=True, truth=quick_path)
    assert outcome.verdict == Verdict.RIGHT
    assert max(outcome.state_error, outcome.time_error) < 1e-10


@pytest.mark.parametrize("start", [3, 36, 107])
def test_a_guard_is_found_by_what_is_left_of_it(start):
    """Without load N falls from 6e5 N to 6e-10 N within 35 time constants of its fast part, and passes zero there.

    That is below the rounding of the parts at time zero, and the event was found as late as 80 time constants (start
    3); and k_c e + c_c v, of a contact that creeps, had lost all digits of what is left (36, 107).
    """
    wide = wide_drive("threads", 9961, 669, start + 1)
    case = four_case(wide, start, max(abs(float(x.imag)) for x in rates(wide)))
    outcome = judge(case, np.random.default_rng(0), by_reference=True, truth=quick_path)
    assert outcome.verdict == Verdict.RIGHT
    assert max(outcome.state_error, outcome.time_error) < 1e-9


@pytest.mark.parametrize("start", [19, 45])
def test_a_slip_that_falls_below_the_smallest_double_goes_on(start):
    """The nut creeps to its place at 4516 1/s, on and on, while the coupling unwinds and the screw rests.

    After 0.16 s its speed is 10⁻³²⁰ rad/s. It seemed to stop, and static friction then let go of the screw 1.4 s early.
    """
    wide = wide_drive("nut", 9961, 150, 128)
    case = four_case(wide, start, max(abs(float(x.imag)) for x in rates(wide)))
    outcome = judge(case, np.random.default_rng(0), by_reference=True, truth=quick_path)
    assert outcome.verdict == Verdict.RIGHT
    assert max(outcome.state_error, outcome.time_error) < 1e-12


@pytest.mark.parametrize("index", [269, 518, 774])
def test_an_undamped_contact_that_only_touches_zero_does_not_reverse(index):
    """From u = w = e = v = 0 N comes back to zero after each turn; rounding alone makes it negative there."""
    wide = wide_drive("threads", 9901, index, 8)
    fastest = max(abs(float(x.imag)) for x in rates(wide))
    case = four_case(wide, 7, fastest)
    assert not any(case.start)
    motion = follow(automaton(case), case.start, case.duration)
    assert motion.kind.size >= 5
    assert (motion.kind == GRAZE_KIND).all()
    turns = motion.time * fastest / (2 * math.pi)
    assert turns == pytest.approx(np.round(turns), rel=1e-9)
    assert judge(case, np.random.default_rng(0), by_reference=True).verdict == Verdict.RIGHT


@pytest.mark.parametrize("name", ["pairs", "real rates", "a growing pair", "a single rate", "a slow rate"])
def test_a_coordinate_far_from_its_equilibrium_is_moved_by_its_change(name):
    """Random fields with a push that puts the equilibrium up to 1e15 sizes of the motion away, against mpmath."""
    factors = {
        "pairs": [(9.0, 0.3), (1e4, 20.0)],
        "real rates": [(6.0, 5.0), (100.0, 25.0)],
        "a growing pair": [(9.0, -0.2), (400.0, 3.0)],
        "a single rate": [(9.0, 0.3), (-7.0,), (-0.3,)],
        "a slow rate": [(9.0, 0.3), (-1e-9,), (-40.0,)],
    }[name]
    rng, found = np.random.default_rng(len(name)), 0
    for _ in range(20):
        rows, i = [[0.0] * 5 for _ in range(4)], 0
        for factor in factors:
            if len(factor) == 1:
                rows[i][i] = factor[0]
            else:
                rows[i][i + 1], rows[i + 1][i], rows[i + 1][i + 1] = 1.0, -factor[0], -factor[1]
            i += len(factor)
        change = np.eye(4) + 0.3 * rng.standard_normal((4, 4))
        matrix = change @ np.array(rows)[:, :4] @ np.linalg.inv(change)
        push = 10.0 ** rng.uniform(8, 15) * rng.standard_normal(4)
        state = rng.standard_normal(4)
        fastest = np.abs(np.linalg.eigvals(matrix)).max()
        time = float(10.0 ** rng.uniform(-3, 0) * np.abs(state).max() / (np.abs(push).max() + fastest))
        field = np.column_stack([matrix, push])
        flow = flow_of([linear_mode(field.tolist(), [1.0] * 4)])
        out, scale = np.empty(4), np.abs(state)
        dispatch.advance(flow, 0, state, time, out)
        with mp.workdps(60):
            extended = mp.matrix(5)
            for i in range(4):
                for j in range(5):
                    extended[i, j] = mp.mpf(float(field[i, j])) * mp.mpf(time)
            exact = np.array([float(x) for x in (mp.expm(extended) * mp.matrix([*map(float, state), 1.0]))[:4]])
        far = np.abs(flow.from_modal[0, :, -1]) > 2.0**20 * np.maximum(np.abs(state), np.abs(out))
        found += far.sum()
        assert np.abs(out - exact)[far].max(initial=0.0) <= 1e-13 * np.abs(state).max()
        work = dispatch.workspace(flow, 1)
        dispatch.travel(flow, 0, state, time, scale, work)
        assert (state == out).all()
        assert (scale[far] <= 1e3 * np.abs(out).max()).all()
    assert found > 30


@pytest.mark.parametrize(
    ("model", "values"),
    [
        ("nut", {"mass": 104.5, "nut_stiffness": 7.77e-4, "pitch_radius": 1.2e-4, "input_speed": 1e-12}),
        ("threads", {"mass": 1e9, "screw_inertia": 877.0, "contact_damping": 6e-3, "input_speed": -1e-12}),
        ("threads", {"mass": 0.0889, "contact_damping": 7.56e-3, "input_speed": -1e-12, "axial_force": 1e12}),
        ("threads", {"mass": 2e5, "lead_angle": 1e-6, "friction_coefficient": 9.99e5}),
        ("threads", {"mass": 1e-18, "contact_stiffness": 23.2, "contact_damping": 5e11}),
        ("support", {"screw_mass": 1e-18, "support_damping": 1e15, "input_speed": 1e-12}),
        ("threads", {"screw_inertia": 1e-30, "contact_stiffness": 1e15, "mass": 3.2}),
    ],
)
def test_rates_tens_of_decades_apart_share_a_block(model, values):
    """Next to the ends of the ranges, and beyond them while values were accepted there: once a division by zero."""
    definition = find_model(model)
    drive = definition.drive(**values)
    assert definition.build(drive, definition.physics_of(drive), "contact_sign").condition < 1e4


def test_steady_sliding_where_doubles_lose_a_row_of_the_field():
    """Just below μ = cot λ; the field is singular in doubles: once a traceback."""
    drive = ThreadsParameters.of(
        support_damping=54624.77056974889, contact_stiffness=24764977476642.695,
        friction_coefficient=10.25407004273012, input_speed=-1e-9, axial_force=6949.60410918396,
    )  # fmt: skip
    found = steady_state(threads_automaton(drive), seated_state(drive, -1e-9, 0.0))
    assert found.label == Attractor.STEADY_SLIDING
