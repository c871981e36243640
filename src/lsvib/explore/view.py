"""What the page shows, as one value that a link carries unchanged."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self
from urllib.parse import urlencode

import yaml

from lsvib import numbers
from lsvib.api import Drive
from lsvib.drives.model import coordinates
from lsvib.drives.scene import Scene
from lsvib.dynamics.curves import Window
from lsvib.errors import InputError

_NUMBERS = ("u", "w", "duration", "low", "high")
OF_LAW = {  # ends between which the parameters of a friction law are looked at
    "static_friction_coefficient": (0.0, 0.5),
    "stribeck_rise": (0.0, 0.2),
    "stribeck_speed": (0.0, 0.1),
    "stribeck_exponent": (1.0, 2.0),
    "friction_slope": (-0.2, 0.2),
}


@dataclass(frozen=True)
class View:
    """A drive, a motion of it, a part of its phase plane and a parameter to vary.

    ``u`` [rad] and ``w`` [rad/s], where the motion starts, and ``more`` coordinates of drives with parts, the others as
    in steady sliding; ``duration`` [s]; ``window`` of the phase plane [rad, rad/s], None for one that holds the motion
    and its limit cycle; ``over``, the parameter of the amplitude curve, from ``low`` to ``high`` in its SI unit;
    ``note``, which no link carries: how the data sheet was read. Raises ``InputError`` for what is not acceptable.
    """

    drive: Drive = field(default_factory=Drive)
    u: float = 0.003
    w: float = 0.0
    duration: float = 0.1
    window: Window | None = None
    over: str = "axial_force"
    low: float = 1.0
    high: float = 60.0
    more: Mapping[str, float] = field(default_factory=dict)
    note: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        """Check everything that a link may have got wrong."""
        self.scene()
        if self.window is not None:
            Window.of(self.window)
        if self.over not in self.drive.model_dump(exclude_none=True):
            raise InputError(f"over = {numbers.shown(self.over)} is not a parameter of this drive.")
        if not self.low < self.high:
            raise InputError(f"the amplitude curve goes from {self.low:g} to {self.high:g}; it needs low < high.")
        for end in (self.low, self.high):
            self.drive.replace(**{self.over: end})

    def _scene(self, drive: Any) -> dict[str, Any]:
        start, samples = {"u": self.u, "w": self.w, **self.more}, 2001  # no corner of the line is seen
        return {"drive": drive, "start": start, "duration": self.duration, "samples": samples}

    def _changed(self) -> dict[str, float]:
        """The parameters that differ from their defaults."""
        return {key: value for key, value in self.drive if value != type(self.drive).model_fields[key].default}

    def scene(self) -> Scene:
        """Return the scene of the motion."""
        return Scene(**self._scene(self.drive))

    @classmethod
    def of_scene(cls, scene: Scene, note: str = "") -> Self:
        """Return the view of a scene; raises ``InputError`` if its motion is one that the page cannot show."""
        drive, start = Drive(**dict(scene.drive)), scene.start
        more = {key: value for key, value in start.items() if key not in ("u", "w")}
        view = cls(drive, start["u"], start["w"], scene.duration, more=more, note=note, **around(drive, cls.over))
        for key, word in (("rests", "physics"), ("command", "command"), ("resume", "resume")):
            if getattr(scene, key) != getattr(view.scene(), key):
                raise InputError(f"the page cannot show the {word} of this scene; lsvib simulate --scene does.")
        return view

    def yaml(self) -> str:
        """Return the scene as YAML, as ``lsvib simulate --scene`` reads it."""
        return yaml.safe_dump(self._scene(self._changed()), sort_keys=False)

    def query(self) -> str:
        """Return the part of a link that says all of this; every number comes back with the same bits."""
        values: dict[str, Any] = {key: repr(value) for key, value in self._changed().items()}
        values |= {key: repr(getattr(self, key)) for key in _NUMBERS} | {key: repr(x) for key, x in self.more.items()}
        values["over"] = self.over
        if self.window is not None:
            values |= {name: repr(float(edge)) for name, edge in self.window._asdict().items()}
        return urlencode(values)

    @classmethod
    def of(cls, query: Mapping[str, str]) -> Self:
        """Read a link; raises ``InputError`` in one sentence for a key or value that is not acceptable."""
        given = dict(query)
        values: dict[str, Any] = {key: numbers.start(key, given.pop(key)) for key in _NUMBERS if key in given}
        values["more"] = {key: numbers.start(key, given.pop(key)) for key in coordinates()[2:] if key in given}
        if "over" in given:
            values["over"] = given.pop("over")
        if edges := {name: numbers.start(name, given.pop(name)) for name in Window._fields if name in given}:
            if len(edges) != len(Window._fields):
                raise InputError("the window of the phase plane needs left, right, bottom and top.")
            values["window"] = Window(**edges)
        return cls(drive=Drive.of(given), **values)


def around(drive: Drive, key: str) -> dict[str, Any]:
    """Return a range of the amplitude curve over a parameter: from a hundredth of its value to twice, or above zero.

    Of a friction at rest it begins with that in sliding. Of a parameter of a friction law it is that of
    :data:`OF_LAW`, from a hundredth of the speed, which must not vanish beside a rise.
    """
    value = getattr(drive, key, 0.0)  # a name that is not known is refused with the view
    if key in OF_LAW:
        low, high = OF_LAW[key]
        return {"low": 0.01 * high if key == "stribeck_speed" else low, "high": high}
    if "_static_" in key and (sliding := getattr(drive, key.replace("_static", ""), 0.0)):
        return {"low": sliding, "high": 2 * max(value, sliding)}
    ends = sorted((0.01 * value, 2 * value)) if value else [0.0, 1.0]
    return {"low": ends[0], "high": ends[1]}
