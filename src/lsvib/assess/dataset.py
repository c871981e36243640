"""The verdict as a dataset: the operating chart, margins, sensitivities, and the motions at middle and worst values."""

import json
from typing import Any

import numpy as np
import xarray as xr

from lsvib.assess.assessment import AssessedMotion, Assessment
from lsvib.assess.margins import KINDS, Chart
from lsvib.assess.uncertainty import BINS
from lsvib.assess.words import VERDICTS
from lsvib.datasets.attributes import named_flags, named_index, variable, yes_no

_REFERENCES = "Vahid-Araghi and Golnaraghi, Friction-Induced Vibration in Lead Screw Drives, Springer 2011, chapter 8"


def dataset(assessment: Assessment, charts: list[Chart]) -> xr.Dataset:
    """Return the dataset of an assessment; names of mechanisms, changes and entries stand in flags and attributes."""
    mechanisms = list(assessment.mechanisms)
    changes = sorted({row.quantity for one in assessment.mechanisms.values() for row in one.margins})
    counts = [assessment.uncertainty.probability[name].counts for name in mechanisms]
    kinds, words = np.stack([chart.kind for chart in charts]), "what occurs at a point of operation"
    variables: dict[str, Any] = {
        **_probabilities(assessment),
        **_margins(assessment, changes),
        "reserve_counts": variable(
            ("mechanism", "class"), np.array(counts, dtype=np.int64), "1", "number of samples by reserve"
        ),
        "chart": named_flags(("direction", "force", "speed"), kinds, words, dict(enumerate(KINDS))),
    }
    directions, middles = [chart.direction for chart in charts], 0.5 * (BINS[1:] + BINS[:-1])
    coordinates = {
        "mechanism": named_index("mechanism", "mechanism", mechanisms),
        "change": named_index("change", "changed quantity", changes),
        "direction": variable("direction", directions, "1", "direction, 1 is outward"),
        "force": variable("force", charts[0].force, "N", "force against outward travel"),
        "speed": variable("speed", charts[0].speed, "m s-1", "speed of the load"),
        "class": variable("class", middles, "1", "reserve, middle of its class"),
    }
    for name, motion in (("nominal", assessment.nominal), ("worst", assessment.worst)):
        coordinates[f"{name}_time"], more = _motion(name, motion)
        variables |= more
    return xr.Dataset(
        variables,
        coordinates,
        attrs={
            "title": f"Assessment of a lead-screw drive: {assessment.sheet.name}",
            "source": "lsvib assess",
            "references": _REFERENCES,
            "verdict": f"{assessment.verdict}. {VERDICTS[assessment.verdict]}",
            "samples": assessment.uncertainty.samples,
            "seed": assessment.seed,
            "worst_case_scene": json.dumps(assessment.worst.vibration.scene),
        },
    )


def _probabilities(assessment: Assessment) -> dict[str, tuple]:
    """Whether each mechanism occurs at the middle values, with which reserve, and how probable it is."""
    found, dim = assessment.mechanisms.values(), "mechanism"
    ends = [list(one.interval) for one in found]
    return {
        "occurs": yes_no(dim, [one.occurs for one in found], "whether the mechanism occurs at the middle values"),
        "reserve": variable(dim, [one.reserve for one in found], "1", "lowest reserve in the window"),
        "probability": variable(dim, [one.probability for one in found], "1", "probability to occur"),
        "interval": variable((dim, "end"), ends, "1", "confidence interval of the probability, 95 per cent"),
    }


def _margins(assessment: Assessment, changes: list[str]) -> dict[str, tuple]:
    """Margin and sensitivity of each mechanism for each change of a quantity; missing where there is none."""
    factor = np.full((len(assessment.mechanisms), len(changes)), np.nan)
    slope = np.full_like(factor, np.nan)
    for k, one in enumerate(assessment.mechanisms.values()):
        for row in one.margins:
            at = changes.index(row.quantity)
            factor[k, at] = np.nan if row.factor is None else row.factor
            slope[k, at] = one.sensitivities.get(row.quantity, np.nan)
    dims, words = ("mechanism", "change"), "factor on a quantity at which the verdict changes, missing if there is none"
    return {
        "margin": variable(dims, factor, "1", words),
        "sensitivity": variable(dims, slope, "1", "change of the reserve per relative change of a quantity"),
    }


def _motion(name: str, motion: AssessedMotion) -> tuple[tuple, dict[str, Any]]:
    """Time and samples of a motion; a motion that is not known has none."""
    moved, dim = motion.vibration, f"{name}_time"
    where = {"nominal": "at the middle values", "worst": "in the worst case"}[name]
    variables = {
        f"{name}_deviation": variable(dim, moved.deviation, "m", f"deviation of the load {where}"),
        f"{name}_screw_speed": variable(dim, moved.speed, "rad s-1", f"speed of the screw {where}"),
        f"{name}_angle": variable(dim, moved.angle, "rad", f"angle deviation of the screw {where}"),
    }
    return variable(dim, moved.time, "s", f"time of the motion {where}"), variables
