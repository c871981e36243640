"""The verdict as a dataset: the operating chart, margins, sensitivities, and the motions at middle and worst values."""

import json
from typing import Any

import numpy as np
import xarray as xr

from lsvib.assess.assessment import Assessment, Motion
from lsvib.assess.chart import KINDS, Chart
from lsvib.assess.uncertainty import BINS
from lsvib.assess.words import VERDICTS
from lsvib.data.attributes import attributes, yes_no

_REFERENCES = "Vahid-Araghi and Golnaraghi, Friction-Induced Vibration in Lead Screw Drives, Springer 2011, chapter 8"


def dataset(assessment: Assessment, charts: list[Chart]) -> xr.Dataset:
    """Return the dataset of an assessment; names of mechanisms, changes and entries stand in flags and attributes."""
    mechanisms = list(assessment.mechanisms)
    changes = sorted({row.quantity for one in assessment.mechanisms.values() for row in one.margins})
    variables: dict[str, Any] = {**_probabilities(assessment), **_margins(assessment, changes)}
    variables["reserve_counts"] = (
        ("mechanism", "class"),
        np.array([assessment.uncertainty.probability[name].counts for name in mechanisms], dtype=np.int64),
        attributes("1", "number of samples by reserve"),
    )
    variables["chart"] = (
        ("direction", "force", "speed"),
        np.stack([chart.kind for chart in charts]),
        {**attributes("1", "what occurs at a point of operation"), **_words(KINDS)},
    )
    coordinates = {
        "mechanism": _flagged("mechanism", "mechanism", mechanisms),
        "change": _flagged("change", "changed quantity", changes),
        "direction": ("direction", [chart.direction for chart in charts], attributes("1", "direction, 1 is outward")),
        "force": ("force", charts[0].force, attributes("N", "force against outward travel")),
        "speed": ("speed", charts[0].speed, attributes("m s-1", "speed of the load")),
        "class": ("class", 0.5 * (BINS[1:] + BINS[:-1]), attributes("1", "reserve, middle of its class")),
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
    found = assessment.mechanisms.values()
    return {
        "occurs": yes_no(
            "mechanism", [one.occurs for one in found], "whether the mechanism occurs at the middle values"
        ),
        "reserve": ("mechanism", [one.reserve for one in found], attributes("1", "lowest reserve in the window")),
        "probability": ("mechanism", [one.probability for one in found], attributes("1", "probability to occur")),
        "interval": (
            ("mechanism", "end"),
            [list(one.interval) for one in found],
            attributes("1", "confidence interval of the probability, 95 per cent"),
        ),
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
    return {
        "margin": (
            ("mechanism", "change"),
            factor,
            attributes("1", "factor on a quantity at which the verdict changes, missing if there is none"),
        ),
        "sensitivity": (
            ("mechanism", "change"),
            slope,
            attributes("1", "change of the reserve per relative change of a quantity"),
        ),
    }


def _words(names: Any) -> dict[str, Any]:
    return {"flag_values": np.arange(len(names), dtype=np.int8), "flag_meanings": " ".join(names)}


def _flagged(name: str, long_name: str, names: list[str]) -> tuple:
    return (name, np.arange(len(names), dtype=np.int8), {**attributes("1", long_name), **_words(names)})


def _motion(name: str, motion: Motion) -> tuple[tuple, dict[str, Any]]:
    """Time and samples of a motion; a motion that is not known has none."""
    moved, dimension = motion.vibration, f"{name}_time"
    where = {"nominal": "at the middle values", "worst": "in the worst case"}[name]
    variables = {
        f"{name}_deviation": (dimension, moved.deviation, attributes("m", f"deviation of the load {where}")),
        f"{name}_screw_speed": (dimension, moved.speed, attributes("rad s-1", f"speed of the screw {where}")),
        f"{name}_angle": (dimension, moved.angle, attributes("rad", f"angle deviation of the screw {where}")),
    }
    return (dimension, moved.time, attributes("s", f"time of the motion {where}")), variables
