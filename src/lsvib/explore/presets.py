"""Views of the drives of the chapter's figures, read from the settings of the figures, so that both stay one."""

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

from lsvib.api import DRIVES
from lsvib.basins.curves import Window
from lsvib.explore.view import View
from lsvib.figures.configuration import DEFAULT
from lsvib.models.drive import Drive, described
from lsvib.models.scene import read_yaml

_LISTS = {  # key of a section: the parameter that it lists values of
    "masses": "mass",
    "axial_forces": "axial_force",
    "insets": "axial_force",
    "support_dampings": "support_damping",
    "dampings": "support_damping",
    "contact_dampings": "contact_damping",
}
_DEFAULT = View()


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
    start = starts[0] if "u" in starts[0] else {"u": _DEFAULT.u, "w": _DEFAULT.w}
    common: dict[str, Any] = {**start, "duration": section.get("duration", _DEFAULT.duration), "window": None}
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
        math.copysign(end, drive.axial_force) for end in (_DEFAULT.low, max(_DEFAULT.high, 2 * abs(drive.axial_force)))
    )
    return {"over": "axial_force", "low": ends[0], "high": ends[1]}


def _model(values: Mapping[str, Any]) -> type[Drive]:
    """The first model that has all parameters among some keys; the rigid drive has no parameter of its own."""
    every = {key for kind in DRIVES.values() for key in kind.model_fields}
    return next(kind for kind in DRIVES.values() if (values.keys() & every) <= kind.model_fields.keys())


def _is_parameter(key: str, value: Any) -> bool:
    return isinstance(value, int | float) and any(key in kind.model_fields for kind in DRIVES.values())


def _amount(kind: type[Drive], key: str, value: float) -> str:
    about = described(kind, key)
    unit = "" if about["unit"] == "1" else f" {about['unit']}"
    return f"{about['symbol']} = {value:g}{unit}"
