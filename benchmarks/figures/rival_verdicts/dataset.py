"""Wrong verdicts of other methods over the sweeps: every method on a seeded sample of the cases of each family."""

import json
import math
from collections.abc import Mapping
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from benchmarks.record import Verdict
from benchmarks.rivals.answer_errors import VERDICTS, Answer
from benchmarks.rivals.method_list import METHODS
from benchmarks.rivals.on_sweeps import ask, pose
from benchmarks.rivals.race import quiet
from benchmarks.sweeps import case_judge
from benchmarks.sweeps.cases import Case, CaseFamily, cases
from lsvib.datasets.attributes import flagged, named_flags, named_index, variable
from lsvib.datasets.checks import Check

NOT_ASKED = int(Verdict.NOT_RUN)  # of a case without a question: as a run that did not take place
WRONG = (Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION)
_SOURCE = "docs/validation.md"


class _Row(NamedTuple):
    """A case, the verdict on the engine, and the answers by method, None if not asked."""

    case: Case
    engine: Verdict
    answers: list[Answer | None]


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Ask the methods of :data:`benchmarks.rivals.method_list.METHODS`; ``InputError`` if a package is missing."""
    entries = [(name, float(value)) for name, values in settings["methods"].items() for value in values]
    rows = []
    for name, count in settings["counts"].items():
        family = CaseFamily[name.upper()]
        rng = np.random.default_rng([settings["seed"], family])
        for case in cases(family, count, rng):
            engine, question = pose(case, rng)
            with quiet():
                answers = [ask(question, *entry) if question else None for entry in entries]
            rows.append(_Row(case, engine, answers))
    return _dataset(rows, entries, settings["seed"])


def _dataset(rows: list[_Row], entries: list[tuple[str, float]], seed: int) -> xr.Dataset:
    families = sorted({row.case.family for row in rows})
    family = np.array([row.case.family for row in rows], dtype=np.int8)
    verdict = np.array([[NOT_ASKED if a is None else a.verdict for a in row.answers] for row in rows], dtype=np.int8)
    error = np.array([[math.nan if a is None else a.error for a in row.answers] for row in rows], dtype=np.float32)
    level = np.array([row.case.level for row in rows])
    level = np.where(np.isfinite(level), level, np.nan).astype(np.float32)  # −inf is on the edge itself
    engine = np.array([row.engine for row in rows], dtype=np.int8)
    count = np.array([[(verdict[family == f] == v).sum(axis=0) for v in VERDICTS] for f in families], np.int32)
    count = count.transpose(0, 2, 1)
    ours = np.array([[((family == f) & (engine == v)).sum() for v in case_judge.VERDICTS] for f in families], np.int32)
    words = {NOT_ASKED: "not_asked", **{int(kind): kind.name.lower() for kind in VERDICTS}}
    return xr.Dataset(
        {
            "method_verdict": named_flags(("case", "method"), verdict, "verdict on the method", words),
            "error": variable(
                ("case", "method"), error, "1", "relative error of the right events and of the final state"
            ),
            "engine_verdict": flagged("case", engine, "verdict on the engine", case_judge.VERDICTS),
            "case_family": flagged("case", family, "family of the case", CaseFamily),
            "level": variable(
                "case", level, "1", "decimal logarithm of the parameter or of its distance from the edge"
            ),
            "count": variable(("edge_family", "method", "method_outcome"), count, "1", "number of cases"),
            "engine_count": variable(("edge_family", "engine_outcome"), ours, "1", "number of verdicts on the engine"),
            "relative_tolerance": variable("method", [x for _, x in entries], "1", "relative tolerance of the method"),
        },
        coords={
            "case": variable("case", np.arange(len(rows)), "1", "index of the case"),
            "edge_family": flagged("edge_family", families, "what is driven to the edge", CaseFamily),
            "method_outcome": flagged("method_outcome", VERDICTS, "verdict on a method", VERDICTS),
            "engine_outcome": flagged(
                "engine_outcome", case_judge.VERDICTS, "verdict on the engine", case_judge.VERDICTS
            ),
            "method": named_index(
                "method",
                "method",
                [f"{name}_{value:.0e}" for name, value in entries],
                labels="; ".join(f"{METHODS[name].label}, {value:.0e}" for name, value in entries),
            ),
        },
        attrs={
            "title": "Verdicts on other methods over the sweeps to the edge of the domain",
            "source": "lsvib; truth: the engine's motion where 40 digits have confirmed it",
            "references": "doi:10.1007/978-1-4419-1752-2_8; docs/validation.md",
            "seed": seed,
            "rival_versions": json.dumps(_versions(entries)),
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that the engine has no wrong verdict on the sample, and count those of the others."""
    faults = (Verdict.WRONG, Verdict.INACCURATE, Verdict.UNBALANCED)
    found = [int(dataset.engine_count.sel(engine_outcome=int(verdict)).sum()) for verdict in faults]
    total = dataset["count"].sum("edge_family")
    wrong = total.sel(method_outcome=list(map(int, WRONG))).sum("method_outcome").values
    gave_up = total.sel(method_outcome=int(Verdict.GAVE_UP)).values
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
            f"wrong and given up of {int(total.isel(method=0).sum())}: {'; '.join(words)}",
            bool((wrong + gave_up > 0).all()),
        ),
    ]


def _versions(entries: list[tuple[str, float]]) -> dict[str, str]:
    packages = {METHODS[name].needs for name, _ in entries} - {None}
    return {package: import_module(package).__version__ for package in sorted(packages)}
