"""The settings of `ablation`."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from lsvib.figures.settings import Duration, FigureSettings, Repeats, Unique

MODULES = {  # what a dataset or a picture imports; measured in processes of their own
    "figure": "lsvib.figures.fig8_08.picture",
    "eigenvalues": "lsvib.figures.fig8_08.dataset",
    "motion": "lsvib.figures.fig8_09.dataset",
    "everything": "lsvib.figures.fig8_09.dataset, lsvib.figures.fig8_09.picture, lsvib.cli.app",
}


class Settings(FigureSettings):
    """What a scene saves by leaving out what it does not need."""

    timed: ClassVar = True
    needs: ClassVar = tuple({name: None for words in MODULES.values() for name in words.split(", ")})

    duration: Duration
    repeats: Repeats
    compile: Annotated[list[Literal["planar", "modal"]], *Unique] = Field(
        min_length=1, description="Kinds of flow whose compilation is measured, each with those before it."
    )
