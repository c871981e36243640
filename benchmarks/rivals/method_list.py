"""The methods that are compared: their families, settings and the functions that prepare them.

A method's module is loaded when it is used, since it may need a package that only the target ``accuracy`` requires.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from benchmarks.rivals import methods
from benchmarks.rivals.hybrid import Clock, Hybrid
from lsvib.errors import InputError

_PACKAGES = {"sksundae": "scikit-sundae"}  # import name: package, where they differ


class MethodFamily(IntEnum):
    """Kinds of methods."""

    EXACT = 0  # this engine
    GENERAL = 1  # general solvers with events, adaptive, whose field is a Python function, from event to event
    FIXED_STEP = 2  # Runge–Kutta with a fixed step, made for this drive
    SMOOTHED = 3  # friction without a jump
    TAYLOR = 4  # a general solver with compiled Taylor series and roots isolated on them, Python from event to event


@dataclass(frozen=True)
class Method:
    """A method: ``control`` is what its setting is, ``relative_tolerance`` [1], ``time_step`` [s], ``smoothing_width``
    [rad/s] or ``none``; ``module``, one of :mod:`benchmarks.rivals.methods`, prepares what is timed;
    ``needs``: a package by its import name; ``explicit``: bounded region of stability, so no method for stiff scenes;
    ``linear``: made for fields that are linear in a mode, so none for friction that depends on speed.
    """

    label: str
    family: MethodFamily
    module: str
    control: str = "relative_tolerance"
    options: Mapping[str, Any] = field(default_factory=dict)
    needs: str | None = None
    explicit: bool = False
    linear: bool = False

    def prepare(self, hybrid: Hybrid, setting: float, clock: Clock, max_events: int) -> Callable:
        """Return the function to time; its result makes a record when called. ``InputError`` without the package."""
        self._require()
        module: Any = import_module(f"{methods.__name__}.{self.module}")
        if hasattr(module, "runner"):  # of a whole motion
            return module.runner(hybrid, setting, clock, max_events)
        integrate = module.integrator(hybrid, setting, clock, **self.options)
        return lambda: hybrid.run(integrate, clock, max_events)

    def _require(self) -> None:
        if self.needs and find_spec(self.needs) is None:
            raise InputError(
                f"The package {_PACKAGES.get(self.needs, self.needs)}, which {self.label} needs, is not installed; "
                'run pip install -e ".[accuracy]".'
            )


_EXPLICIT = ("RK45", "DOP853", "Adams")  # solvers


def _general(label: str, module: str, needs: str, **options) -> Method:
    """A general solver of a package, by its name there."""
    explicit = options["solver"] in _EXPLICIT
    return Method(label, MethodFamily.GENERAL, module, options=options, needs=needs, explicit=explicit)


_with_scipy = partial(_general, module="scipy_events", needs="scipy")
_with_cvode = partial(_general, module="cvode", needs="sksundae")
_with_steps = partial(Method, family=MethodFamily.FIXED_STEP, module="fixed_step", control="time_step", explicit=True,
                      linear=True)  # fmt: skip

METHODS = {
    "exact": Method("lsvib", MethodFamily.EXACT, "this_engine", "none"),
    "rk45": _with_scipy("RK45", solver="RK45"),
    "dop853": _with_scipy("DOP853", solver="DOP853"),
    "dop853_capped": _with_scipy("DOP853, step cap", solver="DOP853", capped=True),
    "radau": _with_scipy("Radau", solver="Radau"),
    "bdf": _with_scipy("BDF", solver="BDF"),
    "lsoda": _with_scipy("LSODA", solver="LSODA"),
    "cvode_adams": _with_cvode("CVODE Adams", solver="Adams"),
    "cvode_bdf": _with_cvode("CVODE BDF", solver="BDF"),
    # Explicit too, but of so high an order and with steps so cheap that it does the stiff scene: not left out of it.
    "heyoka": Method("heyoka", MethodFamily.TAYLOR, "heyoka_events", needs="heyoka"),
    "smoothed": Method("smoothed friction", MethodFamily.SMOOTHED, "smoothed", "smoothing_width", needs="sksundae",
                       linear=True),
    "rk4": _with_steps("RK4, fixed step"),
    "rk4_refined": _with_steps("RK4, refined events", options={"refined": True}),
}  # fmt: skip
