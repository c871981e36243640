"""The settings of `attraction`."""

from typing import Annotated, Literal

from pydantic import AfterValidator, Discriminator, Field, Tag
from pydantic_core import PydanticCustomError

from lsvib.basins.grid import coordinates
from lsvib.figures.settings import Cells, FigureSettings, Unique
from lsvib.models.model import Resume, all_models, model_names

Coordinate = Annotated[
    Annotated[float, Tag("number")] | Annotated[Cells, Tag("axis")],
    Discriminator(lambda value: "axis" if isinstance(value, dict) else "number"),
]


def _with_label(values: list[str]) -> list[str]:
    if "label" not in values:
        raise PydanticCustomError("of_the_value", "is not acceptable; it must hold label")
    return values


Quantities = Annotated[
    list[Literal["label", "time", "seizures", "first_event", "doubt"]],
    *Unique,
    AfterValidator(_with_label),
    Field(description="What is computed of each cell; all but the label need the motion up to its attractor."),
]


# The coordinates that the models have beyond u and w, in words.
_MORE = ", ".join(
    f"{name} {' and '.join(model.optional)}" for name, model in all_models().items() if model.optional
).replace(" ", " also ", 1)


class Settings(FigureSettings):
    """Region of attraction, which the rule `attraction` of the workflow maps."""

    model: Literal[*model_names()] = Field(default="rigid", description="Model of the drive.")
    resume: Resume = Field(default="contact_sign", description="Motion after a seizure.")
    drive: dict[str, float] = Field(description="Changes of the model's drive; lsvib checks keys and ranges.")
    grid: dict[Literal[*coordinates()], Coordinate] = Field(
        min_length=2,
        description="The two coordinates that the map spans, as cells of equal width (of these two the one that is "
        "listed first below is horizontal); other coordinates of the state as numbers. All models have u and w, "
        f"{_MORE}.",
    )
    quantities: Quantities
    tiles: int = Field(ge=1, le=100_000, description="Number of tiles; at least one cell in each.")
