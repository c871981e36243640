"""Thresholds of a drive by name, each solved for any one of its parameters, with the derivatives by all others."""

import math
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

from lsvib.errors import EngineError, InputError, NoThreshold
from lsvib.models.drive import Drive, allowed_range, described
from lsvib.models.model import find_model
from lsvib.numbers import shown
from lsvib.results import Quantity, SolvedThreshold, ThresholdSolution
from lsvib.stability import force_thresholds, motion_equations
from lsvib.stability.boundaries import Place, places
from lsvib.stability.motion_equations import Start
from lsvib.stability.solve import DECADES, Root, Singular, changes, solved

_FORCES: dict[str, Callable[[Any], Start]] = {
    "stick": force_thresholds.stick_start,
    "detach": force_thresholds.detach_start,
    "global_stability": force_thresholds.global_stability_start,
    "fold": force_thresholds.fold_start,
    "cycle_birth": force_thresholds.cycle_birth_start,
}
"""Thresholds that are forces in closed form, for rigid drives mirrored to Ω > 0; no other model has one of the name."""
_POLYNOMIALS = ("onset", "kinematic_constraint", "negative_damping", "flutter")  # where one of the parameters vanishes
_USUAL = {
    "kinematic_constraint": "mass",
    "negative_damping": "support_damping",
    "flutter": "mass",
    "rest_loss": "support_damping",
}


def names(model: str) -> tuple[str, ...]:
    """Return the names of the thresholds of a model."""
    return find_model(model).thresholds


def solve_threshold(drive: Drive, name: str, unknown: str | None = None) -> SolvedThreshold:
    """Solve a threshold of a drive for one of its parameters, all others held.

    Arguments: drive of any model; name of a threshold (:func:`names`); name of the parameter, by default
    the usual one: ``axial_force``, of ``kinematic`` and ``flutter`` ``mass``, of ``negative_damping`` and ``rest_loss``
    ``support_damping``. The drive's own value of that parameter counts only as the middle of a search. Raises
    ``InputError`` for other names, ``NoThreshold`` where there is no solution in the allowed range.
    """
    drive = find_model(drive.model).drive(**drive.model_dump())
    known = names(drive.model)
    if not isinstance(name, str) or name not in known:
        raise InputError(f"threshold = {shown(name)} is not one of those of model {drive.model}: {', '.join(known)}.")
    key = _USUAL.get(name, "axial_force") if unknown is None else unknown
    if not isinstance(key, str) or key not in type(drive).model_fields:
        raise InputError(
            f"unknown = {shown(key)} is not a parameter of model {drive.model}: {', '.join(type(drive).model_fields)}."
        )
    if name in _POLYNOMIALS:
        return _by_polynomials(drive, name, key)
    if name in _FORCES and key == "axial_force":
        start = _FORCES[name](drive)
        sense = 1 if drive.input_speed > 0 else -1
        try:
            found = _newton(drive, key, start, sense * start.force)
        except Singular:
            raise NoThreshold(
                f"no axial_force is the threshold {name}: next to {sense * float(start.force):.9g} N, where the drive "
                "changes what it does, its equations have no solution."
            ) from None
        return _result(drive, name, key, [found], "The force follows from a closed form, which has one value.")
    return _by_search(drive, name, key)


def _by_polynomials(drive: Drive, name: str, unknown: str) -> SolvedThreshold:
    found = places(drive, name, unknown)
    if found is None:
        raise NoThreshold(f"the threshold {name} of model {drive.model} does not depend on {unknown}.")
    if not found:
        raise NoThreshold(
            f"no {unknown} in the allowed range {allowed_range(type(drive), unknown)} is the threshold {name}, "
            "all other parameters held."
        )
    how = "All of them: the roots of polynomials are isolated with certainty."
    return _result(drive, name, unknown, [_at_place(drive, name, unknown, place) for place in found], how)


def _at_place(drive: Drive, name: str, unknown: str, place: Place) -> ThresholdSolution:
    condition = place.condition
    try:
        root = solved(drive, unknown, condition.equations(type(drive), place.sense), place.value)
    except Singular:
        raise NoThreshold(
            f"{unknown} = {float(place.value):.17g} is a double root of the threshold {name}, at which it has no "
            "derivatives."
        ) from None
    return _solution(drive, unknown, root, condition.words)


def _by_search(drive: Drive, name: str, unknown: str) -> SolvedThreshold:
    found = []
    for value in changes(drive, unknown, lambda near: float(_start(name, near)[0])):
        near = drive.replace(**{unknown: value})
        with suppress(Singular, NoThreshold):  # a jump of the gap, not a root
            found.append(_newton(near, unknown, _start(name, near)[1], value))
    span = f"{DECADES} decades on both sides of the drive's own value"
    if not found:
        raise NoThreshold(
            f"no {unknown} within {span} is the threshold {name} at axial_force = {drive.axial_force:g}, all other "
            f"parameters held{_why_not(name, drive)}."
        )
    return _result(drive, name, unknown, found, f"All that a search over {span} has found; that is no proof.")


def _why_not(name: str, drive: Drive) -> str:
    """Why the drive itself has no such threshold, as the end of a sentence; nothing if it has one."""
    try:
        _start(name, drive)
    except (InputError, EngineError) as error:
        return f"; with its own value {str(error).rstrip('.')}"
    return ""


def _start(name: str, drive: Any) -> tuple[Any, Start]:
    """What is left of a threshold's equation at a drive, and where Newton's method starts."""
    if name == "rest_loss":
        return force_thresholds.rest_left(drive)
    start = _FORCES[name](drive)
    return start.force - drive.axial_force * (1 if drive.input_speed > 0 else -1), start


def _newton(drive: Drive, unknown: str, start: Start, guess: Any) -> ThresholdSolution:
    equations = motion_equations.equations(start.system, 1 if drive.input_speed > 0 else -1)
    root = solved(drive, unknown, equations, guess, start.times)
    return _solution(drive, unknown, root, motion_equations.words(start.system))


def _solution(drive: Drive, unknown: str, root: Root, words: str) -> ThresholdSolution:
    unit = described(type(drive), unknown)["unit"]
    return ThresholdSolution(
        value=root.value,
        residual=root.residual,
        error_bound=root.error_bound,
        derivatives={
            name: Quantity(slope if math.isfinite(slope) else None, _ratio(unit, described(type(drive), name)["unit"]))
            for name, slope in root.derivatives.items()
        },
        equation=words,
    )


def _ratio(unit: str, by: str) -> str:
    """The unit of a quotient, as UDUNITS spells it."""
    return unit if by == "1" else f"{unit}/({by})"


def _result(drive: Drive, name: str, unknown: str, found: Iterable[ThresholdSolution], how: str) -> SolvedThreshold:
    ordered = tuple(sorted(found, key=lambda solution: solution.value))
    return SolvedThreshold(
        name=name,
        model=drive.model,
        unknown=unknown,
        unit=described(type(drive), unknown)["unit"],
        solutions=ordered,
        how=how,
    )
