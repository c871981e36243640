"""Linear stability of a drive of any model as plain values, ready for JSON. Needs no engine."""

from collections.abc import Mapping
from typing import Any

from lsvib.models.drive import Drive, model_of, parameters_of
from lsvib.models.model import find_model, of_model
from lsvib.stability import stability_of_models
from lsvib.stability.linear import steady_law
from lsvib.stability.spectrum import scale, spectrum
from lsvib.stability.stability_of_models import condition


def stability_table(changes: Drive | Mapping[str, Any] | None = None, model: str = "rigid") -> dict[str, Any]:
    """Linear stability of steady sliding of a drive: one given as such, or the default one of a model with ``changes``.

    A drive is of its own ``model``. Returns ``stable`` (asymptotically), ``class``, ``eigenvalues`` [1/s] in ascending
    real part, the ``steady_law`` s_0, and ``conditions`` of instability: margins of inequalities, each holding where
    positive, and whether all ``hold``.

    Of the rigid drive (eqs 8.18–8.21) the class is one of :class:`~lsvib.stability.linear.Stability`,
    in lower case, and the conditions are those of :func:`~lsvib.stability.conditions.conditions`; there are also
    the effective coefficients of both laws, the steady deflection z_0 [rad] and whether Γ₊ ≤ 0 (``paradox_region``).
    With a negative effective inertia steady sliding is unstable by Lemma 8.1, whatever its eigenvalues.

    Of the others (Sect. 5.5; 5.6, eqs 8.23–8.32; 5.8, eq. 8.33) the class is that of :func:`spectrum`, and steady
    sliding is unstable exactly if a condition holds: ``divergence`` if a real eigenvalue is positive, ``flutter`` if a
    complex pair grows, the others say why. There are also ``model``, ``characteristic_polynomial`` (of s, highest power
    first) and ``quantities`` with ``value`` (None where there is none) and ``unit``; what the chapter says of the
    undamped drive with axial support stands apart, under ``without_damping``.

    Raises ``InputError`` for an unknown model, unacceptable parameters, or a contact that carries no force.
    """
    model, changes = model_of(changes, model), parameters_of(changes)
    drive = find_model(model).drive.of(changes)
    table: dict[str, Any] = of_model(stability_of_models, model, "stability", _by_eigenvalues)(drive)
    return table


def _by_eigenvalues(drive: Drive) -> dict[str, Any]:
    law = steady_law(drive)
    kind, values, exact = spectrum(drive, law)
    factor = scale(drive, law)
    polynomial = tuple(p / factor for p in exact)
    rates = {
        "divergence": max((x.real for x in values if x.imag == 0 < x.real), default=None),
        "flutter": max((x.real for x in values if x.imag != 0 < x.real), default=None),
    }
    details = of_model(stability_of_models, drive.model, "said", _nothing)(drive, law, polynomial, rates["flutter"])
    growth = {name: condition(growth_rate=rate) for name, rate in rates.items()}
    return {
        "model": drive.model,
        "stable": kind == "stable",
        "class": kind,
        "eigenvalues": [{"real": x.real, "imaginary": x.imag} for x in values],
        "steady_law": law,
        "characteristic_polynomial": [float(p) for p in polynomial],
        "conditions": details.pop("conditions") | growth,
        **details,
    }


def _nothing(*_: Any) -> dict[str, Any]:
    """What there is to say of a model without a file of its own."""
    return {"conditions": {}, "quantities": {}}
