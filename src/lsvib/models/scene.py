"""A scene: which model and which physics, from which state, for how long, and what is wanted of it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, Self

import yaml
from pydantic import BaseModel, ConfigDict, Field, field_validator

from lsvib.errors import InputError
from lsvib.models.parameters import LeadScrew, Number, validated

Term = Literal["support_damping", "translation_damping", "axial_force", "rest"]
Output = Literal["normal_force", "coupling_torque", "coupling_deflection", "screw_speed"]
_TERMS = ("support_damping", "translation_damping", "axial_force")


class Scene(BaseModel):
    """One simulation, immutable and checked.

    ``drive``: the parameters. ``physics``: the terms that the scene has – a damping or force that is listed nowhere
    must be zero in the drive, and without ``rest`` the motion is taken never to reach θ′ = 0, so reversal, rest and
    seizure are left out; by default the non-zero terms and rest. ``resume``: how motion goes on after a seizure, see
    :mod:`lsvib.models.rigid`. ``initial``: u [rad] and w [rad/s]. ``t_end`` [s]. ``samples``: number of equidistant
    output times, both ends included. ``outputs``: observables to store besides the state, the mode and the events.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    model: Literal["rigid"] = "rigid"
    drive: LeadScrew = Field(default_factory=LeadScrew)
    physics: tuple[Term, ...] | None = None
    resume: Literal["contact_sign", "at_once"] = "contact_sign"
    initial: dict[str, Number]
    t_end: Number = Field(gt=0, le=1e9)
    samples: int = Field(default=1001, ge=2, le=100_000_000)
    outputs: tuple[Output, ...] = ("normal_force", "coupling_torque")

    @field_validator("drive", mode="before")
    @classmethod
    def _drive(cls, value: Any) -> Any:
        return LeadScrew.of(value) if isinstance(value, Mapping) else value

    def model_post_init(self, context: Any) -> None:
        """Check what couples two keys: a complete initial state, no term in the drive that the physics leaves out."""
        if set(self.initial) != {"u", "w"}:
            raise InputError(
                f"initial has the keys {', '.join(self.initial) or 'none'}; it needs u [rad] and w [rad/s]."
            )
        for term in _TERMS:
            value = getattr(self.drive, term)
            if self.physics is not None and term not in self.physics and value != 0:
                raise InputError(f"{term} = {value:g} although physics does not list {term}; set it to 0 or list it.")

    @property
    def terms(self) -> tuple[str, ...]:
        """The physics of the scene, spelled out."""
        if self.physics is not None:
            return self.physics
        return (*(term for term in _TERMS if getattr(self.drive, term) != 0), "rest")

    def parameters(self) -> dict[str, float]:
        """Return the parameters that the scene uses: the drive's without the terms that the physics leaves out."""
        return {key: value for key, value in self.drive if key not in _TERMS or key in self.terms}

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Make a scene from names and values; raises ``InputError`` in one sentence."""
        return validated(cls, values)


def read_yaml(path: str | Path) -> dict[str, Any]:
    """Read a YAML file that holds names and values; raises ``InputError`` if it is missing or something else."""
    try:
        values = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"Cannot read {path}: {error.strerror}.") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(f"{path} is not valid YAML: {' '.join(str(error).split())}.") from None
    if not isinstance(values, dict):
        raise InputError(f"{path} does not hold names and values.")
    return values
