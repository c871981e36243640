"""The ranges of the fields of a model, and one sentence about what pydantic finds wrong with its values."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from inspect import Signature
from typing import TYPE_CHECKING, Any, ClassVar, get_args

from pydantic import BaseModel, ConfigDict, GetCoreSchemaHandler, ValidationError
from pydantic_core import PydanticCustomError, core_schema

from lsvib.errors import InputError
from lsvib.numbers import EXAMPLES, NotNumber, shown
from lsvib.words import with_unit

_NO_TYPE = {  # complaint of pydantic: what the value should be
    "float_type": "a number, such as 5 or 1.0e-3",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "string_too_short": "text of one character or more",
    "string_too_long": "text of at most {max_length} characters",
    "tuple_type": "a list",
    "list_type": "a list",
    "too_short": "long enough; it needs at least {min_length}",
    "too_long": "short enough; it needs at most {max_length}",
    "model_type": "a set of names and values",
    "model_attributes_type": "a set of names and values",
    "dict_type": "a set of names and values",
}
_TAGS = ("number", "axis", "[key]")  # of types that pydantic has tried; they are no part of a place
_SIGNS = {"ge": "<=", "gt": "<", "le": "<=", "lt": "<"}


@dataclass(frozen=True)
class Least:
    """The least magnitude of a number that is not zero."""

    least: float

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Check this bound after the others."""
        return core_schema.no_info_after_validator_function(self._checked, handler(source))

    def _checked(self, value: float) -> float:
        if abs(value) >= self.least or value == 0:
            return value
        raise PydanticCustomError("too_close_to_zero", "is too close to zero")


if TYPE_CHECKING:  # by which a type checker knows the fields
    from pydantic._internal._model_construction import ModelMetaclass as _Own
else:

    class _Own(type(BaseModel)):
        def __dir__(cls) -> list[str]:  # without the names of pydantic, also in ``help``
            return [name for name in super().__dir__() if name[:2] != "__" and name not in dir(BaseModel)]


class Checked(BaseModel, metaclass=_Own):
    """Values by known names, immutable; ``_about`` begins each sentence about what is wrong with them."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    _about: ClassVar[str] = ""

    if not TYPE_CHECKING:  # a type checker reads the names from the fields

        def __init__(self, /, **values: Any) -> None:
            """Take the values; raises ``InputError`` in one sentence."""
            try:
                super().__init__(**values)
            except ValidationError as error:
                raise InputError(f"{self._about}{sentence_about(type(self), error)}") from None

    def __dir__(self) -> list[str]:
        return [*dir(type(self)), *vars(self)]

    @classmethod
    def __pydantic_init_subclass__(cls, **more: Any) -> None:
        """Make the signature readable: names and defaults."""
        own = cls.__signature__.parameters.values()
        cls.__signature__ = Signature([each.replace(annotation=Signature.empty) for each in own])


def meant(model: type[BaseModel], key: Any, names: Sequence[str] = ()) -> str:
    """Say which of the fields of a model, or of some ``names``, a wrong key is the symbol of or like, or list all."""
    names = names or [*model.model_fields]
    given = str(key).lower().strip("_")  # lambda_ is what Python lets one write
    for name in names:
        extra = model.model_fields[name].json_schema_extra
        if isinstance(extra, dict) and str(extra.get("symbol")).lower() == given:
            return f"{key} is the symbol of {name}"
    near = [name for name in names if len(given) > 3 and given in name] or get_close_matches(given, names, 3, 0.75)
    return f"perhaps {' or '.join(near)} is meant" if near else f"the known keys are {', '.join(names)}"


def bounds_of(model: type[BaseModel], key: str) -> dict[str, float]:
    """Return the bounds that a field has, by their names ``ge``, ``gt``, ``le``, ``lt`` and ``least``."""
    found = model.model_fields[key].metadata
    return {name: getattr(one, name) for one in found for name in (*_SIGNS, "least") if hasattr(one, name)}


def allowed_range(model: type[BaseModel], key: str) -> str:
    """Return the allowed range of a field as text, e.g. ``1e-18 <= mass <= 1e+09``; empty if it has no bounds."""
    more, text = model.model_fields[key].json_schema_extra, _in_words(key, bounds_of(model, key))
    return f"{text}{more.get('beyond', '')}" if isinstance(more, Mapping) else text


def _in_words(name: str, bounds: Mapping[str, float]) -> str:
    """A range in words, e.g. ``0 or 1e-18 <= |R| <= 1e+12``."""
    zero, size = "", name
    if least := bounds.get("least"):
        if bounds.get("lt") == 0:
            bounds = {"ge": bounds["ge"], "le": -least}
        elif "gt" in bounds:
            bounds = {"ge": least, "le": bounds["le"]}
        else:
            zero, size = "0 or ", f"|{name}|" if bounds["ge"] < 0 else name
            bounds = {**bounds, "ge": least}
    low = [f"{bounds[side]:g} {_SIGNS[side]} " for side in ("ge", "gt") if side in bounds]
    high = [f" {_SIGNS[side]} {bounds[side]:g}" for side in ("le", "lt") if side in bounds]
    return f"{zero}{''.join(low)}{size}{''.join(high)}" if low or high else ""


def sentence_about(model: type[BaseModel], error: ValidationError, place: Sequence[str] = ()) -> str:
    """Return one sentence about the first complaint of pydantic about a model, with key, value and range.

    The models may lie in one another, and the first at a ``place``. A ``ValueError`` of a field's own is the end of the
    sentence.
    """
    # Of a misspelt key the misspelling is the news, not that the right one is missing.
    first = min(error.errors(), key=lambda complaint: complaint["type"] == "missing")
    kind, context = first["type"], first.get("ctx", {})
    cause, parts = context.get("error"), [part for part in first["loc"] if part not in _TAGS]
    key, value = ".".join(map(str, (*place, *parts))), shown(first["input"])
    if isinstance(cause, InputError) and not isinstance(cause, NotNumber):
        return str(cause)
    if isinstance(cause, ValueError) and not isinstance(cause, InputError):
        return f"{key} {cause}."
    for part in parts[:-1]:
        if part in model.model_fields:
            model = next(_models(model.model_fields[str(part)].annotation), model)
    last = str(parts[-1]) if parts else ""
    choices = context.get("expected", "").replace("'", "")
    if kind in ("extra_forbidden", "invalid_key") or "[key]" in first["loc"]:
        known = f"the known keys are {choices}" if choices else meant(model, last)
        return f"{key} is not a known key; {known}."
    if kind == "missing":
        return f"{key} is missing{f'; give one{EXAMPLES[key]}' if key in EXAMPLES else ''}."
    if kind == "literal_error":
        return f"{key} = {value} is not one of {choices}."
    if kind in _NO_TYPE:
        return f"{key} = {value} is not {_NO_TYPE[kind].format(**context)}."
    if kind == "of_the_whole":
        return f"{key} {first['msg']}."
    field = model.model_fields.get(last)
    allowed = allowed_range(model, last) if field else _in_words("value", context)
    if field and isinstance(field.json_schema_extra, Mapping):
        allowed = with_unit(allowed, str(field.json_schema_extra["unit"]))
    if isinstance(cause, NotNumber):
        return f"{key} = {value} {cause}{'; the allowed range is ' if allowed else ''}{allowed}."
    if allowed and kind != "of_the_value":
        return f"{key} = {value} is outside the allowed range {allowed}."
    ours = kind in ("of_the_value", "too_close_to_zero")
    return f"{key} = {value} {'' if ours else 'is not acceptable: '}{first['msg']}."


def _models(kind: Any) -> Iterator[type[BaseModel]]:
    """The models in a type, such as a list of one, or one that may be absent."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        yield kind
    for part in get_args(kind):
        yield from _models(part)
