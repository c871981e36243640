"""Sheets and tables of screws that were never measured, from a torque written down apart from lsvib."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import yaml

LAW = {  # coefficients of the flanks
    "friction_coefficient": 0.15,
    "stribeck_rise": 0.05,
    "stribeck_speed": 0.02,
    "friction_slope": 0.08,
    "coulomb": 0.02,
    "viscous": 4e-4,
    "offset": 0.004,
}
LEAD, DIAMETER, HALF_ANGLE = 4e-3, 18e-3, math.radians(15)
SPEEDS = np.geomspace(0.5, 40.0, 14)  # rad/s
SHEET = {
    "thread": {"lead": "4 mm", "pitch_diameter": "18 mm", "half_angle": "15 deg"},
    "measurements": [],
    "friction": {"stribeck_exponent": 1},
}


def square() -> float:
    """What a coefficient of the flanks is multiplied by to be that of the square thread."""
    lead_angle = math.atan(LEAD / (math.pi * DIAMETER))
    return 1 / math.cos(math.atan(math.cos(lead_angle) * math.tan(HALF_ANGLE)))


def torque(speed: np.ndarray, load: float, law: Mapping[str, float] = LAW) -> np.ndarray:
    """T [N m] at speeds [rad/s] under a load against outward travel [N]: the wedge with the angle of friction."""
    lead_angle = math.atan(LEAD / (math.pi * DIAMETER))
    sliding = 0.5 * DIAMETER * np.abs(speed) / math.cos(lead_angle)
    mu = law["friction_coefficient"] + law["friction_slope"] * sliding
    mu = square() * (mu + law["stribeck_rise"] * np.exp(-sliding / law["stribeck_speed"]))
    wedge = 0.5 * DIAMETER * abs(load) * np.tan(np.arctan(mu) + np.sign(load * speed) * lead_angle)
    return law["offset"] + np.sign(speed) * (law["coulomb"] + wedge) + law["viscous"] * speed


def write_tables(
    folder: Path,
    loads: Sequence[float] = (300.0, 900.0),
    speeds: Sequence[float] = (*-SPEEDS, *SPEEDS),
    noise: float = 0.02,
    samples: int = 40,
    random: np.random.Generator | None = None,
    **more: object,
) -> Path:
    """Write one file for each load and speed, with noise of each sample [N m], and the sheet; its path.

    The sheet has an item of ``measurements`` for each load, and ``more`` entries, with None for those that it has not.
    """
    random = random or np.random.default_rng(1)
    sheet = {**SHEET, **more, "measurements": []}
    for load in loads:
        name = f"load{load:g}"
        (folder / name).mkdir(parents=True)
        for k, speed in enumerate(speeds):
            turning = np.full(samples, speed) + 0.01 * abs(speed) * random.standard_normal(samples)
            measured = torque(turning, load) + noise * random.standard_normal(samples)
            rows = "\n".join(f"{w * 30 / math.pi:.9g},{t * 1e3:.9g}" for w, t in zip(turning, measured, strict=True))
            (folder / name / f"{k:02}.csv").write_text(f"rpm,mN m\n{rows}\n")
        sheet["measurements"].append(
            {
                "files": f"{name}/*.csv",
                "speed": {"column": 1, "unit": "rpm"},
                "torque": {"column": 2, "unit": "mN*m"},
                "load": {"force": f"{load} N"},
            }
        )
    path = folder / "sheet.yaml"
    path.write_text(yaml.safe_dump({key: value for key, value in sheet.items() if value is not None}))
    return path
