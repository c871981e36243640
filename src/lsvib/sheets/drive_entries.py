"""Entries of a data sheet on what drives the screw, how it is run, and what brakes it; all parts are of one kind."""

from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict

from lsvib.numbers import whole_between
from lsvib.sheets import fields
from lsvib.sheets.fields import Spread


class Part(BaseModel):
    """A part of a sheet."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)
    _needed: ClassVar[tuple[tuple[str, ...], ...]] = ()  # entries of which one must be given
    _either: ClassVar[tuple[tuple[str, ...], ...]] = ()  # an entry, and others that are not given beside it

    def problem(self) -> str | None:
        """Return what does not fit together, or None."""
        name, given = type(self).__name__.lower(), {key for key in self.model_fields_set if getattr(self, key)}
        for one, *others in self._either:
            if one in given and (too := next(filter(given.__contains__, others), None)):
                return f"{name}.{one} and {name}.{too} are both given; give one of them."
        for keys in self._needed:
            if not given.intersection(keys):
                return f"{name} has none of {', '.join(keys)}; give one of them."
        return self._misfit()

    def _misfit(self) -> str | None:
        """What is wrong besides."""
        return None

    def entries(self, before: str = "") -> Iterator[tuple[str, Any]]:
        """Yield the entries of all parts that are given, such as (load.mass, spread), each with ``before`` its name."""
        for key, entry in self:
            if isinstance(entry, Part):
                yield from entry.entries(f"{before}{key}.")
            elif before and key in self.model_fields_set:
                yield f"{before}{key}", entry


class Coupling(Part):
    """What joins motor and screw; with a gear the stiffness is that on the side of the motor."""

    stiffness: fields.Torsion | None = None
    gear_ratio: fields.Ratio | None = None
    inertia: fields.MoreInertia | None = None
    damping: fields.TurningDamping | None = None


class Motor(Part):
    """The motor before the coupling: what it can give, its inertia, and what ties it to the commanded motion.

    The last are gains of a PI controller of the speed, K_p and K_i, or the ``bandwidth`` ω / 2π of one that on a
    stiff coupling is damped critically, K_p = ω (J + I) and K_i = K_p ω / 4 – assumed where nothing else is known –, or
    of a stepper its ``holding_torque`` and full ``steps_per_turn``, whose torque falls by that times steps / 4 per
    radian. It gives its ``rated_torque`` for ever, its ``peak_torque`` for a while, and as long as a ramp takes what
    its ``torque_curve`` has at each speed, straight between the points and nothing beyond the last.
    A gear or belt behind it loses what its ``gear_efficiency`` leaves.
    """

    inertia: fields.Inertia | None = None
    speed_gain: fields.TurningDamping | None = None
    integral_gain: fields.Torsion | None = None
    bandwidth: fields.Bandwidth | None = None
    holding_torque: fields.Holding | None = None
    steps_per_turn: Annotated[
        int, BeforeValidator(lambda value: whole_between("motor.steps_per_turn", value, 4, 10000))
    ] = 200
    rated_torque: fields.Holding | None = None
    peak_torque: fields.Holding | None = None
    torque_curve: fields.TorqueCurve | None = None
    gear_efficiency: fields.GearEfficiency | None = None
    _needed = (("inertia", "rated_torque", "peak_torque", "holding_torque", "torque_curve", "gear_efficiency"),)
    _either = (("integral_gain", "bandwidth", "holding_torque"), ("bandwidth", "holding_torque", "speed_gain"))

    @property
    def complies(self) -> bool:
        """Whether it takes part in vibration: its inertia and what ties it to its command are given."""
        return self.inertia is not None and any((self.integral_gain, self.bandwidth, self.holding_torque))

    def _misfit(self) -> str | None:
        if "steps_per_turn" in self.model_fields_set and self.holding_torque is None:
            return "motor.steps_per_turn makes the motor a stepper, which needs motor.holding_torque."
        if self.speed_gain is not None and self.integral_gain is None:
            return "motor.speed_gain needs motor.integral_gain, without which the motor falls ever further behind."
        if self.inertia is None and (self.integral_gain or self.bandwidth):
            return "motor.inertia is missing; the controller of the motor needs it."
        return None


class Brake(Part):
    """A brake on the shaft of the motor, or of the screw where there is no gear: it holds the load without current."""

    torque: fields.Holding


class Move(Part):
    """A move of the load from rest to rest: its ``distance``, and two of ``time``, ``speed`` and ``acceleration_time``.

    Each ramp takes the acceleration time. Of a triangle one of them is enough; where one is given of another profile,
    it has thirds: ramp, even run, ramp. An s-curve has twice the mean acceleration in the middle of a ramp, and none at
    its ends. A cycle is the move, ``back`` again if so, and a ``pause``, all of it together, in which the motor holds.
    """

    distance: fields.Length
    time: fields.Duration | None = None
    speed: fields.Speed | None = None
    acceleration_time: fields.Duration | None = None
    pause: fields.Pause | None = None
    back: bool = False
    profile: Literal["trapezoid", "triangle", "s-curve"] = "trapezoid"

    def _misfit(self) -> str | None:
        given = self.time or self.speed or self.acceleration_time
        return None if given else "operation.move has none of time, speed, acceleration_time; give one or two of them."


class Running(Part):
    """How the drive is run: speeds of the screw or of the load, or a move, and the directions of travel."""

    speed: fields.Speed | None = None
    acceleration: fields.Acceleration | None = None
    move: Move | None = None
    direction: Literal["out", "back", "both"] = "both"

    def _misfit(self) -> str | None:
        if self.move is None:
            return None
        if self.speed or self.acceleration:
            return "operation.move has its own speed and ramps; leave out operation.speed and acceleration."
        if self.move.back and self.direction != "both":
            return "operation.move with back travels both ways; leave out back or operation.direction."
        return self.move.problem()

    @property
    def of_load(self) -> bool:
        """Whether the speed is given as that of the load."""
        given = self.speed if self.move is None else self.move.speed
        return given.unit == "m/s" if given else self.move is not None


class Dampings(Part):
    """Viscous damping of the rotation of the screw, and of the travel of the load."""

    rotational: fields.TurningDamping | None = None
    translational: fields.LinearDamping | None = None


class Collar(Part):
    """A thrust collar that slides under the axial force: its friction coefficient and its mean diameter."""

    coefficient: fields.Coefficient
    mean_diameter: fields.Diameter


class Bearing(Part):
    """What brakes the screw: a torque whatever the load, at rest up to ``static``, viscous damping, and a collar."""

    torque: fields.Drag | None = None
    static: fields.Drag | None = None
    viscous: fields.TurningDamping | None = None
    collar: Collar | None = None

    def _misfit(self) -> str | None:
        if self.static is not None and self.torque is None:
            return "bearing.static needs bearing.torque, the friction torque while the screw turns."
        return _too_little("bearing.torque", self.torque, self.static)


class Guide(Part):
    """What brakes the load: friction, at rest up to ``static``, and a ``coefficient`` times the weight on the guide."""

    friction: fields.Rubbing | None = None
    coefficient: fields.Coefficient | None = None
    static: fields.Rubbing | None = None
    _needed = (("friction", "coefficient"),)
    _either = (("coefficient", "static"),)

    def _misfit(self) -> str | None:
        return _too_little("guide.friction", self.friction, self.static)


def _too_little(name: str, sliding: Spread | None, static: Spread | None) -> str | None:
    """Say if friction at rest may be below that in motion: any value of one may come with any of the other."""
    if sliding is None or static is None or static.low >= sliding.high:
        return None
    part, least, most = name.split(".")[0], f"{static.low:g} {static.unit}", f"{sliding.high:g} {sliding.unit}"
    return f"{part}.static, at least {least}, is below the friction in motion, {name}, at most {most}."
