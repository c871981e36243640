"""``scipy.integrate.solve_ivp`` with events, started again in the new mode after each."""

from collections.abc import Sequence

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.rivals.hybrid import RETRIES, Clock, GaveUp, Hybrid, Integrate

_IMPLICIT = ("Radau", "BDF", "LSODA")


def integrator(hybrid: Hybrid, setting: float, clock: Clock, solver: str, capped: bool = False) -> Integrate:
    """Return what follows one mode with ``solver`` at relative tolerance ``setting``; ``capped``: with a step cap.

    Absolute tolerances are ``setting`` times the sizes of the coordinates; implicit solvers are given a constant
    Jacobian. Where a guard rises from zero and falls again within the first step, so that its only root that is seen
    is the start, the arc is repeated with smaller steps.
    """
    scene = hybrid.scene
    modes = [_functions(mode, clock) for mode in hybrid.modes]
    options = {"method": solver, "rtol": max(setting, 3e-14), "atol": setting * scene.scales}
    if capped:
        options["max_step"] = scene.step_cap

    def integrate(mode: int, now: float, state: Sequence[float], end: float):
        field, events = modes[mode]
        limits = dict(options)
        matrix, jacobian = hybrid.modes[mode].matrix, {}
        if solver in _IMPLICIT and hybrid.modes[mode].friction is None:
            jacobian = {"jac": (lambda t, x: matrix) if solver == "LSODA" else matrix}
        for _ in range(RETRIES):
            found = solve_ivp(field, (now, end), state, events=events, **limits, **jacobian)
            if not found.success:
                raise GaveUp(found.message)
            guard = next((k for k, times in enumerate(found.t_events or ()) if times.size), None)
            if guard is None:
                return end, found.y[:, -1], None
            if found.t_events[guard][0] > now:
                return float(found.t_events[guard][0]), found.y_events[guard][0], guard
            # The guard was zero at the start and negative after a step; the root in between is what is wanted.
            limits["max_step"] = min(limits.get("max_step", np.inf), scene.step_cap) / 4
        raise GaveUp("no step away from a guard")

    return integrate


def _functions(mode, clock: Clock):
    rate = mode.rate()

    def field(t, x):
        """Return x′."""
        clock.check()
        return rate(x)

    events = []
    for row in mode.guards:
        weights, offset = row[:-1], float(row[-1])

        def guard(t, x, weights=weights, offset=offset):
            """Return the value of the guard, which is positive inside the mode."""
            return weights @ x + offset

        guard.terminal, guard.direction = True, -1
        events.append(guard)
    return field, events
