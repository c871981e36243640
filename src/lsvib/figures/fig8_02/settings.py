"""The settings of Figure 8.2."""

from lsvib.figures.settings import ContactPortrait


class Settings(ContactPortrait):
    """Phase portrait of the contact force, inconsistent case."""
