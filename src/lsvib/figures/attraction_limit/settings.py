"""The settings of `attraction_limit`."""

from typing import Annotated, ClassVar

from pydantic import Field

from lsvib.figures.common.settings import Cells, DriveChanges, FigureSettings, SettingsSection, Unique


class Box(SettingsSection):
    """Box in u [rad] and w [rad/s] around steady sliding."""

    u: Cells
    w: Cells


class Settings(FigureSettings):
    """Planar slices of the region of attraction of a compliant contact as it stiffens."""

    unused: ClassVar = ("input_speed",)  # without c_x; no motion on the boundary reaches θ′ = 0
    needs: ClassVar = ("lsvib.drives.threads",)  # found by the name of the model

    drive: DriveChanges
    grid: Box
    stiffnesses: Annotated[list[Annotated[float, Field(ge=1e3, le=1e14)]], *Unique] = Field(
        min_length=3, description="Contact stiffnesses, ascending [N/m]; the damping is as large in N s/m."
    )
    rays: int = Field(ge=1, le=1000, description="Rays on which the boundary is found.")
