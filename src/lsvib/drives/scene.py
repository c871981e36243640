"""A scene: which drive and which physics, from which state, under which command, for how long, and what is wanted.

A commanded speed changes with time, straight between given points: ramps, stays, and jumps. In each piece Ω(t) = Ω_0 +
α t by a clock that begins anew, so that the equations are those of a constant command with time as one more state
(:mod:`lsvib.drives.mechanism`). The pieces of one automaton follow each other: a mode has a copy in each of them, and
the end of a piece is an event like any other.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
import yaml
from pydantic import BeforeValidator, Field, SerializeAsAny, model_validator

from lsvib.drives.complaints import Checked
from lsvib.drives.drive import Drive, Number, Whole
from lsvib.drives.model import Model, model_of
from lsvib.drives.names import Event, Resume
from lsvib.errors import InputError
from lsvib.numbers import names_and_values
from lsvib.systems.automaton import Branch, Guard, Surface, Transition

Values = Annotated[  # a thousand take ten seconds
    tuple[Number, ...],
    BeforeValidator(lambda given: given.tolist() if isinstance(given, np.ndarray) else given),
    Field(min_length=2, max_length=1000),
]


class Command(Checked):
    """The commanded speed of the motor, ``speeds`` [rad/s] at ``times`` [s] and linear between them.

    It is constant before the first and after the last time, and jumps where a time is given twice.

    >>> Command(times=[0, 0.2, 1, 1.5], speeds=[0, 40, 40, 0]).at([0.1, 2.0])
    array([20.,  0.])
    """

    _about = "command: "

    times: Values
    speeds: Values

    def model_post_init(self, context: Any) -> None:
        """Check what couples times and speeds."""
        times = np.array(self.times)
        if len(self.speeds) != times.size:
            raise InputError(f"command has {times.size} times but {len(self.speeds)} speeds; give one for each.")
        if times[0] < 0 or times[-1] > 1e9 or (np.diff(times) < 0).any() or (times[2:] == times[:-2]).any():
            raise InputError("command.times must ascend within 0 <= time <= 1e9 s, with no time more than twice.")
        if np.abs(self.speeds).max() > 1e9:
            raise InputError("command.speeds has a speed outside the allowed range -1e9 <= speed <= 1e9 rad/s.")

    def pieces(self) -> Iterator[tuple[float, float, float]]:
        """Yield duration [s], initial speed [rad/s] and its rate [rad/s²] of each piece; the last one is endless."""
        if self.times[0] > 0:
            yield self.times[0], self.speeds[0], 0.0
        for k, duration in enumerate(np.diff(self.times).tolist()):
            if duration > 0:
                yield duration, self.speeds[k], (self.speeds[k + 1] - self.speeds[k]) / duration
        yield np.inf, self.speeds[-1], 0.0

    def angle(self, times: Any) -> np.ndarray:
        """Return the commanded angle [rad] at times [s], from zero at t = 0."""
        begun, found = 0.0, np.zeros(np.shape(times))
        for duration, speed, rate in self.pieces():
            stay = np.clip(times - begun, 0.0, duration)
            found, begun = found + stay * (speed + 0.5 * rate * stay), begun + duration
        return found

    def at(self, times: Any) -> np.ndarray:
        """Return the commanded speed [rad/s] at times [s]; at a jump, that after it."""
        return np.asarray(np.interp(times, self.times, self.speeds))  # which takes the last of two equal times


def one_after_the_other(pieces: Sequence[tuple[Mapping[str, Any], float]]) -> dict[str, Any]:
    """Join what automata are made of (:func:`lsvib.systems.automaton.assemble`), each for a duration [s]."""
    n = len(pieces[0][0]["states"])
    identity = np.eye(n, n + 1).astype(int).tolist()
    again = tuple(map(tuple, (*identity[:-1], [0] * (n + 1))))
    whole: dict[str, Any] = {
        **pieces[0][0],
        "shortest_stay": min(layout["shortest_stay"] for layout, _ in pieces),
        **{name: {} for name in ("surfaces", "modes", "transitions", "observables", "parts")},
    }
    for k, (layout, duration) in enumerate(pieces):
        for name in ("observables", "parts"):
            for of, rows in layout[name].items():
                whole[name].setdefault(of, {}).update({f"{mode} {k}": row for mode, row in rows.items()})
        whole["surfaces"] |= {f"{name} {k}": surface for name, surface in layout["surfaces"].items()}
        for name, transition in layout["transitions"].items():
            if k == 0 or name != "entry":
                branches = tuple(branch._replace(mode=f"{branch.mode} {k}") for branch in transition.branches)
                whole["transitions"][f"{name} {k}"] = replace(transition, branches=branches)
        if ends := duration < np.inf:
            whole["surfaces"][f"end {k}"] = Surface((*(0 for _ in range(n - 1)), -1, duration), n - 1)
        for name, mode in layout["modes"].items():
            guards = [Guard(f"{g.surface} {k}", g.sign, f"{g.transition} {k}") for g in mode.guards]
            if ends:
                onward = Branch(f"{name} {k + 1}", Event.COMMAND)
                whole["transitions"][f"end of {name} {k}"] = Transition((onward,), reset=again)
                guards.append(Guard(f"end {k}", 1, f"end of {name} {k}"))
            whole["modes"][f"{name} {k}"] = replace(mode, guards=tuple(guards))
    return whole


REST = "rest"  # a start, in place of coordinates


class Scene(Checked):
    """One simulation, immutable and checked.

    Its fields are the arguments of :meth:`lsvib.Drive.simulate`, and ``drive``, also as names and values. ``physics``:
    the terms of the equations of motion, by default those that are not zero, and rest. A damping or force that is not
    listed must be zero; without ``rest`` the motion of a rigid drive is assumed never to reach θ′ = 0, so that
    reversal, rest and seizure are left out (docs/physics.md). Raises ``InputError``.

    >>> scene = lsvib.Scene(drive={"mass": 11}, start={"u": 0.1, "w": 0}, duration=0.1)
    >>> lsvib.simulate(scene).sizes["time"], scene.terms
    (1001, ('support_damping', 'axial_force', 'rest'))
    """

    drive: SerializeAsAny[Drive]
    physics: tuple[str, ...] | None = None
    resume: Resume = "contact_sign"
    start: Annotated[dict[str, Number], BeforeValidator(partial(names_and_values, "start"))]
    command: Annotated[
        Command | None,
        BeforeValidator(lambda x: x if isinstance(x, Command | None) else Command(**names_and_values("command", x))),
    ] = None
    duration: Number = Field(gt=0, le=1e9)
    samples: Whole = Field(default=1001, ge=2, le=100_000_000)
    outputs: tuple[str, ...] = ("normal_force", "coupling_torque")

    @model_validator(mode="before")
    @classmethod
    def _made(cls, values: Any) -> Any:
        drive = values.get("drive")
        drive = drive if isinstance(drive, Drive) else Drive.of(drive)
        rest = {"start": model_of(drive).from_rest(drive)} if values.get("start") == REST else {}
        return {**values, "drive": drive, **rest}

    def model_post_init(self, context: Any) -> None:
        """Check what couples two keys: start, words of physics and outputs, no term that physics omits."""
        definition = self.definition
        definition.initial_state(self.drive, self.start)
        for key, words in (("physics", (*definition.terms, *definition.options)), ("outputs", definition.outputs)):
            for word in getattr(self, key) or ():
                if word not in words:
                    raise InputError(f"{key} cannot have {word!r}; of this drive it can have {', '.join(words)}.")
        for term in definition.terms:
            value = getattr(self.drive, term)
            if self.physics is not None and term not in self.physics and value != 0:
                raise InputError(f"{term} = {value:g} although physics does not list {term}; set it to 0 or list it.")

    @property
    def definition(self) -> Model:
        """The model of a drive with these parts."""
        return model_of(self.drive)

    @property
    def terms(self) -> tuple[str, ...]:
        """The names of the terms of the equations of motion, also where ``physics`` is not given."""
        if self.physics is not None:
            return self.physics
        return (*(term for term in self.definition.terms if getattr(self.drive, term)), *self.definition.options)

    @property
    def rests(self) -> bool:
        """Whether the motion may come to rest."""
        return set(self.definition.options) <= set(self.terms)

    def parameters(self) -> dict[str, float]:
        """Return the parameters [SI units] that the scene uses: those of the drive without omitted terms."""
        return {key: value for key, value in self.drive if key not in self.definition.terms or key in self.terms}

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Make a scene from names and values, such as the content of a YAML file; raises ``InputError``."""
        return cls(**names_and_values("scene", values))


def read_yaml(path: str | Path, texts: bool = False) -> dict[str, Any]:
    """Read a YAML file that holds names and values; numbers are decimal, with leading zeros too.

    With ``texts`` all that stands there is text, also numbers, ``on`` and ``off``.

    Raises ``InputError`` in one sentence if the file is missing or something else, or gives a key twice.
    """
    try:
        with Path(path).open(encoding="utf-8") as file:
            values = yaml.load(file, Loader=_Texts if texts else _Loader)
    except OSError as error:
        raise InputError(f"Cannot read {path}: {error.strerror}.") from None
    except (yaml.YAMLError, ValueError) as error:  # ValueError: no UTF-8, no day of the calendar, no decimal number
        raise InputError(f"{path} is not valid YAML: {' '.join(str(error).split()).rstrip('.')}.") from None
    if not isinstance(values, dict):
        raise InputError(f"{path} is not a YAML file of names and values, such as name: drive.")
    return values


class _Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]  # in C, ten times as fast
    """YAML that refuses a key that is given twice."""

    def construct_mapping(self, node: yaml.Node, deep: bool = False) -> dict[Any, Any]:
        """Return a mapping."""
        seen: list[Any] = []
        for key, _ in node.value:
            if key.value in seen:
                raise yaml.YAMLError(f"the key {key.value} is given twice, again in line {key.start_mark.line + 1}")
            seen.append(key.value)
        return super().construct_mapping(node, deep)  # type: ignore[no-any-return]


for _tag, _kind in (("int", int), ("float", float)):  # 3:1 is a ratio, and not 181
    _Loader.add_constructor(
        f"tag:yaml.org,2002:{_tag}", lambda _, node, kind=_kind: node.value if ":" in node.value else kind(node.value)
    )


_Texts = type("_Texts", (_Loader,), {"yaml_implicit_resolvers": {}})  # YAML whose values are all texts
