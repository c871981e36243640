"""Materials of screws and nuts by name, with their numbers and where these come from."""

from dataclasses import dataclass


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
    pv_limit: float
    source: str


# Modulus and yield strength of ASTM A36, AISI 304, aluminium 6061-T6, brass C83400, Ti-6Al-4V, which are low for
# their kind: Hibbeler, Mechanics of Materials, average mechanical properties.
SCREW_MATERIALS = {
    "steel": ScrewMaterial(7850.0, 200e9, 250e6),
    "stainless steel": ScrewMaterial(7900.0, 193e9, 207e6),
    "aluminium": ScrewMaterial(2700.0, 68.9e9, 255e6),
    "brass": ScrewMaterial(8500.0, 101e9, 70e6),
    "titanium": ScrewMaterial(4430.0, 120e9, 924e6),
}

_IGUS = "igus, material data of plain bearings, dry at 20 °C"
_MOTT = "Mott, Machine Elements in Mechanical Design, table of pV in boundary lubrication, as others quote it"
NUT_MATERIALS = {
    "iglidur_j": NutMaterial(35.0e6, 0.34e6, _IGUS),
    "iglidur_j260": NutMaterial(40.0e6, 0.35e6, _IGUS),
    "iglidur_b": NutMaterial(40.0e6, 0.15e6, _IGUS),
    "leaded_tin_bronze": NutMaterial(None, 2.625e6, _MOTT),
    "manganese_bronze": NutMaterial(None, 5.25e6, _MOTT),
    "nylon": NutMaterial(None, 0.105e6, _MOTT),
    "uhmw_pe": NutMaterial(None, 0.14e6, _MOTT),
}
