"""Materials of screws and nuts by name, with their numbers and where these come from (materials.yaml)."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lsvib.drives.pairings import PAIRINGS
from lsvib.drives.scene import read_yaml

_TABLE: dict[str, Any] = read_yaml(Path(__file__).with_name("materials.yaml"))


@dataclass(frozen=True)
class ScrewMaterial:
    """Density [kg/m³], to one per cent that of the usual alloys; Young's modulus and yield strength [Pa]."""

    density: float
    modulus: float
    yield_strength: float


@dataclass(frozen=True)
class NutMaterial:
    """What a nut bears, as its maker or a handbook says in ``source``; None is what they do not say.

    ``pressure_limit`` [Pa] of its projected area, ``pv_limit`` [Pa m/s] of pressure times sliding speed.
    """

    pressure_limit: float | None
    pv_limit: float | None
    source: str


SCREW_MATERIALS = {name: ScrewMaterial(*numbers) for name, numbers in _TABLE["screws"].items()}
NUT_MATERIALS = {name: NutMaterial(p, pv, _TABLE["sources"][by]) for name, (p, pv, by) in _TABLE["nuts"].items()}
_ALSO = {other: name for name, others in _TABLE["also"].items() for other in others.split()}


def common_name(name: Any) -> Any:
    """Return the name of a material in the tables for another one, such as acetal for POM, if there is one."""
    plain = re.sub(r"[\s-]+", "_", str(name).strip().lower())
    return _ALSO.get(plain, plain if plain in NUT_MATERIALS | SCREW_MATERIALS else name)


def pairings(nut: Any, screw: Any) -> dict[str, list[float]]:
    """Return the names of :data:`PAIRINGS` for a nut of one material on a screw of another (steel), with their ranges.

    >>> pairings("leaded_tin_bronze", None)
    {'steel_on_bronze_dry': [0.4, 0.4], 'steel_on_bronze_lubricated': [0.15, 0.15]}
    """
    nut, screw = common_name(nut), common_name(screw)
    if not isinstance(nut, str) or screw not in (None, "steel", "stainless steel"):
        return {}
    kind = "bronze" if nut.endswith("bronze") else nut
    found = {name: one for name, one in PAIRINGS.items() if f"{name.removeprefix('steel_on_')}_".startswith(f"{kind}_")}
    return {name: [one.low, one.high] for name, one in found.items()}
