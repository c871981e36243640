"""What a hand or a keyboard moves on the page: every parameter of every model, start, duration, range of the curve."""

from collections.abc import Callable, Iterable
from typing import Any

from bokeh.layouts import column, row
from bokeh.models import Button, CheckboxGroup, Column, CustomJS, Select, Slider, TextInput

from lsvib.drives import friction
from lsvib.drives.complaints import allowed_range
from lsvib.drives.drive import IN_WORDS, PARTS, Drive, described, may_vanish
from lsvib.explore.view import OF_LAW, View
from lsvib.pictures import style

_FROM_ZERO = {  # end of a slider whose parameter is zero: enough to change what the chapter's drive does
    "translation_damping": 2000.0, "axial_force": 100.0, "support_damping": 1e-3, "friction_coefficient": 0.4,
    "contact_damping": 1e5, "axial_support_damping": 1e3, "nut_damping": 1e-3, "slide_friction": 50.0,
    "slide_static_friction": 100.0, "bearing_friction": 0.05, "bearing_static_friction": 0.1, "collar_friction": 0.3,
    "collar_radius": 0.02,
}  # fmt: skip
_SIGNED = ("axial_force", "input_speed")
_TEXTS = {
    "u": "Start u [rad]",
    "w": "Start u′ [rad/s]",
    "duration": "Duration [s]",
    "low": "Curve from",
    "high": "Curve to",
}

# Bokeh gives the handle that a keyboard moves no name.
_NAMES = """
const views = parameters.children.map(row => Bokeh.index.find_one(row.children[1]));
const name = view => view.slider_el.querySelector(".noUi-handle").ariaLabel = view.model.tags[0];
const kind = Object.getPrototypeOf(views[0]), {render} = kind;
kind.render = function() { render.call(this); name(this); };
views.forEach(name);
"""

Asked = Callable[[str, str], None]


class Controls:
    """The controls of one page; ``asked(key, text)`` is called when one of them is moved by hand."""

    def __init__(self, view: View, asked: Asked) -> None:
        self._asked, self._silent = asked, False
        self.parts = CheckboxGroup(labels=list(IN_WORDS.values()), width=300, name="parts")
        self.all = CheckboxGroup(labels=["show unused parameters, too"], width=300)
        self.over = Select(title="Curve over", width=190)
        self.texts = {key: TextInput(title=title, width=120) for key, title in _TEXTS.items()}
        self.fit = Button(label="Fit the window", width=110, align="end")
        self.sliders: dict[str, Slider] = {}
        self.fields: dict[str, TextInput] = {}
        self.parameters: Column = column(width=320, name="parameters")
        self.names = CustomJS(args={"parameters": self.parameters}, code=_NAMES)
        for key, control in (("over", self.over), *self.texts.items()):
            control.on_change("value", self._ask(key))
        self.all.on_change("active", lambda attribute, old, new: self.show(self._view))
        self.parts.on_change("active", self._ask("parts", lambda new: " ".join(tuple(PARTS)[k] for k in sorted(new))))
        self.fit.on_click(lambda: asked("fit", ""))
        self.show(view)

    def show(self, view: View) -> None:
        """Set the controls to a view, without asking anything by that."""
        self._silent, self._view = True, view
        try:
            every = view.drive.model_dump(exclude_none=True)  # without those of parts that are not there
            used = {*dict(view.drive), *(friction.NAMES if friction.depends_on_speed(view.drive) else ())}
            values = {key: value for key, value in every.items() if self.all.active or key in used}
            if self.fields.keys() != values.keys():
                self._make_fields(values)
            self.parts.active = [k for k, part in enumerate(PARTS) if part in view.drive.parts]
            self.over.options = list(every)
            self.over.value = view.over
            for key, control in self.texts.items():
                control.value = f"{getattr(view, key):.6g}"
            for key, value in values.items():
                self.fields[key].value = f"{value:.6g}"
                self._place(key, value)
        finally:
            self._silent = False

    def say_value(self, key: str, value: float) -> None:
        """Write a value that a slider gave into the field beside it."""
        self._silent = True
        self.fields[key].value = f"{value:.6g}"
        self._silent = False

    def _make_fields(self, keys: Iterable[str]) -> None:
        rows = []
        self.fields, self.sliders = {}, {}
        for key in keys:
            about = described(key)
            name = f"{about['long_name']} {about['symbol']} {style.unit(about['unit'])}".rstrip()
            self.fields[key] = TextInput(title=name, width=150, description=allowed_range(Drive, key), name=key)
            self.fields[key].stylesheets = ["label {width: 310px; white-space: normal}"]  # above the slider, too
            slider = Slider(start=0, end=1, value=0, step=1, width=150, show_value=False, align="end", tags=[name])
            self.sliders[key] = slider
            self.fields[key].on_change("value", self._ask(key))
            slider.on_change("value", self._ask(f"slider:{key}"))
            rows.append(row(self.fields[key], slider))
        self.parameters.children = rows

    def _place(self, key: str, value: float) -> None:
        if key in OF_LAW:
            low, high = OF_LAW[key]
            start, end = min(low, value), max(high, value)
            step = 1.0 if key == "stribeck_exponent" else (high - low) / 200  # finer than a hand
        else:
            end = 2 * abs(value) or _FROM_ZERO.get(key, 1.0)
            step = (2 if key in _SIGNED else 1) * end / 200
            start = -end if key in _SIGNED else 0.0 if may_vanish(key) else step
        self.sliders[key].update(start=start, end=end, step=step, value=value)

    def _ask(self, key: str, said: Callable[[Any], str] = str) -> Callable[[str, Any, Any], None]:
        def changed(attribute: str, old: Any, new: Any) -> None:
            if not self._silent and new != old:
                self._asked(key, said(new))

        return changed
