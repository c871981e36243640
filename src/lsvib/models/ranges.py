"""Ranges of numbers that may be zero but not next to it: checked, stated in a JSON schema, and in words."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import PydanticCustomError, core_schema


@dataclass(frozen=True)
class Least:
    """The least magnitude of a parameter that is not zero; ``zero`` says whether it may be zero."""

    magnitude: float
    zero: bool = True

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """Check this bound after the others."""
        return core_schema.no_info_after_validator_function(self._checked, handler(source))

    def __get_pydantic_json_schema__(self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler) -> Any:
        """Say this bound beside the others."""
        rule = handler(schema)
        sides: list[dict[str, float]] = [{"minimum": self.magnitude}]
        if rule.get("minimum", 0) < 0:
            sides.insert(0, {"maximum": -self.magnitude})
        return {**rule, "anyOf": [*([{"const": 0}] if self.zero else []), *sides]}

    def _checked(self, value: float) -> float:
        if abs(value) >= self.magnitude or (self.zero and value == 0):
            return value
        raise PydanticCustomError("too_close_to_zero", "is too close to zero")


def range_in_words(name: str, rule: Mapping[str, Any], form: str = "g") -> str:
    """Return the range that a JSON schema states for a number, e.g. ``0 or 1e-18 <= |R| <= 1e+12``; empty if none."""
    alternatives = [bound for bound in rule.get("anyOf", ()) if bound.keys() <= {"const", "minimum", "maximum"}]
    zero, size = "", name
    if alternatives:
        least = alternatives[-1]["minimum"]
        if rule.get("exclusiveMaximum") == 0:
            rule = {"minimum": rule["minimum"], "maximum": -least}
        elif "exclusiveMinimum" in rule:
            rule = {"minimum": least, "maximum": rule["maximum"]}
        else:
            zero = "0 or " if {"const": 0} in alternatives and "not" not in rule else ""
            size = f"|{name}|" if rule["minimum"] < 0 else name
            rule = {**rule, "minimum": least}
    low = [f"{rule[k]:{form}} {sign} " for k, sign in (("minimum", "<="), ("exclusiveMinimum", "<")) if k in rule]
    high = [f" {sign} {rule[k]:{form}}" for k, sign in (("maximum", "<="), ("exclusiveMaximum", "<")) if k in rule]
    return f"{zero}{''.join(low)}{size}{''.join(high)}" if low or high else ""
