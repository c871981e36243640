"""The settings of Figure 8.6."""

from typing import Annotated, ClassVar

from pydantic import Field

from lsvib.figures.common.settings import MassPair, PhasePlane, Span, State, Unique, parameter


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
