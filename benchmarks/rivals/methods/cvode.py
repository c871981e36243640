"""CVODE of SUNDIALS through scikit-sundae, with its root finding, started again in the new mode after each event."""

from collections.abc import Sequence

import numpy as np
from sksundae.cvode import CVODE

from benchmarks.rivals.hybrid import MOST_STEPS, Clock, GaveUp, Hybrid, HybridMode, Integrate

_FINEST = 1e-14  # relative tolerance; CVODE wants no less
_ROOT = 2  # CVODE's return value at an event


def integrator(hybrid: Hybrid, setting: float, clock: Clock, solver: str) -> Integrate:
    """Return what follows one mode with CVODE (``solver``: Adams or BDF) at relative tolerance ``setting``.

    Absolute tolerances are ``setting`` times the sizes of the coordinates; BDF is given a Jacobian that is constant.
    """
    options = {
        "method": solver,
        "rtol": max(setting, _FINEST),
        "atol": setting * hybrid.scene.scales,
        "max_num_steps": MOST_STEPS,
    }
    functions = [_functions(mode, clock, solver == "BDF") for mode in hybrid.modes]

    def integrate(mode: int, now: float, state: Sequence[float], end: float):
        arc = CVODE(**functions[mode], **options)  # a solver that is used again keeps, and copies, all earlier events
        arc.init_step(now, np.array(state))
        found = arc.step(end, method="normal", tstop=end)
        if not found.success:
            raise GaveUp(str(found.message))
        guard = int(np.flatnonzero(found.i_events[-1])[0]) if found.status == _ROOT else None
        return float(found.t), np.array(found.y), guard

    return integrate


def _functions(mode: HybridMode, clock: Clock, jacobian: bool) -> dict:
    matrix, rate_at = mode.matrix, mode.rate()
    weights, offsets = mode.guards[:, :-1], mode.guards[:, -1]

    def field(t, x, rate):
        """Put x′ into ``rate``."""
        clock.check()
        rate[:] = rate_at(x)

    def slope(t, x, rate, out):
        """Put the Jacobian A into ``out``."""
        out[:] = matrix

    def guards(t, x, values):
        """Put the values of the guards, positive inside the mode, into ``values``."""
        values[:] = weights @ x + offsets

    found = {"rhsfn": field}
    if len(offsets):
        guards.terminal = [True] * len(offsets)
        guards.direction = [-1] * len(offsets)
        found |= {"eventsfn": guards, "num_events": len(offsets)}
    return found | ({"jacfn": slope} if jacobian and mode.friction is None else {})
