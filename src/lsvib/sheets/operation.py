"""A point of operation of a drive of a data sheet: parameters there, reserves, motions."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from lsvib.drives.drive import DRY, PARTS, Drive, zero_if_close
from lsvib.errors import EngineError, InputError
from lsvib.sheets import vibration
from lsvib.sheets.draw import Draw
from lsvib.sheets.formulas import Values
from lsvib.sheets.reserves import reserves, without

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

    def motion(self, perturbation: float | None = vibration.NUDGE, stiff: bool = False) -> vibration.Vibration:
        """Return the motion from near steady sliding, u = 0, w = ``perturbation`` Ω, or None from rest, to its end.

        ``stiff``: that of the rigid drive. Friction is that at the running speed, to which a slope adds nothing,
        unless the sheet has a law of friction.
        """
        try:
            return vibration.vibration(self.rigid if stiff else self.drive, perturbation)
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
