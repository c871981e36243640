"""What the jerks of a screw tell of its drive: static friction, and spring and damper between command and screw.

While the screw stands the torque climbs with the slope k Ω up to that at which it breaks loose, which makes the static
coefficient (:mod:`lsvib.fit.law`). The damping c is bounded by which files jerk and which are even, as a drive that
starts from rest jerks for ever below its smallest even speed (:mod:`lsvib.stability.starting`). Motor and control are a
spring k with a damper c to the commanded motion, as a PI controller of the speed is: k its integral gain, c its
proportional one and the damping of the screw.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lsvib.fit.law import Measured, Solution
from lsvib.fit.records import Number
from lsvib.models.drive import Drive

MOST = 30.0  # times critical damping 2 √(k J): largest damping that is tried
CLOSE = 1e-3  # relative, to which a damping or a speed is closed in on


Place = tuple[float, float, float]  # speed of the screw [rad/s], axial load [N] and mass that moves [kg]


@dataclass(frozen=True)
class StickSlip:
    """What records of jerks tell; None is what they do not.

    ``stiffness`` [N m/rad] with its standard error. With inertia and mass of the drive ``damping`` [N m s/rad]: the
    least by which the files that were even are, and the most by which those that jerked jerk, standard errors included;
    in the middle of both ``even_speed`` [rad/s], from which on the drive runs evenly once started, and the ``periods``
    [s] with which it jerks in the place of each file that jerked. ``doubt``: why these are not known.
    """

    stiffness: Number
    damping: tuple[float, float] | None = None
    even_speed: float | None = None
    periods: tuple[float, ...] = ()
    doubt: str = ""

    @property
    def middle(self) -> float | None:
        """The damping in the middle of both ends [N m s/rad]."""
        return (
            None if self.damping is None else math.sqrt(max(self.damping[0], 1e-3 * self.damping[1]) * self.damping[1])
        )


def combined(found: Sequence[Number]) -> Number:
    """Return the weighed mean of estimates; where they differ by more than their errors say, its error is larger."""
    values, errors = np.array(found).T
    weights = 1 / errors**2
    mean = float(np.sum(weights * values) / weights.sum())
    excess = np.sum(weights * (values - mean) ** 2) / max(len(found) - 1, 1)
    return mean, float(math.sqrt(max(1.0, excess) / weights.sum()))


def explained(
    measured: Measured,
    solution: Solution,
    stiffnesses: Sequence[Number],
    jerked: Sequence[Place],
    even: Iterable[Place],
    inertia: float | None,
) -> StickSlip:
    """Return what files that ``jerked``, some with a stiffness, tell beside the law of those that were ``even``.

    Damping and even speed take the ``inertia`` [kg m²] of what turns, and the masses.
    """
    stiffness = combined(stiffnesses)
    static = solution.static
    doubt = "the motion of a preloaded nut is not followed" if measured.preload else ""
    if inertia is None or not all(mass for _, _, mass in jerked):
        doubt = "they take screw.inertia and load.mass, which the sheet does not give"
    elif static is None:
        doubt = "the torque at which the screw breaks loose is not above that of slow sliding"
    if doubt or static is None or inertia is None:
        return StickSlip(stiffness, doubt=doubt)
    law = solution.drive() | {"bearing_friction": solution.values["coulomb"]}

    def drive(speed: float, load: float, mass: float, damping: float, errors: float = 0.0) -> Drive:
        """The drive at a speed under a load, with stiffness and static friction changed by so many standard errors."""
        stiff, rough = (value + errors * error for value, error in (stiffness, static))
        return Drive(
            **law | {"static_friction_coefficient": rough}, pitch_radius=measured.pitch_radius, mass=mass,
            lead_angle=measured.lead_angle, screw_inertia=inertia, axial_force=-load, coupling_stiffness=stiff,
            support_damping=damping + solution.values["viscous"], input_speed=speed,
        )  # fmt: skip

    most = MOST * 2 * math.sqrt(stiffness[0] * inertia)

    def damped(at: Place, errors: float) -> float:
        """The damping from which on the drive runs evenly at a place."""
        return even_from(lambda c: drive(*at, c, errors), most)

    low, high = max((damped(at, -1.0) for at in slowest(even)), default=0.0), min(damped(at, 1.0) for at in jerked)
    if not low < high:
        doubt = (
            f"files that were even need a damping of {low:.3g} N m s/rad at least, and those that jerked {high:.3g} at "
            "most: a spring and a damper do not explain both"
        )
        return StickSlip(stiffness, doubt=doubt)
    found = StickSlip(stiffness, (low, high))
    damping = found.middle or high

    def fast(at: Place) -> float:
        """The speed from which on it runs evenly in the direction of a place."""
        return even_from(lambda v: drive(math.copysign(v, at[0]), *at[1:], damping), 100 * abs(at[0]))

    periods = tuple(period(drive(*at, damping)) for at in jerked)
    return replace(found, even_speed=max(map(fast, jerked)), periods=periods)


def even_from(drive: Callable[[float], Drive], most: float) -> float:
    """The value up to ``most``, a damping or a speed, from which on a drive runs evenly; infinite if not even there."""
    from lsvib.stability.starting import runs_evenly  # the engine

    low, high = 1e-4 * most, most
    if not runs_evenly(drive(high)):
        return math.inf
    if runs_evenly(drive(low)):
        return 0.0
    while high - low > CLOSE * high:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if runs_evenly(drive(middle)) else (middle, high)
    return high


def slowest(files: Iterable[Place]) -> list[Place]:
    """Return the slowest file of each direction under each load."""
    kept = {(math.copysign(1.0, at[0]), at[1]): at for at in sorted(files, key=lambda at: -abs(at[0]))}
    return list(kept.values())


def period(drive: Drive) -> float:
    """The period with which a drive jerks once started [s]; NaN where it does not."""
    from lsvib.dynamics.attractor import steady_state
    from lsvib.models.mechanism import standing_state
    from lsvib.models.model import automaton_of

    return steady_state(automaton_of(drive), standing_state(drive)).period
