"""One look for all figures: fonts, sizes, colours that colour-blind readers tell apart, labels from the metadata."""

import os
import re
from collections.abc import Callable
from functools import wraps
from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from lsvib.files import replacing

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
    "axes.prop_cycle": matplotlib.cycler(color=[BLUE, VERMILION, GREEN, ORANGE, SKY, PURPLE, BLACK]),
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


def styled(draw: Callable[[xr.Dataset], Figure]) -> Callable[[xr.Dataset], Figure]:
    """Decorate a ``draw`` function: it runs in our style, and the caller's matplotlib settings stay as they were."""

    @wraps(draw)
    def in_style(dataset: xr.Dataset) -> Figure:
        with matplotlib.rc_context(_STYLE):
            return draw(dataset)

    return in_style


def new_figure(width: float = SINGLE, height: float = 2.8) -> Figure:
    """Return an empty figure of the given size [inch] that draws without a display (Agg, no pyplot)."""
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


def flag_names(variable: xr.DataArray) -> dict[int, str]:
    """Return the words of a flag variable by value, with spaces: ``{0: "stable node", …}``."""
    words = [word.replace("_", " ") for word in variable.attrs["flag_meanings"].split()]
    # A single flag comes back from a file as a scalar.
    return dict(zip((int(value) for value in np.atleast_1d(variable.attrs["flag_values"])), words, strict=True))


def save(
    figure: Figure, png: str | os.PathLike[str], pdf: str | os.PathLike[str] | None = None, resolution: float = 300
) -> None:
    """Write the figure as PNG and PDF, each whole or not at all and without a date, so equal runs give equal files.

    ``pdf``: None for no PDF; ``resolution`` [dots per inch] of the PNG. Raises ``LsvibError`` if a file cannot be
    written.
    """
    metadata: dict[str, dict[str, Any]] = {"png": {"Software": None}, "pdf": {"CreationDate": None, "Producer": None}}
    with matplotlib.rc_context(_STYLE):
        for path, kind in ((png, "png"), (pdf, "pdf")):
            if path is None:
                continue
            with replacing(path) as part:
                figure.savefig(part, format=kind, metadata=metadata[kind], dpi=resolution)
