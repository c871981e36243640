"""The settings of Figure 8.4."""

from lsvib.figures.settings import PhasePlane


class Settings(PhasePlane):
    """Phase plane under negative damping, contact force with the motion."""
