"""The verdict on one data sheet as plain values for JSON."""

from typing import Any

import numpy as np

from lsvib.assess.assessment import AssessedMotion, Assessment
from lsvib.assess.drive import UNITS
from lsvib.assess.margins import Margin
from lsvib.assess.words import VERDICTS

_OF_VIBRATION = ("model", "attractor", "vibrates", "frequency", "audible", "amplitude")


def as_json(assessment: Assessment) -> dict[str, Any]:
    """Return the verdict as plain values for JSON: SI units, None for what does not exist or is infinite."""
    pushed = assessment.mechanisms["push_needed"]
    return {
        "name": assessment.sheet.name,
        "verdict": assessment.verdict,
        "sentence": VERDICTS[assessment.verdict],
        "self_locking": assessment.self_locking,
        "self_locking_probability": assessment.uncertainty.holds.value,
        "efficiency": {**assessment.efficiency, "lifting_range": list(assessment.uncertainty.lifting)},
        "mechanisms": {
            name: {
                "occurs": one.occurs,
                "probability": one.probability,
                "interval": list(one.interval),
                "reserve": one.reserve,
                "at": _place(one.corner),
                "margin": _margins_json(one.margins),
                "sensitivity": one.sensitivities,
            }
            for name, one in assessment.mechanisms.items()
            if name != "push_needed"
        },
        "after_a_push": {
            "possible": pushed.occurs,
            "probability": pushed.probability,
            "interval": list(pushed.interval),
        },
        "quantities": {key: {"value": value, "unit": UNITS[key]} for key, value in assessment.values.items()},
        "samples": assessment.uncertainty.samples,
        "seed": assessment.seed,
        "any_mechanism": {
            "probability": assessment.uncertainty.any.value,
            "interval": list(assessment.uncertainty.any.interval),
            "margin": _margins_json(assessment.margins),
        },
        "sobol": {"first_order": assessment.uncertainty.first_order, "total": assessment.uncertainty.total},
        "nominal": _motion_json(assessment.nominal),
        "worst_case": _motion_json(assessment.worst),
        "assumptions": dict(assessment.sheet.assumptions),
        "sources": dict(assessment.sheet.sources),
    }


def _place(corner: tuple[int, float, float]) -> dict[str, float]:
    return dict(zip(("direction", "screw_speed", "force"), corner, strict=True))


def _margins_json(rows: list[Margin]) -> dict[str, Any]:
    return {row.quantity: {"factor": row.factor, "value": row.value, "unit": UNITS[row.quantity]} for row in rows}


def _motion_json(motion: AssessedMotion) -> dict[str, Any]:
    moved, (push, sentence) = motion.vibration, motion.push
    return {
        "mechanism": motion.mechanism,
        "entries": motion.entries,
        "at": _place(motion.corner),
        **{name: getattr(moved, name) for name in _OF_VIBRATION},
        "load_speed": moved.load_speed and list(moved.load_speed),
        "screw_speed": moved.screw_speed and list(moved.screw_speed),
        "peak_contact_force": moved.peak_force,
        "peak_impulse": moved.impulse,
        "reason": moved.reason,
        "scene": moved.scene,
        "survived_push": None if push is None or not np.isfinite(push) else push,
        "survived_push_sentence": sentence,
    }
