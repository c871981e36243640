"""The settings of Figure 8.5."""

from lsvib.figures.settings import PhasePlane


class Settings(PhasePlane):
    """Phase plane under negative damping, contact force against the motion."""
