"""lsvib: friction-induced vibration of lead-screw drives, computed exactly from event to event.

The public names are those that ``__init__.pyi`` imports. They are loaded on first use, so that importing the package
costs nothing that is not needed.
"""

import lazy_loader

__version__ = "0.1.0"
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
