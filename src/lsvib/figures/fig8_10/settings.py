"""The settings of Figure 8.10."""

from pydantic import Field

from lsvib.drives.parameters import ThreadsParameters
from lsvib.figures.common.settings import (
    DriveChanges,
    Duration,
    FigureSettings,
    PositiveSpan,
    Samples,
    State,
    parameter,
)


class Settings(FigureSettings):
    """Cycle with compliant threads, its contact force, and its dependence on the axial force."""

    drive: DriveChanges
    contact_stiffness: parameter("contact_stiffness", of=ThreadsParameters)
    contact_damping: parameter("contact_damping", of=ThreadsParameters)
    start: State
    duration: Duration
    samples: Samples
    axial_force: PositiveSpan = Field(description="R [N] over which the dependence on it is shown.")
