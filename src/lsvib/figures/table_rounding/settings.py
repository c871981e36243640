"""The settings of `table_rounding`."""

from typing import ClassVar

from lsvib.figures.settings import DriveChanges, FigureSettings


class Settings(FigureSettings):
    """What the rounding of Table 8.1 does to the printed thresholds."""

    unused: ClassVar = ("mass", "translation_damping", "axial_force")

    drive: DriveChanges
