"""The settings of Figure 8.10."""

from pydantic import Field

from lsvib.figures.settings import (
    DriveChanges,
    Duration,
    FigureSettings,
    PositiveSpan,
    Samples,
    State,
    parameter,
)
from lsvib.models.drive import ThreadsDrive


class Settings(FigureSettings):
    """Cycle with compliant threads, its contact force, and its dependence on the axial force."""

    drive: DriveChanges
    contact_stiffness: parameter("contact_stiffness", of=ThreadsDrive)
    contact_damping: parameter("contact_damping", of=ThreadsDrive)
    start: State
    duration: Duration
    samples: Samples
    axial_force: PositiveSpan = Field(description="R [N] over which the dependence on it is shown.")
