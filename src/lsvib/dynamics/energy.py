"""Work per cycle: what motor and load put in, what friction, damping and impacts take out. Of every drive.

Each power is a quadratic form of (x, 1) in a mode (:mod:`lsvib.drives.powers`), whose integral the flow knows to
rounding. The terms are summed from different laws – input and load from the ends of the drive, friction from N and the
speed of sliding, impacts from the kinetic energy – so that their balance is a check of the cycle.
"""

import math
from dataclasses import dataclass, fields

import numpy as np

from lsvib.drives.drive import Drive
from lsvib.drives.powers import Powers
from lsvib.systems.motion import Motion


@dataclass(frozen=True)
class Work:
    """Work over one period [J]: ``motor`` and ``load`` put in (negative if they take), the others take out.

    ``motor``: Ω ∫ T dt, with the torque T of the coupling or, behind a motor with a controller, that of the controller,
    T = K_p (Ω − θ_m′) + K_i ∫ (Ω − θ_m′) dt. Such a speed loop is then a spring and a damper to the commanded motion:
    its K_p ∫ (Ω − θ_m′)² dt is part of ``damping``, and the rotor receives so much less, ∫ T θ_m′ dt. ``friction`` of
    the threads, of slide, bearing and collar; ``damping``, all dampers; ``impacts``, kinetic energy that seizures
    destroy.
    """

    motor: float
    load: float
    friction: float
    damping: float
    impacts: float

    @property
    def balance(self) -> float:
        """What is put in less what is taken out, relative to the largest term [1]; zero but for rounding."""
        gained = self.motor + self.load - self.friction - self.damping - self.impacts
        largest = max(abs(getattr(self, term.name)) for term in fields(self))
        return gained / largest if largest else 0.0

    @property
    def efficiency(self) -> float:
        """Work that motor or load receives over what the other puts in [1]; 0 if both put in."""
        put_in = max(self.motor, self.load)
        return max(-min(self.motor, self.load), 0.0) / put_in if put_in > 0 else math.nan


def work(drive: Drive, orbit: Motion) -> Work:
    """Return the work of each kind over one period of a cycle of a drive."""
    automaton = orbit.automaton
    powers, totals = Powers(drive, automaton), np.zeros(4)
    for mode, start, _, duration in zip(*orbit.arcs(), strict=True):
        code = int(mode)
        forms = [powers.motor(code), powers.load(), powers.signed_friction(code), powers.damping()]
        forms += powers.friction(code)
        found = automaton.flow.integral(mode, start, float(duration), forms)
        totals += found[:4]
        totals[2] += np.abs(found[4:]).sum()
    lost = np.array([powers.kinetic(x) - powers.kinetic(y) for x, y in zip(orbit.before, orbit.after, strict=True)])
    seized = automaton.marked(orbit.kind, "impact")
    return Work(*map(float, [*totals, lost[seized].sum()]))
