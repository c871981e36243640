"""Linear stability of a drive of any model as plain values, ready for JSON. Needs no engine."""

import sys
from collections.abc import Mapping
from typing import Any

from lsvib.drives.coefficients import coefficients
from lsvib.drives.parameters import RigidParameters, model_of, parameters_of
from lsvib.errors import InputError
from lsvib.steady_sliding.conditions import conditions
from lsvib.steady_sliding.eigenvalues_rigid import Stability
from lsvib.steady_sliding.spectrum import rigid_spectrum
from lsvib.steady_sliding.summary_two_coordinates import model_stability_table


def stability_table(changes: RigidParameters | Mapping[str, Any] | None = None, model: str = "rigid") -> dict[str, Any]:
    """Linear stability of steady sliding (eqs 8.18–8.21) of a drive: one given as such, or Table 8.1 with ``changes``.

    A drive is of its own ``model``. For another than the rigid one see
    :func:`lsvib.steady_sliding.summary_two_coordinates.model_stability_table`. Returns ``stable`` (asymptotically),
    ``class`` (:class:`Stability`, lower case), ``eigenvalues`` [1/s], the ``steady_law`` s_0, the effective
    coefficients of both laws, the steady deflection z_0 [rad], whether Γ₊ ≤ 0 (``paradox_region``), and the
    ``conditions`` of :func:`conditions`. With a negative effective inertia steady sliding is unstable by Lemma 8.1,
    whatever its eigenvalues.
    """
    model, changes = model_of(changes, model), parameters_of(changes)
    if model != "rigid":
        return model_stability_table(model, changes)
    drive = RigidParameters.of(changes)
    c = coefficients(drive)
    law = c.steady_law
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
        "steady_law": law,
        "effective_inertia": {"plus": float(c.gamma[1]), "minus": float(c.gamma[-1]), "unit": "kg m2"},
        "effective_damping": {"plus": float(c.damping[1]), "minus": float(c.damping[-1]), "unit": "N m s rad-1"},
        "steady_deflection": {"value": float(c.deflection), "unit": "rad"},
        "paradox_region": c.paradox,
        "conditions": conditions(drive),
    }
