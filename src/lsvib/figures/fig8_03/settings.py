"""The settings of Figure 8.3."""

from typing import ClassVar

from pydantic import Field

from lsvib.figures.settings import DriveChanges, FigureSettings, Span


class Settings(FigureSettings):
    """Stability of the steady sliding over effective inertia and damping."""

    unused: ClassVar = ("mass", "translation_damping")

    drive: DriveChanges
    inertia: Span = Field(description="Effective inertia [kg m2].")
    damping: Span = Field(description="Effective damping [N m s/rad].")
    cases: list[DriveChanges] = Field(max_length=5, description="Drives to place in the plane, as changes of `drive`.")
