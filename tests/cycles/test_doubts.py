"""Why an attractor is unresolved is said wherever its label is: by the search, the mapper, the commands and the judge.

The drives are those of ``judge.wide_drives``, far from the chapter's.
"""

import pytest
from judge import command, judges
from references.wide_drives import wide_drive
from references.wide_scenes import scene

from lsvib.basins import slice_mapper
from lsvib.basins.grid import Grid
from lsvib.basins.mapper import mapper
from lsvib.command.printing import print_map, print_motion
from lsvib.cycles.attractors import Attractor, Doubt, steady_state
from lsvib.data import attraction_map, simulation
from lsvib.drives.registry import find_model
from lsvib.engine import motion
from lsvib.engine.kernels.tables import BlockFlow
from lsvib.errors import (
    AccumulationError,
    BeatError,
    DivergenceError,
    EndlessSearchError,
    EngineError,
    UndecidedError,
    WorkSpentError,
)

ERRORS = {
    DivergenceError: Doubt.RANGE,
    AccumulationError: Doubt.ACCUMULATION,
    UndecidedError: Doubt.UNDECIDED,
    BeatError: Doubt.BEAT,
    EndlessSearchError: Doubt.SEARCH,
    WorkSpentError: Doubt.EVENTS,
    EngineError: Doubt.ENGINE,
}

FEW = 30_000  # units of work, so that the tests are quick


def test_every_error_of_the_engine_has_a_doubt_of_its_own():
    assert {kind: Doubt.of(kind("")) for kind in ERRORS} == ERRORS
    assert set(ERRORS.values()) | {Doubt.FORK, Doubt.BOUNDARY} == set(Doubt)


@pytest.mark.parametrize(("key", "doubt"), [(("nut", 72, 20, 2), Doubt.EVENTS)])
def test_search_and_mapper_say_why(key, doubt, monkeypatch):
    monkeypatch.setattr(slice_mapper, "_EVENTS", FEW)
    automaton, state = scene(*key)
    found = steady_state(automaton, state, max_events=FEW)
    assert (found.label, found.doubt) == (Attractor.UNRESOLVED, doubt)
    wide = wide_drive(*key[:3], 4)
    destiny = mapper(wide.drive, wide.model, wide.physics).destiny(state)
    assert (destiny.label, destiny.doubt) == (Attractor.UNRESOLVED, doubt)


def test_what_is_resolved_leaves_no_doubt():
    automaton, state = scene("nut", 21, 25, 1)
    assert steady_state(automaton, state).doubt is None


def test_motions_maps_and_the_judge_say_why(capsys, tmp_path, monkeypatch):
    """The events of this nut go on for longer than is allowed."""
    monkeypatch.setattr(slice_mapper, "_EVENTS", FEW)
    wide = wide_drive("nut", 72, 20, 4)
    kind = find_model("nut")
    start = dict(zip((*kind.required, *kind.optional), wide.starts[2].tolist(), strict=True))
    given = {"model": "nut", "duration": 1e-9, "start": start}
    checked = simulation.as_scene(None, given, dict(wide.drive))
    result = simulation.summary(checked, simulation.run(checked))
    print_motion(result)
    assert f"attractor: unresolved, because {Doubt.EVENTS}\n" in capsys.readouterr().out

    mapped = mapper(wide.drive, "nut", wide.physics)
    axes = [f"{key}={start[key] - 1e-3}:{start[key] + 1e-3}:1" for key in ("u", "w")]
    grid = Grid.parse([*axes, *(f"{key}={start[key]}" for key in kind.optional)])
    found = mapped.cells(grid, quantities=("label", "doubt"))
    labels, doubts = found["label"], attraction_map.doubts(found["doubt"])
    assert labels.tolist() == [[Attractor.UNRESOLVED]]
    counts = {kind: int((labels == kind).sum()) for kind in Attractor}
    assert doubts == {Doubt.EVENTS: 1}
    print_map(attraction_map.summary(counts, doubts, None, 1.0), counts)
    assert f"unresolved: 1 cells\n  1 because {Doubt.EVENTS}\n" in capsys.readouterr().out

    record = command.judged("nut", 72, 20, ("attractor",))
    said = {(entry["start"], entry["said"]) for entry in record["notable"] if entry["verdict"] == judges.UNRESOLVED}
    assert (2, Doubt.EVENTS) in said
    monkeypatch.setattr(command, "run", lambda *asked: [record])
    command.main(["--model", "nut", "--cases", "4", "--out", str(tmp_path)])
    assert f"unresolved attractor: {len(said)} because {Doubt.EVENTS}" in capsys.readouterr().out


def test_a_section_that_is_a_point_has_no_multipliers():
    """A support whose motion repeats on a section without directions once ended the search by a traceback."""
    wide = wide_drive("support", 71, 26, 4)
    assert mapper(wide.drive, wide.model, wide.physics).destiny(wide.starts[0]).doubt is None


def test_an_amplitude_that_does_not_change_at_all_is_no_trend():
    """A support with one such amplitude beside one that scatters once ended the search by a traceback."""
    wide = wide_drive("support", 73, 53, 4)
    assert mapper(wide.drive, wide.model, wide.physics).destiny(wide.starts[0]).doubt is None


@pytest.mark.parametrize(("seed", "index", "start"), [(84, 18, 2), (85, 39, 2)])
def test_what_is_not_told_takes_no_more_work_than_is_allowed(seed, index, start, monkeypatch):
    """One starts in steady sliding, which repels so slowly that it was asked about twice; one has large blocks."""
    wide, spent = wide_drive("threads", seed, index, 4), []

    def run(tables, mode, state, scale, clock, *others):
        before = clock[3]
        found = kernel(tables, mode, state, scale, clock, *others)
        an_event, a_step = motion._COSTS[isinstance(tables.flow, BlockFlow)]
        spent.append(motion.CALL + mapped.automaton.effort * (an_event * found[2] + a_step * (before - clock[3])))
        return found

    kernel = motion.event_loop.run
    mapped = mapper(wide.drive, wide.model, wide.physics)
    monkeypatch.setattr(motion.event_loop, "run", run)
    monkeypatch.setattr(mapped, "_events", FEW)
    assert mapped.destiny(wide.starts[start]).doubt == Doubt.EVENTS
    assert sum(spent) < 3.6 * FEW
    assert mapped.automaton.effort == pytest.approx({84: 1.0, 85: 0.5 + 0.5 * 33 / 17}[seed])
