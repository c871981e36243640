"""What a script may get wrong ends in one sentence, before anything is computed."""

import numpy as np
import pytest

import lsvib
from lsvib.errors import InputError

DRIVE = lsvib.Drive(mass=11, support_damping=2e-3, axial_force=-18.37)
U, W = lsvib.Axis("u", -0.1, 0.1, 4), lsvib.Axis("w", -5, 5, 4)
MASKED = np.ma.masked_array([1.0, 2.0], [False, True])


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: DRIVE.follow(DRIVE.cycles(), "axial_force", (-18.5, -18.35)), "what is followed is one cycle"),
        (lambda: DRIVE.follow(None, "axial_force", (-18.5, -18.35)), "what is followed is one cycle"),
        (lambda: DRIVE.sweep(mass=np.array(1.0)), r"mass = array\(1.\) is not a list of numbers"),
        (lambda: DRIVE.sweep(mass=np.ones((2, 2))), "is not a list of numbers"),
        (lambda: DRIVE.sweep(mass=MASKED), "mass holds a value that is not a number"),
        (lambda: lsvib.Drive(mass=np.ma.masked), "mass = masked is not a number"),
        (lambda: DRIVE.simulate({"u": MASKED[1], "w": 0}, 0.1), "start.u = masked is not a number"),
        (lambda: setattr(DRIVE, "mass", 5), r"drive.replace\(mass=...\) makes another one"),
        (lambda: delattr(DRIVE, "mass"), "a drive does not change"),
        (lambda: lsvib.Axis("u", 0, float("nan"), 3), "stop = nan is not a number"),
        (lambda: lsvib.Axis("u", 0, float("inf"), 3), "stop = inf is outside"),
        (lambda: lsvib.Axis("u", 1, 0, 3), "it needs start < stop"),
        *(
            (lambda count=count: lsvib.Axis("u", 0, 1, count), "allowed range is 1 <= count")
            for count in (0, -3, True, "x", 2.5)
        ),
        (lambda: lsvib.Grid(U, 3), "a grid needs two axes"),
        (lambda: lsvib.Grid(U, U), "a coordinate twice"),
        (lambda: lsvib.Grid(U, lsvib.Axis("mass", 0, 1, 3)), "coordinate 'mass'"),
        (lambda: lsvib.Grid(U, W, {"e": float("nan")}), "grid: e = nan is not a number"),
        (lambda: DRIVE.basin().area(lsvib.Window(0.1, -0.1, -5, 5)), "window u = 0.1 to -0.1"),
        (lambda: DRIVE.basin().fraction({"u": (0, 1)}), "does not give the ends of u and of w"),
        (lambda: DRIVE.basin().line((0.1, 0.2, -5, 5)), "does not give the ends of u and of w"),
    ],
)
def test_is_refused_in_one_sentence(call, sentence):
    with pytest.raises(InputError, match=sentence) as refused:
        call()
    assert "\n" not in str(refused.value)


def test_a_mask_that_hides_nothing_is_no_fault():
    found = DRIVE.sweep(mass=np.ma.masked_array([10.0, 11.0], [False, False]))
    assert found.mass.values.tolist() == [10.0, 11.0]
