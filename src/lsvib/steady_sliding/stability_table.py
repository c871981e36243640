"""Linear stability of a drive of any model as plain values, ready for JSON. Needs no engine."""

import sys
from collections.abc import Mapping
from typing import Any

from lsvib.drives.coefficients import coefficients
from lsvib.drives.parameters import RigidParameters, model_of, parameters_of
from lsvib.drives.registry import find_model
from lsvib.errors import InputError
from lsvib.steady_sliding.characteristic import scale
from lsvib.steady_sliding.conditions import conditions
from lsvib.steady_sliding.eigenvalues_rigid import Stability
from lsvib.steady_sliding.linearised import steady_law
from lsvib.steady_sliding.said_of_models import condition, said_of
from lsvib.steady_sliding.spectrum import rigid_spectrum, spectrum


def stability_table(changes: RigidParameters | Mapping[str, Any] | None = None, model: str = "rigid") -> dict[str, Any]:
    """Linear stability of steady sliding of a drive: one given as such, or the default one of a model with ``changes``.

    A drive is of its own ``model``. Returns ``stable`` (asymptotically), ``class``, ``eigenvalues`` [1/s] in ascending
    real part, the ``steady_law`` s_0, and ``conditions`` of instability: margins of inequalities, each holding where
    positive, and whether all ``hold``.

    Of the rigid drive (eqs 8.18–8.21) the class is one of :class:`Stability`, in lower case, and the conditions are
    those of :func:`conditions`; there are also the effective coefficients of both laws, the steady deflection z_0 [rad]
    and whether Γ₊ ≤ 0 (``paradox_region``). With a negative effective inertia steady sliding is unstable by Lemma 8.1,
    whatever its eigenvalues.

    Of the others (Sect. 5.5; 5.6, eqs 8.23–8.32; 5.8, eq. 8.33) the class is that of :func:`spectrum`, and steady
    sliding is unstable exactly if a condition holds: ``divergence`` if a real eigenvalue is positive, ``flutter`` if a
    complex pair grows, the others say why. There are also ``model``, ``characteristic_polynomial`` (of s, highest power
    first) and ``quantities`` with ``value`` (None where there is none) and ``unit``; what the chapter says of the
    undamped drive with axial support stands apart, under ``without_damping``.

    Raises ``InputError`` for an unknown model, unacceptable parameters, or a contact that carries no force.
    """
    model, changes = model_of(changes, model), parameters_of(changes)
    if model == "rigid":
        return _of_rigid(RigidParameters.of(changes))
    return _of_two_coordinates(find_model(model).drive.of(changes))


def _of_rigid(drive: RigidParameters) -> dict[str, Any]:
    c = coefficients(drive)
    if c.net_force == 0:
        raise InputError(
            "axial_force balances the translation damping exactly, so the contact carries no force and no law holds."
        )
    kind, pair = rigid_spectrum(drive, c)
    if abs(c.deflection) > sys.float_info.max:
        raise InputError("These parameters give a steady deflection beyond 1.8e308 rad, the range of doubles.")
    return {
        "stable": kind in (Stability.STABLE_NODE, Stability.STABLE_FOCUS),
        "class": kind.name.lower(),
        "eigenvalues": [{"real": x.real, "imaginary": x.imag} for x in pair],
        "steady_law": c.steady_law,
        "effective_inertia": {"plus": float(c.gamma[1]), "minus": float(c.gamma[-1]), "unit": "kg m2"},
        "effective_damping": {"plus": float(c.damping[1]), "minus": float(c.damping[-1]), "unit": "N m s rad-1"},
        "steady_deflection": {"value": float(c.deflection), "unit": "rad"},
        "paradox_region": c.paradox,
        "conditions": conditions(drive),
    }


def _of_two_coordinates(drive: RigidParameters) -> dict[str, Any]:
    law = steady_law(drive)
    kind, values, exact = spectrum(drive, law)
    factor = scale(drive, law)
    polynomial = tuple(p / factor for p in exact)
    rates = {
        "divergence": max((x.real for x in values if x.imag == 0 < x.real), default=None),
        "flutter": max((x.real for x in values if x.imag != 0 < x.real), default=None),
    }
    details = said_of(drive.model, drive, law, polynomial, rates["flutter"])
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
