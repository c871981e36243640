"""The worst case of each family that a search found, for the dataset of the sweeps."""

from typing import Any

import numpy as np

from lsvib.bench.sweeps.case_judge import VERDICTS
from lsvib.bench.sweeps.worst_case import Tried
from lsvib.data.attributes import flagged, variable


def worst_cases(worst: list[Tried]) -> dict[str, tuple]:
    """Return the variables of the worst cases, one of each family: errors, what the input allows, verdict."""
    words = {
        "worst_state_error": ("state_error", "error of the final state in the worst case of the family"),
        "worst_time_error": ("time_error", "error of an event time in the worst case of the family"),
        "worst_sensitivity": ("sensitivity", "change of the worst case when its input is moved in its last places"),
        "worst_condition": ("condition", "condition number of the modal forms in the worst case"),
    }
    found = {
        name: variable("edge_family", np.array([getattr(tried.outcome, key) for tried in worst]), "1", text)
        for name, (key, text) in words.items()
    }
    verdicts = [tried.outcome.verdict for tried in worst]
    return found | {"worst_verdict": flagged("edge_family", verdicts, "verdict on the worst case", VERDICTS)}


def description(tried: Tried) -> dict[str, Any]:
    """Everything that is needed to run a case again."""
    case, outcome = tried.case, tried.outcome
    numbers = {key: getattr(outcome, key) for key in ("state_error", "time_error", "sensitivity", "condition")}
    return {
        **{key: value if np.isfinite(value) else None for key, value in numbers.items()},
        "verdict": outcome.verdict.name.lower(),
        "events": outcome.events,
        "group": case.group.name.lower(),
        "level": case.level if np.isfinite(case.level) else None,
        "drive": dict(case.drive),
        "physics": list(case.physics),
        "start": list(case.start),
        "duration": case.duration,
    }
