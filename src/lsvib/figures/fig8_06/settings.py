"""The settings of Figure 8.6."""

from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator
from pydantic_core import PydanticCustomError

from lsvib.figures.settings import MassPair, PhasePlane, Span, State, Unique, parameter


class Settings(PhasePlane):
    """Amplitude of the steady vibration against the axial force."""

    unused: ClassVar = ("axial_force",)

    axial_force: Span = Field(description="R [N].")
    start: State
    insets: list[parameter("axial_force")] = Field(
        min_length=1, max_length=3, description="Axial forces of the inset phase portraits [N]."
    )
    mass_readings: Annotated[MassPair, *Unique] = Field(
        description="Mass as stated, and mass to which the printed effective inertias belong [kg]."
    )

    @model_validator(mode="after")
    def _mass_is_read(self) -> Self:
        """Check that the mass of the drive is one of the two readings."""
        if self.drive.mass not in self.mass_readings:
            words = " and ".join(f"{mass:g}" for mass in self.mass_readings)
            raise PydanticCustomError("of_the_whole", f"has mass = {self.drive.mass:g}, none of mass_readings: {words}")
        return self
