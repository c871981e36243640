"""Map of regions of attraction, whose dataset the rule `attraction` makes in tiles (:mod:`lsvib.answers.map`)."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from lsvib.chapter.settings import Cells, FigureSettings, Unique, refusing
from lsvib.drives.model import coordinates
from lsvib.pictures.attraction import draw as draw

CAPTION = """\
Regions of attraction: the attractor reached from every initial state, shaded by the time it takes, with the exact
boundary. Sect. 8.7 says only that the region of steady sliding can be quite small.
"""

_Name: Any = Literal[*coordinates()]
Coordinate = Annotated[
    Annotated[float, Tag("number")] | Annotated[Cells, Tag("axis")],
    Discriminator(lambda value: "axis" if isinstance(value, dict) else "number"),
]
Quantities = Annotated[
    list[Literal["label", "time", "seizures", "first_event", "doubt"]],
    *Unique,
    refusing(lambda values: "label" not in values, "is not acceptable; it must hold label"),
    Field(description="What is computed for each cell; all but the label need the motion up to its attractor."),
]


class Settings(FigureSettings):
    drive: dict[str, float] = Field(description="Changes of the drive of Table 8.1; lsvib checks keys and ranges.")
    grid: dict[_Name, Coordinate] = Field(
        min_length=2,
        description="The two coordinates that the map spans, as cells of equal width (the one listed first below is "
        "horizontal), and the other coordinates of the state as numbers. All drives have u and w; parts add "
        f"{', '.join(coordinates()[2:])}.",
    )
    quantities: Quantities
    tiles: int = Field(ge=1, le=100_000, description="Number of tiles; at least one cell in each.")
