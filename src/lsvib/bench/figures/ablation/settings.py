"""The settings of `ablation`."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from lsvib.figures.common.settings import Duration, FigureSettings, Repeats, Unique


class Settings(FigureSettings):
    """What a scene saves by leaving out what it does not need."""

    timed: ClassVar = True
    needs: ClassVar = (  # their import is measured, in processes of their own
        "lsvib.figures.fig8_08.picture",
        "lsvib.figures.fig8_09.picture",
        "lsvib.figures.fig8_08.dataset",
        "lsvib.figures.fig8_09.dataset",
        "lsvib.command.app",
    )

    duration: Duration
    repeats: Repeats
    compile: Annotated[list[Literal["planar", "modal"]], *Unique] = Field(
        min_length=1, description="Kinds of flow whose compilation is measured, each with those before it."
    )
