"""The settings of Figure 8.11."""

from typing import Annotated, ClassVar

from pydantic import Field

from lsvib.figures.settings import Damping, PhasePlane, Unique


class Settings(PhasePlane):
    """Sprag-slip cycles for three levels of support damping."""

    unused: ClassVar = ("support_damping",)

    support_dampings: Annotated[list[Damping], *Unique] = Field(
        min_length=2, max_length=4, description="Support dampings in ascending order [N m s/rad]."
    )
