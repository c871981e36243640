r"""The torque of a screw that turns steadily, points at which it was measured, and numbers that fit them; SI units.

A motor that turns the screw at ω against an axial load W (positive against outward travel, θ′ > 0) needs

    T = T₀ + s T_b + b ω − r_m W ξ_±(μ(v)),    s = sgn ω,    v = r_m |ω| / cos λ,

with law − (ξ₋ = −tan(φ + λ), lifting) where W ω > 0 and law + (ξ₊ = tan(φ − λ), lowering) elsewhere, φ = arctan μ,
and μ(v) the law of :mod:`lsvib.drives.friction` of the square thread. T_b and b are the Coulomb and viscous drag of
bearings and slide, T₀ the error of the torque's zero, which has the same sign in both directions, as the load has.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from lsvib.drives import friction
from lsvib.drives.mechanics import friction_factor, relieved_half, thread_force
from lsvib.sheets.torque.starts import Array, Number

PARAMETERS = {  # unit and words, those of the law as parameters of a drive have them
    "friction_coefficient": ("1", "friction coefficient of the threads"),
    "stribeck_rise": ("1", "rise of friction towards slow sliding"),
    "stribeck_speed": ("m s-1", "sliding speed over which the rise fades"),
    "friction_slope": ("s m-1", "slope of friction over the sliding speed"),
    "coulomb": ("N m", "Coulomb drag of the bearing"),
    "viscous": ("N m s rad-1", "viscous drag of the bearing"),
    "offset": ("N m", "zero error of the torque"),
}
OF_RISE = ("stribeck_rise", "stribeck_speed")
BREAKAWAY = ("static_friction_coefficient", "bearing_static_friction")  # friction at rest, likewise
LOSS = 3.0  # standard deviations from which on a residual counts as an outlier
SAME_SPEED = 0.05  # relative: files of one commanded speed are not further apart


@dataclass(frozen=True)
class Measured:
    """Points of steady motion (n): ``speed`` [rad/s], ``torque`` [N m], axial ``load`` W [N]; and the screw.

    ``breakaway`` (k, 3): direction ±1, torque [N m] and load [N] at which a screw at rest began to turn. ``preload``
    [N] and ``load_share`` of a nut of two halves, :func:`lsvib.drives.mechanics.relieved_half`. ``loose``: standard
    error of the breakaway torques, relative, that all of them may have in common. ``rate`` (n) of the speed [rad/s²],
    whose torque was taken off by an inertia of a standard error ``unsure`` [kg m²].
    ``spread`` (n) of the speeds over which it is a mean [rad/s].
    """

    speed: Array
    torque: Array
    load: Array
    pitch_radius: float
    lead_angle: float
    breakaway: Array = field(default_factory=lambda: np.zeros((0, 3)))
    preload: float = 0.0
    load_share: float = 1.0
    loose: float = 0.0
    rate: Array | float = 0.0
    unsure: float = 0.0
    spread: Array | float = 0.0

    @property
    def directions(self) -> int:
        """Number of directions of turning, 1 or 2."""
        return np.unique(np.sign(self.speed)).size

    def model(self, values: Mapping[str, Any]) -> Array:
        """Return the torque of a law [N m], by names of :data:`PARAMETERS`, in the mean over the spread of speeds."""
        spread = np.minimum(self.spread, 0.5 * np.abs(self.speed))
        ends = (self.speed + side * spread for side in ((1, -1) if np.any(spread) else (0,)))
        return np.asarray(np.mean([steady_torque(values, self, end, self.load) for end in ends], axis=0))

    @property
    def speeds(self) -> Array:
        """The different speeds |ω|, ascending [rad/s]."""
        found, kept = np.unique(np.abs(self.speed)), [0]
        while (k := int(np.searchsorted(found, found[kept[-1]] * (1 + SAME_SPEED)))) < found.size:
            kept.append(k)
        return np.asarray(found[kept])

    @property
    def sizes(self) -> dict[str, float]:
        """The natural size of each parameter: what alone would make the typical torque at the highest speed."""
        torque, fastest = float(np.median(np.abs(self.torque))), float(self.speeds[-1])
        force = float(np.median(np.abs(self.load)))
        rubs = force + 2 * relieved_half(force, self.preload, self.load_share)
        level = torque / (self.pitch_radius * (rubs or 1.0))
        sliding = self.sliding(fastest)
        sizes = (level, level, sliding, level / sliding, torque, torque / fastest, torque)
        return dict(zip(PARAMETERS, sizes, strict=True))

    @property
    def fading(self) -> tuple[float, float]:
        """The sliding speeds [m/s] between which a rise would fade that the measured speeds can show."""
        return 0.3 * float(self.sliding(self.speeds[0])), float(self.sliding(self.speeds[-1]))

    def sliding(self, speed: Any) -> Any:
        """Return the sliding speed [m/s] at speeds of the screw [rad/s]."""
        return self.pitch_radius * np.abs(speed) / math.cos(self.lead_angle)

    def pressed(self, sense: Any, load: Any) -> tuple[Any, ...]:
        """Return the force of loads, that of the relieved half of the nut [N], and the law, turned in a direction."""
        force = np.abs(load)
        return force, relieved_half(force, self.preload, self.load_share), np.where(load * sense > 0, -1, 1)

    def threads(self, coefficient: Any, sense: Any, load: Any) -> Any:
        """Return the torque of the threads [N m] in the direction of turning."""
        force, relieved, law = self.pressed(sense, load)
        return self.pitch_radius * thread_force(force, relieved, coefficient, math.tan(self.lead_angle), law)


@dataclass(frozen=True)
class Solution:
    """Numbers that fit the points, by names of :data:`PARAMETERS` and ``stribeck_exponent``.

    ``free``: the names that were fitted, in the order of ``covariance`` (f, f); ``residual`` (n) [N m], measured less
    fitted. ``static``: static friction with its standard error, by names of :data:`BREAKAWAY`, where it is above that
    of sliding; ``absurd``: number of breakaway torques that no static coefficient explains.
    """

    values: dict[str, float]
    free: tuple[str, ...]
    covariance: Array
    residual: Array
    static: dict[str, Number] = field(default_factory=dict)
    absurd: int = 0

    @property
    def errors(self) -> dict[str, float]:
        """Standard errors of the numbers that were fitted."""
        return dict(zip(self.free, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def correlation(self) -> Array:
        """Correlation of the numbers that were fitted (f, f)."""
        scale = np.sqrt(np.diag(self.covariance))
        scale[scale == 0] = 1.0  # without any residual
        return np.asarray(self.covariance / np.outer(scale, scale))

    @property
    def rms(self) -> float:
        """Root of the mean square of the residuals [N m]."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def scatter(self) -> float:
        """Standard deviation of the points about the law [N m], with residuals of outliers cut down to :data:`LOSS`."""
        size = np.abs(self.residual)
        capped = np.minimum(size, LOSS * 1.4826 * np.median(size))
        return float(np.sqrt(np.sum(capped**2) / max(size.size - len(self.free), 1)))

    def drive(self) -> dict[str, float]:
        """Return the friction law as parameters of a drive; those of a rise or slope that it has not are left out."""
        law = {"friction_coefficient": self.values["friction_coefficient"]}
        if self.values["stribeck_rise"]:
            law |= {name: self.values[name] for name in (*OF_RISE, "stribeck_exponent")}
        if self.values["friction_slope"]:
            law["friction_slope"] = self.values["friction_slope"]
        return law | {name: value for name, (value, _) in self.static.items() if name == BREAKAWAY[0]}

    def bearing(self) -> dict[str, float]:
        """Return dry friction of the bearing as parameters of a drive, those that are not zero."""
        found = {"bearing_friction": self.values["coulomb"]} if self.values["coulomb"] else {}
        return found | {name: value for name, (value, _) in self.static.items() if name == BREAKAWAY[1]}


def steady_torque(values: Mapping[str, Any], measured: Measured, speed: Any, load: Any) -> Any:
    """Return the torque [N m] at speeds ω ≠ 0 [rad/s] under loads W [N], as above.

    Arguments broadcast; ``values`` by names of :data:`PARAMETERS`. Over the measured speeds no law is below zero.
    """
    law = SimpleNamespace(**{"stribeck_exponent": 1, **values})
    mu = friction.unbounded(law, measured.sliding(speed))[0]
    sense = np.sign(speed)
    threads = sense * measured.threads(mu, sense, load)
    return values["offset"] + values["coulomb"] * sense + values["viscous"] * speed + threads


def load_of_directions(measured: Measured, solution: Solution) -> float | None:
    """Return by how much the load is larger [N] if the difference of both directions is all the load's, T₀ being zero.

    To lift takes more than to lower, by r_m W (tan(φ + λ) − tan(φ − λ)); None where one direction was measured only.
    """
    if measured.directions == 1 or not measured.load.any():
        return None
    law = SimpleNamespace(**solution.values)
    mu = float(np.median(np.maximum(friction.unbounded(law, measured.sliding(measured.speed))[0], 0.0)))
    tangent = math.tan(measured.lead_angle)
    lever = 0.5 * measured.pitch_radius * -sum(friction_factor(mu, tangent, s) for s in (1, -1))
    return float(solution.values["offset"] / lever)


def halves(measured: Measured) -> Array:
    """Return speed |ω| [rad/s], half-sum and half-difference [N m] of both directions at equal speeds and loads (k, 3).

    The half-sum of the torques' magnitudes is friction, the half-difference, positive direction less negative, the load
    (and T₀).
    """
    rows = []
    for k in np.lexsort((np.abs(measured.speed), measured.load)):
        speed, alike = measured.speed[k], measured.load == measured.load[k]
        near = alike & (measured.speed < 0) & (np.abs(measured.speed + speed) <= SAME_SPEED * speed)
        if near.any():
            forth, back = measured.torque[k], -measured.torque[near].mean()
            rows.append((speed, 0.5 * (forth + back), 0.5 * (forth - back)))
    return np.array(rows).reshape(-1, 3)
