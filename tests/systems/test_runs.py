"""Runs of the engine: digits of rates decades apart, room for events, too many of them; where it is kept compiled.

Without compilation results are the same to rounding, as LLVM may contract and reorder; 1e-12 of the motion, as in the
comparison with mpmath. An index out of range raises then.
"""

import json
import logging
import math
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial

import numpy as np
import pytest
from filelock import FileLock, Timeout
from references.drives import threads_drive
from references.known import NEGATIVE_DAMPING, PARADOX

from lsvib import Drive
from lsvib.drives.automata import automaton_of
from lsvib.errors import EngineError
from lsvib.systems import motion as runs
from lsvib.systems.exact.modal_form import linear_mode, modal_flow
from lsvib.systems.kernels import event_loop, jit
from lsvib.systems.motion import bouncing, follow


def test_growth_beyond_all_numbers_does_not_move_what_is_in_equilibrium():
    """Steady sliding that repels at 1.2e5 1/s: a motion from it stays there, for 0.2 s and whenever it is looked at."""
    drive = Drive.of(
        pitch_radius=0.03806244679962706, lead_angle=0.12264428665884365, screw_inertia=1.2429230549627857e-06,
        coupling_stiffness=0.003946670052215552, support_damping=9.60114218189808e-07,
        friction_coefficient=0.1608478915598803, input_speed=0.1696369958396299, mass=0.09625457766977397,
        translation_damping=10800.043519753883, axial_force=632.0047383503252,
    )  # fmt: skip
    motion = follow(automaton_of(drive), (0.0, 0.0), 0.2)
    assert motion.time.size == 0
    assert motion.end_state.tolist() == [0.0, 0.0]
    assert not motion.at([0.001, 0.1, 0.2])[0].any()


def test_growth_beyond_all_numbers_does_not_move_a_pair_in_equilibrium():
    """The same of a growing pair of a field of four states, beside a pair that decays and swings."""
    rows = [[0, 1, 0, 0, 0], [-1e10, 3e5, 0, 0, 0], [0, 0, 0, 1, 0], [0, 0, -100, -1, 0]]
    flow = modal_flow([linear_mode(rows, [1.0] * 4, None, "a parameter")])
    out, turning = np.empty(4), math.sqrt(99.75)
    event_loop.advance(flow, 0, np.array([0.0, 0.0, 1.0, 0.0]), 0.1, out)
    assert out[:2].tolist() == [0.0, 0.0]
    swing = math.cos(0.1 * turning) + 0.5 / turning * math.sin(0.1 * turning)
    assert out[2] == pytest.approx(math.exp(-0.05) * swing, rel=1e-12)


JUST_BELOW_COT_LEAD = {
    "support_damping": 54624.77056974889, "contact_stiffness": 24764977476642.695,
    "friction_coefficient": 10.25407004273012, "input_speed": -1e-9, "axial_force": 6949.60410918396,
}  # fmt: skip
CREEPING = [{"contact_stiffness": 1e4, "contact_damping": damping} for damping in (1e11, 1e12)]


@pytest.mark.parametrize("values", [*CREEPING, JUST_BELOW_COT_LEAD])
def test_rates_that_cannot_be_told_apart_are_refused_by_name(values):
    """A contact that creeps at 1e-8 1/s beside the coupling's 500 1/s; and a field that is singular in doubles."""
    drive = threads_drive(**values)
    with pytest.raises(EngineError, match=r"cannot be distinguished .*change contact_damping\."):
        automaton_of(drive)


FASTEST = Drive(translation_damping=1e15, friction_slope=-1e-5)  # turns at 10¹⁴ 1/s


def test_a_motion_of_too_many_steps_is_refused_in_one_sentence(monkeypatch):
    monkeypatch.setattr("lsvib.systems.motion._MANY_STEPS", 10_000)
    with pytest.raises(EngineError, match=r"than 10,000 steps to the event after t = 0 s; shorten the duration"):
        follow(automaton_of(FASTEST), (0.1, 0.0), 1.0)


def test_samples_of_a_friction_law_do_not_depend_on_those_before():
    """All samples of a stay are taken in one pass; each is that of a pass of its own, to rounding."""
    drive = Drive(stribeck_rise=0.05, stribeck_speed=0.02)
    motion = follow(automaton_of(drive), (0.1, 0.0), 0.2)
    times = np.sort(np.append(np.linspace(0.0, 0.2, 301), motion.time))
    states, modes = motion.at(times)
    for when, state, mode in zip(times, states, modes, strict=True):
        alone, there = motion.at([when])
        assert there[0] == mode
        assert (np.abs(alone[0] - state) <= 1e-13 * np.abs(states).max(axis=0)).all()


SPRAG_SLIP = automaton_of(PARADOX)
STICK_SLIP = automaton_of(NEGATIVE_DAMPING.replace(axial_force=40.0))
NO_DAMPING = automaton_of(Drive.of(mass=11.0, axial_force=-10.0), resume="at_once")  # seizures accumulate
THREADS = automaton_of(threads_drive(mass=11.0, axial_force=50.0, contact_stiffness=1e8, contact_damping=1e8))


@pytest.mark.parametrize("room", [1, 2, 3])
@pytest.mark.parametrize(
    ("automaton", "start", "duration"),
    [
        (SPRAG_SLIP, (0.1, 0.0), 0.5),
        (STICK_SLIP, (0.01, 0.0), 0.5),
        (NO_DAMPING, (0.1, 0.0), 0.2),
        (THREADS, (0.003, 0.0, 0.0, 0.0), 0.01),
    ],
)
def test_the_room_for_events_takes_no_part_in_the_arithmetic(monkeypatch, automaton, start, duration, room):
    whole = follow(automaton, start, duration)
    monkeypatch.setattr(runs, "_FIRST_CAPACITY", room)
    pieces = follow(automaton, start, duration)
    assert whole.time.size > 5
    for name in ("time", "kind", "sign", "mode", "before", "after", "end_state"):
        assert np.array_equal(getattr(whole, name), getattr(pieces, name))
    assert (whole.end_time, whole.end_mode, whole.status) == (pieces.end_time, pieces.end_mode, pieces.status)


def test_more_events_than_anybody_can_want_is_an_error_unless_asked_for(monkeypatch):
    assert follow(STICK_SLIP, (0.01, 0.0), 1.0, max_events=100).time.size == 100
    monkeypatch.setattr(runs, "_MANY_EVENTS", 100)
    with pytest.raises(EngineError, match=r"more than 100 events before t = 0\.\d+ s; shorten the duration"):
        follow(STICK_SLIP, (0.01, 0.0), 1.0)


NOWHERE = "/dev/null/nowhere"  # cannot be made, not even by root


def test_the_folder_of_the_cache(monkeypatch, tmp_path):
    """The one that is asked for, else one of the user; where there is none that can be written, none."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "chosen"))
    assert jit.cache_folder() == tmp_path / "chosen"
    monkeypatch.setenv("NUMBA_CACHE_DIR", NOWHERE)
    assert jit.cache_folder() is None
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert jit.cache_folder() == tmp_path / "cache" / "lsvib" / jit.source_digest()
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", NOWHERE)
    assert jit.cache_folder() is None
    monkeypatch.delenv("HOME")
    monkeypatch.setattr("pwd.getpwuid", {}.__getitem__)  # of a user whom the system does not know
    assert jit.cache_folder() is None
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "chosen"))
    assert jit.cache_folder() == tmp_path / "chosen"


@pytest.fixture
def other():
    """The lock of the cache, as another process has it."""
    return FileLock(f"{jit.numba.config.CACHE_DIR}/lock", timeout=60)


@pytest.fixture
def small():
    """Make a kernel that has not been kept, with the file that will."""
    kernel = jit.numba.njit(lambda x: x, cache=True)
    kernel._cache.flush()
    return kernel, kernel._cache._cache_file


@pytest.mark.skipif(jit.numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_one_process_at_a_time_adds_to_the_cache(small, other, monkeypatch):
    """Until the other one has done, it waits; then it lets no other add until all is written."""
    kernel, file = small
    save = file.save

    def alone(*what):
        with pytest.raises(Timeout):
            other.acquire(timeout=0)
        save(*what)

    monkeypatch.setattr(file, "save", alone)
    with ThreadPoolExecutor(1) as pool, other:
        called = pool.submit(kernel, 1.0)
        while not (kernel.overloads or called.done()):  # until it is compiled
            time.sleep(0.01)
        with pytest.raises(TimeoutError):
            called.result(timeout=0.3)
        assert not file._load_index()
        other.release()
        assert called.result(timeout=60) == 1.0
    assert len(file._load_index()) == 1
    with other.acquire(timeout=0):
        pass


@pytest.mark.skipif(jit.numba.config.DISABLE_JIT, reason="nothing is compiled")
def test_nobody_waits_for_ever_to_add_to_the_cache(small, other, monkeypatch, caplog):
    """Not for a process that has been stopped, and a thread not for itself; what cannot be kept is compiled and run."""
    kernel, file = small
    monkeypatch.setattr(jit.writer, "patience", 0.1)
    with other:
        assert (kernel(1.0), kernel(1)) == (1.0, 1)
    assert not file._load_index()
    (told,) = (record.getMessage() for record in caplog.records)
    assert told.startswith("The compiled engine is not kept for the next start: ")
    ended = partial(jit.event.Event, status=jit.event.EventStatus.END, data={"dispatcher": None})
    compiled, given_back = ended("numba:compile"), ended("numba:compiler_lock")
    for event in (compiled, compiled, given_back, given_back):
        jit.writer.notify(event)
    with other.acquire(timeout=0):
        pass


def test_compiling_is_said_once_for_each_part(caplog):
    caplog.set_level(logging.INFO, "lsvib")
    jit.notice.said -= {*jit.notice.said} - {None}  # by what this process has compiled before
    small = jit.numba.njit(lambda tables: tables.shortest_stay)
    other = jit.numba.njit(lambda tables: -tables.shortest_stay)
    for kernel in (small, other):
        kernel.py_func.__module__ = "lsvib.systems.kernels.small"
    for kernel in (small, small, other):
        for kind in ("planar", "modal"):
            kernel(bouncing(kind).tables)
    told = [record.getMessage() for record in caplog.records]
    assert [words for words in told if "with two states (first use only, about 10 s)" in words] == told[:1]
    assert [words for words in told if "more than two states (first use only, about 30 s)" in words] == told[1:]
    assert len(told) == 2
    say = jit.sentence
    assert "map of attractors" in say("lsvib.systems.kernels.next_section", "Tables(array(float64, 2d, C))")
    told = say("lsvib.dynamics.kernels.sweep", "Tables(AnyFlow(array(float64, 2d, C)))")
    assert "the search for attractors" in told
    assert say("lsvib.systems.kernels.flow_planar", "array(float64, 1d, C)") is None
    assert say("somebody.else", "Tables") is None


@pytest.mark.skipif(jit.numba.config.DISABLE_JIT, reason="nothing is compiled")
@pytest.mark.parametrize("kind", ["planar", "modal"])
def test_a_kernel_calls_the_kernel_of_the_kind_of_flow(kind):
    @jit.numba.njit
    def quarter(flow, state, out):
        event_loop.advance(flow, 0, state, 0.5 * np.pi, out)

    flow, out = bouncing(kind).tables.flow, np.empty(2)
    quarter(flow, np.array([1.0, 0.0]), out)
    np.testing.assert_allclose(out, [0.0, -1.0], atol=1e-15)


MOVED = """
import sys
from numba.core.compiler import CompileResult
from numba.core.cpu import CPUTargetOptions

for owner in CPUTargetOptions.__mro__:
    for name in {"_nrt", "no_cfunc_wrapper"} & {*vars(owner)}:
        delattr(owner, name)
library = CompileResult.library


def refused(compiled):
    if sys._getframe(1).f_globals["__name__"].startswith("lsvib"):
        raise AttributeError("library")
    return library.__get__(compiled)


CompileResult.library = property(refused)
"""
PROGRAM = """
import json
from lsvib.systems.motion import follow
from lsvib import Drive
from lsvib.drives.automata import automaton_of

results = []
for mass, force, c_x, rule in (
    (1.0, 40.0, 1e3, "contact_sign"), (11.0, 50.0, 0.0, "contact_sign"), (15.0, -20.0, 0.0, "at_once")
):
    automaton = automaton_of(Drive.of(mass=mass, axial_force=force, translation_damping=c_x), resume=rule)
    motion = follow(automaton, (0.05, 10.0), 0.05)
    states, modes = motion.at([0.0, 0.01, 0.02, 0.05])
    results.append([motion.time.tolist(), motion.kind.tolist(), states.tolist(), modes.tolist()])
"""
CYCLE = """
from lsvib.systems.attractor import steady_state

cycle = steady_state(automaton_of(Drive.of(axial_force=25.0, translation_damping=1e3)), (0.05, 5.0))
results.append([[cycle.period, cycle.amplitude, float(cycle.multiplier)], [int(cycle.label)], [], []])
"""


@cache
def results(program, **environment):
    """The results of a program, in a process of its own, and what it says."""
    command = [sys.executable, "-c", f"{program}\nprint(json.dumps(results))"]
    run = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment})
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout), run.stderr


@pytest.mark.slow
def test_same_motion_by_a_numba_that_lacks_what_it_does_not_promise(tmp_path):
    found, said = results(MOVED + PROGRAM, NUMBA_CACHE_DIR=str(tmp_path))
    assert found == results(PROGRAM + CYCLE)[0][:-1]
    for what in ("_nrt and no_cfunc_wrapper", "the address of compiled code"):
        assert f"lacks {what}: the first start takes longer" in said


@pytest.mark.slow
def test_same_motion_without_compilation():
    (compiled, _), (plain, said) = (results(PROGRAM + CYCLE, **own) for own in ({}, {"NUMBA_DISABLE_JIT": "1"}))
    assert not said
    for (times, kinds, states, modes), expected in zip(plain, compiled, strict=True):
        assert kinds == expected[1]
        assert modes == expected[3]
        # The multiplier is a difference quotient of step 1e-5: rounding over the step.
        np.testing.assert_allclose(times, expected[0], rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(states, expected[2], rtol=1e-12, atol=1e-12)
