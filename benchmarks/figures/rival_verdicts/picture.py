"""Verdicts on other methods over the sweeps: a bar for each method and family, the engine on top."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lsvib.figures import style

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
_HEIGHT, _WIDTH = 0.42, 0.9  # of a bar, in rows and columns; above it there is room for the numbers


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Draw shares of verdicts as bars, method by family, with the number of wrong ones and of cases."""
    words = list(style.flag_names(dataset.method_outcome).values())
    methods = ["lsvib", *map(_label, dataset.method.attrs["labels"].split("; "))]
    names = style.flag_names(dataset.edge_family)
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
    axes.tick_params(axis="x", labelsize=5.5)
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
    known = [style.flag_names(dataset.engine_verdict)[int(v)] for v in dataset.engine_verdict.values]
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
    axes.text(column - _WIDTH / 2, row - 0.24, f"{wrong}/{total}", va="bottom", fontsize=5.2,
              fontweight="bold" if wrong else "normal")  # fmt: skip
