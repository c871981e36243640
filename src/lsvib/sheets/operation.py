"""A drive of a data sheet, and what it is and does at one point of operation: parameters, reserves, motion."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from lsvib.drives import friction
from lsvib.drives.drive import PARTS, Drive, zero_if_close
from lsvib.errors import EngineError, InputError
from lsvib.sheets import mechanisms, vibration
from lsvib.sheets.quantities import (
    FRICTION,
    GRAVITY,
    Values,
    lifting_efficiency,
    lowering_efficiency,
    quantities,
    sliding_speed,
    square_coefficient,
)
from lsvib.sheets.sheet import Sheet
from lsvib.words import plain

_RIGID = ("screw_inertia", "coupling_stiffness", "support_damping", "mass", "translation_damping")
_DRY = ("bearing_friction", "bearing_static_friction", "slide_friction", "slide_static_friction", "collar_friction")
PAIRS = {"force": ("force_low", "force_high"), "speed": ("speed_low", "speed_high")}
"""Quantities of the window, which are changed together."""


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
            return cls(sheet, quantities(sheet, entries), entries)
        entries = {path: float(value) for path, value in entries.items()}
        return cls(sheet, {key: float(value) for key, value in quantities(sheet, entries).items()}, entries)

    def at(self, direction: Any, speed: Any, force: Any) -> "Operation":
        """Return it at a direction of travel ±1, a speed of the screw > 0 [rad/s] and a force [N], or at many."""
        return Operation(self, direction, speed, force)

    def changed(self, **values: Any) -> "Draw":
        """Return it with some quantities changed."""
        return replace(self, values={**self.values, **values})

    def scaled(self, keys: Sequence[str], factors: Any) -> "Draw":
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
        if "lead" in new and sheet.operation.speed.unit == "m/s":
            new |= {key: old[key] / factors for key in PAIRS["speed"]}
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
    def friction_law(self) -> dict[str, Any]:
        """The friction law of the square thread (:mod:`lsvib.drives.friction`), as parameters of a drive."""
        law = {key: self.square(self.values.get(key, 0.0)) for key in FRICTION}
        fading = {"stribeck_speed": self.values.get("stribeck_speed", 0.0)}
        return law | fading | {"stribeck_exponent": self.sheet.friction.stribeck_exponent}

    def square(self, coefficient: Any) -> Any:
        """Return the coefficient of the square thread for one of the flanks."""
        return square_coefficient(coefficient, self.lead_angle, self.values["half_angle"])

    @property
    def efficiencies(self) -> tuple[Any, Any]:
        """The lifting and the lowering efficiency [1] at the middle speed; below zero the latter is self-locking."""
        there = self.at(1, 0.5 * (self.values["speed_low"] + self.values["speed_high"]), 0.0)
        thread = there.parameters["friction_coefficient"], self.lead_angle, self.collar
        return lifting_efficiency(*thread), lowering_efficiency(*thread)


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
    def without_friction(self) -> dict[str, Any]:
        """The parameters of the drive with all of its parts, but for friction of the threads."""
        draw, values = self.draw, self.draw.values
        found = {key: values[key] for key in (*_RIGID, *_DRY) if key in values}
        if "collar_friction" in values:
            found["collar_radius"] = 0.5 * values["collar_diameter"]
        found |= {key: values[key] for part in draw.sheet.parts for key in PARTS[part]}
        if "coupling_damping" in values:
            found["coupling_damping"] = values["coupling_damping"]
        return found | {
            "pitch_radius": draw.pitch_radius,
            "lead_angle": draw.lead_angle,
            "input_speed": self.direction * self.speed,
            "axial_force": -(self.force + draw.weight),
        }

    @cached_property
    def friction(self) -> tuple[Any, Any]:
        """Coefficient μ [1] of the square thread at the speed, not below zero, and its slope μ′ [s/m]."""
        draw, values = self.draw, self.draw.values
        if draw.sheet.friction.law:
            sliding = sliding_speed(self.speed, draw.pitch_radius, draw.lead_angle)
            coefficient, slope = friction.unbounded(SimpleNamespace(**draw.friction_law), sliding)
            positive = coefficient > 0
            return np.where(positive, coefficient, 0.0), np.where(positive, slope, 0.0)
        return draw.square(values["friction_coefficient"]), draw.square(values["friction_slope"])

    @cached_property
    def parameters(self) -> dict[str, Any]:
        """The parameters of the drive with all of its parts; friction is that at the speed."""
        return {**self.without_friction, "friction_coefficient": self.friction[0]}

    @cached_property
    def reserves(self) -> dict[str, Any]:
        """The reserve [1] of each mechanism, see :func:`lsvib.sheets.mechanisms.reserves`."""
        return mechanisms.reserves(self.parameters, self.friction[1], self.draw.sheet.friction.sloped)

    @cached_property
    def drive(self) -> Drive:
        """The drive with the parts of the sheet; with its law of friction, if there is one, else its coefficient here.

        Raises ``InputError`` where it is out of range.
        """
        return self._drive(self.parameters)

    @cached_property
    def rigid(self) -> Drive:
        """The same with rigid parts, and a motor that turns as it is told."""
        return self._drive(mechanisms.without(self.parameters, *PARTS))

    def _drive(self, parameters: Values) -> Drive:
        given = {**parameters, **(self.draw.friction_law if self.draw.sheet.friction.law else {})}
        return Drive(**{key: zero_if_close(key, float(value)) for key, value in given.items()})

    def motion(self, perturbation: float | None = vibration.NUDGE, stiff: bool = False) -> vibration.Vibration:
        """Return the motion from near steady sliding, u = 0, w = ``perturbation`` Ω, or None from rest, to its end.

        ``stiff``: that of the rigid drive. Friction is that at the running speed, to which a slope adds nothing,
        unless the sheet has a law of friction.
        """
        parts = () if stiff else self.draw.sheet.parts
        try:
            drive = self.rigid if stiff else self.drive
            return vibration.vibration(drive, perturbation, parts, self.draw.sheet.friction.law)
        except (InputError, EngineError) as error:
            return vibration.Vibration(parts, "unknown", reason=str(error))

    @cached_property
    def after_knock(self) -> str:
        """What a motion after a strong perturbation ends in, by a key of :data:`lsvib.sheets.words.ATTRACTORS`."""
        parts = self.draw.sheet.parts
        try:
            drive = self.drive if parts else self.rigid
            return plain(vibration.ended(drive, -vibration.STRONG, vibration.work_of_many(parts))[-1].label)
        except (InputError, EngineError):
            return "unknown"

    @cached_property
    def tolerated(self) -> vibration.Tolerated:
        """The sudden change of the screw's speed [rad/s] that the rigid drive tolerates, and a sentence."""
        return vibration.tolerated(self.rigid)
