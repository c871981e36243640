"""Thresholds solved for any parameter: 12 digits against 40-digit values, derivatives against 40-digit differences."""

from functools import partial

import numpy as np
import pytest
from mpmath import mp, mpf
from references import threshold_digits
from references.draws import LIKE_PARTS, LIKE_TABLE_8_1, about, drawn, one_of, times
from references.parts import DRIVES as KINDS

from lsvib.errors import InputError
from lsvib.models.drive import Drive
from lsvib.stability.slip import SlipDrive, half_return, leaving
from lsvib.stability.threshold import _start, solve_threshold

DRIVES = 8  # of each threshold
SLOPES = 2  # of these whose derivatives are compared
VALUE, SLOPE = mpf("1e-12"), mpf("1e-9")
_STEP = mpf(10) ** -14  # of a central difference, relative: its square is far below SLOPE, 40 digits far below it


@pytest.fixture(autouse=True)
def _forty_digits():
    with mp.workdps(threshold_digits.WORK):
        yield


def random_drive(rng: np.random.Generator, name: str) -> Drive:
    """A rigid drive like the chapter's, every parameter up to a factor of two away, where a threshold may be."""
    negative = name in ("onset", "stick", "detach")
    values = drawn(
        rng, LIKE_TABLE_8_1, coupling_stiffness=about(1.0), input_speed=times(about(40.0), one_of(-1, 1)),
        support_damping=about(2e-4 if negative else 3e-4 if name == "rest_loss" else 1.5e-3),
        mass=about(1.0 if negative else 15.0), axial_force=about(30.0),
        translation_damping=about(1e3) if negative else times(about(10.0), one_of(0, 1)),
    )  # fmt: skip
    values["axial_force"] *= np.sign(values["input_speed"]) * (1 if negative or name == "rest_loss" else -1)
    return Drive.of(values)


def accepted(name: str, unknown: str, count: int, draw=random_drive):
    """Drives that have a threshold, with its solutions for one parameter, and how many slopes to ask for."""
    rng, found = np.random.default_rng([count, len(unknown)]), 0
    while found < count:
        drive = draw(rng, name)
        try:
            solution = solve_threshold(drive, name, unknown)
        except InputError:
            continue
        found += 1
        assert solution.solutions
        yield rng, drive, solution, 2 if found <= SLOPES else 0


def hint(name: str, drive: Drive):
    """Where the references look for the root of a motion: nearly, and nothing that counts in the result."""
    if name in ("onset", "kinematic_constraint", "negative_damping"):
        return ()
    time = _start(name, drive)[1].times[0]
    if name != "stick":
        return (float(time),)
    forward = SlipDrive.of(drive)
    slip, height = forward.slip(1), forward.inertia[1]
    return (float(leaving(slip, forward.contact, height, half_return(slip, height, time)[0])[1]),)


def judged(name, drive, solved, solution, rng, slopes):
    """Value and some derivatives of a solution against the reference."""
    unknown = solved.unknown
    near = hint(name, drive.replace(**{unknown: solution.value}))

    def truth(values, guess):
        return threshold_digits.root(lambda x: threshold_digits.gap(which, {**values, unknown: x}, near), guess)

    which = name
    if name == "onset":  # by the equation that it is
        which = {"R̃": "onset", "Γ₊": "kinematic_constraint", "C₊": "negative_damping"}[solution.equation.split(" ")[0]]
    if name == "global_stability" and "dh/dτ" in solution.equation:
        which = "fold"
    compared(drive, solved, solution, truth, rng, slopes)


def compared(drive, solved, solution, truth, rng, slopes):
    """Value, enclosure and some derivatives of a solution against a function of (parameters, guess)."""
    values = dict(drive)
    exact = truth(values, solution.value)
    assert abs(solution.value - exact) <= VALUE * abs(exact)
    assert solution.enclosure[0] <= exact <= solution.enclosure[1]
    others = [key for key, value in values.items() if key != solved.unknown and value]
    for key in rng.choice(others, slopes, replace=False):
        step = abs(mpf(values[key])) * _STEP
        ends = [truth({**values, key: values[key] + sign * step}, exact) for sign in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * step)
        found = solution.derivatives[key].value
        assert solution.derivatives[key].low <= found <= solution.derivatives[key].high
        assert abs(found - slope) <= SLOPE * abs(slope) + mpf("1e-14") * abs(exact / values[key]), key


@pytest.mark.parametrize(
    ("name", "unknown"),
    [
        ("onset", "axial_force"),
        ("onset", "friction_coefficient"),
        ("kinematic_constraint", "lead_angle"),
        ("negative_damping", "pitch_radius"),
        ("stick", "axial_force"),
        ("detach", "axial_force"),
        ("global_stability", "axial_force"),
        ("fold", "axial_force"),
        ("cycle_birth", "axial_force"),
        pytest.param("rest_loss", "support_damping", marks=pytest.mark.slow),  # which few drives have
    ],
)
def test_twelve_digits_and_derivatives(name, unknown):
    for rng, drive, found, slopes in accepted(name, unknown, DRIVES):
        for solution in found.solutions:
            judged(name, drive, found, solution, rng, slopes)


def two_bodies(model: str):
    """Draws drives of a model with two bodies, about as stiff as those of the chapter."""

    def draw(rng, name):
        values = drawn(
            rng, LIKE_TABLE_8_1, input_speed=about(40.0), support_damping=about(2e-4), mass=about(5.0),
            axial_force=about(30.0), translation_damping=times(about(5.0), one_of(0, 1)),
        )  # fmt: skip
        return KINDS[model].of(values | drawn(rng, LIKE_PARTS[model]))

    return draw


@pytest.mark.parametrize(
    ("model", "name", "unknown"),
    [
        ("threads", "flutter", "mass"),
        ("support", "flutter", "support_stiffness"),
        ("support", "kinematic_constraint", "friction_coefficient"),
        ("nut", "flutter", "translation_damping"),
    ],
)
def test_twelve_digits_of_drives_with_two_bodies(model, name, unknown):
    """A growth rate passes zero, or the contact force has no bound, by the state matrix of Newton's laws."""
    for rng, drive, found, slopes in accepted(name, unknown, DRIVES, two_bodies(model)):
        for solution in found.solutions:

            def truth(values, guess, words=solution.equation):
                at = partial(threshold_digits.growth, model) if "Hurwitz" in words else None
                if words.startswith("R"):
                    at = threshold_digits.net_force
                at = at or partial(threshold_digits.jam, model)
                return threshold_digits.root(lambda x: at({**values, unknown: x}), guess)

            compared(drive, found, solution, truth, rng, slopes)
