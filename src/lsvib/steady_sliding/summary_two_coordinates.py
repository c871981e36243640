"""Linear stability of the models with two coordinates as plain values, ready for JSON."""

from collections.abc import Mapping
from typing import Any

from lsvib.drives.registry import find_model
from lsvib.steady_sliding import boundaries
from lsvib.steady_sliding.characteristic import scale
from lsvib.steady_sliding.linearised import steady_law
from lsvib.steady_sliding.said_of_models import condition, said_of
from lsvib.steady_sliding.spectrum import spectrum


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
    details = said_of(model, drive, law, polynomial, rates["flutter"])
    conditions = details.pop("conditions")
    conditions |= {name: condition(growth_rate=rate) for name, rate in rates.items()}
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
