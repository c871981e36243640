"""Rates of the motion near steady sliding, from the references' statements of Newton's laws, with 120 digits."""

import math
from functools import lru_cache

from mpmath import mp

from judge.wide_drives import WideDrive
from lsvib.bench.reference import rigid_digits, threads_digits
from lsvib.bench.reference.two_bodies_digits import ClosedFormDrive
from lsvib.drives.parameters import RigidParameters

_DIGITS = 120  # so that a double rate has 60
REAL = mp.mpf(10) ** -50  # of a rate; a real part below this is rounding, as even a double rate has 60 digits


def rates(wide: WideDrive) -> list:
    """Rates [1/s] of the motion near steady sliding, two or four."""
    return _rates(wide.model, wide.drive, wide.physics)


@lru_cache(maxsize=2)  # several questions about one drive begin with them
def _rates(model: str, drive: RigidParameters, physics: tuple[str, ...]) -> list:
    parameters = dict(drive)
    with mp.workdps(_DIGITS):
        turning = 1 if drive.input_speed > 0 else -1
        if model == "rigid":
            d = rigid_digits.RigidTrueDrive(parameters, _DIGITS)
            law = d.s0 or 1
            a, b = d.C(law) / (2 * d.Gamma(law)), d.k / d.Gamma(law)
            root = mp.sqrt(a * a - b)
            first = -a - root if mp.re(-a) < 0 else -a + root
            return [first, b / first]
        if model == "threads":
            d = threads_digits.ThreadsTrueDrive(parameters)
            law = 1 if (d.R - d.r * d.tan * d.cx * d.Omega) * turning >= 0 else -1
            matrix, _ = d.matrix(lambda x: d.slip(law, x))
        else:
            d = ClosedFormDrive(model, parameters, physics)
            axial = d.p["axial_force"] - d.p["translation_damping"] * d.reach * d.Omega - d.F0 * turning
            sign = 1 if axial >= 0 else -1
            rows = d.row_of_field((turning, sign, turning if d.second else None))
            matrix = mp.matrix([row[:4] for row in rows])
        return list(mp.eig(matrix, left=False, right=False))


def stable(found: list) -> bool:
    """Whether all rates have a negative real part."""
    with mp.workdps(_DIGITS):
        return all(mp.re(x) <= -REAL * abs(x) for x in found)


def grows_not(found: list) -> bool:
    """Whether no rate has a positive real part."""
    with mp.workdps(_DIGITS):
        return all(mp.re(x) < REAL * abs(x) for x in found)


def carries_no_force(wide: WideDrive) -> bool:
    """Whether axial force, drag and friction balance exactly, so that no law holds in steady sliding."""
    d = wide.drive
    if d.translation_damping:  # tan λ is transcendental
        return False
    friction = d.slide_friction if "slide_friction" in wide.physics else 0.0
    return d.axial_force == math.copysign(friction, d.input_speed)
