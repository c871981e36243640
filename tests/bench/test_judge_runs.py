"""Runs of the judge over random drives: a part of them, what is told of them, and faults that must be found."""

import json

import numpy as np
import pytest
from judge import boundary_judge, command, judges, threshold_judge
from judge.fate import fate
from judge.second_opinions import watch
from judge.wide_drives import MODELS, wide_drive

from lsvib.drives.parameters import RigidParameters

SEED = 7


@pytest.mark.parametrize("model", MODELS)
def test_drives_do_not_depend_on_what_else_is_drawn(model):
    """Drive and first start of an index are the same whatever the number of starts."""
    one, more = wide_drive(model, SEED, 3, 1), wide_drive(model, SEED, 3, 5)
    assert one.drive == more.drive
    assert (one.starts[0] == more.starts[0]).all()


def test_motions_and_stability_of_random_drives_are_right():
    """A part of the run that judges a million: motions and linear stability of rigid drives."""
    records = [command.judged("rigid", SEED, k, ("stability", "motion")) for k in range(25)]
    table = command.summary(records)
    assert table["motion"].total() == 25 * command.STARTS
    assert not any(table[stage][verdict] for stage in table for verdict in judges.BAD), records


@pytest.mark.slow
def test_more_motions_and_stability_of_random_drives_are_right():
    """The same for more drives, and some of each other model."""
    drives = {"rigid": 400, "support": 5, "nut": 5}
    for model, count in drives.items():
        records = [command.judged(model, SEED, k, ("stability", "motion")) for k in range(count)]
        table = command.summary(records)
        assert not any(table[stage][verdict] for stage in table for verdict in judges.BAD), records


def test_the_judges_can_say_wrong(monkeypatch):
    """A program that calls everything a cycle, or has an onset that is off by 1 %, is found out."""
    wide = wide_drive("rigid", SEED, 0, 1)
    truth = fate(watch.constants(dict(wide.drive)), *wide.starts[0])
    other = "other_cycle" if truth.name == "steady_sliding" else "steady_sliding"
    assert judges.compared(wide, 0, truth, other).verdict == judges.WRONG
    assert judges.compared(wide, 0, truth, "unbounded").verdict == judges.WRONG
    drive = RigidParameters.of(translation_damping=1e3)
    rng = np.random.default_rng(0)
    assert {verdict for _, verdict, *_ in threshold_judge.objections(drive, rng)} == {"right", "not run"}
    right = threshold_judge.thresholds.onset_force
    monkeypatch.setattr(threshold_judge.thresholds, "onset_force", lambda drive: 1.01 * right(drive))
    found = {name: verdict for name, verdict, *_ in threshold_judge.objections(drive, rng)}
    assert found["onset_force"] == "wrong"


@pytest.mark.parametrize("model", MODELS[1:])
def test_a_boundary_of_stability_that_is_off_by_a_part_in_a_million_is_found_out(model, monkeypatch):
    """The thresholds of a drive with four states are right, and a table that moves them is called wrong."""
    right = boundary_judge.threshold_table

    def moved(changes, model):
        table = right(changes, model)
        for entry in table.values():
            for interval in entry["stable_intervals"]:
                interval["low"] *= 1 + 1e-6
                interval["high"] = interval["high"] and interval["high"] * (1 + 1e-6)
            entry["value"] = entry["value"] and entry["value"] * (1 + 1e-6)
        return table

    wrong = 0
    for index in range(2):
        wide = wide_drive(model, SEED, index, 1)
        asked = [verdict for _, verdict, *_ in boundary_judge.objections(wide, np.random.default_rng(index))]
        assert asked == ["right"] * 3
        with monkeypatch.context() as patch:
            patch.setattr(boundary_judge, "threshold_table", moved)
            wrong += any(x[1] == "wrong" for x in boundary_judge.objections(wide, np.random.default_rng(index)))
    assert wrong


def test_faults_and_their_drives_are_recorded(monkeypatch):
    """A question that raises is a finding, and the next one is asked."""

    def stages(wide, questions):
        yield "motion", lambda: 1 / 0
        yield "label", lambda: [judges.Finding(judges.RIGHT)]

    monkeypatch.setattr(judges, "stages", stages)
    record = command.judged("rigid", SEED, 0, ())
    assert record["counts"] == {"motion crashed": 1, "label right": 1}
    assert "ZeroDivisionError" in record["notable"][0]["said"]
    assert not command.passed(command.summary([record]))


def test_verdicts_that_let_a_run_pass():
    """Only a small share may be refused or unresolved; nothing may be wrong."""
    good = {"index": 0, "counts": {"label right": 5000}, "longest": 0.0, "notable": []}
    few = {**good, "counts": {"label unresolved": 4}}
    many = {**good, "counts": {"label unresolved": 40}}
    wrong = {**good, "counts": {"label wrong": 1}}
    assert command.passed(command.summary([good, few]))
    assert not command.passed(command.summary([good, many]))
    assert not command.passed(command.summary([good, wrong]))


def test_runs_are_added_up_and_what_is_not_right_is_named(tmp_path, capsys):
    """Files of several runs make one table; a drive in two of them counts once; numbers do not split a kind."""
    entry = {"stage": "label", "verdict": "unresolved", "start": 0, "said": "unresolved", "truth": "cycle (1.5e-3 N)"}
    record = {"index": 0, "counts": {"label unresolved": 1}, "longest": 0.5, "notable": [entry]}
    other = {**record, "index": 7, "notable": [{**entry, "truth": "cycle (-20 N)"}]}
    right = {"index": 8, "counts": {"label right": 5000}, "longest": 0.1, "notable": []}
    files = [tmp_path / "rigid-1.jsonl", tmp_path / "b" / "rigid-1.jsonl", tmp_path / "rigid-2.jsonl"]
    files[1].parent.mkdir()
    for path, lines in zip(files, ([record, right], [right, other], [record]), strict=True):
        path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert command.main(["--summary", *map(str, files)]) == 0
    said = capsys.readouterr().out
    assert "| label | 5003 | 5000 | 3 |" in said
    assert "| label | unresolved | 3 | 3 | unresolved / cycle (# N) |" in said
    assert command.main(["--summary", str(files[2])]) == 1
    with pytest.raises(SystemExit):
        command.main(["--summary", str(tmp_path / "rigid-3.jsonl")])


@pytest.mark.slow
def test_a_run_goes_on_where_it_was_stopped_and_ends_what_does_not_return(tmp_path):
    """Records that are there are kept, a torn line is judged again, and a limit of nothing makes all questions late."""
    arguments = ["--cases", "8", "--seed", "3", "--questions", "motion", "--out", str(tmp_path)]
    assert command.main(arguments) == 0
    path = tmp_path / "rigid-3.jsonl"
    lines = path.read_text().splitlines()
    assert [json.loads(line)["index"] for line in lines] == [0, 1]
    path.write_text(lines[0] + "\n" + lines[1][:20])
    assert command.main(arguments) == 0
    kept = [line for line in path.read_text().splitlines() if line.endswith("}")]
    assert kept[0] == lines[0]
    assert json.loads(kept[1])["counts"] == json.loads(lines[1])["counts"]
    faint = ["--cases", "4", "--seed", "9101"]  # hardly damped: longer than a tick of the clock, 4 ms
    assert command.main([*faint, "--questions", "attractor", "--out", str(tmp_path / "late"), "--limit", "1e-6"]) == 1
    assert "attractor late" in (tmp_path / "late" / "rigid-9101.jsonl").read_text()


def test_a_damping_of_forty_decades_below_its_rate_is_one():
    """Where friction is tan λ the damping of a nut has a double zero: 1e-9 beside it, it is 1e-45 of the rate."""
    wide = wide_drive("nut", 9961, 766, 1)
    found = list(boundary_judge.objections(wide, np.random.default_rng([wide.seed, wide.index])))
    assert {verdict for _, verdict, *_ in found} == {"right"}, found
