"""The methods that are compared: their families, settings and the modules that run them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from lsvib.accuracy.hybrid import Clock, Hybrid
from lsvib.errors import InputError

_PACKAGES = {"scipy": "scipy", "sksundae": "scikit-sundae", "diffrax": "diffrax"}  # import name: package


class Family(IntEnum):
    """Kinds of methods."""

    EXACT = 0  # this engine
    GENERAL = 1  # general solvers with events, adaptive
    FIXED_STEP = 2  # Runge–Kutta with a fixed step, made for this drive
    SMOOTHED = 3  # friction without a jump


@dataclass(frozen=True)
class Method:
    """A method: ``control`` is what its setting is, ``relative_tolerance`` [1], ``time_step`` [s], ``smoothing_width``
    [rad/s] or ``none``; ``prepare`` of ``module`` makes the function that is timed; ``needs``: a package by its import
    name; ``explicit``: bounded region of stability, so no method for stiff scenes.
    """

    label: str
    family: Family
    module: str
    control: str = "relative_tolerance"
    options: Mapping[str, Any] = field(default_factory=dict)
    needs: str | None = None
    explicit: bool = False

    def prepare(self, hybrid: Hybrid, setting: float, clock: Clock, max_events: int) -> Callable:
        """Return the function to time; ``InputError`` if the package is missing."""
        if self.needs and find_spec(self.needs) is None:
            raise InputError(
                f"The package {_PACKAGES[self.needs]}, which {self.label} needs, is not installed; "
                "run pip install -r requirements-accuracy.txt."
            )
        module = import_module(f"lsvib.accuracy.methods.{self.module}")
        return module.prepare(hybrid, setting, clock, max_events, **self.options)


def _scipy(label: str, **options) -> Method:
    explicit = options["solver"] in ("RK45", "DOP853")
    return Method(label, Family.GENERAL, "scipy_events", options=options, needs="scipy", explicit=explicit)


def _cvode(label: str, **options) -> Method:
    return Method(
        label,
        Family.GENERAL,
        "cvode",
        options=options,
        needs="sksundae",
        explicit=options["solver"] == "Adams",
    )


METHODS = {
    "exact": Method("lsvib", Family.EXACT, "exact", "none"),
    "exact_single": Method("lsvib, float32 tables", Family.EXACT, "exact", "none", {"single": True}),
    "rk45": _scipy("RK45", solver="RK45"),
    "dop853": _scipy("DOP853", solver="DOP853"),
    "dop853_capped": _scipy("DOP853, step cap", solver="DOP853", capped=True),
    "radau": _scipy("Radau", solver="Radau"),
    "bdf": _scipy("BDF", solver="BDF"),
    "lsoda": _scipy("LSODA", solver="LSODA"),
    "lsoda_capped": _scipy("LSODA, step cap", solver="LSODA", capped=True),
    "cvode_adams": _cvode("CVODE Adams", solver="Adams"),
    "cvode_bdf": _cvode("CVODE BDF", solver="BDF"),
    "cvode_bdf_capped": _cvode("CVODE BDF, step cap", solver="BDF", capped=True),
    "diffrax": Method("diffrax Dopri8", Family.GENERAL, "diffrax_events", needs="diffrax", explicit=True),
    "smoothed": Method("smoothed friction", Family.SMOOTHED, "smoothed", "smoothing_width", needs="sksundae"),
    "rk4": Method("RK4, fixed step", Family.FIXED_STEP, "fixed_step", "time_step", explicit=True),
    "rk4_refined": Method(
        "RK4, refined events", Family.FIXED_STEP, "fixed_step", "time_step", {"refined": True}, explicit=True
    ),
}


def find_method(name: str) -> Method:
    """Return a method by name; ``InputError`` if there is none of that name."""
    if name not in METHODS:
        raise InputError(f"method = {name!r} is not one of {', '.join(METHODS)}.")
    return METHODS[name]
