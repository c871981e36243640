"""The engine at the edge of the domain: digits that are right, family by family, and where they are lost."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from lsvib.figures import style

_ALL = 17.0  # digits of an error that is zero
_EDGES = {  # families with a distance from the edge: colour, marker, words
    "critical mass": (style.BLUE, "o", "critical mass"),
    "friction": (style.GREEN, "^", "friction: 0, tan λ, cot λ"),
    "axial force": (style.ORANGE, "s", "thresholds of R"),
    "double rate": (style.PURPLE, "D", "double rate"),
}
_PASSED = ("right", "corner")


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw (a) the digits of every case, (b, c) the contact, (d) digits near the edges, (e) the energy balance."""
    figure = style.new_figure(style.DOUBLE, 7.0)
    axes = figure.subplot_mosaic([["a", "b"], ["a", "c"], ["d", "e"]], width_ratios=[1.5, 1],
                                 height_ratios=[1.1, 1.1, 0.9])  # fmt: skip
    digits = -np.log10(np.maximum(dataset.state_error.values, 10.0**-_ALL))
    asked = np.isfinite(digits)
    _families(axes["a"], dataset, digits, asked)
    _contact(figure, axes["b"], dataset, digits, "(b) compliant threads: digits right", "digits", 6, 16)
    condition = np.log10(dataset.condition.values)
    _contact(figure, axes["c"], dataset, condition, "(c) condition of the modal form", "log$_{10}$ condition", 0, None)
    _edges(axes["d"], dataset, digits, asked)
    _energy(axes["e"], dataset)
    return figure


def _is(variable: xr.DataArray, word: str) -> np.ndarray:
    values = {name: value for value, name in style.flag_names(variable).items()}
    return variable.values == values[word]


def _families(axes: Axes, dataset: xr.Dataset, digits: np.ndarray, asked: np.ndarray) -> None:
    names = style.flag_names(dataset.edge_family)
    outcomes = style.flag_names(dataset.outcome)
    total = int(dataset.case_count.sum())
    rng = np.random.default_rng(0)  # scatter of the dots across their row, no data
    for row, family in enumerate(dataset.edge_family.values):
        chosen = asked & (dataset.case_family.values == family)
        good = np.isin(dataset.case_verdict.values, [v for v, n in outcomes.items() if n in _PASSED])
        for part, colour, size in ((chosen & good, style.BLUE, 2.0), (chosen & ~good, style.VERMILION, 8.0)):
            height = row + rng.uniform(-0.3, 0.3, part.sum())
            axes.scatter(digits[part], height, s=size, color=colour, linewidths=0, alpha=0.6, rasterized=True)
        limits = dataset.sensitivity.values[chosen]
        limits = limits[np.isfinite(limits) & (limits > 0)]
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
        title=f"(a) {total:,} cases, judged by 40 digits",
        xlabel="Digits that are right",
        xlim=(-3.5, 24.5),
        ylim=(dataset.sizes["edge_family"] - 0.4, -0.6),
    )
    axes.set_xticks([4, 8, 12, 16])
    handles = (
        Line2D([], [], color=style.BLUE, marker="o", markersize=2.5, linestyle="none", label="a case"),
        Line2D([], [], color=style.VERMILION, marker="o", markersize=3.5, linestyle="none", label="not passed"),
        Line2D([], [], color=style.BLACK, marker="|", markersize=9, linestyle="none",
               label="what 16 units in the\nlast place of the\ninput may change"),
    )  # fmt: skip
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


def _edges(axes: Axes, dataset: xr.Dataset, digits: np.ndarray, asked: np.ndarray) -> None:
    for name, (colour, marker, words) in _EDGES.items():
        chosen = asked & _is(dataset.case_family, name)
        axes.scatter(dataset.level.values[chosen], digits[chosen], s=7, color=colour, marker=marker, linewidths=0,
                     alpha=0.7, label=words, rasterized=True)  # fmt: skip
    axes.axhline(-np.log10(float(dataset.passing_error)), color=style.GREY, linestyle=":", linewidth=0.9)
    axes.set(
        title="(d) next to the edges",
        xlabel="log$_{10}$ of the relative distance from the edge",
        ylabel="Digits of the final state",
        xlim=(-17, -1),
        ylim=(3.5, 18),
    )
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
    axes.set(title=f"(e) energy balance, {drawn.sum():,} motions", xlabel="Digits to which energy balances",
             ylabel="Motions")  # fmt: skip
    axes.legend(loc="upper left", handlelength=1.0)
