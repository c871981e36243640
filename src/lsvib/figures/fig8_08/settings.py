"""The settings of Figure 8.8."""

from typing import Annotated, ClassVar

from annotated_types import Gt
from pydantic import Field

from lsvib.figures.settings import Damping, DriveChanges, FigureSettings, PositiveSpan


class Settings(FigureSettings):
    """Eigenvalues of the steady sliding against the translating mass."""

    unused: ClassVar = ("input_speed", "mass", "translation_damping", "axial_force")

    drive: DriveChanges
    mass: PositiveSpan = Field(description="Translating mass [kg].")
    dampings: list[Annotated[Damping, Gt(0)]] = Field(
        min_length=1, description="Support dampings at which the loss of stability is located [N m s/rad]."
    )
