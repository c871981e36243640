"""Stability on stiff and extreme cases: the engine judged at the edge of the domain, family by family."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import xarray as xr
from pydantic import Field

from benchmarks.judge import Verdict
from benchmarks.sweeps.families import Case, CaseFamily, FamilyName
from lsvib.answers.attributes import flag_names, flagged, variable
from lsvib.chapter.checks import Check
from lsvib.chapter.settings import FigureSettings
from lsvib.pictures import style
from lsvib.pictures.style import Axes, Figure

if TYPE_CHECKING:
    from benchmarks.sweeps.case_judge import CaseOutcome

CAPTION = """\
The engine at the edge of its domain. (a) Correct digits of the final state, judged by a reference with 40 digits, 22
under a friction law, by family; vermilion: not passed; black, where computed: effect of 16 units in the last place of
the input. (b, c) Compliant threads over stiffness and damping of the contact, and the condition number of the modal
form; vermilion circles: not passed. (d) Digits against the distance from an edge, (e) against the sliding speed over
which friction falls from its static value, relative to the speed of steady sliding. (f) Digits to which the energy of
motions under constant friction balances; orange where rounding alone may exceed the tolerance. See docs/validation.md.
"""

_SOURCE = "docs/validation.md"
_NUMBERS = {
    "state_error": ("1", "error of the final state, relative to the size of the motion"),
    "time_error": ("1", "largest error of an event time, relative to the duration"),
    "sensitivity": ("1", "change of the final state when the last places of the input change"),
    "condition": ("1", "largest condition number of the modal forms"),
    "energy_residual": ("1", "residual of the energy balance, relative to the largest energy or work in it"),
    "energy_rounding": ("1", "residual of the energy balance that rounding may cause"),
}
_WORDS = {
    "level": "decimal logarithm of the parameter or of its distance from the edge",
    "damping_level": "decimal logarithm of the contact damping in N s/m",
    "energy_tolerance": "largest residual of the energy balance that passes, beyond rounding",
}
_WITH_PARTS = (CaseFamily.CONTACT, CaseFamily.SUPPORT, CaseFamily.NUT, CaseFamily.LAW_AND_PARTS)
_WITHOUT_BALANCE = [family for family in CaseFamily if family >= CaseFamily.FRICTION_LAW]
# Of the size or the duration: a speed that is zero to rounding ends a little early, see docs/validation.md.
_TOLERANCE_WITH_PARTS = 1e-8
_NOT_PASSED = 1e-3  # share of the cases that need not pass, without a wrong one among them,
_FEW = 3  # or this number, if that is more
_BALANCED = 0.99  # share of the motions whose energy must be balanced
_ALL = 17.0  # digits of an error that is zero
_EDGES = {  # families with a distance from the edge: colour, marker, words
    "critical mass": (style.BLUE, "o", "critical mass"),
    "friction": (style.GREEN, "^", "μ: 0, tan λ, cot λ"),
    "axial force": (style.ORANGE, "s", "thresholds of R"),
    "double rate": (style.PURPLE, "D", "double rate"),
    "vanishing friction": (style.SKY, "v", "μ(Ω) falls to 0"),
    "grazing": (style.WINE, "P", "touch, law"),
}
_LAWS = {
    "friction law": (style.BLUE, "o", "rigid drive"),
    "law and parts": (style.ORANGE, "s", "with parts"),
}
_PASSED = ("right", "corner")


class Settings(FigureSettings):
    """The engine at the edge of the domain."""

    engine: ClassVar = ("planar", "modal", "taylor")

    seed: int = Field(ge=0, description="Seed of the random cases.")
    counts: dict[FamilyName, Annotated[int, Field(ge=1, le=10_000_000)]] = Field(
        min_length=1, description="Number of cases of each family."
    )
    thorough: int = Field(ge=0, description="Cases of each family that the reference judges in any case.")


def build(settings: Mapping[str, Any]) -> xr.Dataset:
    """Run the sweeps; ``settings``: see ``Settings``."""
    from benchmarks.sweeps.case_judge import ENERGY_TOLERANCE, TOLERANCE, VERDICTS, judge
    from benchmarks.sweeps.cases import cases

    rows = []
    for name, count in settings["counts"].items():
        family = CaseFamily[name.upper()]
        rng = np.random.default_rng([settings["seed"], family])
        for k, case in enumerate(cases(family, count, rng)):
            outcome = judge(case, rng, thorough=k < settings["thorough"])
            outcome.path = None  # of no further use, and most of the memory
            rows.append((case, outcome))
    families = sorted({case.family for case, _ in rows})
    count = np.array([[sum(c.family == f and o.verdict == v for c, o in rows) for v in VERDICTS] for f in families])
    return xr.Dataset(
        _cases(rows) | {"case_count": variable(("edge_family", "outcome"), count, "1", "number of cases")},
        coords={
            "case": variable("case", np.arange(len(rows)), "1", "index of the case"),
            "edge_family": flagged("edge_family", families, "what is driven to the edge", CaseFamily),
            "outcome": flagged("outcome", VERDICTS, "verdict", VERDICTS),
            "passing_error": variable((), TOLERANCE, "1", "largest relative error that passes"),
            "energy_tolerance": variable((), ENERGY_TOLERANCE, "1", _WORDS["energy_tolerance"]),
        },
        attrs={
            "title": "The engine at the edge of the domain",
            "source": "lsvib, exact event-driven motion; judge: references with 40 digits, 22 under a friction law",
            "references": "doi:10.1007/978-1-4419-1752-2_8; docs/validation.md",
        },
    )


def checks(dataset: xr.Dataset) -> list[Check]:
    """Check that no verdict is wrong and hardly one but passed, accuracy and energy."""
    from benchmarks.sweeps.case_judge import TOLERANCE, VERDICTS

    total = dataset.sizes["case"]
    verdict, rigid = dataset.case_verdict.values, ~np.isin(dataset.case_family.values, _WITH_PARTS)
    inaccurate = verdict == Verdict.INACCURATE
    count = {kind: int((verdict == kind).sum()) for kind in VERDICTS}
    failed = total - count[Verdict.RIGHT] - count[Verdict.CORNER]
    worst = float(np.nanmax(dataset.state_error.values[rigid & (verdict != Verdict.BEYOND_INPUT)]))
    others = ~rigid & ~np.isin(verdict, (Verdict.BEYOND_INPUT, Verdict.REFUSED))
    errors = np.fmax(dataset.state_error.values, dataset.time_error.values)[others]
    return [
        Check.holds(
            "No wrong motion: in every case the engine has the events of an independent computation, in the same order",
            _SOURCE,
            f"{count[Verdict.WRONG]} wrong of {total}",
            count[Verdict.WRONG] == 0,
        ),
        Check.holds(
            f"At most one case in {1 / _NOT_PASSED:g}, or {_FEW} if that is more, does not pass",
            _SOURCE,
            f"{failed} of {total} do not: {count[Verdict.BEYOND_INPUT]} decided by digits beyond those of the input, "
            f"{count[Verdict.REFUSED]} refused with a reason, {count[Verdict.INACCURATE]} inaccurate, "
            f"{count[Verdict.UNBALANCED]} unbalanced; in {count[Verdict.CORNER]} others events swap at a corner",
            failed <= max(_FEW, _NOT_PASSED * total),
        ),
        Check.holds(
            f"Rigid drive: final states and event times to {TOLERANCE:.0e} in every case",
            _SOURCE,
            f"{int((inaccurate & rigid).sum())} above it; worst error against 40 digits {worst:.1e}",
            not bool((inaccurate & rigid).any()),
        ),
        Check.holds(
            f"Drives with parts: final states and event times to {_TOLERANCE_WITH_PARTS:.0e} in every case "
            "that is not refused and whose input decides it",
            _SOURCE,
            f"worst error {errors.max(initial=0.0, where=np.isfinite(errors)):.1e} of {errors.size} cases, "
            f"unknown in {int(np.isnan(errors).sum())}",
            bool(errors.size and (errors <= _TOLERANCE_WITH_PARTS).all()),
        ),
        _energy_check(dataset),
    ]


def _energy_check(dataset: xr.Dataset) -> Check:
    from benchmarks.sweeps.case_judge import allowed_residual

    residual, rounding = dataset.energy_residual.values, dataset.energy_rounding.values
    tolerance = float(dataset.energy_tolerance)
    drawn, asked = np.isfinite(residual), ~np.isin(dataset.case_family.values, _WITHOUT_BALANCE)
    asked &= dataset.case_verdict.values != Verdict.REFUSED
    astray = int((residual[drawn] > allowed_residual(rounding[drawn])).sum())
    sharp = drawn & (rounding <= tolerance)
    return Check.holds(
        "In every motion under constant friction the energies of supply, storage, friction, dampers and seizures "
        f"balance, to {tolerance:.0e} of the largest of them, and rounding",
        _SOURCE,
        f"{astray} of {int(drawn.sum())} do not, {int((asked & ~drawn).sum())} not drawn; in {int(sharp.sum())}, "
        f"where rounding is below {tolerance:.0e}, the largest residual is {float(residual[sharp].max()):.1e}",
        astray == 0 and bool(drawn[asked].mean() > _BALANCED),
    )


def _cases(rows: "list[tuple[Case, CaseOutcome]]") -> dict[str, tuple]:
    from benchmarks.sweeps.case_judge import VERDICTS

    damping = np.array([c.drive.contact_damping or np.nan for c, _ in rows])
    # On the edge itself the logarithm is −inf, which is stored as missing.
    level = np.array([case.level for case, _ in rows])
    found = {name: np.array([_number(o, name) for _, o in rows], np.float32) for name in _NUMBERS}
    if np.isnan(found["sensitivity"]).all():  # no case was asked for it
        del found["sensitivity"]
    return {
        "case_family": flagged("case", [c.family for c, _ in rows], "family of the case", CaseFamily),
        "level": variable("case", np.where(np.isfinite(level), level, np.nan).astype(np.float32), "1", _WORDS["level"]),
        "damping_level": variable("case", np.log10(damping).astype(np.float32), "1", _WORDS["damping_level"]),
        "case_verdict": flagged("case", [o.verdict for _, o in rows], "verdict on the case", VERDICTS),
        "events": variable("case", np.array([o.events for _, o in rows], np.int32), "1", "number of events"),
        **{name: variable("case", values, *_NUMBERS[name]) for name, values in found.items()},
    }


def _number(outcome: "CaseOutcome", name: str) -> float:
    if not name.startswith("energy_"):
        return getattr(outcome, name)
    return np.nan if outcome.energy is None else getattr(outcome.energy, name.removeprefix("energy_"))


def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the digits of every case, (b, c) the contact, (d, e) digits near edges, (f) the energy balance."""
    figure = style.new_figure(style.DOUBLE, 7.8)
    upper, lower = figure.subfigures(2, 1, height_ratios=[2.5, 1])
    axes = upper.subplot_mosaic("ab;ac", width_ratios=[1.5, 1]) | lower.subplot_mosaic("def", width_ratios=[1.3, 1, 1])
    digits = -np.log10(np.maximum(dataset.state_error.values, 10.0**-_ALL))
    asked = np.isfinite(digits)
    _families(axes["a"], dataset, digits, asked)
    _contact(upper, axes["b"], dataset, digits, "(b) threads: correct digits", "digits", 6, 16)
    condition = np.log10(dataset.condition.values)
    _contact(upper, axes["c"], dataset, condition, "(c) condition of modes", "log$_{10}$ condition", 0, None)
    _edges(axes["d"], dataset, digits, asked, _EDGES)
    axes["d"].set(title="(d) next to the edges", xlabel="log$_{10}$ of the relative distance", xlim=(-17, -1))
    _edges(axes["e"], dataset, digits, asked, _LAWS)
    axes["e"].set(title="(e) transition of a law", xlabel="log$_{10}$ of the relative speed")
    axes["d"].set_ylabel("Correct digits")
    _energy(axes["f"], dataset)
    return figure


def _is(variable: xr.DataArray, word: str) -> np.ndarray:
    values = {name: value for value, name in flag_names(variable).items()}
    return variable.values == values[word]


def _families(axes: Axes, dataset: xr.Dataset, digits: np.ndarray, asked: np.ndarray) -> None:
    from matplotlib.lines import Line2D

    names = flag_names(dataset.edge_family)
    outcomes = flag_names(dataset.outcome)
    total = int(dataset.case_count.sum())
    moved = dataset.get("sensitivity", np.nan * dataset.level).values
    rng = np.random.default_rng(0)  # scatter of the dots across their row, no data
    for row, family in enumerate(dataset.edge_family.values):
        chosen = asked & (dataset.case_family.values == family)
        good = np.isin(dataset.case_verdict.values, [v for v, n in outcomes.items() if n in _PASSED])
        for part, colour, size in ((chosen & good, style.BLUE, 2.0), (chosen & ~good, style.VERMILION, 8.0)):
            height = row + rng.uniform(-0.3, 0.3, part.sum())
            axes.scatter(digits[part], height, s=size, color=colour, linewidths=0, alpha=0.6, rasterized=True)
        limits = moved[chosen & (moved > 0)]
        if limits.size:
            axes.plot(-np.log10(limits.max()), row, marker="|", markersize=13, color=style.BLACK, linestyle="none")
        counts = {outcomes[int(v)]: int(n) for v, n in zip(dataset.outcome.values, dataset.case_count.values[row],
                                                           strict=True) if n}  # fmt: skip
        rest = ", ".join(f"{n} {word}" for word, n in counts.items() if word not in _PASSED)
        text = f"{sum(counts.values()):,} cases" + (f"\n{rest}" if rest else "")
        axes.text(17.6, row, text, va="center", fontsize=6, linespacing=1.1)
    axes.axvline(-np.log10(float(dataset.passing_error)), color=style.GREY, linestyle=":", linewidth=0.9)
    axes.set_yticks(range(dataset.sizes["edge_family"]), [names[int(f)] for f in dataset.edge_family.values])
    axes.set(
        title=f"(a) all {total:,} cases",
        xlabel="Correct digits",
        xlim=(-3.5, 25.5),
        ylim=(dataset.sizes["edge_family"] - 0.4, -0.6),
    )
    axes.set_xticks([4, 8, 12, 16])
    handles = [
        Line2D([], [], color=style.BLUE, marker="o", markersize=2.5, linestyle="none", label="a case"),
        Line2D([], [], color=style.VERMILION, marker="o", markersize=3.5, linestyle="none", label="not passed"),
        Line2D([], [], color=style.BLACK, marker="|", markersize=9, linestyle="none",
               label="effect of 16 units in\nthe last place of\nthe input"),
    ][: 2 + bool((moved > 0).any())]  # fmt: skip
    axes.legend(handles=handles, loc="upper left", fontsize=6.5, handletextpad=0.1, borderpad=0.2,
                frameon=True, framealpha=1.0, edgecolor="none")  # fmt: skip
    axes.text(9.15, dataset.sizes["edge_family"] - 0.6, "tolerance", fontsize=6, color=style.GREY, va="center")


def _contact(figure: Figure, axes: Axes, dataset: xr.Dataset, values: np.ndarray, title: str, words: str,
             low: float, high: float | None) -> None:  # fmt: skip
    here = _is(dataset.case_family, "contact")
    marks = axes.scatter(dataset.level.values[here], dataset.damping_level.values[here], c=values[here], s=7,
                         cmap="cividis", vmin=low, vmax=high, linewidths=0, rasterized=True)  # fmt: skip
    bad = here & ~_is(dataset.case_verdict, "right")
    axes.scatter(dataset.level.values[bad], dataset.damping_level.values[bad], s=22, facecolors="none",
                 edgecolors=style.VERMILION, linewidths=0.7)  # fmt: skip
    figure.colorbar(marks, ax=axes, label=words, pad=0.02)
    axes.set(title=title, xlabel=r"log$_{10}$ $k_c$ [N m⁻¹]", ylabel=r"log$_{10}$ $c_c$ [N s m⁻¹]")


def _edges(axes: Axes, dataset: xr.Dataset, digits: np.ndarray, asked: np.ndarray, families: Mapping) -> None:
    for name, (colour, marker, words) in families.items():
        chosen = asked & _is(dataset.case_family, name)
        axes.scatter(dataset.level.values[chosen], digits[chosen], s=7, color=colour, marker=marker, linewidths=0,
                     alpha=0.7, label=words, rasterized=True)  # fmt: skip
    axes.axhline(-np.log10(float(dataset.passing_error)), color=style.GREY, linestyle=":", linewidth=0.9)
    axes.set_ylim(2, 18)
    axes.legend(ncols=2, loc="lower left", fontsize=6.5, handletextpad=0.1, columnspacing=0.8)


def _energy(axes: Axes, dataset: xr.Dataset) -> None:
    residual, rounding = dataset.energy_residual.values, dataset.energy_rounding.values
    tolerance = float(dataset.energy_tolerance)
    digits = np.clip(-np.log10(np.maximum(residual, 10.0**-_ALL)), 0, _ALL)
    drawn = np.isfinite(residual)
    bins = np.arange(5.0, _ALL + 0.5, 0.5)
    parts = (
        (drawn & (rounding <= tolerance), style.BLUE, "rounding < 10$^{-10}$"),
        (drawn & ~(rounding <= tolerance), style.ORANGE, "more"),
    )
    axes.hist([digits[part] for part, *_ in parts], bins, stacked=True, color=[colour for _, colour, _ in parts],
              label=[label for *_, label in parts])  # fmt: skip
    axes.axvline(-np.log10(tolerance), color=style.GREY, linestyle=":", linewidth=0.9)
    axes.set_yscale("log")
    axes.set(title="(f) energy balance", xlabel="Digits to which it balances", ylabel="Motions")
    axes.legend(loc="upper left", handlelength=1.0)
