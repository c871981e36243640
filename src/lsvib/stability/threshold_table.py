"""Thresholds of a drive as plain values, ready for JSON."""

from collections.abc import Mapping
from typing import Any

from lsvib.models.drive import Drive, model_of, parameters_of
from lsvib.models.model import find_model, of_model
from lsvib.stability import thresholds_of_models
from lsvib.stability.boundaries import model_thresholds


def threshold_table(
    changes: Drive | Mapping[str, Any] | None = None, model: str = "rigid"
) -> dict[str, dict[str, Any]]:
    """Compute the chapter's thresholds, each for the chapter's own drive with ``changes`` to its parameters.

    A drive in place of ``changes`` stands for itself: all its parameters count, and it is of its own model. For another
    ``model`` than the rigid one see :func:`lsvib.stability.boundaries.model_thresholds`. The chapter's critical
    friction, alone among its thresholds, is that of a drive with axial support (8.28): for it alone a change of
    ``screw_mass`` counts, and ``by_eigenvalues`` is the same threshold as the root of an eigenvalue. That of a rigid
    drive that stands for itself is where its own Γ₊ vanishes (8.20). Returns by name: ``value`` and ``unit``, the
    chapter's ``expected`` value with ``tolerance``, ``relative_error`` and whether it ``passed`` – all four None if
    ``changes`` leave the chapter's parameters or, as for ``global_stability_force``, the chapter prints no number –,
    ``reason`` if there is no such threshold (value None), and for forces the ``statement`` that they divide, for Ω > 0.
    Raises ``InputError`` for unacceptable parameters.
    """
    itself = isinstance(changes, Drive)
    model, changes = model_of(changes, model), parameters_of(changes)
    kind, thresholds = find_model(model).drive, of_model(thresholds_of_models, model, "thresholds", None)
    if thresholds is None:
        return model_thresholds(kind.of(changes))
    table: dict[str, dict[str, Any]] = thresholds(changes, itself)
    return table


def without_effect(model: str) -> Mapping[str, str]:
    """Return the parameters of which a change moves none of these thresholds, each with the reason."""
    find_model(model)
    reasons: Mapping[str, str] = of_model(thresholds_of_models, model, "WITHOUT_EFFECT", {})
    return reasons
