"""Random data sheets with values at the ends of their ranges: a report, or one sentence that refuses the sheet."""

import json
import math
import warnings

import numpy as np
import pytest

pytest.importorskip("pint")
pytest.importorskip("scipy")

from lsvib.assess.assessment import assess
from lsvib.assess.dataset import dataset
from lsvib.assess.operating_chart import charts
from lsvib.assess.plain_values import as_json
from lsvib.assess.report import report
from lsvib.assess.sheet import Sheet
from lsvib.errors import InputError

AT_AN_END = 0.05  # probability of a value to be the least or the largest that is allowed
# Of each quantity: the usual range, the least and the largest value that are allowed, its unit.
LENGTH = (0.05, 3.0, 1e-9, 100.0, "m")
RADIUS = (2e-3, 0.05, 2e-6, 2.0, "m")
LEAD = (5e-4, 0.02, 1e-9, 100.0, "m")
LEAD_ANGLE = (0.5, 40.0, 6e-5, 80.0, "deg")
MASS = (0.1, 1e3, 1e-18, 1e9, "kg")
INERTIA = (1e-7, 1e-3, 1e-30, 1e6, "kg m^2")
TORSION = (0.1, 1e4, 1e-21, 1e12, "N m/rad")
FORCE = (1.0, 1e4, 1e-18, 1e10, "N")
SPEED = (0.1, 300.0, 1e-12, 1e6, "rad/s")
FRICTION = (0.02, 0.5, 1e-18, 3.0, "")
TURNING = (1e-6, 1e-2, 1e-30, 1e12, "N m s/rad")
DAMPING = (0.1, 1e4, 1e-18, 1e15, "N s/m")
STIFFNESS = (1e6, 1e9, 1e-9, 1e15, "N/m")


def value(random, quantity, signed=False):
    """A value, a range or a distribution of a quantity."""
    low, high, least, largest, unit = quantity
    size = 10 ** random.uniform(math.log10(low), math.log10(high))
    if random.random() < AT_AN_END:
        size = random.choice([least, largest])
    sign = -1 if signed and random.random() < 0.5 else 1

    def written(x):
        return f"{float(x)!r} {unit}" if unit else float(x)

    form = random.random()
    if form < 0.6:
        return written(sign * size)
    if form < 0.8:
        return sorted([written(sign * size), written(sign * size * 0.5)], key=lambda x: float(str(x).split()[0]))
    if form < 0.9 or sign < 0:
        return {"mean": written(sign * size), "std": written(0.1 * size)}
    return {"median": written(size), "factor": 1.1}


def sheet(random):
    """A data sheet with random entries and values."""

    def some(chance, **entries):
        return {key: value(random, quantity) for key, quantity in entries.items() if random.random() < chance}

    lead = {"lead": value(random, LEAD)} if random.random() < 0.5 else {"lead_angle": value(random, LEAD_ANGLE)}
    inertia = {"inertia": value(random, INERTIA)} if random.random() < 0.5 else {"length": value(random, LENGTH)}
    springs = {
        part: {"stiffness": value(random, STIFFNESS), **some(0.6, damping=DAMPING)}
        for part in ("contact", "support")
        if random.random() < 0.3
    }
    return {
        "name": "random",
        "thread": {**lead, "pitch_diameter": value(random, RADIUS)},
        "screw": {**inertia, "mass": value(random, MASS)},
        "coupling": {"stiffness": value(random, TORSION), **some(0.3, inertia=INERTIA)},
        "load": {"mass": value(random, MASS), "force": value(random, FORCE, signed=True)},
        "operation": {"speed": value(random, SPEED), "direction": str(random.choice(["out", "back", "both"]))},
        "friction": {"coefficient": value(random, FRICTION)},
        "damping": some(0.6, rotational=TURNING, translational=DAMPING),
        **springs,
    }


def assessed(values):
    """All that is written about a data sheet; None if it is refused, in a sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = assess(Sheet.of(values), 64, 1)
            operating = charts(found.sheet, found.values)
            written = json.dumps(as_json(found), allow_nan=False)
            return report(found, operating), dataset(found, operating), written
    except InputError as error:
        return None if str(error).endswith(".") else error


def reports(seed, count):
    """How many of so many random data sheets have a report; the others must be refused."""
    random = np.random.default_rng(seed)
    found = [assessed(sheet(random)) for _ in range(count)]
    assert not any(isinstance(one, InputError) for one in found)
    return sum(one is not None for one in found)


@pytest.mark.slow
def test_a_random_data_sheet_has_a_report_or_a_sentence():
    assert reports(1, 4) > 1


@pytest.mark.long
def test_many_random_data_sheets_have_a_report_or_a_sentence():
    assert reports(2, 150) > 90
