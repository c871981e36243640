"""The settings of `basin_sweep`."""

from typing import Annotated

from pydantic import Field

from lsvib.figures.settings import (
    DriveChanges,
    FigureSettings,
    MassPair,
    OpposingForces,
    PlaneWindow,
    PositiveSpan,
    SettingsSection,
    Span,
    Unique,
)


class SweepCase(SettingsSection):
    """Changes of `drive`, and the window in which its basin is drawn."""

    drive: DriveChanges
    window: PlaneWindow


class Settings(FigureSettings):
    """The basin of steady sliding and its size."""

    drive: DriveChanges
    window: PlaneWindow
    axial_force: Span = Field(description="R [N], against the motion.")
    support_damping: PositiveSpan = Field(description="c [N m s/rad].")
    mass: PositiveSpan = Field(description="m [kg].")
    friction_coefficient: PositiveSpan = Field(description="mu [1].")
    cases: list[SweepCase] = Field(
        min_length=1, max_length=3, description="Drives whose basins are drawn and compared with grids."
    )
    resolutions: Annotated[list[Annotated[int, Field(ge=2, le=10_000)]], *Unique] = Field(
        min_length=2, description="Starts along each edge of the grids, ascending."
    )
    masses: MassPair = Field(description="Mass as printed for Fig. 8.14, and mass beyond the critical one [kg].")
    axial_forces: OpposingForces = Field(description="Axial forces of Fig. 8.14 (a) and (b) [N].")
