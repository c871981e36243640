"""The settings of Figure 8.1."""

from lsvib.figures.settings import ContactPortrait


class Settings(ContactPortrait):
    """Phase portrait of the contact force, indeterminate case."""
