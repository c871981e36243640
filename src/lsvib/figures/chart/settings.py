"""The settings of `chart`."""

from typing import Literal

from pydantic import Field

from lsvib.figures.settings import Cells, FigureSettings
from lsvib.models.model import Resume, all_models

_CHARTED = tuple(name for name, model in all_models().items() if model.curves)


class ParameterCells(Cells):
    """Cells along a parameter [SI unit], of equal width; of the stiffness and damping of a contact of equal ratio."""

    parameter: str = Field(description="Name of the parameter; lsvib checks it and its range.")


class Settings(FigureSettings):
    """Chart of what a drive does over two parameters, which the rule `chart` of the workflow makes."""

    model: Literal[*_CHARTED] = Field(default="rigid", description="Model of the drive.")
    resume: Resume = Field(default="contact_sign", description="Motion after a seizure.")
    drive: dict[str, float] = Field(description="Changes of the model's drive; lsvib checks keys and ranges.")
    x: ParameterCells = Field(description="Along the columns.")
    y: ParameterCells = Field(description="Along the rows.")
    tiles: int = Field(ge=1, le=100_000, description="Number of tiles; at least one cell in each.")
