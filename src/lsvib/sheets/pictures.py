"""The pictures of the report, each as an SVG that is embedded in the page."""

import base64
import io
from collections.abc import Callable
from typing import Any

import matplotlib
import numpy as np
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import EngFormatter

from lsvib.pictures import style
from lsvib.sheets.assessment import AssessedMotion, Assessment
from lsvib.sheets.from_rest import KINDS, Chart
from lsvib.sheets.words import MECHANISMS, entry_name

WIDTH = 3.7  # inch: on a phone one to one
_COLOURS = {
    "steady": "#E8F3EC",
    "steady_until_perturbed": "#F0D96B",
    "steady_once_started": "#CDB9DF",
    "steady_when_left_alone": "#D9D2C3",
    "jerks_from_rest": "#9DB7D9",
    "negative_damping": style.ORANGE,
    "kinematic_constraint": style.VERMILION,
    "mode_coupling": style.PURPLE,
    "falling_friction": style.SKY,
    "thread_contact": style.GREY,
}
_NAMES = {kind: MECHANISMS[kind][0].lower() if kind in MECHANISMS else kind.replace("_", " ") for kind in KINDS}
_SETTINGS: dict[Any, Any] = {"svg.hashsalt": "lsvib", "svg.fonttype": "path", "axes.formatter.limits": (-4, 5)}


def embedded(draw: Callable[..., Figure], *arguments: Any) -> str:
    """Return what ``draw`` draws as a data URI of an SVG; equal drawings give equal text."""
    with matplotlib.rc_context(_SETTINGS):
        figure = style.styled(draw)(*arguments)
        stream = io.BytesIO()
        with matplotlib.rc_context({**_SETTINGS, "font.family": "DejaVu Sans"}):
            figure.savefig(stream, format="svg", metadata={"Date": None})
    return "data:image/svg+xml;base64," + base64.b64encode(stream.getvalue()).decode("ascii")


def operating_chart(charts: list[Chart], chart: Chart, assessment: Assessment) -> Figure:
    """Regions of one of the charts over speed and force, and the operating window as a frame.

    The legend names what any of the charts shows, so that those side by side are alike.
    """
    figure = style.new_figure(WIDTH, 3.6)
    axis = figure.subplots()
    colours = ListedColormap([_COLOURS[kind] for kind in KINDS])
    norm = BoundaryNorm(np.arange(len(KINDS) + 1) - 0.5, len(KINDS))
    values, speed = assessment.draw.values, 1e3 * chart.speed
    axis.pcolormesh(speed, chart.force, chart.kind, cmap=colours, norm=norm, shading="nearest", rasterized=True)
    low, high = (1e3 * assessment.draw.travel * values[f"speed_{end}"] for end in ("low", "high"))
    bottom, height = values["force_low"], values["force_high"] - values["force_low"]
    if high > low and height > 0:
        axis.add_patch(Rectangle((low, bottom), high - low, height, fill=False, edgecolor=style.BLUE, linewidth=1.6))
    else:
        axis.plot([low, high], [bottom, bottom + height], "o-", color=style.BLUE, linewidth=1.6)
    axis.set(xlim=(0, speed[-1]), ylim=(chart.force[0], chart.force[-1]))
    axis.set(xlabel="Speed of the load [mm/s]", ylabel="Force against outward travel [N]")
    lifts = assessment.draw.lifts
    axis.set_title((("Lifting", "Lowering")[::lifts] if lifts else ("Outward", "Back"))[chart.direction < 0])
    seen = np.unique([one.kind for one in charts])
    handles = [Patch(color=_COLOURS[KINDS[k]], label=_NAMES[KINDS[k]]) for k in seen]
    handles.append(Patch(fill=False, edgecolor=style.BLUE, linewidth=1.6, label="operating window"))
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=7)
    return figure


def load_chart(motion: AssessedMotion) -> Figure:
    """Time history of the load in one motion."""
    figure = style.new_figure(WIDTH, 2.7)
    axis = figure.subplots()
    axis.plot(motion.vibration.time, motion.vibration.deviation, color=style.VERMILION, linewidth=0.9)
    axis.set(xlabel="Time", ylabel="Deviation of the load")
    axis.xaxis.set_major_formatter(EngFormatter("s"))
    axis.yaxis.set_major_formatter(EngFormatter("m"))
    axis.set_title("How the load moves")
    return figure


def sobol_chart(assessment: Assessment, name: str) -> Figure:
    """Shares of the spread of a reserve that the uncertain entries cause, each with all others; names above bars."""
    shares = sorted(assessment.uncertainty.sobol[name].items(), key=lambda pair: -pair[1])
    figure = style.new_figure(WIDTH, max(0.75 + 0.34 * len(shares), 1.4))
    axis = figure.subplots()
    for place, (entry, _) in enumerate(shares):
        axis.text(0.01, place - 0.3, entry_name(entry), fontsize=7, transform=axis.get_yaxis_transform())
    axis.barh(range(len(shares)), [share for _, share in shares], height=0.4, color=style.BLUE)
    axis.set(xlim=(0, 1.05), xlabel="Share of the spread", ylim=(len(shares) - 0.6, -0.8), yticks=[])
    return figure
