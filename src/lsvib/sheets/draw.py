"""A drive of a data sheet, or many drawn from its uncertainties: from the entries of the sheet to its quantities.

And a point of its operation: parameters there, reserves, motions.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lsvib.drives import friction
from lsvib.drives.drive import DRY, PARTS, Drive, zero_if_close
from lsvib.errors import EngineError, InputError
from lsvib.sheets import vibration
from lsvib.sheets.drive_entries import Motor
from lsvib.sheets.formulas import (
    FRICTION,
    GRAVITY,
    Values,
    coefficient_from_efficiency,
    flank_coefficient,
    lifting_efficiency,
    lowering_efficiency,
    sliding_speed,
    square_coefficient,
    thread_geometry,
)
from lsvib.sheets.move import Course, course, started
from lsvib.sheets.reserves import reserves, without
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.threads import SCREW_MATERIALS
from lsvib.sheets.words import QUANTITIES

PAIRS = {"force": ("force_low", "force_high"), "speed": ("speed_low", "speed_high")}
"""Quantities of the window, which are changed together."""

_ABSENT = (  # quantities that are entries as they are, absent where the sheet does not give them
    *("bearing_friction", "bearing_static_friction", "collar_friction", "collar_diameter", "slide_friction"),
    *("slide_static_friction", "stribeck_rise", "stribeck_speed", "static_friction_coefficient"),
    *("contact_stiffness", "contact_damping", "support_stiffness", "axial_support_damping"),
)


@dataclass(frozen=True, eq=False)
class Draw:
    """A drive of a sheet, or many: ``values`` by :data:`lsvib.sheets.words.QUANTITIES`, floats or arrays (n).

    ``entries``: of the sheet, from which they follow, but for changes.
    """

    sheet: Sheet
    values: Values
    entries: Values

    @classmethod
    def of(cls, sheet: Sheet, shares: NDArray[np.float64] | None = None) -> Self:
        """Return the drive at the middle values, or for a point (d) or points (d, n) of the unit cube.

        ``shares``: one coordinate to each uncertain entry.
        """
        entries: dict[str, Any] = {path: entry.nominal for path, entry in sheet.spreads.items()}
        if shares is not None:
            inside = np.clip(shares, 1e-9, 1 - 1e-9)  # off the ends, where some are infinite
            pairs = zip(sheet.random, inside, strict=True)
            entries |= {path: sheet.spreads[path].quantile(share) for path, share in pairs}
        if shares is not None and shares.ndim > 1:
            return cls(sheet, _quantities(sheet, entries), entries)
        entries = {path: float(value) for path, value in entries.items()}
        return cls(sheet, {key: float(value) for key, value in _quantities(sheet, entries).items()}, entries)

    def changed(self, **values: Any) -> Self:
        """Return it with some quantities changed."""
        return replace(self, values={**self.values, **values})

    def scaled(self, keys: Sequence[str], factors: Any) -> Self:
        """Multiply some quantities, and what the sheet makes follow from them.

        With another diameter a given lead angle leads further, and a screw of some length is another cylinder; with
        another lead the speed of the load turns the screw slower; with another inertia a bandwidth has other gains.
        """
        sheet, old, entries = self.sheet, self.values, self.entries
        new = {key: old[key] * factors for key in keys}
        if "pitch_diameter" in keys and sheet.thread.lead_angle is not None:
            new["lead"] = old["lead"] * factors
        if "pitch_diameter" in keys and sheet.screw.inertia is None and sheet.screw.diameter is None:
            besides = entries.get("coupling.inertia", 0.0)
            new["screw_inertia"] = besides + (old["screw_inertia"] - besides) * factors**4
            if "screw_mass" in old and sheet.screw.mass is None:
                new["screw_mass"] = old["screw_mass"] * factors**2
        if "lead" in new and sheet.operation.of_load:
            new |= {key: old[key] / factors for key in PAIRS["speed"]}
        if "mass" in new and "guide.coefficient" in entries:
            pressed = entries["guide.coefficient"] * GRAVITY * np.cos(old["tilt"])
            new["slide_friction"] = old["slide_friction"] + pressed * (new["mass"] - old["mass"])
        if "motor.bandwidth" in entries and new.keys() & {"motor_inertia", "screw_inertia"}:
            own = [sum({**old, **more}[key] for key in ("motor_inertia", "screw_inertia")) for more in ({}, new)]
            new |= {key: old[key] * own[1] / own[0] for key in ("speed_gain", "integral_gain")}
        return self.changed(**new)

    @property
    def shape(self) -> tuple[int, ...]:
        """That of the arrays, () of one drive."""
        return np.broadcast_shapes(*map(np.shape, self.values.values()))

    @property
    def weight(self) -> Any:
        """The part of the weight along the axis [N], against outward travel."""
        return self.values["mass"] * GRAVITY * np.sin(self.values["tilt"])

    @property
    def lifts(self) -> int:
        """The direction of travel that lifts the load, if no other force exceeds its weight along the axis; else 0."""
        most = max(abs(self.values[key]) for key in PAIRS["force"])
        return int(np.sign(self.weight)) if abs(self.weight) >= most else 0

    @property
    def collar(self) -> Any:
        """What a thrust collar adds to |ξ_s|, μ_b r_b / r_m [1]; zero without one."""
        collar = self.values.get("collar_friction", 0.0) * self.values.get("collar_diameter", 0.0)
        return collar / self.values["pitch_diameter"]

    @property
    def pitch_radius(self) -> Any:
        """Half of the pitch diameter, r_m [m]."""
        return 0.5 * self.values["pitch_diameter"]

    @property
    def lead_angle(self) -> Any:
        """λ [rad]."""
        return np.arctan(self.values["lead"] / (2 * math.pi * self.pitch_radius))

    @property
    def travel(self) -> Any:
        """The travel of the load per radian of the screw [m]."""
        return self.values["lead"] / (2 * math.pi)

    @property
    def run(self) -> Course | None:
        """The move of the sheet, or a ramp of its acceleration to the highest speed; None if it has neither."""
        operation, entries = self.sheet.operation, self.entries
        if operation.acceleration is None:
            return course(operation.move, entries, self.values["lead"]) if operation.move else None
        speed = self.values["speed_high"] * self.travel
        most = entries["operation.acceleration"] * (1.0 if operation.acceleration.unit == "m/s^2" else self.travel)
        return Course(speed, speed / most, np.inf, most)

    @property
    def friction_law(self) -> dict[str, Any]:
        """The friction law of the square thread (:mod:`lsvib.drives.friction`), as parameters of a drive."""
        law = {key: self.square(self.values.get(key, 0.0)) for key in FRICTION}
        fading = {"stribeck_speed": self.values.get("stribeck_speed", 0.0)}
        return law | fading | {"stribeck_exponent": self.sheet.friction.stribeck_exponent}

    def square(self, coefficient: Any) -> Any:
        """Return the coefficient of the square thread for one of the flanks."""
        return square_coefficient(coefficient, self.lead_angle, self.values["half_angle"])

    def friction_at(self, speed: Any) -> tuple[Any, Any]:
        """Return μ [1] of the square thread at a speed of the screw [rad/s], not below zero, and its slope μ′ [s/m]."""
        if self.sheet.friction.law:
            sliding = sliding_speed(speed, self.pitch_radius, self.lead_angle)
            coefficient, slope = friction.unbounded(SimpleNamespace(**self.friction_law), sliding)
            positive = coefficient > 0
            return np.where(positive, coefficient, 0.0), np.where(positive, slope, 0.0)
        return self.square(self.values["friction_coefficient"]), self.square(self.values["friction_slope"])

    @property
    def efficiencies(self) -> tuple[Any, Any]:
        """The lifting and the lowering efficiency [1] at the middle speed; below zero the latter is self-locking."""
        coefficient, _ = self.friction_at(0.5 * (self.values["speed_low"] + self.values["speed_high"]))
        thread = coefficient, self.lead_angle, self.collar
        return lifting_efficiency(*thread), lowering_efficiency(*thread)


def _quantities(sheet: Sheet, entries: Values) -> dict[str, Any]:
    """The quantities of :data:`lsvib.sheets.words.QUANTITIES` from the entries of a sheet.

    Entries are floats, or arrays of one shape. Quantities that the sheet does not give are zero, or absent for a
    contact, support, motor, bearing or law of friction that it does not have.
    """
    lead, diameter, half_angle = thread_geometry(sheet, entries)
    inertia, screw_mass = _screw(sheet, entries, diameter)
    gear = entries.get("coupling.gear_ratio", 1.0) ** 2
    coefficient = entries.get("friction.coefficient")
    if coefficient is None:
        angle = np.arctan(lead / (math.pi * diameter))
        square = coefficient_from_efficiency(entries["friction.efficiency"], angle)
        coefficient = flank_coefficient(square, angle, half_angle)
    found = {
        "lead": lead,
        "pitch_diameter": diameter,
        "half_angle": half_angle,
        "friction_coefficient": coefficient,
        "friction_slope": entries.get("friction.slope", 0.0),
        "screw_inertia": inertia + entries.get("coupling.inertia", 0.0),
        "coupling_stiffness": entries.get("coupling.stiffness", 0.0) * gear,
        "support_damping": entries.get("damping.rotational", 0.0) + entries.get("bearing.viscous", 0.0),
        "translation_damping": entries.get("damping.translational", 0.0),
        "mass": entries.get("load.mass", 0.0),
        "tilt": entries.get("load.orientation", 0.0),
    }
    undamped = {f"{part}.damping": 0.0 for part in ("contact", "support") if f"{part}.stiffness" in entries}
    given = {**undamped, **entries}
    found |= {key: given[path] for key in _ABSENT if (path := QUANTITIES[key].entry) in given}
    if "guide.coefficient" in entries:
        pressed = entries["guide.coefficient"] * found["mass"] * GRAVITY * np.cos(found["tilt"])
        found["slide_friction"] = found.get("slide_friction", 0.0) + pressed
    if sheet.motor is not None and sheet.motor.complies:
        found |= _motor(sheet.motor, entries, found["screw_inertia"], gear)
    if sheet.support is not None:
        found["screw_mass"] = screw_mass
    move, turns = sheet.operation.move, 1.0
    if move or sheet.operation.of_load:
        turns = 2 * math.pi / lead  # of the screw, from the speed of the load to rad/s
    run = {"operation.speed": course(move, entries, lead).speed} if move else {}
    for key, path, scale in (("force", "load.force", 1.0), ("speed", "operation.speed", turns)):
        one = {**entries, **run}.get(path, 0.0)
        low, high = (sheet.spreads[path].low, sheet.spreads[path].high) if sheet.is_window(path) else (one, one)
        found |= {f"{key}_low": low * scale, f"{key}_high": high * scale}
    return found


def _screw(sheet: Sheet, entries: Values, pitch_diameter: Any) -> tuple[Any, Any]:
    """Inertia [kg m²] and mass [kg] of the screw, a cylinder where they are not given."""
    screw = sheet.screw
    if screw.inertia is not None or screw.length is None:
        return entries.get("screw.inertia", 0.0), entries.get("screw.mass")
    density = entries.get("screw.density", SCREW_MATERIALS[screw.material or "steel"].density)
    diameter = entries.get("screw.diameter", pitch_diameter)
    mass = density * math.pi / 4 * diameter**2 * entries["screw.length"]
    return mass * diameter**2 / 8, entries.get("screw.mass", mass)


def _motor(motor: Motor, entries: Values, inertia: Any, gear: Any) -> dict[str, Any]:
    """What a motor is on the side of the screw, whose ``inertia`` counts for the gains by bandwidth."""
    own = entries["motor.inertia"] * gear
    damping, stiffness = entries.get("motor.speed_gain", 0.0) * gear, entries.get("motor.integral_gain", 0.0) * gear
    if "motor.bandwidth" in entries:
        rate = 2 * math.pi * entries["motor.bandwidth"]
        damping, stiffness = rate * (own + inertia), rate**2 * (own + inertia) / 4
    if "motor.holding_torque" in entries:
        stiffness = entries["motor.holding_torque"] * motor.steps_per_turn / 4 * gear
    found = {"motor_inertia": own, "integral_gain": stiffness, "speed_gain": damping}
    return found | {"coupling_damping": entries.get("coupling.damping", 0.0) * gear}


_RIGID = ("screw_inertia", "coupling_stiffness", "support_damping", "mass", "translation_damping")


@dataclass(frozen=True, eq=False)
class Operation:
    """A point of operation: ``direction`` of travel ±1, ``speed`` of the screw > 0 [rad/s], ``force`` [N].

    The force acts against outward travel; the weight adds to it.
    """

    draw: Draw
    direction: Any
    speed: Any
    force: Any

    @property
    def corner(self) -> tuple[Any, Any, Any]:
        """Direction, speed and force."""
        return self.direction, self.speed, self.force

    @cached_property
    def friction(self) -> tuple[Any, Any]:
        """Coefficient μ [1] of the square thread at the speed, not below zero, and its slope μ′ [s/m]."""
        return self.draw.friction_at(self.speed)

    @cached_property
    def parameters(self) -> dict[str, Any]:
        """The parameters of the drive with all of its parts; friction is that at the speed."""
        draw, values = self.draw, self.draw.values
        names = (*_RIGID, *DRY, *(key for part in draw.sheet.parts for key in PARTS[part]), "coupling_damping")
        found = {key: values[key] for key in names if key in values}
        if "collar_friction" in values:
            found["collar_radius"] = 0.5 * values["collar_diameter"]
        return found | {
            "pitch_radius": draw.pitch_radius,
            "lead_angle": draw.lead_angle,
            "friction_coefficient": self.friction[0],
            "input_speed": self.direction * self.speed,
            "axial_force": -(self.force + draw.weight),
        }

    @cached_property
    def reserves(self) -> dict[str, Any]:
        """The reserve [1] of each mechanism, see :func:`lsvib.sheets.reserves.reserves`."""
        return reserves(self.parameters, self.friction[1], self.draw.sheet.friction.sloped)

    @cached_property
    def drive(self) -> Drive:
        """The drive with the parts of the sheet; with its law of friction, if there is one, else its coefficient here.

        Raises ``InputError`` where it is out of range.
        """
        return self._drive(self.parameters)

    @cached_property
    def rigid(self) -> Drive:
        """The same with rigid parts, and a motor that turns as it is told."""
        return self._drive(without(self.parameters, *PARTS))

    def _drive(self, parameters: Values) -> Drive:
        given = {**parameters, **(self.draw.friction_law if self.draw.sheet.friction.law else {})}
        return Drive(**{key: zero_if_close(key, float(value)) for key, value in given.items()})

    def started(self, drive: Drive, work: float = 1e5) -> tuple[float, ...]:
        """Return the state of a drive after the ramp of the sheet from rest; empty without a ramp."""
        if (run := self.draw.run) is None:
            return ()
        ramp = float(run.ramp * self.speed / self.draw.values["speed_high"])
        return tuple(started(drive, self.draw.sheet.operation.move, ramp, work=work).end_state[:-1].tolist())

    def motion(self, perturbation: float | None = vibration.NUDGE, stiff: bool = False) -> vibration.Vibration:
        """Return the motion from near steady sliding, u = 0, w = ``perturbation`` Ω, or None from rest, to its end.

        ``stiff``: that of the rigid drive. Friction is that at the running speed, to which a slope adds nothing,
        unless the sheet has a law of friction.
        """
        try:
            drive = self.rigid if stiff else self.drive
            return vibration.vibration(drive, perturbation, self.started(drive) if perturbation is None else ())
        except (InputError, EngineError) as error:
            return vibration.Vibration(() if stiff else self.draw.sheet.parts, "unknown", reason=str(error))

    @cached_property
    def after_knock(self) -> str:
        """What a motion after a strong perturbation ends in, by a key of :data:`lsvib.sheets.words.ATTRACTORS`."""
        try:
            return vibration.after_knock(self.drive)
        except (InputError, EngineError):
            return "unknown"

    @cached_property
    def tolerated(self) -> vibration.Tolerated:
        """The sudden change of the screw's speed [rad/s] that the rigid drive tolerates, and a sentence."""
        return vibration.tolerated(self.rigid)
