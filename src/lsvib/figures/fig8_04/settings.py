"""The settings of Figure 8.4."""

from lsvib.figures.common.settings import DriveChanges, Duration, FigureSettings, Samples, Starts


class Settings(FigureSettings):
    """Phase plane under negative damping, contact force with the motion."""

    drive: DriveChanges
    starts: Starts
    duration: Duration
    samples: Samples
