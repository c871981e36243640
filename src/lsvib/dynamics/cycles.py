"""Cycles of a drive: what :class:`lsvib.systems.cycles.Cycle` says of them, and works, impulses and starts besides."""

import math
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from typing import Any, Self

import numpy as np

from lsvib.drives.drive import PARTS, Drive
from lsvib.drives.mechanics import coefficients
from lsvib.drives.model import seated_state
from lsvib.drives.names import BODIES
from lsvib.dynamics.impulses import Impulses, Work, event_impulses, work
from lsvib.systems import cycles
from lsvib.systems.kernels.layout import GRAZE_KIND


@dataclass(frozen=True, repr=False)
class Cycle(cycles.Cycle):
    """A periodic motion of ``drive``, with its work; means omit the impulses of seizures (docs/cycles.md).

    ``orbit``: one period from ``state`` (n); ``residual`` [1]: the change of the state over it, relative to the size of
    the motion; ``multipliers`` [1] (n − 1), complex, the largest first, and ``multiplier_error``, a bound of their
    errors (for stiff contacts an estimate); ``found_by``: how it was found.

    >>> cycle = lsvib.Drive(translation_damping=1000).cycles().cycles[0]
    >>> f"{cycle.period:.6f} s", f"{cycle.amplitude:.6f} rad", f"{cycle.work.motor:.6f} J", cycle.attracting
    ('0.010672 s', '0.074280 rad', '0.010086 J', True)
    >>> abs(cycle.work.balance) < 1e-12, cycle.impulses.normal.tolist()
    (True, [0.0, 0.0])
    """

    drive: Drive

    @classmethod
    def of(cls, drive: Drive, cycle: cycles.Cycle) -> Self:
        """Return a cycle of the automaton of a drive as one of the drive."""
        return cls(drive=drive, **{own.name: getattr(cycle, own.name) for own in fields(cycles.Cycle)})

    @cached_property
    def work(self) -> Work:
        """Work over a period [J]: of motor and load, friction, damping and impacts."""
        return work(self.drive, self.orbit)

    @property
    def impulses(self) -> Impulses:
        """Impulses [N s, N m s] of the events of a period (k); only those of seizures are not zero."""
        return event_impulses(self.drive, self.orbit)

    def to_json(self) -> dict[str, Any]:
        """Return what is known of the cycle, as plain numbers and names."""
        taken = self.work
        efficiency = taken.efficiency if math.isfinite(taken.efficiency) else None
        return {"label": self.label.name.lower(), **super().to_json()} | {
            "itinerary": self._events(),
            "extremes": {name: list(ends) for name, ends in self.extremes.items()},
            "means": self.means,
            "work": asdict(taken) | {"balance": taken.balance, "efficiency": efficiency},
        }

    def _events(self) -> list[dict[str, Any]]:
        """Events of a period without touches: time [s], and the impulses [N s, N m s] of those that are seizures."""
        impulses, seized = vars(self.impulses), self.orbit.automaton.marked(self.orbit.kind, "impact")
        found, names = [], iter(self.itinerary)
        for k in np.flatnonzero(self.orbit.kind != GRAZE_KIND):
            kind, mode = next(names)
            event: dict[str, Any] = {"event": kind, "mode": mode, "time": float(self.orbit.time[k])}
            if seized[k]:
                event |= {f"{name}_impulse": float(each[k]) for name, each in impulses.items()}
            found.append(event)
        return found


def swing(drive: Drive) -> tuple[float, float]:
    """Return the sizes u [rad] and w [rad/s] of a swing of the screw under law −1 with the speed of the motor."""
    inertia = float(coefficients(drive).gamma[-1])
    return abs(drive.input_speed) * math.sqrt(inertia / drive.coupling_stiffness), abs(drive.input_speed)


def starts(drive: Drive) -> list[tuple[float, float]]:
    """Return starts (u [rad], w [rad/s]) next to steady sliding, at standstill, and far out on both sides."""
    u, w = swing(drive)
    still = -drive.input_speed
    standing = [(part * u, still) for part in (0.0, -0.5, 0.5)]
    return [(1e-3 * u, 0.0), (u, 0.0), (-u, 0.0), *standing, (10 * u, w), (-10 * u, -w)]


def random_starts(drive: Drive) -> list[np.ndarray]:
    """Return starts (n) around steady sliding, as a cycle may attract little of the states of a drive.

    They are drawn, the same in every run, from boxes of half to eight times what the bodies do in a swing with the
    speed of the motor, of the screw or, if that is faster, their own; the screw also by what twists its coupling.
    """
    (angle, rate), lever = swing(drive), drive.pitch_radius * math.tan(drive.lead_angle)
    sizes = [angle + abs(float(coefficients(drive).deflection)), rate]
    for part in drive.parts:
        # Compliant threads have no body of their own: it is the load's.
        inertia, stiffness = (getattr(drive, name) for name in ("mass", *PARTS[part])[-3:-1])
        along = lever if part == "threads" or BODIES[part].pushed == "contact" else 1.0
        sizes += [along * min(rate * math.sqrt(inertia / stiffness), angle), along * rate]
    draw = np.random.default_rng(0)
    boxes = 2.0 ** draw.uniform(-1.0, 3.0, (96, 1)) * sizes
    return list(seated_state(drive, 0.0, 0.0) + draw.uniform(-1.0, 1.0, boxes.shape) * boxes)
