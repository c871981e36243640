"""What the page shows, as one value that a link carries unchanged; and the views of the chapter's figures."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import Any, Self
from urllib.parse import urlencode

import yaml

from lsvib import numbers
from lsvib.api import RigidDrive, drive_class
from lsvib.basins.curves import Window
from lsvib.errors import InputError
from lsvib.figures.configuration import DEFAULT
from lsvib.models.drive import Drive, described
from lsvib.models.model import all_models
from lsvib.models.scene import Scene, read_yaml

_WINDOW = ("left", "right", "bottom", "top")
_RANGE = ("over", "low", "high")


@dataclass(frozen=True)
class View:
    """A drive, a motion of it, a part of its phase plane and a parameter to vary.

    ``u`` [rad] and ``w`` [rad/s], where the motion starts; ``duration`` [s]; ``window`` of the phase plane
    [rad, rad/s], None for one that holds the motion and its limit cycle; ``over``, the parameter of the amplitude
    curve, from ``low`` to ``high`` in its SI unit. Raises ``InputError`` for what is not acceptable.
    """

    drive: Drive = field(default_factory=RigidDrive)
    u: float = 0.003
    w: float = 0.0
    duration: float = 0.1
    window: Window | None = None
    over: str = "axial_force"
    low: float = 1.0
    high: float = 60.0

    def __post_init__(self) -> None:
        """Check everything that a link may have got wrong."""
        self.scene()
        if self.window is not None:
            left, right, bottom, top = self.window
            if not (left < right and bottom < top):
                raise InputError("the window of the phase plane needs left < right and bottom < top.")
        if self.over not in type(self.drive).model_fields:
            raise InputError(f"over = {numbers.shown(self.over)} is not a parameter of the model {self.drive.model}.")
        if not self.low < self.high:
            raise InputError(f"the amplitude curve goes from {self.low:g} to {self.high:g}; it needs low < high.")
        for end in (self.low, self.high):
            self.drive.replace(**{self.over: end})

    def _scene(self, drive: Any) -> dict[str, Any]:
        start = {"u": self.u, "w": self.w}
        scene = {"model": self.drive.model, "drive": drive, "start": start}
        return {**scene, "duration": self.duration, "samples": 2001}  # no corner of the line is seen

    def _changed(self) -> dict[str, float]:
        """The parameters that differ from their defaults."""
        return {key: value for key, value in self.drive if value != type(self.drive).model_fields[key].default}

    def scene(self) -> Scene:
        """Return the scene of the motion."""
        return Scene(**self._scene(self.drive))

    def yaml(self) -> str:
        """Return the scene as YAML, as ``lsvib simulate --scene`` reads it."""
        return yaml.safe_dump(self._scene(self._changed()), sort_keys=False)

    def query(self) -> str:
        """Return the part of a link that says all of this; every number comes back with the same bits."""
        values: dict[str, Any] = {"model": self.drive.model}
        values |= {key: repr(value) for key, value in self._changed().items()}
        values |= {"u": repr(self.u), "w": repr(self.w), "duration": repr(self.duration)}
        values |= {"over": self.over, "low": repr(self.low), "high": repr(self.high)}
        if self.window is not None:
            values |= {name: repr(float(edge)) for name, edge in zip(_WINDOW, self.window, strict=True)}
        return urlencode(values)

    @classmethod
    def of(cls, query: Mapping[str, str]) -> Self:
        """Read a link; raises ``InputError`` in one sentence for a key or value that is not acceptable."""
        given = dict(query)
        kind = drive_class(given.pop("model", "rigid"))
        values: dict[str, Any] = {}
        for key in ("u", "w", "duration", *_RANGE[1:]):
            if key in given:
                values[key] = numbers.start(key, given.pop(key))
        if "over" in given:
            values["over"] = given.pop("over")
        edges = [given.pop(name) for name in _WINDOW if name in given]
        if edges:
            if len(edges) != len(_WINDOW):
                raise InputError("the window of the phase plane needs all of left, right, bottom and top.")
            values["window"] = Window(*(numbers.start(n, e) for n, e in zip(_WINDOW, edges, strict=True)))
        return cls(drive=kind.of(given), **values)


_LISTS = {  # key of a section: the parameter that it lists values of
    "masses": "mass",
    "axial_forces": "axial_force",
    "insets": "axial_force",
    "support_dampings": "support_damping",
    "dampings": "support_damping",
    "contact_dampings": "contact_damping",
}


def presets() -> dict[str, View]:
    """Return a view for each drive of each figure of the chapter, by a name such as "Figure 8.9: m = 11 kg"."""
    sections = read_yaml(DEFAULT)
    found: dict[str, View] = {}
    for name, section in sections.items():
        if name.startswith("fig8_"):
            found |= _of_figure(f"Figure 8.{int(name.removeprefix('fig8_'))}", section)
    return found


def _of_figure(label: str, section: Mapping[str, Any]) -> dict[str, View]:
    """The views of one figure: each of its drives."""
    shared = {**section["drive"], **{key: section[key] for key in section if _is_parameter(key, section[key])}}
    kind = _model({**shared, **{_LISTS.get(key, key): None for key in section}, **next(_cases(section), {})})
    starts = section.get("starts") or [section.get("start") or {}]
    start = starts[0] if "u" in starts[0] else {"u": View.u, "w": View.w}
    common: dict[str, Any] = {**start, "duration": section.get("duration", View.duration), "window": None}
    if {"angle", "velocity"} <= section.keys():
        angle, rate = section["angle"], section["velocity"]
        common["window"] = Window(angle["start"], angle["stop"], rate["start"], rate["stop"])
    found = {}
    for case in _cases(section):
        drive = kind.of({**shared, **case})
        about = ", ".join(_amount(kind, key, value) for key, value in case.items())
        found[f"{label}: {about}" if about else label] = View(drive=drive, **common, **_curve(drive, section))
    return found


def _cases(section: Mapping[str, Any]) -> Iterator[dict[str, float]]:
    """The drives of a figure, as what each adds to the shared parameters."""
    lists = [[{parameter: value} for value in section[key]] for key, parameter in _LISTS.items() if key in section]
    named = [section[key] for key in ("cases", "contacts") if key in section]
    for parts in product(*named, *lists):
        yield {key: value for part in parts for key, value in part.items()}


def _curve(drive: Drive, section: Mapping[str, Any]) -> dict[str, Any]:
    """The parameter that the figure varies, with its range; without one the default of a view."""
    for key, span in section.items():
        if key in type(drive).model_fields and isinstance(span, Mapping) and "start" in span:
            return {"over": key, "low": float(span["start"]), "high": float(span["stop"])}
    ends = sorted(
        math.copysign(end, drive.axial_force) for end in (View.low, max(View.high, 2 * abs(drive.axial_force)))
    )
    return {"over": "axial_force", "low": ends[0], "high": ends[1]}


def _model(values: Mapping[str, Any]) -> type[Drive]:
    """The first model that has all parameters among some keys; the rigid drive has no parameter of its own."""
    every = {key for kind in _drives() for key in kind.model_fields}
    return next(kind for kind in _drives() if (values.keys() & every) <= kind.model_fields.keys())


def _drives() -> list[type[Drive]]:
    return [model.drive for model in all_models().values()]


def _is_parameter(key: str, value: Any) -> bool:
    return isinstance(value, int | float) and any(key in kind.model_fields for kind in _drives())


def _amount(kind: type[Drive], key: str, value: float) -> str:
    about = described(kind, key)
    unit = "" if about["unit"] == "1" else f" {about['unit']}"
    return f"{about['symbol']} = {value:g}{unit}"
