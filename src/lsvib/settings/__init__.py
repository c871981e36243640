"""The settings of the figures: where they are, and one sentence about what is wrong with them.

The two files beside this module are links to ``config/config.yaml`` and ``workflow/schemas/config.schema.yaml`` of the
repository; an installed package holds copies of them.
"""

import math
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError
from lsvib.numbers import shown

DEFAULT = Path(__file__).with_name("config.yaml")
_SCHEMA = Path(__file__).with_name("config.schema.yaml")
# Parameters of its drive that a figure does not depend on: it varies them itself, or they drop out of what it shows.
UNUSED = {
    "fig8_01": ("coupling_stiffness", "support_damping", "input_speed", "translation_damping", "axial_force"),
    "fig8_02": ("coupling_stiffness", "support_damping", "input_speed", "translation_damping", "axial_force"),
    "fig8_03": ("mass", "translation_damping"),
    "fig8_06": ("axial_force",),
    "fig8_08": ("input_speed", "mass", "translation_damping", "axial_force"),
    "fig8_09": ("mass",),
    "fig8_11": ("support_damping",),
    "fig8_12": ("support_damping",),
    "fig8_14": ("mass", "axial_force"),
    "fig8_15": ("support_damping", "friction_coefficient", "input_speed", "translation_damping", "axial_force"),
    "limit_process": ("support_damping", "translation_damping", "axial_force"),
    "table_rounding": ("mass", "translation_damping", "axial_force"),
    "contact_stability": ("mass",),
    "nut_stability": ("input_speed", "axial_force"),
}
_LISTS = ("figures", "accuracy_figures")
_BOUNDS = {  # keyword of the schema: how it stands in a range, before or after the name
    "minimum": ("{:.10g} <= ", ""),
    "exclusiveMinimum": ("{:.10g} < ", ""),
    "maximum": ("", " <= {:.10g}"),
    "exclusiveMaximum": ("", " < {:.10g}"),
}
_TYPES = {
    "number": "a number",
    "integer": "a whole number",
    "array": "a list",
    "object": "a set of names and values",
    "string": "text",
}
_ORDERED = (("start", "stop"), ("left", "right"), ("bottom", "top"))


def check(settings: Mapping[str, Any]) -> None:
    """Check complete settings, those of a run of the workflow; raises ``InputError`` in one sentence."""
    _check(settings, _schema())


def check_section(settings: Mapping[str, Any], name: str) -> None:
    """Check the section of one figure, and nothing else; raises ``InputError`` in one sentence."""
    schema = _schema()
    _check({name: settings[name]}, {**schema, "required": []})


def figures(settings: Mapping[str, Any]) -> list[str]:
    """Return the names of the figures in settings that have a section; raises ``InputError`` in one sentence."""
    schema = _schema()
    for key in settings:
        if key not in schema["properties"]:
            raise InputError(f"{shown(key)} is not a known key; the known keys are {', '.join(schema['properties'])}.")
    _check({key: settings[key] for key in _LISTS if key in settings}, {**schema, "required": []})
    names = [name for key in _LISTS for name in settings.get(key, ())]
    return [name for name in names if name in settings]


@cache
def _schema() -> dict[str, Any]:
    return read_yaml(_SCHEMA)


def _check(settings: Mapping[str, Any], schema: Mapping[str, Any]) -> None:
    from jsonschema import Draft202012Validator, validators

    for path, value in _places(settings, ""):
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{path} = {value} is not a finite number.")
    checker = Draft202012Validator.TYPE_CHECKER.redefine("integer", lambda _, value: type(value) is int)
    kind = validators.extend(Draft202012Validator, type_checker=checker)
    errors = sorted(kind(schema).iter_errors(settings), key=lambda error: [str(part) for part in error.absolute_path])
    if errors:
        raise InputError(_sentence(errors[0]))
    for path, values in _places(settings, ""):
        for low, high in _ORDERED if isinstance(values, Mapping) else ():
            if low in values and high in values and not values[low] < values[high]:
                raise InputError(
                    f"{path} has {low} = {values[low]:g} and {high} = {values[high]:g}; it needs {low} < {high}."
                )


def _places(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield everything in settings with its place, such as ``fig8_06.axial_force.count``."""
    yield path, value
    items = value.items() if isinstance(value, Mapping) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in items:
        yield from _places(inner, f"{path}.{key}" if path else str(key))


def _sentence(error: Any) -> str:
    """One sentence about one complaint of the validator."""
    path = ".".join(map(str, error.absolute_path))
    name, value, rule = path.rsplit(".", 1)[-1], shown(error.instance), error.validator
    inside = f"{path}." if path else ""
    if rule == "additionalProperties":
        known = error.schema.get("properties", {})
        unknown = next(key for key in error.instance if key not in known)
        return f"{inside}{unknown} is not a known key; the known keys are {', '.join(known)}."
    if rule == "required":
        missing = next(key for key in error.validator_value if key not in error.instance)
        return f"{inside}{missing} is missing."
    if rule in _BOUNDS:
        bounds = [(low, high, error.schema[key]) for key, (low, high) in _BOUNDS.items() if key in error.schema]
        low = "".join(low.format(bound) for low, _, bound in bounds if low)
        high = "".join(high.format(bound) for _, high, bound in bounds if high)
        return f"{path} = {value} is outside the allowed range {low}{name}{high}."
    if rule == "type":
        hint = "; write it with a point, such as 1.0e-3" if isinstance(error.instance, str) else ""
        return f"{path} = {value} is not {_TYPES[error.validator_value]}{hint}."
    if rule == "enum":
        return f"{path} = {value} is not one of {', '.join(map(str, error.validator_value))}."
    if rule in ("minItems", "minProperties", "maxItems", "maxProperties"):
        side = "at least" if rule.startswith("min") else "at most"
        return f"{path} has {len(error.instance)} entries; it needs {side} {error.validator_value}."
    if rule == "uniqueItems":
        return f"{path} = {value} holds an entry twice."
    if rule == "not":
        return f"{path} = {value} is not acceptable; it must not be {shown(error.validator_value.get('const'))}."
    if rule == "oneOf":
        return f"{path} = {value} is neither a number nor an axis with start, stop and count."
    return f"{path} = {value} is not acceptable: it breaks the rule {rule} = {shown(error.validator_value)}."
