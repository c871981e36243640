"""lsvib: friction-induced vibration of lead-screw drives, computed exactly from event to event.

The names below are loaded on first use, so that importing the package costs nothing that is not needed.
"""

from importlib import import_module
from typing import Any

__version__ = "0.1.0"

_HOMES = {
    "RigidDrive": "lsvib.api",
    "ThreadsDrive": "lsvib.api",
    "SupportDrive": "lsvib.api",
    "NutDrive": "lsvib.api",
    "Scene": "lsvib.models.scene",
    "simulate": "lsvib.datasets.motion",
    "StabilityReport": "lsvib.results",
    "UndampedStability": "lsvib.results",
    "Condition": "lsvib.results",
    "Quantity": "lsvib.results",
    "Threshold": "lsvib.results",
    "SolvedThreshold": "lsvib.results",
    "ThresholdSolution": "lsvib.results",
    "Attractor": "lsvib.dynamics.attractor",
    "SteadyState": "lsvib.dynamics.attractor",
    "Cycle": "lsvib.dynamics.cycles",
    "Cycles": "lsvib.datasets.cycles",
    "CycleBranch": "lsvib.dynamics.continuation",
    "Basin": "lsvib.basins.boundary",
    "Grid": "lsvib.basins.grid",
    "Axis": "lsvib.basins.grid",
    "Window": "lsvib.basins.curves",
    "Resilience": "lsvib.basins.resilience",
    "LsvibError": "lsvib.errors",
    "InputError": "lsvib.errors",
    "NoThreshold": "lsvib.errors",
    "EngineError": "lsvib.errors",
    "DivergenceError": "lsvib.errors",
}
__all__ = ["__version__", *_HOMES]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'lsvib' has no attribute {name!r}")
    module, _, attribute = _HOMES[name].partition(":")
    return getattr(import_module(module), attribute or name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOMES])
