"""Random tables and sheets for a fit, sound, unusual and malformed: an answer without NaN, or one sentence."""

import json
import math
import re
import time

import numpy as np
import pytest
from references.measured import DIAMETER, LEAD
from references.random_tables import one_load, random_measurement
from references.sizes import sizes

import lsvib
from lsvib.errors import LsvibError
from lsvib.sheets.fit_output import text_of
from lsvib.sheets.torque.law import FALL, PAIRS, fitted
from lsvib.sheets.torque.measured import Measured

MOST = 10.0  # seconds for a sheet


def answered(folder, seed, index):
    """Fit one; warnings are errors in all tests."""
    path, begin = random_measurement(folder / str(index), seed, index), time.process_time()
    refusal = ""
    try:
        found = lsvib.fit(path, folder / str(index) / "out" if index % 10 == 0 else None)
    except LsvibError as error:
        refusal = str(error)
    if refusal:
        assert re.fullmatch(r"[^\n]+\.", refusal), index
        return False
    json.dumps(found, allow_nan=False)
    assert not re.search(r"\bnan\b|\binf\b|\bNone\b", text_of(found)), index
    assert time.process_time() - begin <= MOST, index
    return True


@pytest.mark.parametrize("sheets", sizes([(1, range(20))], [], [(2, range(k, k + 100)) for k in range(0, 500, 100)]))
def test_random_tables_are_answered_or_refused(sheets, tmp_path):
    answers = [answered(tmp_path, sheets[0], index) for index in sheets[1]]
    assert 0.125 <= np.mean(answers) <= 0.875


@pytest.mark.parametrize("seeds", sizes([range(24)], [], [range(500)]), ids=len)
def test_one_load_tells_the_sums_alone(seeds):
    """Both ends hold the truth between them, and the first, where a rise is known to be none, the sum of constants.

    In 95 %, less four deviations of the count. Their laws are above a tenth of the constant, where none has a kink.
    """
    inside: dict[str, list[bool]] = {"sum": []}
    for seed in seeds:
        speed, torque, load, law = one_load(seed)
        thread = DIAMETER / 2, math.atan(LEAD / math.pi / DIAMETER)
        measured = Measured(speed, torque, np.full(speed.size, load), *thread)
        found = fitted(measured, {"stribeck_exponent": 1} | ({} if law["stribeck_rise"] else {"stribeck_rise": 0}))
        assert found.not_separable[:2] == PAIRS, seed
        for name, end in zip(PAIRS[0], found.ends.values(), strict=True):
            fall = -end.values["friction_slope"] * measured.sliding(speed).max()
            assert fall <= (FALL + 1e-9) * end.values["friction_coefficient"], seed
            inside.setdefault(name, []).append(law[name] <= end.values[name] + 1.96 * end.errors[name])
        constant, error = (of["friction_coefficient"] for of in (found.main.values, found.main.errors))
        levels = constant - 1.96 * error, law["friction_coefficient"], constant + 1.96 * error
        low, held, high = (measured.threads(level, np.sign(speed), load).mean() for level in levels)
        inside["sum"] += [] if law["stribeck_rise"] else [low <= held + law["coulomb"] <= high]
    for name, held in inside.items():
        assert np.mean(held) >= 0.95 - 4 * math.sqrt(0.95 * 0.05 / len(held)), name
