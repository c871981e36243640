"""The settings of `nut_stability`."""

from typing import ClassVar

from pydantic import Field

from lsvib.figures.settings import DriveChanges, FigureSettings, PositiveSpan, Span


class Settings(FigureSettings):
    """Critical mass over the inertia of a rotating nut, and the stability map."""

    unused: ClassVar = ("axial_force", "coupling_stiffness", "input_speed", "support_damping", "translation_damping")

    drive: DriveChanges
    nut_inertia: PositiveSpan = Field(description="I_2 [kg m2], spaced logarithmically.")
    friction_coefficient: Span = Field(description="mu, from zero or more.")
