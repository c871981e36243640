"""The data sheet of a drive: one YAML file in the words and units of an engineer, checked as a whole."""

import math
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationError, model_validator

from lsvib.drives.complaints import sentence_about
from lsvib.drives.pairings import PAIRINGS, stated
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError
from lsvib.numbers import names_and_values, shown, whole_between
from lsvib.sheets import fields
from lsvib.sheets.drive_entries import Bearing, Brake, Coupling, Dampings, Guide, Motor, Part, Running
from lsvib.sheets.fields import NotQuantity, Spread
from lsvib.sheets.threads import NUT_MATERIALS, SCREW_MATERIALS, Size, common_name, pairings
from lsvib.sheets.torque.law import law_of_curve
from lsvib.sheets.words import QUANTITIES

_OF_QUANTITIES = {path for one in QUANTITIES.values() for path in (one.entry, one.entry.split(".")[0])}
_ABOUT = ("sources", "assumptions", "fixed")
_Material = Annotated[str, BeforeValidator(common_name)]
_Ends = Literal["fixed-free", "supported-supported", "fixed-supported", "fixed-fixed"]
_SIMPLE = BeforeValidator(lambda ends: ends.replace("simple", "supported") if isinstance(ends, str) else ends)


class Thread(Part):
    """A thread: a size of the catalogue, or lead (or lead angle, or pitch and starts) and diameter."""

    size: Size | None = None
    lead: fields.Lead | None = None
    lead_angle: fields.LeadAngle | None = None
    pitch: fields.Lead | None = None
    starts: Annotated[int, BeforeValidator(lambda value: whole_between("thread.starts", value, 1, 50))] = 1
    nominal_diameter: fields.Diameter | None = None
    pitch_diameter: fields.Diameter | None = None
    half_angle: fields.HalfAngle | None = None
    _needed = (("size", "lead", "lead_angle", "pitch"),)
    _either = (
        ("size", "lead", "lead_angle", "pitch", "starts", "nominal_diameter", "pitch_diameter", "half_angle"),
        ("lead", "lead_angle"),
        ("nominal_diameter", "pitch_diameter"),
    )

    @property
    def bare(self) -> bool:
        """Whether it has no diameter, which a lead with a measured efficiency does not need for a torque."""
        return all(one is None for one in (self.size, self.nominal_diameter, self.pitch_diameter))

    def _misfit(self) -> str | None:
        lead, pitch, counted = self.lead, self.pitch, "starts" in self.model_fields_set
        # One per cent is more than sizes in inches lose when they are written in millimetres.
        if lead and pitch and counted and abs(lead.nominal / (self.starts * pitch.nominal) - 1) > 0.01:
            return "thread.lead is not thread.starts times thread.pitch; leave one of them out."
        if self.nominal_diameter is not None:
            largest = pitch.high if pitch else lead.high / self.starts if lead and counted else None
            if largest is None:
                return (
                    "thread.nominal_diameter needs thread.pitch, or thread.starts with thread.lead, from which the "
                    "pitch diameter follows; for a ball screw give thread.pitch_diameter."
                )
            if not self.nominal_diameter.low > 0.5 * largest:
                return "thread.nominal_diameter is not above half the pitch, so there is no pitch diameter."
        return None


class Screw(Part):
    """What turns: an inertia, or a cylinder, which vibration needs; its mass is needed with a support only.

    With ``ends`` its column and its critical speed are judged, over ``unsupported_length``, or else ``length``;
    ``modulus`` and ``yield_strength`` go before those of ``material``, and are needed beside ``density``.
    """

    inertia: fields.Inertia | None = None
    length: fields.Length | None = None
    diameter: fields.Diameter | None = None
    material: _Material | None = None
    density: fields.Density | None = None
    modulus: fields.Pressure | None = None
    yield_strength: fields.Pressure | None = None
    mass: fields.Mass | None = None
    ends: Annotated[_Ends | None, _SIMPLE] = None
    unsupported_length: fields.Length | None = None
    root_diameter: fields.Diameter | None = None
    _either = (("inertia", "length"), ("material", "density"))

    def _misfit(self) -> str | None:
        if self.material is not None and self.material not in SCREW_MATERIALS:
            names = ", ".join(SCREW_MATERIALS)
            return f"screw.material = {shown(self.material)} is not one of {names}; or give screw.density."
        if self.length and self.unsupported_length and self.unsupported_length.high > self.length.high:
            return f"screw.unsupported_length = {self.unsupported_length.text} is above screw.length."
        if self.ends is not None and self.density is not None and not (self.modulus and self.yield_strength):
            return "screw.ends needs screw.modulus and screw.yield_strength with screw.density, or screw.material."
        if self.ends is not None and self.length is None and self.unsupported_length is None:
            return "screw.ends needs screw.unsupported_length or screw.length, over which the screw can bend."
        return None


class Nut(Part):
    """The nut: its length, over which the threads are engaged, and what it bears, by ``material`` or by limits.

    With a ``preload`` it has two halves that a spring presses apart, each of that length. ``load_share``: of the load,
    what the half that it presses bears beside the preload; the other one bears the preload less the rest.
    """

    length: fields.Length | None = None
    preload: fields.Rubbing | None = None
    load_share: fields.Share | None = None
    material: _Material | None = None
    pressure_limit: fields.Pressure | None = None
    pv_limit: fields.PressureSpeed | None = None
    speed_limit: fields.SlidingSpeed | None = None

    def _misfit(self) -> str | None:
        if self.load_share is not None and self.preload is None:
            return "nut.load_share needs nut.preload, which presses two halves apart."
        if self.length is None and (self.preload is None or self.model_fields_set - {"preload", "load_share"}):
            return "nut.length is missing, over which the threads are engaged."
        if self.material is not None and self.material not in NUT_MATERIALS:
            names = ", ".join(NUT_MATERIALS)
            return f"nut.material = {shown(self.material)} is not one of {names}; or give nut.pv_limit."
        return None


class Load(Part):
    """What is moved, and what it is pushed with: a positive force opposes outward travel."""

    mass: fields.Mass | None = None
    force: fields.Force | None = None
    orientation: fields.Tilt | None = None

    def _misfit(self) -> str | None:
        if self.mass is None and self.orientation is not None and (self.orientation.low or self.orientation.high):
            return "load.orientation needs load.mass, whose weight acts along the screw."
        if self.mass is None and self.force is None:
            return "load has neither force nor mass; give one of them."
        return None


class Friction(Part):
    """Friction of the threads: a coefficient or a measured efficiency, and a slope over the speed.

    ``pairing``, a name of :data:`lsvib.drives.pairings.PAIRINGS`, stands for the coefficient and law that it states,
    ``curve``, coefficients over the sliding speed, for the law that fits it. With ``stribeck_rise`` or ``static``
    coefficient and slope are parts of a law of the speed (docs/assess.md).
    """

    pairing: str | None = None
    coefficient: fields.Coefficient | None = None
    efficiency: fields.Efficiency | None = None
    curve: tuple[tuple[float, float], ...] | None = None
    slope: fields.Slope | None = None
    stribeck_rise: fields.Coefficient | None = None
    stribeck_speed: fields.SlidingSpeed | None = None
    stribeck_exponent: Literal[1, 2] = 1
    static: fields.Coefficient | None = None
    _needed = (("coefficient", "efficiency", "curve"),)
    _either = (("coefficient", "efficiency"), ("efficiency", "stribeck_rise", "static"))

    @model_validator(mode="before")
    @classmethod
    def _with_law(cls, values: Any) -> Any:
        """Put the law beside the name of a pairing, or the curve, that stands for it."""
        sources = [key for key in ("pairing", "curve") if isinstance(values, Mapping) and values.get(key) is not None]
        if not sources:
            return values
        values, source, name = dict(values), sources[0], values[sources[0]]
        if source == "curve":
            try:
                values[source] = fields.friction_curve(name)
            except NotQuantity as error:
                raise InputError(f"friction.curve {error}.") from None
            law: dict[str, Any] = law_of_curve(*map(np.array, zip(*values[source], strict=True)))
        elif isinstance(name, str) and name in PAIRINGS:
            low, high = PAIRINGS[name].low, PAIRINGS[name].high
            law = {**stated(name), "friction_coefficient": [low, high] if low < high else low}
        else:
            raise InputError(f"friction.pairing = {shown(name)} is not known; lsvib pairings lists all.")
        units = {"stribeck_speed": "m/s", "friction_slope": "s/m"}
        found = {
            key.removeprefix("friction_"): f"{value!r} {units[key]}" if key in units else value
            for key, value in law.items()
        }
        for key in (*found, "efficiency", *sources[1:]):
            if values.get(key) is not None:
                raise InputError(f"friction.{source} and friction.{key} are both given; give one of them.")
        return {**values, **found}

    @property
    def law(self) -> bool:
        """Whether it is a law of the sliding speed, which motions follow too."""
        return self.stribeck_rise is not None or self.static is not None

    @property
    def sloped(self) -> bool:
        """Whether it changes with the speed about which it slides."""
        return any(one is not None for one in (self.slope, self.stribeck_rise))

    def _misfit(self) -> str | None:
        if self.stribeck_rise is not None and self.stribeck_speed is None:
            return "friction.stribeck_rise needs friction.stribeck_speed, the sliding speed over which it fades."
        if self.stribeck_rise is None and self.model_fields_set & {"stribeck_speed", "stribeck_exponent"}:
            return "friction.stribeck_speed and friction.stribeck_exponent need friction.stribeck_rise."
        if self.static is not None:
            slowest = sum(one.high for one in (self.coefficient, self.stribeck_rise) if one is not None)
            if not self.static.low > slowest:
                return (
                    f"friction.static, at least {self.static.low:g}, is not above the friction of slow sliding, "
                    f"coefficient + stribeck_rise, at most {slowest:g}."
                )
        return None


class Spring(Part):
    """A spring with a damper, of the thread contact or of the axial support."""

    stiffness: fields.Stiffness
    damping: fields.LinearDamping | None = None


NO_DIAMETER = "thread has none of size, nominal_diameter, pitch_diameter; give one of them"
_OF_SPEED = "friction.curve friction.stribeck_rise damping.rotational damping.translational bearing.viscous"


class Sheet(Part):
    """A whole data sheet. ``sources`` and ``assumptions`` say of an entry, such as load.mass, where it comes from.

    ``fixed``: parts and entries that no advice changes; one from which several quantities follow fixes its whole part.
    Without one of the mass that is moved, the screw's inertia, the coupling's stiffness, a speed and a diameter it is
    one of statics.
    """

    name: str = Field("drive", min_length=1, max_length=200)
    thread: Thread
    screw: Screw = Screw()
    coupling: Coupling = Coupling()
    motor: Motor | None = None
    load: Load
    operation: Running = Running()
    friction: Friction
    damping: Dampings = Dampings()
    bearing: Bearing = Bearing()
    guide: Guide | None = None
    brake: Brake | None = None
    nut: Nut | None = None
    contact: Spring | None = None
    support: Spring | None = None
    sources: dict[str, str] = Field(default_factory=dict)
    assumptions: dict[str, str] = Field(default_factory=dict)
    fixed: tuple[str, ...] = ()

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Make a sheet from names and values; raises ``InputError`` in one sentence."""
        values = names_and_values("sheet", values)
        if values.get("contact") == "rigid":
            del values["contact"]
        try:
            sheet = cls.model_validate(values)
        except ValidationError as error:
            own = [one.get("material") if isinstance(one := values.get(p), Mapping) else None for p in ("nut", "screw")]
            sentence, names = sentence_about(cls, error), pairings(*own)
            if sentence == "friction is missing.":
                more = f"; for these materials friction.pairing may be {' or '.join(names)}" if names else ""
                sentence = f"friction is missing; give its pairing, coefficient, curve or efficiency{more}."
            raise InputError(sentence) from None
        for _, part in sheet:
            if isinstance(part, Part) and (problem := part.problem()) is not None:
                raise InputError(problem)
        root, size = sheet.screw.root_diameter, sheet.thread.size
        rubs = sheet.friction.coefficient is not None and (sheet.friction.coefficient.high > 0 or sheet.friction.law)
        if sheet.thread.bare and (rubs or sheet.thread.lead_angle is not None):
            raise InputError(f"{NO_DIAMETER}, or friction.efficiency with the lead.")
        if sheet.thread.bare and sheet.screw.length is not None and sheet.screw.diameter is None:
            raise InputError("screw.length needs screw.diameter where the thread has no diameter.")
        if not sheet.runs and (fast := next(filter(sheet.paths().__contains__, _OF_SPEED.split()), None)):
            raise InputError(f"{fast} needs operation.speed, because its effect depends on speed.")
        if sheet.screw.ends is not None and root is None and size is None:
            raise InputError("screw.ends needs screw.root_diameter, or thread.size from which it follows.")
        outer = sheet.thread.pitch_diameter or sheet.thread.nominal_diameter
        if root is not None and root.high >= (size.pitch_diameter if size else outer.low if outer else math.inf):
            raise InputError(f"screw.root_diameter = {root.text} is not below the diameter of the thread.")
        if sheet.support is not None and sheet.screw.mass is None and sheet.screw.length is None:
            raise InputError("support needs screw.mass, or screw.length from which it follows.")
        if sheet.coupling.damping is not None and "motor" not in sheet.parts:
            raise InputError("coupling.damping needs a motor with inertia and control; else give damping.rotational.")
        if sheet.guide is not None and sheet.guide.coefficient is not None and sheet.load.mass is None:
            raise InputError("guide.coefficient needs load.mass, whose weight presses on the guide.")
        if sheet.bearing.collar is not None and (sheet.contact or sheet.support):
            raise InputError(
                "bearing.collar cannot be assessed with a compliant support or contact, which changes the force on "
                "the collar; leave one of them out."
            )
        for table in ("sources", "assumptions"):
            for path in getattr(sheet, table):
                if path not in sheet.paths():
                    raise InputError(f"{table} names {shown(path)}, which is not in the sheet.")
        if unknown := set(sheet.fixed) - sheet.paths() - _OF_QUANTITIES:
            raise InputError(f"fixed names {shown(min(unknown))}, which is not an entry of the sheet.")
        return sheet

    def is_fixed(self, entry: str) -> bool:
        """Whether the sheet says that an entry, one of a quantity, cannot change."""
        paths = (path if path in _OF_QUANTITIES else path.split(".")[0] for path in self.fixed)
        return any(f"{entry}.".startswith(f"{path}.") for path in paths)

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a sheet from a YAML file, whose name it has unless it says another; raises ``InputError``."""
        return cls.of({"name": Path(path).stem, **read_yaml(path)})

    def assumption(self, path: str) -> str | None:
        """Return by which name a given entry is a guess: its own or, without a source of its own, that of its part."""
        names = [path] if path in self.sources else [path, path.split(".")[0]]
        return next((name for name in names if name in self.assumptions and path in self.paths()), None)

    def with_entries(self, entries: Mapping[str, Any]) -> Self:
        """Return the sheet with other entries, such as coupling.stiffness; a new thread or friction is all new."""
        parts: dict[str, Any] = {key: getattr(self, key) for key in self.model_fields_set if key not in _ABOUT}
        for name in {path.split(".")[0] for path in entries}:
            own = {path.split(".")[1]: one for path, one in entries.items() if path.split(".")[0] == name}
            old, new = getattr(self, name), own.keys() & {"size", "coefficient", "pairing"}
            kept = set() if new else old.model_fields_set - {"pairing", "curve"}  # for which a law stands
            parts[name] = {key: getattr(old, key) for key in kept} | own
        return self.of(parts)

    def paths(self) -> set[str]:
        """Return the names of the entries that are given, and of the parts."""
        found = {path for path, _ in self.entries()}
        return found | {".".join(path.split(".")[:k]) for path in found for k in (1, 2)}

    @property
    def of_statics(self) -> str:
        """Why vibration is not asked of the sheet; empty where it is."""
        given = {
            "the inertia or length of the screw": self.screw.inertia or self.screw.length,
            "coupling.stiffness": self.coupling.stiffness,
            "load.mass": self.load.mass,
            "operation.speed": self.operation.speed or self.operation.move,
            "a diameter of the thread": None if self.thread.bare else self.thread,
        }
        missing = [name for name, value in given.items() if value is None]
        if missing:
            listed = " and ".join([", ".join(missing[:-1]), missing[-1]] if missing[1:] else missing)
            return f"the sheet does not give {listed}"
        return "the motion of a preloaded nut, both halves of which rub, cannot be computed" if self.preloaded else ""

    @property
    def runs(self) -> bool:
        """Whether it says how fast the drive runs."""
        return self.operation.speed is not None or self.operation.move is not None

    @property
    def preloaded(self) -> bool:
        """Whether the nut has two halves that are pressed apart."""
        return self.nut is not None and self.nut.preload is not None and self.nut.preload.high > 0

    @property
    def pairings(self) -> dict[str, list[float]]:
        """Friction by name for the materials of nut and screw, where the sheet names none, with its range."""
        return pairings(self.nut and self.nut.material, self.screw.material) if self.friction.pairing is None else {}

    @property
    def dry(self) -> bool:
        """Whether bearing, collar or guide rub."""
        return self.guide is not None or self.bearing.torque is not None or self.bearing.collar is not None

    @property
    def followed(self) -> bool:
        """Whether motions from rest are followed: friction is a law of the speed, or somewhere larger at rest."""
        return self.friction.law or bool(self.spreads.keys() & {"bearing.static", "guide.static"})

    @property
    def closed(self) -> bool:
        """Whether the basin is known: parts are rigid, and only the threads rub, with a coefficient at each point."""
        return self.stiff and not self.friction.law and not self.dry

    @property
    def parts(self) -> tuple[str, ...]:
        """The parts that comply in its motions."""
        there = {"motor": self.motor and self.motor.complies, "support": self.support, "threads": self.contact}
        return tuple(part for part, given in there.items() if given)

    @property
    def stiff(self) -> bool:
        """Whether all parts are rigid, and the motor turns as it is told."""
        return not self.parts

    @cached_property
    def spreads(self) -> dict[str, Spread]:
        """The quantities that are given, by name."""
        return {path: value for path, value in self.entries() if isinstance(value, Spread)}

    def is_window(self, path: str) -> bool:
        """Whether an entry is a side of the operating window: a range of force or speed, all of which is used."""
        entry = self.spreads.get(path)
        return path in ("load.force", "operation.speed") and entry is not None and entry.kind == "uniform"

    @property
    def random(self) -> list[str]:
        """The entries that are uncertain: all but ranges of force and speed, which are the operating window."""
        return [path for path, entry in self.spreads.items() if entry.uncertain and not self.is_window(path)]

    @property
    def directions(self) -> tuple[int, ...]:
        """The directions of travel, 1 outward and −1 back."""
        return {"out": (1,), "back": (-1,), "both": (1, -1)}[self.operation.direction]
