"""The settings of `limit_process`."""

from typing import Annotated, ClassVar

from pydantic import Field

from lsvib.figures.settings import (
    Damping,
    DriveChanges,
    Duration,
    FigureSettings,
    NotZero,
    State,
    Unique,
    parameter,
)
from lsvib.models.drive import ThreadsDrive


class Settings(FigureSettings):
    """Convergence of the drive with compliant threads to the rigid one."""

    unused: ClassVar = ("support_damping", "translation_damping", "axial_force")

    drive: DriveChanges
    axial_forces: Annotated[list[parameter("axial_force", *NotZero)], *Unique] = Field(
        min_length=2, max_length=4, description="Axial forces [N], of both signs."
    )
    support_dampings: Annotated[list[Damping], *Unique] = Field(
        min_length=1, max_length=4, description="Support dampings c [N m s/rad], a small and a large one."
    )
    speed: float = Field(gt=0, le=1e9, description="Screw speed before an impact [rad/s].")
    duration: Duration
    start: State
    stiffness: Annotated[list[parameter("contact_stiffness", of=ThreadsDrive)], *Unique] = Field(
        min_length=3, max_length=50, description="Contact stiffnesses k_c [N/m], ascending."
    )
    fit_from: float = Field(gt=0, description="Least stiffness that orders are fitted to [N/m].")
    damping_ratio: float = Field(gt=0, le=1000, description="Damping ratio of the nut in its family [1].")
