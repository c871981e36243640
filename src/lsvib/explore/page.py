"""One page in one browser: what is asked by hand, answered at once where it can be, and in small steps elsewhere."""

from asyncio import CancelledError, get_running_loop
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from html import escape
from itertools import pairwise
from math import pi, tan
from time import perf_counter
from typing import Any

import numpy as np
import xarray as xr
from bokeh.document import Document, without_document_lock
from bokeh.events import ClientReconnected, ConnectionLost, DocumentReady, RangesUpdate, Tap
from bokeh.layouts import column, row
from bokeh.models import CustomJS, Div, Row

from lsvib import numbers
from lsvib.drives import chapter, friction
from lsvib.drives.drive import PARTS, Drive
from lsvib.dynamics.curves import Window
from lsvib.errors import InputError, LsvibError
from lsvib.explore import answers
from lsvib.explore.controls import Controls
from lsvib.explore.plots import Plots
from lsvib.explore.view import View, around
from lsvib.pictures.attraction import COLOURS
from lsvib.systems.attractor import Attractor
from lsvib.words import plain

_TO_ADDRESS = """
const link = new DOMParser().parseFromString(cb_obj.text, "text/html").querySelector("a");
if (link) window.history.replaceState(null, "", link.getAttribute("href"));
"""


_HEADING = """
<h1 style="font-size:1.3em;margin:0 0 .2em">lsvib explorer</h1>
A motor turns a screw through a spring, the screw pushes a mass, and its threads rub. Drag a slider to change the drive;
click in the phase plane to start a motion there. Colours show what each start ends on.
"""
_TEMPLATE = """{% block preamble %}<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,"><style>[inert] {opacity: .3}</style>{% endblock %}
{% block contents %}<main>{{ super() }}</main>{% endblock %}"""
_COMPILING = "Loading the engine for this drive; at its first use it is compiled, which takes a minute."
# Seen on a telephone beside the sliders, too.
_ALERT = {"color": "#B00020", "background": "white", "position": "fixed", "inset": "0 0 auto", "z-index": "9"}
_NARROW = {"sizing_mode": "scale_width", "max_width": 640, "min_width": 320}  # as narrow as a telephone

THREAD = ThreadPoolExecutor(1)
"""Where slow work is done, piece by piece, so that pages answer meanwhile."""


class Page:
    """The page of one session; ``view`` is what it shows."""

    def __init__(self, document: Document, view: View, complaint: str = "") -> None:
        self.document, self.view, self._complaint = document, view, complaint
        self.controls = Controls(view, self.ask)
        self.plots = Plots()
        self._asked: dict[str, str] = {}
        self._answered = 0.0  # time of the last answer [s]
        self._settling: Any = None
        self._shares: dict[Attractor, float] = {}
        self._emptied = False  # nothing is shown while the engine for another drive is compiled
        self._alert = Div(name="alert", html_attributes={"role": "alert"}, styles=_ALERT)
        self._words = Div(
            name="words", sizing_mode="stretch_width", html_attributes={"role": "status", "aria-live": "polite"}
        )
        self._legend = Div(name="legend", sizing_mode="stretch_width")
        self._links = Div(name="links", sizing_mode="stretch_width")
        self._said = column(self._words, self._legend, self._links, name="said", sizing_mode="stretch_width")
        # The first link in the text, that to this view, becomes the address of the page.
        self._links.js_on_change("text", CustomJS(code=_TO_ADDRESS))
        self.plots.plane.on_event(Tap, lambda event: self.ask("start", f"{event.x} {event.y}"))
        self.plots.plane.on_event(RangesUpdate, lambda event: self.look_at(event.x0, event.x1, event.y0, event.y1))
        self._lay_out()
        document.js_on_event(DocumentReady, self.plots.clip, self.controls.names)
        # Without the server the sliders would move and the answer stay; a server that is back knows the address alone.
        document.js_on_event(ConnectionLost, CustomJS(code="document.querySelector('main').inert = true"))
        document.js_on_event(ClientReconnected, CustomJS(code="location.reload()"))
        # Nothing is computed for a request, which any page can make a browser send, but for a page that is open.
        document.on_event(DocumentReady, lambda event: self._answer())

    def ask(self, key: str, text: str) -> None:
        """Take a request of a control; requests that come within a moment of each other are answered together."""
        waiting = bool(self._asked)
        self._asked[key] = text
        if not waiting:
            alone = perf_counter() > self._answered + 0.02  # s
            # Requests that come while an answer is made are gathered for 8 ms; a single one is answered at once.
            self.document.add_timeout_callback(self._answer, 0 if alone else 8)

    def look_at(self, left: float, right: float, bottom: float, top: float) -> None:
        """Take the window that a hand has moved or zoomed to."""
        window = Window(left, right, bottom, top)
        if self.view.window is not None and not np.allclose(window, self.view.window, rtol=1e-9, atol=0):
            self.ask("window", " ".join(map(repr, map(float, window))))

    def _answer(self) -> None:
        asked, self._asked = self._asked, {}
        try:
            view = self._changed(asked)
            if answers.kind_of(view.drive) not in answers.READY:  # it is compiled beside the pages, which answer others
                self._asked, self._alert.text = asked, _COMPILING
                self._take_away(*self.plots.sources)
                self.view, self._emptied = replace(self.view), True  # an answer to the one before is late
                made = THREAD.submit(answers.make_ready, view)
                made.add_done_callback(lambda done: self.document.add_next_tick_callback(self._answer))
                return
            self._redraw(view)
            if any(not key.startswith("slider:") and key != "window" for key in asked):
                self.controls.show(self.view)
            self._alert.text, self._complaint = escape(self._complaint), ""
        except LsvibError as error:
            self._alert.text = escape(str(error))
            self.controls.show(self.view)
            if self._emptied:
                with suppress(LsvibError):  # of the first view of a page
                    self._redraw(self.view)
        self._answered = perf_counter()

    def _changed(self, asked: Mapping[str, str]) -> View:
        before = self._with_parts(asked["parts"].split()) if "parts" in asked else self.view
        parameters, changes = dict[str, Any](), dict[str, Any]()
        for key, text in asked.items():
            name = key.removeprefix("slider:")
            if name in Drive.model_fields:
                parameters[name] = text
            elif key == "over":
                changes |= {"over": text, **around(before.drive, text)}
            elif key == "window":
                changes["window"] = Window(*(numbers.start("window", edge) for edge in text.split()))
            elif key == "start":
                u, w = (numbers.start(key, each) for each in text.split())
                changes |= {"u": u, "w": w, "more": {}}  # what it has more is as in steady sliding
            elif key == "fit":
                changes["window"] = None
            elif key != "parts":
                changes[key] = numbers.start(key, text)
            if key.startswith("slider:") and name in self.controls.fields:
                self.controls.say_value(name, numbers.start(name, text))
        return replace(before, drive=before.drive.replace(**parameters), **changes)

    def _with_parts(self, parts: list[str]) -> View:
        """The same drive with other parts, those that are new as in the chapter."""
        drive = self.view.drive
        changes: dict[str, float | None] = {}
        for part, names in PARTS.items():
            if (part in parts) != (part in drive.parts):
                changes |= chapter.PARTS[part] if part in parts else dict.fromkeys(names)
        changed = drive.replace(**changes)
        over = self.view.over if getattr(changed, self.view.over) is not None else "axial_force"
        ends: dict[str, Any] = {} if over == self.view.over else around(drive, over)
        return replace(self.view, drive=changed, over=over, more={}, **ends)

    def _redraw(self, view: View) -> None:
        """Draw what can be drawn at once; a view without an answer leaves the page as it is."""
        shown = answers.followed(view)
        if view.window is None:
            view = replace(view, window=answers.window_around(view.drive, shown))
        window = view.window
        assert window is not None
        found = None
        if answers.at_once(view.drive):
            found = answers.labels(view.drive, window, answers.DRAGGED)
        elif (view.drive, view.window) != (self.view.drive, self.view.window):
            found = np.full(answers.cells_of(view.drive)[::-1], -2)
        self.view, self.shown, self._shares, self._emptied = view, shown, {}, False
        self._take_away("near", "curve", "marks", "bar")  # before anything of this view comes
        if found is not None:
            self.plots.draw_map(found, window)
        self.plots.draw_motion(view.drive, shown, window)
        self.plots.draw_friction(*answers.friction_visited(view.drive, shown))
        self._settling = self.document.add_timeout_callback(self._settle, 500)  # ms: the hand rests

    def _take_away(self, *sources: str) -> None:
        """Take away what is said of the view before, and what sources show of it."""
        if self._settling is not None:
            self.document.remove_timeout_callback(self._settling)
        self._settling, self._said.styles = None, {"visibility": "hidden"}
        for source in sources:
            if len(self.plots.sources[source].data["x"]):
                self.plots.fill(source)

    def _settle(self) -> None:
        """The hand rests: say in words and links what is shown, and begin what takes longer."""
        self._settling = None
        query = escape(self.view.query(), quote=True)
        files = (("scene.yaml", "scene as YAML"), ("motion.nc", "motion as netCDF"))
        links = [f'<a href="export/{name}?{query}" download="{name}">{text}</a>' for name, text in files]
        self._links.text = " &middot; ".join([f'<a href="?{query}">link to this view</a>', *links])
        self._say_words()
        self._said.styles = {"visibility": "visible"}
        self.document.add_next_tick_callback(self._find_out)

    @without_document_lock
    async def _find_out(self) -> None:
        """Find the fine map, the thresholds and the amplitude curve piece by piece, and draw each as it is known."""
        view, window, until = self.view, self.view.window, perf_counter() + 30.0
        if window is None or self._emptied:
            return

        def draw(show: Callable[..., None], *of: Any) -> None:
            self.document.add_next_tick_callback(lambda: show(*of) if view is self.view else None)

        async def found(work: Callable[..., Any], *of: Any) -> Any:
            """What a piece of work returns, done in a thread while pages answer."""
            if perf_counter() > until:
                raise InputError("This would take over half a minute; use lsvib attraction or lsvib sweep.")
            result = await get_running_loop().run_in_executor(THREAD, partial(work, *of))
            if view is not self.view:  # another one is shown by now
                raise CancelledError
            return result

        try:
            if not answers.laborious(view.drive):  # each point of a map would take a second
                cells = answers.cells_of(view.drive)
                count = 1 if answers.at_once(view.drive) else cells[1]  # of strips, the lowest first
                edges = pairwise(np.linspace(window.bottom, window.top, count + 1).tolist())
                strips = [Window(window.left, window.right, *pair) for pair in edges]
                part = cells[0], cells[1] // count
                labels = np.concatenate([await found(answers.labels, view.drive, strip, part) for strip in strips])
                self._shares = answers.shares(labels)
                draw(self.plots.draw_map, labels, window)
                draw(self._say_words)
            draw(self.plots.start_curve, view, await found(answers.thresholds_over, view))
            values, parts = answers.values_of(view, 61), []
            # What vibrates without a period takes up to half a second.
            size = len(values) if answers.at_once(view.drive) else 6
            for first in range(0, len(values), size):
                parts.append(await found(answers.curves, view, values[first : first + size]))
                curves = [xr.concat(sweeps, view.over, data_vars="minimal") for sweeps in zip(*parts, strict=True)]
                draw(self.plots.draw_curve, curves)
            draw(self._say_words, curves)
        except CancelledError:
            return
        except LsvibError as error:
            draw(partial(self._alert.update, text=escape(str(error))))

    def _say_words(self, curves: Sequence[xr.Dataset] = ()) -> None:
        view, shown, steady = self.view, self.shown, self.shown.steady
        rpm, lead = 30 / pi * view.drive.input_speed, 2e3 * pi * view.drive.pitch_radius * tan(view.drive.lead_angle)
        words = [f"The motion of {view.duration:g} s at {rpm:.4g} rpm (lead {lead:.4g} mm) has {shown.events} event"]
        words[0] += "." if shown.events == 1 else "s."
        if steady is None:
            words.append("Where it ends is unresolved.")
        elif steady.orbit is None:
            words.append(f"It ends on {plain(steady.label)}.")
        else:
            end = f"a {plain(steady.label)}".replace("a other", "another")
            load = 0.5e3 * float(np.ptp(steady.extremes(steady.orbit.automaton.observables["load_place"][0])))
            at_load = f"{load:.4g} mm" if load >= 0.1 else f"{1e3 * load:.4g} µm"
            words.append(f"It ends on {end} of amplitude {steady.amplitude:.4g} rad ({at_load} at the load) and period")
            words.append(f"{steady.period:.4g} s ({1 / steady.period:.4g} Hz).")
        try:
            stability = view.drive.stability()
            words.append(f"Steady sliding is {'stable' if stability.stable else 'unstable'} ({plain(stability.kind)}).")
        except InputError as error:
            words.append(str(error))
        if friction.depends_on_speed(view.drive):
            speeds, coefficients, visited = answers.friction_visited(view.drive, shown)
            speeds, coefficients = speeds[visited], coefficients[visited]
            words.append(
                f"The threads slide at {speeds[0]:.3g} to {speeds[-1]:.3g} m/s, with a friction coefficient of "
                f"{coefficients.min():.3g} to {coefficients.max():.3g}."
            )
        if answers.laborious(view.drive):
            words.append("No map is shown: with a friction law and compliant parts it takes too long; use")
            words.append("`lsvib attraction`.")
        if self._shares:
            parts = [f"{plain(kind)} {100 * share:.1f} %" for kind, share in self._shares.items()]
            words.append(f"Of the starts in the window: {', '.join(parts)}.")
        if curves:
            places = ("next to steady sliding", "where the motion does")
            vibrate = ", and ".join(map(_vibrating, curves, places))
            drives = f"{curves[0].amplitude.size} drives with {view.over} from {view.low:g} to {view.high:g}"
            words.append(f"Of {drives}, {vibrate}.")
        self._words.text = escape(" ".join([*words, view.note]).strip())
        patches = [
            f'<span style="display:inline-block;width:1em;height:1em;background:{COLOURS[plain(kind)]};opacity:.5">'
            f"</span>&nbsp;{plain(kind)}"
            for kind in self._shares
        ]
        self._legend.text = "&emsp;".join(["Regions of attraction:", *patches]) if patches else ""

    def _lay_out(self) -> None:
        c = self.controls
        start = _line(c.texts["u"], c.texts["w"], c.texts["duration"], c.fit)
        plane = column(self.plots.plane, self._alert, start, self._said, **_NARROW)
        curve = _line(c.over, c.texts["low"], c.texts["high"])
        others = column(self.plots.curve, curve, self.plots.force, self.plots.friction, **_NARROW)
        heading = Div(text=_HEADING, name="heading", sizing_mode="stretch_width")
        body = _line(plane, column(c.parts, c.all, c.parameters), others)
        self.document.add_root(column(heading, body, sizing_mode="stretch_width"))
        self.document.title = "lsvib explorer"
        self.document.template = _TEMPLATE


def _line(*parts: Any) -> Row:
    """Parts side by side, or below each other on a narrow screen."""
    return row(*parts, sizing_mode="stretch_width", styles={"flex-wrap": "wrap"})


def _vibrating(curve: xr.Dataset, place: str) -> str:
    """How many points of an amplitude curve vibrate that started in some place."""
    (over,), size = curve.dims, curve.amplitude.values
    values = curve[over].values[size > 0]
    where = f", between {values[0]:.4g} and {values[-1]:.4g}" if values.size else ""
    return f"{values.size or 'none'} vibrate when started {place}{where}"
