"""The settings of Figure 8.2."""

from typing import ClassVar

from pydantic import Field

from lsvib.drives.parameters import ThreadsParameters
from lsvib.figures.common.settings import (
    ContactDampings,
    ContactStarts,
    DriveChanges,
    FigureSettings,
    Samples,
    Span,
    parameter,
)


class Settings(FigureSettings):
    """Phase portrait of the contact force, inconsistent case."""

    unused: ClassVar = ("coupling_stiffness", "support_damping", "input_speed", "translation_damping", "axial_force")

    drive: DriveChanges
    contact_stiffness: parameter("contact_stiffness", of=ThreadsParameters)
    contact_dampings: ContactDampings
    force: Span = Field(description="Contact force in the scale of the chapter [1/(kg m2)].")
    rate: Span = Field(description="Its rate, in the same scale [1/(kg m2)].")
    starts: ContactStarts
    samples: Samples
