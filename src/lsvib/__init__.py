"""Friction-induced vibration of lead-screw drives, computed exactly from event to event.

:class:`lsvib.Drive` answers questions about a drive by its methods, :func:`lsvib.assess` assesses a data sheet, and
:class:`lsvib.systems.System` is a system of your own. Public names (``__init__.pyi``) are loaded on first use.
"""

from typing import Any

import lazy_loader

__version__ = "0.1.0"
_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    try:
        return _load(name)
    except ModuleNotFoundError as error:  # of an extra; ``help`` and completion go on to the next name
        from lsvib.errors import NotInstalledError

        missing = f"lsvib.{name} needs {error.name}, which is not installed"
        raise NotInstalledError(f"{missing}: pip install 'lsvib[assess]'.") from None
