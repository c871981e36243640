"""Public questions with printed answers, typed as their pages print them: ``cases.yaml`` says where each comes from."""

from copy import deepcopy
from decimal import Decimal
from pathlib import Path

import pytest
import yaml

from lsvib.sheets.fields import quantity
from lsvib.sheets.inverse import solved
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import statics
from lsvib.sheets.words import ABOUT

CASES = yaml.safe_load(Path(__file__).with_name("cases.yaml").read_text(encoding="utf-8"))


def answers(case: dict) -> dict[str, dict]:
    """Each answer as a mapping, those that wait for something left out."""
    every = {key: said if isinstance(said, dict) else {"printed": said} for key, said in case["answers"].items()}
    return {key: said for key, said in every.items() if "needs" not in said}


ASKED = [pytest.param(case, key, id=f"{case['title']}: {key}") for case in CASES for key in answers(case)]


def put(sheet: dict, path: str, value: object) -> None:
    """Write an entry, such as load.force; None takes it away."""
    *parts, last = path.split(".")
    for part in parts:
        sheet = sheet[part]
    sheet.pop(last) if value is None else sheet.update({last: value})


@pytest.mark.parametrize(("case", "key"), ASKED)
def test_the_printed_answer_or_why_it_is_another(case, key):
    """Where an entry is asked for, it is solved for, and the other rows are those with its value."""
    sheet, said, given = deepcopy(case["sheet"]), answers(case)[key], case.get("solve")
    for path, value in case.get("until", {}).items():
        put(sheet, path, value)
    if given:
        ((row, wanted),) = case["for"].items()
        answer = solved(sheet, given, f"{row} = {wanted}")
    found = statics(answer.sheet if given else Sheet.of(sheet))
    name, _, column = key.partition(".")
    if key == given:
        value, unit = answer.values[0], answer.unit
    elif name == "back_drives":
        value, unit = found.back_drives, ""
    else:
        value, unit = getattr(found.rows[name], column or "worst"), ABOUT[name]["unit"].strip("1")
    if isinstance(value, bool | str):
        assert value == said["printed"]
        return
    ends = {}
    for kind in said.keys() & {"printed", "correct"}:
        exact, digits = quantity(said[kind], unit)[0], Decimal(str(said[kind]).split()[0])
        half = exact / float(digits) * 0.505 * 10.0 ** int(digits.as_tuple().exponent)
        ends[kind] = pytest.approx(exact, abs=half, rel=quantity(said.get("within", 0), "")[0])
    assert value == ends.pop("correct", ends["printed"])
    assert "correct" not in said or value != ends["printed"]
