"""Thresholds of a drive by name, each solved for any one of its parameters, with an enclosure and derivatives.

Names and equations stand in docs/thresholds.md. Roots of one equation are isolated (:mod:`lsvib.stability.boundaries`),
axial forces follow from closed forms and return maps (:mod:`lsvib.stability.force_thresholds`), and as any other
parameter a threshold of a motion is searched for: where that force equals the force of the drive. All then go through
one solver, which proves and encloses them (:mod:`lsvib.stability.solve`).
"""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

from flint import arb

from lsvib.drives import friction
from lsvib.drives.complaints import allowed_range, meant
from lsvib.drives.drive import DRY, Drive, described, require_direction, zero_if_close
from lsvib.drives.model import model_of
from lsvib.drives.thresholds import TABLE
from lsvib.errors import EngineError, InputError, NoThreshold
from lsvib.numbers import shown
from lsvib.results import Derivative, Threshold, ThresholdSolution
from lsvib.stability import boundaries
from lsvib.stability.boundaries import FRICTIONLESS, Place, StableSet, place_values, places, searched, stable_set
from lsvib.stability.force_thresholds import STARTS
from lsvib.stability.motion_equations import Start, equations
from lsvib.stability.solve import DECADES, Root, Singular, crossings, outwards, samples, solved
from lsvib.systems.exact.arithmetic import many_digits

Solver = Callable[[Drive, str], Threshold]
"""What solves ``even_speed`` for a parameter: it needs the engine (:mod:`lsvib.stability.starting`)."""


def all_thresholds(drive: Drive, unknown: str | None = None, even: Solver | None = None) -> dict[str, Threshold]:
    """Return all thresholds of a drive by name, ``even_speed`` with its solver, as :func:`solve_threshold` gives them.

    Solved for ``unknown``, by default each for its usual parameter. One that does not exist has no value but a
    ``reason``. Raises ``InputError`` for another parameter.
    """
    found = {}
    for name in model_of(drive).thresholds:
        if name == "even_speed" and even is None:
            continue
        key = parameter(drive, name, unknown)
        try:
            found[name] = _solve(drive, name, key, even)
        except NoThreshold as absent:
            found[name] = result(drive, name, key, (), reason=str(absent))
    return found


def solve_threshold(drive: Drive, name: str, unknown: str | None = None, even: Solver | None = None) -> Threshold:
    """Solve a threshold of a drive, ``even_speed`` with its solver, for one of its parameters, all others held.

    Arguments: drive of any model; name of one of the thresholds of that model; name of the parameter, by default the
    usual one (:mod:`lsvib.drives.thresholds`). The drive's own value of that parameter counts only as the middle of a
    search. Raises ``InputError`` for other names, ``NoThreshold`` where there is no solution in the allowed range.
    """
    known = model_of(drive).thresholds
    if not isinstance(name, str) or name not in known:
        raise InputError(f"threshold = {shown(name)} is not a threshold of this drive; those are {', '.join(known)}.")
    found = _solve(drive, name, parameter(drive, name, unknown), even)
    if not found.solutions:
        raise NoThreshold(found.reason)
    return found


def parameter(drive: Drive, name: str, unknown: Any) -> str:
    """Return the parameter that a threshold is solved for, the usual one for None; raises ``InputError``."""
    usual = TABLE[name].usual or ("mass" if drive.parts else "axial_force")
    key = usual if unknown is None else unknown
    if key not in (there := [*drive.model_dump(exclude_none=True)]):
        raise InputError(f"unknown = {shown(key)} is not a parameter of this drive; {meant(Drive, key, there)}.")
    return key


def _solve(drive: Drive, name: str, unknown: str, even: Solver | None) -> Threshold:
    """A threshold, perhaps without solutions but with a reason; or ``NoThreshold``."""
    require_direction(drive)
    if unknown == "stribeck_exponent":
        raise NoThreshold("stribeck_exponent is either 1 or 2, so no threshold is solved for it.")
    if unknown in friction.FADING and not getattr(drive, friction.FADING[unknown]):
        raise NoThreshold(f"no threshold is solved for {unknown} without {friction.FADING[unknown]} > 0.")
    if name == "even_speed" and even:
        return even(drive, unknown)
    if name in boundaries.NAMES:
        return _by_roots(drive, name, unknown)
    if unknown in DRY:
        raise NoThreshold(f"the threshold {name} is computed only without friction of slide, bearing and collar.")
    if unknown == "static_friction_coefficient" and name == "stick":
        raise NoThreshold("the threshold stick does not depend on static_friction_coefficient.")
    wanted = friction.refusal(drive, TABLE[name].rest)
    if not wanted and unknown in friction.NAMES:
        wanted = "is computed only for a single friction coefficient"
    if wanted:
        raise NoThreshold(f"the threshold {name} {wanted}.")
    if unknown == "axial_force":
        return _by_force(drive, name)
    return _by_search(drive, name, unknown)


def _by_roots(drive: Drive, name: str, unknown: str) -> Threshold:
    stable = stable_set(drive, unknown) if name == "onset" else None
    found = stable.places() if stable else None if name == "onset" else places(drive, name, unknown)
    if found is None:
        raise NoThreshold(f"the threshold {name} of this drive does not depend on {unknown}.")
    solutions, reason = [_at_place(drive, name, unknown, place) for place in found], ""
    if stable:
        reason = stable.why_no_change()
    elif not solutions:
        reason = (
            f"no {unknown} in the allowed range {allowed_range(type(drive), unknown)} is the threshold {name}, "
            "with all other parameters fixed."
        )
    what = "equations" if searched(drive, unknown) else "polynomials"
    how = f"All of them: the roots of {what} are isolated with certainty."
    if any(place.condition.words == FRICTIONLESS for place in found):
        how += " Where the equation is μ = 0, the falling law of friction reaches zero and is cut off."
    return result(drive, name, unknown, solutions, how, reason, stable)


def _at_place(drive: Drive, name: str, unknown: str, place: Place) -> ThresholdSolution:
    condition = place.condition
    try:
        root = solved(drive, unknown, lambda p, _: [condition.of(p, p["lead_angle"].tan(), place.sense)], place.value)
    except Singular:
        raise NoThreshold(
            f"{unknown} = {float(place.value):.17g} is a double root of the threshold {name}, at which it has no "
            "derivatives."
        ) from None
    return _solution(drive, unknown, root, condition.words)


def _by_force(drive: Drive, name: str) -> Threshold:
    with many_digits():
        start = STARTS[name](drive)
        force = start.force * (1 if drive.input_speed > 0 else -1)
    try:
        found = newton(drive, "axial_force", start, force)
    except Singular:
        raise NoThreshold(
            f"no axial_force is the threshold {name}: near {float(force):.9g} N, where the drive changes its "
            "behaviour, its equations have no solution."
        ) from None
    return result(drive, name, "axial_force", [found], "The force follows from a closed form, which has one value.")


def _by_search(drive: Drive, name: str, unknown: str) -> Threshold:
    found = []
    # Where these vanish a threshold begins or ends.
    ends = [x for other in ("kinematic_constraint", "negative_damping") for x in place_values(drive, other, unknown)]

    def gap(value: float) -> float | None:
        with suppress(InputError, EngineError):
            left = float(_start(name, drive.replace(**{unknown: zero_if_close(unknown, value)}))[0])
            return left if math.isfinite(left) else None
        return None

    for place in crossings(gap, samples(drive, unknown, ends), 1e-11):
        value = zero_if_close(unknown, place)
        near = drive.replace(**{unknown: value})
        with suppress(Singular, NoThreshold):  # a jump of the gap, not a root
            found.append(newton(near, unknown, _start(name, near)[1], value))
    span, why = f"within {DECADES} decades of the drive's own value", ""
    if not found:
        try:
            _start(name, drive)
        except (InputError, EngineError) as error:
            why = f"; at its own value, {str(error).rstrip('.')}"
    reason = (
        f"no {unknown} {span} makes axial_force = {drive.axial_force:g} the threshold {name}, with all other "
        f"parameters fixed{why}."
    )
    return result(drive, name, unknown, found, f"All found by a search {span}; there may be others.", reason)


def _start(name: str, drive: Any) -> tuple[Any, Start]:
    """What is left of a threshold's equation at a drive, and where Newton's method starts."""
    with many_digits():
        start = STARTS[name](drive)
        return start.force - drive.axial_force * (1 if drive.input_speed > 0 else -1), start


def newton(drive: Drive, unknown: str, start: Start, guess: Any) -> ThresholdSolution:
    """Return the solution of a system of equations next to a guess; raises ``Singular`` where there is none."""
    words, system = equations(start.system, 1 if drive.input_speed > 0 else -1)
    return _solution(drive, unknown, solved(drive, unknown, system, guess, start.times), words)


def _solution(drive: Drive, unknown: str, root: Root, words: str) -> ThresholdSolution:
    unit = described(unknown)["unit"]

    def derivative(name: str, slope: arb) -> Derivative:
        # What is not distinguished from zero is zero: a threshold may not depend on what is in its equation.
        numbers = (0.0 if slope.contains(0) else float(slope), *outwards(slope))
        value, low, high = (x if math.isfinite(x) else None for x in numbers)
        return Derivative(value, _quotient(unit, described(name)["unit"]), low, high)

    slopes = {name: derivative(name, slope) for name, slope in root.derivatives.items()}
    return ThresholdSolution(float(root.unknown), outwards(root.unknown), slopes, words)


def _quotient(unit: str, by: str) -> str:
    """A unit over another one, as UDUNITS spells it."""
    powers: Counter[str] = Counter()
    for text, sign in ((unit, 1), (by, -1)):
        for name, power in re.findall(r"([A-Za-z]+)(-?\d*)", text):
            powers[name] += sign * int(power or 1)
    ordered = sorted(powers.items(), key=lambda item: item[1] < 0)  # what is below the line last
    return " ".join(f"{name}{n if n != 1 else ''}" for name, n in ordered if n) or "1"


def result(
    drive: Drive,
    name: str,
    unknown: str,
    found: Iterable[ThresholdSolution],
    how: str = "",
    reason: str = "",
    stable: StableSet | None = None,
) -> Threshold:
    """Return a threshold with the solutions that were found, or with the reason for none."""
    solutions = tuple(sorted(found, key=lambda solution: solution.value))
    return Threshold(
        name=name,
        parts=drive.parts,
        unknown=unknown,
        unit=described(unknown)["unit"],
        solutions=solutions,
        statement=TABLE[name].statement,
        how=how if solutions else "",
        reason="" if solutions else reason,
        stability="" if stable is None else "neutral" if stable.neutral else "asymptotic",
        stable_intervals=() if stable is None else stable.in_doubles(),
    )
