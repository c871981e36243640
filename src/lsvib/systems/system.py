"""A system of one's own: linear between events, in words and numbers, as a value."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple, Self

import numpy as np

from lsvib.errors import InputError
from lsvib.numbers import names_and_values, shown
from lsvib.systems.assembly import made
from lsvib.systems.expressions import LARGEST, check_name

KEYS = ("states", "parameters", "harmonics", "clocks", "modes", "events", "surfaces")


class Event(NamedTuple):
    """What happens in some modes ``when`` a condition comes true, or ``at_clock``, as that returns.

    ``reset``: new values of states; ``to``: the mode that is entered, None to stay; ``beyond``: the mode that follows
    infinitely many events in finite time.
    """

    mode: tuple[str, ...]
    when: str | None = None
    at_clock: str | None = None
    reset: Mapping[str, Any] | None = None
    to: str | None = None
    beyond: str | None = None


class SurfaceBetween(NamedTuple):
    """A surface ``at`` which an affine function is zero, ``between`` the mode where it is negative and the other."""

    between: tuple[str, str]
    at: str


class System:
    """A system that is linear between events; immutable, checked as it is made.

    ``states``: names; ``parameters``: numbers, or expressions of other parameters; ``harmonics``: by ``"c, s"`` the
    rate ω [rad/s] of c = cos ω t and s = sin ω t; ``clocks``: by name the period [s] after which a time returns to
    zero; ``modes``: by name the derivatives of all states, affine in states, harmonics and clocks, or ``matrix`` and
    ``vector``; ``events``: mappings with ``mode`` (one or several), ``when`` or ``at_clock``, and ``reset``, ``to``,
    ``beyond``; ``surfaces``: mappings with ``between``, two modes, and ``at``, which is negative in the first one.
    A number in a text is the decimal that it is, a float the double that it is. Modes that slide along surfaces have
    the names of those that meet there, as in ``"slower|faster"``.
    """

    states: tuple[str, ...]
    parameters: dict[str, Any]
    harmonics: dict[tuple[str, str], Any]
    clocks: dict[str, Any]
    modes: dict[str, dict[str, Any]]
    events: tuple[Event, ...]
    surfaces: tuple[SurfaceBetween, ...]

    def __init__(
        self,
        states: Iterable[str],
        modes: Mapping[str, Mapping[str, Any]],
        parameters: Mapping[str, Any] | None = None,
        harmonics: Mapping[str, Any] | None = None,
        clocks: Mapping[str, Any] | None = None,
        events: Iterable[Mapping[str, Any]] = (),
        surfaces: Iterable[Mapping[str, Any]] = (),
    ) -> None:
        """Make a system from its keys; raises ``InputError`` in one sentence."""
        put = self.__dict__
        put["states"] = tuple(_listed("states", states))
        for key, given in (("parameters", parameters), ("harmonics", harmonics), ("clocks", clocks)):
            put[key] = {name: _value(x) for name, x in names_and_values(key, given).items()}
        put["harmonics"] = {_pair(key): x for key, x in put["harmonics"].items()}
        self._check_names()
        if not self.states or not modes:
            raise InputError("a system needs one state and one mode at least.")
        put["modes"] = {name: self._mode(name, own) for name, own in names_and_values("modes", modes).items()}
        put["events"] = tuple(self._event(f"events[{k}]", own) for k, own in enumerate(_listed("events", events)))
        planes = enumerate(_listed("surfaces", surfaces))
        put["surfaces"] = tuple(self._surface(f"surfaces[{k}]", own) for k, own in planes)
        put["_text"] = f"System({', '.join(f'{key}={value!r}' for key, value in self.keys().items())})"
        made(self)

    @classmethod
    def of(cls, values: Mapping[str, Any], /) -> Self:
        """Make a system from its keys, as a file holds them; raises ``InputError`` in one sentence."""
        return cls(**_known("system", values, KEYS, ("states", "modes")))

    def keys(self) -> dict[str, Any]:
        """Return the keys that make it, as a file holds them."""
        events = [{key: x for key, x in event._asdict().items() if x} for event in self.events]
        keys: dict[str, Any] = {key: getattr(self, key) for key in KEYS}
        keys["harmonics"] = {", ".join(pair): x for pair, x in self.harmonics.items()}
        keys["events"], keys["surfaces"] = events, [one._asdict() for one in self.surfaces]
        return {key: _plain(value) for key, value in keys.items() if value}

    def replace(self, /, **changes: Any) -> Self:
        """Return a copy with some parameters changed, or whole keys such as ``events``, checked again."""
        keys = self.keys()
        for name, value in changes.items():
            if name not in self.parameters and name not in KEYS:
                known = ", ".join(self.parameters) or "none"
                raise InputError(f"{name} is no parameter of the system; its parameters are {known}.")
            (keys["parameters"] if name in self.parameters else keys)[name] = value
        return type(self)(**keys)

    def __setattr__(self, name: str, value: Any) -> None:
        raise InputError(f"a system does not change; system.replace({name}=...) makes another one.")

    def __eq__(self, other: object) -> bool:
        return repr(self) == repr(other) if isinstance(other, System) else NotImplemented

    def __hash__(self) -> int:
        return hash(repr(self))

    def __repr__(self) -> str:
        return str(self.__dict__["_text"])

    def _check_names(self) -> None:
        seen: dict[str, str] = {}
        pairs = [name for pair in self.harmonics for name in pair]
        for what, names in zip(KEYS, (self.states, self.parameters, pairs, self.clocks), strict=False):
            for name in names:
                if check_name(name) in seen:
                    raise InputError(f"{name} stands twice, in {seen[name]} and in {what}; take two names.")
                seen[name] = what

    def _mode(self, mode: str, given: Any) -> dict[str, Any]:
        about, n = f"modes.{mode}", len(self.states)
        if not mode.strip() or "|" in mode:
            raise InputError(f"{shown(mode)} cannot be the name of a mode; | stands between modes that slide.")
        if not (isinstance(given, Mapping) and "matrix" in given):
            own = _known(about, given, self.states, self.states)
            return {name: _value(own[name]) for name in self.states}
        own = _known(about, given, ("matrix", "vector"), ("matrix",))
        matrix = [_listed(f"{about}.matrix", row) for row in _listed(f"{about}.matrix", own["matrix"])]
        vector = _listed(f"{about}.vector", own.get("vector", [0] * n))
        if [len(row) for row in matrix] != [n] * n or len(vector) != n:
            raise InputError(f"{about} needs a matrix of {n} by {n} numbers and a vector of {n}, one a state.")
        return {"matrix": [[*map(_value, row)] for row in matrix], "vector": [*map(_value, vector)]}

    def _event(self, about: str, given: Any) -> Event:
        own = _known(about, given, Event._fields, ("mode",))
        modes = (own["mode"],) if isinstance(own["mode"], str) else tuple(_listed(f"{about}.mode", own["mode"]))
        for name in (*(modes or [None]), *(own[key] for key in ("to", "beyond") if own.get(key) is not None)):
            if not isinstance(name, str) or not {*name.split("|")} <= {*self.modes}:
                raise InputError(f"{about} names the mode {shown(name)}; modes are {', '.join(self.modes)}.")
        if ("when" in own) == ("at_clock" in own):
            raise InputError(f"{about} needs when, such as x > 1, or at_clock, the name of a clock, and not both.")
        if own.get("at_clock") not in [None, *self.clocks]:
            known = ", ".join(self.clocks) or "none"
            raise InputError(f"{about}.at_clock = {own['at_clock']} is no clock; clocks are {known}.")
        reset = _known(f"{about}.reset", own.get("reset"), (*self.states, *self.clocks))
        return Event(**own | {"mode": modes, "reset": {name: _value(x) for name, x in reset.items()}})

    def _surface(self, about: str, given: Any) -> SurfaceBetween:
        own = _known(about, given, SurfaceBetween._fields, SurfaceBetween._fields)
        between = _listed(f"{about}.between", own["between"])
        if len(between) != 2 or between[0] == between[1] or any(name not in [*self.modes] for name in between):
            raise InputError(f"{about}.between = {shown(own['between'])} is not two modes of {', '.join(self.modes)}.")
        return SurfaceBetween((between[0], between[1]), own["at"])


def _listed(about: str, given: Any) -> list[Any]:
    given = given.tolist() if isinstance(given, np.ndarray) else given
    if isinstance(given, (str, Mapping)) or not isinstance(given, Iterable):
        raise InputError(f"{about} = {shown(given)} is not a list.")
    return [*given]


def _known(about: str, given: Any, allowed: Iterable[str], needed: Iterable[str] = ()) -> dict[str, Any]:
    """Return names and values, all of which are allowed, and none of those that are needed missing."""
    own = names_and_values(about, given)
    if wrong := [key for key in own if key not in allowed]:
        raise InputError(f"{wrong[0]} is not a known key of {about}; those are {', '.join(allowed)}.")
    if missing := [key for key in needed if key not in own]:
        raise InputError(f"{about} needs {missing[0]}.")
    return own


def _value(given: Any) -> Any:
    """Return a number or an expression as a plain value; 24 and 24.0 are one, and so are 0.0 and -0.0."""
    if isinstance(given, str):
        return given
    given = given.item() if isinstance(given, np.number) else given
    if isinstance(given, bool) or not isinstance(given, (int, float)) or not abs(given) < LARGEST:
        raise InputError(f"{shown(given)} is neither an expression nor a number below {LARGEST:g}.")
    return float(given) + 0.0


def _pair(key: str) -> tuple[str, str]:
    names = [name.strip() for name in key.split(",")]
    if len(names) != 2:
        raise InputError(f"harmonics has {shown(key)}, which is not two names, such as 'c, s'.")
    return names[0], names[1]


def _plain(value: Any) -> Any:
    """Return lists and dictionaries in place of tuples and mappings, all the way down."""
    if isinstance(value, Mapping):
        return {key: _plain(x) for key, x in value.items()}
    return [*map(_plain, value)] if isinstance(value, (tuple, list)) else value
