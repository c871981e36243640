"""A scene: which drive and which physics, from which state, for how long, and what is wanted of it."""

from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Any, ClassVar, Self

import yaml
from pydantic import BeforeValidator, Field, SerializeAsAny, model_validator

from lsvib.drives.command import Command
from lsvib.drives.complaints import Checked
from lsvib.drives.drive import Drive, Number, Whole
from lsvib.drives.model import Model, model_of
from lsvib.drives.names import Resume
from lsvib.errors import InputError
from lsvib.numbers import names_and_values

REST = "rest"  # a start, in place of coordinates


class Scene(Checked):
    """One simulation, immutable and checked.

    ``drive``: its parameters. ``physics``: the terms that the scene has – a damping or force that is listed nowhere
    must be zero in the drive, and without ``rest`` the motion of a rigid drive is taken never to reach θ′ = 0, so
    reversal, rest and seizure are left out; by default the non-zero terms and rest. ``resume``: how motion goes on
    after a seizure, see :mod:`lsvib.drives.modes`. ``start``: u [rad], w [rad/s], and what else the model has; or
    ``rest``: the screw stands with the coupling relaxed as the motor begins to turn. ``command``: the commanded speed
    over time, :class:`lsvib.drives.command.Command`, in place of the constant ``input_speed``, from whose steady
    sliding deviations are measured still. ``duration`` [s]. ``samples``: number of equidistant output times, both ends
    included. ``outputs``: observables to store besides the state, the mode and the events.
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
                    raise InputError(f"{key} has the word {word!r}; this drive knows {', '.join(words)}.")
        for term in definition.terms:
            value = getattr(self.drive, term)
            if self.physics is not None and term not in self.physics and value != 0:
                raise InputError(f"{term} = {value:g} although physics does not list {term}; set it to 0 or list it.")

    @property
    def definition(self) -> Model:
        """What the parts of the drive make of it."""
        return model_of(self.drive)

    @property
    def terms(self) -> tuple[str, ...]:
        """The physics of the scene, spelled out."""
        if self.physics is not None:
            return self.physics
        return (*(term for term in self.definition.terms if getattr(self.drive, term)), *self.definition.options)

    @property
    def rests(self) -> bool:
        """Whether its motion may come to rest."""
        return set(self.definition.options) <= set(self.terms)

    def parameters(self) -> dict[str, float]:
        """Return the parameters that the scene uses: the drive's without the terms that the physics leaves out."""
        return {key: value for key, value in self.drive if key not in self.definition.terms or key in self.terms}

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Make a scene from names and values; raises ``InputError`` in one sentence."""
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


class _Texts(_Loader):
    """YAML whose values are texts."""

    yaml_implicit_resolvers: ClassVar[dict[str, Any]] = {}
