"""Sweep over two parameters, whose dataset the rule `chart` makes (:mod:`lsvib.answers.sweep`)."""

from pydantic import Field

from lsvib.chapter.settings import FigureSettings, Span
from lsvib.pictures.chart import draw as draw

CAPTION = """\
The behaviour of the drive over two of its parameters, from up to three motions of each drive, with the exact curves
that divide the plane. Sects 8.5 to 8.7 give single values of these curves.
"""


class ParameterSpan(Span):
    """Values of a parameter [SI unit], evenly spaced; those of contact stiffness and damping in equal ratios."""

    parameter: str = Field(description="Name of the parameter; lsvib checks it and its range.")


class Settings(FigureSettings):
    drive: dict[str, float] = Field(description="Changes of the drive of Table 8.1; lsvib checks keys and ranges.")
    x: ParameterSpan = Field(description="Along the horizontal axis.")
    y: ParameterSpan = Field(description="Along the vertical axis.")
