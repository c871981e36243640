"""The dataset of a fit: points as measured, the fitted law with its errors, and what both ends leave over."""

import json
import math
from collections.abc import Sequence

import numpy as np

from lsvib.answers.attributes import Variable, Variables, named_index, variable
from lsvib.sheets.torque.law import Fit
from lsvib.sheets.torque.measured import BREAKAWAY, PARAMETERS, halves, steady_torque
from lsvib.sheets.torque.starts import Array
from lsvib.sheets.torque.tables import Point

CURVE = 200  # speeds at which the fitted law is stated, evenly spaced in logarithm


def fit_variables(fit: Fit, points: Sequence[Point]) -> tuple[Variables, Variables, dict[str, str]]:
    """Return variables, coordinates and attributes of a fit and its points, in the order of its measured speeds."""
    measured, ends = fit.measured, list(fit.ends.values())
    loads, speeds = np.unique(measured.load), measured.speeds
    senses = np.unique(np.sign(measured.speed)).astype(int)
    curve = np.geomspace(speeds[0], speeds[-1], CURVE)
    grid = np.meshgrid(loads, senses, curve, indexing="ij")
    law = np.array([steady_torque(end.values, measured, grid[1] * grid[2], grid[0]) for end in ends])
    half = halves(measured)
    variables: Variables = {
        "measured_speed": variable("point", measured.speed, "rad s-1", "mean speed of the screw", r"$\omega$"),
        "measured_torque": variable("point", measured.torque, "N m", "mean torque of the motor", "$T$"),
        "speed_scatter": _of_points(points, "speed_scatter", "rad s-1", "standard deviation of the speed's samples"),
        "torque_scatter": _of_points(points, "torque_scatter", "N m", "standard deviation of the torque's samples"),
        "measured_load": variable("point", measured.load, "N", "axial load against outward travel", "$W$"),
        "samples": variable("point", np.array([one.samples for one in points]), "1", "number of samples of a point"),
        "residual": variable(
            ("end", "point"), [end.residual for end in ends], "N m", "measured torque minus fitted torque"
        ),
        "law_torque": variable(("end", "load_case", "direction", "law_speed"), law, "N m", "fitted torque"),
        "half_sum": variable("pair", half[:, 1], "N m", "half-sum of the torques of both directions"),
        "half_difference": variable("pair", half[:, 2], "N m", "half-difference of the torques of both directions"),
        "residual_rms": variable("end", [end.rms for end in ends], "N m", "root mean square of the residuals"),
        "correlation": variable(
            ("end", "number", "other_number"), [_correlation(fit, name) for name in fit.ends], "1",
            "correlation of the fitted numbers",
        ),
        "singular_value": variable(
            "rank", fit.singular_values, "1", "singular value of the scaled Jacobian by all unknown numbers"
        ),
    }  # fmt: skip
    static = (("1", "static friction coefficient of the threads"), ("N m", "static friction of the bearing"))
    for name, (unit, words) in (PARAMETERS | dict(zip(BREAKAWAY, static, strict=True))).items():
        known = [{key: (x, end.errors.get(key, 0.0)) for key, x in end.values.items()} | end.static for end in ends]
        values, errors = np.array([one.get(name, (math.nan, math.nan)) for one in known]).T
        variables[f"fitted_{name}"] = variable("end", values, unit, f"fitted {words}")
        variables[f"fitted_{name}_error"] = variable("end", errors, unit, f"standard error of the {words}")
    coordinates: Variables = {
        "end": named_index("end", "end of the range that the data leave open", list(fit.ends)),
        "load_case": variable("load_case", loads, "N", "axial load of the fitted law", "$W$"),
        "direction": variable("direction", senses, "1", "direction of turning, 1 is outward"),
        "law_speed": variable("law_speed", curve, "rad s-1", "speed of the screw", r"$|\omega|$"),
        "half_speed": variable("pair", half[:, 0], "rad s-1", "speed at which both directions were measured"),
        "number": named_index("number", "fitted number", list(PARAMETERS)),
        "other_number": named_index("other_number", "other fitted number", list(PARAMETERS)),
    }
    attributes = {
        "not_separable": json.dumps(fit.not_separable),
        "stribeck_exponents": json.dumps([end.values["stribeck_exponent"] for end in ends]),
        "point_names": json.dumps([point.name for point in points]),
    }
    return variables, coordinates, attributes


def _of_points(points: Sequence[Point], name: str, unit: str, words: str) -> Variable:
    return variable("point", np.array([getattr(point, name) for point in points]), unit, words)


def _correlation(fit: Fit, end: str) -> Array:
    """Correlation by all of :data:`PARAMETERS`, NaN where a number was not fitted."""
    solution, found = fit.ends[end], np.full((len(PARAMETERS), len(PARAMETERS)), np.nan)
    places = [list(PARAMETERS).index(name) for name in solution.free]
    found[np.ix_(places, places)] = solution.correlation
    return found
