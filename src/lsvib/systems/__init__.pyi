"""The public names of systems and where they live; lazy_loader loads each on first use."""

from .ends import End as End
from .ends import Label as Label
from .system import System as System
