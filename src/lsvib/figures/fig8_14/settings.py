"""The settings of Figure 8.14."""

from typing import ClassVar

from pydantic import Field

from lsvib.figures.settings import MassPair, OpposingForces, PhasePlane, Span


class Settings(PhasePlane):
    """Trajectories under a negative axial force, for two readings of the mass."""

    unused: ClassVar = ("mass", "axial_force")

    masses: MassPair = Field(description="Mass as printed, and mass beyond the critical one [kg].")
    axial_forces: OpposingForces = Field(description="Axial forces of panels (a) and (b) [N].")
    angle: Span = Field(description="Deviations u of the starts whose attractor is found [rad].")
    velocity: Span = Field(description="Rates of those starts w [rad/s].")
