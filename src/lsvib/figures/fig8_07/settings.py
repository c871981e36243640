"""The settings of Figure 8.7."""

from pydantic import Field

from lsvib.figures.common.settings import DriveChanges, Duration, FigureSettings, Samples, Span, Starts


class Settings(FigureSettings):
    """The four sectors of the Painlevé region."""

    drive: DriveChanges
    angle: Span = Field(description="Deviation u [rad].")
    velocity: Span = Field(description="Rate of the deviation w [rad/s].")
    starts: Starts
    duration: Duration
    samples: Samples
