"""What the chapter says of a model beyond its eigenvalues: a file for each model, found by its name."""

import math
from decimal import Decimal
from fractions import Fraction
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from lsvib.drives.linear_parts import Polynomial


def said_of(model: str, drive: Any, law: int, polynomial: Polynomial, flutter: float | None) -> dict[str, Any]:
    """Return the ``conditions`` and ``quantities`` of a model and what else its file says; none without a file here.

    Arguments: its name; a drive; the law s_0 of steady sliding; its characteristic polynomial; its growth rate of
    flutter [1/s], None if nothing grows.
    """
    module = f"{__name__}.{model}"
    if find_spec(module) is None:
        return {"conditions": {}, "quantities": {}}
    found: dict[str, Any] = import_module(module).said(drive, law, polynomial, flutter)
    return found


def condition(**margins: Decimal | Fraction | float | None) -> dict[str, Any]:
    """Return the margins of a condition, missing ones left out, and whether all of them exist and are positive."""
    known = {name: float(value) for name, value in margins.items() if value is not None}
    return {"margins": known, "hold": all(value is not None and value > 0 for value in margins.values())}


def quantity(value: Decimal | Fraction | float | None, unit: str) -> dict[str, Any]:
    """Return a quantity with its unit; None where there is none, and where it is beyond the range of doubles."""
    return {"value": None if value is None or math.isinf(float(value)) else float(value), "unit": unit}
