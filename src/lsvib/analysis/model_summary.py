"""Linear stability of the models with two coordinates as plain values, ready for JSON."""

from collections.abc import Callable, Mapping
from decimal import Decimal
from typing import Any

import numpy as np

from lsvib.analysis import modes, nut, support, threads
from lsvib.analysis.conditions import critical_friction
from lsvib.analysis.modes import Mode
from lsvib.errors import InputError
from lsvib.models import linear
from lsvib.models.coefficients import coefficients
from lsvib.models.parameters import LeadScrew, NutDrive, SupportDrive, ThreadsDrive

_MODELS: dict[str, tuple[type[LeadScrew], Callable[..., linear.LinearModel]]] = {
    "threads": (ThreadsDrive, linear.threads_model),
    "support": (SupportDrive, linear.support_model),
    "nut": (NutDrive, linear.nut_model),
}


def model_stability_table(model: str, changes: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Linear stability of steady sliding in a model with two coordinates, its default drive with ``changes``.

    ``model``: ``threads`` (Sect. 5.5), ``support`` (5.6, eqs 8.23–8.32) or ``nut`` (5.8, eq. 8.33). Returns ``model``,
    ``stable``, ``class`` (:class:`Mode`, lower case), the four ``eigenvalues`` [1/s] in ascending real part, the
    ``steady_law`` s_0, ``characteristic_polynomial`` (of s, highest power first), ``conditions`` – margins of the
    inequalities, each holding where positive, and whether all ``hold`` – and ``quantities`` with ``value`` (None where
    there is none) and ``unit``. ``stable`` is decided by the Routh–Hurwitz conditions in 50 digits; a drive without any
    damping counts as stable if all its frequencies are real. Raises ``InputError`` for an unknown model, unacceptable
    parameters, or a singular mass matrix.
    """
    if model not in _MODELS:
        raise InputError(f"model = {model!r} is not one of {', '.join(_MODELS)}.")
    kind, build = _MODELS[model]
    drive = kind.of(changes or {})
    law = linear.steady_law(drive)
    exact, floating = build(drive, law, exact=True), build(drive, law)
    polynomial = exact.polynomial()
    if polynomial[0] == 0 or linear.determinant(floating.mass) == 0:
        raise InputError(f"The mass matrix of model {model} is singular for these parameters: no eigenvalues exist.")
    values = modes.eigenvalues(floating)
    mode = _class(exact, floating, polynomial, values)
    return {
        "model": model,
        "stable": mode is Mode.STABLE,
        "class": mode.name.lower(),
        "eigenvalues": [{"real": float(x.real), "imaginary": float(x.imag)} for x in values],
        "steady_law": law,
        "characteristic_polynomial": [float(p) for p in polynomial],
        **_DETAILS[model](drive, law),
    }


def _class(exact: linear.LinearModel, floating: linear.LinearModel, polynomial: tuple, values: np.ndarray) -> Mode:
    if all(x == 0 for row in exact.damping for x in row):
        return Mode(int(modes.undamped_class(floating)))
    if polynomial[0] < 0:
        return Mode.KINEMATIC
    if modes.routh_hurwitz(polynomial):
        return Mode.STABLE
    return Mode.DIVERGENCE if values[-1].imag == 0 else Mode.FLUTTER


def _threads(drive: ThreadsDrive, law: int) -> dict[str, Any]:
    c = coefficients(drive)
    limit = threads.least_contact_damping(drive)
    return {
        "conditions": {
            "negative_inertia": _condition(negative_effective_inertia=-c.gamma[law]),
            "contact_flutter": _condition(
                missing_contact_damping=None if limit is None else limit - drive.contact_damping
            ),
        },
        "quantities": {
            "effective_inertia": _quantity(c.gamma[law], "kg m2"),
            "effective_damping": _quantity(c.damping[law], "N m s rad-1"),
            "unstable_contact_stiffness": _quantity(threads.unstable_contact_stiffness(drive), "N m-1"),
            "least_contact_damping": _quantity(limit, "N s m-1"),
        },
    }


def _support(drive: SupportDrive, law: int) -> dict[str, Any]:
    a_4, a_2, a_0 = support.characteristic_polynomial(drive, law, exact=True)
    lower, upper = (float(x) if np.isfinite(x) else None for x in support.flutter_boundaries(drive, law))
    inertia = support.reduced_inertia(drive, law, exact=True)
    return {
        "conditions": {
            "kinematic": _condition(negative_reduced_inertia=-inertia),
            "divergence": _condition(positive_a_4=a_4, positive_a_2=a_2),
            "mode_coupling": _condition(negative_discriminant=4 * a_0 * a_4 - a_2**2),
        },
        "quantities": {
            "reduced_inertia": _quantity(inertia, "kg m2"),
            "reduced_mass": _quantity(drive.mass * drive.screw_mass / (drive.mass + drive.screw_mass), "kg"),
            "critical_friction": _quantity(critical_friction(drive, drive.screw_mass), "1"),
            "critical_friction_by_eigenvalues": _quantity(support.critical_friction_by_eigenvalues(drive), "1"),
            "lower_flutter_stiffness": _quantity(lower, "N m-1"),
            "upper_flutter_stiffness": _quantity(upper, "N m-1"),
        },
    }


def _nut(drive: NutDrive, law: int) -> dict[str, Any]:
    inertia = nut.kinematic_inertia(drive, law, exact=True)
    return {
        "conditions": {"kinematic": _condition(negative_effective_inertia=-inertia)},
        "quantities": {
            "kinematic_inertia": _quantity(inertia, "kg m2"),
            "effective_screw_inertia": _quantity(nut.effective_screw_inertia(drive, exact=True), "kg m2"),
            "critical_mass": _quantity(nut.critical_mass(drive), "kg"),
        },
    }


_DETAILS: dict[str, Callable[..., dict[str, Any]]] = {"threads": _threads, "support": _support, "nut": _nut}


def _condition(**margins: Decimal | float | None) -> dict[str, Any]:
    """A condition holds where all its margins are positive; a margin that does not exist is left out and holds not."""
    known = {name: float(value) for name, value in margins.items() if value is not None}
    return {"margins": known, "hold": all(value > 0 for value in known.values()) and bool(known)}


def _quantity(value: Decimal | float | None, unit: str) -> dict[str, Any]:
    return {"value": None if value is None else float(value), "unit": unit}
