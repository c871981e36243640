"""Sentences on a drive, from the templates beside this file, and the short answer that they make."""

import math
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from jinja2 import Environment

from lsvib.assess import words
from lsvib.assess.assessment import Assessment
from lsvib.assess.margins import Margin, applied
from lsvib.assess.operation import Draw
from lsvib.assess.quantities import sliding_speed
from lsvib.assess.starting import BEYOND
from lsvib.assess.statics import Statics, lets_go
from lsvib.models import friction

EFFORTS = {"lifting": "against the load", "lowering": "with the load", "braking": "to brake, where the load turns it"}
"""What torques are for, the most demanding first."""
POOR = 0.1  # of a coefficient: a law that is further off says something else than its curve


def templates(html: bool) -> Environment:
    """Return what renders the templates, with the words that they use."""
    found = words.environment(Path(__file__).parent, html)
    found.globals |= vars(words) | {"EFFORTS": EFFORTS, "BEYOND": BEYOND, "POOR": POOR, "drops": drops, "inf": math.inf}
    return found


@cache
def _sentences() -> Any:
    return templates(html=False).get_template("summary.j2").module


def said(name: str, *about: Any) -> str:
    """Return sentences by their name in the template ``summary.j2``, without line breaks."""
    return " ".join(str(getattr(_sentences(), name)(*about)).split())


def brief(assessment: Assessment) -> list[str]:
    """Return the short answer for the shell, a sentence or two to a line: verdict, statics, limits, three changes."""
    known = 0 < (assessment.starting.even_speed or 0.0) < math.inf
    told = assessment.verdict not in ("vibrates", "steady without reserve") or known
    first = f"{words.VERDICTS[assessment.verdict]} {said('from_rest', assessment.starting) if told else ''}".strip()
    changes = [said("changes", assessment)] if assessment.verdict in ("vibrates", "jerks") else []
    return [first, *of_statics(assessment.statics), *of_curve(assessment.draw), *changes]


def of_statics(found: Statics) -> list[str]:
    """Return what statics say: whether the load is held, torques and efficiency, limits that are exceeded."""
    return [line for name in ("holding", "effort", "limits") if (line := said(name, found))]


def of_curve(draw: Draw) -> list[str]:
    """Return which law stands for a curve of friction and how well, if the sheet has one."""
    given = draw.sheet.friction
    if not given.curve:
        return []
    speeds, coefficients = np.array(given.curve).T
    law = SimpleNamespace(**draw.values, stribeck_exponent=given.stribeck_exponent)
    off = np.abs(friction.unbounded_coefficient(law, speeds) / coefficients - 1)
    used = [sliding_speed(draw.values[f"speed_{end}"], draw.pitch_radius, draw.lead_angle) for end in ("low", "high")]
    return [said("curve", law, off.max(), speeds[off.argmax()], speeds[[0, -1]], used)]


def drops(assessment: Assessment, row: Margin) -> bool:
    """Whether the load drops, once the current is off, with a change of one quantity."""
    return lets_go(assessment.draw, applied(assessment.draw, row))
