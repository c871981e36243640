"""The drawings of the page: phase plane with its map, amplitude curve, force over time, and the friction.

What a redraw changes is in few sources, since each is a message to the browser, and is painted on the upper one of the
two canvases of each drawing: title, axes, grid and legend below stay as they are.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from bokeh.models import (
    BasicTicker,
    BasicTickFormatter,
    ColumnDataSource,
    CustomJS,
    LinearScale,
    LogScale,
    LogTicker,
    LogTickFormatter,
    NoOverlap,
)
from bokeh.plotting import figure

from lsvib.answers.phase_plane import lines
from lsvib.drives.drive import Drive, described
from lsvib.dynamics.curves import Window
from lsvib.explore import answers
from lsvib.explore.answers import Followed
from lsvib.explore.view import View
from lsvib.pictures import style
from lsvib.pictures.attraction import COLOURS
from lsvib.systems.attractor import Attractor
from lsvib.words import plain

_TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
_NARROW = {"sizing_mode": "scale_width", "min_width": 320}  # a drawing shrinks with its column, down to a telephone
_LOOKS: dict[str, dict[str, list[Any]]] = {  # of the rows of the sources, before anything is drawn
    "map": {"image": [], "x": [], "y": [], "dw": [], "dh": []},
    "lines": {
        "x": [[], [], [], []],
        "y": [[], [], [], []],
        "label": ["N = 0", "θ′ = 0", "limit cycle", "motion"],
        "colour": [style.VERMILION, style.GREY, style.BLACK, style.BLUE],
        "dash": [[5, 3], [6, 2, 1, 2], [], []],
        "width": [1.0, 1.0, 4.5, 1.5],  # the motion ends on the cycle, which shows on both sides of it
    },
    "points": {  # the origin, and the start
        "x": [0.0, 0.0],
        "y": [0.0, 0.0],
        "marker": ["cross", "circle"],
        "colour": [style.BLACK, style.BLUE],
        "fill": [style.BLACK, "white"],
    },
    **{name: {"x": [], "y": []} for name in ("history", "law", "visited")},
    **{name: {"x": [], "y": [], "colour": []} for name in ("curve", "near")},
    "marks": {"x": [], "name": []},
    "bar": {"x": []},
}
# Painted without title, axes, grid and legend, which take longer than all that a redraw changes; seen once clipped.
_ABOVE = {"level": "overlay", "visible": False}
# Bokeh clips overlays to the whole drawing; these belong into its frame, as what lies below them.
_CLIP = """
for (const plot of plots)
  for (const renderer of plot.renderers) {
    Object.defineProperty(Bokeh.index.find_one(renderer), "needs_clip", {get: () => true});
    renderer.visible = true;
  }
"""


class Plots:
    """The drawings and their sources; every method replaces what a drawing shows."""

    def __init__(self) -> None:
        self.sources = {name: ColumnDataSource(looks) for name, looks in _LOOKS.items()}
        self.plane = self._plane()
        self.curve = self._curve()
        self.force = self._force()
        self.friction = self._friction()
        self.clip = CustomJS(args={"plots": [self.plane, self.force]}, code=_CLIP)

    def _plane(self) -> figure:
        made = _figure("plane", "Phase plane: click to start a motion", 620, 470, (-1, 1), (-1, 1))
        made.xaxis.axis_label, made.yaxis.axis_label = "deviation u [rad]", "rate of the deviation u′ [rad/s]"
        made.image_rgba("image", x="x", y="y", dw="dw", dh="dh", source=self.sources["map"], **_ABOVE)
        made.multi_line(
            "x", "y", source=self.sources["lines"], color="colour", line_dash="dash", line_width="width", **_ABOVE
        )
        made.scatter(
            "x", "y", source=self.sources["points"], marker="marker", size=9, line_color="colour", fill_color="fill",
            **_ABOVE,
        )  # fmt: skip
        looks = map(_LOOKS["lines"].get, ("label", "colour", "dash", "width"))
        for label, colour, dash, width in zip(*looks, strict=True):
            # A line of which nothing is seen stands in the legend for each line, which may lie outside the window.
            made.line([math.nan], [math.nan], legend_label=label, color=colour, line_dash=dash, line_width=width)
        _legend_below(made)
        made.axis.formatter = BasicTickFormatter(power_limit_low=-4)  # 0.003, not 3.000e-3
        made.xaxis.major_label_policy = NoOverlap()
        return made

    def _curve(self) -> figure:
        made = _figure("curve", "Amplitude of the steady vibration", 470, 270, (0, 1), (0, 0.01))
        made.yaxis.axis_label = "amplitude [rad]"
        made.vspan(x="x", source=self.sources["bar"], color=style.GREY, line_width=1)
        made.vspan(x="x", source=self.sources["marks"], color=style.BLACK, line_dash=[5, 3])
        made.text(
            "x", 0.0, "name", source=self.sources["marks"], angle=math.pi / 2, text_font_size="11px",
            x_offset=-3, y_offset=-20,
        )  # fmt: skip
        made.scatter("x", "y", source=self.sources["near"], color="colour", size=6, legend_label="from near sliding")
        made.scatter(
            "x", "y", source=self.sources["curve"], line_color="colour", fill_color=None, size=9,
            legend_label="from the start",
        )  # fmt: skip
        _legend_below(made)
        return made

    def _force(self) -> figure:
        made = _figure("force", "Normal force, without impulses", 470, 210, (0, 1), (-1, 1))
        made.xaxis.axis_label, made.yaxis.axis_label = "time [s]", "N [N]"
        made.hspan(y=[0.0], color=style.VERMILION, line_dash=[5, 3])
        made.line("x", "y", source=self.sources["history"], color=style.BLUE, **_ABOVE)
        return made

    def _friction(self) -> figure:
        made = _figure("friction", "Friction over the sliding speed", 470, 190, (0, 1), (0, 0.3), tools="")
        made.toolbar_location = None
        made.xaxis.axis_label, made.yaxis.axis_label = "sliding speed [m/s]", "coefficient"
        made.line("x", "y", source=self.sources["law"], color=style.BLACK)
        made.line("x", "y", source=self.sources["visited"], color=style.BLUE, line_width=4, line_alpha=0.5)
        return made

    def draw_friction(self, speeds: np.ndarray, coefficients: np.ndarray, visited: np.ndarray) -> None:
        """Show the coefficient (n) over sliding speeds (n) [m/s], and which (n) of them the motion takes."""
        self.fill("law", x=speeds, y=coefficients)
        self.fill("visited", x=speeds[visited], y=coefficients[visited])
        self.friction.x_range.update(start=0.0, end=float(speeds[-1]))
        self.friction.y_range.update(start=0.0, end=1.1 * float(coefficients.max()) or 1.0)

    def fill(self, source: str, **columns: Sequence[Any] | np.ndarray) -> None:
        """Show other rows of a source, or what stands in it before anything is drawn."""
        self.sources[source].data = {**_LOOKS[source], **columns}

    def draw_map(self, labels: np.ndarray, window: Window) -> None:
        """Show labels (rows, columns) of a window as colours."""
        sides = {"dw": [window.right - window.left], "dh": [window.top - window.bottom]}
        self.fill("map", image=[answers.rgba(labels)], x=[window.left], y=[window.bottom], **sides)

    def draw_motion(self, drive: Drive, shown: Followed, window: Window) -> None:
        """Show a motion in a window with its force, its limit cycle and the lines N = 0 and θ′ = 0."""
        self.plane.x_range.update(start=window.left, end=window.right)
        self.plane.y_range.update(start=window.bottom, end=window.top)
        line, rates = lines([drive]), np.array([window.bottom, window.top])
        angles = line["contact_line_angle"][1][0] + line["contact_line_slope"][1][0] * rates  # N = 0
        closed = np.concatenate([shown.cycle, shown.cycle[:1]])
        self.fill(
            "lines",
            x=[angles, np.array([window.left, window.right]), closed[:, 0], shown.u],
            y=[rates, np.full(2, -drive.input_speed), closed[:, 1], shown.w],
        )
        self.fill("points", x=[0.0, float(shown.u[0])], y=[0.0, float(shown.w[0])])
        self.fill("history", x=shown.time, y=shown.force)
        end = float(shown.time[-1])
        self.force.x_range.update(start=-0.02 * end, end=1.02 * end)
        low, high = _steady_range(shown.force)
        self.force.y_range.update(start=low, end=high)

    def start_curve(self, view: View, thresholds: Mapping[str, float]) -> None:
        """Set the axis of the amplitude curve, the drive's own value and its thresholds."""
        about = described(view.over)
        decades = answers.logarithmic(view)
        self.curve.x_scale = LogScale() if decades else LinearScale()
        self.curve.xaxis.ticker = LogTicker() if decades else BasicTicker()
        self.curve.xaxis.formatter = LogTickFormatter() if decades else BasicTickFormatter()
        self.curve.xaxis.axis_label = f"{about['long_name']} {about['symbol']} {style.unit(about['unit'])}".rstrip()
        self.curve.x_range.update(start=view.low, end=view.high)
        self.fill("bar", x=[getattr(view.drive, view.over)])
        inside = {name: value for name, value in thresholds.items() if view.low <= value <= view.high}
        self.fill("marks", x=list(inside.values()), name=[plain(name) for name in inside])

    def draw_curve(self, curves: Sequence[xr.Dataset]) -> None:
        """Show the amplitudes of two sweeps over one parameter, coloured by attractor."""
        for name, curve in zip(("near", "curve"), curves, strict=True):
            (over,) = curve.dims
            colours = [COLOURS[plain(Attractor(kind))] for kind in curve.attractor.values.tolist()]
            self.sources[name].data = {"x": curve[over].values, "y": curve.amplitude.values, "colour": colours}
        amplitudes = np.concatenate([curve.amplitude.values for curve in curves])
        amplitudes = amplitudes[np.isfinite(amplitudes)]
        # An axis of 0.01 rad where nothing vibrates; a range without numbers would be a warning of Bokeh's.
        low, high = _steady_range(amplitudes if np.any(amplitudes) else np.array([0.01]))
        self.curve.y_range.update(start=low, end=high)


def _figure(
    name: str, title: str, width: int, height: int, x: tuple[float, float], y: tuple[float, float], tools: str = _TOOLS
) -> figure:
    """An empty drawing whose axes are as long as a redraw says."""
    return figure(
        name=name, title=title, width=width, height=height, tools=tools, x_range=x, y_range=y,
        html_attributes={"role": "group", "aria-label": f"{title}; described in words below"}, **_NARROW,
    )  # fmt: skip


def _legend_below(made: figure) -> None:
    """Put the legend below a drawing, where it covers nothing."""
    made.legend.update(orientation="horizontal", border_line_color=None, padding=0, margin=0, spacing=8, glyph_width=16)
    made.legend.update(label_standoff=3, label_text_font_size="11px")
    made.add_layout(made.legend[0], "below")


def _steady_range(values: np.ndarray) -> tuple[float, float]:
    """Ends of a range around values and zero that mostly stay while the values change a little.

    An axis whose labels change their width lets the whole page be laid out anew.
    """
    low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
    step = 0.25 * 10 ** math.floor(math.log10(high - low or 1.0))  # four to forty of it from end to end
    return (math.floor(low / step) - 0.25) * step, (math.ceil(high / step) + 0.25) * step
