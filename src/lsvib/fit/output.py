"""Fit one sheet; say what was found in plain words and as JSON, and write dataset and picture: all of them or none."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
import yaml

from lsvib.datasets.io import write_dataset
from lsvib.figures import style
from lsvib.figures.measured_drive import residual_panel, torque_panel
from lsvib.files import Outputs, write_json, write_text
from lsvib.fit.dataset import fit_variables
from lsvib.fit.law import LARGEST_STATIC, PARAMETERS, Solution, falls_up_to, halves, load_of_directions
from lsvib.fit.records import Record
from lsvib.fit.sheet import FittedSheet, fit_sheet
from lsvib.fit.stick_slip import StickSlip

_FILES = {"fit.nc": "netCDF", "fit.json": "JSON", "fit.png": "PNG", "fit.pdf": "PDF", "friction.yaml": ""}
_SENSES = {"lifting": 1, "lowering": -1}  # of the speed, times that of the load
_ENDS = {
    "fit": "Fit",
    "threads": "All friction in the threads",
    "bearing": "As much friction as can be in the bearing",
}
POOR = 0.1  # of the typical torque: residuals beyond are no good fit
NONE = 0.3  # of the typical torque: a law that leaves more rms is none to copy
_WORDS = {
    "friction_coefficient": "The constant part of friction of the threads and the Coulomb drag of the bearing",
    "friction_slope": "The slope of friction of the threads and the viscous drag of the bearing",
}


def fit_file(path: Path, out: Path | None = None) -> dict[str, Any]:
    """Fit the sheet in a YAML file; write ``fit.nc``, ``.json``, ``.png``, ``.pdf``, ``friction.yaml`` to ``out``.

    Returns what ``fit.json`` holds. Raises ``InputError`` or another ``LsvibError`` in one sentence; then nothing is
    written.

    >>> from pathlib import Path
    >>> from lsvib.fit.output import fit_file
    >>> found = fit_file(Path("examples/measured_screw/measured_screw.yaml"))
    >>> found["points"], round(found["friction"]["stribeck_rise"], 2)
    (30, 0.16)
    """
    files = [(out / name, kind) for name, kind in _FILES.items()] if out else []
    outputs = Outputs(files, [path], make_folders=True)
    found = fit_sheet(path)
    result = as_json(found)
    if out:
        made = dataset(found)
        with outputs.writing() as (data, numbers, png, pdf, block):
            write_dataset(made, data, "lsvib.fit.output.fit_file")
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
        "sliding_speeds": measured.sliding(measured.speeds[[0, -1]]).tolist(),
        "not_separable": [list(pair) for pair in fit.not_separable],
        "ends": {name: _end(found, end) for name, end in fit.ends.items()},
        "loads": loads,
        "falls_up_to": {
            words: [falls_up_to(measured, main, load, int(sense * (np.sign(load) or 1))) for load in loads]
            for words, sense in _SENSES.items()
        },
        "halves": [
            {"speed": speed, "half_sum": friction, "half_difference": of_load}
            for speed, friction, of_load in halves(measured).tolist()
        ],
        "measured": [
            {key: None if value != value else value for key, value in vars(point).items()} for point in found.points
        ],
        "records": [_record(table.record) for table in found.tables if table.record],
        "stick_slip": _stick_slip(found.stick_slip),
        "inertia": dict(zip(("value", "standard_error"), found.inertia, strict=True)) if found.inertia else None,
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
        "periods": [list(pair) for pair in told.periods],
    }
    return {"stiffness": stiffness, "standard_error": error, **known, "doubt": told.doubt or None}


def _record(record: Record) -> dict[str, Any]:
    """What a file is over time; values in SI units, each with its standard error in a table of its own."""
    values = {key: value for key, value in vars(record).items() if value is not None}
    pairs = {key: value for key, value in values.items() if isinstance(value, tuple) and key != "said"}
    errors = {"standard_errors": {key: error for key, (_, error) in pairs.items()}} if pairs else {}
    return values | {key: value for key, (value, _) in pairs.items()} | errors


def _end(found: FittedSheet, end: Solution) -> dict[str, Any]:
    return {
        "friction": end.drive(),
        "bearing": {name: end.values[name] for name in ("coulomb", "viscous")},
        "offset": end.values["offset"],
        "sheet": found.flank_law(end),
        "standard_errors": end.errors | ({"static_friction_coefficient": _finite(end.static[1])} if end.static else {}),
        "correlation": {"of": list(end.free), "matrix": end.correlation.tolist()},
        "rms": end.rms,
        "largest_residual": float(np.abs(end.residual).max()),
        "loads_of_directions": _loads(found, end),
    }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _loads(found: FittedSheet, end: Solution) -> list[float] | None:
    more = load_of_directions(found.fit.measured, end)
    return None if more is None else [load + more for load in np.unique(found.fit.measured.load).tolist()]


def sentences(found: FittedSheet) -> list[str]:
    """Return what the data say and what they do not, in sentences."""
    fit, measured = found.fit, found.fit.measured
    said = [f"Left out of {text}." for text in found.left_out] or ["No sample was left out."]
    said += [
        f"{_WORDS[threads]} are not separable: only the sum of their torques is known. Give one of them in "
        "the sheet, or measure with a second load; below all of it is in the threads at one end, and as much as can be "
        "in the bearing at the other."
        for threads, _ in fit.not_separable
    ]
    if measured.directions == 1:
        said.append("One direction was measured only: whether load and zero of the torque are right cannot be seen.")
    loads = [value for end in fit.ends.values() for value in _loads(found, end) or ()]
    if loads and "offset" in fit.unknown and np.ptp(measured.load) == 0:
        text = " to ".join(f"{value:.3g}" for value in sorted({float(f"{value:.3g}") for value in loads}))
        said.append(
            f"The sheet gives a load of {measured.load[0]:.4g} N; if the torque had no zero error, the "
            f"difference between both directions would be that of {text} N."
        )
    residual = fit.main.residual[np.lexsort((measured.speed, measured.load))]
    alike = float(np.sum(residual[1:] * residual[:-1]) / np.sum(residual**2)) if residual.any() else 0.0
    if alike > 2 / np.sqrt(residual.size):  # two standard deviations of what independent residuals have
        said.append(
            f"Residuals at neighbouring speeds are alike (correlation {alike:.2f}): the law leaves more than noise, "
            "and the standard errors, which take residuals to be independent, are too small."
        )
    said += _of_misfit(found) + _of_exponents(found)
    fading, speed = np.array(measured.fading), fit.main.values["stribeck_speed"]
    if "stribeck_speed" in fit.main.free and (abs(speed / fading - 1) < 1e-3).any():
        said.append(
            f"The speed over which the rise fades, {speed:.3g} m/s, is at the end of what the measured speeds can show."
        )
    if not fit.rise_seen:
        said.append("No rise of friction towards slow sliding is seen.")
    said += _of_falling(found)
    said += [f"Of {text}" for table in found.tables if table.record for text in table.record.said[1:]]
    if found.inertia:
        value, error = found.inertia
        load = (
            "without that of the mass it moves" if all(table.mass for table in found.tables) else "the load's included"
        )
        said.append(
            f"Starts and stops tell an inertia of {value:.3g} ± {error:.1g} kg m² of what turns, {load}: in a data "
            f"sheet it is screw: {{inertia: {value:.3g} kg*m^2}}."
        )
    said += _of_jerks(found)
    if not len(measured.breakaway):
        said.append("No table begins at rest, so there is no breakaway and no static coefficient.")
    elif not fit.main.static:
        said.append("The breakaway torque is not above that of slow sliding, so there is no static coefficient.")
    elif any(point.breakaway is not None for point in found.points) or found.stick_slip is None:
        said.append(
            "The static coefficient is of the largest torque at rest, which noise of the samples makes larger: take it "
            "as an upper bound."
        )
    if fit.main.absurd:
        said.append(
            f"Left out of the static coefficient: breakaway torques that would make it negative, above "
            f"{LARGEST_STATIC:g} or so large that the screw jams ({fit.main.absurd})."
        )
    return said


def _of_misfit(found: FittedSheet) -> list[str]:
    """Say that the law does not fit, where it leaves much of the typical torque over."""
    measured, residual = found.fit.measured, np.abs(found.fit.main.residual)
    typical, k = float(np.median(np.abs(measured.torque))), int(np.argmax(residual))
    if residual[k] <= POOR * typical:
        return []
    return [
        f"The law fits poorly: it leaves {found.fit.main.rms / typical:.0%} of the typical torque rms, and most, "
        f"{residual[k] / typical:.0%}, at {measured.speed[k]:.4g} rad/s under {measured.load[k]:.4g} N "
        f"({found.points[k].name})."
    ]


def _of_exponents(found: FittedSheet) -> list[str]:
    """Say what the law would be with the other exponent, where the points do not tell it from the chosen one."""
    if (other := found.fit.rival) is None:
        return []
    names = ("friction_coefficient", "stribeck_rise", "stribeck_speed")
    values = ", ".join(f"{name} {other.values[name]:.3g}" for name in names)
    return [
        f"The exponent of the rise is not known: {other.values['stribeck_exponent']:.0f} fits about as well as "
        f"{found.fit.main.values['stribeck_exponent']:.0f}, with {values}. The standard errors take the chosen one "
        "for certain; what both laws differ by comes on top."
    ]


def _of_jerks(found: FittedSheet) -> list[str]:
    """Say what jerks tell of the drive."""
    told = found.stick_slip
    if told is None:
        return []
    seen = [table.record.period[0] for table in found.tables if table.record is not None and table.record.period]
    stiffness, error = told.stiffness
    said = [
        f"While the screw stands the torque climbs as behind a spring of {stiffness:.3g} ± {error:.1g} N m/rad between "
        "command and screw: with a controller of the speed its integral gain, in series with all else that yields.",
        f"The torque at which jerks begin is that of a screw that has stood for {max(seen):.2g} s at most; after a "
        "longer rest it may be larger.",
    ]
    if told.damping is None:
        return [*said, f"Damping and the speed from which on it runs evenly are not known: {told.doubt}."]
    low, high = told.damping
    known = f"between {low:.2g} and {high:.2g}" if low else f"of at most {high:.2g}"
    said.append(f"Which files jerk and which are even leaves a damping {known} N m s/rad between command and screw.")
    if told.middle is None:
        return [*said, f"The speed from which on it runs evenly is not known: {told.doubt}."]
    speed, end = told.even_speed, "at no speed that was tried"
    if speed is not None:
        end = (
            f"from {speed:.3g} rad/s ({speed * 30 / np.pi:.3g} rpm) on, in all directions and under all loads that jerk"
        )
    said.append(f"With {told.middle:.2g} N m s/rad the drive runs evenly {end}.")
    if told.periods:
        screw, model = (f"{min(own):.3g} to {max(own):.3g} s" for own in zip(*told.periods, strict=True))
        said.append(f"Where the screw jerks every {screw}, that drive jerks every {model}.")
    return said


def _behind(record: dict[str, Any]) -> str:
    """The stiffness of a record of jerks in words, if it is known."""
    return f"behind {record['stiffness']:.3g} N m/rad" if "stiffness" in record else "behind an unknown stiffness"


def _told(record: dict[str, Any]) -> str:
    """What a start, a stop or a ramp tells, in words."""
    parts = {"inertia": (1, "kg m²"), "breakaway": (1e3, "mN m"), "ramp": (1, "rad/s²")}
    return ", ".join(
        f"{key} {record[key] * size:.3g} ± {record['standard_errors'][key] * size:.1g} {unit}"
        for key, (size, unit) in parts.items()
        if key in record and record["kind"] != "jerks"
    )


def _of_falling(found: FittedSheet) -> list[str]:
    """Say up to which speed friction falls, in the directions that were measured under the largest load."""
    measured = found.fit.measured
    load = float(measured.load[np.argmax(np.abs(measured.load))])
    turned = np.unique(np.sign(measured.speed[measured.load == load] * (load or 1)))
    falls = {
        words: falls_up_to(measured, found.fit.main, load, int(sense * (np.sign(load) or 1)))
        for words, sense in _SENSES.items()
        if sense in turned
    }
    texts = [f"{speed:.3g} rad/s ({speed * 30 / np.pi:.3g} rpm) {words}" for words, speed in falls.items() if speed]
    return [f"Under {load:.4g} N friction falls with the speed up to {' and '.join(texts)}."] if texts else []


def blocks(result: dict[str, Any]) -> str:
    """Return the friction law, and the bearing's drag, as a data sheet, a scene and ``--set`` take it.

    Each is introduced by a comment.

    Nothing but a comment where the law leaves so much of the torque that it is none.
    """
    if result["rms"] > NONE * result["typical_torque"]:
        share = result["rms"] / result["typical_torque"]
        return f"# The fitted law leaves {share:.0%} of the typical torque: it is no law of this screw.\n"
    rubs, brakes = result["bearing"]["coulomb"], result["bearing"]["viscous"]
    drag = {"torque": f"{rubs:.6g} N*m"} if rubs else {}
    drag |= {"viscous": f"{brakes:.6g} N*m*s/rad"} if brakes else {}
    parts = result["friction"] | ({"bearing_friction": rubs} if rubs else {})
    parts |= {"support_damping": brakes} if brakes else {}
    jerks, more = result["stick_slip"], {}
    if jerks and jerks["damping"]:
        more = {
            "coupling": {"stiffness": f"{jerks['stiffness']:.6g} N*m/rad"},
            "damping": {"rotational": f"{jerks['damping']:.6g} N*m*s/rad"},
        }
        parts |= {"coupling_stiffness": jerks["stiffness"], "support_damping": jerks["damping"] + brakes}
    if result["inertia"]:
        more["screw"] = {"inertia": f"{result['inertia']['value']:.4g} kg*m^2"}
    law = {key: float(f"{value:.6g}") for key, value in parts.items()}
    options = " ".join(f"--set {key}={value:g}" for key, value in law.items())
    sheet = yaml.safe_dump({"friction": result["sheet"]} | ({"bearing": drag} if drag else {}) | more, sort_keys=False)
    scene = yaml.safe_dump({"drive": law}, sort_keys=False)
    end = f"; {_ENDS[next(iter(result['ends']))].lower()}, the upper bound" if result["not_separable"] else ""
    low, high = result["sliding_speeds"]
    return (
        f"# Measured at sliding speeds from {low:.3g} to {high:.3g} m/s{end}.\n"
        f"# For a data sheet of lsvib assess, coefficients of the flanks:\n{sheet}"
        f"# For a scene, of the square thread (those of the flanks over the cosine of their angle):\n{scene}"
        f"# For the shell:\n# {options}\n"
    )


def text_of(result: dict[str, Any]) -> str:
    """Return what was found as a person reads it, torques in mN m."""
    lines = [f"{'file':>16} {'rad/s':>9} {'scatter':>8} {'mN m':>9} {'scatter':>8} {'samples':>8}"]
    for point in result["measured"] if result["points"] <= 100 else ():  # a table of rows is not repeated
        scatter = [point["speed_scatter"], point["torque_scatter"]]
        spread = [
            "" if value is None else f"{value * factor:.3g}" for value, factor in zip(scatter, (1, 1e3), strict=True)
        ]
        lines.append(
            f"{point['name'][-16:]:>16} {point['speed']:9.4g} {spread[0]:>8} {point['torque'] * 1e3:9.4f} "
            f"{spread[1]:>8} {point['samples']:8d}"
        )
    lines += [
        f"{record['file'][-16:]:>16} jerks every {record['period']:.4g} s {_behind(record)}, "
        f"from {record['breakaway'] * 1e3:.3g} to {record['after'] * 1e3:.3g} mN m"
        for record in result["records"]
        if "period" in record
    ]
    lines += [f"{record['file'][-16:]:>16} {_told(record)}" for record in result["records"] if _told(record)]
    if result["halves"]:
        lines += ["", f"{'both directions':>16} {'rad/s':>9} {'half-sum':>18} {'half-difference, mN m':>26}"]
    lines += [
        f"{'':>16} {row['speed']:9.4g} {row['half_sum'] * 1e3:18.4f} {row['half_difference'] * 1e3:26.4f}"
        for row in result["halves"]
    ]
    lines += ["", *result["said"], ""]
    for name, end in result["ends"].items():
        values = {**end["friction"], **end["bearing"], "offset": end["offset"]}
        lines.append(
            f"{_ENDS[name]}: rms {end['rms'] * 1e3:.3g} mN m, largest residual {end['largest_residual'] * 1e3:.3g} mN m"
        )
        for key, value in values.items():
            error = end["standard_errors"].get(key)
            unit = PARAMETERS.get(key, ("1",))[0]
            of_error = f" ± {error:.2g}" if error is not None else ""
            lines.append(f"  {key:28} {value:.4g}{of_error}{'' if unit == '1' else f' {unit}'}")
        lines += ["  correlation:"]
        lines += [
            f"  {key:28} {' '.join(f'{value:6.2f}' for value in row)}"
            for key, row in zip(end["correlation"]["of"], end["correlation"]["matrix"], strict=True)
        ]
    return "\n".join([*lines, "", blocks(result).rstrip()])


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
    residual.set_title("(b) measured less fitted, bars: error of means")
    return figure
