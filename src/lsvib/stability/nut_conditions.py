"""Rotating nut: the kinematic condition (8.33) and what it does to the critical mass (Remarks 8.5 and 8.6)."""

from typing import Any

from lsvib.engine.exact.arithmetic import many_digits
from lsvib.models import mechanics
from lsvib.models.drive import NutDrive
from lsvib.stability.linear import DriveValues, values_of


def effective_screw_inertia(drive: DriveValues) -> Any:
    """Return I_eff = I I_2 / (I + I_2) [kg m²] (Remark 8.6); below I, so the rotation of the nut destabilises."""
    p = values_of(drive, 1)
    with many_digits():
        return p.screw_inertia * p.nut_inertia / (p.screw_inertia + p.nut_inertia)


def kinematic_inertia(drive: DriveValues, law: int) -> Any:
    """Return I_eff − ξ_s tan λ m r_m² [kg m²]; steady sliding under law s = ±1 is unstable where it is negative (8.33).

    It equals det M_0 / (I + I_2). M_0 and K are symmetric and K is positive, so without it steady sliding can be lost
    neither by flutter nor – as det K > 0 – by divergence.
    """
    p = values_of(drive, law)
    with many_digits():
        inertia = effective_screw_inertia(drive)
        return mechanics.effective_inertia(inertia, p.mass, p.pitch_radius, p.tan_lead, p.factor)


def kinematic_mass(drive: NutDrive) -> float | None:
    """Mass [kg] at which (8.33) begins to hold under law +, I_eff / (ξ₊ tan λ r_m²); None if μ ≤ tan λ.

    It is smaller than the critical mass of the rigid drive by the factor I_2 / (I + I_2). With translation damping
    steady sliding can be lost at a smaller mass already (:mod:`lsvib.stability.boundaries`).
    """
    p = values_of(drive.exact(), 1)
    with many_digits():
        if p.factor <= 0:
            return None
        return float(effective_screw_inertia(drive.exact()) / (p.factor * p.tan_lead * p.pitch_radius**2))
