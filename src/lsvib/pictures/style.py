"""One look for all figures: fonts, sizes, colours that colour-blind readers tell apart, labels from the metadata.

Importing this loads no matplotlib, so that figures can name colours and types while datasets are built without it.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from lsvib.files import File, replacing

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

PRINTED = dict[str, Any](color=BLACK, linewidth=0.6, linestyle=(0, (5, 3)))  # a value that the chapter prints

SINGLE = 3.5  # width of one journal column [inch]
DOUBLE = 7.2  # width of two columns [inch]

_STYLE: dict[Any, Any] = {
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
    "xtick.major.pad": 5,  # below the lowest label of the other axis
    "legend.frameon": False,
    "legend.fontsize": 7.5,
    "legend.columnspacing": 1.5,
    "figure.constrained_layout.use": True,
    "pdf.fonttype": 42,  # embed TrueType, so that text in the PDF stays text
}
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_LETTERS = {"\\times": "×", "\\Omega": "Ω", "\\lambda": "λ", "\\mu": "μ", "\\theta": "θ", "\\zeta": "ζ"}
_STATED = re.compile(r"(\S+) \(printed")  # a printed value among assumed ones


def styled(draw: Callable[..., Figure]) -> Callable[..., Figure]:
    """Decorate a ``draw`` function: it runs in our style, and the caller's matplotlib settings stay as they were."""
    return _look()(draw)


@contextmanager
def _look(**more: Any) -> Iterator[None]:
    """Our style, with indices of four fifths of the size, so that those of 7.5 pt are of 6 pt."""
    from matplotlib import _mathtext, rc_context

    factor, _mathtext.SHRINK_FACTOR = _mathtext.SHRINK_FACTOR, 0.8
    try:
        with rc_context(_STYLE | more):
            yield
    finally:
        _mathtext.SHRINK_FACTOR = factor


def new_figure(width: float = SINGLE, height: float = 2.8) -> Figure:
    """Return an empty figure of the given size [inch] that draws without a display (Agg, no pyplot)."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = FigureCanvasAgg(Figure(figsize=(width, height))).figure
    vars(figure)["_repr_png_"] = partial(_png, figure)  # by which notebooks show what is none of pyplot's
    return figure


def _png(figure: Figure) -> bytes:
    with _look(), BytesIO() as file:
        figure.savefig(file, format="png", dpi=144)
        return file.getvalue()


def label(variable: xr.DataArray, name: str | None = None) -> str:
    """Return an axis label "Long name symbol [unit]" from a variable's metadata; ``name`` replaces the long name."""
    text = name or variable.attrs.get("long_name", str(variable.name))
    parts = [text[:1].upper() + text[1:], variable.attrs.get("symbol", ""), unit(variable.attrs.get("units", "1"))]
    return " ".join(part for part in parts if part)


def frame(axes: Axes, title: str, x: xr.DataArray | str, y: xr.DataArray | str, **more: Any) -> None:
    """Give a panel its title, and both axes a variable's :func:`label` or words; ``more`` as ``axes.set`` takes it."""
    across, up = (name if isinstance(name, str) else label(name) for name in (x, y))
    axes.set(title=title, xlabel=across, ylabel=up, **more)


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


def stated(dataset: xr.Dataset) -> str:
    """Return which values a dataset holds for, by its metadata alone, without mathematics; empty where it has none.

    First come the parameters that the chapter prints elsewhere than in Table 8.1, then all that are assumed or given,
    as "symbol = value unit", each once: one value, a few of them, the range of many. Their attribute ``origin`` says
    which they are; of several values it names those that are printed and not assumed after the word "except".
    """
    words: dict[str, list[str]] = {"printed": [], "assumed": [], "given": []}
    origins = [variable.attrs.get("origin", "") for variable in dataset.variables.values()]
    for variable, origin in zip(dataset.variables.values(), origins, strict=True):
        if not origin.startswith(tuple(words)) or origin == "printed: Table 8.1":
            continue
        rule, _, exceptions = origin.partition(", except ")
        values = np.unique(variable.values)
        excepted = np.isin([f"{value:g}" for value in values], _STATED.findall(exceptions))
        for kind, found in words.items():
            chosen = values[~excepted if rule.startswith(kind) else excepted & (kind == "printed")]
            numbers = ", ".join(map(number, chosen))
            if chosen.size > 5:
                numbers = f"{number(chosen[0])} to {number(chosen[-1])}"
            name = variable.attrs.get("symbol", variable.attrs["long_name"])
            if chosen.size:
                found.append(f"{name} = {numbers} {unit(variable.attrs['units']).strip('[]')}".strip())
    heads = zip(("As printed: ", "Assumed: ", "Set by the user: "), words.values(), strict=True)
    parts = [f"{head}{', '.join(dict.fromkeys(found))}." for head, found in heads if found]
    if "printed: Table 8.1" in origins:
        parts.append("Otherwise Table 8.1." if parts else "Table 8.1.")
    text = re.sub(r"\^\{(-?\d+)\}", lambda power: power[1].translate(SUPERSCRIPTS), " ".join(parts))
    for command, letter in _LETTERS.items():
        text = text.replace(command, letter)
    return " ".join(text.replace("$", "").split())


def legend(figure: Figure, axes: Iterable[Axes], columns: int, first: Sequence[Any] = ()) -> Figure:
    """Put one legend above the panels: the ``first`` artists, then what the panels name.

    Each name is there once, with all colours in which it is drawn.
    """
    from matplotlib.legend_handler import HandlerTuple

    entries = dict[str, dict[str, Any]]()
    for artist in (*first, *(handle for panel in axes for handle in panel.get_legend_handles_labels()[0])):
        colour = artist.get_color() if hasattr(artist, "get_color") else ""
        entries.setdefault(artist.get_label(), {}).setdefault(colour, artist)
    look = {"handlelength": max([2, *map(len, entries.values())]), "handler_map": {tuple: HandlerTuple(None, pad=0.3)}}
    handles: Any = [(*own.values(),) for own in entries.values()]
    figure.legend(handles, [*entries], loc="outside upper center", ncols=columns, **look)
    return figure


def laid_out(figure: Figure) -> Figure:
    """Return the figure with its layout found, for what is placed by the size that panels have in the end."""
    if (layout := figure.get_layout_engine()) is not None:
        layout.execute(figure)
    return figure


def save(figure: Figure, png: File | None, pdf: File | None = None, *, resolution: float = 300) -> None:
    """Write the figure as PNG and PDF, each whole or not at all and without a date, so equal runs give equal files.

    ``png``, ``pdf``: None for none; ``resolution`` [dots per inch] of the PNG. The layout is found once, for the PNG;
    the PDF has the same. Raises ``LsvibError`` if a file cannot be written.
    """
    # With an engine of layout, be it the one named "none", each file would be drawn once more, unseen, to lay it out.
    with _look(**{"figure.constrained_layout.use": False}):
        figure.set_dpi(resolution)
        laid_out(figure).set_layout_engine(None)
        for path, kind, unsaid in ((png, "png", ["Software"]), (pdf, "pdf", ["CreationDate", "Producer"])):
            if path is not None:
                with replacing(path) as (part,):
                    figure.savefig(part, format=kind, metadata=dict.fromkeys(unsaid), dpi=resolution)
