"""lsvib: friction-induced vibration of lead-screw drives, computed exactly from event to event.

The names below are loaded on first use, so that importing the package costs nothing that is not needed.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "LeadScrew": "lsvib.models.parameters",
    "Scene": "lsvib.models.scene",
    "simulate": "lsvib.datasets.trajectory",
    "thresholds": "lsvib.analysis.summary:threshold_table",
    "stability": "lsvib.analysis.summary:stability_table",
    "LsvibError": "lsvib.errors",
    "InputError": "lsvib.errors",
    "EngineError": "lsvib.errors",
}
__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'lsvib' has no attribute {name!r}")
    module, _, attribute = _HOMES[name].partition(":")
    return getattr(import_module(module), attribute or name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
