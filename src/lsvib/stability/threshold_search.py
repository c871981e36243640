"""A threshold of the axial force as one of any other parameter: where it equals the force of the drive.

Such an equation is transcendental, so its roots are searched for, not isolated: its sign is sampled over twelve decades
about the drive's own value (or a natural size, if that is zero), closer and closer towards the places at which Γ₊ and
C₊ vanish – there a threshold begins or ends, and these places are exact –, and where a threshold begins or ends between
two samples that place is halved down. So is every change of sign.
What lies between two samples without a change of sign, or beyond the twelve decades, stays unseen.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import pairwise
from typing import Any

from lsvib.dynamics.forward_slip import bracketed_root
from lsvib.errors import EngineError, InputError, NoThreshold
from lsvib.models.drive import Drive, zero_if_close
from lsvib.stability.boundaries import allowed, places

DECADES = 6  # on both sides of the middle of the search
_EACH = 12  # samples a decade: a fifth from one to the next
_CLOSER = tuple(0.3**k for k in range(1, 16))  # of the way to a place where a threshold begins or ends, to 1e-8
_HALVINGS = 30  # of the step from a sample with a threshold to one without: to 1e-9 of it
_CLOSE = 1e-11  # relative, of a root: Newton's method goes on from there

Sample = tuple[float, float | None]
"""A value of the parameter and the gap there, None where there is none."""
Gap = Callable[[Drive], float]
"""A function that vanishes at a threshold; raises ``InputError`` or ``EngineError`` for a drive that has none."""


def changes(drive: Drive, unknown: str, gap: Gap) -> Iterator[float]:
    """Yield the values of a parameter, in ascending order, at which the sign of a gap changes, each to 1e-11 of it.

    A jump through zero is among them.
    """

    def defined(value: float) -> float:
        """Return the gap at a value of the parameter."""
        found = gap(drive.replace(**{unknown: zero_if_close(type(drive), unknown, value)}))
        if not math.isfinite(found):
            raise NoThreshold
        return found

    def at(value: float) -> float | None:
        """Return the gap at a value of the parameter; None where there is none."""
        with suppress(InputError, EngineError):
            return defined(value)
        return None

    known: list[Sample] = [(value, at(value)) for value in samples(drive, unknown)]
    ordered = known[:1]
    for before, after in pairwise(known):
        if (before[1] is None) != (after[1] is None):
            ordered.append(_edge(at, before, after))
        ordered.append(after)
    for before, after in pairwise(ordered):
        if before[1] is not None and after[1] is not None and (before[1] > 0) != (after[1] > 0):
            with suppress(InputError, EngineError):  # it is not defined somewhere on the way
                root = float(bracketed_root(defined, before[0], after[0], _CLOSE))
                yield zero_if_close(type(drive), unknown, root)


def _edge(at: Callable[[float], float | None], before: Sample, after: Sample) -> Sample:
    """The last place at which the gap is defined between two samples of which one is not."""
    inside, outside = (before, after) if before[1] is not None else (after, before)
    for _ in range(_HALVINGS):
        middle = 0.5 * (inside[0] + outside[0])
        found = at(middle)
        if found is None:
            outside = middle, None
        else:
            inside = middle, found
    return inside


def samples(drive: Drive, unknown: str) -> list[float]:
    """Return the values of a parameter at which the gap is looked at, in ascending order, all of them allowed."""
    middle = abs(getattr(drive, unknown)) or _natural(drive, unknown)
    sizes = [middle * 10.0 ** (k / _EACH) for k in range(-DECADES * _EACH, DECADES * _EACH + 1)]
    signs = (-1, 1) if unknown in ("axial_force", "input_speed") else (1,)
    values = {sign * size for sign in signs for size in sizes}
    for name in ("kinematic_constraint", "negative_damping"):
        for place in places(drive, name, unknown) or []:
            end = float(place.value)
            values |= {end * (1 + side * part) for side in (-1, 1) for part in _CLOSER}
    return sorted(value for value in values if allowed(drive, unknown, value))


def _natural(drive: Drive, unknown: str) -> float:
    """A size of a parameter that may be zero, from the others, in its SI unit."""
    rate = math.sqrt(drive.coupling_stiffness / drive.screw_inertia)  # 1/s
    lever = drive.pitch_radius * math.tan(drive.lead_angle)  # m
    sizes: dict[str, Any] = {
        "support_damping": drive.screw_inertia * rate,
        "translation_damping": drive.screw_inertia * rate / lever / lever,
        "axial_force": drive.mass * lever * rate * abs(drive.input_speed),
        "friction_coefficient": math.tan(drive.lead_angle),
    }
    return float(sizes[unknown])
