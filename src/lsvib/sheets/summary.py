"""Sentences on a drive, from the templates beside this file, and the short answer that they make."""

import math
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
from jinja2 import Environment

from lsvib.drives import friction
from lsvib.sheets import words
from lsvib.sheets.assessment import Assessment
from lsvib.sheets.margins import Margin, applied
from lsvib.sheets.operation import Draw
from lsvib.sheets.quantities import FRICTION, sliding_speed
from lsvib.sheets.starting import BEYOND
from lsvib.sheets.statics import Statics, lets_go

EFFORTS = {"lifting": "against the load", "lowering": "with the load", "braking": "to brake, where the load turns it"}
"""What torques are for, the most demanding first."""
POOR = 0.1  # of a coefficient: a law that is further off says something else than its curve


def templates(html: bool) -> Environment:
    """Return what renders the templates, with the words that they use."""
    found = words.environment(html)
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
    curve = said("curve", of_curve(assessment.draw))
    return [line for line in (first, *of_statics(assessment.statics), curve, *changes) if line]


def of_statics(found: Statics) -> list[str]:
    """Return what statics say: whether the load is held, torques and efficiency, limits that are exceeded."""
    return [line for name in ("holding", "effort", "limits") if (line := said(name, found))]


def of_curve(draw: Draw) -> dict[str, Any] | None:
    """Return the ``law`` of a curve of friction, how far it is ``off`` [1] ``at`` most, and the sliding speeds [m/s].

    Those are the ends of the ``curve`` and of the operating ``window``.
    """
    given = draw.sheet.friction
    if not given.curve:
        return None
    law = {name: draw.values[name] for name in (*FRICTION, "stribeck_speed") if name in draw.values}
    law["stribeck_exponent"], (speeds, coefficients) = given.stribeck_exponent, np.array(given.curve).T
    off = np.abs(friction.unbounded_coefficient(SimpleNamespace(**law), speeds) / coefficients - 1)
    used = [sliding_speed(draw.values[f"speed_{end}"], draw.pitch_radius, draw.lead_angle) for end in ("low", "high")]
    ends = {"curve": speeds[[0, -1]].tolist(), "window": [float(speed) for speed in used]}
    return {"law": law, "off": float(off.max()), "at": float(speeds[off.argmax()]), **ends}


def drops(assessment: Assessment, row: Margin) -> bool:
    """Whether the load drops, once the current is off, with a change of one quantity."""
    return lets_go(assessment.draw, applied(assessment.draw, row))
