"""Draw random drives of the models over the full ranges, and judge what the program says about each of them.

    PYTHONPATH=tests python -m judge --model rigid --cases 10000 --seed 1 --jobs 2 --out folder
    PYTHONPATH=tests python -m judge --summary folder/*.jsonl

One line of JSON for each drive is written to ``folder/<model>-<seed>.jsonl``: how many findings of each verdict, and in
full those that are not right. A run goes on where the last one with the same folder, model and seed ended; an older
program's findings, or those of another number of starts, belong into another folder. Drives are judged in processes of
their own: a question that takes too long ends its process, and so may a fault; both are findings like others, and the
drive's next questions are asked nevertheless. ``--summary`` adds up the files of several runs. The exit code is 1 if
anything is wrong, crashed or late, or if too much is refused or unresolved.
"""

import argparse
import json
import re
import sys
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from judge.judges import BAD, QUESTIONS, REFUSED, UNRESOLVED
from judge.processes import STARTS, JsonLine, judged, run
from judge.wide_drives import MODELS

__all__ = ["STARTS", "judged", "kinds", "main", "passed", "run", "summary"]

MOST_UNRESOLVED = 1e-3  # share of the questions of one kind that may stay unresolved
_SHARES = 20  # reports of progress in one run
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


def summary(records: Iterable[JsonLine]) -> dict[str, Counter[str]]:
    """Count verdicts by stage."""
    table: dict[str, Counter[str]] = {}
    for record in records:
        for key, count in record["counts"].items():
            stage, _, verdict = key.partition(" ")
            table.setdefault(stage, Counter())[verdict] += count
    return table


def kinds(records: Iterable[JsonLine]) -> list[tuple[str, str, int, int, str]]:
    """Count what is not right by stage, verdict, and both sides' words without their numbers, the most frequent first.

    Returns (stage, verdict, number of answers, number of drives, words).
    """
    found: dict[tuple[str, str, str], list[int]] = {}
    for drive, record in enumerate(records):
        for entry in record["notable"]:
            words = " / ".join(filter(None, (entry["said"], entry["truth"])))
            found.setdefault((entry["stage"], entry["verdict"], _NUMBER.sub("#", words)), []).append(drive)
    rows = [(stage, verdict, len(at), len(set(at)), words) for (stage, verdict, words), at in found.items()]
    return sorted(rows, key=lambda row: -row[2])


def passed(table: dict[str, Counter[str]]) -> bool:
    """Whether nothing is wrong, crashed or late, and hardly anything refused or unresolved."""
    for counts in table.values():
        if any(counts[verdict] for verdict in BAD):
            return False
        if counts[UNRESOLVED] + counts[REFUSED] > MOST_UNRESOLVED * counts.total():
            return False
    return True


def _report(records: list[JsonLine]) -> str:
    table = summary(records)
    verdicts = sorted({verdict for counts in table.values() for verdict in counts})
    lines = ["| question | asked | " + " | ".join(verdicts) + " |", "|---" * (2 + len(verdicts)) + "|"]
    for stage, counts in table.items():
        row = " | ".join(str(counts[verdict]) for verdict in verdicts)
        lines.append(f"| {stage} | {counts.total()} | {row} |")
    lines += ["", f"drives: {len(records)}; longest question: {max((r['longest'] for r in records), default=0)} s"]
    if unclear := kinds(records):
        lines += ["", "| question | verdict | answers | drives | program / judge |", "|---" * 5 + "|"]
        lines += ["| " + " | ".join(map(str, row)) + " |" for row in unclear]
    lines += _doubts(records)
    return "\n".join(lines)


def _doubts(records: Iterable[JsonLine]) -> list[str]:
    """Return a line for each reason why answers are unresolved, with their number."""
    notable = (entry for record in records for entry in record["notable"] if entry["verdict"] == UNRESOLVED)
    counts = Counter((entry["stage"], entry["said"]) for entry in notable)
    return [f"unresolved {stage}: {count} because {said}" for (stage, said), count in counts.most_common()]


def _read(path: Path) -> dict[int, JsonLine]:
    """Records of a file by drive; without the line that was being written when a run was stopped."""
    records = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            record = json.loads(line)
        except json.JSONDecodeError:
            continue
        records[record["index"]] = record
    return records


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="python -m judge", description=__doc__.split("\n")[0])
    parser.add_argument("--model", choices=MODELS, default="rigid")
    parser.add_argument("--cases", type=int, default=10_000, help="motions")
    parser.add_argument("--first", type=int, default=0, help="number of the first drive")
    parser.add_argument("--starts", type=int, default=STARTS, help="motions of each drive")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="number of processes")
    parser.add_argument("--limit", type=float, default=5.0, help="seconds of CPU time for a question")
    parser.add_argument("--questions", nargs="+", choices=QUESTIONS, default=list(QUESTIONS))
    parser.add_argument("--out", type=Path, help="folder of the results")
    parser.add_argument("--summary", type=Path, nargs="+", metavar="FILE", help="add up these results; ask nothing")
    options = parser.parse_args(arguments)
    if options.summary:
        return _summed(parser, options.summary)
    if options.out is None:
        parser.error("the following arguments are required: --out")
    if min(options.cases, options.starts, options.jobs) < 1 or not options.limit > 0:
        parser.error("cases, starts and jobs must be 1 or more, and limit positive.")
    if min(options.seed, options.first) < 0:
        parser.error("seed and first must be 0 or more.")
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / f"{options.model}-{options.seed}.jsonl"
    drives = range(options.first, options.first - (-options.cases // options.starts))
    known = _read(path)
    records = [known[index] for index in drives if index in known]
    missing = [index for index in drives if index not in known]
    begin, step = time.monotonic(), max(1, len(missing) // _SHARES)
    with path.open("a", encoding="utf-8") as file:
        if path.stat().st_size and not path.read_bytes().endswith(b"\n"):
            file.write("\n")
        questions = tuple(options.questions)
        asked = run(options.model, options.seed, missing, options.jobs, options.limit, questions, options.starts)
        for done, record in enumerate(asked, 1):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
            if done % step == 0 or done == len(missing):
                bad = sum(sum(counts[verdict] for verdict in BAD) for counts in summary(records).values())
                rate = options.starts * done / (time.monotonic() - begin)
                print(f"{done} of {len(missing)} drives, {rate:.0f} cases/s, {bad} bad", file=sys.stderr, flush=True)
    print(_report(records))
    return 0 if passed(summary(records)) else 1


def _summed(parser: argparse.ArgumentParser, paths: list[Path]) -> int:
    """Add up the files of several runs; a drive that is in two of them counts once."""
    absent = [str(path) for path in paths if not path.is_file()]
    if absent:
        parser.error(f"summary: there is no file {absent[0]}.")
    if len({path.name.rpartition("-")[0] for path in paths}) > 1:
        parser.error("summary: the files must be of one model.")
    found = {(path.name, index): record for path in paths for index, record in _read(path).items()}
    records = list(found.values())
    print(_report(records))
    return 0 if passed(summary(records)) else 1
