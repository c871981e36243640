"""The drawings of the page: phase plane with its map, amplitude curve, force over time, and the contact.

A source that changes is one message to the browser, and each message costs the server and the page about a
millisecond, whatever it holds. So what changes together is one source: ``map``, ``scene`` (motion, cycle and lines) and
``moment`` have a single row each, whose columns hold whole lines. A redraw is these three messages.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from bokeh.core import properties
from bokeh.models import (
    BasicTicker,
    BasicTickFormatter,
    ColumnDataSource,
    LinearScale,
    LogScale,
    LogTicker,
    LogTickFormatter,
    Range1d,
)
from bokeh.plotting import figure

from lsvib.basins.clipping import Window
from lsvib.drives.parameters import RigidParameters, described
from lsvib.explore import answers
from lsvib.explore.answers import Followed, Point
from lsvib.explore.view import View
from lsvib.figures.attraction.picture import COLOURS
from lsvib.figures.drawing import style

SLOPE = 0.22  # of the drawn threads, whatever the lead angle: those of most screws are too flat to be seen
_GAP = 0.06  # backlash of the drawn threads, in pitches; real ones have less
_SLIDE = 2.0  # lengths of the drawing that the screw moves for one radian
_MARKS = 0.5  # distance of the marks on the drawn screw
_TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
_NARROW = {"sizing_mode": "scale_width", "min_width": 320}  # a drawing shrinks with its column, down to a telephone
_COLUMNS = {  # of the sources
    "map": "image x y dw dh",
    "scene": "motion_u motion_w cycle_u cycle_w line_u line_w stop_u stop_w start_u start_w time force",
    "moment": "u w now tooth_x tooth_y marks_x marks_y foot tip words",
    "curve": "x y colour",
    "near": "x y colour",
    "marks": "x name",
    "bar": "x",
}


class Plots:
    """The drawings and their sources; every method replaces what a drawing shows."""

    def __init__(self) -> None:
        self.sources = {
            name: ColumnDataSource({key: [] for key in columns.split()}) for name, columns in _COLUMNS.items()
        }
        self.plane = self._plane()
        self.curve = self._curve()
        self.force = self._force()
        self.contact = self._contact()

    def _plane(self) -> figure:
        made = figure(
            width=620, height=470, **_NARROW, tools=_TOOLS, title="Phase plane: click where a motion shall start",
            x_range=Range1d(-1, 1), y_range=Range1d(-1, 1),
            x_axis_label="deviation u [rad]", y_axis_label="rate of the deviation u′ [rad/s]",
            name="plane", html_attributes={"aria-label": "Phase plane; its content is said in words below"},
        )  # fmt: skip
        made.image_rgba("image", x="x", y="y", dw="dw", dh="dh", source=self.sources["map"], level="image")
        for name, label, look in (
            ("line", "N = 0", {"color": style.VERMILION, "line_dash": properties.value([5, 3])}),
            ("stop", "θ′ = 0", {"color": style.GREY, "line_dash": properties.value([6, 2, 1, 2])}),
            ("cycle", "limit cycle", {"color": style.BLACK, "line_width": 2.5}),
            ("motion", "motion", {"color": style.BLUE, "line_width": 1.5}),
        ):
            made.multi_line(f"{name}_u", f"{name}_w", source=self.sources["scene"], legend_label=label, **look)
        start, now = self.sources["scene"], self.sources["moment"]
        made.scatter("start_u", "start_w", source=start, size=9, color=style.BLUE, fill_color="white")
        made.scatter("u", "w", source=now, size=9, color=style.VERMILION)
        made.scatter([0], [0], marker="cross", size=10, color=style.BLACK)
        made.legend.background_fill_alpha = 0.6
        made.legend.location = "top_right"
        made.axis.formatter = BasicTickFormatter(power_limit_low=-4)  # 0.003, not 3.000e-3
        return made

    def _curve(self) -> figure:
        made = figure(
            width=470, height=270, **_NARROW, tools=_TOOLS, title="Amplitude of the steady vibration",
            x_range=Range1d(0, 1), y_range=Range1d(0, 0.01), y_axis_label="amplitude [rad]", name="curve",
            html_attributes={"aria-label": "Amplitude over a parameter; its content is said in words below"},
        )  # fmt: skip
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
        made.legend.update(location="top_left", background_fill_alpha=0.6, padding=2, spacing=0)
        made.legend.label_text_font_size = "11px"
        return made

    def _force(self) -> figure:
        made = figure(
            width=470, height=210, **_NARROW, tools=_TOOLS, title="Normal force of the threads (without impulses)",
            x_range=Range1d(0, 1), y_range=Range1d(-1, 1), x_axis_label="time [s]", y_axis_label="N [N]", name="force",
            html_attributes={"aria-label": "Normal force over time; its content is said in words below"},
        )  # fmt: skip
        made.multi_line("time", "force", source=self.sources["scene"], color=style.BLUE)
        made.vspan(x="now", source=self.sources["moment"], color=style.VERMILION)
        made.hspan(y=[0.0], color=style.VERMILION, line_dash=[5, 3])
        return made

    def _contact(self) -> figure:
        made = figure(
            width=470, height=190, **_NARROW, tools="", title="Contact of screw and nut", name="contact",
            x_range=Range1d(-2, 2), y_range=Range1d(-0.8, 1.15),
            html_attributes={"aria-label": "Screw and nut; their contact is said in words below"},
        )  # fmt: skip
        made.axis.visible = made.grid.visible = False
        made.toolbar_location = None
        edges = np.array([-2.2, 2.2, 2.2, -2.2])
        for middle in (-0.5, 0.5):  # threads of the screw above and below the tooth of the nut
            heights = SLOPE * edges + middle + np.array([-0.25, -0.25, 0.25, 0.25])
            made.patch(edges, heights, color="#D0D0D0", line_color=style.GREY)
        source = self.sources["moment"]
        made.multi_line("marks_x", "marks_y", source=source, color=style.GREY, line_width=2)
        made.patches("tooth_x", "tooth_y", source=source, color=style.SKY, line_color=style.BLUE)
        made.segment(0, "foot", 0, "tip", source=source, color=style.VERMILION, line_width=3)
        made.scatter(0, "tip", source=source, color=style.VERMILION, size=8)
        # A title would have to be laid out anew with the whole page when it changes, which takes longer than all else.
        made.text(-1.95, 0.98, "words", source=source, text_font_size="12px")
        return made

    def set_window(self, window: Window) -> None:
        """Let the phase plane show a window."""
        self.plane.x_range.update(start=window.left, end=window.right)
        self.plane.y_range.update(start=window.bottom, end=window.top)

    def draw_map(self, labels: np.ndarray, window: Window) -> None:
        """Show labels (rows, columns) of a window as colours."""
        self.sources["map"].data = {
            "image": [answers.rgba(labels)],
            "x": [window.left],
            "y": [window.bottom],
            "dw": [window.right - window.left],
            "dh": [window.top - window.bottom],
        }

    def draw_motion(self, drive: RigidParameters, shown: Followed, window: Window) -> None:
        """Show a motion, its limit cycle and the lines N = 0 and θ′ = 0."""
        u, w = answers.contact_line(drive, window)
        closed = np.concatenate([shown.cycle, shown.cycle[:1]])
        self.sources["scene"].data = {
            "motion_u": [shown.u],
            "motion_w": [shown.w],
            "cycle_u": [closed[:, 0]],
            "cycle_w": [closed[:, 1]],
            "line_u": [u],
            "line_w": [w],
            "stop_u": [np.array([window.left, window.right])],
            "stop_w": [np.full(2, -drive.input_speed)],
            "start_u": shown.u[:1],
            "start_w": shown.w[:1],
            "time": [shown.time],
            "force": [shown.force],
        }
        end = float(shown.time[-1])
        self.force.x_range.update(start=-0.02 * end, end=1.02 * end)
        low, high = _steady_range(shown.force)
        self.force.y_range.update(start=low, end=high)

    def draw_moment(self, drive: RigidParameters, shown: Followed, k: int, words: str) -> None:
        """Show sample ``k`` of a motion: in the plane, over time, and as the contact of screw and nut, with ``words``.

        N > 0 balances R > 0, which pulls the nut upwards here, so the upper flank of the screw carries it.
        """
        force, time = float(shown.force[k]), float(shown.time[k])
        side = math.copysign(1.0, force) if force else 0.0
        tooth = np.array([-0.9, 0.9, 0.9, -0.9])
        half = 0.25 - _GAP
        turned = drive.input_speed * time + float(shown.u[k])
        at = (np.arange(-5, 5) * _MARKS - _SLIDE * turned) % (10 * _MARKS) - 5 * _MARKS
        at = np.concatenate([at, at])
        base = SLOPE * at + np.repeat([-0.5, 0.5], 10)
        gap = np.full(at.size, np.nan)  # ends the line of a mark
        most = float(np.abs(shown.force).max()) or 1.0
        self.sources["moment"].data = {
            "u": shown.u[k : k + 1],
            "w": shown.w[k : k + 1],
            "now": [time],
            "tooth_x": [tooth],
            "tooth_y": [SLOPE * tooth + side * _GAP + np.array([-half, -half, half, half])],
            "marks_x": [np.stack([at, at, gap], axis=1).ravel()],
            "marks_y": [np.stack([base - 0.15, base + 0.15, gap], axis=1).ravel()],
            "foot": [side * 0.25],
            "tip": [side * (0.25 - 0.42 * abs(force) / most)],
            "words": [words],
        }

    def start_curve(self, view: View, thresholds: Mapping[str, float]) -> None:
        """Clear the amplitude curve and set its axis, the drive's own value and its thresholds."""
        about = described(type(view.drive), view.over)
        decades = answers.logarithmic(view)
        self.curve.x_scale = LogScale() if decades else LinearScale()
        self.curve.xaxis.ticker = LogTicker() if decades else BasicTicker()
        self.curve.xaxis.formatter = LogTickFormatter() if decades else BasicTickFormatter()
        self.curve.xaxis.axis_label = f"{about['long_name']} {about['symbol']} {style.unit(about['unit'])}".rstrip()
        self.curve.x_range.update(start=view.low, end=view.high)
        self.sources["bar"].data = {"x": [getattr(view.drive, view.over)]}
        inside = {name: value for name, value in thresholds.items() if view.low <= value <= view.high}
        self.sources["marks"].data = {
            "x": list(inside.values()),
            "name": [name.replace("_", " ") for name in inside],
        }
        self.draw_curve([])

    def draw_curve(self, points: Sequence[Point]) -> None:
        """Show points of the amplitude curve, coloured by attractor."""
        for name, near in (("near", True), ("curve", False)):
            here = [point for point in points if point.near == near]
            self.sources[name].data = {
                "x": [point.value for point in here],
                "y": [point.amplitude for point in here],
                "colour": [COLOURS[point.label.name.lower().replace("_", " ")] for point in here],
            }
        amplitudes = np.array([point.amplitude for point in points if math.isfinite(point.amplitude)])
        # An axis of 0.01 rad where nothing vibrates; a range without numbers would be a warning of Bokeh's.
        low, high = _steady_range(amplitudes if np.any(amplitudes) else np.array([0.01]))
        self.curve.y_range.update(start=low, end=high)


def _steady_range(values: np.ndarray) -> tuple[float, float]:
    """Ends of a range around values and zero that mostly stay while the values change a little.

    An axis whose labels change their width lets the whole page be laid out anew.
    """
    low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
    step = 0.25 * 10 ** math.floor(math.log10(high - low or 1.0))  # four to forty of it from end to end
    return (math.floor(low / step) - 0.25) * step, (math.ceil(high / step) + 0.25) * step
