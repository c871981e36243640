"""Fit one sheet; say what was found in plain words and as JSON, and write dataset and picture: all of them or none."""

import json
import math
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from lsvib.answers.io import write_dataset
from lsvib.files import check_outputs, replacing, write_json, write_text
from lsvib.pictures import style
from lsvib.pictures.torque import residual_panel, torque_panel
from lsvib.sheets.fit_sheet import OF_FLANKS, FittedSheet, fit_sheet
from lsvib.sheets.formulas import flank_coefficient
from lsvib.sheets.torque.dataset import fit_variables
from lsvib.sheets.torque.law import LARGEST_STATIC
from lsvib.sheets.torque.measured import BREAKAWAY, PARAMETERS, Solution, load_of_directions
from lsvib.sheets.torque.records import Record
from lsvib.sheets.torque.starts import Number
from lsvib.sheets.torque.stick_slip import StickSlip
from lsvib.sheets.words import environment

_FILES = ("fit.nc", "fit.json", "fit.png", "fit.pdf", "friction.yaml")
_ENDS = {
    "fit": "Fit",
    "threads": "All friction in the threads",
    "bearing": "As much friction as possible in the bearing",
}
_AT_REST = {  # ends of static friction alone
    "threads": "Static friction above sliding in the threads",
    "bearing": "Static friction above sliding in the bearing",
}
_IN_BEARING = {BREAKAWAY[1]: "static"}  # what is called otherwise in the block `bearing`
POOR = 0.1  # of the typical torque: residuals beyond are no good fit
NONE = 0.3  # of the typical torque: a law that leaves more rms is none to copy
DRAWN = 4.1  # standard deviations, within which a data sheet draws, with some room


def fit(path: Path | str, out: Path | str | None = None) -> dict[str, Any]:
    """Fit a friction law to measured torque, as a sheet in a YAML file describes it.

    The torque of a screw under an axial force F, r F tan(λ ± arctan μ), and the drag of its bearing (eqs 8.4, 8.13) are
    fitted by robust least squares; μ over the sliding speed is a constant, a slope and a Stribeck rise (docs/fit.md).

    Arguments: ``path`` of the sheet; ``out``, a folder for ``fit.nc``, ``fit.json``, ``fit.png``, ``fit.pdf`` and
    ``friction.yaml``. Returns the content of ``fit.json``, in SI units. Raises ``LsvibError``; then nothing is written.

    >>> found = lsvib.fit("examples/measured_screw/measured_screw.yaml")
    >>> found["points"], round(found["friction"]["stribeck_rise"], 2)
    (30, 0.16)
    """
    path, out = Path(path), None if out is None else Path(out)
    files = [out / name for name in _FILES] if out else []
    check_outputs(files, [path])
    found = fit_sheet(path)
    result = as_json(found)
    if out:
        made = dataset(found)
        with replacing(*files) as (data, numbers, png, pdf, block):
            write_dataset(made, data, "lsvib.sheets.fit_output.fit")
            write_json(result, numbers)
            style.save(draw(made), png, pdf)
            write_text(blocks(result), block)
    return result


def as_json(found: FittedSheet) -> dict[str, Any]:
    """Return what was found as plain values for JSON: SI units, None for what does not exist."""
    fit, main = found.fit, found.fit.main
    measured, loads = fit.measured, np.unique(fit.measured.load).tolist()
    return {
        "name": found.name,
        **_end(found, main),
        "points": len(found.points),
        "typical_torque": float(np.median(np.abs(measured.torque))),
        "speeds": measured.speeds[[0, -1]].tolist(),
        "sliding_speeds": measured.sliding(measured.speeds[[0, -1]]).tolist() if found.half_angle is not None else None,
        "not_separable": [list(pair) for pair in fit.not_separable],
        "ends": {name: _end(found, end) for name, end in fit.ends.items()},
        "loads": loads,
        "measured": [
            {key: None if value != value else value for key, value in vars(point).items()} for point in found.points
        ],
        "records": [_record(table.record) for table in found.tables if table.record],
        "stick_slip": _stick_slip(found.stick_slip),
        "stick_slip_of_ends": {name: _stick_slip(told) for name, told in found.jerks.items()},
        "inertia": found.inertia and {"value": found.inertia[0], "standard_error": found.inertia[1] or None},
        "said": sentences(found),
    }  # fmt: skip


def _stick_slip(told: StickSlip | None) -> dict[str, Any] | None:
    """What jerks tell of the drive; ``damping`` in the middle of its ``bounds``."""
    if told is None:
        return None
    (stiffness, error), bounds = told.stiffness, told.damping and list(told.damping)
    known = {
        "damping": told.middle,
        "bounds": bounds,
        "even_speed": told.even_speed,
        "damping_by_periods": told.by_periods,
        "jerks_up_to": told.up_to,
        "periods": [list(pair) for pair in told.periods],
        "periods_uneven": told.uneven and list(told.uneven),
    }
    return {"stiffness": stiffness, "standard_error": error, **known, "doubt": told.doubt or None}


def _record(record: Record) -> dict[str, Any]:
    """What a file is over time; values in SI units, each with its standard error in a table of its own."""
    values = {key: value for key, value in vars(record).items() if value is not None and key != "turning"}
    pairs = {key: value for key, value in values.items() if isinstance(value, tuple) and key != "said"}
    errors = {"standard_errors": {key: error or None for key, (_, error) in pairs.items()}} if pairs else {}
    return values | {key: value for key, (value, _) in pairs.items()} | errors


def _end(found: FittedSheet, end: Solution) -> dict[str, Any]:
    static = {_IN_BEARING[k]: value for k, value in end.bearing().items() if k in _IN_BEARING}
    of_static = {_IN_BEARING.get(k, k): error if error > 0 else None for k, (_, error) in end.static.items()}
    return {
        "friction": end.drive() if found.half_angle is not None else {},
        "bearing": {name: end.values[name] for name in ("coulomb", "viscous")} | static,
        "offset": end.values["offset"],
        "sheet": flank_law(found, end),
        "standard_errors": {name: error or None for name, error in end.errors.items()} | of_static,
        "correlation": {"of": list(end.free), "matrix": end.correlation.tolist()},
        "rms": end.rms,
        "largest_residual": float(np.abs(end.residual).max()),
        "loads_of_directions": _loads(found, end),
    }


def flank_law(found: FittedSheet, solution: Solution) -> dict[str, Any]:
    """Return a friction law as the block ``friction`` of a data sheet, with coefficients of the flanks."""
    law, angle = solution.drive(), found.fit.measured.lead_angle
    if found.half_angle is None:
        return {}
    to_flank = float(flank_coefficient(1.0, angle, found.half_angle))
    known = {name: (value, solution.errors.get(name, 0.0)) for name, value in law.items()} | solution.static
    share = above(known, "friction_coefficient", "stribeck_rise", BREAKAWAY[0])
    entries: dict[str, Any] = {
        entry: spread(known[name], share(name), to_flank, "s/m" if entry == "slope" else "")
        for entry, name in OF_FLANKS.items()
        if name in law
    }
    if "stribeck_rise" in entries:
        entries["stribeck_speed"] = spread(known["stribeck_speed"], unit="m/s")
        entries["stribeck_exponent"] = int(law["stribeck_exponent"])
    return entries


def above(known: Mapping[str, Number], *names: str) -> Callable[[str], float]:
    """Return the shares of standard errors with which the last is above the sum of the others in each drive drawn.

    A data sheet wants static friction so. The errors by themselves are larger than those of the sum, in which errors of
    the parts of a law cancel. Either side may use half of what is between.
    """
    *sliding, (static, error) = (known.get(name, (0.0, 0.0)) for name in names)
    room = 0.5 * (static - sum(value for value, _ in sliding)) / DRAWN if static else math.inf
    both = {name: sum(each for _, each in sliding) for name in names[:-1]} | {names[-1]: error}
    return lambda name: min(1.0, room / both[name]) if both.get(name) else 1.0


def spread(known: Number, share: float = 1.0, scale: float = 1.0, unit: str = "") -> Any:
    """Return a number with its standard error, times ``share``, as an entry of a data sheet.

    A range of that standard deviation, but above zero, where a normal distribution would reach beyond.
    """
    value, error = known[0] * scale, known[1] * scale * share
    wide = min(math.sqrt(3) * error, 0.99 * value)

    def entry(number: float, figures: str = ".6g") -> Any:
        """A number with its unit."""
        return f"{number:{figures}} {unit}" if unit else float(f"{number:{figures}}")

    if not error > 0 or (unit != "s/m" and not value):
        return entry(value)
    if unit != "s/m" and DRAWN * error > value:
        return [entry(value - wide), entry(value + wide)]
    return {"mean": entry(value), "std": entry(error, ".2g")}


def _loads(found: FittedSheet, end: Solution) -> list[float] | None:
    more = load_of_directions(found.fit.measured, end)
    return None if more is None else [load + more for load in np.unique(found.fit.measured.load).tolist()]


def sentences(found: FittedSheet) -> list[str]:
    """Return what the data say and what they do not, in sentences, by the template ``fit_said.j2``."""
    fit, measured, main = found.fit, found.fit.measured, found.fit.main
    typical, off = float(np.median(np.abs(measured.torque))), np.abs(main.residual)
    k, residual = int(np.argmax(off)), main.residual[np.lexsort((measured.speed, measured.load))]
    loads = {float(f"{value:.3g}") for end in fit.ends.values() for value in _loads(found, end) or ()}
    records = [table.record for table in found.tables if table.record]
    near_an_end = np.abs(main.values["stribeck_speed"] / np.array(measured.fading) - 1) < 1e-3
    text = _rendered(
        "fit_said.j2",
        found=found,
        fit=fit,
        not_separable=fit.not_separable,
        main=main,
        loads=[f"{value:.3g}" for value in sorted(loads)],
        one_load=np.ptp(measured.load) == 0,
        size=residual.size,
        alike=float(np.sum(residual[1:] * residual[:-1]) / np.sum(residual**2)) if residual.any() else 0.0,
        worst={
            "rms": main.rms / typical, "share": off[k] / typical, "speed": measured.speed[k],
            "load": measured.load[k], "name": found.points[k].name,
        },
        at_the_end="stribeck_speed" in main.free and near_an_end.any(),
        longest=max((one.period[0] for one in records if one.period), default=0.0),
    )  # fmt: skip
    return [" ".join(part.split()) for part in re.split(r"\n\s*\n", text.strip())]


def _rendered(template: str, **values: Any) -> str:
    found = environment().get_template(template)
    return found.render(
        **values,
        POOR=POOR,
        NONE=NONE,
        ENDS=_AT_REST if [tuple(pair) for pair in values["not_separable"]] == [BREAKAWAY] else _ENDS,
        PARAMETERS=PARAMETERS | {"static": ("N m",)},
        LARGEST_STATIC=LARGEST_STATIC,
        rpm=lambda speed: speed * 30 / np.pi,
    )


def blocks(result: dict[str, Any]) -> str:
    """Return the friction law, and the bearing's drag, as a data sheet, a scene and ``--set`` take it.

    Each is introduced by a comment. Nothing but a comment where the law leaves so much of the torque that it is none.
    """
    rubs, brakes, holds = (result["bearing"].get(name, 0.0) for name in ("coulomb", "viscous", "static"))
    of_bearing = {"bearing_friction": rubs, BREAKAWAY[1]: holds, "support_damping": brakes}
    parts = result["friction"] | {name: value for name, value in of_bearing.items() if value}
    jerks = result["stick_slip"]
    if jerks and jerks["damping"]:
        parts |= {"coupling_stiffness": jerks["stiffness"], "support_damping": jerks["damping"] + brakes}
    drive = {key: float(f"{value:.6g}") for key, value in parts.items()}
    return _rendered("fit_blocks.j2", **result, drive=drive, entries=_entries(result))


def _entries(result: dict[str, Any]) -> dict[str, Any]:
    """Return the blocks of a data sheet, each number with what is known of its error."""
    errors, jerks, inertia = result["standard_errors"], result["stick_slip"], result["inertia"]
    bearing = {name: (value, errors.get(name) or 0.0) for name, value in result["bearing"].items() if value}
    share = above(bearing, "coulomb", "static")
    of_bearing = {
        name: spread(bearing.get(key, (0.0, 0.0)), share(key), unit=unit)
        for name, key, unit in (
            ("torque", "coulomb", "N*m"), ("static", "static", "N*m"), ("viscous", "viscous", "N*m*s/rad")
        ) if key in bearing or (name == "torque" and "static" in bearing)
    }  # fmt: skip
    found = {"friction": result["sheet"]} if result["sheet"] else {}
    found |= {"bearing": of_bearing} if of_bearing else {}
    if jerks and jerks["damping"]:
        found["coupling"] = {"stiffness": spread((jerks["stiffness"], jerks["standard_error"]), unit="N*m/rad")}
        found["damping"] = {"rotational": [f"{value:.6g} N*m*s/rad" for value in jerks["bounds"]]}
    if inertia:
        found["screw"] = {"inertia": spread((inertia["value"], inertia["standard_error"] or 0.0), unit="kg*m^2")}
    return found


def text_of(result: dict[str, Any]) -> str:
    """Return what was found as a person reads it, torques in mN m."""
    return _rendered("fit_text.j2", **result, blocks=blocks(result).rstrip()).strip("\n")


def dataset(found: FittedSheet) -> xr.Dataset:
    """Return points, law, errors and residuals of a fit."""
    variables, coordinates, attributes = fit_variables(found.fit, found.points)
    about = {
        "title": f"Friction of a lead screw from measured torque: {found.name}",
        "source": "lsvib fit, least squares with a robust loss",
        "references": "steady torque of a lead screw, eqs 8.4 and 8.13 of doi:10.1007/978-1-4419-1752-2_8",
        "said": json.dumps(sentences(found)),
    }
    return xr.Dataset(variables, coordinates, {**about, **attributes})


@style.styled
def draw(found: xr.Dataset) -> style.Figure:
    """Draw the points with the scatter of their samples, the fitted law, and the residuals."""
    figure = style.new_figure(style.DOUBLE, 2.8)
    torque, residual = figure.subplots(1, 2)
    torque_panel(torque, found)
    residual_panel(residual, found)
    torque.set_title("(a) torque of the motor, bars: scatter")
    residual.set_title("(b) measured minus fitted, bars: error of means")
    return figure
