"""The settings of `rival_verdicts`."""

from typing import Annotated, ClassVar

from pydantic import Field

from benchmarks.rivals.methods import MODULES
from benchmarks.sweeps.families import FamilyName
from lsvib.figures.settings import CaseSeed, FigureSettings, Tolerances


class Settings(FigureSettings):
    """Other methods at the edge of the domain."""

    needs: ClassVar = MODULES

    seed: CaseSeed
    counts: dict[FamilyName, Annotated[int, Field(ge=1, le=1_000_000)]] = Field(
        min_length=1, description="Number of cases of each family that every method is asked."
    )
    methods: dict[str, Tolerances] = Field(description="Relative tolerances of each method; none leaves it out.")
