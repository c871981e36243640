"""The settings of Figure 8.13."""

from pydantic import Field

from lsvib.figures.settings import Contact, DriveChanges, FigureSettings, PositiveSpan, Samples, State


class Settings(FigureSettings):
    """Cycles with softer contacts, and where the coupling deflection turns positive."""

    drive: DriveChanges
    contacts: list[Contact] = Field(
        min_length=2, max_length=4, description="Contacts whose cycles are drawn, the stiffest first."
    )
    start: State
    samples: Samples
    contact_stiffness: PositiveSpan = Field(description="k_c [N/m] of the grid, spaced logarithmically.")
    contact_damping: PositiveSpan = Field(description="c_c [N s/m] of the grid, spaced logarithmically.")
