"""The parameters of a lead-screw drive: names, units, allowed ranges, defaults (Table 8.1).

A drive can be made, printed or refused without loading what makes its equations of motion.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, Any, ParamSpec, Self, TypeVar

from flint import arb
from pydantic import BeforeValidator, Field

from lsvib.drives import friction, pairings
from lsvib.drives.complaints import Checked, Least, allowed_range, bounds_of
from lsvib.errors import InputError
from lsvib.numbers import NotNumber, names_and_values, number, shown, whole
from lsvib.systems.exact.arithmetic import many_digits

P = ParamSpec("P")
T = TypeVar("T")
_forget: list[Callable[[], None]] = []


def once(make: Callable[P, T]) -> Callable[P, T]:
    """Decorate a function of a drive, and of what else can be hashed, so that it computes each result once.

    Drives are values, so that what was made from one serves every equal one, in every layer; of the last 256 drives, as
    a sweep goes through a hundred thousand. Results are shared, so nobody may change them. Arguments must be given in
    one and the same way.
    """
    kept: Any = lru_cache(maxsize=256)(make)
    _forget.append(kept.cache_clear)
    return kept  # type: ignore[no-any-return]


def forget() -> None:
    """Forget all results of :func:`once`, so that the time to make one can be measured."""
    for clear in _forget:
        clear()


# The parameters of each part that a drive may have; the last one, its damper, is zero where only the others are given.
PARTS = {
    "motor": ("motor_inertia", "integral_gain", "speed_gain"),
    "support": ("screw_mass", "support_stiffness", "axial_support_damping"),
    "nut": ("nut_inertia", "nut_stiffness", "nut_damping"),
    "threads": ("contact_stiffness", "contact_damping"),
}
PART_OF = {name: part for part, names in PARTS.items() for name in names}
LOGARITHMIC = PARTS["threads"]  # span many decades, so that axes of them have equal ratios in place of equal steps
IN_WORDS = {
    "motor": "a motor with its controller",
    "support": "a compliant axial support",
    "nut": "a nut that may turn",
    "threads": "compliant threads",
}
# Dry friction against the ground, not in the threads.
DRY = ("slide_friction", "slide_static_friction", "bearing_friction", "bearing_static_friction", "collar_friction")
STATIC = {  # friction at rest of each contact, and the parameters whose sum is that of slow sliding
    "static_friction_coefficient": ("friction_coefficient", "stribeck_rise"),
    "slide_static_friction": ("slide_friction",),
    "bearing_static_friction": ("bearing_friction",),
}
_UNLESS_ZERO = (*friction.NAMES, *DRY, "collar_radius", "coupling_damping")

Number = Annotated[float, BeforeValidator(number)]
Value = Annotated[float, BeforeValidator(lambda value: number(value) + 0.0)]  # -0.0 and 0.0 are one drive
Whole = Annotated[int, BeforeValidator(whole)]


# What is not zero has a size that some drive might have, the smallest of machines among them, so that squares and
# products of such numbers stay within the range of doubles. A silicon cylinder of 1 μm in radius and length has
# 7e-15 kg and 4e-27 kg m2: the least mass, 1e-18 kg, and inertia, 1e-30 kg m2, are less than a thousandth of these. The
# least dampings, of the same numbers, stop the least bodies in a second. The warmth of a room, 4e-21 J, winds the least
# coupling up, 1e-21 N m/rad, by two radians, and moves a body on the least spring, 1e-9 N/m, by 2 μm. The least force,
# 1e-18 N, is a tenth of the weight of the least mass; the least torque is that force at the least radius. The least
# speed, 1e-12 rad/s, is a turn in 200 000 years. The least friction, 1e-18, is far below any that has been
# measured; the least lead angle, 1e-6 rad, makes a pitch of 6 μm on the largest radius.
_LEAST_LEAD = 1e-6  # rad
_RANGES: dict[str, dict[str, Any]] = {  # of inertias, springs and dampers, by their units
    "kg": {"ge": 1e-18, "le": 1e9},
    "N m-1": {"ge": 1e-9, "le": 1e15},
    "N s m-1": {"least": 1e-18, "ge": 0, "le": 1e15},
    "kg m2": {"ge": 1e-30, "le": 1e6},
    "N m rad-1": {"ge": 1e-21, "le": 1e15},
    "N m s rad-1": {"least": 1e-30, "ge": 0, "le": 1e15},
}


def quantity(default: float | None, symbol: str, unit: str, long_name: str, beyond: str = "", **bounds: Any) -> Any:
    """Return the field of a parameter: its default, how it is written, its SI unit, its name, and its range.

    The range, where it is not that of its unit, is given in words of pydantic: ``gt``, ``ge``, ``lt`` and ``le`` for >,
    ≥, < and ≤. ``least`` is the least magnitude of a parameter that may be zero, where it is not; ``beyond`` says in
    words what another parameter allows.
    """
    words, bounds = {"symbol": symbol, "unit": unit, "long_name": long_name}, dict(bounds or _RANGES[unit])
    least = bounds.pop("least", 0.0)
    field = Field(default=default, json_schema_extra={**words, "beyond": beyond}, **bounds)
    if least:
        field.metadata.append(Least(least))
    return field


class Drive(Checked):
    """A lead-screw drive in SI units, immutable and checked; the defaults are those of Table 8.1.

    A motor at the speed Ω turns a screw (I, c) through a coupling (k); its threads (r_m, λ, μ) move a load (m, c_x, R).
    Dry friction may also act on the slide of the load (F_0, static F_s), on the bearing of the screw (T_0, T_s) and, in
    proportion to the axial force, on a thrust collar (μ_b, r_b). The state is u [rad], the deviation of the coupling
    deflection z = θ − Ω t from steady sliding, and its rate w [rad/s]: the screw turns at θ′ = Ω + w. With Ω = 0 the
    motor stands still, and u is the deflection itself.

    These *parts* are present if their parameters are given, and rigid otherwise (:mod:`lsvib.drives.mechanism`):

    * a motor with a PI speed controller, T = K_p (Ω − θ_m′) + K_i ∫ (Ω − θ_m′) dt: ``motor_inertia``,
      ``integral_gain``, ``speed_gain``; the coupling behind it may have ``coupling_damping``;
    * compliant threads (Sect. 5.5): ``contact_stiffness``, ``contact_damping``; Fig. 8.10 has 1e8 and 1e8;
    * a compliant axial support of the screw (Sect. 5.6): ``screw_mass``, ``support_stiffness``,
      ``axial_support_damping``; Fig. 8.15 has a screw of 11.6 kg;
    * a rotating nut (Sect. 5.8): ``nut_inertia``, ``nut_stiffness``, ``nut_damping``.

    A damper that is left out is zero. ``lead_angle_deg`` [degree] may replace ``lead_angle``, and ``friction``, the
    name of a pairing of materials, the coefficient and the law (:mod:`lsvib.drives.pairings`). ``mass``,
    ``translation_damping`` and ``axial_force`` differ from figure to figure of the chapter; their defaults are m = 1 kg
    (Sect. 8.5.1), c_x = 0 and R = 50 N (assumed: the text does not state R for Figs 8.9–8.13). Equal values make equal
    drives; ``repr`` shows what differs from the defaults. Raises ``InputError``, naming key, value and allowed range.

    >>> import lsvib
    >>> lsvib.Drive(mass=11, axial_force=-10).replace(mass=12)
    Drive(mass=12.0, axial_force=-10.0)
    >>> drive = lsvib.Drive(mass=9, contact_stiffness=1e8, contact_damping=5e4)
    >>> drive.parts, drive.rigid, drive.stability().kind
    (('threads',), False, 'flutter')

    See also: docs/physics.md. ``lsvib config`` lists the parameters with their ranges as well::
    """

    pitch_radius: Value = quantity(5.18e-3, "r_m", "m", "pitch radius of the screw", ge=1e-6, le=1.0)
    lead_angle: Value = quantity(
        math.radians(5.57), "lambda", "rad", "lead angle of the screw", ge=_LEAST_LEAD, lt=math.pi / 2
    )
    screw_inertia: Value = quantity(3.12e-6, "I", "kg m2", "moment of inertia of the screw")
    coupling_stiffness: Value = quantity(1.0, "k", "N m rad-1", "torsional stiffness of the coupling")
    support_damping: Value = quantity(2e-4, "c", "N m s rad-1", "rotational damping of the support")
    friction_coefficient: Value = quantity(
        0.218, "mu", "1", "friction coefficient of the threads", " < cot(lead_angle)", least=1e-18, ge=0
    )
    input_speed: Value = quantity(40.0, "Omega", "rad s-1", "input angular speed", least=1e-12, ge=-1e9, le=1e9)
    mass: Value = quantity(1.0, "m", "kg", "translating mass")
    translation_damping: Value = quantity(0.0, "c_x", "N s m-1", "damping of the translating mass")
    axial_force: Value = quantity(50.0, "R", "N", "axial force on the translating mass", least=1e-18, ge=-1e12, le=1e12)
    static_friction_coefficient: Value = quantity(
        0.0, "mu_s", "1", "static friction coefficient of the threads", least=1e-18, ge=0
    )
    stribeck_rise: Value = quantity(0.0, "Delta mu", "1", "rise of friction towards slow sliding", ge=0)
    stribeck_speed: Value = quantity(
        0.0, "v_s", "m s-1", "sliding speed over which the rise fades", least=1e-12, ge=0, le=1e6
    )
    stribeck_exponent: Value = quantity(
        1.0, "delta", "1", "exponent of the fading rise of friction, 1 or 2", ge=1, le=2
    )
    friction_slope: Value = quantity(
        0.0, "mu_v", "s m-1", "slope of friction over the sliding speed", least=1e-18, ge=-1e6, le=1e6
    )
    slide_friction: Value = quantity(0.0, "F_0", "N", "Coulomb friction of the slide", least=1e-18, ge=0, le=1e12)
    slide_static_friction: Value = quantity(0.0, "F_s", "N", "static friction of the slide", least=1e-18, ge=0, le=1e12)
    bearing_friction: Value = quantity(
        0.0, "T_0", "N m", "Coulomb friction of the screw support", least=1e-24, ge=0, le=1e12
    )
    bearing_static_friction: Value = quantity(
        0.0, "T_s", "N m", "static friction of the screw support", least=1e-24, ge=0, le=1e12
    )
    collar_friction: Value = quantity(
        0.0, "mu_b", "1", "friction coefficient of the thrust collar", least=1e-18, ge=0, le=1e3
    )
    collar_radius: Value = quantity(0.0, "r_b", "m", "mean radius of the thrust collar", least=1e-6, ge=0, le=10.0)
    coupling_damping: Value = quantity(0.0, "d", "N m s rad-1", "damping of the coupling behind a motor")
    motor_inertia: Value = quantity(None, "J", "kg m2", "moment of inertia of the motor")
    integral_gain: Value = quantity(None, "K_i", "N m rad-1", "integral gain of the speed controller")
    speed_gain: Value = quantity(None, "K_p", "N m s rad-1", "proportional gain of the speed controller")
    contact_stiffness: Value = quantity(None, "k_c", "N m-1", "stiffness of the thread contact")
    contact_damping: Value = quantity(None, "c_c", "N s m-1", "damping of the thread contact")
    screw_mass: Value = quantity(None, "m_1", "kg", "mass of the screw")
    support_stiffness: Value = quantity(None, "k_1", "N m-1", "axial stiffness of the support")
    axial_support_damping: Value = quantity(None, "c_1", "N s m-1", "axial damping of the support")
    nut_inertia: Value = quantity(None, "I_2", "kg m2", "moment of inertia of the nut")
    nut_stiffness: Value = quantity(None, "k_2", "N m rad-1", "rotational stiffness of the nut")
    nut_damping: Value = quantity(None, "c_2", "N m s rad-1", "rotational damping of the nut")

    if not TYPE_CHECKING:  # a type checker reads the parameters from the fields

        def __init__(self, /, **values: Any) -> None:
            """Make a drive from its parameters; raises ``InputError`` in one sentence."""
            if "lead_angle_deg" in values or "friction" in values:
                values = _resolved(values)
            values = {key: value for key, value in values.items() if value is not None or key not in PART_OF}
            for *needed, damping in PARTS.values():
                if damping not in values and all(name in values for name in needed):
                    values[damping] = 0.0
            super().__init__(**values)

    def __setattr__(self, name: str, value: Any) -> None:
        raise InputError(f"a drive cannot be changed; drive.replace({name}=...) makes another one.")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Drive):
            return NotImplemented
        return self.__dict__ == other.__dict__

    def __hash__(self) -> int:
        return hash(tuple(self.__dict__.values()))

    def __repr_args__(self) -> Iterator[tuple[str, Any]]:
        for key, field in type(self).model_fields.items():
            if getattr(self, key) != field.default:
                yield key, getattr(self, key)

    def __str__(self) -> str:
        return repr(self)

    def __iter__(self) -> Iterator[tuple[str, Any]]:  # type: ignore[override]  # as pydantic's, of what it has
        """Yield names and values of the parameters that the drive has: of its parts, and of friction what it uses."""
        for key, value in self.__dict__.items():
            if value is not None and (key not in _UNLESS_ZERO or value != type(self).model_fields[key].default):
                yield key, value

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the parts that are present, of motor, support, nut and threads."""
        return tuple(part for part, names in PARTS.items() if getattr(self, names[0]) is not None)

    @property
    def rigid(self) -> bool:
        """Whether this is the rigid drive of the chapter (Sect. 5.3): no parts, and friction in the threads only."""
        return not self.parts and not any(getattr(self, name) for name in DRY)

    def model_post_init(self, context: Any) -> None:
        """Check what couples parameters: those of a part, μ < cot λ, and the friction law."""
        for part, names in PARTS.items():
            given = [name for name in names if getattr(self, name) is not None]
            missing = [name for name in names[:-1] if name not in given]
            if given and missing:
                raise InputError(
                    f"{given[0]} is a parameter of {IN_WORDS[part]}, which {'needs' if part != 'threads' else 'need'} "
                    f"{' and '.join(missing)} as well."
                )
        for name in ("slide", "bearing"):
            key, sliding = f"{name}_static_friction", getattr(self, f"{name}_friction")
            static = getattr(self, key)
            if static and static < sliding:
                raise InputError(
                    f"{key} = {static:g} is outside the allowed range 0 or {name}_friction = {sliding:g} "
                    f"<= {key} <= 1e+12."
                )
        if self.collar_friction and not self.collar_radius:
            raise InputError(f"collar_friction = {self.collar_friction:g} needs collar_radius > 0.")
        if self.collar_friction and (comply := [part for part in self.parts if part != "motor"]):
            raise InputError(
                f"collar_friction = {self.collar_friction:g} cannot be combined with {IN_WORDS[comply[0]]}: "
                "the force or the speed at the collar then differs; leave one of them out."
            )
        if self.coupling_damping and self.motor_inertia is None:
            raise InputError(
                f"coupling_damping = {self.coupling_damping:g} needs a motor (motor_inertia, integral_gain); "
                "without one, give support_damping."
            )
        limit = 1 / math.tan(self.lead_angle)
        if not self.friction_coefficient < limit:
            raise InputError(
                f"friction_coefficient = {self.friction_coefficient:g} is outside the allowed range "
                f"{allowed_range(type(self), 'friction_coefficient')} = {limit:.6g}."
            )
        if any(True for key, _ in self if key in friction.NAMES):
            friction.check(self, limit)

    @classmethod
    def of(cls, values: "Drive | Mapping[str, Any] | None" = None, /, **more: Any) -> Self:
        """Make a drive from a drive or from names and values [SI units], with ``more`` values; raises ``InputError``.

        >>> lsvib.Drive.of({"mass": 11, "lead_angle": 0.1}, axial_force=-10)
        Drive(lead_angle=0.1, mass=11.0, axial_force=-10.0)
        """
        if isinstance(values, Drive):
            return cls(**values.model_dump()).replace(**more)
        return cls(**{**names_and_values("drive", values), **more})

    def replace(self, /, **changes: Any) -> Self:
        """Return a copy with some parameters [SI units] changed; raises ``InputError``.

        >>> lsvib.Drive(mass=11).replace(mass=9, friction="steel_on_bronze_lubricated").mass
        9.0
        """
        return type(self)(**{**self.model_dump(), **_resolved(changes)})

    def exact(self) -> "ExactParameters":
        """Return the parameters as balls of 150 digits (``flint.arb``: a midpoint and a radius), and sin λ, tan λ, …"""
        return _exact(self)


class ExactParameters:
    """A drive in balls of 150 digits (``flint.arb``): attributes as in :class:`Drive`, plus functions of them.

    These are those of λ, ``sin_lead``, ``cos_lead`` and ``tan_lead``, and the coefficients ``steady_friction`` in
    steady sliding and ``static_friction`` at rest (:mod:`lsvib.drives.friction`), and ``collar``, μ_b r_b / r_m.

    It is made once and shared: do not change it.
    """

    def __init__(self, drive: Drive) -> None:
        values = {key: arb(value) for key, value in drive.__dict__.items() if value is not None}
        with many_digits():
            angle = values["lead_angle"]
            self.__dict__.update(values, sin_lead=angle.sin(), cos_lead=angle.cos(), tan_lead=angle.tan())
            self.__dict__.update(friction.levels(self))

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> arb: ...


_exact = once(ExactParameters)


def _resolved(values: dict[str, Any]) -> dict[str, Any]:
    """Names and values with what ``lead_angle_deg`` and ``friction`` stand for in their place."""
    values = pairings.in_parameters(values)
    if "lead_angle_deg" not in values:
        return values
    if "lead_angle" in values:
        raise InputError("lead_angle and lead_angle_deg are both given; give one of them.")
    given, allowed = values["lead_angle_deg"], f"{math.degrees(_LEAST_LEAD):g} <= lead_angle_deg < 90"
    try:
        degrees = number(given)
    except NotNumber as error:
        raise InputError(f"lead_angle_deg = {shown(given)} {error}; the allowed range is {allowed}.") from None
    if not _LEAST_LEAD <= math.radians(degrees) < math.pi / 2:
        raise InputError(f"lead_angle_deg = {shown(given)} is outside the allowed range {allowed}.")
    rest = {key: value for key, value in values.items() if key != "lead_angle_deg"}
    return {**rest, "lead_angle": math.radians(degrees)}


def changed(given: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return names and values of a drive with changes.

    A lead angle replaces the given one, whatever its unit, and a friction that is given by name all of the law.
    """
    given, changes = pairings.in_parameters(given), pairings.in_parameters(changes)
    angles = {"lead_angle", "lead_angle_deg"}
    dropped = angles if changes.keys() & angles else set()
    return {**{key: value for key, value in given.items() if key not in dropped}, **changes}


def require_direction(drive: Drive) -> None:
    """Raise ``InputError`` for a drive that is let go, which has no steady sliding."""
    if not drive.input_speed:
        raise InputError(
            "input_speed = 0 holds the motor still, so there is no steady sliding; set a speed, "
            "or compute motions from a start (simulate, sweep, attraction)."
        )


def described(key: str) -> dict[str, str]:
    """Return the ``symbol``, ``unit`` and ``long_name`` of a parameter."""
    extra = Drive.model_fields[key].json_schema_extra
    return {name: str(text) for name, text in extra.items()} if isinstance(extra, dict) else {}


def _parameters() -> Iterator[str]:
    """Yield the lines of a table of all parameters."""
    line = "        {:28}{:10}{:13}{:10}{}".format
    yield line("parameter", "symbol", "unit", "default", "meaning")
    for key, field in Drive.model_fields.items():
        own, default = described(key), "" if field.default is None else f"{field.default:.4g}"
        yield line(key, own["symbol"], own["unit"], default, own["long_name"])


Drive.__doc__ = "\n".join([f"{Drive.__doc__}", *_parameters()])


def may_vanish(key: str) -> bool:
    """Whether a parameter may be zero in steady sliding."""
    return key != "input_speed" and "least" in bounds_of(Drive, key)


def zero_if_close(key: str, value: float) -> float:
    """Return a value that was computed, or zero where it is closer to zero than a parameter that may vanish can be.

    Steps across zero and halvings of an interval towards it come there by rounding.
    """
    return 0.0 if abs(value) < bounds_of(Drive, key).get("least", 0.0) else value
