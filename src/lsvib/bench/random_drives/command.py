"""Draw random drives of the models over the full ranges, and judge what the program says about each of them.

    python -m lsvib.bench.random_drives --model rigid --cases 10000 --seed 1 --jobs 2 --out folder

One line of JSON for each drive is written to ``folder/<model>-<seed>.jsonl``: how many findings of each verdict, and in
full those that are not right. A run goes on where the last one with the same folder, model and seed ended; an older
program's findings, or those of another number of starts, belong into another folder. Drives are judged in processes of
their own: a question that takes too long ends its process, and so may a fault; both are findings like others, and the
drive's next questions are asked nevertheless. The exit code is 1 if anything is wrong, crashed or late, or if too much
is refused or unresolved.
"""

import argparse
import json
import math
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from lsvib.bench.random_drives import judges
from lsvib.bench.random_drives.judges import (
    BAD,
    CRASHED,
    GOOD,
    LATE,
    QUESTIONS,
    REFUSED,
    UNRESOLVED,
    Finding,
)
from lsvib.bench.sweeps.wide_drives import MODELS, wide_drive

STARTS = 4  # starts of each drive by default
MOST_UNRESOLVED = 1e-3  # share of the questions of one kind that may stay unresolved
_PATIENCE = 60  # A process that waits for something is stopped after so many times the limit of CPU time.
_WARM = 600.0  # [s] that every process may take at least, because it may compile before its first answer
_SHARES = 20  # reports of progress in one run

Line = dict[str, Any]


def judged(
    model: str,
    seed: int,
    index: int,
    questions: Iterable[str],
    limit: float = math.inf,
    skipped: Iterable[int] = (),
    tell: Callable[[int, str], None] = lambda number, name: None,
    starts: int = STARTS,
) -> Line:
    """Judge one drive: its findings by stage and verdict, and in full those that are not right.

    ``questions``: names of the stages wanted; ``limit`` [s of CPU time]: a stage that takes longer ends the *process*,
    since a kernel that does not return cannot be stopped otherwise; ``skipped``: numbers of stages not to ask again;
    ``tell``: called with the number and name of a stage before it is asked; ``starts``: how many the drive has.
    """
    counts: Counter[str] = Counter()
    notable: list[Line] = []
    wide = wide_drive(model, seed, index, starts)
    longest = 0.0
    for number, (name, ask) in enumerate(judges.stages(wide, questions)):
        if number in skipped:
            continue
        tell(number, name)
        begin = time.process_time()
        if limit < math.inf:
            signal.setitimer(signal.ITIMER_PROF, limit)
        try:
            findings = ask()
            if callable(findings):  # the program has answered; who judges has no limit
                signal.setitimer(signal.ITIMER_PROF, 0)
                longest = max(longest, time.process_time() - begin)
                findings, begin = findings(), math.inf
        except Exception as error:  # whatever it is, it is what the judge is after
            where = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(where.filename).name}:{where.lineno}"
            findings = [Finding(CRASHED, None, f"{type(error).__name__}: {error} ({place})")]
        if limit < math.inf:
            signal.setitimer(signal.ITIMER_PROF, 0)
        longest = max(longest, time.process_time() - begin)
        for finding in findings:
            counts[f"{name} {finding.verdict}"] += 1
            if finding.verdict not in GOOD:
                notable.append({"stage": name, **finding._asdict()})
    return {"index": index, "counts": dict(counts), "longest": round(longest, 3), "notable": notable}


def _work(connection: Connection, model: str, seed: int, questions: tuple[str, ...], limit: float, starts: int) -> None:
    """Judge the drives whose numbers come through a pipe, and tell of every stage before it is asked."""
    judges.warm_up(model, questions)
    connection.send(("ready", None))
    while True:
        task = connection.recv()
        if task is None:
            return
        index, skipped = task
        tell = lambda number, name: connection.send(("stage", (number, name)))  # noqa: E731
        record = judged(model, seed, index, questions, limit, skipped, tell, starts)
        connection.send(("done", record))


class _Worker:
    """A process that judges, and what it is doing."""

    def __init__(self, model: str, seed: int, questions: tuple[str, ...], limit: float, starts: int) -> None:
        self.arguments, self.patience = (model, seed, questions, limit, starts), max(_PATIENCE * limit, _WARM)
        self.process = None
        self.index, self.ready = -1, False

    def start(self) -> None:
        """Start a process; it may compile before its first answer."""
        context = get_context("spawn")
        self.connection, child = context.Pipe()
        self.process = context.Process(target=_work, args=(child, *self.arguments), daemon=True)
        self.process.start()
        child.close()

    def give(self, index: int, skipped: tuple[int, ...] = ()) -> None:
        """Have a drive judged."""
        if self.process is None:
            self.start()
        self.index, self.skipped, self.stage = index, skipped, (-1, "draw")
        self.connection.send((index, skipped))
        self.deadline = time.monotonic() + (self.patience if self.ready else _WARM)

    def hear(self) -> Line | None:
        """Take a message; the record of the drive if it is the last one. ``EOFError`` if the process has died."""
        word, content = self.connection.recv()
        if word == "done":
            return content
        if word == "ready":
            self.ready = True
        else:
            self.stage = content
        self.deadline = time.monotonic() + self.patience
        return None

    def stop(self) -> None:
        """End the process, whatever it is doing."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.connection.close()
            self.process, self.ready = None, False


def run(
    model: str,
    seed: int,
    indices: Iterable[int],
    jobs: int,
    limit: float,
    questions: tuple[str, ...] = QUESTIONS,
    starts: int = STARTS,
) -> Iterator[Line]:
    """Judge drives in ``jobs`` processes; yields their records in the order in which they are done."""
    workers = [_Worker(model, seed, questions, limit, starts) for _ in range(jobs)]
    waiting = iter(indices)
    lost: dict[int, list[Line]] = {}  # what was stopped, by drive
    busy: list[_Worker] = []
    try:
        for worker in workers:
            index = next(waiting, None)
            if index is not None:
                worker.give(index)
                busy.append(worker)
        while busy:
            patience = max(0.0, min(worker.deadline for worker in busy) - time.monotonic())
            ready = wait([worker.connection for worker in busy], patience)
            for worker in list(busy):
                verdict = None
                if worker.connection in ready:
                    try:
                        record = worker.hear()
                    except (EOFError, ConnectionError):
                        worker.process.join()
                        record, verdict = None, LATE if worker.process.exitcode == -signal.SIGPROF else CRASHED
                    if record is not None:
                        yield _with_lost(record, lost.pop(record["index"], []))
                        index = next(waiting, None)
                        if index is None:
                            busy.remove(worker)
                        else:
                            worker.give(index)
                elif time.monotonic() > worker.deadline:
                    verdict = LATE
                if verdict is None:
                    continue
                index, number, name = worker.index, *worker.stage
                said = f"the process died ({worker.process.exitcode})" if verdict == CRASHED else "stopped"
                lost.setdefault(index, []).append({"stage": name, **Finding(verdict, None, said)._asdict()})
                worker.stop()
                if number < 0:  # not even drawn
                    yield _with_lost({"index": index, "counts": {}, "longest": 0.0, "notable": []}, lost.pop(index))
                    index = next(waiting, None)
                    if index is None:
                        busy.remove(worker)
                        continue
                    worker.give(index)
                else:
                    worker.give(index, (*worker.skipped, number))
    finally:
        for worker in workers:
            worker.stop()


def _with_lost(record: Line, lost: list[Line]) -> Line:
    for entry in lost:
        key = f"{entry['stage']} {entry['verdict']}"
        record["counts"][key] = record["counts"].get(key, 0) + 1
    record["notable"] = [*lost, *record["notable"]]
    return record


def summary(records: Iterable[Line]) -> dict[str, Counter[str]]:
    """Count verdicts by stage."""
    table: dict[str, Counter[str]] = {}
    for record in records:
        for key, count in record["counts"].items():
            stage, _, verdict = key.partition(" ")
            table.setdefault(stage, Counter())[verdict] += count
    return table


def passed(table: dict[str, Counter[str]]) -> bool:
    """Whether nothing is wrong, crashed or late, and hardly anything refused or unresolved."""
    for counts in table.values():
        if any(counts[verdict] for verdict in BAD):
            return False
        if counts[UNRESOLVED] + counts[REFUSED] > MOST_UNRESOLVED * counts.total():
            return False
    return True


def _report(table: dict[str, Counter[str]]) -> str:
    verdicts = sorted({verdict for counts in table.values() for verdict in counts})
    lines = ["| question | asked | " + " | ".join(verdicts) + " |", "|---" * (2 + len(verdicts)) + "|"]
    for stage, counts in table.items():
        row = " | ".join(str(counts[verdict]) for verdict in verdicts)
        lines.append(f"| {stage} | {counts.total()} | {row} |")
    return "\n".join(lines)


def _doubts(records: Iterable[Line]) -> list[str]:
    """Return a line for each reason why answers are unresolved, with their number."""
    notable = (entry for record in records for entry in record["notable"] if entry["verdict"] == UNRESOLVED)
    counts = Counter((entry["stage"], entry["said"]) for entry in notable)
    return [f"unresolved {stage}: {count} because {said}" for (stage, said), count in counts.most_common()]


def _read(path: Path) -> list[Line]:
    if not path.exists():
        return []
    records = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            records.append(json.loads(line))
        except json.JSONDecodeError:  # the line that was being written when a run was stopped
            continue
    return records


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    parser = argparse.ArgumentParser(prog="python -m lsvib.bench.random_drives", description=__doc__.split("\n")[0])
    parser.add_argument("--model", choices=MODELS, default="rigid")
    parser.add_argument("--cases", type=int, default=10_000, help="motions")
    parser.add_argument("--starts", type=int, default=STARTS, help="motions of each drive")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1, help="number of processes")
    parser.add_argument("--limit", type=float, default=5.0, help="seconds of CPU time for a question")
    parser.add_argument("--questions", nargs="+", choices=QUESTIONS, default=list(QUESTIONS))
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    options = parser.parse_args(arguments)
    if min(options.cases, options.starts, options.jobs) < 1 or not options.limit > 0 or options.seed < 0:
        parser.error("cases, starts and jobs must be 1 or more, seed 0 or more, and limit positive.")
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / f"{options.model}-{options.seed}.jsonl"
    drives = -(-options.cases // options.starts)
    known = {record["index"]: record for record in _read(path)}
    records = [record for index, record in known.items() if index < drives]
    missing = [index for index in range(drives) if index not in known]
    begin, step = time.monotonic(), max(1, len(missing) // _SHARES)
    with path.open("a", encoding="utf-8") as file:
        if path.stat().st_size and not path.read_bytes().endswith(b"\n"):
            file.write("\n")
        for done, record in enumerate(_asked(options, missing), 1):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
            if done % step == 0 or done == len(missing):
                bad = sum(sum(counts[verdict] for verdict in BAD) for counts in summary(records).values())
                rate = options.starts * done / (time.monotonic() - begin)
                print(f"{done} of {len(missing)} drives, {rate:.0f} cases/s, {bad} bad", file=sys.stderr, flush=True)
    table = summary(records)
    print(_report(table))
    for line in _doubts(records):
        print(line)
    return 0 if passed(table) else 1


def _asked(options: argparse.Namespace, missing: list[int]) -> Iterator[Line]:
    questions = tuple(options.questions)
    return run(options.model, options.seed, missing, options.jobs, options.limit, questions, options.starts)
