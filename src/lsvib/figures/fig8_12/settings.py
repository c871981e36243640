"""The settings of Figure 8.12."""

from typing import ClassVar

from pydantic import Field

from lsvib.figures.settings import DriveChanges, FigureSettings, Span, State


class Settings(FigureSettings):
    """Amplitude and means of the sprag-slip cycle against the support damping."""

    unused: ClassVar = ("support_damping",)

    drive: DriveChanges
    support_damping: Span = Field(description="c [N m s/rad], from zero or more.")
    start: State
