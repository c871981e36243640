"""Assess one data sheet and write the report, the dataset and the JSON file, all of them or none; or variants of it.

Variants are a table, a row each. Columns are entries of a sheet, such as ``load.mass``, with the unit in the cells or
in the heading, ``load.mass [kg]`` or ``load.mass (kg)``. Where semicolons or tabs part the cells, a comma in a number
is the decimal sign.
"""

import copy
import json
import math
from collections.abc import Mapping, Sequence
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import yaml

from lsvib import numbers
from lsvib.drives.scene import read_yaml
from lsvib.errors import InputError, LsvibError
from lsvib.files import check_outputs, replacing, write_json, write_text
from lsvib.sheets import assessment as whole
from lsvib.sheets.assessment import AssessedMotion, Assessment
from lsvib.sheets.changes import Change
from lsvib.sheets.draw import Draw, Operation
from lsvib.sheets.from_rest import KINDS, Chart, FromRest, charts
from lsvib.sheets.inverse import Solved, solved
from lsvib.sheets.report import brief, of_curve, of_statics, report, said, size_report
from lsvib.sheets.sheet import Sheet
from lsvib.sheets.statics import Statics, statics
from lsvib.sheets.units import plain, split
from lsvib.sheets.words import ABOUT, QUANTITIES, us_units_too

if TYPE_CHECKING:
    import xarray as xr

_OF_MOTIONS = ("parts", "attractor", "vibrates", "frequency", "audible", "amplitude", "load_speed", "screw_speed",
               "peak_contact_force", "peak_impulse", "motor_torque", "reason", "scene")  # fmt: skip


def assess(
    sheet: Path | str | Mapping[str, Any],
    out: Path | str | None = None,
    samples: Any = 4096,
    seed: Any = 1,
    units: Literal["si", "us"] = "si",
    solve: tuple[str, str] | None = None,
) -> dict[str, Any]:
    """Assess a data sheet: does the drive vibrate, and which torques does it need?

    Torques are those of a power screw, r F tan(λ ± ρ), with all other friction (Shigley); the stability of steady
    running follows from eqs 8.18–8.21, 8.27 and 8.33 over the operating window and the uncertainties (docs/assess.md).

    Arguments:

    * ``sheet``: the path of a YAML file, or its names and values.
    * ``out``: a folder for ``index.html``, ``assessment.json`` and, if vibration is assessed, ``assessment.nc``.
    * ``samples``: the number of drives drawn from the uncertainties, a power of two from 64 on; ``seed``: of the draw.
    * ``units``: "us" adds US units to the page and to the ``brief`` that is returned.
    * ``solve``: an entry to solve for, and its goal, see :func:`lsvib.sheets.inverse.solved`.

    Returns the content of ``assessment.json``, in SI units. Raises ``LsvibError``; then nothing is written.

    >>> sheet = {"thread": {"size": "Tr 16x4"}, "load": {"force": "500 N"}, "friction": {"coefficient": 0.15}}
    >>> f"{lsvib.assess(sheet)['statics']['lifting_torque']['worst']:.3f} N m"
    '0.874 N m'
    """
    count = numbers.whole_between("samples", samples, 64, 2**20)  # seconds; a share is in error by less than 1e-3
    if count & (count - 1):
        raise InputError(f"samples = {count} is not a power of two, such as 1024.")
    start = numbers.whole_between("seed", seed, 0, 2**32 - 1)
    values = sheet if isinstance(sheet, Mapping) else {"name": Path(sheet).stem, **read_yaml(sheet)}
    answer = solved(values, *solve) if solve else None
    given = answer.sheet if answer else Sheet.of(values)
    names = ["index.html", "assessment.json", *([] if given.of_statics else ["assessment.nc"])]
    files = [Path(out) / name for name in names] if out else []
    check_outputs(files, [] if isinstance(sheet, Mapping) else [sheet])
    found = None if given.of_statics else whole.assess(given, count, start)
    result = _told(given, found, answer)
    with us_units_too(units == "us"):
        told = {**result, "brief": _told(given, found, answer)["brief"]} if units == "us" else result
        if out:
            _write(files, given, found, result, told, answer.sentence if answer else "")
    return told


def _told(sheet: Sheet, found: Assessment | None, answer: Solved | None) -> dict[str, Any]:
    """What is said of a sheet, of what was ``found`` unless it asks for a size only, and of an entry solved for."""
    result = as_json(found) if found else _of_statics(sheet)
    first = answer and f"{answer.sentence} What follows is for {'the first' if answer.values[1:] else 'this'} value."
    more = {"brief": [first, *result["brief"]], "solved": answer.as_json()} if answer else {}
    return result | more


def _write(files: Sequence[Path], sheet: Sheet, found: Assessment | None, result: Any, told: Any, first: str) -> None:
    """Write all files, or none."""
    operating = charts(found.draw) if found else []
    with replacing(*files) as (page, verdict, *more):
        write_text(report(found, operating, first) if found else size_report(sheet, told, first), page)
        write_json(result, verdict)
        if found:
            from lsvib.answers.io import write_dataset

            write_dataset(dataset(found, operating), more[0])


def _of_statics(sheet: Sheet) -> dict[str, Any]:
    """The answer for a sheet that gives no drive which could vibrate: its verdict is on motor and brake alone."""
    found, draw = statics(sheet), Draw.of(sheet)
    curve, (lifting, lowering) = of_curve(draw), map(float, draw.efficiencies)
    sentence = f"Vibration is not assessed: {sheet.of_statics}."
    if sheet.load.mass is None:
        sentence += " No weight is counted."
    if draw.run and "acceleration_torque" not in found.rows:
        sentence += " No inertia is given, so the torque for ramps is not counted."
    more = said("move", draw), said("nut", sheet), said("curve", curve)
    return {
        "name": sheet.name,
        "verdict": found.verdict,
        "vibration": None,
        "sentence": f"{found.sentence} {sentence}".strip(),
        "brief": [line for line in (found.sentence, *of_statics(found), *more, sentence) if line],
        **_of_any(draw, found),
        "self_locking": lowering <= 0,
        "efficiency": {"lifting": lifting, "lowering": lowering if lowering > 0 else None},
    }


def as_json(assessment: Assessment) -> dict[str, Any]:
    """Return the verdict as plain values for JSON: SI units, None for what does not exist or is infinite."""
    perturbed = assessment.perturbed
    return {
        "name": assessment.draw.sheet.name,
        "verdict": assessment.verdict,
        "vibration": assessment.vibration,
        "sentence": said("verdict", assessment),
        "taken_as_zero": assessment.omitted,
        "brief": brief(assessment),
        **_of_any(assessment.draw, assessment.statics),
        "ripple": assessment.ripple and vars(assessment.ripple),
        "self_locking": assessment.efficiency["lowering"] is None,
        "self_locking_probability": assessment.uncertainty.holds.value,
        "efficiency": {**assessment.efficiency, "lifting_range": list(assessment.uncertainty.lifting)},
        "mechanisms": {
            name: {
                **{key: getattr(one, key) for key in ("occurs", "probability", "interval", "reserve")},
                "at": _place(one.there),
                "margin": _margins_json(one.margins),
            }
            for name, one in assessment.mechanisms.items()
        },
        "after_perturbation": {
            "possible": bool(perturbed.probability) or perturbed.occurs,
            "probability": perturbed.probability,
            "interval": None if perturbed.interval is None else list(perturbed.interval),
        },
        "quantities": {
            QUANTITIES[key].name: {"value": value, "unit": QUANTITIES[key].unit}
            for key, value in assessment.draw.values.items()
        },
        "samples": assessment.uncertainty.samples,
        "seed": assessment.seed,
        "any_mechanism": {
            "probability": assessment.uncertainty.any.value,
            "interval": list(assessment.uncertainty.any.interval),
            "margin": _margins_json(assessment.margins),
        },
        "sobol": assessment.uncertainty.sobol,
        "from_rest": _from_rest_json(assessment.from_rest),
        "changes": {
            row.about.name: {"factor": row.factor, "value": row.value, "unit": row.about.unit, "left": row.left or None}
            for row in assessment.changes
        },
        "purchases": [
            {"words": said("purchase", assessment, x), "left": x.left or None, "steps": [y._asdict() for y in x.steps]}
            for x in assessment.purchases
        ],
        "resonances": [one._asdict() for one in assessment.resonances],
        "nominal": _motion_json(assessment.nominal),
        "worst_case": _motion_json(assessment.worst),
    }


def _statics_json(found: Statics) -> dict[str, Any]:
    rows = {key: {**vars(row), "unit": ABOUT[key]["unit"]} for key, row in found.rows.items()}
    for row in rows.values():
        del row["key"]
        row["worst"] = row["worst"] if np.isfinite(row["worst"]) else None  # a torque, where the threads jam
    return {"back_drives": found.back_drives, **rows}


def _of_any(draw: Draw, found: Statics) -> dict[str, Any]:
    """What the answer for any sheet has."""
    run = draw.run and {key: float(one) if np.isfinite(one) else None for key, one in draw.run._asdict().items()}
    return {
        "statics": _statics_json(found),
        "motor": {"highest_speed": found.highest_speed},
        "move": run,
        "worst_torque": found.parts,
        "friction_curve": of_curve(draw),
        "pairings": draw.sheet.pairings,
        "assumptions": dict(draw.sheet.assumptions),
        "sources": dict(draw.sheet.sources),
    }


def _from_rest_json(found: FromRest) -> dict[str, Any]:
    travel, moved = found.there.draw.travel, found.motion
    even = None if found.even_speed == math.inf else found.even_speed
    return {
        "jerks": found.jerks,
        "unstable_directions": list(found.unstable),
        "even_speed": even,
        "even_load_speed": even and travel * even,
        "at_no_speed_tried": found.even_speed == math.inf,
        "at": {**_place(found.there), "load_speed": travel * found.there.speed},
        "frequency": moved and moved.frequency,
        "peak_to_peak": moved and moved.amplitude and 2 * moved.amplitude,
        "cause": found.cause or None,
        "share_of_drawn": found.share,
        "drawn": found.drawn,
        "jerky": found.jerky,
        "not_known": found.unknown,
    }


def _place(there: Operation) -> dict[str, float]:
    return {"direction": int(there.direction), "screw_speed": float(there.speed), "force": float(there.force)}


def _margins_json(rows: list[Change]) -> dict[str, Any]:
    return {row.about.name: {"factor": row.factor, "value": row.value, "unit": row.about.unit} for row in rows}


def _motion_json(motion: AssessedMotion) -> dict[str, Any]:
    moved, (size, sentence) = motion.vibration, motion.tolerated
    return {
        "mechanism": motion.mechanism,
        "entries": motion.there.draw.entries,
        "at": _place(motion.there),
        **{key: getattr(moved, key) for key in _OF_MOTIONS},
        "tolerated_perturbation": None if size is None or not np.isfinite(size) else size,
        "tolerated_perturbation_sentence": sentence,
    }


def dataset(assessment: Assessment, charts: list[Chart]) -> "xr.Dataset":
    """Return the operating chart, and the motions of the load at middle and worst values."""
    import xarray as xr

    from lsvib.answers.attributes import flagged, variable

    kinds, words = np.stack([chart.kind for chart in charts]), "what occurs at a point of operation"
    variables: dict[str, Any] = {"chart": flagged(("direction", "force", "speed"), kinds, words, KINDS)}
    coordinates = {
        "direction": variable("direction", [chart.direction for chart in charts], "1", "direction, 1 is outward"),
        "force": variable("force", charts[0].force, "N", "force against outward travel"),
        "speed": variable("speed", charts[0].speed, "m s-1", "speed of the load"),
    }
    for name, motion, where in (
        ("nominal", assessment.nominal, "at the middle values"),
        ("worst", assessment.worst, "in the worst case"),
    ):
        dim, moved = f"{name}_time", motion.vibration  # a motion that is not known has no samples
        coordinates[dim] = variable(dim, moved.time, "s", f"time of the motion {where}")
        variables[f"{name}_deviation"] = variable(dim, moved.deviation, "m", f"deviation of the load {where}")
    return xr.Dataset(
        variables,
        coordinates,
        attrs={
            "title": f"Assessment of a lead-screw drive: {assessment.draw.sheet.name}",
            "source": "lsvib assess",
            "references": "Vahid-Araghi and Golnaraghi, Friction-Induced Vibration in Lead Screw Drives, Springer "
            "2011, chapter 8",
            "verdict": f"{assessment.verdict}. {said('verdict', assessment)}",
            "samples": assessment.uncertainty.samples,
            "seed": assessment.seed,
            "worst_case_scene": json.dumps(assessment.worst.vibration.scene),
        },
    )


ON_SCREEN = ["name", "verdict", "limit_used", "exceeded", "lifting_torque", "lifting_efficiency", "refused"]


def assess_variants(
    path: Path, base: Path | None = None, samples: Any = 64, seed: Any = 1, progress: numbers.Progress | None = None
) -> Any:
    """Return the rows of a CSV file as a table of pandas with what is said of each, or why it is ``refused``.

    ``base``: the YAML file of a sheet that has what the table leaves out; a cell ``null`` takes an entry of it away.
    Raises ``InputError`` if the file is no table, or all rows are refused for one reason.
    """
    import pandas as pd  # type: ignore[import-untyped]

    sheet, found = read_yaml(base) if base else {}, []
    for about in ("sources", "assumptions"):  # of entries that a variant may not have
        sheet.pop(about, None)
    try:
        text = path.read_text(encoding="utf-8-sig")
        parted = next((sign for sign in ";\t" if sign in text.partition("\n")[0]), ",")
        rows = pd.read_csv(StringIO(text), sep=parted, dtype=str, keep_default_na=False, skipinitialspace=True)
    except (OSError, ValueError) as error:  # pandas raises many kinds of the latter
        reason = getattr(error, "strerror", None) or " ".join(str(error).split()).rstrip(".")
        raise InputError(f"Cannot read {path}: {reason}.") from None
    if parted != ",":
        rows = rows.replace(r"^(-?\d+),(\d+)(?![\d,.])", r"\1.\2", regex=True)
    if not isinstance(rows.index, pd.RangeIndex):
        raise InputError(f"{path} is not a table: a row has more cells than the first line has headings.")
    for count, cells in enumerate(rows.to_dict("records"), 1):
        row = {"name": f"row {count}", **{key: cell for key, cell in cells.items() if cell or key != "name"}}
        try:
            found.append({**row, "refused": None, **_said(assess(_variant(sheet, row), None, samples, seed))})
        except LsvibError as error:
            found.append({**row, "refused": str(error)})
        if progress:
            progress(count, len(rows))
    refused = {row["refused"] for row in found} or {"it has no rows."}
    if len(refused) == 1 and (reason := refused.pop()):
        raise InputError(f"All variants in {path} are refused: {reason}")
    return pd.DataFrame(found)


def _variant(base: Mapping[str, Any], cells: Mapping[str, str]) -> dict[str, Any]:
    """The names and values of the sheet of one row."""
    values = copy.deepcopy(dict(base))
    for heading, cell in cells.items():
        path, _, unit = heading.strip().replace("(", "[", 1).removesuffix("]").removesuffix(")").partition("[")
        *parts, last = path.strip().split(".")
        place = values
        for part in parts:
            if not isinstance(place.get(part), dict):  # nothing, or contact: rigid
                place[part] = {}
            place = place[part]
        if cell == "null":
            place.pop(last, None)
        elif cell:
            place[last] = _value(cell, unit)
    return _with_entries(values)


def _with_entries(values: dict[str, Any]) -> dict[str, Any]:
    """Leave out the parts that have no entry, as all of their cells are empty."""
    inner = {key: _with_entries(value) if isinstance(value, dict) else value for key, value in values.items()}
    return {key: value for key, value in inner.items() if value != {}}


def _value(cell: str, unit: str) -> Any:
    """What a cell holds, as in a sheet; a number gets the unit of its heading."""
    try:
        value = yaml.safe_load(cell)
    except yaml.YAMLError:
        return cell
    if isinstance(value, list):
        return [_value(str(one), unit) for one in value]
    bare = unit and (found := split(plain(cell))) and not found[1]  # 2e-6 too, which YAML takes for text
    return f"{cell} {unit}" if bare else value


def _said(result: Mapping[str, Any]) -> dict[str, Any]:
    """The answers by which an engineer sorts: worst values of statics, the largest share of a limit that is used."""
    rows = {key: row for key, row in result["statics"].items() if isinstance(row, Mapping)}
    back = result["statics"]["back_drives"]
    found = {key: result[key] for key in ("verdict", "sentence")} | {"back_drives": "no" if back is False else back}
    if result["vibration"] is not None:
        near, one = min(result["mechanisms"].items(), key=lambda item: item[1]["reserve"])
        found |= {"probability": result["any_mechanism"]["probability"], "mechanism": near, "reserve": one["reserve"]}
        found |= {"even_speed [m/s]": result["from_rest"]["even_load_speed"]}
        found |= {"frequency [Hz]": result["nominal"]["frequency"], "amplitude [m]": result["nominal"]["amplitude"]}
    limited = [row for key, row in rows.items() if row["limit"] and row["worst"] and key != "holding_friction"]
    found |= {"limit_used": max((row["worst"] / row["limit"] for row in limited), default=None)}
    found |= {"exceeded": "; ".join(key for key, row in rows.items() if row["exceeded"])}
    return found | {f"{key} [{row['unit']}]".removesuffix(" [1]"): row["worst"] for key, row in rows.items()}
