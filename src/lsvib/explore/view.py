"""What the page shows, as one value: it goes into a link and comes out of it unchanged."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self
from urllib.parse import urlencode

import yaml

from lsvib import numbers
from lsvib.api import RigidDrive, drive_class
from lsvib.basins.curves import Window
from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.models.scene import Scene

SAMPLES = 2001  # of an exported motion: a line without visible corners on any screen
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
        return {**scene, "duration": self.duration, "samples": SAMPLES}

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
