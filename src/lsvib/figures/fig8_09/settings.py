"""The settings of Figure 8.9."""

from typing import ClassVar

from pydantic import Field

from lsvib.figures.settings import DriveChanges, PhasePlane, PositiveSpan


class Settings(PhasePlane):
    """Trajectories below and above the critical mass."""

    unused: ClassVar = ("mass",)

    cases: list[DriveChanges] = Field(
        min_length=2,
        max_length=2,
        description="Changes of `drive`, one for each panel, the one below the critical mass first.",
    )
    axial_force: PositiveSpan = Field(description="R [N] over which the dependence on it is shown.")
