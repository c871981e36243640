"""Friction-induced vibration of lead-screw drives, computed exactly from event to event.

:class:`lsvib.Drive` answers questions about a drive by its methods, :func:`lsvib.assess` assesses a data sheet, and
:class:`lsvib.systems.System` is a system of your own. Public names (``__init__.pyi``) are loaded on first use.
"""

import lazy_loader

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
