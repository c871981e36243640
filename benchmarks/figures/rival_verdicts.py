"""Wrong verdicts of other methods over the sweeps: every method on a seeded sample of the cases of each family."""

import json
import math
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple

import numpy as np
import xarray as xr
from pydantic import Field

from benchmarks.record import Verdict
from benchmarks.rivals.methods import MODULES
from benchmarks.sweeps.families import FamilyName
from lsvib.datasets.attributes import flagged, named_index, variable
from lsvib.datasets.checks import Check
from lsvib.figures import style
from lsvib.figures.common import flag_names
from lsvib.figures.settings import CaseSeed, FigureSettings, Unique
from lsvib.figures.style import Axes, Figure

if TYPE_CHECKING:
    from benchmarks.judge import Answer
    from benchmarks.sweeps.families import Case

CAPTION = """\
Other methods on the cases of the sweeps: what they show, family by family, where 40 digits confirm the engine's motion.
A bar is the share of the cases; the numbers are wrong verdicts (other events than the true motion has) and cases. A
tolerance is what a method was asked for; a thousand times that error is still right. See docs/validation.md.
"""

NOT_ASKED = int(Verdict.NOT_RUN)  # of a case without a question: as a run that did not take place
WRONG = (Verdict.OTHER_EVENTS, Verdict.OTHER_MOTION)
_SOURCE = "docs/validation.md"
_PARTS = {  # verdict: colour, hatch, words
    "right": ("#D9E6F2", "", "right"),
    "inaccurate": (style.SKY, "", "right events, inaccurate"),
    "other events": (style.ORANGE, "", "wrong: other events, same end"),
    "other motion": (style.VERMILION, "", "wrong: other events, other end"),
    "gave up": ("white", "//////", "gave up"),
}
_WRONG = ("other events", "other motion")
_ENGINE = {  # its verdicts as those of the others; the rest is asked of nobody
    "right": "right",
    "refused": "gave up",
    "inaccurate": "inaccurate",
    "wrong": "other motion",
    "unbalanced": "other motion",
}
_Tolerances = Annotated[
    list[Annotated[float, Field(gt=0, le=10)]],
    *Unique,
    Field(max_length=20, description="Settings of a method, coarse to fine; [] leaves it out."),
]
_HEIGHT, _WIDTH = 0.42, 0.9  # of a bar, in rows and columns; above it there is room for the numbers


class Settings(FigureSettings):
    """Other methods at the edge of the domain."""

    needs: ClassVar = MODULES

    seed: CaseSeed
    counts: dict[FamilyName, Annotated[int, Field(ge=1, le=1_000_000)]] = Field(
        min_length=1, description="Number of cases of each family that every method is asked."
    )
    methods: dict[str, _Tolerances] = Field(description="Relative tolerances of each method; none leaves it out.")


class _Row(NamedTuple):
    """A case, the verdict on the engine, and the answers by method, None if not asked."""

    case: "Case"
    engine: Verdict
    answers: "list[Answer | None]"


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Ask the methods of :data:`benchmarks.rivals.method_list.METHODS`; ``InputError`` if a package is missing."""
    from benchmarks.rivals.on_sweeps import ask, pose
    from benchmarks.rivals.race import quiet
    from benchmarks.sweeps.cases import CaseFamily, cases

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
    from benchmarks.judge import VERDICTS
    from benchmarks.rivals.method_list import METHODS
    from benchmarks.sweeps import case_judge
    from benchmarks.sweeps.cases import CaseFamily

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
            "method_verdict": flagged(("case", "method"), verdict, "verdict on the method", words),
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
    from benchmarks.rivals.method_list import METHODS

    packages = {METHODS[name].needs for name, _ in entries} - {None}
    return {package: import_module(package).__version__ for package in sorted(packages)}


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw shares of verdicts as bars, method by family, with the number of wrong ones and of cases."""
    from matplotlib.patches import Patch

    words = list(flag_names(dataset.method_outcome).values())
    methods = ["lsvib", *map(_label, dataset.method.attrs["labels"].split("; "))]
    names = flag_names(dataset.edge_family)
    families = [names[int(f)].replace(" ", "\n") for f in dataset.edge_family.values]
    figure = style.new_figure(style.DOUBLE, 1.3 + 0.29 * len(methods))
    axes = figure.subplots()
    for row, counts in enumerate([_engine(dataset, words), *_others(dataset)]):
        for column, count in enumerate(counts):
            _bar(axes, row, column, dict(zip(words, count, strict=True)))
    axes.set_xticks(range(len(families) + 1), [*families, "all"])
    axes.set_yticks(range(len(methods)), methods)
    for ticks in (axes.get_yticklabels()[0], axes.get_xticklabels()[-1]):
        ticks.set_fontweight("bold")
    axes.tick_params(length=0, labelsize=6.5)
    axes.tick_params(axis="x", labelsize=6)
    axes.tick_params(axis="x", top=False, labeltop=True, bottom=False, labelbottom=False)
    axes.spines[:].set_visible(False)
    axes.axhline(0.4, color=style.BLACK, linewidth=0.6)
    axes.axvline(len(families) - 0.5, color=style.BLACK, linewidth=0.6)
    axes.set(xlim=(-0.55, len(families) + 0.5), ylim=(len(methods) - 0.55, -0.65))
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor=style.GREY, linewidth=0.4, label=text)
        for colour, hatch, text in _PARTS.values()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=5, fontsize=6.5, handlelength=1.5,
                  columnspacing=1.2, title="Share of cases; above a bar: wrong / all", title_fontsize=6.5)  # fmt: skip
    return figure


def _engine(dataset: xr.Dataset, words: list[str]) -> np.ndarray:
    """Count the verdicts on the engine (family and all, outcome).

    Cases at a corner, and those that digits beyond the input decide, have no one true motion: they are left out for
    all methods.
    """
    known = [flag_names(dataset.engine_verdict)[int(v)] for v in dataset.engine_verdict.values]
    verdict = np.array([words.index(_ENGINE[word]) if word in _ENGINE else -1 for word in known])
    groups = [dataset.case_family.values == family for family in dataset.edge_family.values]
    groups.append(np.ones(verdict.size, dtype=bool))
    return np.array([[(verdict[g] == k).sum() for k in range(len(words))] for g in groups])


def _others(dataset: xr.Dataset) -> np.ndarray:
    """Counts of the other methods, (method, family and all, outcome)."""
    families = dataset["count"].transpose("method", "edge_family", "method_outcome").values
    return np.concatenate([families, families.sum(axis=1, keepdims=True)], axis=1)


def _label(text: str) -> str:
    """A tolerance for the eye: "RK45, 1e-06" becomes "RK45, 10⁻⁶"."""
    name, _, tolerance = text.rpartition(", ")
    return f"{name}, 10{str(int(tolerance.partition('e')[2])).translate(style.SUPERSCRIPTS)}"


def _bar(axes: Axes, row: int, column: int, count: dict[str, int]) -> None:
    """One method on one family: shares of its verdicts, and how many are wrong."""
    total, left = sum(count.values()), column - _WIDTH / 2
    if not total:
        return
    for word, (colour, hatch, _) in _PARTS.items():
        width = _WIDTH * count[word] / total
        if width:
            look = {"color": colour, "hatch": hatch, "edgecolor": style.GREY, "linewidth": 0.3}
            axes.barh(row, width, _HEIGHT, left=left, **look)
        left += width
    wrong = sum(count[word] for word in _WRONG)
    axes.text(column - _WIDTH / 2, row - 0.24, f"{wrong}/{total}", va="bottom", fontsize=6,
              fontweight="bold" if wrong else "normal")  # fmt: skip
