"""What the jerks of a screw tell of its drive: static friction, and spring and damper between command and screw.

While the screw stands the torque climbs with the slope k Ω up to that at which it breaks loose, which makes the static
coefficient (:mod:`lsvib.sheets.torque.measured`). The damping c is bounded by which files jerk and which are even, as a
drive that starts from rest jerks for ever below its smallest even speed (:mod:`lsvib.stability.starting`). Motor and
control are a spring k with a damper c to the commanded motion, as a PI controller of the speed is: k its integral gain,
c its proportional one and the damping of the screw.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lsvib.drives.drive import Drive
from lsvib.errors import InputError, LsvibError
from lsvib.sheets.torque.measured import Measured, Solution
from lsvib.sheets.torque.records import Record
from lsvib.sheets.torque.starts import Number
from lsvib.stability.solve import bracketed_root
from lsvib.stability.starting import end_from_rest, even_from, runs_evenly

MOST = 30.0  # times critical damping 2 √(k J): largest damping that is tried
WEAK = 1e-3  # of the most damping with which it jerks: what is tried as none
SEEN = 0.8  # of the period that jerks would have: averaged over more, they are not seen
BENT = 0.02  # standard error of all slopes in common, relative, as real ramps are no straight lines

Place = tuple[float, float, float]  # speed of the screw [rad/s], axial load [N] and mass that moves [kg]


@dataclass(frozen=True)
class StickSlip:
    """What records of jerks tell; None is what they do not.

    ``stiffness`` [N m/rad] with its standard error. With inertia and mass of the drive ``damping`` [N m s/rad]: the
    least by which the files that were even are, and the most by which those that jerked jerk, standard errors included;
    in the middle of both ``even_speed`` [rad/s], from which on the drive runs evenly once started in the direction and
    under the load of each record. ``by_periods``: the damping with which it jerks as often as the screw in the mean of
    all records, ``up_to`` which speed [rad/s], and of each the measured and its own of ``periods`` [s], whose ratios
    differ between records by ``uneven`` [1]. ``doubt``: why these are not known.
    """

    stiffness: Number
    damping: tuple[float, float] | None = None
    even_speed: float | None = None
    by_periods: float | None = None
    up_to: float | None = None
    periods: tuple[Number, ...] = ()
    uneven: Number | None = None
    doubt: str = ""

    @property
    def middle(self) -> float | None:
        """The damping in the middle of both ends [N m s/rad]; None without a lower one."""
        return 0.5 * (self.damping[0] + self.damping[1]) if self.damping and self.damping[0] else None


def combined(found: Sequence[Number], bent: float = BENT) -> Number:
    """Return the weighed mean; its error is larger where values differ by more, and holds what is ``bent`` in all."""
    values, errors = np.array(found).T
    weights = 1 / errors**2
    mean = float(np.sum(weights * values) / weights.sum())
    excess = np.sum(weights * (values - mean) ** 2) / max(len(found) - 1, 1)
    return mean, math.hypot(math.sqrt(max(1.0, float(excess)) / weights.sum()), bent * mean)


def explained(
    measured: Measured,
    solution: Solution,
    records: Mapping[Place, Record],
    even: Iterable[tuple[Place, float]],
    inertia: float | None,
) -> StickSlip | None:
    """Return what ``records`` of jerks tell beside the law of files that were ``even``; None without a stiffness.

    The latter with the time [s] over which a sample of theirs stands, too long a one hiding jerks. Damping and even
    speed take the ``inertia`` [kg m²] of what turns, and the masses.
    """
    stiffnesses = [record.stiffness for record in records.values() if record.stiffness is not None]
    if not stiffnesses:
        return None
    known = StickSlip(combined(stiffnesses))
    given = {"screw.inertia": inertia is not None, "load.mass": all(mass for _, _, mass in records)}
    if inertia is None or not all(given.values()):
        missing = " and ".join(name for name, there in given.items() if not there)
        return replace(known, doubt=f"they need {missing}, too")
    if measured.preload:
        return replace(known, doubt="the motion of a preloaded nut cannot be computed")
    if not solution.static:
        return replace(known, doubt="the torque at which the screw breaks loose is not above that of slow sliding")
    jerks = {at: record.period[0] for at, record in records.items() if record.period is not None}
    swing = max(
        record.breakaway[0] - record.after[0] for record in records.values() if record.breakaway and record.after
    )
    seen = [at for at, blur in even if blur < SEEN * swing / (known.stiffness[0] * abs(at[0]))]
    try:
        found = _damped(measured, solution, known, jerks, slowest(seen), inertia)
    except LsvibError as error:
        return replace(known, doubt=str(error).removesuffix("."))
    if len(found.periods) < 2:
        return found
    # A drop of the torque, and with it a period, is about twice what breaks loose less what slides.
    told = [(one.breakaway, one.after) for one in records.values() if one.breakaway and one.after]
    parts = [2 * error / (before - after) for (before, error), (after, _) in told]
    ratios = [model / period for period, model in found.periods]
    return replace(found, uneven=(max(ratios) - min(ratios), math.hypot(*parts)))


def _damped(
    measured: Measured,
    solution: Solution,
    known: StickSlip,
    jerks: Mapping[Place, float],
    even: Sequence[Place],
    inertia: float,
) -> StickSlip:
    """Add damping, even speed and periods by motions from rest; ``jerks``: measured periods [s]."""
    law, unsure = solution.drive() | solution.bearing(), {"coupling_stiffness": known.stiffness} | solution.static

    def drive(speed: float, load: float, mass: float, damping: float, errors: float = 0.0) -> Drive:
        """The drive at a speed under a load, with stiffness and static friction changed by so many standard errors."""
        changed = {name: value + errors * error for name, (value, error) in unsure.items()}
        return Drive(
            **law | changed, pitch_radius=measured.pitch_radius, mass=mass,
            lead_angle=measured.lead_angle, screw_inertia=inertia, axial_force=-load,
            support_damping=damping + solution.values["viscous"], input_speed=speed,
        )  # fmt: skip

    most = MOST * 2 * math.sqrt(known.stiffness[0] * inertia)

    def least(at: Place, errors: float) -> float:
        """The damping from which on the drive runs evenly at a place."""
        return surely_even_from(lambda c: drive(*at, c, errors), most)

    low, high = max((least(at, -1.0) for at in even), default=0.0), min(least(at, 1.0) for at in jerks)
    if not 0 < high < math.inf:
        raise InputError("no damping makes such a drive jerk and run steadily where it did; check screw.inertia.")
    if not low < high:
        raise InputError(
            f"files with steady running need a damping of at least {low:.3g} N m s/rad, and those with jerks at most "
            f"{high:.3g}: a spring and a damper do not explain both"
        )
    found = replace(known, damping=(low, high))
    if (damping := found.middle) is None:
        return replace(found, doubt="no file surely shows steady running, so the damping has no lower bound")

    def fast(at: Place, damping: float) -> float:
        """The speed from which on it runs evenly in the direction of a place."""
        return surely_even_from(lambda v: drive(math.copysign(v, at[0]), *at[1:], damping), 100 * abs(at[0]))

    speed = max(fast(at, damping) for at in jerks)
    found = replace(found, even_speed=speed if speed < math.inf else None)

    def periods(damping: float) -> list[Number]:
        """Measured periods, and those of the drive, infinite where it does not jerk."""
        return [(seen, end_from_rest(drive(*at, damping)).period) for at, seen in jerks.items()]

    def longer(damping: float) -> float:
        """By how much, in logarithm, jerks of the drive are longer in the mean."""
        return sum(math.log(model / seen) if model < math.inf else -10.0 for seen, model in periods(damping))

    if not longer(WEAK * high) > 0 > longer(high):
        return found
    own = bracketed_root(longer, WEAK * high, high, 1e-3 * high)
    up_to = max(fast(at, own) for at in jerks)
    return replace(found, by_periods=own, up_to=up_to, periods=tuple(periods(own)))


def surely_even_from(drive: Callable[[float], Drive], most: float) -> float:
    """Return the value up to ``most``, a damping or a speed, from which on a drive runs evenly; infinite if none is.

    Raises ``InputError`` where it is not known of a motion what it ends in.
    """

    def evenly(value: float) -> bool:
        """Whether it runs evenly with this value."""
        if (found := runs_evenly(drive(value))) is None:
            raise InputError("a motion with such a damping takes too long to compute.")
        return found

    return even_from(evenly, [1e-4 * most, most], most) or 0.0


def breaking(jerks: Iterable[tuple[int, float, Record]]) -> tuple[list[tuple[float, float, float]], float]:
    """Return direction, torque [N m] and load [N] at which records of jerks break loose, and their error, relative.

    ``jerks``: direction of turning, load and record of each. The largest error counts for all, as it may be common.
    """
    known = [(sense, load, record.breakaway) for sense, load, record in jerks if record.breakaway is not None]
    rows = [(float(sense), sense * torque, load) for sense, load, (torque, _) in known]
    return rows, max((error / abs(torque) for _, _, (torque, error) in known), default=0.0)


def slowest(files: Iterable[Place]) -> list[Place]:
    """Return the slowest file of each direction under each load."""
    kept = {(math.copysign(1.0, at[0]), at[1]): at for at in sorted(files, key=lambda at: -abs(at[0]))}
    return list(kept.values())
