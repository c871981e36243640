"""What the chapter says of the stability of a model beyond its eigenvalues: a file for each, found by its name.

A file has ``said(drive, law, polynomial, flutter)``: the ``conditions`` and ``quantities`` of a drive, and what else
there is to say, from the law s_0 of steady sliding, its characteristic polynomial, and its growth rate of flutter
[1/s], None if nothing grows. That of the rigid drive has ``stability(drive)``, the whole table.
"""

import math
from fractions import Fraction
from typing import Any

from flint import arb


def condition(**margins: arb | Fraction | float | None) -> dict[str, Any]:
    """Return the margins of a condition, missing ones left out, and whether all of them exist and are positive."""
    known = {name: float(value) for name, value in margins.items() if value is not None}
    return {"margins": known, "hold": all(value is not None and value > 0 for value in margins.values())}


def quantity(value: arb | Fraction | float | None, unit: str) -> dict[str, Any]:
    """Return a quantity with its unit; None where there is none, and where it is beyond the range of doubles."""
    return {"value": None if value is None or math.isinf(float(value)) else float(value), "unit": unit}
