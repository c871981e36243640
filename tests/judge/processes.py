"""Judge random drives in processes of their own: a question that does not return, or dies, costs its process only.

A process is given some drives at once and answers with one record for each. Which question it is at stands in memory
that it shares with who gave them, so that asking costs no message.
"""

import math
import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

from numba.core.event import Listener, register

from judge import judges
from judge.judges import CRASHED, LATE, QUESTIONS, UNNOTED, Finding
from judge.wide_drives import wide_drive

STARTS = 4  # starts of each drive by default
_CHUNK = 16  # drives that a process is given at once, so that it never waits for the next one
_PATIENCE = 60  # A process that does not get on is stopped after so many times the limit of CPU time.
_WARM = 3600.0  # [s] that every process may take at least: it may compile, or wait for its turn on a busy machine

JsonLine = dict[str, Any]


class _Compiling(Listener):
    """Stops the clock of a question while a kernel is compiled or loaded for it, which happens once in a process."""

    depth, left, begin, spent = 0, 0.0, 0.0, 0.0

    def on_start(self, event: Any) -> None:
        """Stop the clock."""
        if _Compiling.depth == 0:
            _Compiling.left, _Compiling.begin = signal.setitimer(signal.ITIMER_PROF, 0)[0], time.process_time()
        _Compiling.depth += 1

    def on_end(self, event: Any) -> None:
        """Let it go on."""
        _Compiling.depth -= 1
        if _Compiling.depth == 0:
            _Compiling.spent += time.process_time() - _Compiling.begin
            signal.setitimer(signal.ITIMER_PROF, _Compiling.left)


def judged(
    model: str,
    seed: int,
    index: int,
    questions: Iterable[str],
    limit: float = math.inf,
    skipped: Iterable[int] = (),
    tell: Callable[[int, str], None] = lambda number, name: None,
    starts: int = STARTS,
) -> JsonLine:
    """Judge one drive: its findings by stage and verdict, and in full those that are not right.

    ``questions``: names of the stages wanted; ``limit`` [s of CPU time]: a stage that takes longer ends the *process*,
    since a kernel that does not return cannot be stopped otherwise; ``skipped``: numbers of stages not to ask again;
    ``tell``: called with the number and name of a stage before it is asked; ``starts``: how many the drive has.
    """
    counts: Counter[str] = Counter()
    notable: list[JsonLine] = []
    wide = wide_drive(model, seed, index, starts)
    longest = 0.0
    for number, (name, ask) in enumerate(judges.stages(wide, questions)):
        if number in skipped:
            continue
        tell(number, name)
        begin = time.process_time() - _Compiling.spent
        if limit < math.inf:
            signal.setitimer(signal.ITIMER_PROF, limit)
        try:
            findings = ask()
            if callable(findings):  # the program has answered; who judges has no limit
                signal.setitimer(signal.ITIMER_PROF, 0)
                longest = max(longest, time.process_time() - _Compiling.spent - begin)
                findings, begin = findings(), math.inf
        except Exception as error:  # whatever it is, it is what the judge is after
            where = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(where.filename).name}:{where.lineno}"
            findings = [Finding(CRASHED, None, f"{type(error).__name__}: {error} ({place})")]
        if limit < math.inf:
            signal.setitimer(signal.ITIMER_PROF, 0)
        longest = max(longest, time.process_time() - _Compiling.spent - begin)
        for finding in findings:
            counts[f"{name} {finding.verdict}"] += 1
            if finding.verdict not in UNNOTED:
                notable.append({"stage": name, **finding._asdict()})
    return {"index": index, "counts": dict(counts), "longest": round(longest, 3), "notable": notable}


def _work(
    connection: Connection, place: Any, model: str, seed: int, questions: tuple[str, ...], limit: float, starts: int
) -> None:
    """Judge the drives whose numbers come through a pipe, and tell of every stage before it is asked."""
    register("numba:compiler_lock", _Compiling())
    judges.warm_up(model, questions)

    def tell(number: int, name: str) -> None:
        """Write down the stage that is asked."""
        place[1], place[2] = QUESTIONS.index(name), number

    while True:
        indices, skipped = connection.recv()
        for index in indices:
            place[0], place[2] = index, -1
            connection.send(judged(model, seed, index, questions, limit, skipped.get(index, ()), tell, starts))


class _Worker:
    """A process that judges, the drives that it has still to judge, and the stage at which it is."""

    def __init__(self, model: str, seed: int, questions: tuple[str, ...], limit: float, starts: int) -> None:
        self.arguments, self.patience = (model, seed, questions, limit, starts), max(_PATIENCE * limit, _WARM)
        self.process: Any = None
        self.indices: list[int] = []
        self.skipped: dict[int, tuple[int, ...]] = {}

    def give(self, indices: list[int]) -> None:
        """Have drives judged."""
        if self.process is None:
            context = get_context("spawn")
            self.connection, child = context.Pipe()
            self.place = context.Array("q", [-1, 0, -1], lock=False)  # drive, question, number of the stage
            self.process = context.Process(target=_work, args=(child, self.place, *self.arguments), daemon=True)
            self.process.start()
            child.close()
        self.indices = indices
        self.connection.send((indices, self.skipped))
        self._look()

    def _look(self) -> None:
        self.seen, self.deadline = self.place[:], time.monotonic() + self.patience

    def hear(self) -> JsonLine:
        """Take the record of the next drive. ``EOFError`` if the process has died."""
        record: JsonLine = self.connection.recv()
        self.indices.remove(record["index"])
        self._look()
        return record

    def stuck(self) -> bool:
        """Whether the process has not got on for longer than anybody waits."""
        if time.monotonic() <= self.deadline:
            return False
        if self.place[:] == self.seen:
            return True
        self._look()
        return False

    def stop(self) -> None:
        """End the process, whatever it is doing."""
        if self.process is not None:
            self.process.kill()
            self.process.join()
            self.connection.close()
            self.process = None


def run(
    model: str,
    seed: int,
    indices: Iterable[int],
    jobs: int,
    limit: float,
    questions: tuple[str, ...] = QUESTIONS,
    starts: int = STARTS,
) -> Iterator[JsonLine]:
    """Judge drives in ``jobs`` processes; yields their records in the order in which they are done."""
    workers = [_Worker(model, seed, questions, limit, starts) for _ in range(jobs)]
    waiting = iter(indices)
    lost: dict[int, list[JsonLine]] = {}  # what was stopped, by drive
    busy: list[_Worker] = []

    def supply(worker: _Worker) -> None:
        """Give a process what it has not done, or else the next drives; without any it is done."""
        more = worker.indices or list(islice(waiting, _CHUNK))
        if more:
            worker.give(more)
        elif worker in busy:
            busy.remove(worker)

    try:
        for worker in workers:
            supply(worker)
            if worker.indices:
                busy.append(worker)
        while busy:
            patience = max(0.0, min(worker.deadline for worker in busy) - time.monotonic())
            ready = wait([worker.connection for worker in busy], patience)
            for worker in list(busy):
                if worker.connection in ready:
                    try:
                        record = worker.hear()
                    except (EOFError, ConnectionError):
                        worker.process.join()
                        code = worker.process.exitcode
                    else:
                        yield _with_lost(record, lost.pop(record["index"], []))
                        if not worker.indices:
                            supply(worker)
                        continue
                elif worker.stuck():
                    code = -signal.SIGPROF
                else:
                    continue
                record = _after_death(worker, code, lost)
                worker.stop()
                if record is not None:
                    yield record
                supply(worker)
    finally:
        for worker in workers:
            worker.stop()


def _after_death(worker: _Worker, code: int, lost: dict[int, list[JsonLine]]) -> JsonLine | None:
    """Note the stage at which a process was stopped; the record of the drive if that was not even drawn."""
    index = worker.indices[0]
    at, question, number = worker.place[:]
    if at != index:  # it died before it began
        question, number = 0, -1
    stage = QUESTIONS[question] if number >= 0 else "draw"
    late = code == -signal.SIGPROF
    said = "stopped" if late else f"the process died ({code})"
    lost.setdefault(index, []).append({"stage": stage, **Finding(LATE if late else CRASHED, None, said)._asdict()})
    if number >= 0:
        worker.skipped[index] = (*worker.skipped.get(index, ()), number)
        return None
    worker.indices.pop(0)
    return _with_lost({"index": index, "counts": {}, "longest": 0.0, "notable": []}, lost.pop(index))


def _with_lost(record: JsonLine, lost: list[JsonLine]) -> JsonLine:
    for entry in lost:
        key = f"{entry['stage']} {entry['verdict']}"
        record["counts"][key] = record["counts"].get(key, 0) + 1
    record["notable"] = [*lost, *record["notable"]]
    return record
