"""Random tables and sheets for a fit, sound, unusual and malformed: an answer without NaN, or one sentence."""

import json
import re
import time

import numpy as np
import pytest
from references.random_tables import random_measurement
from references.sizes import sizes

from lsvib.errors import LsvibError
from lsvib.fit.output import fit_file, text_of

MOST = 10.0  # seconds for a sheet


def answered(folder, seed, index):
    """Fit one; warnings are errors in all tests."""
    path, begin = random_measurement(folder / str(index), seed, index), time.process_time()
    refusal = ""
    try:
        found = fit_file(path, folder / str(index) / "out" if index % 10 == 0 else None)
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
