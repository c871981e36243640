"""The settings of Figure 8.7."""

from pydantic import Field

from lsvib.figures.settings import PhasePlane, Span


class Settings(PhasePlane):
    """The four sectors of the Painlevé region."""

    angle: Span = Field(description="Deviation u [rad].")
    velocity: Span = Field(description="Rate of the deviation w [rad/s].")
