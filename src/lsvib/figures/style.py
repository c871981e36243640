"""One look for all figures: fonts, sizes, colours that colour-blind readers tell apart, labels from the metadata.

Importing this loads no matplotlib, so a figure, whose dataset is built without it, may name colours and types freely.
"""

import os
import re
from collections.abc import Callable, Sequence
from functools import wraps
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from lsvib.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes as Axes
    from matplotlib.figure import Figure as Figure
else:  # names for annotations
    Axes = Figure = Any

# Okabe & Ito (2008), "Color universal design".
BLACK = "#000000"
ORANGE = "#E69F00"
SKY = "#56B4E9"
GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILION = "#D55E00"
PURPLE = "#CC79A7"
WINE, OLIVE = "#882255", "#999933"  # Tol (2021), "Colour schemes", muted
GREY = "#8C8C8C"

PRINTED = {"color": BLACK, "linewidth": 0.6, "linestyle": (0, (5, 3))}  # a value that the chapter prints

SINGLE = 3.5  # width of one journal column [inch]
DOUBLE = 7.2  # width of two columns [inch]

_STYLE = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so every machine draws the same
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.linewidth": 0.6,
    "axes.prop_cycle": "cycler('color', " + str([BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE, BLACK]) + ")",
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-3, 4),
    "lines.linewidth": 1.2,
    "lines.markersize": 4,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "figure.constrained_layout.use": True,
    "pdf.fonttype": 42,  # embed TrueType, so that text in the PDF stays text
}
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LETTERS = {"\\times": "×", "\\Omega": "Ω", "\\lambda": "λ", "\\mu": "μ", "\\theta": "θ", "\\zeta": "ζ"}
_STATED = re.compile(r"(\S+) \(printed")  # a printed value among assumed ones


def styled(draw: Callable[[xr.Dataset], Figure]) -> Callable[[xr.Dataset], Figure]:
    """Decorate a ``draw`` function: it runs in our style, and the caller's matplotlib settings stay as they were."""

    @wraps(draw)
    def in_style(dataset: xr.Dataset) -> Figure:
        """Draw in our style."""
        from matplotlib import rc_context

        with rc_context(_STYLE):
            return draw(dataset)

    return in_style


def new_figure(width: float = SINGLE, height: float = 2.8) -> Figure:
    """Return an empty figure of the given size [inch] that draws without a display (Agg, no pyplot)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    return figure


def label(variable: xr.DataArray, name: str | None = None) -> str:
    """Return an axis label "Long name symbol [unit]" from a variable's metadata; ``name`` replaces the long name."""
    text = name or variable.attrs["long_name"]
    parts = [text[:1].upper() + text[1:], variable.attrs.get("symbol", ""), unit(variable.attrs["units"])]
    return " ".join(part for part in parts if part)


def unit(units: str) -> str:
    """Return a unit for the eye: ``"N m s rad-1"`` becomes ``"[N m s rad⁻¹]"``, ``"1"`` becomes empty."""
    if units == "1":
        return ""
    return "[" + re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power.group().translate(SUPERSCRIPTS), units) + "]"


def number(value: float) -> str:
    """Return a number for a text: a minus sign in place of a hyphen, a power of ten where it is short."""
    text = f"{float(value):g}".replace("-", "−")
    if float(value) == 0 or ("e" not in text and 0.01 <= abs(float(value)) < 1e4):
        return text
    mantissa, power = f"{float(value):.3e}".split("e")
    factor = "" if float(mantissa) == 1 else f"{float(mantissa):g} \\times "
    return f"${factor}10^{{{int(power)}}}$"


def amount(variable: xr.DataArray, values: np.ndarray | None = None) -> str:
    """Return "symbol = value unit" of a parameter, or of some of its values: one, a few of them, the range of many."""
    values = np.unique(variable.values[np.isfinite(variable.values)]) if values is None else values
    if values.size > 5:
        text = f"{number(values[0])} to {number(values[-1])}"
    else:
        text = ", ".join(number(value) for value in values)
    name = variable.attrs.get("symbol", variable.attrs["long_name"])
    return f"{name} = {text} {unit(variable.attrs['units']).strip('[]')}".strip()


def amounts(dataset: xr.Dataset, kind: str) -> list[str]:
    """Return :func:`amount` of each parameter, as far as it is "printed" beyond Table 8.1, or "assumed", each once.

    The attribute ``origin`` of a parameter says which; of several values it names those that are printed and not
    assumed after the word "except".
    """
    found = []
    for variable in dataset.variables.values():
        origin = variable.attrs.get("origin", "")
        if not origin.startswith(("printed", "assumed")) or origin == "printed: Table 8.1":
            continue
        rule, _, exceptions = origin.partition(", except ")
        values = np.unique(variable.values)
        excepted = np.isin([f"{value:g}" for value in values], _STATED.findall(exceptions))
        chosen = values[excepted != rule.startswith(kind)]
        if chosen.size:
            found.append(amount(xr.DataArray(variable), chosen))
    return list(dict.fromkeys(found))


def state_values(figure: Figure, dataset: xr.Dataset, rest: str = "Otherwise Table 8.1.") -> None:
    """Write under a picture which values it holds for, by the metadata of the dataset alone.

    First come the parameters that the chapter prints elsewhere than in Table 8.1, then all that are assumed, then
    ``rest``. The text is broken where it would be wider than the figure.
    """
    words = [
        *enumeration("As printed: ", amounts(dataset, "printed")),
        *enumeration("Assumed: ", amounts(dataset, "assumed")),
    ]
    write_below(figure, [*words, rest if words else "All values: Table 8.1."])


def state_given(figure: Figure, dataset: xr.Dataset) -> None:
    """Write under a picture the parameters that were given for it."""
    given = [x for x in dataset.variables.values() if x.attrs.get("origin", "").startswith("given")]
    write_below(figure, enumeration("", [amount(xr.DataArray(x)) for x in given]))


def legend(figure: Figure, axes: Sequence[Axes], columns: int, first: Sequence[Any] = ()) -> None:
    """Put one legend above the panels: the ``first`` artists, then what the panels name, each name once."""
    entries = {artist.get_label(): artist for artist in first}
    for panel in axes:
        for handle, name in zip(*panel.get_legend_handles_labels(), strict=True):
            entries.setdefault(name, handle)
    figure.legend(entries.values(), entries.keys(), loc="outside upper center", ncols=columns)


def finished(
    figure: Figure, dataset: xr.Dataset, axes: Sequence[Axes], columns: int, first: Sequence[Any] = ()
) -> Figure:
    """Return a picture with its values below, :func:`state_values`, and one legend above, :func:`legend`."""
    state_values(figure, dataset)
    legend(figure, axes, columns, first)
    return figure


def write_below(figure: Figure, words: Sequence[str]) -> None:
    """Write pieces of a text under a picture, in as many lines as its width takes."""
    note = figure.supxlabel("", x=0.01, ha="left", fontsize=7, linespacing=1.4)
    room = 0.98 * figure.bbox.width
    lines: list[str] = []
    for word in words:
        note.set_text(f"{lines[-1]} {word}" if lines else word)
        if lines and note.get_window_extent().width <= room:
            lines[-1] = note.get_text()
        else:
            lines.append(word)
    note.set_text("\n".join(lines))


def plain(text: str) -> str:
    """Return words of a picture in one line and without mathematics: ``"$k_c$ = $10^{8}$"`` becomes ``"k_c = 10⁸"``."""
    text = re.sub(r"\^\{(-?\d+)\}", lambda power: power[1].translate(SUPERSCRIPTS), text)
    for command, letter in _LETTERS.items():
        text = text.replace(command, letter)
    return " ".join(text.replace("$", "").split())


def enumeration(start: str, items: Sequence[str]) -> list[str]:
    """Return the pieces of "start a, b, c." that a line break may part."""
    ends = [","] * (len(items) - 1) + ["."]
    return [f"{start if k == 0 else ''}{item}{end}" for k, (item, end) in enumerate(zip(items, ends, strict=False))]


def save(
    figure: Figure, png: str | os.PathLike[str], pdf: str | os.PathLike[str] | None = None, *, resolution: float = 300
) -> None:
    """Write the figure as PNG and PDF, each whole or not at all and without a date, so equal runs give equal files.

    ``pdf``: None for no PDF; ``resolution`` [dots per inch] of the PNG. The layout is found once, for the PNG; the PDF
    has the same. Raises ``LsvibError`` if a file cannot be written.
    """
    from matplotlib import rc_context

    metadata: dict[str, dict[str, Any]] = {"png": {"Software": None}, "pdf": {"CreationDate": None, "Producer": None}}
    # With an engine of layout, be it the one named "none", each file would be drawn once more, unseen, to lay it out.
    with rc_context(_STYLE | {"figure.constrained_layout.use": False}):
        figure.set_dpi(resolution)
        if (layout := figure.get_layout_engine()) is not None:
            layout.execute(figure)
            figure.set_layout_engine(None)
        for path, kind in ((png, "png"), (pdf, "pdf")):
            if path is None:
                continue
            with replacing(path) as part:
                figure.savefig(part, format=kind, metadata=metadata[kind], dpi=resolution)
