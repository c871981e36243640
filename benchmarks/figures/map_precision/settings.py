"""The settings of `map_precision`."""

from typing import Annotated, ClassVar

from pydantic import Field

from lsvib.figures.settings import (
    CaseSeed,
    DriveChanges,
    FigureSettings,
    PlaneWindow,
    PositiveSpan,
    SettingsSection,
)

BoxName = Annotated[str, Field(pattern="^[a-z][a-z0-9_]*$")]
Some = Annotated[int, Field(ge=1, le=10_000)]
SomeOrNone = Annotated[int, Field(ge=0, le=10_000)]


class MappedBox(SettingsSection):
    """A drive and the part of the phase plane that is mapped."""

    drive: DriveChanges
    window: PlaneWindow
    ratio_floor: float = Field(
        gt=0, description="Labels per second of lsvib over those of RK4 with the coarse step, at least [1]."
    )


class CellsOfMethods(SettingsSection):
    """Cells along an edge of each method's grid, 0 to leave the method out."""

    engine: Some
    rk4_coarse: Some
    rk4_fine: SomeOrNone = 0


class Settings(FigureSettings):
    """Ways to map the region of attraction, their speed and their wrong labels."""

    timed: ClassVar = True

    boxes: dict[BoxName, MappedBox] = Field(
        min_length=1, max_length=6, description="Drives, each with the part of the phase plane that is mapped."
    )
    cells: CellsOfMethods
    repeats: int = Field(ge=1, le=1000, description="Repeats of each timed grid.")
    distances: PositiveSpan = Field(
        description="Distances from the boundary in widths of the box, evenly in logarithms."
    )
    starts: int = Field(ge=1, le=100_000, description="Starts on either side of the boundary at each distance.")
    seed: CaseSeed = Field(description="Seed of their places along the boundary.")
