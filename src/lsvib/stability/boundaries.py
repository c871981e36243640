"""Boundaries of stability of steady sliding in one parameter, from the full characteristic polynomial of a drive.

All coefficients of the polynomial are linear in the mass, in μ (after multiplication by 1 + s_0 μ tan λ) and in every
damping; so the Hurwitz determinant is a cubic, and steady sliding changes its stability only at positive roots of these
five polynomials. They are isolated with certainty, and exact signs between them decide. The steady law s_0 depends on
none of these parameters but c_x, which is therefore left out.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from lsvib.engine.exact.arithmetic import multiplied
from lsvib.models.drive import Drive
from lsvib.stability.linear import steady_law
from lsvib.stability.spectrum import (
    DIGITS,
    SAME,
    Polynomial,
    hurwitz,
    neutral_margins,
    polynomial,
    positive_roots,
    rationals,
    tangents,
    trimmed,
)


@dataclass(frozen=True)
class StableSet:
    """Values of one parameter at which steady sliding is stable, all others held at those of the drive.

    ``intervals`` are open intervals (low, high) [unit of the parameter] in ascending order, within 0 and ``limit``, the
    end of the range of the parameter. With ``neutral`` the drive has no damping, and they are the values at which no
    motion grows; else those at which steady sliding is asymptotically stable. ``from_zero`` says that zero belongs to
    the first interval.
    """

    key: str
    intervals: tuple[tuple[Fraction, Fraction], ...]
    limit: Fraction
    neutral: bool
    from_zero: bool


def stable_set(drive: Drive, key: str) -> StableSet:
    """Compute the values of the parameter ``key`` at which the steady sliding of a drive is stable.

    Arguments: drive with compliant threads, axial support or rotating nut; ``mass``, ``friction_coefficient``,
    ``support_damping`` or the drive's ``own_damping``. Raises ``InputError`` if the contact carries no force.
    """
    kind, law, neutral = type(drive), steady_law(drive), undamped(drive, key)
    tangent = tangents(drive, DIGITS)[0]
    if key == "friction_coefficient":
        limit = largest_friction(tangent)
    else:
        limit = Fraction(kind.model_json_schema()["properties"][key]["maximum"])
    values = rationals(drive)

    def at(value: Fraction) -> tuple[Fraction, ...]:
        return margins(polynomial(kind, {**values, key: value}, law, tangent), neutral)

    def stable(value: Fraction) -> bool:
        return min(at(value)) > 0

    conditions = [interpolated(samples) for samples in zip(*(at(Fraction(x)) for x in range(4)), strict=True)]
    if not all(conditions):  # one vanishes for every value of the parameter
        return StableSet(key, (), limit, neutral, False)
    places = [root for p in conditions for root in positive_roots(p, limit)]
    ends = [Fraction(0), *_apart(places, limit), limit]
    intervals = tuple((a, b) for a, b in pairwise(ends) if stable((a + b) / 2))
    return StableSet(key, intervals, limit, neutral, stable(Fraction(0)))


def largest_friction(tangent: Fraction) -> Fraction:
    """Return the end of the range of the friction coefficient, cot λ."""
    return 1 / tangent


def threshold_of(drive: Drive, key: str) -> dict[str, Any]:
    """The threshold of a parameter as plain values: ``value``, ``unit``, ``stable_intervals``, perhaps a ``reason``.

    For a damping the value is the least one: below it steady sliding is stable at none. For the mass and the friction
    coefficient it is the critical one: above it steady sliding is stable at none. ``stable_intervals`` is the whole
    set, with ``low`` and ``high``; ``high`` is None at the end of the range of the parameter. ``stability`` says of
    what: ``asymptotic`` or, for a drive without any damping, ``neutral``. The value is None, with a ``reason``, if the
    set is empty or reaches the end of the range.
    """
    found = stable_set(drive, key)
    schema = type(drive).model_fields[key].json_schema_extra
    least = key not in ("mass", "friction_coefficient")
    value, reason = None, None
    name, adverb = key.replace("_", " "), "neutrally" if found.neutral else "asymptotically"
    if not found.intervals:
        reason = f"Steady sliding is {adverb} stable for no {name}, all other parameters held."
    elif least:
        value = float(found.intervals[0][0])
        if value == 0 and not found.from_zero:
            reason = f"Steady sliding is not {adverb} stable without it, but with any {name} above zero, however small."
    elif found.intervals[-1][1] == found.limit:
        reason = (
            f"Steady sliding is {adverb} stable up to the end of the range of {name}, {_end(found, schema['unit'])}"
        )
        gaps = len(found.intervals) > 1 or found.intervals[0][0] > 0
        reason += ", though not for every smaller one." if gaps else "."
    else:
        value = float(found.intervals[-1][1])
    intervals = [{"low": float(a), "high": None if b == found.limit else float(b)} for a, b in found.intervals]
    return {
        "value": value,
        "unit": schema["unit"],
        "stability": "neutral" if found.neutral else "asymptotic",
        "stable_intervals": intervals,
        **({"reason": reason} if reason else {}),
    }


def model_thresholds(drive: Drive) -> dict[str, dict[str, Any]]:
    """Return a drive's critical mass, critical friction and least own damping, each as :func:`threshold_of`."""
    own = drive.own_damping
    keys = {"critical_mass": "mass", "critical_friction": "friction_coefficient", f"least_{own}": own}
    return {name: threshold_of(drive, key) for name, key in keys.items()}


def margins(p: tuple[Any, ...], neutral: bool) -> tuple[Any, ...]:
    """Return numbers that are all positive exactly where steady sliding is stable; p_0 always is.

    Without damping (``neutral``) those for which no motion grows and all frequencies are distinct.
    """
    if len(p) == 3:
        return p[:1] if neutral else p[:2]
    return neutral_margins(p) if neutral else (*p[:4], hurwitz(p))


def undamped(drive: Drive, key: str) -> bool:
    """Whether nothing damps the drive, whatever the parameter ``key`` is: stability is then neutral stability."""
    dampings = ["support_damping", "translation_damping", drive.own_damping]
    return key not in dampings and not any(getattr(drive, name) for name in dampings if name)


def _end(found: StableSet, unit: str) -> str:
    return "cot(lead_angle)" if found.key == "friction_coefficient" else f"{float(found.limit):g} {unit}"


def interpolated(values: Sequence[Fraction]) -> Polynomial:
    """The polynomial through ``values`` at 0, 1, 2, …, by Newton's divided differences; leading zeros left out."""
    differences = list(values)
    for order in range(1, len(values)):
        for i in range(len(values) - 1, order - 1, -1):
            differences[i] = (differences[i] - differences[i - 1]) / order
    result: Polynomial = (Fraction(0),)
    for place in range(len(values) - 1, -1, -1):
        *others, last = multiplied(result, (Fraction(1), Fraction(-place)))
        result = (*others, last + differences[place])
    return trimmed(result)


def _apart(places: Iterable[Fraction], limit: Fraction) -> list[Fraction]:
    """Places below the limit in ascending order, each once even if it is a root of two polynomials.

    The limit itself is left out, although the coefficients vanish at μ = cot λ under law −.
    """
    kept: list[Fraction] = []
    for place in sorted(places):
        if limit - place > SAME * limit and (not kept or place - kept[-1] > SAME * place):
            kept.append(place)
    return kept
