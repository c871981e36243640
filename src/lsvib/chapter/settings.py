"""The types that the settings of figures share: drives, states, spans of values, lists; SI units throughout.

A figure states its settings as a class ``Settings`` in its file, with a unit and a range for each of them. Ranges of
parameters are those of :mod:`lsvib.drives.drive`.
"""

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

from annotated_types import Ge, Gt, Le, Lt
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, create_model, model_validator
from pydantic_core import PydanticCustomError

from lsvib.drives.complaints import Least, bounds_of
from lsvib.drives.drive import Drive, described

_BOUNDS = (Ge, Gt, Le, Lt, Least)
Values = Mapping[str, Any]  # names and values, such as the settings of a figure once they are checked


class SettingsSection(BaseModel):
    """Names and values, immutable and checked: no other name, no text for a number, nothing infinite."""

    model_config = ConfigDict(frozen=True, strict=True, extra="forbid", allow_inf_nan=False)


class FigureSettings(SettingsSection):
    """The settings of one figure, and what it needs besides what it imports.

    ``unused``: parameters of its drive on which the figure does not depend, because it varies them itself or because
    they drop out of what it shows. ``engine``: the parts of the compiled engine that its dataset runs: ``planar`` for
    rigid drives, ``modal`` for parts that comply, ``taylor`` for friction that depends on speed. ``tables``: files that
    it reads.
    """

    unused: ClassVar[tuple[str, ...]] = ()
    engine: ClassVar[tuple[str, ...]] = ("planar",)
    tables: ClassVar[tuple[Path, ...]] = ()


class Span(SettingsSection):
    """Evenly spaced values from start to stop, both included."""

    start: float
    stop: float
    count: int = Field(ge=2, le=100_000)

    @model_validator(mode="after")
    def _start_is_below_stop(self) -> Self:
        if not self.start < self.stop:
            words = "has start = {start} and stop = {stop}; it needs start < stop"
            raise PydanticCustomError("of_the_whole", words, {"start": f"{self.start:g}", "stop": f"{self.stop:g}"})
        return self


class PositiveSpan(Span):
    """Evenly spaced positive values from start to stop, both included."""

    start: float = Field(gt=0)
    stop: float = Field(gt=0)


class Cells(Span):
    """Cells of equal width between start and stop."""

    count: int = Field(ge=1, le=1_000_000)


class State(SettingsSection):
    """State of the drive: deviation u [rad] and its rate w [rad/s]."""

    u: float = Field(ge=-1e6, le=1e6)
    w: float = Field(ge=-1e9, le=1e9)


def refusing(wrong: Callable[[Any], bool], words: str) -> AfterValidator:
    """Return what refuses some values of a type, in words that follow the value; to be added to the type."""

    def check(value: Any) -> Any:
        if wrong(value):
            raise PydanticCustomError("of_the_value", words)
        return value

    return AfterValidator(check)


Unique = (refusing(lambda values: any(x in values[:k] for k, x in enumerate(values)), "holds an entry twice"),)


def several(least: int, most: int | None, description: str) -> Any:
    """Return the field of a list of so many entries, none of them twice."""
    field = Field(min_length=least, max_length=most, description=description)
    field.metadata.extend(Unique)
    return field


def parameter(key: str, *more: Any) -> Any:
    """Return the field of a parameter of a drive, with its range, and with ``more`` bounds."""
    words = described(key)
    field = Field(description=f"{words['symbol']} [{words['unit']}]: {words['long_name']}.")
    field.metadata.extend((*(one for one in Drive.model_fields[key].metadata if isinstance(one, _BOUNDS)), *more))
    return field


_LOW, _HIGH = (math.degrees(bound) for bound in bounds_of(Drive, "lead_angle").values())
_DEGREES = Annotated[float, Ge(_LOW), Lt(_HIGH), Field(description="lambda [degree].")]
_TYPES = {**{key: Annotated[float, parameter(key)] for key in Drive.model_fields}, "lead_angle_deg": _DEGREES}
_NAMED: dict[str, Any] = {key: (kind, None) for key, kind in _TYPES.items()}  # what is not named is as in Table 8.1
_WORDS = "Changes of the drive of Table 8.1; lsvib checks what couples them."
DriveChanges: Any = create_model("DriveChanges", __base__=SettingsSection, __doc__=_WORDS, **_NAMED)
Stiffness = Annotated[float, parameter("contact_stiffness")]
ContactDamping = Annotated[float, parameter("contact_damping")]


class Contact(SettingsSection):
    """A contact of compliant threads."""

    contact_stiffness: Stiffness
    contact_damping: ContactDamping


class ContactStart(SettingsSection):
    """A contact force and its rate, in the scale of the chapter [1/(kg m2)]."""

    force: float = Field(ge=-1e12, le=1e12)
    rate: float = Field(ge=-1e12, le=1e12)


_Zero = Annotated[float, refusing(lambda value: value != 0, "is not acceptable; it must be 0")]
Duration = Annotated[float, Field(gt=0, le=10, description="Time for which motions are drawn [s].")]
Samples = Annotated[int, Field(ge=100, le=100_000, description="Samples of each motion, events included.")]
Damping = Annotated[float, Field(ge=0, le=1, description="Support damping c [N m s/rad].")]
MassPair = Annotated[list[Annotated[float, parameter("mass")]], several(2, 2, "Two readings of the mass [kg].")]
OpposingForces = Annotated[list[Annotated[float, parameter("axial_force", Lt(0))]], several(2, 2, "Forces R < 0 [N].")]


class DriveFigure(FigureSettings):
    """Settings of a figure about one drive, that of Table 8.1 with changes."""

    drive: DriveChanges


class PhasePlane(DriveFigure):
    """Settings of the motions that a figure draws in the phase plane; Figs 8.4 and 8.5 need no others."""

    starts: list[State] = Field(min_length=1, max_length=4, description="States from which motions are drawn.")
    duration: Duration
    samples: Samples


class ContactPortrait(DriveFigure):
    """Settings of a phase portrait of the contact force, Figs 8.1 and 8.2."""

    unused: ClassVar = ("coupling_stiffness", "support_damping", "input_speed", "translation_damping", "axial_force")

    contact_stiffness: Stiffness
    contact_dampings: tuple[_Zero, Annotated[float, parameter("contact_damping", Gt(0))]] = Field(
        strict=False, description="Contact damping of both panels, zero first [N s/m]."
    )
    force: Span = Field(description="Contact force in the scale of the chapter [1/(kg m2)].")
    rate: Span = Field(description="Its rate, in the same scale [1/(kg m2)].")
    starts: list[ContactStart] = Field(
        min_length=1, max_length=12, description="Contact forces and rates that motions start from."
    )
    samples: Samples
