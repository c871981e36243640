"""The settings of `stability_sweeps`."""

from typing import Annotated

from pydantic import Field

from benchmarks.sweeps.families import FamilyName
from lsvib.figures.settings import CaseSeed, FigureSettings


class Settings(FigureSettings):
    """The engine at the edge of the domain."""

    seed: CaseSeed
    counts: dict[FamilyName, Annotated[int, Field(ge=1, le=10_000_000)]] = Field(
        min_length=1, description="Number of cases of each family."
    )
    thorough: int = Field(ge=1, description="Cases of each family that the reference judges in any case.")
