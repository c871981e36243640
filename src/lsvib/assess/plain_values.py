"""The verdict on one data sheet as plain values for JSON."""

from typing import Any

import numpy as np

from lsvib.assess.assessment import Assessment, Motion
from lsvib.assess.drive import QUANTITIES
from lsvib.assess.margins import Margin
from lsvib.assess.words import VERDICTS


def as_json(assessment: Assessment) -> dict[str, Any]:
    """Return the verdict as plain values for JSON: SI units, None for what does not exist or is infinite."""
    units = {key: unit for key, (_, unit) in QUANTITIES.items()} | {"force": "N", "speed": "rad s-1"}
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
                "at": {"direction": one.corner[0], "screw_speed": one.corner[1], "force": one.corner[2]},
                "margin": _margins_json(one.margins, units),
                "sensitivity": one.sensitivities,
            }
            for name, one in assessment.mechanisms.items()
            if name != "push_needed"
        },
        "after_a_push": {
            "possible": assessment.mechanisms["push_needed"].occurs,
            "probability": assessment.mechanisms["push_needed"].probability,
            "interval": list(assessment.mechanisms["push_needed"].interval),
        },
        "quantities": {key: {"value": value, "unit": units[key]} for key, value in assessment.values.items()},
        "samples": assessment.uncertainty.samples,
        "seed": assessment.seed,
        "any_mechanism": {
            "probability": assessment.uncertainty.any.value,
            "interval": list(assessment.uncertainty.any.interval),
            "margin": _margins_json(assessment.margins, units),
        },
        "sobol": {"first_order": assessment.uncertainty.first_order, "total": assessment.uncertainty.total},
        "nominal": _motion_json(assessment.nominal),
        "worst_case": _motion_json(assessment.worst),
        "assumptions": dict(assessment.sheet.assumptions),
        "sources": dict(assessment.sheet.sources),
    }


def _margins_json(rows: list[Margin], units: dict[str, str]) -> dict[str, Any]:
    return {row.quantity: {"factor": row.factor, "value": row.value, "unit": units[row.quantity]} for row in rows}


def _motion_json(motion: Motion) -> dict[str, Any]:
    moved, (push, sentence) = motion.vibration, motion.push
    return {
        "mechanism": motion.mechanism,
        "entries": motion.entries,
        "at": {"direction": motion.corner[0], "screw_speed": motion.corner[1], "force": motion.corner[2]},
        "model": moved.model,
        "attractor": moved.attractor,
        "vibrates": moved.vibrates,
        "frequency": moved.frequency,
        "audible": moved.audible,
        "amplitude": moved.amplitude,
        "load_speed": None if moved.load_speed is None else list(moved.load_speed),
        "screw_speed": None if moved.screw_speed is None else list(moved.screw_speed),
        "peak_contact_force": moved.peak_force,
        "peak_impulse": moved.impulse,
        "reason": moved.reason,
        "scene": moved.scene,
        "survived_push": None if push is None or not np.isfinite(push) else push,
        "survived_push_sentence": sentence,
    }
