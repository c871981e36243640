"""The settings of Figure 8.15."""

from typing import ClassVar

from pydantic import Field

from lsvib.figures.settings import DriveChanges, FigureSettings, PositiveSpan, Span, parameter
from lsvib.models.drive import SupportDrive


class Settings(FigureSettings):
    """Instability regions of the drive with axial support."""

    unused: ClassVar = ("support_damping", "friction_coefficient", "input_speed", "translation_damping", "axial_force")

    drive: DriveChanges
    screw_mass: parameter("screw_mass", of=SupportDrive)
    friction_coefficient: Span = Field(description="mu, from zero or more.")
    support_stiffness: PositiveSpan = Field(description="k_1 [N/m], spaced logarithmically.")
