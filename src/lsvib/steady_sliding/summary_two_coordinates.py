"""Linear stability of the models with two coordinates as plain values, ready for JSON."""

from collections.abc import Callable, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np

from lsvib.drives.coefficients import coefficients
from lsvib.drives.linear_parts import Polynomial
from lsvib.drives.parameters import NutParameters, SupportParameters, ThreadsParameters
from lsvib.drives.registry import find_model
from lsvib.steady_sliding import boundaries, nut_conditions, stiff_contact, support_conditions
from lsvib.steady_sliding.characteristic import scale
from lsvib.steady_sliding.conditions import critical_friction
from lsvib.steady_sliding.linearised import steady_law
from lsvib.steady_sliding.spectrum import neutral_margins, spectrum

_UNDAMPED = dict.fromkeys(("support_damping", "translation_damping", "axial_support_damping"), 0.0)


def model_threshold_table(model: str, changes: Mapping[str, Any] | None = None) -> dict[str, dict[str, Any]]:
    """Boundaries of stability of steady sliding in a model with two coordinates, its default drive with ``changes``.

    ``model``: ``threads``, ``support`` or ``nut``. Returns ``critical_mass``, ``critical_friction`` and the least of
    the model's own damping, ``least_contact_damping``, ``least_axial_support_damping`` or ``least_nut_damping``, each
    as :func:`lsvib.steady_sliding.boundaries.threshold_of`. Raises ``InputError`` for an unknown model, unacceptable
    parameters, or a contact that carries no force.
    """
    return boundaries.model_thresholds(_drive(model, changes))


def model_stability_table(model: str, changes: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Linear stability of steady sliding in a model with two coordinates, its default drive with ``changes``.

    ``model``: ``threads`` (Sect. 5.5), ``support`` (5.6, eqs 8.23–8.32) or ``nut`` (5.8, eq. 8.33). Returns ``model``,
    ``stable`` (asymptotically), ``class`` (:func:`lsvib.steady_sliding.spectrum.spectrum`), the four ``eigenvalues``
    [1/s] in ascending real part, the ``steady_law`` s_0, ``characteristic_polynomial`` (of s, highest power first),
    ``conditions`` of instability – margins of inequalities, each holding where positive, and whether all ``hold`` – and
    ``quantities`` with ``value`` (None where there is none) and ``unit``. Steady sliding is unstable exactly if one of
    the conditions holds: ``divergence`` if a real eigenvalue is positive, ``flutter`` if a complex pair grows, the
    others say why. What the chapter says of the undamped drive with axial support stands apart, under
    ``without_damping``. Raises ``InputError`` for an unknown model, unacceptable parameters, or a contact that carries
    no force.
    """
    drive = _drive(model, changes)
    law = steady_law(drive)
    kind, values, exact = spectrum(drive, law)
    factor = scale(drive, law)
    polynomial = tuple(p / factor for p in exact)
    rates = {
        "divergence": max((x.real for x in values if x.imag == 0 < x.real), default=None),
        "flutter": max((x.real for x in values if x.imag != 0 < x.real), default=None),
    }
    said = _DETAILS.get(model)
    details = said(drive, law, polynomial, rates["flutter"]) if said else {"conditions": {}, "quantities": {}}
    conditions = details.pop("conditions")
    conditions |= {name: _condition(growth_rate=rate) for name, rate in rates.items()}
    return {
        "model": model,
        "stable": kind == "stable",
        "class": kind,
        "eigenvalues": [{"real": x.real, "imaginary": x.imag} for x in values],
        "steady_law": law,
        "characteristic_polynomial": [float(p) for p in polynomial],
        "conditions": conditions,
        **details,
    }


def _drive(model: str, changes: Mapping[str, Any] | None) -> Any:
    return find_model(model).drive.of(changes)


def _threads(drive: ThreadsParameters, law: int, polynomial: Polynomial, flutter: float | None) -> dict[str, Any]:
    c = coefficients(drive)
    damped = boundaries.stable_set(drive, "contact_damping").intervals
    least = damped[0][0] if damped else None
    missing = None if least is None else least - Fraction(drive.contact_damping)
    return {
        "conditions": {
            # Lemma 8.1 at the stiffness of this very contact: p_2 < 0.
            "negative_inertia": _condition(
                negative_effective_inertia=-c.gamma[law], negative_coefficient_of_s2=-polynomial[2]
            ),
            "contact_flutter": _condition(missing_contact_damping=missing, growth_rate=flutter),
        },
        "quantities": {
            "effective_inertia": _quantity(c.gamma[law], "kg m2"),
            "effective_damping": _quantity(c.damping[law], "N m s rad-1"),
            "unstable_contact_stiffness": _quantity(stiff_contact.unstable_contact_stiffness(drive), "N m-1"),
            "least_contact_damping": _quantity(least, "N s m-1"),
            "least_damping_of_stiff_contact": _quantity(stiff_contact.least_damping_of_stiff_contact(drive), "N s m-1"),
        },
    }


def _support(drive: SupportParameters, law: int, polynomial: Polynomial, flutter: float | None) -> dict[str, Any]:
    inertia = support_conditions.reduced_inertia(drive, law, exact=True)
    undamped = drive.replace(**_UNDAMPED)
    undamped_class, _, undamped_polynomial = spectrum(undamped, law)
    a_4, minus_a_2, discriminant = neutral_margins(tuple(p / scale(drive, law) for p in undamped_polynomial))
    lower, upper = (float(x) if np.isfinite(x) else None for x in support_conditions.flutter_boundaries(drive, law))
    return {
        "conditions": {"kinematic": _condition(negative_reduced_inertia=-inertia)},
        "quantities": {
            "reduced_inertia": _quantity(inertia, "kg m2"),
            "reduced_mass": _quantity(drive.mass * drive.screw_mass / (drive.mass + drive.screw_mass), "kg"),
            "kinematic_friction": _quantity(critical_friction(drive, drive.screw_mass) if law > 0 else None, "1"),
        },
        "without_damping": {
            "class": undamped_class,
            "conditions": {
                "divergence": _condition(positive_a_4=a_4, positive_a_2=-minus_a_2),
                "mode_coupling": _condition(negative_discriminant=-discriminant),
            },
            "quantities": {
                "lower_flutter_stiffness": _quantity(lower, "N m-1"),
                "upper_flutter_stiffness": _quantity(upper, "N m-1"),
            },
        },
    }


def _nut(drive: NutParameters, law: int, polynomial: Polynomial, flutter: float | None) -> dict[str, Any]:
    inertia = nut_conditions.kinematic_inertia(drive, law, exact=True)
    return {
        "conditions": {"kinematic": _condition(negative_effective_inertia=-inertia)},
        "quantities": {
            "kinematic_inertia": _quantity(inertia, "kg m2"),
            "effective_screw_inertia": _quantity(nut_conditions.effective_screw_inertia(drive, exact=True), "kg m2"),
            "kinematic_mass": _quantity(nut_conditions.kinematic_mass(drive) if law > 0 else None, "kg"),
        },
    }


# What the chapter says of a model beyond its eigenvalues; of a model that is not among them it says nothing.
_DETAILS: dict[str, Callable[..., dict[str, Any]]] = {"threads": _threads, "support": _support, "nut": _nut}


def _condition(**margins: Decimal | Fraction | float | None) -> dict[str, Any]:
    """Missing margins are omitted; a condition holds where all its margins exist and are positive."""
    known = {name: float(value) for name, value in margins.items() if value is not None}
    return {"margins": known, "hold": all(value is not None and value > 0 for value in margins.values())}


def _quantity(value: Decimal | Fraction | float | None, unit: str) -> dict[str, Any]:
    return {"value": None if value is None else float(value), "unit": unit}
