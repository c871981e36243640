"""Random tables and sheets for a fit, sound, unusual and malformed: an answer without NaN, or one sentence."""

import json
import re
import time

import pytest
from references.random_tables import random_measurement

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


def test_random_tables_are_answered_or_refused(tmp_path):
    answers = [answered(tmp_path, 1, index) for index in range(20)]
    assert 3 <= sum(answers) <= 17


@pytest.mark.search
@pytest.mark.parametrize("first", range(0, 500, 100))
def test_five_hundred_random_tables_are_answered_or_refused(first, tmp_path):
    answers = [answered(tmp_path, 2, index) for index in range(first, first + 100)]
    assert 10 <= sum(answers) <= 90
