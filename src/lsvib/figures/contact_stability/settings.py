"""The settings of `contact_stability`."""

from typing import Annotated, ClassVar

from pydantic import Field

from lsvib.figures.settings import (
    Contact,
    DriveChanges,
    FigureSettings,
    MassPair,
    PositiveSpan,
    Unique,
    parameter,
)
from lsvib.models.drive import ThreadsDrive


class Settings(FigureSettings):
    """Critical mass over the contact of compliant threads, and growth rates (Lemma 8.1)."""

    unused: ClassVar = ("mass",)

    drive: DriveChanges
    stiffnesses: Annotated[list[parameter("contact_stiffness", of=ThreadsDrive)], *Unique] = Field(
        min_length=1, max_length=6, description="Contact stiffnesses k_c of the curves [N/m]."
    )
    contact_damping: PositiveSpan = Field(description="c_c [N s/m] along the curves, spaced logarithmically.")
    contacts: list[Contact] = Field(
        min_length=2, max_length=5, description="Contacts that figures draw, the stiffest first."
    )
    masses: MassPair = Field(description="Masses above and below the critical mass of the rigid drive [kg].")
    stiffness: PositiveSpan = Field(description="k_c [N/m] of the growth rates, spaced logarithmically.")
    dampings: Annotated[list[parameter("contact_damping", of=ThreadsDrive)], *Unique] = Field(
        min_length=2, max_length=5, description="Contact dampings of the growth rates, the first zero [N s/m]."
    )
