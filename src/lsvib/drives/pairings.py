"""Friction of pairings of screw and nut by name, from makers' tables and from measurements.

``friction="steel_on_bronze_lubricated"`` may replace ``friction_coefficient`` and the law wherever the parameters of a
drive are given. Tables state one typical number or a range, of which the middle is taken. They do not describe one
drive: load, speed, surface and lubricant matter more than their digits.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from lsvib.drives.friction import NAMES
from lsvib.errors import InputError
from lsvib.numbers import shown

_ROTON = "Roton, screw actions, table of friction"
_TRANSDEV = "Transdev, materials of chain guides, dynamic friction"
_ACETAL = f"{_TRANSDEV} on polished steel"
_IGUS = "igus, page of the material, dynamic friction on steel"
# A law that replaces another one replaces all of it.
_NO_LAW = {name: 1.0 if name == "stribeck_exponent" else 0.0 for name in NAMES}


@dataclass(frozen=True)
class Pairing:
    """Friction that has a name.

    ``low``, ``high``: the range of the coefficient [1], of kinetic friction if there is a law; ``source``, in words;
    ``law``: the parameters of the law that have an effect, by name.
    """

    low: float
    high: float
    source: str
    law: Mapping[str, float] = field(default_factory=dict)

    def parameters(self) -> dict[str, float]:
        """Return what the pairing states, by names of the parameters of a drive; of a range the middle."""
        return {"friction_coefficient": round(0.5 * (self.low + self.high), 12), **self.law}


def _one(coefficient: float, source: str, **law: float) -> Pairing:
    return Pairing(coefficient, coefficient, source, law)


PAIRINGS = {
    "steel_on_bronze_dry": _one(0.40, _ROTON),
    "steel_on_bronze_lubricated": _one(0.15, _ROTON),
    "steel_on_brass_dry": _one(0.35, _ROTON),
    "steel_on_brass_lubricated": _one(0.19, _ROTON),
    "steel_on_steel_dry": _one(0.80, _ROTON),
    "steel_on_steel_lubricated": _one(0.16, _ROTON),
    "steel_on_cast_iron_dry": _one(0.23, _ROTON),
    "steel_on_cast_iron_lubricated": _one(0.15, _ROTON),
    "steel_on_plastic_dry": _one(0.15, _ROTON),
    "steel_on_plastic_lubricated": _one(0.125, _ROTON),
    "acetal_dry": Pairing(0.15, 0.35, _ACETAL),
    "acetal_wet": Pairing(0.12, 0.20, _ACETAL),
    "acetal_oil": Pairing(0.05, 0.10, _ACETAL),
    "nylon_dry": Pairing(0.15, 0.40, _TRANSDEV),
    "ptfe_dry": Pairing(0.04, 0.25, _TRANSDEV),
    "uhmw_pe_dry": Pairing(0.10, 0.22, _TRANSDEV),
    "iglidur_j": Pairing(0.06, 0.18, _IGUS),
    "iglidur_j260": Pairing(0.06, 0.20, _IGUS),
    "iglidur_b": Pairing(0.18, 0.28, _IGUS),
    # Their law fades as exp(−2 |θ′| / 6.4 s): at 3.2 rad/s, on the effective radius of 5.5 mm and with the lead of 2 mm
    # at r_m |θ′| / cos λ = 17.63 mm/s.
    "measured_screw": _one(
        0.27,
        "measured, screw of 12 mm with a lead of 2 mm; Mablekos-Alexiou et al., IEEE Trans. Robotics 37 (2021) 1252",
        stribeck_rise=0.1,
        stribeck_speed=0.01763,
    ),
    # The slope is −4.47e-4 s/rad of θ′, over r_m / cos λ of Table 8.1.
    "powered_seat": _one(
        0.218,
        "the drive of Table 8.1; eqs 6.44-6.48 of Vahid-Araghi's thesis, as in example 4 of github.com/canbooo/duqo",
        stribeck_rise=0.0203,
        stribeck_speed=0.013704,
        friction_slope=-0.08588598956673593,
    ),
}


def stated(name: Any) -> dict[str, float]:
    """Return the parameters that a pairing states, by their names; ``InputError`` for a name that is not known."""
    if not isinstance(name, str) or name not in PAIRINGS:
        raise InputError(f"friction = {shown(name)} is not known; known are {', '.join(PAIRINGS)}.")
    return PAIRINGS[name].parameters()


def in_parameters(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters of a drive with what ``friction`` stands for in its place, a law as a whole.

    Raises ``InputError`` for a name that is not known, and for a parameter that is given as well.
    """
    if "friction" not in values:
        return dict(values)
    found = stated(values["friction"])
    for key in found:
        if key in values:
            raise InputError(f"friction and {key} are both given; give one of them.")
    return {**_NO_LAW, **{key: value for key, value in values.items() if key != "friction"}, **found}
