"""Wrong verdicts of other methods over the sweeps: every method on a seeded sample of the cases of each family."""

import json
import math
from collections import Counter
from collections.abc import Mapping
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from benchmarks.record import Verdict
from benchmarks.rivals.answer_errors import VERDICTS, Answer
from benchmarks.rivals.method_list import METHODS, find_method
from benchmarks.rivals.method_list import MethodFamily as Kind
from benchmarks.rivals.on_sweeps import Question, ask, pose
from benchmarks.rivals.race import quiet
from benchmarks.sweeps import case_judge
from benchmarks.sweeps.cases import Case, CaseFamily, CaseGroup, cases
from lsvib.data.attributes import flagged, named_flags, named_index, variable, yes_no
from lsvib.data.checks import Check

NOT_ASKED = int(Verdict.NOT_RUN)  # of a method that is not asked a case: as a run that did not take place
WRONG = (Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION)
_SOURCE = "docs/validation.md"
_SHARED = "over the cases that every method is asked"
_WORDS = {
    "error": "error of final state and event times, relative to the motion, where its events are right",
    "level": "decimal logarithm of the parameter or of its distance from the edge",
    "decay": "fastest rate of decay, integrated over the motion",
    "shortest_stay": "shortest time between two events, in shortest oscillations; missing where there are fewer "
    "than two",
    "shared_count": "number of cases, over those that every method is asked",
    "engine_count": "number of cases by verdict on the engine",
}


class _Row(NamedTuple):
    """A case, whether every method is asked it, the verdict on the engine, and the answers by method."""

    case: Case
    shared: bool
    engine: Verdict
    question: Question | None
    answers: list[Answer | None]


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Ask the methods of :data:`benchmarks.rivals.method_list.METHODS`; ``InputError`` if a package is missing."""
    entries = [(name, float(value)) for name, values in settings["methods"].items() for value in values]
    every = [True] * len(entries)
    fixed = [find_method(name).family == Kind.FIXED_STEP for name, _ in entries]
    rows = []
    for name, count in settings["counts"].items():
        family = CaseFamily[name.upper()]
        rng = np.random.default_rng([settings["seed"], family])
        for k, case in enumerate(cases(family, count + settings["more"].get(name, 0), rng)):
            shared = k < count
            engine, question = pose(case, rng)
            asked = every if shared else fixed
            with quiet():
                answers = [ask(question, *e) if question and a else None for e, a in zip(entries, asked, strict=True)]
            rows.append(_Row(case, shared, engine, question, answers))
    return _dataset(rows, entries, settings["seed"])


def _dataset(rows: list[_Row], entries: list[tuple[str, float]], seed: int) -> xr.Dataset:
    families = sorted({row.case.family for row in rows})
    family = np.array([row.case.family for row in rows], dtype=np.int8)
    shared = np.array([row.shared for row in rows])
    verdict = np.array([[NOT_ASKED if a is None else a.verdict for a in row.answers] for row in rows], dtype=np.int8)
    level = np.array([row.case.level for row in rows])
    level = np.where(np.isfinite(level), level, np.nan).astype(np.float32)  # −inf is on the edge itself
    engine = np.array([row.engine for row in rows], dtype=np.int8)
    count = _count(verdict, [family == f for f in families])
    together = _count(verdict, [shared])[0]
    ours = np.array([[((family == f) & (engine == v)).sum() for v in case_judge.VERDICTS] for f in families], np.int32)
    by_family, tolerances = ("edge_family", "method"), np.array([value for _, value in entries])
    words = {NOT_ASKED: "not_asked", **{int(kind): kind.name.lower() for kind in VERDICTS}}
    return xr.Dataset(
        {
            "method_verdict": named_flags(("case", "method"), verdict, "verdict on the method", words),
            "error": variable(("case", "method"), _errors(rows), "1", _WORDS["error"]),
            "engine_verdict": flagged("case", engine, "verdict on the engine", case_judge.VERDICTS),
            "case_family": flagged("case", family, "family of the case", CaseFamily),
            "group": flagged("case", [row.case.group for row in rows], "edge of the case", CaseGroup),
            "level": variable("case", level, "1", _WORDS["level"]),
            "shared": yes_no("case", shared, "whether every method is asked"),
            "decay": variable("case", _of_question(rows, "stiffness"), "1", _WORDS["decay"]),
            "shortest_stay": variable("case", _of_question(rows, "shortest_stay"), "1", _WORDS["shortest_stay"]),
            "count": variable((*by_family, "method_outcome"), count, "1", "number of cases"),
            "shared_count": variable(("method", "method_outcome"), together, "1", _WORDS["shared_count"]),
            "engine_count": variable(("edge_family", "engine_outcome"), ours, "1", _WORDS["engine_count"]),
            **_shares("", by_family, count, "share of wrong verdicts"),
            **_shares("shared_", ("method",), together, f"share of wrong verdicts, {_SHARED}"),
            "relative_tolerance": variable("method", tolerances, "1", "relative tolerance of the method"),
        },
        coords=_coordinates(len(rows), entries, families),
        attrs={
            "title": "Verdicts on other methods over the sweeps to the edge of the domain",
            "source": "lsvib; truth: the engine's motion where 40 digits have confirmed it",
            "references": "doi:10.1007/978-1-4419-1752-2_8; docs/validation.md",
            "seed": seed,
            "reasons": json.dumps(_reasons(rows, entries)),
            "examples": json.dumps(_examples(rows, entries)),
            "rival_versions": json.dumps(_versions(entries)),
        },
    )


def _coordinates(cases: int, entries: list[tuple[str, float]], families: list[CaseFamily]) -> dict[str, tuple]:
    return {
        "case": variable("case", np.arange(cases), "1", "index of the case"),
        "edge_family": flagged("edge_family", families, "what is driven to the edge", CaseFamily),
        "method_outcome": flagged("method_outcome", VERDICTS, "verdict on a method", VERDICTS),
        "engine_outcome": flagged("engine_outcome", case_judge.VERDICTS, "verdict on the engine", case_judge.VERDICTS),
        "method": named_index(
            "method",
            "method",
            [f"{name}_{value:.0e}" for name, value in entries],
            labels="; ".join(f"{METHODS[name].label}, {value:.0e}" for name, value in entries),
        ),
    }


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that the engine has no wrong verdict on the sample, and count those of the others."""
    faults = (Verdict.WRONG, Verdict.INACCURATE, Verdict.UNBALANCED)
    found = [int(dataset.engine_count.sel(engine_outcome=int(verdict)).sum()) for verdict in faults]
    shared = dataset.shared_count
    wrong = shared.sel(method_outcome=list(map(int, WRONG))).sum("method_outcome").values
    gave_up = shared.sel(method_outcome=int(Verdict.GAVE_UP)).values
    words = [
        f"{label} {n} and {m}"
        for label, n, m in zip(dataset.method.attrs["labels"].split("; "), wrong, gave_up, strict=True)
    ]
    return [
        Check.holds(
            "The engine is neither wrong nor inaccurate nor out of balance in any case that is drawn to ask the others",
            _SOURCE,
            f"{found[0]} wrong, {found[1]} inaccurate, {found[2]} unbalanced of {dataset.sizes['case']}",
            not any(found),
        ),
        Check.holds(
            "Every other method shows a wrong motion, or none, in some of the same cases",
            _SOURCE,
            f"wrong and given up of {int(shared.isel(method=0).sum())}: {'; '.join(words)}",
            bool((wrong + gave_up > 0).all()),
        ),
    ]


def _versions(entries: list[tuple[str, float]]) -> dict[str, str]:
    packages = {METHODS[name].needs for name, _ in entries} - {None}
    return {package: import_module(package).__version__ for package in sorted(packages)}


def _count(verdict: np.ndarray, groups: list[np.ndarray]) -> np.ndarray:
    """Number of cases by group, method and verdict."""
    found = [[[(verdict[group, m] == v).sum() for v in VERDICTS] for m in range(verdict.shape[1])] for group in groups]
    return np.array(found, dtype=np.int32)


def _shares(prefix: str, dims: tuple[str, ...], count: np.ndarray, words: str) -> dict[str, tuple]:
    """Share of wrong verdicts and the ends of its interval."""
    wrong, asked = count[..., [VERDICTS.index(v) for v in WRONG]].sum(axis=-1), count.sum(axis=-1)
    low, high = _wilson(wrong, asked)
    interval = "end of the interval of 95 % (Wilson)"
    return {
        f"{prefix}wrong_share": variable(dims, wrong / np.where(asked, asked, np.nan), "1", words),
        f"{prefix}wrong_share_low": variable(dims, low, "1", f"{words}: lower {interval}"),
        f"{prefix}wrong_share_high": variable(dims, high, "1", f"{words}: upper {interval}"),
    }


def _wilson(part: np.ndarray, total: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both ends of the interval of 95 % of a share, ``part`` of ``total`` (Wilson 1927); nan where that is 0."""
    n, z = np.where(total, total, np.nan), 1.959964
    share = part / n
    middle = (share + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z / (1 + z**2 / n) * np.sqrt(share * (1 - share) / n + z**2 / (4 * n**2))
    return np.maximum(middle - half, 0.0), np.minimum(middle + half, 1.0)


def _errors(rows: list[_Row]) -> np.ndarray:
    return np.array([[math.nan if a is None else a.error for a in row.answers] for row in rows], dtype=np.float32)


def _of_question(rows: list[_Row], name: str) -> np.ndarray:
    values = [math.nan if row.question is None else getattr(row.question, name) for row in rows]
    return np.where(np.isfinite(values), values, math.nan).astype(np.float32)


def _reasons(rows: list[_Row], entries: list[tuple[str, float]]) -> dict[str, dict[str, int]]:
    """Why each method gave up, and in how many of the cases that every method is asked."""
    found = {}
    for k, (name, value) in enumerate(entries):
        given = [row.answers[k] for row in rows if row.shared and row.answers[k] is not None]
        found[f"{name}_{value:.0e}"] = dict(Counter(a.failure for a in given if a.verdict is Verdict.GAVE_UP))
    return found


def _examples(rows: list[_Row], entries: list[tuple[str, float]]) -> dict[str, dict]:
    """The first case in which each method shows another motion, so that it can be run again."""
    found = {}
    for k, (name, value) in enumerate(entries):
        for row in rows:
            if row.answers[k] is not None and row.answers[k].verdict is Verdict.OTHER_MOTION:
                case = row.question.case
                found[f"{name}_{value:.0e}"] = {"family": case.family.name.lower(), "drive": dict(case.drive),
                                                "start": list(case.start), "duration": case.duration}  # fmt: skip
                break
    return found
